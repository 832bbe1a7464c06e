"""What all parts of this stage work with: the network, its roads, and the types that the parts exchange."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import count
from typing import Final

import numpy as np

from osm2xodr.curves import CurveFinder, cosine, hypot, pose, project, sine
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.furniture.options import FurnitureOptions
from osm2xodr.furniture.world.lane_table import LaneTable, NodePlaces
from osm2xodr.model import (
    FloatArray,
    IntArray,
    PlanView,
    RoadMap,
    RoadObject,
    Street,
    StreetAttributes,
    StreetNetwork,
    StreetPlaces,
)
from osm2xodr.system import record

# Shorter remainders of a piece of a street at a road's end are dropped, m.
_SHORTEST_PIECE: Final = 0.5


class Ids:
    """Counts ids from 1: `thing` those of signals and objects, `controller` those of controllers."""

    def __init__(self) -> None:
        self.thing: Callable[[], int] = count(1).__next__
        self.controller: Callable[[], int] = count(1).__next__


@dataclass(frozen=True, eq=False)
class World:
    """Streets and roads before furniture is placed."""

    network: StreetNetwork  # The streets
    road_map: RoadMap  # The roads made from them
    places: StreetPlaces  # Where these lie
    lanes: LaneTable  # Looks up lanes
    options: FurnitureOptions  # What the user chose
    diagnostics: Diagnostics  # Gets what is guessed, and what is dropped and why
    ids: Ids = field(default_factory=Ids)

    def object_at(self, road: int, words: tuple[str, str, str], s: float, t: float, osm_id: str) -> RoadObject:
        """Return an object without size; words are OpenDRIVE's type and subtype, and a name."""
        return RoadObject(self.ids.thing(), road, *words, s, t, osm_id=osm_id)

    @cached_property
    def nodes(self) -> NodePlaces:
        """Finds the places of nodes of streets."""
        return NodePlaces(self.network, self.road_map, self.places, self.lanes)

    @cached_property
    def outside_junctions(self) -> CurveFinder:
        """Finds roads outside junctions, which come first."""
        return CurveFinder(self.road_map.plan_view, np.arange(len(self.places.road_street)))

    @cached_property
    def in_junctions(self) -> CurveFinder:
        """Finds connecting roads."""
        outside = len(self.places.road_street)
        return CurveFinder(self.road_map.plan_view, np.arange(outside, len(self.road_map.roads)))

    @cached_property
    def piece_starts(self) -> dict[int, list[float]]:
        """Where pieces of streets but the first begin along the roads of streets with several, by road id, m."""
        streets = [self.network.streets[k] for k in self.places.road_street.tolist()]
        roads = [k for k, street in enumerate(streets) if len(street.pieces) > 1]
        if not roads:
            return {}
        points = [streets[k].points[[first for first, _ in streets[k].pieces[1:]]] for k in roads]
        count = [len(places) for places in points]
        x, y = np.concatenate(points).T
        s, _, _ = project(self.road_map.plan_view, np.repeat(roads, count), x, y)
        at = np.split(s, np.cumsum(count)[:-1])
        return {self.road_map.roads[k].id: places.tolist() for k, places in zip(roads, at, strict=True)}

    @cached_property
    def footway_nodes(self) -> frozenset[int]:
        """OSM ids of the nodes of ways for people on foot or bicycles."""
        return frozenset(node for way in self.network.footways for node in way.node_ids.tolist())


@record
class Crossing:
    """A crossing for people on foot, placed on a road."""

    road: int  # Id of the road, a connecting road in a junction
    s: float  # Of its middle, m
    width: float  # Extent along the road, m
    left: float  # t of its left end, m
    right: float  # t of its right end, m
    osm_id: str  # The node that it comes from
    signals: bool  # Whether it has lights
    at_start: bool = False  # Whether it lies at the junction at the road's start, and traffic stops before it
    at_end: bool = False  # The same of its end
    # What is painted: OSM's value of ``crossing:markings``, ``unmarked`` where there is nothing
    marking: str = "unmarked"
    island: bool = False  # Whether people can wait in its middle
    skew: float = 0.0  # How far it leads on along the road for each metre to the left
    junction: int = -1  # Id of the junction in which it lies, -1 for none
    # Id of the road outside junctions on whose course it lies, and s there, m, beyond the road's ends; None where
    # that is the road on which it lies
    arm: tuple[int, float] | None = None

    @property
    def on_course(self) -> tuple[int, float]:
        """The road outside junctions on whose course it lies, by id, and s there, m."""
        return (self.road, self.s) if self.arm is None else self.arm


@record
class Movement:
    """One way through a junction."""

    connecting_road: int  # Id
    entry_lane: int  # Lane of the approach's road
    exit_road: int  # Id of the road that it leads to
    exit_at_start: bool  # Whether onto its start
    exit_lane: int  # The lane there
    turn: float  # Change of heading, rad, left positive


@record
class Approach:
    """A road end at which cars come to a junction."""

    road: int  # Id
    at_end: bool  # Whether traffic comes to its end (along s), else to its start
    junction: int  # Id of the junction
    street_end: int  # As in `StreetPlaces.end_road`
    # Ids of the lanes for cars that lead into the junction, from left to right as their drivers see them
    lanes: tuple[int, ...]
    # The ways through the junction from these lanes, in the order of connecting roads
    movements: tuple[Movement, ...]
    stop_s: float  # s of the stop line's edge that is nearer to the junction, m

    @property
    def orientation(self) -> str:
        """OpenDRIVE's word for the direction of its traffic."""
        return "+" if self.at_end else "-"


@record
class Stop:
    """A place where traffic stops or yields, which gets a line across its lanes."""

    road: int  # Id
    s: float  # Of the edge of the line on the far side for its traffic, m
    lanes: tuple[int, ...]  # Ids of the lanes that it crosses
    orientation: str  # Of the traffic, as in OpenDRIVE
    kind: str  # ``traffic_signals``, ``stop`` or ``give_way``
    osm_id: str  # What it comes from


def points_beside(
    plan: PlanView, curve: IntArray, s: FloatArray, t: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y, m, at s and t of curves, and the heading of the curve there, rad, all (n,)."""
    x, y, hdg = pose(plan, curve, s)
    return x - t * sine(hdg), y + t * cosine(hdg), hdg


def outline(
    world: World, road: int, s: float, t: float, corners: Sequence[tuple[float, float]], height: float = 0.0
) -> tuple[tuple[float, float, float, float], ...]:
    """Return the corners (s, t) of an object at s, t of a road in its own frame: u, v, z, height, m.

    u runs along the road at the object, v to its left. z is 0: the frame leans with the road, as CARLA 0.9.16 reads
    it (corners on roads of 10 % are then 0.01 m off; with heights of their own they are 0.2 m off).
    """
    at, lateral = np.array([(s, t), *corners]).T
    curve = np.full(len(at), world.lanes.index(road), np.int64)
    x, y, hdg = points_beside(world.road_map.plan_view, curve, at, lateral)
    dx, dy = x[1:] - x[0], y[1:] - y[0]
    u = dx * cosine(hdg[0]) + dy * sine(hdg[0])
    v = dy * cosine(hdg[0]) - dx * sine(hdg[0])
    return tuple((a, b, 0.0, height) for a, b in zip(u.tolist(), v.tolist(), strict=True))


def pieces_on_road(world: World, street: Street, road: int) -> list[tuple[float, float, StreetAttributes]]:
    """Return (start, end, attributes) of the pieces of a street along one of its roads, in ascending s, m."""
    length = world.lanes.length(road)
    pieces = street.pieces
    if len(pieces) == 1:
        return [(0.0, length, pieces[0][1])]
    bounds = [0.0, *world.piece_starts[road], length]
    found = [
        (bounds[k], bounds[k + 1], attributes)
        for k, (_, attributes) in enumerate(pieces)
        if bounds[k + 1] - bounds[k] > min(_SHORTEST_PIECE, 0.5 * length)
    ]
    return found or [(0.0, length, pieces[0][1])]


def way_at(street: Street, x: float, y: float) -> StreetAttributes:
    """Return the attributes of the part of a street that is nearest to a point, m."""
    return street.attributes_at(nearest_segment(np.array([x, y]), street.points[:-1], street.points[1:])[0])


def nearest_segment(point: FloatArray, start: FloatArray, end: FloatArray) -> tuple[int, float]:
    """Return the index of the line segment nearest to a point (2,), and its distance, m; segments are (n, 2)."""
    step = end - start
    share = np.clip(((point - start) * step).sum(1) / np.maximum((step * step).sum(1), 1e-12), 0.0, 1.0)
    distance = hypot(*(point - start - share[:, None] * step).T)
    k = int(np.argmin(distance))
    return k, float(distance[k])
