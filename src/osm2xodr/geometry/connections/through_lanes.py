"""Lanes that lead on lie in line where their number changes, and on both sides of junctions (docs/method/lanes.md).

OSM's lines tell where carriageways are, and often not where among the lanes: if roads lay about the middle of the
lines everywhere, cars would shift by half a lane where one opens beside theirs.

Roads shift toward the opposite carriageway of their street as far as there is room. Lanes also narrow towards a
junction that leads to narrower ones, where the roads through it are too short for that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Final

import numpy as np
import scipy.sparse as sp

from osm2xodr.curves import PointTree, cosine, curve_ends, pose, sine, solve_sparse, unique_all, unique_rows, wrapped
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import defaults
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads
from osm2xodr.geometry.connections.defaults import STEEPEST_JOIN, TAPER_PER_WIDTH
from osm2xodr.geometry.defaults import STEEPEST_WIDTH
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.lanes import (
    Stretch,
    change_between,
    room_for_tapers,
    shifted_stretch,
    with_narrow_ends,
    with_shifted_ends,
)
from osm2xodr.model import BoolArray, Direction, FloatArray, IntArray, Rule

# Ends that shift are compared over this length, m: about that over which their shift fades.
_END: Final = 20.0
# More lanes than any road has at a side: a road end's lanes get numbers of their own.
_MOST_LANES: Final = 64
# Widths are rounded to this many decimals of a metre, downwards.
_WIDTH_DECIMALS: Final = 2
_SAME_WIDTH: Final = 1e-6
# Where lanes narrow, the ways between them are drawn again, and have this share of their length at least. A choice:
# of six in three towns the shortest had 0.92, and 0.03 are in what is above.
_SHORTER: Final = 0.94


@dataclass(slots=True)
class _Shifts:
    """How far parts of roads shift to the left, and what is known of that."""

    # Of each part how much it counts that it stays, and how far it shifts at most, m
    weight: list[float] = field(default_factory=list)
    most: list[float] = field(default_factory=list)
    # Of lanes in line: how far they are off to the left behind a border, m, and the parts before and behind it, -1
    # for none, each with the sign of its left as drivers see it
    off: list[float] = field(default_factory=list)
    before: list[tuple[int, float]] = field(default_factory=list)
    behind: list[tuple[int, float]] = field(default_factory=list)

    def part(self, stretch: Stretch) -> int:
        """Return the number of a new part."""
        turns = any(lane.turns for lane in (*stretch.section.left, *stretch.section.right))
        weight = defaults.IN_LINE_WEIGHT_TURNS if turns else defaults.IN_LINE_WEIGHT
        if stretch.attributes.middle_offset:
            weight = defaults.IN_LINE_WEIGHT_KNOWN
        self.weight.append(weight)
        self.most.append(defaults.IN_LINE_MOST_TURNS if turns else defaults.IN_LINE_MOST)
        return len(self.weight) - 1

    def in_line(self, off: float, before: tuple[int, float], behind: tuple[int, float]) -> None:
        """Note that lanes lead on which are off."""
        if abs(off) <= defaults.IN_LINE_FARTHEST and max(before[0], behind[0]) >= 0:
            self.off.append(off)
            self.before.append(before)
            self.behind.append(behind)

    def found(self) -> FloatArray:
        """Return the shifts with the least squares, of each part, (parts,), m."""
        shape = len(self.off), len(self.weight)
        entries = [(k, n, s) for k, (n, s) in enumerate(self.behind) if n >= 0]
        entries += [(k, n, -s) for k, (n, s) in enumerate(self.before) if n >= 0]
        row, column, sign = (np.array(item) for item in zip(*entries, strict=True))
        matrix = sp.csr_matrix((sign, (row, column)), shape)
        found = solve_sparse(matrix.T @ matrix + sp.diags(self.weight), -(matrix.T @ np.array(self.off)))
        most = np.array(self.most)
        return np.asarray(np.where(np.abs(found) < defaults.IN_LINE_LEAST, 0.0, np.clip(found, -most, most)))


def keep_lanes_in_line(parts: RoadParts, connecting: ConnectingRoads, rule: Rule) -> RoadParts:
    """Return roads whose lanes shift to the side to lead straight on where they did not.

    Least squares: unknown is how far short stretches shift, and the ends of longer ones at junctions; observed is
    that they do not, and that lanes are in line.
    """
    row, off = _straight_on(connecting, parts)
    entry, exit_ = connecting.entry[row].tolist(), connecting.exit[row].tolist()
    used = {end // 2 for end in (*entry, *exit_)}
    shifts = _Shifts()
    # Of each road the parts that its start, its stretches, and its end are.
    numbers = {
        road: _parts_of(stretches, parts.end_link[road].tolist(), shifts, rule)
        for road, stretches in enumerate(parts.stretches)
        if road in used or len(stretches) > 1
    }
    for one, other, aside in zip(entry, exit_, off.tolist(), strict=True):
        before, behind = (numbers[end // 2][-1 if end % 2 else 0] for end in (one, other))
        shifts.in_line(aside, (before, 1.0 if one % 2 else -1.0), (behind, -1.0 if other % 2 else 1.0))
    if not shifts.off:
        return parts
    shift = shifts.found()
    found = [*(shift * shares_with_room(parts, numbers, shift)).tolist(), 0.0]
    stretches = list(parts.stretches)
    for road, part in numbers.items():
        aside = [found[k] for k in part]
        if any(aside):
            stretches[road] = _shifted(stretches[road], aside, part, rule)
    return replace(parts, stretches=tuple(stretches))


def _straight_on(connecting: ConnectingRoads, parts: RoadParts) -> tuple[IntArray, FloatArray]:
    """Return a connecting road of each two road ends that lead straight on to each other, and how far to the left, m.

    Of several it is the one that leads straightest on: lanes that open beside it are farther off.
    """
    plan = connecting.plan_view
    (x0, y0, hdg0), (x1, y1, hdg1) = curve_ends(plan)
    turn = wrapped(hdg1 - hdg0)
    hdg = hdg0 + turn / 2
    off = (y1 - y0) * cosine(hdg) - (x1 - x0) * sine(hdg)
    straight = (
        (np.abs(turn) <= defaults.IN_LINE_BEND)
        & (np.abs(off) <= defaults.IN_LINE_FARTHEST)
        & connecting.for_vehicles()
    )
    row = np.flatnonzero(straight & (connecting.entry != connecting.exit))
    arms = zip(connecting.entry[row].tolist(), connecting.exit[row].tolist(), strict=True)
    row = row[np.array([_is_ramp(parts, one) == _is_ramp(parts, other) for one, other in arms], bool)]
    row = row[np.argsort(np.abs(off[row]), kind="stable")]
    row = row[_first_of(connecting.entry[row], connecting.exit[row])]
    # Each end has one partner, that of the ends which bends least.
    row = row[np.argsort(np.abs(turn[row]), kind="stable")]
    row = row[_first_of(connecting.entry[row]) & _first_of(connecting.exit[row])]
    return row, off[row]


def _is_ramp(parts: RoadParts, end: int) -> bool:
    return parts.at_end(end).attributes.highway.endswith("_link")


def _first_of(*keys: IntArray) -> BoolArray:
    """Say which of some keys, columns of rows, were not there before, (n,)."""
    out = np.zeros(len(keys[0]), bool)
    out[unique_rows(np.column_stack(keys)).first] = True
    return out


def _parts_of(stretches: Sequence[Stretch], link: Sequence[int], shifts: _Shifts, rule: Rule) -> list[int]:
    """Return the parts that shift of a road's start, its stretches and its end, -1 for what does not.

    Short stretches shift as a whole; longer ones at the road's ends alone. Where a road touches another, `link`, it
    stays.
    """
    linked = {place for place, other in ((0, link[0]), (len(stretches) - 1, link[1])) if other >= 0}
    inner = [
        shifts.part(item) if k not in linked and item.length < defaults.IN_LINE_SECONDS * _speed(item) else -1
        for k, item in enumerate(stretches)
    ]
    ends = [
        inner[k] if inner[k] >= 0 or other >= 0 else shifts.part(stretches[k])
        for k, other in zip((0, -1), link, strict=True)
    ]
    for (one, before), (other, behind) in pairwise(zip(stretches, inner, strict=True)):
        change = change_between(one, other, rule)
        if change.beside:
            shifts.in_line(change.aside, (before, 1.0), (behind, 1.0))
    return [ends[0], *inner, ends[1]]


def _speed(stretch: Stretch) -> float:
    """Return how fast cars drive on a stretch, m/s."""
    return min(stretch.attributes.speed_along(Direction.BOTH) or defaults.TOWN_SPEED, defaults.SHIFT_SPEED)


def _shifted(stretches: tuple[Stretch, ...], aside: list[float], part: list[int], rule: Rule) -> tuple[Stretch, ...]:
    """Return the stretches of a road that shift, by what its start, its stretches and its end do, m."""
    out = tuple(
        shifted_stretch(item, shift) if shift else item for item, shift in zip(stretches, aside[1:-1], strict=True)
    )
    start, end = (aside[k] if aside[k] and part[k] != part[beside] else None for k, beside in ((0, 1), (-1, -2)))
    if start is None and end is None:
        return out
    shifted = with_shifted_ends(out, start, end, rule)
    # Not at the cost of lanes that have no room then.
    return shifted if len(shifted) == len(out) + (start is not None) + (end is not None) else out


def shares_with_room(parts: RoadParts, numbers: Mapping[int, Sequence[int]], shift: FloatArray) -> FloatArray:
    """Return which share of its shift each part may keep, (parts,), so that opposite carriageways stay apart.

    `shift` (parts,) is to the left, m. `numbers` has of each road the parts that its start, its stretches and its end
    are, -1 for what stays.
    """
    share = np.ones(len(shift))
    road, s, part, edge, motorway = _places(parts, numbers)
    aside = np.append(shift, 0.0)[part]
    moved = np.flatnonzero(aside)
    if not len(moved):
        return share
    x, y, hdg = pose(parts.plan_view, road, s)
    xy = np.column_stack([x, y])
    reach = 2 * float(edge.max()) + defaults.PARALLEL_SPACING
    a, b = PointTree(xy).within(xy[moved], reach)
    a = moved[a]
    (dx, dy), cos, sin = (xy[b] - xy[a]).T, cosine(hdg[a]), sine(hdg[a])
    along, across, turn = dx * cos + dy * sin, dy * cos - dx * sin, hdg[b] - hdg[a]
    abreast = (np.abs(along) <= 0.5 * defaults.PARALLEL_SPACING) & (np.abs(sine(turn)) < defaults.PARALLEL_SINE)
    side, sign = (across < 0).astype(np.int64), np.sign(across)
    gap = np.where(motorway[a] & motorway[b], defaults.LEAST_MEDIAN, defaults.PARALLEL_GAP)
    room = np.abs(across) - edge[a, side] - edge[b, side] - gap
    own, other = np.maximum(sign * aside[a], 0.0), np.maximum(sign * aside[b], 0.0)
    tight = np.flatnonzero(abreast & (cosine(turn) < 0) & (own > 0) & (own + other > room))
    np.minimum.at(share, part[a[tight]], np.maximum(room[tight], 0.0) / (own + other)[tight])
    return share


def _places(
    parts: RoadParts, numbers: Mapping[int, Sequence[int]]
) -> tuple[IntArray, FloatArray, IntArray, FloatArray, BoolArray]:
    """Return places along one-way roads.

    These are road, s, m, part, -1 for none, distance of both edges, (n, 2), m, and whether it is a motorway.
    """
    rows = [
        (road, item, part)
        for road, stretches in enumerate(parts.stretches)
        for item, part in zip(stretches, numbers.get(road, [-1] * (len(stretches) + 2))[1:-1], strict=True)
        if len(item.attributes.car_directions()) == 1
    ]
    steps = [np.arange(item.start, item.end, 0.5 * defaults.PARALLEL_SPACING) for _, item, _ in rows]
    count = [len(s) for s in steps]
    road = np.repeat(np.array([road for road, _, _ in rows], np.int64), count)
    part = np.repeat(np.array([part for _, _, part in rows], np.int64), count)
    edges = np.array([(item.section.left_edge, -item.section.right_edge) for _, item, _ in rows]).reshape(-1, 2)
    s = np.concatenate([np.zeros(0), *steps])
    ends = np.array([(own[0], own[-1]) for own in (numbers.get(k, (-1, -1)) for k in range(len(parts.length)))])
    for end, distance in enumerate((s, parts.length[road] - s)):
        part = np.where((part < 0) & (distance < _END), ends.reshape(-1, 2)[road, end], part)
    motorway = np.array([item.attributes.highway == "motorway" for _, item, _ in rows], bool)
    return road, s, part, np.repeat(edges, count, axis=0), np.repeat(motorway, count)


def even_widths(parts: RoadParts, connecting: ConnectingRoads, rule: Rule, diagnostics: Diagnostics) -> RoadParts:
    """Return roads whose lanes narrow towards junctions where connecting roads would taper too fast.

    Widths only shrink: each lane gets the largest width from which tapers lead to all others that it is linked to,
    `TAPER_PER_WIDTH` times as long as widths change; roads without changes of their own taper from end to end.
    """
    ends = np.concatenate([connecting.entry, connecting.exit])
    lanes = np.concatenate([connecting.entry_lane, connecting.exit_lane])
    keys, first, number, _ = unique_all(ends * 2 * _MOST_LANES + lanes + _MOST_LANES)
    before = np.concatenate([connecting.entry_width, connecting.exit_width])[first]
    one, other = number.reshape(2, -1)
    along = _along_roads(parts, keys)
    one, other = np.concatenate([one, along[0]]), np.concatenate([other, along[1]])
    # Bicycle lanes that join lanes for cars may fan out at their end.
    steeper = np.where(connecting.joins_cars, STEEPEST_JOIN / STEEPEST_WIDTH, 1.0)
    length = np.concatenate(
        [connecting.length * steeper, [room_for_tapers(item) for item in parts.length[along[2]].tolist()]]
    )
    step, width = 10.0**_WIDTH_DECIMALS, before
    for share in (1.0, _SHORTER):
        again = (np.minimum(width[one] - before[one], width[other] - before[other]) < 0.0)[: len(connecting.length)]
        length[: len(again)] *= np.where(again, share, 1.0)
        # Rounding may take one end down by all of a step, and the other by nothing.
        width = _reachable(before, one, other, np.maximum(length / TAPER_PER_WIDTH - 1 / step, 0.0))
    narrowed = np.flatnonzero(width < before - _SAME_WIDTH)
    if not len(narrowed):
        return parts
    found: dict[int, dict[int, float]] = {}
    for key, new in zip(keys[narrowed].tolist(), (np.floor(width[narrowed] * step) / step).tolist(), strict=True):
        end, lane = divmod(key, 2 * _MOST_LANES)
        found.setdefault(end, {})[lane - _MOST_LANES] = new
    stretches = list(parts.stretches)
    for road in sorted({end // 2 for end in found}):
        # Where roads touch without a junction between them, their widths stay what they are.
        low, high = (found.get(2 * road + k, {} if parts.end_link[road, k] >= 0 else None) for k in (0, 1))
        stretches[road] = with_narrow_ends(stretches[road], low, high, rule)
    text = "its lanes narrow towards a junction that leads to narrower ones within a few metres"
    for end in sorted(found):
        diagnostics.repaired("lanes-narrowed", f"way/{parts.at_end(end).attributes.osm_way_id}", text)
    return replace(parts, stretches=tuple(stretches))


def _along_roads(parts: RoadParts, keys: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return which lanes at either end of a road are the same, as indices of keys, and the road, (n,)."""
    end, lane = np.divmod(keys, 2 * _MOST_LANES)
    alike = np.array([len(item) == 1 for item in parts.stretches], bool)
    start = np.flatnonzero((end % 2 == 0) & alike[end // 2])
    beyond = (end[start] + 1) * 2 * _MOST_LANES + lane[start]
    place = np.minimum(np.searchsorted(keys, beyond), len(keys) - 1)
    both = keys[place] == beyond
    return start[both], place[both], end[start[both]] // 2


def _reachable(width: FloatArray, one: IntArray, other: IntArray, most: FloatArray) -> FloatArray:
    """Return the largest widths up to given ones of which no linked two differ by more than they may, m."""
    out = width.copy()
    while True:
        last = out.copy()
        np.minimum.at(out, one, out[other] + most)
        np.minimum.at(out, other, out[one] + most)
        if (out > last - _SAME_WIDTH).all():
            return out
