"""Signs that follow from tags of ways: speed limits where they change, priority roads behind junctions."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.conventions import find_country, priority_rank
from osm2xodr.curves import project
from osm2xodr.defaults import PRIORITY_RANK_MINOR
from osm2xodr.furniture import defaults
from osm2xodr.furniture.signs.directions import IN_UNIT, SAME_LIMIT
from osm2xodr.furniture.signs.posts import Post
from osm2xodr.furniture.world import Approach, World, car_lanes
from osm2xodr.model import SignFace, StreetAttributes

# Where a road begins at a junction its signs stand this far from it, m; a choice, about a car's length.
_SIGN_BEYOND_JUNCTION: Final = 5.0

# How far a limit in a unit may be from a whole number to have been meant in it.
_WHOLE: Final = 0.02
_LIMITS: Final = frozenset({"maxspeed", "maxspeed_zone", "living_street", "restrictions_end"})


@dataclass(frozen=True, slots=True)
class _Pieces:
    """What holds along a road: s from which on, ascending, the first at the start; and the tags there."""

    s: tuple[float, ...]
    attributes: tuple[StreetAttributes, ...]


@dataclass(frozen=True, slots=True)
class _Change:
    """A place where traffic of a direction comes from what some tags say to what others do."""

    road: int
    s: float
    along: bool
    before: tuple[StreetAttributes, ...]
    limits_before: tuple[float, ...]
    after: StreetAttributes
    from_junction: bool


def road_signs(world: World, approaches: Sequence[Approach], mapped: Sequence[Post]) -> list[Post]:
    """Return the poles of signs that follow from tags of ways.

    Where the limit that is signed for a direction changes along a road, or differs from that of an arm that leads to
    it through a junction, there is a sign, unless one that is mapped says the same nearby.

    Parameters
    ----------
    world, approaches
        What is there.
    mapped
        Other signs.
    """
    pieces = _road_pieces(world)
    said: dict[tuple[int, bool], list[tuple[float, SignFace, bool]]] = defaultdict(list)
    for post in mapped:
        said[post.road, post.along] += [(post.s, face, True) for face in post.faces]
    out: list[Post] = []
    changes = [*_along_roads(world, pieces), *_behind_junctions(world, approaches, pieces)]
    # In the direction of travel, so that the first of equal signs stays.
    for change in sorted(changes, key=lambda item: (item.road, item.along, item.s if item.along else -item.s)):
        faces = [
            face
            for face in _faces(change, world.network.country)
            if not _is_said(face, change, said.get((change.road, change.along), ()))
        ]
        if faces and car_lanes(world, change.road, change.s, change.along):
            said[change.road, change.along] += [(change.s, face, False) for face in faces]
            osm_id = f"way/{change.after.osm_way_id}"
            out.append(Post(change.road, change.s, change.along, tuple(faces), osm_id))
    return out


def _road_pieces(world: World) -> Mapping[int, _Pieces]:
    """Return what the tags say along each road outside junctions."""
    places, streets = world.places, world.network.streets
    of_street = places.road_street.tolist()
    cut = [
        (k, piece, *streets[street].points[streets[street].pieces[piece][0]].tolist())
        for k, street in enumerate(of_street)
        for piece in range(1, len(streets[street].pieces))
        if _differ(streets[street].pieces[piece - 1][1], streets[street].pieces[piece][1])
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
        starts, holding = [0.0], [ways[0][1]]
        for at, index in sorted(found.get(k, ()), key=lambda item: item[1]):
            starts.append(max(at, starts[-1]))
            holding.append(ways[index][1])
        out[world.road_map.roads[k].id] = _Pieces(tuple(starts), tuple(holding))
    return out


def _differ(one: StreetAttributes, other: StreetAttributes) -> bool:
    return (one.speed_forward, one.speed_backward, one.speed_signed, one.priority_road, one.traffic_sign) != (
        other.speed_forward,
        other.speed_backward,
        other.speed_signed,
        other.priority_road,
        other.traffic_sign,
    )


def _limit(attributes: StreetAttributes, along: bool) -> float | None:
    return attributes.speed_forward if along else attributes.speed_backward


def _along_roads(world: World, pieces: Mapping[int, _Pieces]) -> Iterator[_Change]:
    for road, item in pieces.items():
        if len(item.s) == 1:
            continue
        length = world.lanes.length(road)
        for k in range(1, len(item.s)):
            if not 0.0 < item.s[k] < length:
                continue
            one, other = item.attributes[k - 1], item.attributes[k]
            for along, before, after in ((True, one, other), (False, other, one)):
                limit = _limit(before, along)
                limits = () if limit is None else (limit,)
                yield _Change(road, item.s[k], along, (before,), limits, after, from_junction=False)


def _behind_junctions(
    world: World, approaches: Sequence[Approach], pieces: Mapping[int, _Pieces]
) -> Iterator[_Change]:
    limits: dict[tuple[int, bool], set[float]] = defaultdict(set)
    for item in approaches:
        there = pieces[item.road].attributes[-1 if item.at_end else 0]
        limit = _limit(there, item.at_end)
        # Where the limit of an arm is not known, or it is no street of its own, no sign is behind it.
        known = limit is not None and priority_rank(there.highway) > PRIORITY_RANK_MINOR
        for movement in item.movements:
            if movement.exit_road == item.road or movement.exit_road not in pieces:
                continue
            after = pieces[movement.exit_road].attributes[0 if movement.exit_at_start else -1]
            signed = after.speed_signed and known and _limit(after, movement.exit_at_start) != limit
            if signed and limit is not None:
                limits[movement.exit_road, movement.exit_at_start].add(limit)
            elif after.priority_road:
                limits.setdefault((movement.exit_road, movement.exit_at_start), set())
    for (road, at_start), found in sorted(limits.items()):
        length = world.lanes.length(road)
        away = min(_SIGN_BEYOND_JUNCTION, 0.5 * length)
        after = pieces[road].attributes[0 if at_start else -1]
        s = away if at_start else length - away
        yield _Change(road, s, at_start, (), tuple(sorted(found)), after, from_junction=True)


def _faces(change: _Change, country: str) -> Iterator[SignFace]:
    """Yield the signs that stand where the tags change so."""
    if change.after.priority_road and (change.from_junction or not all(item.priority_road for item in change.before)):
        yield SignFace("priority_road")
    limit = _limit(change.after, change.along)
    if limit is None or not change.after.speed_signed:
        return
    others = [item for item in change.limits_before if item != limit and not abs(item - limit) < SAME_LIMIT]
    if others:
        face = _limit_face(change.after, limit, country)
        if face is not None:
            yield face


def _limit_face(attributes: StreetAttributes, limit: float, country: str) -> SignFace | None:
    """Return the sign of a limit, m/s; of a zone where the way says that it is one."""
    if math.isinf(limit):
        return SignFace("restrictions_end")
    if attributes.highway == "living_street":
        return SignFace("living_street")
    value, unit = shown_speed(limit, country)
    return SignFace("maxspeed_zone" if attributes.speed_zone else "maxspeed", "", "", value, unit)


def shown_speed(speed: float, country: str) -> tuple[float, str]:
    """Return the number on a sign and its unit for a limit, m/s.

    The unit is the country's if that makes a whole number, else the other one if that does.
    """
    own = find_country(country).speed_unit
    for unit in (own, "mph" if own == "km/h" else "km/h"):
        value = speed * IN_UNIT[unit]
        if abs(value - round(value)) < _WHOLE:
            return float(round(value)), unit
    return float(round(speed * IN_UNIT[own])), own


def _is_said(face: SignFace, change: _Change, said: Sequence[tuple[float, SignFace, bool]]) -> bool:
    """Whether another sign says the same: one shortly before, or a mapped one shortly behind as well."""
    for s, other, mapped in said:
        ahead = change.s - s if change.along else s - change.s
        near = abs(ahead) < defaults.SIGN_REPEATED if mapped else 0.0 <= ahead < defaults.SIGN_REPEATED
        if near and _says(other) == _says(face):
            return True
    return False


def _says(face: SignFace) -> tuple[str, float | None]:
    # Of limits the number counts, not whether it is that of a zone.
    limit = face.meaning in _LIMITS and face.value is not None
    return ("limit" if limit else face.meaning), face.value
