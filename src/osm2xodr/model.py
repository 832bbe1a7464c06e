"""What the stages hand to each other, in the order of the pipeline. Read this first.

Units are SI (m, rad, m/s, 1/m) unless a name says otherwise. Local x points east, y north; headings count
counter-clockwise from east; s runs along a road, t to its left. Everything is frozen, arrays are read-only.
Words of OpenStreetMap (node, way, street, intersection) belong to what is read, words of OpenDRIVE (road, lane
section, junction, s, t, hdg) to what is written.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol

import numpy as np
import numpy.typing as npt

from osm2xodr.elevation_report import ElevationReport

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


def freeze_arrays(record: object) -> None:
    """Set every array of a dataclass read-only, so that stages can share it."""
    for name in type(record).__dataclass_fields__:  # type: ignore[attr-defined]
        value = getattr(record, name)
        if isinstance(value, np.ndarray):
            value.flags.writeable = False


# ---------------------------------------------------------------- shared


class Rule(str, Enum):
    """On which side of the road traffic drives, in OpenDRIVE's words."""

    RIGHT_HAND = "RHT"
    LEFT_HAND = "LHT"


class Direction(int, Enum):
    """Which way traffic on a lane runs, seen along its street."""

    FORWARD = 1
    BACKWARD = -1
    BOTH = 0


class LaneType(str, Enum):
    """Types of lanes, in OpenDRIVE's words."""

    DRIVING = "driving"
    BIDIRECTIONAL = "bidirectional"
    BUS = "bus"
    TAXI = "taxi"
    BIKING = "biking"
    SIDEWALK = "sidewalk"
    PARKING = "parking"
    SHOULDER = "shoulder"
    MEDIAN = "median"
    NONE = "none"


class Structure(int, Enum):
    """What carries a piece of road."""

    GROUND = 0
    BRIDGE = 1
    TUNNEL = 2


@dataclass(frozen=True, slots=True)
class LocalFrame:
    """Where local x and y are on Earth.

    Parameters
    ----------
    proj
        PROJ text of the projection, also the georeference that is written.
    lat_0_deg, lon_0_deg
        Origin of x and y, WGS 84.
    """

    proj: str
    lat_0_deg: float
    lon_0_deg: float


# ---------------------------------------------------------------- osmParsing -> geometry


@dataclass(frozen=True, slots=True)
class LaneSpec:
    """One lane as OSM's tags describe it.

    Parameters
    ----------
    type, direction
        What may use it, and which way along the street.
    width
        m.
    turns
        The values of ``turn:lanes`` for it (``left``, ``through``, ``merge_to_right`` …); empty where OSM says
        nothing or ``none``.
    """

    type: LaneType
    direction: Direction
    width: float
    turns: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class StreetAttributes:
    """What the tags of one way say, turned into the direction of the street that carries it.

    Parameters
    ----------
    osm_way_id
        The way.
    reversed
        Whether the street runs against the way's order of nodes.
    highway, name, ref
        OSM's own values; empty where absent.
    lanes_ltr
        All lanes from left to right, seen along the street.
    middle_offset
        t of the carriageway's middle off the OSM line (left positive), m; 0 unless ``placement`` says otherwise.
    speed_forward, speed_backward
        m/s; None where unknown, infinity where there is no limit.
    structure, layer
        What carries the street here, and OSM's ``layer`` (0 where absent; bridges default to 1, tunnels to -1).
    grade
        Rise per metre along the street from ``incline``; None where OSM gives no number.
    roundabout
        Whether the way is part of a roundabout (``junction=roundabout`` or ``circular``).
    priority_road
        Whether the way has the right of way wherever nothing else is said (``priority_road=designated``).
    """

    osm_way_id: int
    reversed: bool
    highway: str
    name: str
    ref: str
    lanes_ltr: tuple[LaneSpec, ...]
    middle_offset: float
    speed_forward: float | None
    speed_backward: float | None
    structure: Structure
    layer: int
    grade: float | None
    roundabout: bool
    priority_road: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Street:
    """A chain of pieces of ways between two intersections or dead ends.

    Parameters
    ----------
    id
        Its index in `StreetNetwork.streets`.
    start, end
        Indices into `StreetNetwork.intersections`. A street may start and end at the same one; -1 at both ends
        marks a closed ring without any intersection.
    points : (n, 2)
        Local x, y of its nodes, m; no two in a row are closer than 1 mm; n >= 2.
    node_ids : (n,)
        OSM ids of the nodes.
    pieces
        Attributes that hold from the node at an index on (the first index is 0, ascending).
    """

    id: int
    start: int
    end: int
    points: FloatArray
    node_ids: IntArray
    pieces: tuple[tuple[int, StreetAttributes], ...]

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True, slots=True)
class Intersection:
    """A node where streets meet or end. Dead ends are intersections of one street end.

    Parameters
    ----------
    id
        Its index in `StreetNetwork.intersections`.
    osm_node_id
        The node.
    x, y
        Local position, m.
    arms
        The street ends that meet here: (street id, True if it is the street's start).
    """

    id: int
    osm_node_id: int
    x: float
    y: float
    arms: tuple[tuple[int, bool], ...]


@dataclass(frozen=True, slots=True)
class TurnRestriction:
    """A restriction relation that holds for cars at all times.

    Parameters
    ----------
    osm_relation_id
        The relation.
    only
        True for ``only_*``, False for ``no_*``.
    value
        OSM's value, e.g. ``no_left_turn``.
    from_ways, to_ways
        OSM way ids.
    via_node
        OSM node id, or None where the via members are ways.
    via_ways
        OSM way ids in the relation's order; empty with a via node.
    """

    osm_relation_id: int
    only: bool
    value: str
    from_ways: tuple[int, ...]
    via_node: int | None
    via_ways: tuple[int, ...]
    to_ways: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class LaneConnectivity:
    """A ``connectivity`` relation: which lane of one way leads to which lane of another.

    Lanes count as in the relation: from 1 at the left as their drivers see them, those of the direction of travel
    only.

    Parameters
    ----------
    osm_relation_id
        The relation.
    from_way, to_way
        OSM way ids.
    via_node
        OSM node id, or None where the via members are ways.
    via_ways
        OSM way ids in the relation's order; empty with a via node.
    lanes
        (lane of the from way, lane of the to way, whether the link is optional, that is in brackets).
    """

    osm_relation_id: int
    from_way: int
    via_node: int | None
    via_ways: tuple[int, ...]
    to_way: int
    lanes: tuple[tuple[int, int, bool], ...]


@dataclass(frozen=True, slots=True, eq=False)
class StreetNetwork:
    """All streets of an area: what the OSM file says about what is to be driven on.

    Parameters
    ----------
    frame
        Where x and y are.
    rule
        The side of the road that traffic drives on.
    country
        ISO 3166-1 alpha-2 code of the country of the frame's origin; empty where it is in none.
    streets, intersections, restrictions
        The network.
    connectivities
        What connectivity relations say about lanes.
    node_tags
        Tags of the tagged nodes on streets by OSM node id (signals, stop lines, crossings, turning circles …).
    bounds_deg
        West, south, east, north of the carried nodes, degrees, WGS 84.
    """

    frame: LocalFrame
    rule: Rule
    country: str
    streets: tuple[Street, ...]
    intersections: tuple[Intersection, ...]
    restrictions: tuple[TurnRestriction, ...]
    node_tags: Mapping[int, Mapping[str, str]]
    bounds_deg: tuple[float, float, float, float]
    connectivities: tuple[LaneConnectivity, ...] = ()


# ---------------------------------------------------------------- surface -> geometry


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceQuality:
    """How far heights can be trusted, point by point.

    Parameters
    ----------
    cell_size : (n,)
        Distance between the heights that the surface is made from there, m (0 for an exact surface).
    sigma : (n,)
        Standard error of the heights, m (0 for an exact surface).
    covered : (n,)
        Whether the heights are those of a surface model, which lies on canopy and roofs rather than on the ground.
    """

    cell_size: FloatArray
    sigma: FloatArray
    covered: BoolArray

    def __post_init__(self) -> None:
        freeze_arrays(self)


class Surface(Protocol):
    """Height of the ground at local positions."""

    @property
    def cell_size(self) -> float:
        """Distance between the heights that most of the surface is made from, m (0 for an exact surface)."""

    @property
    def sigma(self) -> float:
        """Standard error of most of its heights, m (0 for an exact surface)."""

    def heights(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return z (n,), m, at local x, y (n,), m, and where it is measured.

        Where it is not measured (voids, outside of the elevation model) z is the surface's best guess.
        """

    def quality(self, x: FloatArray, y: FloatArray) -> SurfaceQuality:
        """Return how far the heights at local x, y (n,), m, can be trusted."""


# ---------------------------------------------------------------- geometry -> xodrWriter


@dataclass(frozen=True, slots=True, eq=False)
class PlanView:
    """Lines and arcs of many curves (reference lines) as flat arrays.

    Parameters
    ----------
    start : (curves + 1,)
        Index of each curve's first record; the last entry is the number of records.
    s, x, y, hdg, length, curvature : (records,)
        As OpenDRIVE's ``<geometry>``; curvature 0 is a line. s restarts at 0 with each curve.
    """

    start: IntArray
    s: FloatArray
    x: FloatArray
    y: FloatArray
    hdg: FloatArray
    length: FloatArray
    curvature: FloatArray

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True, slots=True, eq=False)
class CubicProfile:
    """Piecewise cubics a + b ds + c ds² + d ds³ over s of many curves as flat arrays, ds = s' - s.

    Parameters
    ----------
    start : (curves + 1,)
        Index of each curve's first record; a curve may have none.
    s, a, b, c, d : (records,)
        Start and coefficients. Every curve that has records starts at s = 0.
    """

    start: IntArray
    s: FloatArray
    a: FloatArray
    b: FloatArray
    c: FloatArray
    d: FloatArray

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True, slots=True)
class Cubic:
    """One record a + b ds + c ds² + d ds³ from s on (s local to what carries it)."""

    s: float
    a: float
    b: float = 0.0
    c: float = 0.0
    d: float = 0.0


@dataclass(frozen=True, slots=True)
class RoadMark:
    """The mark on a lane's outer edge, in OpenDRIVE's words."""

    type: str
    color: str = "standard"
    width: float = 0.12
    lane_change: str = "none"


@dataclass(frozen=True, slots=True)
class Lane:
    """One lane of a lane section.

    Parameters
    ----------
    id
        OpenDRIVE's lane id: 0 centre, negative to its right, positive to its left.
    type
        What it is for.
    widths
        Width from the section's start on, s local to the section; empty for the centre lane.
    predecessor, successor
        Lane id in the section or road before and after; None where there is none, or where the road's end lies
        at a junction.
    road_mark
        The mark on its outer edge (for the centre lane: on the centre line).
    speed
        m/s, only where it differs from the road's own.
    """

    id: int
    type: LaneType
    widths: tuple[Cubic, ...]
    predecessor: int | None = None
    successor: int | None = None
    road_mark: RoadMark | None = None
    speed: float | None = None


@dataclass(frozen=True, slots=True)
class LaneSection:
    """All lanes from s on, highest id (leftmost) first, the centre lane among them."""

    s: float
    lanes: tuple[Lane, ...]


@dataclass(frozen=True, slots=True)
class RoadType:
    """Type and speed limit of a road from s on.

    Parameters
    ----------
    s
        m.
    type
        OpenDRIVE's word: ``motorway``, ``rural``, ``town``, ``townExpressway``, ``lowSpeed`` …
    speed
        m/s; None where unknown, infinity where there is no limit.
    """

    s: float
    type: str
    speed: float | None


@dataclass(frozen=True, slots=True)
class RoadLink:
    """What lies beyond a road's end.

    Parameters
    ----------
    to_junction
        Whether `id` names a junction (else a road).
    id
        Id of the road or junction.
    at_start
        With a road: whether its start (else its end) touches; None with a junction.
    """

    to_junction: bool
    id: int
    at_start: bool | None = None


@dataclass(frozen=True, slots=True)
class Road:
    """A road, save for its curve and heights, which stand in the tables of `RoadMap` at the road's index.

    Parameters
    ----------
    id
        OpenDRIVE id, unique among roads and junctions, above 0.
    name
        For people; may be empty.
    junction
        Id of the junction that a connecting road belongs to; None for all others.
    predecessor, successor
        What lies before s = 0 and beyond the end.
    types, lane_sections
        In ascending s; at least one lane section.
    osm_way_ids
        Where it comes from.
    """

    id: int
    name: str
    junction: int | None
    predecessor: RoadLink | None
    successor: RoadLink | None
    types: tuple[RoadType, ...]
    lane_sections: tuple[LaneSection, ...]
    osm_way_ids: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Connection:
    """One way through a junction; the connecting road touches the incoming road with its start.

    Parameters
    ----------
    id
        Unique within its junction, from 0.
    incoming_road, connecting_road
        Ids of roads.
    lane_links
        (lane id of the incoming road, lane id of the connecting road).
    """

    id: int
    incoming_road: int
    connecting_road: int
    lane_links: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class Junction:
    """A junction and the ways through it.

    Parameters
    ----------
    id
        OpenDRIVE id, unique among roads and junctions, above 0.
    name
        For people; may be empty.
    connections
        At least one.
    osm_node_ids
        Where it comes from.
    priorities
        (id of the road with priority, id of the road that yields).
    """

    id: int
    name: str
    connections: tuple[Connection, ...]
    osm_node_ids: tuple[int, ...]
    priorities: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class RoadMap:
    """An OpenDRIVE road network.

    Parameters
    ----------
    frame, rule
        Where it is, and on which side one drives.
    roads, junctions
        In ascending id.
    plan_view, elevation, superelevation, lane_offset
        Tables whose k-th curve belongs to the k-th road. Elevation has records for every road, the last two may
        have none.
    elevation_report
        How the heights came out; None on a level world.
    """

    frame: LocalFrame
    rule: Rule
    roads: tuple[Road, ...]
    junctions: tuple[Junction, ...]
    plan_view: PlanView
    elevation: CubicProfile
    superelevation: CubicProfile
    lane_offset: CubicProfile
    statistics: Mapping[str, float] = field(default_factory=dict)
    elevation_report: ElevationReport | None = None
