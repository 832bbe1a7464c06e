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
    """What is there before furniture is placed.

    Parameters
    ----------
    network, road_map, places
        The streets, the roads that they became, and where.
    lanes
        Looks up lanes.
    options
        What the user chose.
    diagnostics
        Gets what is dropped and why.
    ids
        Hands out ids.
    """

    network: StreetNetwork
    road_map: RoadMap
    places: StreetPlaces
    lanes: LaneTable
    options: FurnitureOptions
    diagnostics: Diagnostics
    ids: Ids = field(default_factory=Ids)

    @cached_property
    def nodes(self) -> NodePlaces:
        """Finds the places of nodes of streets."""
        return NodePlaces(self.network, self.road_map, self.places, self.lanes)


@dataclass(frozen=True, slots=True)
class Crossing:
    """A crossing for people on foot, placed on a road.

    Parameters
    ----------
    road, s
        Its middle, m.
    width
        Extent along the road, m.
    left, right
        t of its ends, m.
    osm_id
        The node (or way) that it comes from.
    signals
        Whether it has lights.
    at_start, at_end
        Whether it lies at the junction at the road's start or end, so that traffic stops before it there.
    marking
        What is painted: OSM's value of ``crossing:markings``, ``unmarked`` where there is nothing.
    island
        Whether people can wait in its middle.
    """

    road: int
    s: float
    width: float
    left: float
    right: float
    osm_id: str
    signals: bool
    at_start: bool = False
    at_end: bool = False
    marking: str = "unmarked"
    island: bool = False


@dataclass(frozen=True, slots=True)
class Movement:
    """One way through a junction: its connecting road, the lane that it begins at, where it leads, its turn.

    Parameters
    ----------
    connecting_road, entry_lane
        Id of the connecting road, lane of the approach's road.
    exit_road, exit_at_start, exit_lane
        The road that it leads to, whether onto its start, and the lane there.
    turn
        Change of heading, rad, left positive.
    """

    connecting_road: int
    entry_lane: int
    exit_road: int
    exit_at_start: bool
    exit_lane: int
    turn: float


@dataclass(frozen=True, slots=True)
class Approach:
    """A road end at which cars come to a junction.

    Parameters
    ----------
    road, at_end
        The road, and whether traffic comes to its end (along s) or to its start.
    junction
        Id of the junction.
    street_end
        As in `StreetPlaces.end_road`.
    lanes
        Ids of the lanes for cars that lead into the junction, from left to right as their drivers see them.
    movements
        The ways through the junction from these lanes, in the order of connecting roads.
    stop_s
        Where the edge of the stop line that is nearer to the junction lies, s, m.
    """

    road: int
    at_end: bool
    junction: int
    street_end: int
    lanes: tuple[int, ...]
    movements: tuple[Movement, ...]
    stop_s: float

    @property
    def orientation(self) -> str:
        """OpenDRIVE's word for the direction of its traffic."""
        return "+" if self.at_end else "-"


@dataclass(frozen=True, slots=True)
class Stop:
    """A place where traffic stops or yields, which gets a line across its lanes.

    Parameters
    ----------
    road, s
        Edge of the line that is nearer to what traffic stops for, m.
    lanes
        Ids of the lanes that it crosses.
    orientation
        Of the traffic, as in OpenDRIVE.
    kind
        ``traffic_signals``, ``stop`` or ``give_way``.
    osm_id
        What it comes from.
    """

    road: int
    s: float
    lanes: tuple[int, ...]
    orientation: str
    kind: str
    osm_id: str
