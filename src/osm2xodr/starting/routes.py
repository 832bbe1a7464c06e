"""Cars with a way to go each, that do not meet: an ego and others around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.curves import sorted_unique
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.starting.lanes import LaneNetwork, Path, path_along
from osm2xodr.starting.motion import Motion, Programme, lights_on, plan_motion

# How long a way should be, m: about what a car covers at 50 km/h while it is watched.
_WAY: Final = 1_200.0
# A car sets out on a lane at least so long, so far from its begin, and at most so far from its end, m.
_ROOM: Final = 25.0
_FIRST: Final = 10.0
_LAST: Final = 60.0
# esmini 3.6 finds the way from one waypoint to the next among the 100 nearest roads (`RoadPath::Calculate`), and may
# count those for people.
_MOST_ROADS: Final = 50
# How many places are tried for the ego, and for all others.
_EGO_TRIES: Final = 48
_OTHER_TRIES: Final = 160
# The middles of cars are never nearer to each other than this, m: a length and a gap.
_APART: Final = 8.0
# When others set out, s, and how far they come at least, m: the first choices are those that leave most to see.
_CHOICES: Final = ((0.0, 300.0), (10.0, 200.0), (20.0, 150.0), (30.0, 100.0), (0.0, 0.0), (40.0, 0.0))
# How often their distance is looked at, s: at 100 km/h a car comes 7 m on.
_LOOK: Final = 0.25
# A light on the way is worth as much as this length of it, m, and a turn through a junction as that.
_LIGHT_WORTH: Final = 400.0
_TURN_WORTH: Final = 40.0


@dataclass(frozen=True, eq=False)
class Car:
    """A car, the way that it takes, and how it goes along it."""

    path: Path
    motion: Motion
    lights: int  # How many are on its way


def choose_cars(network: LaneNetwork, programmes: list[Programme], count: int, seconds: float) -> list[Car]:
    """Return up to `count` cars that do not meet for a while, s; the first one is the ego."""
    places = _places(network)
    if not len(places):
        return []
    tried = places[np.unique(np.linspace(0, len(places) - 1, _EGO_TRIES).round().astype(np.int64))]
    cars = [_car(network, programmes, int(node)) for node in tried]
    ego = max(cars, key=_worth)
    around = _around(network, places, ego)
    times = np.arange(0.0, seconds, _LOOK)
    chosen, taken = [ego], [ego.path.at(ego.motion.distance(times))]
    for delay, least in _CHOICES:
        for node in around if len(chosen) < count else ():
            car = _car(network, programmes, node, delay)
            where = car.path.at(car.motion.distance(times))
            moves = float(car.motion.distance(times[-1:])[0]) >= least
            if moves and all(np.hypot(*(where - other).T).min() > _APART for other in taken):
                chosen.append(car)
                taken.append(where)
            if len(chosen) == count:
                break
    return chosen


def _places(network: LaneNetwork) -> IntArray:
    """Return the nodes at the ends of roads outside of junctions on which there is room to set out."""
    leaves = np.zeros(len(network.length), np.bool_)
    leaves[network.start[network.road[network.start] != network.road[network.end]]] = True
    nodes = network.nodes[~network.in_junction[network.nodes]]
    long: IntArray = nodes[network.length[nodes] >= _ROOM]
    at_ends: IntArray = long[leaves[long]]
    if len(at_ends):
        return at_ends
    return long if len(long) else network.nodes[network.length[network.nodes] > _FIRST]


def _around(network: LaneNetwork, places: IntArray, ego: Car) -> Sequence[int]:
    """Return nodes by how far they are from where the ego sets out."""
    sections = [network.section(int(node)) for node in places]
    middles = np.array(
        [
            network.middle(int(node), np.array([0.5 * (low + high)]))[0][0, :2]
            for node, (low, high) in zip(places, sections, strict=True)
        ]
    )
    far = np.hypot(*(middles - ego.path.place[0, :2]).T)
    found: list[int] = places[np.argsort(far, kind="stable")][:_OTHER_TRIES].tolist()
    return found


def _car(network: LaneNetwork, programmes: list[Programme], node: int, delay: float = 0.0) -> Car:
    """Return a car that sets out on a node after a delay, s, and goes as far as it should, or can."""
    nodes = _within_reach(network, _way(network, node))
    path = path_along(network, nodes, max(_FIRST, float(network.length[node]) - _LAST))
    lights = lights_on(path, network, programmes)
    return Car(path, plan_motion(path, lights, delay), len(lights))


def _way(network: LaneNetwork, node: int) -> tuple[int, ...]:
    """Return the shortest way from a node to where it is long enough, or as long as can be."""
    far, before = network.ways_from(node)
    reached = np.flatnonzero(np.isfinite(far))
    enough = reached[far[reached] >= _WAY]
    last = int(enough[np.argmin(far[enough])] if len(enough) else reached[np.argmax(far[reached])])
    way = [last]
    while way[-1] != node:
        way.append(int(before[way[-1]]))
    return tuple(reversed(way))


def _within_reach(network: LaneNetwork, way: tuple[int, ...]) -> tuple[int, ...]:
    """Return a way up to where the next road ends too far away for a route: among too many others."""
    for k, node in enumerate(way[1:], 1):
        if network.length[node] > _LAST:
            far, _ = network.ways_from(way[k - 1])
            near = far <= network.length[node]
            if len(sorted_unique(network.road[near])) > _MOST_ROADS:
                return way[: k + 1 - bool(network.in_junction[way[k - 1]])]
    return way


def _worth(car: Car) -> float:
    """Return how much there is to see on a way, m."""
    turns: FloatArray = np.abs(np.diff(np.unwrap(car.path.hdg)))
    return min(car.path.length, _WAY) + _LIGHT_WORTH * min(car.lights, 3) + _TURN_WORTH * min(float(turns.sum()), 6.0)
