"""The result of geometry: roads, junctions, the tables of their curves and heights, a report on these, and areas."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

import numpy as np

from osm2xodr.model.furniture import Furniture
from osm2xodr.model.shared import Access, BoolArray, FloatArray, IntArray, LaneType, LocalFrame, ReadOnlyArrays, Rule
from osm2xodr.system import record


@record(eq=False)
class PlanView(ReadOnlyArrays):
    """Lines, arcs and spirals of many curves (reference lines) as flat arrays."""

    start: IntArray  # (curves + 1,) Index of each curve's first record; the last entry is the number of records
    # (records,) As OpenDRIVE's ``<geometry>``, curvature where the record starts; a line has 0. s restarts at 0 with
    # each curve.
    s: FloatArray
    x: FloatArray
    y: FloatArray
    hdg: FloatArray
    length: FloatArray
    curvature: FloatArray
    # (records,) Change of curvature with s, 1/m²: that of a spiral (clothoid). Lines and arcs only if left out.
    rate: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        if len(self.rate) != len(self.s):
            object.__setattr__(self, "rate", np.zeros(len(self.s)))
        ReadOnlyArrays.__post_init__(self)


@record(eq=False)
class CubicProfile(ReadOnlyArrays):
    """Piecewise cubics a + b ds + c ds² + d ds³ over s of many curves as flat arrays, ds = s' - s."""

    start: IntArray  # (curves + 1,) Index of each curve's first record; a curve may have none
    # (records,) Start and coefficients. Every curve that has records starts at s = 0.
    s: FloatArray
    a: FloatArray
    b: FloatArray
    c: FloatArray
    d: FloatArray


@record(eq=False)
class Stretches(ReadOnlyArrays):
    """Stretches of many curves as flat arrays."""

    start: IntArray  # (curves + 1,) Index of each curve's first stretch; a curve may have none
    # (stretches,) s, m; they do not overlap, and may end beyond their curves by no more than rounding
    begin: FloatArray
    end: FloatArray

    def total(self, lengths: FloatArray) -> float:
        """Return the length of all stretches, m, on curves of these lengths, (curves,), m."""
        most = np.repeat(lengths, np.diff(self.start))
        return float((np.minimum(self.end, most) - np.minimum(self.begin, most)).sum())


@record
class Cubic:
    """One record a + b ds + c ds² + d ds³ from s on, where s counts from the start of the road or lane section."""

    s: float
    a: float
    b: float = 0.0
    c: float = 0.0
    d: float = 0.0

    def at(self, ds: float) -> float:
        """Return the value at ds from its start."""
        return self.a + ds * (self.b + ds * (self.c + ds * self.d))

    def begun_later(self, ds: float, s: float) -> Cubic:
        """Return the same curve as a record that begins ds farther on, at a given s."""
        slope, bend = self.b + ds * (2 * self.c + 3 * ds * self.d), self.c + 3 * ds * self.d
        return Cubic(s, self.at(ds), slope, bend, self.d)

    @property
    def is_flat(self) -> bool:
        """Whether the record is a constant."""
        return self.b == self.c == self.d == 0.0


@record
class RoadMark:
    """The mark on a lane's outer edge, in OpenDRIVE's words."""

    type: str
    color: str = "standard"
    width: float = 0.12
    lane_change: str = "none"


@record
class Lane:
    """One lane of a lane section."""

    id: int  # OpenDRIVE's lane id: 0 centre, negative to its right, positive to its left
    type: LaneType
    widths: tuple[Cubic, ...]  # Width from the section's start on, s local to the section; empty for the centre lane
    predecessor: int | None = None  # Lane id in the section or road before; None where none is, or at a junction
    successor: int | None = None  # In that after, likewise
    road_mark: RoadMark | None = None  # The mark on its outer edge (for the centre lane: on the centre line)
    # Speed limit of a lane for vehicles, m/s; None where unknown, infinity where there is no limit
    speed: float | None = None
    height: float = 0.0  # Of its surface above the road's, m
    access: Access = Access.ALL  # Which cars may drive on a lane for cars


@record
class LaneSection:
    """All lanes from s on, highest id (leftmost) first, the centre lane among them."""

    s: float
    lanes: tuple[Lane, ...]


@record
class RoadType:
    """Type and speed limit of a road from s on."""

    s: float  # m
    type: str  # OpenDRIVE's word: ``motorway``, ``rural``, ``town``, ``townExpressway``, ``lowSpeed`` …
    speed: float | None  # m/s; None where unknown, infinity where there is no limit


@record
class RoadLink:
    """The road or junction beyond a road's end."""

    to_junction: bool  # Whether `id` names a junction (else a road)
    id: int  # Id of the road or junction
    at_start: bool | None = None  # With a road: whether its start (else its end) touches; None with a junction


@record
class RoadName:
    """The name of a road from s on, and the ways that it comes from there."""

    s: float  # m
    name: str  # As of `Road`, like what follows
    osm_way_ids: tuple[int, ...]
    guesses: tuple[str, ...] = ()


@record
class Road:
    """A road, except for its curve and heights, which are in the tables of `RoadMap` at the road's index."""

    id: int  # OpenDRIVE id, unique among roads and junctions, above 0
    name: str  # For people; may be empty
    junction: int | None  # Id of the junction that a connecting road belongs to; None for all others
    predecessor: RoadLink | None  # Before s = 0
    successor: RoadLink | None  # Beyond the end
    types: tuple[RoadType, ...]  # In ascending s
    lane_sections: tuple[LaneSection, ...]  # In ascending s, at least one
    osm_way_ids: tuple[int, ...]  # The ways that it comes from
    guesses: tuple[str, ...] = ()  # Codes of the guesses about its ways, in ascending order
    # Where it has several names, all of them, the first from 0 on: it is cut there once everything is placed
    names: tuple[RoadName, ...] = ()


@record
class Connection:
    """One way through a junction; the connecting road touches the incoming road with its start."""

    id: int  # Unique within its junction, from 0
    incoming_road: int  # Id of a road
    connecting_road: int  # Id of a road
    lane_links: tuple[tuple[int, int], ...]  # (lane id of the incoming road, lane id of the connecting road)


@record
class BoundaryJoint:
    """A segment of a junction's boundary across the end face of an arm, from its right to its left seen outwards."""

    road: int  # Id of the arm
    at_start: bool  # Whether it is the road's start
    # Ids of the first and the last lane that it crosses; None for all
    first_lane: int | None = None
    last_lane: int | None = None


@record
class BoundaryEdge:
    """A segment of a junction's boundary along the outer edge of a lane of a connecting road."""

    road: int  # Id of the connecting road
    lane: int  # Id of the lane; 0 for the centre line
    # s where it begins and ends, m; it may run against s. 0 is the road's start, infinity its end.
    begin: float
    end: float


@record
class Junction:
    """A junction and the ways through it."""

    id: int  # OpenDRIVE id, unique among roads and junctions, above 0
    name: str  # For people; may be empty
    connections: tuple[Connection, ...]  # At least one
    osm_node_ids: tuple[int, ...]  # The nodes that it comes from
    priorities: tuple[tuple[int, int], ...] = ()  # (id of the road with priority, id of the road that yields)
    # Its outer edge, counter-clockwise and closed; empty where it is not known
    boundary: tuple[BoundaryJoint | BoundaryEdge, ...] = ()


@record(eq=False)
class Island:
    """A raised place that carriageways go round."""

    junction: int  # Id of the junction in which it was found; -1 where OSM maps it
    road: int  # Index of a road beside it
    corners: FloatArray  # (n, 2) local x, y, counter-clockwise, m
    osm_id: str = ""  # The area in OSM


@record(eq=False)
class StreetPlaces(ReadOnlyArrays):
    """Where streets and their tagged nodes are in a `RoadMap`.

    Roads outside junctions run in the direction of the street that they were cut from.
    """

    # (roads outside junctions,) Index of the street of the k-th road; these roads come first in `RoadMap.roads`
    road_street: IntArray
    # (2 x streets,) Id of the road that each street end became (2 k the start of street k, 2 k + 1 its end), -1 for
    # none.
    end_road: IntArray
    # (2 x streets,) Id of the junction at each street end, also where the street lies inside it; -1 for none
    end_junction: IntArray
    inner: BoolArray  # (streets,) Whether the street lies wholly inside a junction
    node: IntArray  # (n,) OSM id of each tagged node (`StreetNetwork.node_tags`), once for each street
    street: IntArray  # (n,) Index of the street
    road: IntArray  # (n,) Id of the street's road that is nearest to the node, -1 where it has none
    # (n,) Where on that road the node is, m. s lies before 0 or beyond the road's length by how far the node lies off
    # it in the junction there; NaN without a road.
    s: FloatArray
    t: FloatArray
    junction: IntArray  # (n,) Id of the junction that the node lies in, -1 for none


@record
class RoadPlace:
    """A place on a road where something is not as it should be."""

    road: int  # OpenDRIVE id
    osm_way_id: int  # The way that holds there
    s: float  # m
    value: float  # Found, m or rise per metre
    wanted: float  # In the same unit


@record
class LayerCrossing:
    """A place where one road passes over another."""

    upper: int  # OpenDRIVE id of the road
    lower: int  # OpenDRIVE id of the road
    upper_way: int  # OSM way
    lower_way: int  # OSM way
    clearance: float  # Found height from road to road, m
    wanted: float  # Wanted height, m


@record
class StructureRecord:
    """A bridge or tunnel: one chain of bridge or tunnel ways without a junction in between."""

    kind: str  # ``bridge`` or ``tunnel``
    osm_way_ids: tuple[int, ...]  # The ways that it consists of
    roads: tuple[int, ...]  # The OpenDRIVE roads that it consists of
    length: float  # m
    # Largest height above the elevation model (in a tunnel: the lowest, negative), m; None where nothing is measured
    above_ground: float | None
    # Least height, m, from road to road where it crosses another one, and that OSM way; None where it crosses none
    clearance: float | None
    crossed_way: int | None
    grade: float  # Largest grade on it, rise per metre
    grade_limit: float  # That of its class, rise per metre


@record
class ElevationReport:
    """The heights of a road network against the elevation model and the limits."""

    # Height of roads on the ground above the elevation model: mean, root of the mean square and 95th percentile of
    # its magnitude, m.
    bias: float
    rms: float
    p95: float
    farthest: tuple[RoadPlace, ...]  # The roads farthest from the model: height above it, wanted 0; worst first
    steep: tuple[RoadPlace, ...]  # Roads above their class's limit, at their steepest place; the worst first
    structures: tuple[StructureRecord, ...]  # All bridges and tunnels, in order of their first OSM way
    tight: tuple[LayerCrossing, ...]  # Crossings whose clearance is not met, the worst first


@record
class Outline:
    """The outline of an area."""

    # Corners (n, 2) of closed rings, local x, y, m, the first not repeated at the end. A point is inside if an odd
    # number of them goes round it, so that holes and parts are rings as well.
    rings: tuple[FloatArray, ...]


@record
class Partition:
    """Areas that are converted one by one, so that the results fit together."""

    frame: LocalFrame  # Common to all
    names: tuple[str, ...]  # Unique
    outlines: tuple[Outline, ...]  # A place that several cover belongs to the first of them
    first_ids: tuple[int, ...]  # Id of each area's first road; its other ids lie below the next greater one
    own: int  # Index of the area that is converted
    block: tuple[int, ...] = ()  # Indices, ascending, of the areas that are laid out together with it; () for none

    def together(self) -> tuple[int, ...]:
        """Return the indices of the areas that are laid out at once, that of the own one among them."""
        return self.block or (self.own,)


@record(eq=False)
class Borders(ReadOnlyArrays):
    """The area of each piece of road: index into `Partition.names`, -1 outside of all."""

    partition: Partition
    # (roads outside junctions + 1,) Index of each road's first piece; the last entry is the number of pieces. Every
    # road has at least one.
    piece_start: IntArray
    piece_s: FloatArray  # (pieces,) Where each piece begins along its road, m; 0 for the first one
    piece_area: IntArray  # (pieces,) Its area, different from that of the next piece of the road
    # (junctions,) The area of each junction of `RoadMap.junctions`, the same as that of the pieces that touch it
    junction_area: IntArray


@record
class BorderEnd:
    """The end of a road that continues in a neighbouring area."""

    road: int  # Id of the road
    at_start: bool  # Whether it is the road's start
    neighbour: str  # Name of the area in which it continues; empty outside of all
    # The reference line there, local, m
    x: float
    y: float
    z: float
    hdg: float  # Of the reference line along s, rad
    osm_way_ids: tuple[int, ...]  # Of the road that was cut


@record(eq=False)
class RoadMap:
    """An OpenDRIVE road network."""

    frame: LocalFrame
    rule: Rule
    roads: tuple[Road, ...]  # In ascending id
    junctions: tuple[Junction, ...]  # In ascending id
    # Tables whose k-th curve belongs to the k-th road. Elevation has records for every road, the last two may have
    # none.
    plan_view: PlanView
    elevation: CubicProfile
    superelevation: CubicProfile
    lane_offset: CubicProfile
    statistics: Mapping[str, float] = field(default_factory=dict)
    # None on a level world where no road passes over another
    elevation_report: ElevationReport | None = None
    # Where no elevation model has a height at the reference lines of the roads; None on a level world
    unmeasured: Stretches | None = None
    country: str = ""  # ISO 3166-1 alpha-2 code; empty outside of all countries
    places: StreetPlaces | None = None
    furniture: Furniture = field(default_factory=Furniture)
    islands: tuple[Island, ...] = ()  # Raised places, which are not furniture yet
    # The areas that the roads belong to, if the area is one of several side by side; the road map then includes the
    # surroundings of the area, until they are cut off.
    borders: Borders | None = None
    # Where roads were cut off that continue in a neighbouring area; None if no surroundings were cut off
    border_ends: tuple[BorderEnd, ...] | None = None
