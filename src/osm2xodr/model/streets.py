"""The result of osmParsing: streets, the things beside them, and what OSM says about points on and beside them.

Such points are signs, lights, crossings, stops and obstacles.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from enum import Enum

from osm2xodr.model.corrections import Corrections
from osm2xodr.model.shared import (
    CAR_LANES,
    Access,
    Direction,
    FloatArray,
    IntArray,
    LaneType,
    LocalFrame,
    ReadOnlyArrays,
    Rule,
    Structure,
)
from osm2xodr.system import record


@record
class LaneSpec:
    """One lane as OSM's tags describe it."""

    type: LaneType
    direction: Direction
    width: float  # m
    # The values of ``turn:lanes`` for it (``left``, ``through``, ``merge_to_right`` …); empty where OSM says nothing
    # or ``none``.
    turns: frozenset[str] = frozenset()
    # The value of ``change:lanes`` for it, left and right as its drivers see them; empty where OSM says nothing
    change: str = ""
    access: Access = Access.ALL  # Which cars may drive on a lane for cars
    speed: float | None = None  # Its own limit (``maxspeed:lanes``), m/s; None where that of its direction holds


@record
class MarginSpec:
    """A strip beside the carriageway as OSM's tags describe it."""

    # ``PARKING``, ``SHOULDER``, ``BIKING`` or ``SIDEWALK``; ``BORDER`` for verges and buffers between them
    type: LaneType
    width: float  # m
    direction: Direction = Direction.BOTH  # Of its traffic along the street; ``BOTH`` but for bicycles
    height: float = 0.0  # Of its surface above the carriageway, m


@record
class StructureTags:
    """What OSM says about a bridge or tunnel."""

    kind: str  # ``bridge`` or ``tunnel``, which includes galleries and passages through houses
    # Of a bridge, in OpenDRIVE's words: ``concrete``, ``steel``, ``brick``, ``wood``; empty where OSM does not say
    material: str = ""
    open_sides: bool = False  # Whether daylight comes in from a side, as in galleries
    lit: bool | None = None  # Whether there are lights; None where OSM does not say
    name: str = ""  # Its own, not the street's; empty where OSM gives none


@record
class StreetAttributes:
    """What the tags of one way say, in the direction of its street."""

    osm_way_id: int  # The way
    reversed: bool  # Whether the street runs against the order of the way's nodes
    highway: str  # OSM's values; empty where absent
    name: str
    ref: str
    lanes_ltr: tuple[LaneSpec, ...]  # All lanes from left to right, seen along the street
    # t of the middle of the lanes from the OSM line (left positive), m; 0 unless ``placement`` says otherwise, or
    # cars park on one side of a carriageway of known width more than on the other.
    middle_offset: float
    speed_forward: float | None  # m/s; None where unknown, infinity where there is no limit
    speed_backward: float | None  # Likewise
    structure: Structure  # What the street lies on
    layer: int  # OSM's ``layer``; 0 where absent, but 1 for bridges, -1 for tunnels
    grade: float | None  # Rise per metre along the street from ``incline``; None where OSM gives no number
    roundabout: bool  # Whether the way is part of a roundabout (``junction=roundabout`` or ``circular``)
    priority_road: bool = False  # Right of way unless tagged otherwise (``priority_road=designated``)
    # Strips beside the carriageway, from its edge outwards, left and right seen along the street. They are no part of
    # `lanes_ltr`, of the carriageway's width or of its middle.
    margin_left: tuple[MarginSpec, ...] = ()
    margin_right: tuple[MarginSpec, ...] = ()
    speed_signed: bool = False  # Whether ``maxspeed`` gives the limits, not the law, and they are known
    no_overtaking: frozenset[Direction] = frozenset()  # Directions along the street in which overtaking is forbidden
    marked: bool | None = None  # Whether lanes are marked (``lane_markings``); None where OSM does not say
    divider: str = ""  # OSM's value; empty where absent
    surface: str = ""  # OSM's value; empty where absent
    traffic_sign: str = ""  # OSM's value on the way; empty where absent
    speed_zone: bool = False  # Whether `traffic_sign` says that its limit is that of a zone
    tram: bool = False  # Whether tram tracks lie in the carriageway
    # Guessed limit, m/s, where `speed_forward` or `speed_backward` is unknown; None where there is no guess
    default_speed: float | None = None
    # More about the bridge or tunnel, if any. Galleries and passages through houses, where the street stays on the
    # ground, have it too.
    structure_tags: StructureTags | None = None
    max_height: float | None = None  # Height of vehicles that ``maxheight`` allows, m; None where it gives none
    # Height from road to road where others pass over or under it, m, by a correction; None where there is none
    clearance: float | None = None
    # How far `geometry` moves the lanes to the left, away from a parallel street, m
    moved_aside: float = 0.0

    def speed_along(self, direction: Direction) -> float | None:
        """Return the limit of a direction (of `BOTH`: of either), m/s, guessed where it is unknown."""
        known = None if direction is Direction.BACKWARD else self.speed_forward
        if known is None and direction is not Direction.FORWARD:
            known = self.speed_backward
        return self.default_speed if known is None else known

    @property
    def road(self) -> str:
        """What tells the road that it is part of from others: its name, else its number, else its class."""
        return self.name or self.ref or self.highway

    def car_directions(self) -> frozenset[Direction]:
        """Return the directions of cars along the street, those of all lanes if none is for cars.

        Lanes for bicycles or buses may run against a one-way street without making it a two-way street.
        """
        # Read more than a million times in a city.
        for_cars = {lane.direction for lane in self.lanes_ltr if lane.type in CAR_LANES}
        return frozenset(for_cars or {lane.direction for lane in self.lanes_ltr})


@record(eq=False)
class Street(ReadOnlyArrays):
    """A chain of pieces of ways between two intersections or dead ends."""

    id: int  # Its index in `StreetNetwork.streets`
    # Indices into `StreetNetwork.intersections`. A street may start and end at the same one; -1 at both ends marks a
    # closed ring without any intersection.
    start: int
    end: int
    points: FloatArray  # (n, 2) Local x, y of its nodes, m; no two in a row are closer than 1 mm; n >= 2
    node_ids: IntArray  # (n,) OSM ids of the nodes
    # (index of a node, attributes that hold from there on), in ascending order; the first index is 0
    pieces: tuple[tuple[int, StreetAttributes], ...]

    def place_of(self, node: int) -> int:
        """Return the index of a node by its OSM id; of the first place where it comes twice."""
        return int(self.node_ids.tolist().index(node))

    def attributes_at(self, place: int) -> StreetAttributes:
        """Return the attributes from the node at an index on (at the last node: up to it)."""
        return next(item for first, item in reversed(self.pieces) if first <= place)

    def attributes_at_end(self, end: int) -> StreetAttributes:
        """Return the attributes at a street end, by its number: that of an end is odd, that of a start even."""
        return self.pieces[-1 if end % 2 else 0][1]


@record
class Intersection:
    """A node where streets meet or end. Dead ends are intersections of one street end."""

    id: int  # Its index in `StreetNetwork.intersections`
    osm_node_id: int  # The node
    x: float  # Local position, m
    y: float  # Likewise
    # The street ends that meet here: (street id, True if it is the street's start)
    arms: tuple[tuple[int, bool], ...]


@record
class TurnRestriction:
    """A restriction relation that applies to cars at all times."""

    osm_relation_id: int  # The relation
    only: bool  # True for ``only_*``, False for ``no_*``
    value: str  # OSM's value, e.g. ``no_left_turn``.
    from_ways: tuple[int, ...]  # OSM way ids
    via_node: int | None  # OSM node id, or None where the via members are ways
    via_ways: tuple[int, ...]  # OSM way ids in the relation's order; empty with a via node
    # OSM way ids; none where the only way on (``only_*``) lies outside of the area or is left out
    to_ways: tuple[int, ...]


@record
class LaneConnectivity:
    """A ``connectivity`` relation: which lane of one way leads to which lane of another.

    Lanes count as in the relation: from 1 at the left as their drivers see them, those of the direction of travel
    only.
    """

    osm_relation_id: int  # The relation
    # from_way, to_way: OSM way ids
    from_way: int
    via_node: int | None  # OSM node id, or None where the via members are ways
    via_ways: tuple[int, ...]  # OSM way ids in the relation's order; empty with a via node
    to_way: int
    # (lane of the from way, lane of the to way, whether the link is optional, that is in brackets)
    lanes: tuple[tuple[int, int, bool], ...]


class RoadsideKind(str, Enum):
    """Kinds of things beside the road."""

    TREE = "tree"
    STREET_LAMP = "street_lamp"
    BUS_STOP = "bus_stop"
    GUARD_RAIL = "guard_rail"
    WALL = "wall"
    FENCE = "fence"
    HEDGE = "hedge"
    BOLLARD = "bollard"
    KERB = "kerb"
    ISLAND = "island"
    TRAM_TRACK = "tram_track"
    TRAFFIC_SIGN = "traffic_sign"
    TRAFFIC_SIGNALS = "traffic_signals"


@record(eq=False)
class RoadsideThing(ReadOnlyArrays):
    """A node or way beside the road that may become an object or a sign."""

    kind: RoadsideKind  # What it is
    osm_id: str  # ``node/1`` or ``way/2``
    points: FloatArray  # (n, 2) Local x, y, m; one for a node
    node_ids: IntArray  # (n,) OSM ids of the nodes
    facts: ThingFacts  # What else OSM says about it


@record(eq=False)
class Footway(ReadOnlyArrays):
    """A way for pedestrians (or bicycles) that OSM maps separately from the street."""

    osm_way_id: int  # The way
    crossing: bool  # Whether it crosses a street (``footway=crossing``, ``path=crossing``, ``cycleway=crossing``)
    points: FloatArray  # (n, 2) Local x, y, m
    node_ids: IntArray  # (n,) OSM ids of the nodes
    tags: Mapping[str, str]  # Those that matter to stage 1


@record
class NodeFacts:
    """What OSM says about the nodes on streets, by subject and OSM node id, in ascending id."""

    controls: Mapping[int, NodeControl] = field(default_factory=dict)
    sign_posts: Mapping[int, SignPost] = field(default_factory=dict)
    crossings: tuple[MappedCrossing, ...] = ()
    calming: Mapping[int, str] = field(default_factory=dict)  # What calms traffic, one word
    bus_stops: Mapping[int, BusStop] = field(default_factory=dict)
    track_crossings: frozenset[int] = frozenset()  # Where railways or trams cross
    rail_crossings: Mapping[int, RailCrossing] = field(default_factory=dict)  # Where railways do, no trams
    mini_roundabouts: frozenset[int] = frozenset()  # Junctions whose traffic goes round a painted middle


@record(eq=False)
class StreetNetwork:
    """All streets of an area as the OSM file describes them."""

    frame: LocalFrame
    rule: Rule
    country: str  # ISO 3166-1 alpha-2 code of the country of the frame's origin; empty outside of all countries
    streets: tuple[Street, ...]
    intersections: tuple[Intersection, ...]
    restrictions: tuple[TurnRestriction, ...]
    # Tags of the tagged nodes on streets by OSM node id (signals, stop lines, crossings …)
    node_tags: Mapping[int, Mapping[str, str]]
    bounds_deg: tuple[float, float, float, float]  # West, south, east, north of the streets' nodes, degrees, WGS 84
    connectivities: tuple[LaneConnectivity, ...] = ()
    footways: tuple[Footway, ...] = ()  # Footways within reach of a street, in ascending id
    roadside: tuple[RoadsideThing, ...] = ()  # Things within reach of a street, in ascending kind and id
    node_facts: NodeFacts = field(default_factory=NodeFacts)  # What `node_tags` and `footways` mean
    node_heights: Mapping[int, float] = field(default_factory=dict)  # What ``ele`` gives, m, by OSM node id
    # Turning circles by OSM node id: diameter of the carriageway, m, None where OSM gives none that can be read
    turning_circles: Mapping[int, float | None] = field(default_factory=dict)
    corrections: Corrections = field(default_factory=Corrections)  # What the user knows better; tags have theirs


class Sign(str, Enum):
    """What regulates the traffic that comes to a street's end, in OSM's words."""

    STOP = "stop"
    GIVE_WAY = "give_way"
    SIGNALS = "traffic_signals"


class Light(str, Enum):
    """The purpose of traffic lights on a node."""

    JUNCTION = "junction"
    CROSSING = "crossing"
    ROAD = "road"  # Apart from junctions and crossings: ramp meters, tunnels, fire stations
    OTHER = "other"  # Lights that never show green to cars: blinkers, level crossings


@record
class Facing:
    """Which traffic something on a street is for, as ``direction`` says; nothing is set where it does not say."""

    along: bool | None = None  # Whether for traffic along the way (``forward``), else against it
    both: bool = False  # Whether for both directions
    azimuth_deg: float | None = None  # Where it looks, degrees clockwise from north


@record
class NodeControl:
    """A stop or give-way sign or traffic lights on a node of a street."""

    tagged: Sign | None  # The value of ``highway``; None for crossings with lights
    light: Light | None  # The purpose of its lights; None where it has none
    facing: Facing = Facing()
    all_way: bool = False  # Whether all arms of its junction have to stop
    crossing_lights: bool = False  # Whether ``crossing=traffic_signals``
    light_value: str = ""  # OSM's value of ``traffic_signals``; empty where absent

    @property
    def sign(self) -> Sign | None:
        """What regulates traffic here; None for lights that are not those of a junction or crossing."""
        if self.tagged in (Sign.STOP, Sign.GIVE_WAY):
            return self.tagged
        return Sign.SIGNALS if self.light in (Light.JUNCTION, Light.CROSSING) else None


@record
class SignFace:
    """One traffic sign or plate."""

    meaning: str  # A key of ``conventions/sign_codes.json``; empty where it is not known
    country: str = ""  # As tagged; empty where OSM says it in words
    code: str = ""  # Likewise
    value: float | None = None  # What is written on it: a speed, a height …; None where nothing is
    unit: str = ""  # Of the value; empty where none is
    text: str = ""  # Further words on it
    supplementary: bool = False  # Whether it adds to the sign above it
    osm_id: str = ""  # The element that it comes from, where that is another one than its pole's


@record
class FacingSigns:
    """Signs on a node that are for the same traffic, from the top down; plates follow their sign."""

    facing: Facing
    faces: tuple[SignFace, ...]


@record
class SignPost:
    """A node with traffic signs."""

    signs: tuple[FacingSigns, ...]  # What ``traffic_sign`` says, by direction; may name no sign at all
    facing: Facing = Facing()  # The direction of the whole post
    control: Sign | None = None  # ``STOP`` or ``GIVE_WAY`` where ``highway`` says so as well
    city_limit: str = ""  # OSM's value: ``begin``, ``end``, ``both``; empty where absent


@record
class BusStop:
    """A bus stop on a street or beside it."""

    name: str = ""  # Empty where absent
    bay: bool = False  # Whether buses stop in a bay
    along: bool | None = None  # Whether its buses run along the way, else against it; None where OSM does not say


@record
class MappedCrossing:
    """A node where people cross a street, and the way that they take, if OSM has it."""

    node: int  # OSM id
    heading: float | None = None  # Of the way that crosses, rad; None for a node alone
    lights: bool = False  # Whether it has traffic lights
    island: bool = False  # Whether people can wait in its middle
    marking: str = "unmarked"  # What is painted, in the words of ``crossing:markings``; ``yes`` for any kind
    width: float | None = None  # Extent along the road, m; None where OSM gives no plausible one
    width_tagged: bool = False  # Whether OSM gives a width, plausible or not


@record
class RailCrossing:
    """What stands where a street crosses a railway on its level."""

    sign: bool = True  # Whether St. Andrew's crosses stand there: everywhere unless OSM says no
    lights: bool = False  # Whether there are lights
    barriers: str = ""  # ``half`` or ``full`` for the part of the road that they close; empty for none


@record
class ThingFacts:
    """What OSM says about a thing beside the road, as far as it matters to its kind; None where it does not say."""

    width: float | None = None  # Of what stands or runs beside the road, m
    height: float | None = None  # Likewise
    gauge: float | None = None  # Of a tram track, m
    bus_stop: BusStop | None = None  # Of bus stops
    sign_post: SignPost | None = None  # Of traffic signs
    at_crossing: bool = False  # Of traffic lights: whether people cross there
