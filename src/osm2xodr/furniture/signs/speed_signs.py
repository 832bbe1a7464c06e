"""Signs that follow from attributes of ways: speed limits where they change, priority roads behind junctions."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Final, TypeAlias

import numpy as np

from osm2xodr.conventions import find_country, priority_rank
from osm2xodr.curves import project
from osm2xodr.defaults import PRIORITY_RANK_MINOR
from osm2xodr.furniture.signs.directions import UNITS_PER_MPS, same_limit
from osm2xodr.furniture.signs.posts import Post
from osm2xodr.furniture.world import Approach, World, car_lanes
from osm2xodr.model import SignFace, StreetAttributes
from osm2xodr.system import record

# Distance of signs from the junction behind which they stand, m; a choice, about a car's length.
_BEHIND_JUNCTION: Final = 5.0
# A sign that repeats another one within this distance before it, for the same direction, is left out, m; a choice:
# VwV-StVO has limits repeated at larger distances only.
_REPEATED: Final = 50.0
# A limit has the unit in which it is a whole number, up to this; rounding.
_WHOLE_NUMBER: Final = 0.02
# Meanings whose value counts as the limit, whether that of a zone or not.
_LIMITS: Final = frozenset({"maxspeed", "maxspeed_zone", "living_street", "restrictions_end"})


# What holds along a road: where each piece begins, ascending from 0, m, and its attributes
_Pieces: TypeAlias = list[tuple[float, StreetAttributes]]


@record
class _Change:
    """A place where other attributes begin to hold for traffic of a direction."""

    road: int
    s: float
    along: bool  # The direction of the traffic, along s or against it
    before: tuple[StreetAttributes, ...]  # Empty behind a junction
    limits_before: tuple[float, ...]  # m/s
    after: StreetAttributes
    from_junction: bool


def posts_of_ways(world: World, approaches: Sequence[Approach], others: Sequence[Post]) -> list[Post]:
    """Return the posts of signs that follow from attributes of ways.

    A sign stands where the signed limit of a direction changes along a road, or differs from that of an arm that
    leads to it through a junction, unless another post says the same nearby.
    """
    pieces = _road_pieces(world)
    stated: dict[tuple[int, bool], list[tuple[float, SignFace, bool]]] = defaultdict(list)
    for post in others:
        stated[post.road, post.along] += [(post.s, face, True) for face in post.faces]
    out: list[Post] = []
    changes = [*_along_roads(world, pieces), *_behind_junctions(world, approaches, pieces)]
    # In the direction of travel, so that the first of equal signs is kept.
    for change in sorted(changes, key=lambda item: (item.road, item.along, item.s if item.along else -item.s)):
        before = stated.get((change.road, change.along), ())
        faces = [face for face in _faces(change, world.network.country) if not _is_stated(face, change, before)]
        if faces and car_lanes(world, change.road, change.s, change.along):
            stated[change.road, change.along] += [(change.s, face, False) for face in faces]
            osm_id = f"way/{change.after.osm_way_id}"
            out.append(Post(change.road, change.s, change.along, tuple(faces), osm_id))
    return out


def _road_pieces(world: World) -> Mapping[int, _Pieces]:
    """Return the attributes along each road outside junctions, by its id."""
    places, streets = world.places, world.network.streets
    of_street = places.road_street.tolist()
    cut = [
        (k, piece, *streets[street].points[at].tolist())
        for k, street in enumerate(of_street)
        for piece, ((_, one), (at, other)) in enumerate(pairwise(streets[street].pieces), start=1)
        if _signed(one) != _signed(other)
    ]
    found: dict[int, list[tuple[float, int]]] = defaultdict(list)
    if cut:
        curve, piece, x, y = (np.array(column) for column in zip(*cut, strict=True))
        s, _, _ = project(world.road_map.plan_view, curve.astype(np.int64), x, y)
        for k, index, at in zip(curve.tolist(), piece.tolist(), s.tolist(), strict=True):
            found[k].append((at, index))
    out: dict[int, _Pieces] = {}
    for k, street in enumerate(of_street):
        ways = streets[street].pieces
        holding = [(0.0, ways[0][1])]
        for at, index in sorted(found.get(k, ()), key=lambda item: item[1]):
            holding.append((max(at, holding[-1][0]), ways[index][1]))
        out[world.road_map.roads[k].id] = holding
    return out


def _signed(item: StreetAttributes) -> tuple[object, ...]:
    """Return the attributes that signs can show."""
    return item.speed_forward, item.speed_backward, item.speed_signed, item.priority_road, item.traffic_sign


def _limit(attributes: StreetAttributes, along: bool) -> float | None:
    return attributes.speed_forward if along else attributes.speed_backward


def _along_roads(world: World, pieces: Mapping[int, _Pieces]) -> Iterator[_Change]:
    for road, items in pieces.items():
        for (_, one), (s, other) in pairwise(items):
            if 0.0 < s < world.lanes.length(road):
                for along, before, after in ((True, one, other), (False, other, one)):
                    limit = _limit(before, along)
                    limits = () if limit is None else (limit,)
                    yield _Change(road, s, along, (before,), limits, after, from_junction=False)


def _behind_junctions(
    world: World, approaches: Sequence[Approach], pieces: Mapping[int, _Pieces]
) -> Iterator[_Change]:
    limits: dict[tuple[int, bool], set[float]] = defaultdict(set)
    for item in approaches:
        there = pieces[item.road][-1 if item.at_end else 0][1]
        limit = _limit(there, item.at_end)
        # Arms of unknown limit or of the lowest classes do not count.
        known = limit is not None and priority_rank(there.highway) > PRIORITY_RANK_MINOR
        for movement in item.movements:
            if movement.exit_road == item.road or movement.exit_road not in pieces:
                continue
            after = pieces[movement.exit_road][0 if movement.exit_at_start else -1][1]
            signed = after.speed_signed and known and _limit(after, movement.exit_at_start) != limit
            if signed and limit is not None:
                limits[movement.exit_road, movement.exit_at_start].add(limit)
            elif after.priority_road:
                limits.setdefault((movement.exit_road, movement.exit_at_start), set())
    for (road, at_start), found in sorted(limits.items()):
        length = world.lanes.length(road)
        away = min(_BEHIND_JUNCTION, 0.5 * length)
        after = pieces[road][0 if at_start else -1][1]
        s = away if at_start else length - away
        yield _Change(road, s, at_start, (), tuple(sorted(found)), after, from_junction=True)


def _faces(change: _Change, country: str) -> Iterator[SignFace]:
    """Yield the signs that stand at a change."""
    if change.after.priority_road and (change.from_junction or not all(item.priority_road for item in change.before)):
        yield SignFace("priority_road")
    limit = _limit(change.after, change.along) if change.after.speed_signed else None
    if limit is not None and not all(same_limit(item, limit) for item in change.limits_before):
        yield _limit_face(change.after, limit, country)


def _limit_face(attributes: StreetAttributes, limit: float, country: str) -> SignFace:
    """Return the sign of a limit, m/s; that of a zone where the way says so."""
    if math.isinf(limit):
        return SignFace("restrictions_end")
    if attributes.highway == "living_street":
        return SignFace("living_street")
    value, unit = shown_speed(limit, country)
    return SignFace("maxspeed_zone" if attributes.speed_zone else "maxspeed", "", "", value, unit)


def shown_speed(speed: float, country: str) -> tuple[float, str]:
    """Return the number on the sign of a limit, m/s, and its unit: the country's, unless only the other is whole."""
    own = find_country(country).speed_unit
    for unit in (own, "mph" if own == "km/h" else "km/h"):
        value = speed * UNITS_PER_MPS[unit]
        if abs(value - round(value)) < _WHOLE_NUMBER:
            return float(round(value)), unit
    return float(round(speed * UNITS_PER_MPS[own])), own


def _is_stated(face: SignFace, change: _Change, stated: Sequence[tuple[float, SignFace, bool]]) -> bool:
    """Return whether another sign says the same: shortly before, or if it is mapped also shortly behind."""
    sign = 1.0 if change.along else -1.0
    same = ((sign * (change.s - s), mapped) for s, other, mapped in stated if _meaning(other) == _meaning(face))
    return any(abs(ahead) < _REPEATED and (mapped or ahead >= 0.0) for ahead, mapped in same)


def _meaning(face: SignFace) -> tuple[str, float | None]:
    limit = face.meaning in _LIMITS and face.value is not None
    return ("limit" if limit else face.meaning), face.value
