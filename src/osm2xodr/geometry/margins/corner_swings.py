"""Sidewalks swing out round the lanes that lie in their way at corners: those of cars that turn back, or wide."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import chain_curves, pose, ranks
from osm2xodr.geometry.connections import ConnectingRoads, connect, legs_through
from osm2xodr.geometry.margins import defaults
from osm2xodr.model import FloatArray, IntArray, PlanView, Rule

# How far out a sidewalk swings at most, and how much farther it keeps from lanes, m. Choices.
_FARTHEST: Final = 8.0
_SLACK: Final = 0.1
# So many lanes one behind the other are looked for. A choice.
_MOST_BEHIND: Final = 6
# Shares of its way at which room is looked for.
_SHARES: Final = np.linspace(0.0, 1.0, 13)[1:-1]
# Places on lanes are so far from each other, m.
_SPACING: Final = 0.8
# It swings out and back by this slope at most. A choice.
_SLOPE: Final = 0.6
# Places through which it is drawn are about so far from each other, m, and not more of them than these. Choices.
_LEG: Final = 3.0
_MOST_LEGS: Final = 7


def swung_out(rows: ConnectingRoads, cars: ConnectingRoads, rule: Rule) -> tuple[IntArray, PlanView]:
    """Return the sidewalks, on curves of their own, that can swing out round lanes, (n,), and the curves they get.

    Whether they are clear, and as smooth as they should be, is not looked at.
    """
    # Away from the carriageway: with right-hand traffic it lies left of the sidewalk's direction.
    outwards = -1.0 if rule is Rule.RIGHT_HAND else 1.0
    found: list[int] = []
    ways: list[tuple[FloatArray, FloatArray, FloatArray]] = []
    for row in range(len(rows.length)):
        lanes = np.flatnonzero(cars.junction == rows.junction[row])
        out = _room_needed(rows, row, cars, lanes, outwards)
        if out is None:
            continue
        found.append(row)
        ways.append(_places(rows, row, out, outwards))
    chosen = np.array(found, np.int64)
    plan, length = rows.plan_view, rows.length[chosen]
    begin, end = pose(plan, chosen, np.zeros(len(chosen))), pose(plan, chosen, length)
    if not found:
        return chosen, plan
    through = tuple(np.concatenate(column) for column in zip(*ways, strict=True))
    one, other, first = legs_through(
        begin, (through[0], through[1], through[2]), end, np.array([len(x) for x, *_ in ways])
    )
    return chosen, chain_curves(connect(*one, *other), first)


def _room_needed(
    rows: ConnectingRoads, row: int, cars: ConnectingRoads, lanes: IntArray, outwards: float
) -> FloatArray | None:
    """Return how far out a sidewalk is clear of lanes at `_SHARES` of its way, m; None where it is so, or nowhere."""
    half = max(rows.entry_width[row], rows.exit_width[row]) / 2
    x, y, hdg = pose(rows.plan_view, np.full(len(_SHARES), row), rows.length[row] * _SHARES)
    count = (cars.length[lanes] / _SPACING).astype(np.int64) + 2
    of, share = np.repeat(lanes, count), ranks(count) / np.repeat(count - 1, count)
    cx, cy, _ = pose(cars.plan_view, of, share * cars.length[of])
    reach = half - min(defaults.CORNER_ONTO_LANE, half / 2) + np.minimum(cars.entry_width, cars.exit_width)[of] / 2
    # Each place on a lane covers so much of the lines that lead outwards from the sidewalk.
    dx, dy = cx - x[:, None], cy - y[:, None]
    sin, cos = np.sin(hdg)[:, None], np.cos(hdg)[:, None]
    middle, along = outwards * (dy * cos - dx * sin), dx * cos + dy * sin
    depth = np.sqrt(np.maximum(reach**2 - along**2, 0.0))
    begin, end = middle - depth, np.where(depth > 0.0, middle + depth, -np.inf)
    need = np.zeros(len(x))
    for _ in range(_MOST_BEHIND):
        need = np.where(begin <= need[:, None], end, 0.0).max(axis=1, initial=0.0).clip(need)
    if not need.any() or need.max() > _FARTHEST:
        return None
    need[need > 0.0] += _SLACK
    s = rows.length[row] * _SHARES
    return np.asarray((need[None, :] - _SLOPE * np.abs(s[:, None] - s[None, :])).max(axis=1).clip(0.0))


def _places(
    rows: ConnectingRoads, row: int, out: FloatArray, outwards: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return poses that far beside a sidewalk's curve, `out` at `_SHARES` of it, m."""
    length = float(rows.length[row])
    many = int(np.clip(length / _LEG, 1, _MOST_LEGS))
    s = (np.arange(many) + 0.5) * length / many
    step = length / (4 * many)
    known = np.concatenate([[0.0], _SHARES * length, [length]])
    there = []
    for at in (s - step, s, s + step):
        x, y, hdg = pose(rows.plan_view, np.full(many, row), at)
        t = outwards * np.interp(at, known, np.concatenate([[0.0], out, [0.0]]))
        there.append((x - t * np.sin(hdg), y + t * np.cos(hdg)))
    (x0, y0), (x, y), (x1, y1) = there
    return x, y, np.arctan2(y1 - y0, x1 - x0)
