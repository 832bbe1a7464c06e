"""Road networks as nouns: roads, lanes, junctions and signals of a file of any writer, or of a conversion.

They are views of the tables of the file: making them costs nothing, and numbers come from where `locate`, `export`
and `check` have them.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, Generic, Literal, NamedTuple, TypeVar, Union, overload

import numpy as np

from osm2xodr.diagnostics import counted
from osm2xodr.errors import OptionError
from osm2xodr.opendrive import (
    ABSENT,
    End,
    LinkKind,
    elevation,
    first_index,
    frame_of,
    grade,
    lane_borders,
    lane_middles,
    section_at,
    speed_limits,
    surface_points,
)

if TYPE_CHECKING:
    from osm2xodr.model import FloatArray
    from osm2xodr.opendrive import Frame, Furniture, OpenDrive

_Element = TypeVar("_Element")
_Default = TypeVar("_Default")
_Number = Union[float, "FloatArray"]

_CONTACTS: Final[Mapping[int, Literal["start", "end"] | None]] = {
    End.UNSAID: None,
    End.START: "start",
    End.END: "end",
}


class Elements(Generic[_Element]):
    """Elements of a road network in the order of the file, found by position or, as in a mapping, by id.

    ``roads[0]`` is the first one, ``roads["12"]`` that with the id 12, ``"12" in roads`` says whether there is one,
    and ``dict(roads)`` has all by id. Of elements with the same id, which damaged files have, the first is found.
    """

    def __init__(self, kind: str, ids: Sequence[str], make: Callable[[int], _Element]) -> None:
        self._kind, self._ids, self._make = kind, ids, make

    @cached_property
    def _index(self) -> dict[str, int]:
        return first_index(list(self._ids))

    def __len__(self) -> int:
        return len(self._ids)

    def __iter__(self) -> Iterator[_Element]:
        return map(self._make, range(len(self._ids)))

    @overload
    def __getitem__(self, key: int | str) -> _Element: ...
    @overload
    def __getitem__(self, key: slice) -> list[_Element]: ...
    def __getitem__(self, key: int | str | slice) -> _Element | list[_Element]:
        if isinstance(key, str):
            if key not in self._index:
                raise KeyError(f"there is no {self._kind} {key!r}")
            return self._make(self._index[key])
        if isinstance(key, slice):
            return [self._make(k) for k in range(len(self._ids))[key]]
        return self._make(range(len(self._ids))[operator.index(key)])

    def __contains__(self, item: object) -> bool:
        return item in self._index if isinstance(item, str) else any(item == element for element in self)

    def keys(self) -> tuple[str, ...]:
        """Return the ids, each once."""
        return tuple(self._index)

    def items(self) -> Iterator[tuple[str, _Element]]:
        """Yield ids and elements."""
        return ((key, self._make(k)) for key, k in self._index.items())

    def get(self, key: str, default: _Default | None = None) -> _Element | _Default | None:
        """Return the element with an id, or else the default."""
        return self._make(self._index[key]) if key in self._index else default

    def __repr__(self) -> str:
        return f"<{counted(len(self), self._kind)}>"


# Not its base: type checkers would then refuse to look for ids in it.
Sequence.register(Elements)


class Link(NamedTuple):
    """What one end of a road leads to."""

    end: Literal["start", "end"]  # Of the road
    to: Road | Junction
    contact: Literal["start", "end"] | None  # Which end of a road there touches; None where the file does not say


class Connection(NamedTuple):
    """A way through a junction."""

    id: str
    # None where the file has no such road
    incoming: Road | None
    connecting: Road | None
    contact: Literal["start", "end"] | None  # Which end of the connecting road touches the incoming one
    lanes: tuple[tuple[int, int], ...]  # Ids of linked lanes of both


@dataclass(frozen=True, repr=False)
class Road:
    """A road."""

    view: View
    row: int  # In the tables

    @property
    def id(self) -> str:
        """Its id."""
        return self.view.tables.roads.id[self.row]

    @property
    def name(self) -> str:
        """The name of its street; empty without one."""
        return self.view.tables.roads.name[self.row]

    @property
    def length(self) -> float:
        """Its length along the reference line, m; NaN where the file does not say it."""
        return float(self.view.tables.roads.length[self.row])

    @property
    def osm_ways(self) -> tuple[int, ...]:
        """The ids of the ways of OpenStreetMap that it is made of; none where the file does not say them."""
        return self.view.tables.osm_ways(self.row)

    @property
    def left_hand(self) -> bool:
        """Whether traffic drives on the left."""
        return bool(self.view.tables.roads.left_hand[self.row])

    @property
    def type(self) -> str:
        """The type of its first stretch, such as ``townLocal``; empty without one."""
        types = self.view.tables.types
        first, last = types.start[self.row : self.row + 2].tolist()
        return types.type[first] if last > first else ""

    @property
    def junction(self) -> Junction | None:
        """The junction that it leads through; None for a road between junctions."""
        row = int(self.view.tables.roads.junction[self.row])
        return self.view.junctions[row] if row >= 0 else None

    @property
    def links(self) -> tuple[Link, ...]:
        """What its start and its end lead to, as far as there is something."""
        found = (self._link(end) for end in (End.START, End.END))
        return tuple(link for link in found if link is not None)

    @property
    def predecessor(self) -> Road | Junction | None:
        """What its start leads to."""
        link = self._link(End.START)
        return None if link is None else link.to

    @property
    def successor(self) -> Road | Junction | None:
        """What its end leads to."""
        link = self._link(End.END)
        return None if link is None else link.to

    def _link(self, end: End) -> Link | None:
        roads = self.view.tables.roads
        kind, row = int(roads.link_kind[self.row, end]), int(roads.link[self.row, end])
        if row == ABSENT or kind not in (LinkKind.ROAD, LinkKind.JUNCTION):
            return None
        to = self.view.roads[row] if kind == LinkKind.ROAD else self.view.junctions[row]
        own: Literal["start", "end"] = "end" if end is End.END else "start"
        return Link(own, to, _CONTACTS[int(roads.contact[self.row, end])])

    @property
    def signals(self) -> list[Signal]:
        """Its signals, in the order of the file."""
        return [signal for signal in self.view.signals if signal.furniture.road == self.row]

    def lanes(self, s: float | None = None) -> tuple[Lane, ...]:
        """Return its lanes at s, m, from left to right, without the centre lane; by default those of all sections."""
        tables = self.view.tables
        if s is None:
            sections = range(*tables.sections.start[self.row : self.row + 2].tolist())
        else:
            section = int(section_at(tables, *self._places(s)[:2])[0])
            sections = range(0) if section == ABSENT else range(section, section + 1)
        start, ids = tables.lanes.start, tables.lanes.id
        rows = (row for section in sections for row in range(int(start[section]), int(start[section + 1])))
        return tuple(Lane(self.view, row) for row in rows if ids[row] not in (0, ABSENT))

    @overload
    def height(self, s: float) -> float: ...
    @overload
    def height(self, s: FloatArray) -> FloatArray: ...
    def height(self, s: _Number) -> _Number:
        """Return the height of the reference line at s, m, in the datum of the file; s may be an array."""
        road, at, _ = self._places(s)
        z = elevation(self.view.tables, road, at)
        found: _Number = _like(z if self.view.frame is None else self.view.frame.height(z), s)
        return found

    @overload
    def grade(self, s: float) -> float: ...
    @overload
    def grade(self, s: FloatArray) -> FloatArray: ...
    def grade(self, s: _Number) -> _Number:
        """Return the rise per metre of the reference line at s; s may be an array."""
        road, at, _ = self._places(s)
        found: _Number = _like(grade(self.view.tables, road, at), s)
        return found

    @overload
    def point(self, s: float, t: float = 0.0) -> tuple[float, float, float]: ...
    @overload
    def point(self, s: FloatArray, t: _Number = 0.0) -> tuple[FloatArray, FloatArray, FloatArray]: ...
    def point(self, s: _Number, t: _Number = 0.0) -> tuple[_Number, _Number, _Number]:
        """Return x, y, z of the surface at s and t, m, in the coordinates of the file; s and t may be arrays."""
        found = surface_points(self.view.tables, *self._places(s, t))
        shape = np.broadcast(s, t)
        x, y, z = (_like(values, shape) for values in found)
        return x, y, z

    @overload
    def lonlat(self, s: float, t: float = 0.0) -> tuple[float, float]: ...
    @overload
    def lonlat(self, s: FloatArray, t: _Number = 0.0) -> tuple[FloatArray, FloatArray]: ...
    def lonlat(self, s: _Number, t: _Number = 0.0) -> tuple[_Number, _Number]:
        """Return longitude and latitude, degrees, WGS 84, at s and t, m; NaN if the file does not say where it is."""
        frame = self.view.frame
        x, y, _ = surface_points(self.view.tables, *self._places(s, t))
        shape = np.broadcast(s, t)
        lon, lat = (np.full_like(x, np.nan),) * 2 if frame is None else frame.to_geographic(x, y)
        return _like(lon, shape), _like(lat, shape)

    def _places(self, s: _Number, t: _Number = 0.0) -> tuple[Any, FloatArray, FloatArray]:
        """Return rows of the road, s and t, (n,) each; refuse what is not on the road."""
        at, across = (np.ravel(values).astype(np.float64) for values in np.broadcast_arrays(s, t))
        # Written so that NaN fails.
        wrong = at[~((at >= 0.0) & (at <= self.length))]
        if len(wrong):
            raise OptionError(f"s: {wrong[0]:g} is not on road {self.id}, which is {self.length:g} m long", "s")
        return np.full(len(at), self.row), at, across

    def __repr__(self) -> str:
        name = f" {self.name!r}" if self.name else ""
        return f"<Road {self.id!r}{name}, {self.length:.1f} m>"


@dataclass(frozen=True, repr=False)
class Lane:
    """A lane of a lane section."""

    view: View
    row: int  # In the tables

    @property
    def id(self) -> int:
        """Its id: positive left of the centre, along s."""
        return int(self.view.tables.lanes.id[self.row])

    @property
    def type(self) -> str:
        """Its type, such as ``driving``."""
        return self.view.tables.lanes.type[self.row]

    @property
    def road(self) -> Road:
        """Its road."""
        tables = self.view.tables
        return self.view.roads[int(tables.sections.road[self._section])]

    @property
    def start(self) -> float:
        """The s of its road where its section begins, m."""
        return float(self.view.tables.sections.s[self._section])

    @property
    def end(self) -> float:
        """The s of its road where its section ends, m."""
        return float(self.view.tables.sections.end[self._section])

    @property
    def speed(self) -> float:
        """Its speed limit, or else that of its road, m/s; NaN where unknown, infinite without a limit."""
        return float(self.view.speed_limits[self.row])

    @property
    def direction(self) -> Literal["forward", "backward", "both"]:
        """Where traffic runs: along s, against it, or both ways."""
        return self.view.directions[self.row]

    def width(self, s: float) -> float:
        """Return its width at s of its road, m."""
        inner, outer = lane_borders(self.view.tables, *self._places(s))
        return float(abs(outer[0] - inner[0]))

    def t(self, s: float) -> float:
        """Return t of its middle at s of its road, m."""
        return float(lane_middles(self.view.tables, *self._places(s))[0])

    def point(self, s: float, offset: float = 0.0) -> tuple[float, float, float]:
        """Return x, y, z at s and `offset` to the left of its middle, m, in the coordinates of the file."""
        return self.road.point(s, self.t(s) + offset)

    @property
    def _section(self) -> int:
        return int(self.view.tables.lanes.section[self.row])

    def _places(self, s: float) -> tuple[Any, FloatArray]:
        if not self.start <= s <= self.end:
            what = f"lane {self.id} of road {self.road.id}, which is from {self.start:g} to {self.end:g} m"
            raise OptionError(f"s: {s:g} is not on {what}", "s")
        return np.array([self.row]), np.array([s], np.float64)

    def __repr__(self) -> str:
        return f"<Lane {self.id} of road {self.road.id!r} from {self.start:.1f} to {self.end:.1f} m: {self.type}>"


@dataclass(frozen=True, repr=False)
class Junction:
    """A junction."""

    view: View
    row: int  # In the tables

    @property
    def id(self) -> str:
        """Its id."""
        return self.view.tables.junctions.id[self.row]

    @property
    def name(self) -> str:
        """Its name; empty without one."""
        return self.view.tables.junctions.name[self.row]

    @property
    def type(self) -> str:
        """Its type as written: ``default``, ``direct``, ``virtual`` …; empty without one."""
        return self.view.tables.junctions.type[self.row]

    @property
    def roads(self) -> list[Road]:
        """The roads through it."""
        return [self.view.roads[k] for k in np.flatnonzero(self.view.tables.roads.junction == self.row).tolist()]

    @property
    def connections(self) -> list[Connection]:
        """The ways through it."""
        tables = self.view.tables
        return [self._connection(k) for k in range(*tables.junctions.start[self.row : self.row + 2].tolist())]

    def _connection(self, k: int) -> Connection:
        table = self.view.tables.connections
        incoming, connecting = (
            None if row == ABSENT else self.view.roads[row]
            for row in (int(table.incoming[k]), int(table.connecting[k]))
        )
        links = slice(int(table.link_start[k]), int(table.link_start[k + 1]))
        lanes = tuple(zip(table.link_from[links].tolist(), table.link_to[links].tolist(), strict=True))
        return Connection(table.id[k], incoming, connecting, _CONTACTS[int(table.contact[k])], lanes)

    def __repr__(self) -> str:
        return f"<Junction {self.id!r}, {counted(len(self.connections), 'connection')}>"


@dataclass(frozen=True, repr=False)
class Signal:
    """A sign, a light, or a stop or give-way line."""

    view: View
    furniture: Furniture  # What the file says of it

    @property
    def id(self) -> str:
        """Its id."""
        return self.attributes.get("id", "")

    @property
    def name(self) -> str:
        """Its name; empty without one."""
        return self.attributes.get("name", "")

    @property
    def type(self) -> str:
        """Its type, by the list of its country."""
        return self.attributes.get("type", "")

    @property
    def subtype(self) -> str:
        """Its subtype, likewise."""
        return self.attributes.get("subtype", "")

    @property
    def country(self) -> str:
        """The country whose list of types it is from, or ``OpenDRIVE``."""
        return self.attributes.get("country", "")

    @property
    def value(self) -> float | None:
        """The number on it, in its `unit`; None without one."""
        try:
            return float(self.attributes.get("value", ""))
        except ValueError:
            return None

    @property
    def unit(self) -> str:
        """The unit of its value; empty without one."""
        return self.attributes.get("unit", "")

    @property
    def dynamic(self) -> bool:
        """Whether it changes, as lights do."""
        return self.attributes.get("dynamic", "") == "yes"

    @property
    def road(self) -> Road:
        """The road that it stands at."""
        return self.view.roads[self.furniture.road]

    @property
    def s(self) -> float:
        """Where it stands along its road, m."""
        return self.furniture.s

    @property
    def t(self) -> float:
        """Where it stands beside the reference line of its road, m."""
        return self.furniture.t

    @property
    def attributes(self) -> Mapping[str, str]:
        """Its attributes as written."""
        return self.furniture.attributes

    def point(self) -> tuple[float, float, float]:
        """Return x, y, z of it, m, in the coordinates of the file."""
        item = self.furniture
        above = 0.0 if math.isnan(item.z_offset) else item.z_offset
        found = surface_points(self.view.tables, np.array([item.road]), np.array([item.s]), np.array([item.t]), above)
        x, y, z = (float(values[0]) for values in found)
        return x, y, z

    def __repr__(self) -> str:
        return f"<Signal {self.id!r} {self.type} {self.name!r} at road {self.road.id!r}, s={self.s:.1f} m>"


class View:
    """The nouns of a file, and what they share."""

    def __init__(self, tables: OpenDrive) -> None:
        self.tables = tables

    @cached_property
    def roads(self) -> Elements[Road]:
        """The roads, by position or id."""
        return Elements("road", self.tables.roads.id, lambda row: Road(self, row))

    @cached_property
    def junctions(self) -> Elements[Junction]:
        """The junctions, by position or id."""
        return Elements("junction", self.tables.junctions.id, lambda row: Junction(self, row))

    @cached_property
    def signals(self) -> Elements[Signal]:
        """The signs, lights and lines, by position or id."""
        found = [item for item in self.tables.furniture if item.kind == "signal"]
        ids = [item.attributes.get("id", "") for item in found]
        return Elements("signal", ids, lambda row: Signal(self, found[row]))

    @cached_property
    def frame(self) -> Frame | None:
        """Where it is on Earth; None if the file does not say it."""
        return frame_of(self.tables.header)[0]

    @cached_property
    def speed_limits(self) -> FloatArray:
        """The speed limit of each lane by its row, m/s; see `Lane.speed`."""
        return speed_limits(self.tables)

    @cached_property
    def directions(self) -> list[Literal["forward", "backward", "both"]]:
        """The direction of traffic of each lane by its row; see `Lane.direction`."""
        from osm2xodr.checking import lane_index

        index = lane_index(self.tables)
        found = zip(index.both_ways.tolist(), index.forward.tolist(), strict=True)
        return ["both" if both else "forward" if forward else "backward" for both, forward in found]


def _like(values: FloatArray, shape: Any) -> Any:
    """Return values, (n,), as a number or in the shape of what was asked for."""
    return float(values[0]) if np.shape(shape) == () else values.reshape(np.shape(shape))
