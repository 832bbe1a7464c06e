"""Finds the road that a sign beside streets is for: the one whose traffic has it on its own side.

A node has no layer: where roads on several levels are about as near, the sign is left out, but for tunnels below it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.curves import (
    CurveFinder,
    heading_at,
    hypot,
)
from osm2xodr.furniture import defaults
from osm2xodr.furniture.signs.directions import LimitsAround, faced_along, seen_heading
from osm2xodr.furniture.world import World, curves_near, way_at
from osm2xodr.model import Facing, RoadsideThing, Rule, SignPost, StreetAttributes, Structure

# How far beside its road a sign may be mapped, m; a choice: MUTCD 2A.19 has overhead ones 12 ft and more beside.
_REACH: Final = 15.0
# How much farther away a road counts if the sign is not on the side of its traffic, m; a choice.
_WRONG_SIDE: Final = 5.0
# The same for stop and give-way signs, per distance to what they are for, m/m; a choice.
_AHEAD_SHARE: Final = 0.2
# A road on another level makes it unclear which is meant if it is farther by less, m; a choice.
_AMBIGUOUS: Final = 5.0

_NO_ROAD: Final = "no road for cars that it faces is near"
# Roads without stop signs; links that leave them may have some.
_WITHOUT_STOP_SIGNS: Final = frozenset({"motorway", "trunk"})


@dataclass(frozen=True, slots=True)
class Spot:
    """A place of a sign on a road."""

    road: int
    s: float
    t: float | None  # None where the sign is mapped on the street
    along: bool | None  # The direction of the traffic that it is for; None where not known
    limits: LimitsAround


@dataclass(frozen=True, slots=True)
class Candidate:
    """A road that a sign beside it may be for."""

    spot: Spot  # Where it would stand, and for which direction
    along: bool  # The same direction, which is known here
    way: StreetAttributes  # The piece of way there
    outside: float  # How far it stands outside the carriageway, m; negative on it
    own_side: bool  # Whether it stands on the side to which the traffic keeps
    beyond: float  # How far it stands before the road's start or beyond its end, m

    def misfit(self) -> float:
        """Return how badly the sign fits this road, m."""
        return abs(self.outside) + self.beyond + (0.0 if self.own_side else _WRONG_SIDE)


def candidates_beside(world: World, things: Sequence[tuple[RoadsideThing, SignPost]]) -> list[list[Candidate]]:
    """Return the roads that each sign beside streets may be for, nearest first."""
    out: list[list[Candidate]] = [[] for _ in things]
    if not things:
        return out
    plan = world.road_map.plan_view
    x, y = np.array([item.points[0] for item, _ in things]).T
    near = curves_near(plan, x, y)
    finder = CurveFinder(plan, near[near < len(world.places.road_street)])
    point, curve, s, t, distance = finder.near(x, y, _REACH)
    beyond = np.sqrt(np.maximum(distance**2 - t**2, 0.0))
    order = np.lexsort((curve, distance, point))
    columns = (point, curve, s, t, heading_at(plan, curve, s), beyond)
    for thing, road, *place in zip(*(column[order].tolist() for column in columns), strict=True):
        found = _candidate(world, things[thing][1].facing, things[thing][0].points[0].tolist(), road, *place)
        if found is not None:
            out[thing].append(found)
    return out


def _candidate(
    world: World, facing: Facing, at: tuple[float, float], curve: int, s: float, t: float, hdg: float, beyond: float
) -> Candidate | None:
    """Return a candidate at s, t, heading of a road; None if the sign faces no traffic there."""
    heading = seen_heading(facing)
    along = None if heading is None else faced_along(heading, hdg)
    if heading is not None and along is None:
        return None
    road = world.road_map.roads[curve].id
    street = world.network.streets[int(world.places.road_street[curve])]
    limits = LimitsAround.at(street, int(np.argmin(hypot(*(street.points - at).T))))
    runs = limits.directions()
    left, right = world.lanes.carriageway(road, s)
    on_right = t < 0.5 * (left + right)
    keeps_right = world.road_map.rule is Rule.RIGHT_HAND
    if along is None:
        along = on_right == keeps_right if len(runs) > 1 else runs[0]
    spot, outside = Spot(road, s, t, along, limits), max(t - left, right - t)
    return Candidate(spot, along, way_at(street, *at), outside, on_right == (along == keeps_right), beyond)


def choose_spot(candidates: Sequence[Candidate], *, any_way: bool) -> Spot | str:
    """Return the place of a sign, or why it has none.

    `any_way` says whether it may be for a direction in which no cars run, as no-entry signs are.
    """
    if not candidates:
        return _NO_ROAD
    led = [item for item in candidates if any_way or item.along in item.spot.limits.directions()]
    return _best([(item.misfit(), item) for item in led or candidates])


def choose_yield(
    candidates: Sequence[Candidate], kind: str, ahead: Callable[[Spot, bool], float | None]
) -> Spot | str:
    """Return the place of a stop or give-way sign (the kind), or why it has none.

    It stands on the side of the traffic that drives towards what it is for. `ahead` returns how far that is from a
    place, in a direction, m; None where there is nothing.
    """
    why = ""
    left: list[tuple[float, Candidate]] = []
    for item in sorted(candidates, key=Candidate.misfit):
        distance = ahead(item.spot, item.along)
        problem = _no_yield(item, kind)
        if problem or distance is None:
            why = why or problem or "no junction or crossing is ahead of it on the nearest road"
        else:
            left.append((item.misfit() + _AHEAD_SHARE * distance, item))
    return _best(left) if left else why or _NO_ROAD


def _no_yield(item: Candidate, kind: str) -> str:
    """Return why a stop or give-way sign cannot be for a road's traffic, empty if it can."""
    if item.way.highway == "motorway" or (kind == "stop" and item.way.highway in _WITHOUT_STOP_SIGNS):
        return f"the road where it stands is a {item.way.highway}, whose traffic does not stop for others"
    if kind == "stop" and item.way.roundabout:
        return "the road where it stands is the ring of a roundabout"
    if item.outside < -defaults.OBJECT_INSIDE:
        return "it lies on the carriageway but on no street, and does not say for which traffic"
    if not item.own_side:
        return "it stands on the far side of the nearest road"
    return ""


def _best(candidates: Sequence[tuple[float, Candidate]]) -> Spot | str:
    """Return the place that fits best, by its misfit, unless a road of another level fits about as well.

    What stands near a tunnel and about as near to a street stands beside that street, above the tunnel.
    """
    above = [pair for pair in candidates if pair[1].way.structure is not Structure.TUNNEL]
    near = min(misfit for misfit, _ in candidates) + _AMBIGUOUS
    if not any(misfit < near for misfit, _ in above):
        return "the nearest road runs in a tunnel, and it does not say that it stands there"
    least, best = min(above, key=lambda pair: pair[0])
    if any(item.way.layer != best.way.layer and misfit < least + _AMBIGUOUS for misfit, item in above):
        return "roads on several levels are near, and it does not say for which of them"
    return best.spot
