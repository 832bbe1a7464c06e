"""Signals, objects and controllers as XML, and signal programmes as SUMO reads them (``--tllogic-files``).

Programmes name edges and lanes that netconvert makes of roads (``NIImporter_OpenDrive.cpp``, measured with 1.28).
Road 7 is edge ``-7`` along its reference line and ``7`` against it, with ``#0``, ``#1`` … for its lane sections where
there are several, and lanes count from the outermost, 0. It cuts sections further where a lane becomes wider or
narrower than 1.8 m, and roads that lead back to their own junction in the middle.
"""

from __future__ import annotations

import cmath
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Final, TypeAlias, TypeVar

import numpy as np

from osm2xodr.conventions import PROGRAMMES_HEAD, Crosswalks
from osm2xodr.curves import cubic_slope, cubic_value, lengths
from osm2xodr.model import (
    Controller,
    Cubic,
    Lane,
    LaneSection,
    ObjectRepeat,
    Road,
    RoadMap,
    RoadObject,
    RoadStructure,
    Signal,
    SignalLink,
    SignalPhase,
    SignalReference,
)
from osm2xodr.xodrWriter.formatting import POSITION_DECIMALS, Words, attribute, number, position, user_data
from osm2xodr.xodrWriter.options import Dialect

# Of places and sizes of furniture, 1 mm, and of its headings, 1e-5 rad: 0.1 mm at the end of a crosswalk of 20 m.
_SIZE_DECIMALS: Final = 3
_TURN_DECIMALS: Final = 5

_Thing = TypeVar("_Thing", Signal, SignalReference, RoadObject, RoadStructure)
_Corners: TypeAlias = tuple[tuple[float, float, float, float], ...]

# What SUMO's documentation of its options says: ``opendrive.min-width``, ``opendrive.curve-resolution``; and the
# program's ``POSITION_EPS``. All m.
_LEAST_WIDTH: Final = 1.8
_SHORTEST_CUT: Final = 2.0
_SAME_PLACE: Final = 0.1
# Its programmes whose green ends, within limits, when no vehicle that is detected has lost time.
_BY_DETECTORS: Final = "delay_based"
# Types of lanes that become lanes of its network.
_IMPORTED: Final = frozenset({"driving", "bidirectional", "restricted", "parking", "stop", "entry", "exit"})


class FurnitureWriter:
    """Make the text of the furniture of any road.

    `crosswalks` is where the reader looks for their corners; `as_met` puts signals in the order in which the traffic
    of their direction meets them; `object_ids` writes the elements of OSM that objects are made of.
    """

    def __init__(
        self,
        road_map: RoadMap,
        dialect: Dialect,
        words: Words,
        crosswalks: Crosswalks,
        *,
        as_met: bool = False,
        object_ids: bool = True,
        one_validity: bool = False,
    ) -> None:
        furniture = road_map.furniture
        self._dialect = dialect
        self._crosswalks = crosswalks
        self._object_ids = object_ids
        self._one_validity = one_validity
        self._offsets = _crosswalk_offsets(road_map)
        self._words = words
        # The last sign of a direction counts for some readers.
        self._signals = _by_road(
            sorted(furniture.signals, key=Signal.place_for_traffic) if as_met else furniture.signals
        )
        self._references = _by_road(furniture.references)
        self._objects = _by_road(furniture.objects)
        # The schema has tunnels before bridges.
        self._structures = _by_road(sorted(furniture.structures, key=lambda item: item.kind != "tunnel"))
        self._busy = self._signals.keys() | self._references.keys() | self._objects.keys() | self._structures.keys()

    def road(self, road: int, length: float) -> str:
        """Return the ``<objects>`` and ``<signals>`` of a road of a length, m; empty where it has none."""
        if road not in self._busy:
            return ""
        objects = "".join([self._object(item, length) for item in self._objects.get(road, ())])
        objects += "".join([_structure(item, length) for item in self._structures.get(road, ())])
        signals = "".join([self._signal(item, length) for item in self._signals.get(road, ())])
        signals += "".join([self._reference(item, length) for item in self._references.get(road, ())])
        groups = (("objects", objects), ("signals", signals))
        return "".join([f"<{tag}>{text}</{tag}>\n" for tag, text in groups if text])

    def _signal(self, item: Signal, length: float) -> str:
        """Return a ``<signal>``."""
        words = self._words
        head = (
            f'<signal{_text("name", item.name)} id="{item.id}" s="{_along(item.s, length)}" t="{_size(item.t)}"'
            f' dynamic="{"yes" if item.dynamic else "no"}" orientation="{words.orientation(item.orientation)}"'
            f' zOffset="{_size(item.z_offset)}"{_text("country", words.country(item.country))}'
            f' type="{attribute(item.type)}" subtype="{attribute(item.subtype)}"'
        )
        if item.value is not None:
            head += f' value="{number(round(item.value, _SIZE_DECIMALS))}"{_text("unit", words.unit(item.unit))}'
        head += (
            f"{_positive('height', item.height)}{_positive('width', item.width)}"
            f"{_text('text', item.text)}{_heading(item.h_offset)}"
        )
        lanes = item.validity
        if self._one_validity and lanes:
            lanes = ((min(map(min, lanes)), max(map(max, lanes))),)
        inner = self._validity(lanes) + user_data("osm_id", item.osm_id)
        inner += user_data("derived", "priority" if item.derived else "")
        return _element("signal", head, inner)

    def _reference(self, item: SignalReference, length: float) -> str:
        """Return a ``<signalReference>``."""
        head = (
            f'<signalReference id="{item.signal}" s="{_along(item.s, length)}" t="{_size(item.t)}"'
            f' orientation="{attribute(item.orientation)}"'
        )
        return _element("signalReference", head, self._validity(item.validity))

    def _validity(self, lanes: tuple[tuple[int, int], ...]) -> str:
        ranges = [self._words.lane_range(*pair) for pair in lanes]
        return "".join([f'<validity fromLane="{first}" toLane="{last}"/>' for first, last in ranges])

    def _object(self, item: RoadObject, length: float) -> str:
        """Return an ``<object>``, its parts in the order of the schema."""
        words = self._words
        kind = words.object_type(item.type)
        name, subtype = item.name, item.subtype
        if not self._dialect.has_subtype:
            # Readers of such versions distinguish kinds by name.
            name, subtype = name or subtype, ""
        size = _positive("radius", item.radius) or _positive("length", item.length) + _positive("width", item.width)
        head = (
            f'<object id="{item.id}" type="{kind}"{_text("subtype", subtype)}{_text("name", name)}'
            f' s="{_along(item.s, length)}" t="{_size(item.t)}" zOffset="{_size(item.z_offset)}"'
            f' orientation="{words.orientation(item.orientation)}" hdg="{_turn(item.hdg)}"'
            f"{size}{_positive('height', item.height)}"
        )
        repeat = "" if item.repeat is None else _repeat(item.repeat, length)
        inner = repeat + self._outlines(item) + self._validity(item.validity)
        osm_id = item.osm_id if self._object_ids else ""
        return _element("object", head, inner + user_data("osm_id", osm_id))

    def _outlines(self, item: RoadObject) -> str:
        """Return the ``<outlines>`` of an object, or the older ``<outline>``, or both.

        CARLA reads the corners of all crosswalks as one list, in which a crosswalk ends where its first corner
        comes again.
        """
        corners = item.outline
        if not corners:
            return ""
        if corners[0] == corners[-1]:
            corners = corners[:-1]
        closed = (*corners, corners[0]) if item.type == "crosswalk" else corners
        style = self._crosswalks if item.type == "crosswalk" else Crosswalks.STANDARD
        if not self._dialect.has_outlines:
            return _outline(self._for_carla(item, closed) if style is Crosswalks.CARLA else closed, "")
        text = ""
        if style is not Crosswalks.STANDARD:
            text = _outline(self._for_carla(item, closed), ' closed="true"')
        if style is not Crosswalks.CARLA:
            outline = _outline(corners, ' id="0" closed="true"')
            text += f"<outlines>{outline}</outlines>"
        return text

    def _for_carla(self, item: RoadObject, corners: _Corners) -> _Corners:
        """Move and turn corners so that they are at the right place in CARLA."""
        offset, slope = self._offsets.get(item.id, (0.0, 0.0))
        if not offset and not slope:
            return corners
        # Along the road and to its left: u + iv
        frame, turned, t = cmath.rect(1.0, item.hdg), cmath.rect(1.0, -slope), 1j * item.t
        moved = [((t - 1j * offset + frame * complex(u, v)) * turned - t) / frame for u, v, _, _ in corners]
        return tuple((to.real, to.imag, *corner[2:]) for to, corner in zip(moved, corners, strict=True))


def _outline(corners: _Corners, attributes: str) -> str:
    texts = [
        f'<cornerLocal u="{_size(u)}" v="{_size(v)}" z="{_size(z)}" height="{_size(height)}"/>'
        for u, v, z, height in corners
    ]
    return f"<outline{attributes}>{''.join(texts)}</outline>"


def _by_road(things: Iterable[_Thing]) -> Mapping[int, list[_Thing]]:
    out: defaultdict[int, list[_Thing]] = defaultdict(list)
    for thing in things:
        out[thing.road].append(thing)
    return out


def controllers_text(controllers: Iterable[Controller]) -> str:
    """Return the ``<controller>`` elements that stand between roads and junctions."""
    text = ""
    for item in controllers:
        switched = [f'<control signalId="{signal}" type="{attribute(item.kind)}"/>' for signal in item.signals]
        head = f'<controller id="{item.id}"{_text("name", item.name)} sequence="{item.sequence}">'
        text += f"{head}{''.join(switched)}</controller>\n"
    return text


def junction_controllers(controllers: Iterable[Controller]) -> Mapping[int, str]:
    """Return the ``<controller>`` elements in each junction, by its id."""
    found: defaultdict[int, str] = defaultdict(str)
    for item in controllers:
        if item.junction is not None:
            text = f'<controller id="{item.id}" type="{attribute(item.kind)}" sequence="{item.sequence}"/>\n'
            for junction in (item.junction, *item.further_junctions):
                found[junction] += text
    return found


def provenance_text(way_ids: tuple[int, ...], guesses: tuple[str, ...]) -> str:
    """Return the ``<userData>`` of a road: the OSM ways that it comes from, and what had to be guessed about them."""
    return _way_ids(way_ids) + user_data("guessed", " ".join(guesses))


def _crosswalk_offsets(road_map: RoadMap) -> dict[int, tuple[float, float]]:
    """Return the lane offset, m, and its slope at each crosswalk with an outline, by the id of its object.

    The standard counts t from the reference line, square to it. CARLA 0.9.16 (measured) counts that of crosswalks,
    and of them alone, from lane 0, which the lane offset puts beside it, and turns t and corners by its slope, rad.
    """
    crosswalks = [item for item in road_map.furniture.objects if item.type == "crosswalk" and item.outline]
    if not crosswalks:
        return {}
    index = {road.id: k for k, road in enumerate(road_map.roads)}
    curve = np.array([index[item.road] for item in crosswalks], dtype=np.int64)
    s = np.array([item.s for item in crosswalks])
    offsets, slopes = (found(road_map.lane_offset, curve, s).tolist() for found in (cubic_value, cubic_slope))
    return {item.id: (a, b) for item, a, b in zip(crosswalks, offsets, slopes, strict=True)}


def _way_ids(way_ids: tuple[int, ...]) -> str:
    return user_data("osm_way_ids", " ".join(map(str, way_ids)))


def _structure(item: RoadStructure, length: float) -> str:
    """Return a ``<bridge>`` or ``<tunnel>``."""
    head = (
        f'<{item.kind} id="{item.id}"{_text("name", item.name)} {_stretch(item.s, item.length, length)}'
        f' type="{attribute(item.type)}"'
    )
    if item.kind == "tunnel":
        head += f' lighting="{_size(item.lighting)}" daylight="{_size(item.daylight)}"'
    return _element(item.kind, head, _way_ids(item.osm_way_ids))


def _repeat(item: ObjectRepeat, length: float) -> str:
    """Return the ``<repeat>`` of an object."""
    return (
        f"<repeat {_stretch(item.s, item.length, length)}"
        f' distance="{_size(item.distance)}" tStart="{_size(item.t_start)}" tEnd="{_size(item.t_end)}"'
        f' heightStart="{_size(item.height)}" heightEnd="{_size(item.height)}"'
        f' zOffsetStart="{_size(item.z_offset)}" zOffsetEnd="{_size(item.z_offset)}"'
        f' widthStart="{_size(item.width)}" widthEnd="{_size(item.width)}"/>'
    )


def _element(tag: str, head: str, inner: str) -> str:
    return f"{head}>{inner}</{tag}>\n" if inner else f"{head}/>\n"


def _along(s: float, length: float) -> str:
    """Write a place along a road, never beyond its end, where esmini would stop."""
    return position(max(min(round(s, _SIZE_DECIMALS), length), 0.0))


def _stretch(s: float, extent: float, length: float) -> str:
    """Write s and length of a stretch of a road of a length, m; it does not go beyond the road's end."""
    begin = max(min(round(s, _SIZE_DECIMALS), length), 0.0)
    extent = max(min(round(extent, _SIZE_DECIMALS), round(length - begin, POSITION_DECIMALS)), 0.0)
    return f's="{position(begin)}" length="{position(extent)}"'


@lru_cache(maxsize=10_000)
def _size(value: float) -> str:
    """Write a length or a place across a road."""
    return number(round(value, _SIZE_DECIMALS))


@lru_cache(maxsize=10_000)
def _positive(name: str, value: float) -> str:
    """Write a size as an attribute, if it is known: 0 is unknown, and not allowed since 1.7."""
    return "" if round(value, _SIZE_DECIMALS) <= 0.0 else f' {name}="{_size(value)}"'


def _heading(value: float) -> str:
    """Write the heading of a signal as an attribute; the default is 0."""
    turn = _turn(value)
    return f' hOffset="{turn}"' if turn != "0" else ""


@lru_cache(maxsize=10_000)
def _turn(value: float) -> str:
    """Write an angle; that of objects also where it is 0, without which CommonRoad's designer ends."""
    return number(round(value, _TURN_DECIMALS))


def _text(name: str, value: str) -> str:
    """Write a text as an attribute, if there is one."""
    return f' {name}="{attribute(value)}"' if value else ""


def programmes_text(road_map: RoadMap, words: Words) -> str:
    """Return the programmes of a road map as a ``tllogic`` file; empty if it has none."""
    programmes = road_map.furniture.programmes
    if not programmes:
        return ""
    edges = _Edges(road_map, words)
    logics, connections = [], []
    for item in programmes:
        named = edges.connections(item.links)
        phases = "".join(_phase(phase, named) for phase in item.phases)
        kind, light, far = "static", item.junction, item.detector_range
        if far:
            kind, phases = _BY_DETECTORS, f'  <param key="detectorRange" value="{number(far)}"/>\n{phases}'
        logics.append(f' <tlLogic id="{light}" type="{kind}" programID="0" offset="0">\n{phases} </tlLogic>\n')
        ends = enumerate(named.values())
        connections += [f' <connection {text} tl="{light}" linkIndex="{k}"/>\n' for k, text in ends]
    return f"{PROGRAMMES_HEAD}<tlLogics>\n{''.join((*logics, *connections))}</tlLogics>\n"


def _phase(phase: SignalPhase, links: Iterable[int]) -> str:
    state = "".join(phase.state[n] for n in links)
    limits = "" if phase.range is None else f' minDur="{number(phase.range[0])}" maxDur="{number(phase.range[1])}"'
    return f'  <phase duration="{number(phase.duration)}"{limits} state="{state}"/>\n'


class _Edges:
    """Names edges and lanes."""

    def __init__(self, road_map: RoadMap, words: Words) -> None:
        self._roads = {road.id: k for k, road in enumerate(road_map.roads)}
        self._map = road_map
        self._lengths = lengths(road_map.plan_view)
        self._words = words
        self._sections = lru_cache(maxsize=None)(self._count_sections)

    def connections(self, links: Sequence[SignalLink]) -> dict[int, str]:
        """Return the attributes that name the ends of links in SUMO, by index of the link.

        Where several lanes of a road lead to one lane it keeps one of them: that of the connecting road whose id
        comes first as a text, but for ways from lanes for some, which are closed there (`preparation`).
        """

        def order(item: tuple[int, SignalLink]) -> tuple[bool, str, int]:
            n, link = item
            return self._for_some(link), str(link.connecting_road), n

        found: dict[tuple[str, str, int], int] = {}
        lanes: dict[int, int] = {}
        for n, link in sorted(enumerate(links), key=order):
            before = self._lane(link.road, link.at_end, link.lane)
            after = self._lane(link.exit_road, not link.exit_at_start, link.exit_lane)
            if before is not None and after is not None:
                edge = self._edge(link.road, link.at_end, along=link.at_end)
                exit_edge = self._edge(link.exit_road, not link.exit_at_start, along=link.exit_at_start)
                lanes.setdefault(found.setdefault((edge, exit_edge, after), n), before)
        places = {n: place for place, n in found.items()}
        return {
            n: f'from="{edge}" to="{exit_edge}" fromLane="{lanes[n]}" toLane="{after}"'
            for n, (edge, exit_edge, after) in sorted(places.items())
        }

    def _edge(self, road: int, at_end: bool, *, along: bool) -> str:
        count = self._sections(road)
        section = f"#{count - 1 if at_end else 0}" if count > 1 else ""
        return f"{'-' if along else ''}{road}{section}"

    def _for_some(self, link: SignalLink) -> bool:
        """Whether a link begins on a lane that is not for all."""
        lanes = self._lanes(link.road, link.at_end)
        return any(item.id == link.lane and self._words.lane_users(item.type.value) for item in lanes)

    def _lanes(self, road: int, at_end: bool) -> tuple[Lane, ...]:
        return self._map.roads[self._roads[road]].lane_sections[-1 if at_end else 0].lanes

    def _lane(self, road: int, at_end: bool, lane: int) -> int | None:
        """Return the index of a lane at an end of a road; None where SUMO has none."""
        side = [item for item in self._imported(self._lanes(road, at_end)) if item.id * lane > 0]
        ids = sorted((item.id for item in side), key=abs, reverse=True)
        return ids.index(lane) if lane in ids else None

    def _imported(self, lanes: Iterable[Lane]) -> list[Lane]:
        return [item for item in lanes if item.id and self._words.lane_type(item.type.value) in _IMPORTED]

    def _count_sections(self, road_id: int) -> int:
        """Return how many pieces netconvert makes of a road."""
        index = self._roads[road_id]
        road, length = self._map.roads[index], float(self._lengths[index])
        sections = [item for k, item in enumerate(road.lane_sections) if not k or _apart(road.lane_sections, k)]
        starts = [item.s for item in sections]
        if len(sections) == 1 and _is_loop(road):
            sections, starts = [sections[0], sections[0]], [0.0, 0.5 * length]
        count = len(sections)
        for section, (start, end) in zip(sections, pairwise([*starts, length]), strict=True):
            at = sorted(
                s
                for item in self._imported(section.lanes)
                if self._words.lane_type(item.type.value) != "restricted"
                for s in _cuts(item.widths, section.s, end)
            )
            last = start
            for s in at:
                if s - last >= _SHORTEST_CUT and end - s >= _SHORTEST_CUT:
                    count, last = count + 1, s
        return count


def _apart(sections: Sequence[LaneSection], k: int) -> bool:
    return abs(sections[k].s - sections[k - 1].s) >= _SAME_PLACE


def _is_loop(road: Road) -> bool:
    ends = [(link.to_junction, link.id) for link in (road.predecessor, road.successor) if link is not None]
    return len(ends) == 2 and ends[0] == ends[1] and ends[0][0]


def _cuts(widths: Sequence[Cubic], start: float, end: float) -> list[float]:
    """Return where a lane of a section is cut, s on the road, m: near where it has the least width."""
    out = []
    s, width = widths[0].s, widths[0].at(0.0)
    for k, item in enumerate(widths):
        until = widths[k + 1].s if k + 1 < len(widths) else end - start
        then = item.at(until - item.s)
        if width < _LEAST_WIDTH < then or width > _LEAST_WIDTH > then:
            at = s + (until - s) / abs(then - width) * abs(_LEAST_WIDTH - width)
            step = -_SAME_PLACE if width < _LEAST_WIDTH else _SAME_PLACE
            while s <= at <= until and item.at(at - item.s) > _LEAST_WIDTH:
                at += step
            out.append(start + min(max(at, s), until))
        s, width = until, then
    return out
