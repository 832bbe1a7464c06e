"""What furniture adds to a road map: signals, objects, and what switches the lights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Signal:
    """A traffic light or sign.

    Parameters
    ----------
    id
        Unique among signals and objects, above 0.
    road
        Id of the road that it stands on.
    s, t
        Where, m.
    name, type, subtype, country
        OpenDRIVE's attributes; subtype ``-1`` where there is none.
    dynamic
        Whether it changes (lights).
    orientation
        ``+`` or ``-``: it is for traffic along s or against it; ``none`` for both.
    z_offset, height, width
        m; z_offset of its lower edge above the road.
    h_offset
        Turn against the direction that its orientation says, rad.
    value, unit
        As of speed limits; None and empty where there is none.
    text
        Written on it.
    validity
        (from lane, to lane) of the lanes that it is for; all where empty.
    osm_id
        ``node/1`` …; empty where no single element is behind it.
    """

    id: int
    road: int
    s: float
    t: float
    name: str
    type: str
    subtype: str
    country: str
    dynamic: bool
    orientation: str
    z_offset: float
    height: float
    width: float
    h_offset: float = 0.0
    value: float | None = None
    unit: str = ""
    text: str = ""
    validity: tuple[tuple[int, int], ...] = ()
    osm_id: str = ""


@dataclass(frozen=True, slots=True)
class SignalReference:
    """A road that a signal of another road is for as well; fields as of `Signal`."""

    signal: int
    road: int
    s: float
    t: float
    orientation: str
    validity: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True, slots=True)
class Controller:
    """Signals that always show the same.

    Parameters
    ----------
    id
        Unique among controllers, above 0.
    name
        For people.
    signals
        Their ids, ascending.
    junction
        Id of the junction it belongs to; None apart from junctions.
    sequence
        Its place among the controllers of the junction, from 0.
    kind
        What it switches: ``traffic`` or ``pedestrian``.
    """

    id: int
    name: str
    signals: tuple[int, ...]
    junction: int | None
    sequence: int
    kind: str = "traffic"


@dataclass(frozen=True, slots=True)
class ObjectRepeat:
    """Copies of an object, or one that goes on, from s over a length; all in m. distance 0 means without a gap."""

    s: float
    length: float
    distance: float
    t_start: float
    t_end: float
    width: float
    height: float
    z_offset: float = 0.0


@dataclass(frozen=True, slots=True)
class RoadObject:
    """A thing on or beside a road.

    Parameters
    ----------
    id
        Unique among signals and objects, above 0.
    road
        Id of its road.
    type, subtype, name
        OpenDRIVE's attributes; the writer puts types into the words of its version.
    s, t, z_offset, hdg
        Its place on the road, m, and its heading against the road's, rad.
    length, width, height, radius
        m; radius instead of the first two for round things, 0 where unknown.
    orientation
        ``+``, ``-`` or ``none``.
    outline
        Corners u, v, z, height in the object's own frame, m; closed; empty for none.
    validity
        As of `Signal`.
    repeat
        Copies.
    osm_id
        As of `Signal`.
    """

    id: int
    road: int
    type: str
    subtype: str
    name: str
    s: float
    t: float
    z_offset: float = 0.0
    hdg: float = 0.0
    length: float = 0.0
    width: float = 0.0
    height: float = 0.0
    radius: float = 0.0
    orientation: str = "none"
    outline: tuple[tuple[float, float, float, float], ...] = ()
    validity: tuple[tuple[int, int], ...] = ()
    repeat: ObjectRepeat | None = None
    osm_id: str = ""


@dataclass(frozen=True, slots=True)
class RoadStructure:
    """A bridge that a road leads over, or a tunnel that it leads through.

    Parameters
    ----------
    id
        Unique among signals, objects and these, above 0.
    road, s, length
        Id of the road, where it begins, and its extent, m.
    kind, type
        ``bridge`` or ``tunnel``, and OpenDRIVE's word for its material, or for whether its sides are open.
    name
        Empty for none.
    lighting, daylight
        Of a tunnel, 0 to 1.
    osm_way_ids
        The ways that it comes from.
    """

    id: int
    road: int
    s: float
    length: float
    kind: str
    type: str
    name: str = ""
    lighting: float = 0.0
    daylight: float = 0.0
    osm_way_ids: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Furniture:
    """All that stands on and beside roads, and what carries or covers them; each kind in ascending road and s."""

    signals: tuple[Signal, ...] = ()
    references: tuple[SignalReference, ...] = ()
    controllers: tuple[Controller, ...] = ()
    objects: tuple[RoadObject, ...] = ()
    structures: tuple[RoadStructure, ...] = ()
    statistics: Mapping[str, float] = field(default_factory=dict)
