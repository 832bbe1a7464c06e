"""Which traffic a mapped sign is for: by its tags, by the way it faces, by the limits on either side of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from osm2xodr.conventions import find_country
from osm2xodr.model import Direction, Facing, FloatArray, SignFace, Street, StreetAttributes

# Where neither tags nor limits tell it, a town lies on that side of its sign on which there are so many times as many
# nodes of streets as on the other, within so many metres. Choices.
_TOWN_REACH: Final = 300.0
_TOWN_RATIO: Final = 1.5

# Units of speed limits, each per m/s.
IN_UNIT: Final = {"km/h": 3.6, "mph": 1.0 / 0.44704}
# Limits are one up to this, m/s: rounding of a unit.
SAME_LIMIT: Final = 0.1
# A sign is for a road's traffic if it faces it within this angle's cosine (60 degrees).
_FACES: Final = 0.5


def seen_heading(facing: Facing) -> float | None:
    """Return the heading of the traffic that sees a sign, rad; None where OSM does not say where it looks."""
    # Traffic drives towards the sign, against the direction in which it looks.
    return None if facing.azimuth_deg is None else float(np.deg2rad(-90.0 - facing.azimuth_deg))


def faced_along(heading: float, hdg: float) -> bool | None:
    """Return whether traffic of a heading runs along a road of another one, rad; None where it does neither."""
    cos = float(np.cos(heading - hdg))
    return None if abs(cos) < _FACES else cos > 0.0


@dataclass(frozen=True, slots=True)
class LimitsAround:
    """What holds on either side of a place in a street."""

    # What the tags say there and at the next change of limits, seen along the street
    before: StreetAttributes
    after: StreetAttributes
    here: StreetAttributes  # What they say at the place
    # Distance to the ends of the street, m
    to_start: float
    to_end: float
    # The place, m, and the heading of the street there, rad
    x: float
    y: float
    facing: float

    @classmethod
    def at(cls, street: Street, node: int) -> LimitsAround:
        """Look around a node of a street."""
        return cls._of(street, int(np.flatnonzero(street.node_ids == node)[0]))

    @classmethod
    def near(cls, street: Street, x: float, y: float) -> LimitsAround:
        """Look around the node of a street that is nearest to a place."""
        return cls._of(street, int(np.argmin(np.hypot(street.points[:, 0] - x, street.points[:, 1] - y))))

    @classmethod
    def of_end(cls, street: Street, *, at_end: bool) -> LimitsAround:
        """Look around the start or end of a street."""
        return cls._of(street, len(street.points) - 1 if at_end else 0)

    @classmethod
    def _of(cls, street: Street, place: int) -> LimitsAround:
        step = np.hypot(*np.diff(street.points, axis=0).T)
        pieces = street.pieces
        k = max(i for i, (first, _) in enumerate(pieces) if first <= place)
        before = pieces[k - 1][1] if k and pieces[k][0] == place else pieces[k][1]
        after = pieces[k][1]
        if before is after:
            # The way is not cut at the sign: the nearest cut on either side is the one it means.
            ends = [pieces[k][0], pieces[k + 1][0] if k + 1 < len(pieces) else len(step)]
            back, ahead = float(step[ends[0] : place].sum()), float(step[place : ends[1]].sum())
            if k and (back <= ahead or k + 1 == len(pieces)):
                before = pieces[k - 1][1]
            elif k + 1 < len(pieces):
                after = pieces[k + 1][1]
        ahead_of = street.points[min(place + 1, len(step))] - street.points[max(place - 1, 0)]
        facing = float(np.arctan2(ahead_of[1], ahead_of[0]))
        x, y = street.points[place].tolist()
        return cls(before, after, pieces[k][1], float(step[:place].sum()), float(step[place:].sum()), x, y, facing)

    def directions(self) -> tuple[bool, ...]:
        """Return which ways cars run along the street: True along it."""
        runs = self.here.car_directions()
        both = Direction.BOTH in runs
        return tuple(
            along for along, way in ((True, Direction.FORWARD), (False, Direction.BACKWARD)) if both or way in runs
        )

    def along(self, facing: Facing) -> bool | None:
        """Return the direction that a tag's value means, or the only one that cars take; None where that is open."""
        if facing.along is not None:
            return facing.along != self.here.reversed
        runs = self.directions()
        if len(runs) == 1:
            return runs[0]
        heading = seen_heading(facing)
        return None if heading is None else faced_along(heading, self.facing)

    def nearer_end(self) -> bool:
        """Return the direction to the nearer end of the street, if cars run there."""
        runs = self.directions()
        return runs[0] if len(runs) == 1 else self.to_end < self.to_start

    def into_town(self) -> bool | None:
        """Return the direction into a town: to where the limit is lower; None where it is the same."""
        before, after = (
            max(item.speed_forward or 0.0, item.speed_backward or 0.0) for item in (self.before, self.after)
        )
        if not before or not after or abs(before - after) < SAME_LIMIT:
            return None
        return after < before

    def _limits(self, along: bool) -> tuple[float | None, float | None]:
        """Return the limits before and behind the place as traffic of a direction meets them, m/s."""
        if along:
            return self.before.speed_forward, self.after.speed_forward
        return self.after.speed_backward, self.before.speed_backward

    def limited(self, face: SignFace, country: str) -> list[bool]:
        """Return the directions in which a limit begins to hold; those in which it holds; or else all."""
        runs = self.directions()
        if face.value is None:
            changed = [along for along in runs if self._limits(along)[0] != self._limits(along)[1]]
            return changed or list(runs)
        speed = face.value / IN_UNIT.get(face.unit or find_country(country).speed_unit, 3.6)
        holds = [along for along in runs if _same(self._limits(along)[1], speed)]
        begins = [along for along in holds if not _same(self._limits(along)[0], speed)]
        return begins or holds or list(runs)

    def tells(self, face: SignFace, country: str) -> bool:
        """Say whether the limits around a sign of one tell its direction: it begins to hold in one, or as said."""
        if len(self.limited(face, country)) < 2:
            return True
        return face.value is None and all(self._limits(along)[0] != self._limits(along)[1] for along in (True, False))

    def with_value(self, face: SignFace, along: bool, country: str) -> SignFace:
        """Return a sign of a limit with the value that holds behind it, if it has none itself."""
        speed = self._limits(along)[1]
        if face.value is not None or speed is None or not np.isfinite(speed):
            return face
        unit = find_country(country).speed_unit
        return replace(face, value=float(round(speed * IN_UNIT[unit])), unit=unit)


def comes_to(street: Street, end: int) -> bool:
    """Whether cars come along a street to one of its ends (2 x street, plus 1 for its end)."""
    runs = street.pieces[-1 if end % 2 else 0][1].car_directions()
    return Direction.BOTH in runs or (Direction.FORWARD if end % 2 else Direction.BACKWARD) in runs


class TownSide:
    """Says on which side of a place there are more streets.

    Parameters
    ----------
    streets
        All of them.
    """

    def __init__(self, streets: Sequence[Street]) -> None:
        self._streets = streets

    @cached_property
    def _nodes(self) -> FloatArray:
        return np.concatenate([street.points for street in self._streets])

    def ahead(self, limits: LimitsAround) -> bool | None:
        """Return whether there are more nodes of streets ahead, along the street; None where it is about the same."""
        dx, dy = self._nodes[:, 0] - limits.x, self._nodes[:, 1] - limits.y
        near = np.hypot(dx, dy) < _TOWN_REACH
        before = (dx * np.cos(limits.facing) + dy * np.sin(limits.facing))[near] < 0.0
        behind, ahead = int(before.sum()), int((~before).sum())
        if max(behind, ahead) < _TOWN_RATIO * min(behind, ahead):
            return None
        return ahead > behind


def _same(one: float | None, other: float) -> bool:
    return one is not None and abs(one - other) < SAME_LIMIT
