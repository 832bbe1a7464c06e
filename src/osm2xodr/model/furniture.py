"""What furniture adds to a road map: signals, objects, and what switches the lights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Signal:
    """A traffic light or sign."""

    id: int  # Unique among signals and objects, above 0
    road: int  # Id of the road that it stands on
    # Where, m
    s: float
    t: float
    # OpenDRIVE's attributes; subtype ``-1`` where there is none
    name: str
    type: str
    subtype: str
    country: str
    dynamic: bool  # Whether it changes (lights)
    orientation: str  # ``+`` or ``-``: it is for traffic along s or against it; ``none`` for both
    # m; z_offset of its lower edge above the road
    z_offset: float
    height: float
    width: float
    h_offset: float = 0.0  # Turn against the direction that its orientation says, rad
    # As of speed limits; None and empty where there is none
    value: float | None = None
    unit: str = ""
    text: str = ""  # Written on it
    validity: tuple[tuple[int, int], ...] = ()  # (from lane, to lane) of the lanes that it is for; all where empty
    osm_id: str = ""  # ``node/1`` …; empty where no single element is behind it


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
    """Signals that always show the same."""

    id: int  # Unique among controllers, above 0
    name: str  # For people
    signals: tuple[int, ...]  # Their ids, ascending
    junction: int | None  # Id of the junction it belongs to; None apart from junctions
    sequence: int  # Its place among the controllers of the junction, from 0
    kind: str = "traffic"  # What it switches: ``traffic`` or ``pedestrian``


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
    """A thing on or beside a road."""

    id: int  # Unique among signals and objects, above 0
    road: int  # Id of its road
    # OpenDRIVE's attributes; the writer puts types into the words of its version
    type: str
    subtype: str
    name: str
    # Its place on the road, m, and its heading against the road's, rad
    s: float
    t: float
    z_offset: float = 0.0
    hdg: float = 0.0
    # m; radius instead of the first two for round things, 0 where unknown
    length: float = 0.0
    width: float = 0.0
    height: float = 0.0
    radius: float = 0.0
    orientation: str = "none"  # ``+``, ``-`` or ``none``
    # Corners u, v, z, height in the object's own frame, m; closed; empty for none
    outline: tuple[tuple[float, float, float, float], ...] = ()
    validity: tuple[tuple[int, int], ...] = ()  # As of `Signal`
    repeat: ObjectRepeat | None = None  # Copies
    osm_id: str = ""  # As of `Signal`


@dataclass(frozen=True, slots=True)
class RoadStructure:
    """A bridge that a road leads over, or a tunnel that it leads through."""

    id: int  # Unique among signals, objects and these, above 0
    # Id of the road, where it begins, and its extent, m
    road: int
    s: float
    length: float
    # ``bridge`` or ``tunnel``, and OpenDRIVE's word for its material, or for whether its sides are open
    kind: str
    type: str
    name: str = ""  # Empty for none
    # Of a tunnel, 0 to 1
    lighting: float = 0.0
    daylight: float = 0.0
    osm_way_ids: tuple[int, ...] = ()  # The ways that it comes from


@dataclass(frozen=True, slots=True)
class Furniture:
    """All that stands on and beside roads, and what carries or covers them; each kind in ascending road and s."""

    signals: tuple[Signal, ...] = ()
    references: tuple[SignalReference, ...] = ()
    controllers: tuple[Controller, ...] = ()
    objects: tuple[RoadObject, ...] = ()
    structures: tuple[RoadStructure, ...] = ()
    statistics: Mapping[str, float] = field(default_factory=dict)
