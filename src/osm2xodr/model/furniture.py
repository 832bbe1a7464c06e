"""Signals, objects and controllers, which furniture adds to a road map."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

from osm2xodr.system import record


@record
class Signal:
    """A traffic light or sign."""

    id: int  # Unique among signals and objects, above 0
    road: int  # Id of the road that it stands on
    s: float  # m
    t: float  # m
    # OpenDRIVE's attributes; subtype ``-1`` for none
    name: str
    type: str
    subtype: str
    country: str
    dynamic: bool  # Whether it changes (lights)
    orientation: str  # ``+`` for traffic along s, ``-`` for traffic against it, ``none`` for both
    z_offset: float  # Height of its lower edge above the road, m
    height: float  # m
    width: float  # m
    h_offset: float = 0.0  # Rotation from the direction of its orientation, rad
    value: float | None = None  # Such as a speed limit; None for none
    unit: str = ""  # Of the value; empty for none
    text: str = ""  # The text on it
    validity: tuple[tuple[int, int], ...] = ()  # (from lane, to lane) of the lanes that it is for; empty for all
    osm_id: str = ""  # ``node/1`` …; empty if it does not come from a single element
    derived: bool = False  # Whether it stands nowhere, but follows from the priorities of a junction

    def place_for_traffic(self) -> tuple[int, str, float, int]:
        """Return what sorts signals by road and direction, each in the order in which its traffic meets them."""
        return self.road, self.orientation, -self.s if self.orientation == "-" else self.s, self.id


@record
class SignalReference:
    """Another road that a signal applies to as well; fields as of `Signal`."""

    signal: int
    road: int
    s: float
    t: float
    orientation: str
    validity: tuple[tuple[int, int], ...] = ()


@record
class Controller:
    """Signals that always show the same phase."""

    id: int  # Unique among controllers, above 0
    name: str  # For people
    signals: tuple[int, ...]  # Their ids, ascending
    junction: int | None  # Id of its junction; None outside junctions
    sequence: int  # Its number among the controllers of the junction, from 0
    kind: str = "traffic"  # The lights that it switches: ``traffic`` or ``pedestrian``
    further_junctions: tuple[int, ...] = ()  # Ids of others that it belongs to as well, ascending


@record
class SignalLink:
    """A way through a junction with lights from one lane to another."""

    connecting_road: int  # Id
    road: int  # Id of the road that traffic comes from
    at_end: bool  # Whether from its end, else from its start
    lane: int  # Id of its lane there
    exit_road: int  # Id of the road that it leads to
    exit_at_start: bool  # Whether onto its start, else onto its end
    exit_lane: int  # Id of its lane there


@record
class SignalPhase:
    """A part of a signal programme in which no light changes."""

    # What each link of the programme shows, in SUMO's letters: ``G`` goes first, ``g`` yields, ``y`` yellow, ``r``
    # red, ``o`` has no light and yields
    state: str
    duration: float  # s
    # Least and greatest duration where detectors decide, s; None where the duration is fixed
    range: tuple[float, float] | None = None


@record
class SignalProgramme:
    """When the lights of a junction are green: phases that follow each other for ever."""

    junction: int  # Id
    links: tuple[SignalLink, ...]  # All of the junction
    phases: tuple[SignalPhase, ...]
    detector_range: float = 0.0  # How far before their stop lines vehicles are detected, m; 0 where times are fixed


@record
class ObjectRepeat:
    """Copies of an object from s over a length, or one continuous object where distance is 0; all in m."""

    s: float
    length: float
    distance: float
    t_start: float
    t_end: float
    width: float
    height: float
    z_offset: float = 0.0


@record
class RoadObject:
    """A thing on or beside a road."""

    id: int  # Unique among signals and objects, above 0
    road: int  # Id of its road
    # OpenDRIVE's attributes; the writer translates types to its version
    type: str
    subtype: str
    name: str
    # Its place on the road, m, and its heading relative to the road, rad
    s: float
    t: float
    z_offset: float = 0.0
    hdg: float = 0.0
    # m, 0 for unknown; round things have a radius instead of length and width
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


@record
class RoadStructure:
    """A bridge or tunnel on a road."""

    id: int  # Unique among signals, objects and these, above 0
    road: int  # Id of the road
    s: float  # Where it begins, m
    length: float  # m
    # ``bridge`` or ``tunnel``, and OpenDRIVE's word for its material, or for whether its sides are open
    kind: str
    type: str
    name: str = ""  # Empty for none
    lighting: float = 0.0  # Of a tunnel, 0 to 1
    daylight: float = 0.0  # As lighting
    osm_way_ids: tuple[int, ...] = ()  # The ways that it comes from


@record
class Furniture:
    """All furniture of the roads, and their bridges and tunnels; each kind in ascending road and s."""

    signals: tuple[Signal, ...] = ()
    references: tuple[SignalReference, ...] = ()
    controllers: tuple[Controller, ...] = ()
    programmes: tuple[SignalProgramme, ...] = ()  # Of junctions, in ascending id
    objects: tuple[RoadObject, ...] = ()
    structures: tuple[RoadStructure, ...] = ()
    statistics: Mapping[str, float] = field(default_factory=dict)
