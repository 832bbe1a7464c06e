"""What OSM says about points on streets and beside them: signs, lights, crossings, stops and obstacles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum


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


@dataclass(frozen=True, slots=True)
class Facing:
    """Which traffic something on a street is for, as ``direction`` says; nothing is set where it does not say."""

    along: bool | None = None  # Whether for traffic along the way (``forward``), else against it
    both: bool = False  # Whether for both directions
    azimuth_deg: float | None = None  # Where it looks, degrees clockwise from north


@dataclass(frozen=True, slots=True)
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


@dataclass(frozen=True, slots=True)
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


@dataclass(frozen=True, slots=True)
class FacingSigns:
    """Signs on a node that are for the same traffic, from the top down; plates follow their sign."""

    facing: Facing
    faces: tuple[SignFace, ...]


@dataclass(frozen=True, slots=True)
class SignPost:
    """A node with traffic signs."""

    signs: tuple[FacingSigns, ...]  # What ``traffic_sign`` says, by direction; may name no sign at all
    facing: Facing = Facing()  # The direction of the whole post
    control: Sign | None = None  # ``STOP`` or ``GIVE_WAY`` where ``highway`` says so as well
    city_limit: str = ""  # OSM's value: ``begin``, ``end``, ``both``; empty where absent


@dataclass(frozen=True, slots=True)
class BusStop:
    """A bus stop on a street or beside it."""

    name: str = ""  # Empty where absent
    bay: bool = False  # Whether buses stop in a bay
    along: bool | None = None  # Whether its buses run along the way, else against it; None where OSM does not say


@dataclass(frozen=True, slots=True)
class MappedCrossing:
    """A node where people cross a street, and the way that they take, if OSM has it."""

    node: int  # OSM id
    heading: float | None = None  # Of the way that crosses, rad; None for a node alone
    lights: bool = False  # Whether it has traffic lights
    island: bool = False  # Whether people can wait in its middle
    marking: str = "unmarked"  # What is painted, in the words of ``crossing:markings``; ``yes`` for any kind
    width: float | None = None  # Extent along the road, m; None where OSM gives no plausible one
    width_tagged: bool = False  # Whether OSM gives a width, plausible or not


@dataclass(frozen=True, slots=True)
class RailCrossing:
    """What stands where a street crosses a railway on its level."""

    sign: bool = True  # Whether St. Andrew's crosses stand there: everywhere unless OSM says no
    lights: bool = False  # Whether there are lights
    barriers: str = ""  # ``half`` or ``full`` for the part of the road that they close; empty for none


@dataclass(frozen=True, slots=True)
class ThingFacts:
    """What OSM says about a thing beside the road, as far as it matters to its kind; None where it does not say."""

    width: float | None = None  # Of what stands or runs beside the road, m
    height: float | None = None  # Likewise
    gauge: float | None = None  # Of a tram track, m
    bus_stop: BusStop | None = None  # Of bus stops
    sign_post: SignPost | None = None  # Of traffic signs
    at_crossing: bool = False  # Of traffic lights: whether people cross there


@dataclass(frozen=True, slots=True)
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
