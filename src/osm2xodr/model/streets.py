"""What osmParsing hands on: streets, and what lies beside them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from osm2xodr.model.shared import (
    Direction,
    FloatArray,
    IntArray,
    LaneType,
    LocalFrame,
    Rule,
    Structure,
    freeze_arrays,
)


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
    change
        The value of ``change:lanes`` for it, left and right as its drivers see them; empty where OSM says nothing.
    """

    type: LaneType
    direction: Direction
    width: float
    turns: frozenset[str] = frozenset()
    change: str = ""


@dataclass(frozen=True, slots=True)
class MarginSpec:
    """A strip beside the carriageway as OSM's tags describe it.

    Parameters
    ----------
    type
        ``PARKING``, ``SHOULDER``, ``BIKING`` or ``SIDEWALK``; ``BORDER`` for what lies between (verges, buffers).
    width
        m.
    direction
        Which way along the street traffic on it runs; ``BOTH`` for all but bicycles.
    height
        Of its surface above the carriageway, m.
    """

    type: LaneType
    width: float
    direction: Direction = Direction.BOTH
    height: float = 0.0


@dataclass(frozen=True, slots=True)
class StructureTags:
    """What OSM says about what a street leads over or through.

    Parameters
    ----------
    kind
        ``bridge``, or ``tunnel``, which galleries and passages through houses are as well.
    material
        Of a bridge, in OpenDRIVE's words: ``concrete``, ``steel``, ``brick``, ``wood``; empty where OSM does not say.
    open_sides
        Whether daylight comes in from a side, as in galleries.
    lit
        Whether there are lights; None where OSM does not say.
    name
        Its own, not the street's; empty where OSM gives none.
    """

    kind: str
    material: str = ""
    open_sides: bool = False
    lit: bool | None = None
    name: str = ""


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
        t of the middle of the lanes off the OSM line (left positive), m; 0 unless ``placement`` says otherwise, or
        cars park on a carriageway of known width on one side more than on the other.
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
    margin_left, margin_right
        What lies beside the carriageway, from its edge outwards, left and right seen along the street. It is no part
        of `lanes_ltr`, of the carriageway's width or of its middle.
    speed_signed
        Whether the limits stand in ``maxspeed`` itself; else they follow from the law or are unknown.
    no_overtaking
        Directions along the street in which overtaking is forbidden.
    marked
        Whether lanes are marked (``lane_markings``); None where OSM does not say.
    divider
        OSM's value; empty where absent.
    surface
        OSM's value; empty where absent.
    traffic_sign
        OSM's value on the way; empty where absent.
    tram
        Whether tram tracks lie in the carriageway.
    structure_tags
        More about the bridge or tunnel; None where there is none. Galleries and passages through houses, which leave
        the street on the ground, have it too.
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
    margin_left: tuple[MarginSpec, ...] = ()
    margin_right: tuple[MarginSpec, ...] = ()
    speed_signed: bool = False
    no_overtaking: frozenset[Direction] = frozenset()
    marked: bool | None = None
    divider: str = ""
    surface: str = ""
    traffic_sign: str = ""
    tram: bool = False
    structure_tags: StructureTags | None = None

    def car_directions(self) -> frozenset[Direction]:
        """Return which ways cars run along the street; those of all lanes where none is for cars.

        Lanes for bicycles or buses alone may run against a one-way street; they do not make it a two-way one.
        """
        for_cars = [lane for lane in self.lanes_ltr if lane.type in (LaneType.DRIVING, LaneType.BIDIRECTIONAL)]
        return frozenset(lane.direction for lane in for_cars or self.lanes_ltr)


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

    def attributes_at(self, place: int) -> StreetAttributes:
        """Return what holds from the node at an index on (at the last node: up to it)."""
        return next(item for first, item in reversed(self.pieces) if first <= place)


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


class RoadsideKind(str, Enum):
    """What a thing beside the road is."""

    TREE = "tree"
    STREET_LAMP = "street_lamp"
    BUS_STOP = "bus_stop"
    GUARD_RAIL = "guard_rail"
    WALL = "wall"
    FENCE = "fence"
    HEDGE = "hedge"
    BOLLARD = "bollard"
    KERB = "kerb"
    TRAM_TRACK = "tram_track"
    TRAFFIC_SIGN = "traffic_sign"
    TRAFFIC_SIGNALS = "traffic_signals"


@dataclass(frozen=True, slots=True, eq=False)
class RoadsideThing:
    """A node or way beside the road that may become an object or a sign.

    Parameters
    ----------
    kind
        What it is.
    osm_id
        ``node/1`` or ``way/2``.
    points : (n, 2)
        Local x, y, m; one for a node.
    node_ids : (n,)
        OSM ids of the nodes.
    tags
        Those that matter to its kind.
    """

    kind: RoadsideKind
    osm_id: str
    points: FloatArray
    node_ids: IntArray
    tags: Mapping[str, str]

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True, slots=True, eq=False)
class Footway:
    """A way for people on foot (or bicycles) that OSM maps apart from the street.

    Parameters
    ----------
    osm_way_id
        The way.
    crossing
        Whether it crosses a street (``footway=crossing``, ``path=crossing``, ``cycleway=crossing``).
    points : (n, 2)
        Local x, y, m.
    node_ids : (n,)
        OSM ids of the nodes.
    tags
        Those that matter.
    """

    osm_way_id: int
    crossing: bool
    points: FloatArray
    node_ids: IntArray
    tags: Mapping[str, str]

    def __post_init__(self) -> None:
        freeze_arrays(self)


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
    footways
        Footways within reach of a street, in ascending id.
    roadside
        Things within reach of a street, in ascending kind and id.
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
    footways: tuple[Footway, ...] = ()
    roadside: tuple[RoadsideThing, ...] = ()
