"""What geometry hands on: roads, junctions and the tables of their curves and heights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from osm2xodr.model.areas import BorderEnd, Borders
from osm2xodr.model.elevation_report import ElevationReport
from osm2xodr.model.furniture import Furniture
from osm2xodr.model.shared import BoolArray, FloatArray, IntArray, LaneType, LocalFrame, Rule, freeze_arrays


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

    def at(self, ds: float) -> float:
        """Return the value at ds from its start."""
        return self.a + ds * (self.b + ds * (self.c + ds * self.d))

    def begun_later(self, ds: float, s: float) -> Cubic:
        """Return the same curve as a record that begins ds farther on, where s is counted as given."""
        return Cubic(
            s,
            self.at(ds),
            self.b + ds * (2 * self.c + 3 * ds * self.d),
            self.c + 3 * ds * self.d,
            self.d,
        )

    @property
    def is_flat(self) -> bool:
        """Whether it is a constant."""
        return self.b == self.c == self.d == 0.0


@dataclass(frozen=True, slots=True)
class RoadMark:
    """The mark on a lane's outer edge, in OpenDRIVE's words."""

    type: str
    color: str = "standard"
    width: float = 0.12
    lane_change: str = "none"
    material: str = "standard"


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
    height
        Of its surface above the road's, m.
    """

    id: int
    type: LaneType
    widths: tuple[Cubic, ...]
    predecessor: int | None = None
    successor: int | None = None
    road_mark: RoadMark | None = None
    speed: float | None = None
    height: float = 0.0


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
    guesses
        Codes of what had to be guessed about its ways, in ascending order.
    """

    id: int
    name: str
    junction: int | None
    predecessor: RoadLink | None
    successor: RoadLink | None
    types: tuple[RoadType, ...]
    lane_sections: tuple[LaneSection, ...]
    osm_way_ids: tuple[int, ...]
    guesses: tuple[str, ...] = ()


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
class StreetPlaces:
    """Where streets and their tagged nodes have gone in a `RoadMap`.

    Roads outside junctions run in the direction of the street that they were cut from.

    Parameters
    ----------
    road_street : (roads outside junctions,)
        Index of the street of the k-th road; these roads come first in `RoadMap.roads`.
    end_road : (2 x streets,)
        Id of the road that each street end became (2 k the start of street k, 2 k + 1 its end), -1 for none.
    end_junction : (2 x streets,)
        Id of the junction at each street end, also where the street lies inside it; -1 for none.
    inner : (streets,)
        Whether the street lies wholly inside a junction.
    node, street : (n,)
        Each place of a tagged node (`StreetNetwork.node_tags`) on a street: OSM id, index of the street.
    road : (n,)
        Id of the street's road that is nearest to the node, -1 where it has none.
    s, t : (n,)
        Where on that road the node is, m. s lies before 0 or beyond the road's length by how far the node lies off it
        in the junction there; NaN without a road.
    junction : (n,)
        Id of the junction that the node lies in, -1 for none.
    """

    road_street: IntArray
    end_road: IntArray
    end_junction: IntArray
    inner: BoolArray
    node: IntArray
    street: IntArray
    road: IntArray
    s: FloatArray
    t: FloatArray
    junction: IntArray

    def __post_init__(self) -> None:
        freeze_arrays(self)


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
    country
        ISO 3166-1 alpha-2 code; empty where it is in none.
    places
        Where streets have gone.
    furniture
        What stands on and beside the roads.
    borders
        Which areas the roads belong to, where the area is one of several side by side; the road map then holds its
        surroundings as well, until they are cut off.
    border_ends
        Where roads were cut off that go on in a neighbouring area; None where no surroundings were cut off.
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
    country: str = ""
    places: StreetPlaces | None = None
    furniture: Furniture = field(default_factory=Furniture)
    borders: Borders | None = None
    border_ends: tuple[BorderEnd, ...] | None = None
