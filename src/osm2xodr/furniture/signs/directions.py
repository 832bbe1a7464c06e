"""Which road and traffic a mapped sign is for: by its tags, by the way it faces, by the limits on either side of it.

A sign beside streets is for the road whose traffic has it on its own side. A node has no layer: where roads on
several levels are about as near, the sign is left out, but for tunnels below it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Final

import numpy as np

from osm2xodr.conventions import find_country
from osm2xodr.curves import arctan2, cosine, heading_at, hypot, sine
from osm2xodr.furniture import defaults
from osm2xodr.furniture.world import World, way_at
from osm2xodr.model import (
    Direction,
    Facing,
    FloatArray,
    RoadsideThing,
    Rule,
    SignFace,
    SignPost,
    Street,
    StreetAttributes,
    Structure,
)
from osm2xodr.system import record

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

# Units of speed limits, per m/s.
UNITS_PER_MPS: Final = {"km/h": 3.6, "mph": 1.0 / 0.44704}
# Speed limits that differ by less are the same, m/s: rounding of units.
_SAME_LIMIT: Final = 0.1
# Where neither tags nor limits say it, a town lies on the side of its sign with this many times more nodes of streets
# than the other, within this distance, m. Choices.
_TOWN_RATIO: Final = 1.5
_TOWN_REACH: Final = 300.0
# A sign is for the traffic of a road if it faces it within the angle with this cosine (60 degrees); a choice.
_FACING_COSINE: Final = 0.5


@record
class Spot:
    """A place of a sign on a road."""

    road: int
    s: float
    t: float | None  # None where the sign is mapped on the street
    along: bool | None  # The direction of the traffic that it is for; None where not known
    limits: LimitsAround


@record
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
    point, curve, s, t, distance = world.outside_junctions.near(x, y, _REACH)
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


def same_limit(one: float | None, other: float) -> bool:
    """Return whether two speed limits, m/s, are the same but for rounding."""
    return one is not None and (one == other or abs(one - other) < _SAME_LIMIT)


def seen_heading(facing: Facing) -> float | None:
    """Return the heading of the traffic that sees a sign, rad; None where OSM does not say where it looks."""
    # Traffic drives towards the sign, against the direction in which it looks.
    return None if facing.azimuth_deg is None else float(np.deg2rad(-90.0 - facing.azimuth_deg))


def faced_along(heading: float, hdg: float) -> bool | None:
    """Return whether traffic with a heading runs along a road with another one, rad; None where it crosses that."""
    cos = float(cosine(heading - hdg))
    return None if abs(cos) < _FACING_COSINE else cos > 0.0


@record
class LimitsAround:
    """What holds on either side of a place in a street."""

    # On either side of the next change of attributes, seen along the street
    before: StreetAttributes
    after: StreetAttributes
    here: StreetAttributes  # At the place itself
    to_start: float  # Distance to the start of the street, m
    to_end: float  # To its end, m
    # The place, m, and the heading of the street there, rad
    x: float
    y: float
    hdg: float

    @classmethod
    def at(cls, street: Street, place: int) -> LimitsAround:
        """Look around the node of a street with an index."""
        step = hypot(*np.diff(street.points, axis=0).T)
        pieces = street.pieces
        k = max(i for i, (first, _) in enumerate(pieces) if first <= place)
        before = pieces[k - 1][1] if k and pieces[k][0] == place else pieces[k][1]
        after = pieces[k][1]
        if before is after:
            # The way is not split at the sign: it means the nearest split on either side.
            ends = [pieces[k][0], pieces[k + 1][0] if k + 1 < len(pieces) else len(step)]
            back, ahead = float(step[ends[0] : place].sum()), float(step[place : ends[1]].sum())
            if k and (back <= ahead or k + 1 == len(pieces)):
                before = pieces[k - 1][1]
            elif k + 1 < len(pieces):
                after = pieces[k + 1][1]
        along = street.points[min(place + 1, len(step))] - street.points[max(place - 1, 0)]
        x, y = street.points[place].tolist()
        to_start, to_end = float(step[:place].sum()), float(step[place:].sum())
        return cls(before, after, pieces[k][1], to_start, to_end, x, y, float(arctan2(along[1], along[0])))

    def directions(self) -> tuple[bool, ...]:
        """Return which ways cars run along the street: True along it."""
        return tuple(along for along, runs in zip((True, False), _runs(self.here), strict=True) if runs)

    def along(self, facing: Facing) -> bool | None:
        """Return the direction of traffic that a sign is for; None where neither tags nor a one-way street say it."""
        if facing.along is not None:
            return facing.along != self.here.reversed
        runs = self.directions()
        if len(runs) == 1:
            return runs[0]
        heading = seen_heading(facing)
        return None if heading is None else faced_along(heading, self.hdg)

    def nearer_end(self) -> bool:
        """Return the direction to the nearer end of the street, or the only one in which cars run."""
        runs = self.directions()
        return runs[0] if len(runs) == 1 else self.to_end < self.to_start

    def into_town(self) -> bool | None:
        """Return the direction into a town: to where the limit is lower; None where it is the same."""
        sides = (self.before, self.after)
        before, after = (max(item.speed_forward or 0.0, item.speed_backward or 0.0) for item in sides)
        if not before or not after or abs(before - after) < _SAME_LIMIT:
            return None
        return after < before

    def _limits(self, along: bool) -> tuple[float | None, float | None]:
        """Return the limits before and behind the place as traffic of a direction meets them, m/s."""
        if along:
            return self.before.speed_forward, self.after.speed_forward
        return self.after.speed_backward, self.before.speed_backward

    def limit_directions(self, face: SignFace, country: str) -> list[bool]:
        """Return the directions in which a sign's limit begins to hold; else those in which it holds; else all."""
        runs = self.directions()
        if face.value is None:
            changed = [along for along in runs if self._limits(along)[0] != self._limits(along)[1]]
            return changed or list(runs)
        speed = face.value / UNITS_PER_MPS.get(face.unit or find_country(country).speed_unit, 3.6)
        holds = [along for along in runs if same_limit(self._limits(along)[1], speed)]
        begins = [along for along in holds if not same_limit(self._limits(along)[0], speed)]
        return begins or holds or list(runs)

    def decide_direction(self, face: SignFace, country: str) -> bool:
        """Return whether the limits around a sign of one decide its directions."""
        if len(self.limit_directions(face, country)) < 2:
            return True
        return face.value is None and all(self._limits(along)[0] != self._limits(along)[1] for along in (True, False))

    def with_value(self, face: SignFace, along: bool, country: str) -> SignFace:
        """Return the sign of a limit with the value that holds behind it, if it has none itself."""
        speed = self._limits(along)[1]
        if face.value is not None or speed is None or not np.isfinite(speed):
            return face
        unit = find_country(country).speed_unit
        return replace(face, value=float(round(speed * UNITS_PER_MPS[unit])), unit=unit)


def cars_at_end(street: Street, end: int) -> tuple[bool, bool]:
    """Return whether cars come to an end of a street (2 x street, plus 1 for its end), and whether they leave it."""
    forward, backward = _runs(street.attributes_at_end(end))
    return (forward, backward) if end % 2 else (backward, forward)


def _runs(attributes: StreetAttributes) -> tuple[bool, bool]:
    """Return whether cars run along a street, and whether against it."""
    runs = attributes.car_directions()
    both = Direction.BOTH in runs
    return both or Direction.FORWARD in runs, both or Direction.BACKWARD in runs


class TownSide:
    """Finds the side of a place on which there are more streets."""

    def __init__(self, streets: Sequence[Street]) -> None:
        self._streets = streets

    @cached_property
    def _nodes(self) -> FloatArray:
        return np.concatenate([street.points for street in self._streets])

    def ahead(self, limits: LimitsAround) -> bool | None:
        """Return whether more nodes of streets lie ahead, along the street; None where it is about as many."""
        dx, dy = self._nodes[:, 0] - limits.x, self._nodes[:, 1] - limits.y
        near = hypot(dx, dy) < _TOWN_REACH
        before = (dx * cosine(limits.hdg) + dy * sine(limits.hdg))[near] < 0.0
        behind, ahead = int(before.sum()), int((~before).sum())
        if max(behind, ahead) < _TOWN_RATIO * min(behind, ahead):
            return None
        return ahead > behind
