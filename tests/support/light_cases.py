"""Traffic lights of small networks built by hand, and where they stand, worked out apart from the product."""

from __future__ import annotations

import cmath
from collections.abc import Callable
from dataclasses import dataclass, replace

from clothoids import clothoid
from junction_cases import CASES
from street_cases import Case

from osm2xodr.conventions.targets import DEFAULT_TARGET, TARGETS
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.furniture.lights import Lights, place_lights
from osm2xodr.furniture.options import FurnitureOptions
from osm2xodr.furniture.world.approaches import find_approaches
from osm2xodr.furniture.world.lane_table import LaneTable
from osm2xodr.furniture.world.world import Approach, Crossing, World
from osm2xodr.model import RoadMap, Rule, Signal, StreetNetwork

SIGNALS = "highway=traffic_signals"
X = CASES["x"].case
# Streets of the crossing with a node each 12 m before it.
NODES = {**X.nodes, "wi": (-12.0, 0.0), "ei": (12.0, 0.0), "si": (0.0, -12.0), "ni": (0.0, 12.0)}
ARMS = Case(NODES, {1: ("w wi o", ""), 2: ("o ei e", ""), 3: ("s si o", ""), 4: ("o ni n", "")})
YIELDING = {"si": "highway=give_way", "ni": "highway=give_way"}
STREET = {"w": (-100.0, 0.0), "a": (-20.0, 0.0), "b": (0.0, 0.0), "c": (10.0, 0.0), "e": (100.0, 0.0)}
ROAD = Case(STREET, {1: ("w a b c e", "")})
ONE_WAY = Case(STREET, {1: ("w a b c e", "oneway=yes")})


@dataclass(frozen=True)
class Lit:
    """A network with its lights, and what was said about them."""

    world: World
    approaches: tuple[Approach, ...]
    lights: Lights

    @property
    def left_out(self) -> dict[str, str]:
        """The nodes that give no lights, and why."""
        return {item.osm_id: item.message for item in self.world.diagnostics if item.code == "signal-left-out"}

    def at(self, signal: Signal) -> complex:
        """Return where a signal stands: x + iy, m."""
        return point(self.world.road_map, signal.road, signal.s, signal.t)

    def heads(self, kind: str = "1000001") -> list[Signal]:
        """Return the heads for cars (or people)."""
        return [item for item in self.lights.signals if item.type == kind]

    def way(self, signal: Signal) -> int:
        """Return the OSM way of a signal's road."""
        road = next(road for road in self.world.road_map.roads if road.id == signal.road)
        return road.osm_way_ids[-1 if signal.orientation == "+" else 0]

    def phases(self) -> list[set[tuple[int, str]]]:
        """Return (way, turns) of the heads of each traffic controller."""
        by_id = {item.id: item for item in self.lights.signals}
        return [
            {(self.way(by_id[k]), by_id[k].name.removeprefix("traffic light, ")) for k in item.signals}
            for item in self.lights.controllers
            if item.kind == "traffic"
        ]


def point(road_map: RoadMap, road: int, s: float, t: float) -> complex:
    """Return the place of s and t on a road: x + iy, m."""
    k = next(k for k, item in enumerate(road_map.roads) if item.id == road)
    plan = road_map.plan_view
    row = next(r for r in reversed(range(plan.start[k], plan.start[k + 1])) if plan.s[r] <= s or r == plan.start[k])
    along, turn = clothoid(float(plan.curvature[row]), float(plan.rate[row]), s - float(plan.s[row]))
    return complex(plan.x[row], plan.y[row]) + cmath.exp(1j * float(plan.hdg[row])) * (
        complex(along) + 1j * t * cmath.exp(1j * float(turn))
    )


def lit(
    case: Case,
    rule: Rule = Rule.RIGHT_HAND,
    *,
    crossings: Callable[[World], tuple[Crossing, ...]] = lambda world: (),
    network: Callable[[StreetNetwork], StreetNetwork] = lambda network: network,
    target: str = DEFAULT_TARGET,
) -> Lit:
    """Place the lights of a case, drawn for right-hand traffic and mirrored for left-hand traffic.

    Parameters
    ----------
    case, rule
        The network.
    crossings
        Makes the crossings.
    network
        Changes what was read.
    target
        The reader to write for.
    """
    drawn = case if rule is Rule.RIGHT_HAND else case.mirrored()
    road_map = drawn.build(rule)
    assert road_map.places is not None
    read = network(drawn.stages(rule).network)
    world = World(
        read, road_map, road_map.places, LaneTable(road_map), FurnitureOptions(TARGETS[target]), Diagnostics()
    )
    found = crossings(world)
    approaches = find_approaches(world, found)
    return Lit(world, approaches, place_lights(world, approaches, found))


def with_tags(case: Case, **tags: str) -> Case:
    """Return a case with tags of its nodes by name."""
    return replace(case, node_tags={**case.node_tags, **tags})


def sides(found: Lit) -> float:
    """Return 1 where traffic drives on the right, -1 on the left."""
    return 1.0 if found.world.road_map.rule is Rule.RIGHT_HAND else -1.0


def crossing_at(way: int, s: float, **changes: object) -> Callable[[World], tuple[Crossing, ...]]:
    """Return what makes a crossing with lights of 4 m by 7 m on the road of a way."""

    def make(world: World) -> tuple[Crossing, ...]:
        road = next(road.id for road in world.road_map.roads if road.osm_way_ids == (way,) and road.junction is None)
        found = Crossing(road, s, 4.0, 3.0, -3.0, "node/1003", signals=True)
        return (replace(found, **changes),)  # type: ignore[arg-type]

    return make
