"""Reference lines move to the outside of tight bends where roads end or lanes change.

A reader that steps along the reference line steps too far in a lane outside of it, and misses the lane beyond a
road's end or the start of a lane section. Where no junction can take the bend (`trims_clear_of_bends`), the reference
line runs along its outer lane instead; the lanes stay in place.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import (
    advance,
    arctan2,
    cosine,
    curvature_at,
    cut_records,
    end_curvature,
    find_record,
    hypot,
    lengths,
    owners,
    ranks,
    repeated,
    sine,
    spirals_between,
    wrapped,
)
from osm2xodr.geometry import defaults
from osm2xodr.geometry.junctions.clusters import JunctionLayout
from osm2xodr.geometry.junctions.road_parts import RoadParts
from osm2xodr.geometry.lanes import taper_zones
from osm2xodr.geometry.plan_view import FittedStreets, has_tight_bend, outermost_lanes
from osm2xodr.model import FloatArray, IntArray, PlanView, Rule

# A bend matters up to 3 m from the end of a road or a change of lanes: distances at which it is looked for, m.
_PROBES: Final = np.arange(0.0, 3.01, 0.25)
# Ends of roads often lie where a bend ends: this far within the road, m, it is certain which side of that is meant.
_WITHIN: Final = 1e-6
# Shares of the way from the line of OSM to the outer lane that lines are moved by; the smallest that does is taken.
_SHIFT_SHARES: Final = np.linspace(0.25, 1.0, 4)
# A curve may shrink to this share of itself where its line moves towards the inside. A choice.
_SMALLEST_SCALE: Final = 0.4
# Where the length beside a spiral, by that of the spiral, changes by a larger share of itself, it is moved in parts,
# no shorter than so many m: curvature at their ends is off by 0.001 / m, or a percent. Choices.
_MOST_CHANGE: Final = 0.1
_SHORTEST_PART: Final = 0.5
# A lane is never longer than its line by this factor.
_TOO_LONG: Final = 1e9
# Shifts are rounded to this many decimals of a metre; ratios of lengths that differ by less than this are equal.
_SHIFT_DECIMALS: Final = 2
_SAME_RATIO: Final = 1e-6


def shift_lines_out_of_bends(
    fitted: FittedStreets, layout: JunctionLayout, parts: RoadParts, rule: Rule
) -> tuple[FittedStreets, JunctionLayout]:
    """Move the reference lines of streets whose roads end, or whose lanes change, in a tight bend.

    The lines are OSM's so far. The layout returned has trims that end the roads in the same places.
    """
    aside = _aside(fitted, parts, rule)
    if not aside.any():
        return fitted, layout
    old = in_short_spirals(fitted.plan_view, aside)
    plan = offset_curves(old, aside)
    moved = np.flatnonzero(aside)
    pieces = list(fitted.pieces)
    for street in moved.tolist():
        at = np.array([p[0] for p in pieces[street]])
        s = _station(old, plan, np.full(len(at), street), at, aside)
        d = float(aside[street])
        pieces[street] = tuple(
            (
                place,
                attributes,
                replace(c, centre=c.centre - d, left_edge=c.left_edge - d, right_edge=c.right_edge - d),
            )
            for place, (_, attributes, c) in zip(s.tolist(), pieces[street], strict=True)
        )
    before, after = lengths(old, moved), lengths(plan, moved)
    trim = layout.trim.copy()
    trim[2 * moved] = _station(old, plan, moved, trim[2 * moved], aside)
    trim[2 * moved + 1] = after - _station(old, plan, moved, before - trim[2 * moved + 1], aside)
    return replace(fitted, plan_view=plan, pieces=tuple(pieces), aside=aside), replace(layout, trim=trim)


def offset_curves(plan: PlanView, aside: FloatArray) -> PlanView:
    """Return curves that run beside others, `aside` to the left of each, (curves,), m.

    What runs beside a line or an arc is one; beside a short spiral it is all but the spiral between the same poses.
    """
    owner = owners(plan.start)
    d = aside[owner]
    share = 1.0 - plan.curvature * d
    length, curvature, rate = plan.length * share, plan.curvature / share, np.zeros(len(d))
    x, y, hdg = plan.x - d * sine(plan.hdg), plan.y + d * cosine(plan.hdg), plan.hdg
    k = np.flatnonzero(plan.rate)
    if len(k):
        x1, y1, hdg1 = advance(plan.x[k], plan.y[k], hdg[k], plan.curvature[k], plan.length[k], plan.rate[k])
        dx, dy = x1 - d[k] * sine(hdg1) - x[k], y1 + d[k] * cosine(hdg1) - y[k]
        chord = arctan2(dy, dx)
        before = wrapped(hdg[k] - chord)
        turn = hdg1 - hdg[k]
        shape, longer = spirals_between(before, before + turn)
        length[k] = hypot(dx, dy) * longer
        curvature[k] = (turn - shape) / length[k]
        rate[k] = 2.0 * shape / length[k] ** 2
    same = np.flatnonzero(aside == 0.0)
    kept = np.isin(owner, same)
    length, curvature, rate = (
        np.where(kept, old, new)
        for old, new in ((plan.length, length), (plan.curvature, curvature), (plan.rate, rate))
    )
    end = np.cumsum(length)
    s = end - length
    base = s[np.minimum(plan.start[:-1], max(len(s) - 1, 0))]
    # Not by sums over other curves where nothing moves.
    at = np.where(d != 0.0, s - base[owner], plan.s)
    return PlanView(plan.start.copy(), at, x, y, hdg.copy(), length, curvature, rate)


def in_short_spirals(plan: PlanView, aside: FloatArray) -> PlanView:
    """Return the same curves with spirals so short that what runs `aside` of them, (curves,), m, are spirals, too.

    Curves that do not move stay as they are.
    """
    d = aside[owners(plan.start)]
    first, last = 1.0 - plan.curvature * d, 1.0 - end_curvature(plan) * d
    change = np.abs(last - first) / np.maximum(np.minimum(first, last), _SMALLEST_SCALE)
    most = np.maximum(plan.length / _SHORTEST_PART, 1.0)
    count = np.clip(np.ceil(change / _MOST_CHANGE), 1.0, most).astype(np.int64)
    row = repeated(count - 1)
    return cut_records(plan, row, (ranks(count - 1) + 1) * (plan.length / count)[row])


def _station(old: PlanView, new: PlanView, curve: IntArray, s: FloatArray, aside: FloatArray) -> FloatArray:
    """Return s on moved curves of the places at s on the old ones, (n,), m."""
    k = find_record(old.start, old.s, curve, s)

    def beside(ds: FloatArray) -> FloatArray:
        return np.asarray(ds * (1.0 - aside[curve] * (old.curvature[k] + 0.5 * old.rate[k] * ds)))

    share = new.length[k] / np.maximum(beside(old.length[k]), 1e-12)
    return np.asarray(new.s[k] + beside(s - old.s[k]) * share)


def _places(parts: RoadParts, rule: Rule) -> tuple[IntArray, FloatArray]:
    """Return street and s of places that must not lie in a tight bend: in roads near their ends, and lane changes."""
    street: list[IntArray] = []
    at: list[FloatArray] = []
    end = parts.begin + parts.length
    for probe in _PROBES + _WITHIN:
        street += [parts.street, parts.street]
        at += [np.minimum(parts.begin + probe, end), np.maximum(end - probe, parts.begin)]
    changes = [
        (int(parts.street[road]), float(parts.begin[road]) + s)
        for road, stretches in enumerate(parts.stretches)
        if len(stretches) > 1
        for zone, item in zip(taper_zones(stretches, rule), stretches[1:], strict=True)
        for s in sorted({zone.start, item.start, zone.end})
    ]
    where, s = np.array([k for k, _ in changes], np.int64), np.array([s for _, s in changes])
    for probe in (*-_PROBES[:0:-1], *_PROBES):
        street.append(where)
        at.append(s + probe)
    return np.concatenate(street), np.concatenate(at)


def _aside(fitted: FittedStreets, parts: RoadParts, rule: Rule) -> FloatArray:
    """Return how far to the left each street's line has to move at least, (streets,), m; mostly 0."""
    plan = fitted.plan_view
    out = np.zeros(len(plan.start) - 1)
    right, left = (np.array(column) for column in zip(*(outermost_lanes(p) for p in fitted.pieces), strict=True))
    tight = has_tight_bend(plan, np.arange(len(out)), right, left)
    if not tight.any():
        return out
    street, s = _places(parts, rule)
    near = tight[street]
    street, s = street[near], s[near]
    curvature = curvature_at(plan, street, s)

    def lengthened(aside: FloatArray) -> FloatArray:
        """Return by what factor outer lanes are longer than lines that are moved, at worst, (streets,)."""
        share = 1.0 - curvature * aside[street]
        outer = 1.0 - np.minimum(curvature * right[street], curvature * left[street])
        worst = np.ones(len(out))
        np.maximum.at(worst, street, outer / np.maximum(share, 1e-3))
        return worst

    best = lengthened(out)
    candidates = best > 1.0 + defaults.TIGHT_BEND
    if not candidates.any():
        return out
    owner, last = owners(plan.start), end_curvature(plan)

    def moved_by(aside: FloatArray) -> FloatArray:
        shrunk = np.ones(len(out))
        np.minimum.at(shrunk, owner, 1.0 - plan.curvature * aside[owner])
        np.minimum.at(shrunk, owner, 1.0 - last * aside[owner])
        return np.where(shrunk > _SMALLEST_SCALE, lengthened(aside), _TOO_LONG)

    for share in _SHIFT_SHARES:
        # The better of both sides, so that the direction in which the street is drawn does not matter.
        to_right, to_left = np.round(right * share, _SHIFT_DECIMALS), np.round(left * share, _SHIFT_DECIMALS)
        by_right, by_left = moved_by(to_right), moved_by(to_left)
        even = np.abs(by_right - by_left) < _SAME_RATIO
        rightwards = np.where(even, np.abs(to_right) < np.abs(to_left), by_right < by_left)
        aside, worst = np.where(rightwards, to_right, to_left), np.where(rightwards, by_right, by_left)
        better = candidates & (best > 1.0 + defaults.TIGHT_BEND) & (worst < best - _SAME_RATIO)
        out = np.where(better, aside, out)
        best = np.where(better, worst, best)
    return out
