"""What all parts of this stage work with: the network, the roads, and the contracts between the parts."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from itertools import count

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.furniture.options import FurnitureOptions
from osm2xodr.furniture.world.lane_table import LaneTable
from osm2xodr.furniture.world.node_places import NodePlaces
from osm2xodr.model import RoadMap, StreetNetwork, StreetPlaces


class Ids:
    """Hands out ids above 0: one range for signals and objects, one for controllers."""

    def __init__(self) -> None:
        self._things = count(1)
        self._controllers = count(1)

    def thing(self) -> int:
        """Return the next id of a signal or object."""
        return next(self._things)

    def controller(self) -> int:
        """Return the next id of a controller."""
        return next(self._controllers)


@dataclass(frozen=True, eq=False)
class World:
    """What is there before furniture is placed."""

    # The streets, the roads that they became, and where
    network: StreetNetwork
    road_map: RoadMap
    places: StreetPlaces
    lanes: LaneTable  # Looks up lanes
    options: FurnitureOptions  # What the user chose
    diagnostics: Diagnostics  # Gets what is dropped and why
    ids: Ids = field(default_factory=Ids)  # Hands out ids

    @cached_property
    def nodes(self) -> NodePlaces:
        """Finds the places of nodes of streets."""
        return NodePlaces(self.network, self.road_map, self.places, self.lanes)

    @cached_property
    def footway_nodes(self) -> frozenset[int]:
        """OSM ids of the nodes of ways for people on foot or bicycles."""
        return frozenset(node for way in self.network.footways for node in way.node_ids.tolist())


@dataclass(frozen=True, slots=True)
class Crossing:
    """A crossing for people on foot, placed on a road."""

    # Its middle, m
    road: int
    s: float
    width: float  # Extent along the road, m
    # t of its ends, m
    left: float
    right: float
    osm_id: str  # The node (or way) that it comes from
    signals: bool  # Whether it has lights
    # Whether it lies at the junction at the road's start or end, so that traffic stops before it there
    at_start: bool = False
    at_end: bool = False
    # What is painted: OSM's value of ``crossing:markings``, ``unmarked`` where there is nothing
    marking: str = "unmarked"
    island: bool = False  # Whether people can wait in its middle


@dataclass(frozen=True, slots=True)
class Movement:
    """One way through a junction: its connecting road, the lane that it begins at, where it leads, its turn."""

    # Id of the connecting road, lane of the approach's road
    connecting_road: int
    entry_lane: int
    # The road that it leads to, whether onto its start, and the lane there
    exit_road: int
    exit_at_start: bool
    exit_lane: int
    turn: float  # Change of heading, rad, left positive


@dataclass(frozen=True, slots=True)
class Approach:
    """A road end at which cars come to a junction."""

    # The road, and whether traffic comes to its end (along s) or to its start
    road: int
    at_end: bool
    junction: int  # Id of the junction
    street_end: int  # As in `StreetPlaces.end_road`
    # Ids of the lanes for cars that lead into the junction, from left to right as their drivers see them
    lanes: tuple[int, ...]
    # The ways through the junction from these lanes, in the order of connecting roads
    movements: tuple[Movement, ...]
    stop_s: float  # Where the edge of the stop line that is nearer to the junction lies, s, m

    @property
    def orientation(self) -> str:
        """OpenDRIVE's word for the direction of its traffic."""
        return "+" if self.at_end else "-"


@dataclass(frozen=True, slots=True)
class Stop:
    """A place where traffic stops or yields, which gets a line across its lanes."""

    # Edge of the line that is nearer to what traffic stops for, m
    road: int
    s: float
    lanes: tuple[int, ...]  # Ids of the lanes that it crosses
    orientation: str  # Of the traffic, as in OpenDRIVE
    kind: str  # ``traffic_signals``, ``stop`` or ``give_way``
    osm_id: str  # What it comes from
