"""Reference lines move to the outside of bends that would lead readers astray where they lie.

A reader that steps along the reference line steps too far in a lane outside of it. Within a road that is a matter of
the road's shape, but over its end, or over the start of a lane section, the lane is missed. Where a bend cannot be
left to a junction (`straight_ends`), the reference line runs along its outer lane instead; the lanes stay in place.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from osm2xodr.curves import find_record, lengths
from osm2xodr.geometry import defaults
from osm2xodr.geometry.junctions.clusters import JunctionLayout
from osm2xodr.geometry.junctions.road_parts import RoadParts
from osm2xodr.geometry.lanes import CrossSection
from osm2xodr.geometry.plan_view import FittedStreets, bends_tightly, outermost_lanes
from osm2xodr.model import FloatArray, IntArray, PlanView

_PROBES = np.arange(0.0, 3.01, 0.25)
# Ends of roads often lie where a bend ends: so far within, m, it is certain which side of that is meant.
_WITHIN = 1e-6
_CHOICES = np.linspace(0.0, 1.0, 5)
# A curve may shrink to this share of itself where its line moves towards the inside.
_LEAST_SHARE = 0.4
# More than any lane is longer than its line.
_NEVER = 1e9


def shift_lines_out_of_bends(
    fitted: FittedStreets, layout: JunctionLayout, parts: RoadParts
) -> tuple[FittedStreets, JunctionLayout]:
    """Move the reference lines of streets whose roads end, or whose lanes change, in a tight bend.

    Parameters
    ----------
    fitted
        Streets with their reference lines on the lines of OSM.
    layout
        Junctions, with the trims that are final but for this.
    parts
        The roads that they make.

    Returns
    -------
    fitted, layout
        With the lines moved, and trims that end the roads in the same places.
    """
    aside = _aside(fitted, parts)
    if not aside.any():
        return fitted, layout
    old = fitted.plan_view
    plan = offset_curves(old, aside)
    moved = np.flatnonzero(aside)
    pieces = list(fitted.pieces)
    for street in moved.tolist():
        s = _station(old, plan, np.full(len(pieces[street]), street), np.array([p[0] for p in pieces[street]]))
        shift = float(aside[street])
        pieces[street] = tuple(
            (place, attributes, _shifted(section, shift))
            for place, (_, attributes, section) in zip(s.tolist(), pieces[street], strict=True)
        )
    before, after = lengths(old)[moved], lengths(plan)[moved]
    trim = layout.trim.copy()
    trim[2 * moved] = _station(old, plan, moved, trim[2 * moved])
    trim[2 * moved + 1] = after - _station(old, plan, moved, before - trim[2 * moved + 1])
    return FittedStreets(plan, tuple(pieces), aside), replace(layout, trim=trim)


def offset_curves(plan: PlanView, aside: FloatArray) -> PlanView:
    """Return curves that run beside those of a table, (curves,) m to the left of each."""
    owner = np.repeat(np.arange(len(plan.start) - 1), np.diff(plan.start))
    d = aside[owner]
    share = 1.0 - plan.curvature * d
    length = plan.length * share
    end = np.cumsum(length)
    s = end - length
    base = s[np.minimum(plan.start[:-1], max(len(s) - 1, 0))]
    first = np.diff(owner, prepend=-1) > 0
    return PlanView(
        plan.start.copy(),
        np.where(first, 0.0, s - base[owner]),
        plan.x - d * np.sin(plan.hdg),
        plan.y + d * np.cos(plan.hdg),
        plan.hdg.copy(),
        length,
        plan.curvature / share,
    )


def _station(old: PlanView, new: PlanView, curve: IntArray, s: FloatArray) -> FloatArray:
    """Return s on a moved curve at the place that has s on the curve before."""
    k = find_record(old.start, old.s, curve, s)
    share = new.length[k] / np.maximum(old.length[k], 1e-12)
    out: FloatArray = new.s[k] + (s - old.s[k]) * share
    return out


def _shifted(section: CrossSection, aside: float) -> CrossSection:
    return replace(
        section,
        centre=section.centre - aside,
        left_edge=section.left_edge - aside,
        right_edge=section.right_edge - aside,
    )


def _places(parts: RoadParts) -> tuple[IntArray, FloatArray]:
    """Return street and s of what must not lie in a tight bend: ends of roads, from within, and lane changes."""
    street: list[IntArray] = []
    at: list[FloatArray] = []
    end = parts.begin + parts.length
    for probe in _PROBES + _WITHIN:
        street += [parts.street, parts.street]
        at += [np.minimum(parts.begin + probe, end), np.maximum(end - probe, parts.begin)]
    changes = [
        (int(parts.street[road]), float(parts.begin[road]) + item.start)
        for road, stretches in enumerate(parts.stretches)
        for item in stretches[1:]
    ]
    if changes:
        where, s = np.array([k for k, _ in changes], np.int64), np.array([s for _, s in changes])
        for probe in (*-_PROBES[:0:-1], *_PROBES):
            street.append(where)
            at.append(s + probe)
    return np.concatenate(street), np.concatenate(at)


def _aside(fitted: FittedStreets, parts: RoadParts) -> FloatArray:
    """Return how far to the left each street's line is to move, (streets,), m: as little as does, mostly 0."""
    plan = fitted.plan_view
    out = np.zeros(len(plan.start) - 1)
    right, left = (np.array(column) for column in zip(*(outermost_lanes(p) for p in fitted.pieces), strict=True))
    tight = bends_tightly(plan, np.arange(len(out)), right, left)
    if not tight.any():
        return out
    street, s = _places(parts)
    near = tight[street]
    street, s = street[near], s[near]
    curvature = plan.curvature[find_record(plan.start, plan.s, street, s)]

    def stretch(aside: FloatArray) -> FloatArray:
        share = 1.0 - curvature * aside[street]
        outer = 1.0 - np.minimum(curvature * right[street], curvature * left[street])
        worst = np.ones(len(out))
        np.maximum.at(worst, street, outer / np.maximum(share, 1e-3))
        return worst

    best = stretch(out)
    candidates = best > 1.0 + defaults.TIGHT_BEND
    if not candidates.any():
        return out
    owner = np.repeat(np.arange(len(out)), np.diff(plan.start))

    def moved_by(aside: FloatArray) -> FloatArray:
        shrunk = np.ones(len(out))
        np.minimum.at(shrunk, owner, 1.0 - plan.curvature * aside[owner])
        return np.where(shrunk > _LEAST_SHARE, stretch(aside), _NEVER)

    for choice in _CHOICES[1:]:
        # Of both sides the better one, so that it does not matter which way the street is drawn.
        to_right, to_left = np.round(right * choice, 2), np.round(left * choice, 2)
        by_right, by_left = moved_by(to_right), moved_by(to_left)
        even = np.abs(by_right - by_left) < 1e-6
        rightwards = np.where(even, np.abs(to_right) < np.abs(to_left), by_right < by_left)
        aside, worst = np.where(rightwards, to_right, to_left), np.where(rightwards, by_right, by_left)
        better = candidates & (best > 1.0 + defaults.TIGHT_BEND) & (worst < best - 1e-6)
        out = np.where(better, aside, out)
        best = np.where(better, worst, best)
    return out
