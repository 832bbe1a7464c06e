"""Rings of roundabouts become circles, or smooth closed curves, whatever the streets that they consist of.

A ring is a row of streets, all of them part of a roundabout, that follow each other around. It is fitted as a whole
and then cut into the curves of its streets; the ends of other streets that join it move onto it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import (
    arctan2,
    chain_curves,
    cosine,
    cut_curves,
    hypot,
    pose,
    reverse_curves,
    running_lengths,
    sine,
    snap_cuts,
    stack_plan_views,
    starts,
    wrapped,
)
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.geometry.plan_view.arc_splines import fit_arcs, turns_of
from osm2xodr.geometry.plan_view.smooth_curves import spirals_through
from osm2xodr.model import BoolArray, FloatArray, PlanView, Street, StreetNetwork
from osm2xodr.system import record

# How far a circle may lie off the line between two nodes of a ring, m (one of 12 m drawn with four nodes is 3.5 m
# off), and from which distance on that line is a straight side of a ring that is not a circle. Choices.
_RING_OFF_CIRCLE: Final = 4.0
_RING_OFF_LINE: Final = 1.0
# Least turn of an open row of streets that counts as part of a ring (extracts cut some), rad (120 degrees).
_RING_TURN_MIN: Final = 2.09
# Points whose spread across a line is so small a share of that along it lie on it.
_ON_A_LINE: Final = 1e-12
# Over this length of a street that joins a ring the line follows its end, which moves onto the ring, m. A choice.
_RING_ARM_BLEND: Final = 15.0
# Laps of a closed curve of spirals: what its ends do to it is 0.27 times as much at each place where spirals meet, so
# 1e-11 after one lap of the fewest. Numerics.
_LAPS: Final = 3
# Intersections this near to the border of two arcs move onto it, m, so that no sliver is left between.
_SLIVER: Final = 0.1


@record(eq=False)
class FittedRings:
    """Curves of the streets of rings."""

    streets: tuple[int, ...]  # Ids of the streets, in the order of the curves
    plan_view: PlanView  # One curve per street
    stations: tuple[FloatArray, ...]  # Of each street, s of its nodes, m
    # By how much the intersections on rings, by their index, have moved onto them, x, y, m
    moved: Mapping[int, FloatArray]


@record
class _Chain:
    """Streets that follow each other."""

    legs: tuple[tuple[int, bool], ...]  # (street id, whether the chain runs along it), in order
    closed: bool  # Whether the last leads to the first


def fit_rings(network: StreetNetwork, diagnostics: Diagnostics, *, spirals: bool = True) -> FittedRings:
    """Fit the rings of a network; rings that are not smooth curves are reported and left out.

    With `spirals` rings that are not circles have continuous curvature; else they are arcs.
    """
    streets: list[int] = []
    stations: list[FloatArray] = []
    moved: dict[int, FloatArray] = {}
    plans: list[PlanView] = []
    for chain in _chains(network):
        points, first = _points(network, chain)
        if not chain.closed and abs(turns_of(points, False).sum()) < _RING_TURN_MIN:
            continue
        found = _fitted(points, chain.closed, spirals)
        if found is None:
            way = network.streets[chain.legs[0][0]].pieces[0][1].osm_way_id
            text = "the ring is neither a circle nor a smooth curve, its streets are drawn one by one"
            diagnostics.note("ring-uneven", f"way/{way}", text)
            continue
        parts, s = _cut_at_intersections(*found, first)
        plans.append(reverse_curves(parts, np.array([not along for _, along in chain.legs]), wrap=False))
        for number, (street, along) in enumerate(chain.legs):
            stations.append(s[number] if along else s[number][-1] - s[number][::-1])
            streets.append(street)
            ends = pose(plans[-1], np.array([number, number]), stations[-1][[0, -1]])
            for node, x, y in zip(
                (network.streets[street].start, network.streets[street].end), *ends[:2], strict=True
            ):
                if node >= 0 and node not in moved:
                    item = network.intersections[node]
                    moved[node] = np.array([x - item.x, y - item.y])
    # Straight sides consist of several lines in a row, which become one: checkers call such records redundant.
    plan = chain_curves(stack_plan_views(*plans), np.arange(len(streets) + 1))
    return FittedRings(tuple(streets), plan, tuple(stations), moved)


def move_ends(points: FloatArray, at_start: FloatArray | None, at_end: FloatArray | None) -> FloatArray:
    """Move the ends of a street with nodes (n, 2) by x, y, (2,), m; the line follows over `_RING_ARM_BLEND`."""
    if at_start is None and at_end is None:
        return points
    chainage = running_lengths(points)
    blend = min(_RING_ARM_BLEND, float(chainage[-1]))
    out = points.copy()
    for shift, away in ((at_start, chainage), (at_end, chainage[-1] - chainage)):
        if shift is not None:
            out += np.clip(1.0 - away / blend, 0.0, 1.0)[:, None] * shift
    return out


# ---------------------------------------------------------------- which streets


def _chains(network: StreetNetwork) -> list[_Chain]:
    """Return the rows of streets of roundabouts, as they follow each other at intersections.

    Rows end where more than two streets of roundabouts meet: two rings that touch there have no curve in common.
    """
    ring = [all(item.roundabout for _, item in street.pieces) for street in network.streets]
    at: dict[int, list[int]] = {}
    for street in network.streets:
        if ring[street.id] and street.start >= 0:
            at.setdefault(street.start, []).append(2 * street.id)
            at.setdefault(street.end, []).append(2 * street.id + 1)
    crowded = {end // 2 for ends in at.values() if len(ends) > 2 for end in ends}
    pairs = [ends for ends in at.values() if len(ends) == 2]
    follows = {one: other for ends in pairs for one, other in (ends, ends[::-1])}
    chains: list[_Chain] = []
    seen: set[int] = set()
    for street in network.streets:
        if not ring[street.id] or street.id in seen:
            continue
        chain = _chain(street, follows)
        seen.update(number for number, _ in chain.legs)
        if not any(number in crowded for number, _ in chain.legs):
            chains.append(chain)
    return chains


def _chain(street: Street, follows: Mapping[int, int]) -> _Chain:
    """Return the row of streets that a street belongs to; `follows` leads from street end to street end."""
    if street.start < 0:
        return _Chain(((street.id, True),), True)
    first = 2 * street.id
    # Back to the first street of the row, or once around.
    while first in follows and follows[first] // 2 != street.id:
        first = follows[first] ^ 1
    if first in follows and follows[first] == 2 * street.id + 1:
        first = 2 * street.id
    legs = [(first // 2, first % 2 == 0)]
    last = first ^ 1
    while last in follows and follows[last] != first:
        last = follows[last]
        legs.append((last // 2, last % 2 == 0))
        last ^= 1
    return _Chain(tuple(legs), last in follows)


def _points(network: StreetNetwork, chain: _Chain) -> tuple[FloatArray, list[int]]:
    """Return the nodes of a chain, (n, 2), and the indices where each leg begins and the last ends.

    The first node of a closed chain is not repeated at its end.
    """
    lines = [network.streets[street].points[:: 1 if along else -1] for street, along in chain.legs]
    first = starts([len(line) - 1 for line in lines]).tolist()
    points = np.concatenate([line[:-1] for line in lines])
    return (points if chain.closed else np.concatenate([points, lines[-1][-1:]])), first


# ---------------------------------------------------------------- their curve


def _fitted(points: FloatArray, closed: bool, spirals: bool) -> tuple[PlanView, FloatArray] | None:
    """Return the curve of a ring and s of its nodes, and of the first again if it is closed; None without one."""
    middle = points.mean(axis=0)
    own = points - middle
    outline = np.concatenate([own, own[:1]]) if closed else own
    if len(outline) < 4:
        return None
    found = None if _sides(outline, _RING_OFF_CIRCLE).any() else _circle(own, closed)
    if found is None:
        line, node = _with_points_on_sides(outline, _sides(outline, _RING_OFF_LINE))
        found = fit_arcs(line[:-1] if closed else line, closed)
        if found is None:
            return None
        plan, s = _with_spirals(found[0], closed, found[1]) if spirals else found
        found = plan, s[node[: len(points)]]
    plan, s = found
    s = np.append(s, plan.length.sum()) if closed else s
    if (np.diff(s) <= 0).any():
        return None
    plan = replace(plan, x=plan.x + middle[0], y=plan.y + middle[1])
    return plan, s


def _with_spirals(plan: PlanView, closed: bool, s: FloatArray) -> tuple[PlanView, FloatArray]:
    """Return a curve of spirals that passes the places where the arcs of another meet, and places s along it, m.

    A closed curve goes round `_LAPS` times, so that the lap in the middle does not feel the ends.
    """
    arcs, laps = len(plan.s), _LAPS if closed else 1
    turn = float(plan.hdg[-1] + plan.curvature[-1] * plan.length[-1] - plan.hdg[0])
    end_x, end_y, _ = pose(plan, np.array([0]), plan.length.sum(keepdims=True))
    x, y = (np.append(np.tile(own, laps), end) for own, end in ((plan.x, end_x), (plan.y, end_y)))
    hdg = np.append((plan.hdg + turn * np.arange(laps)[:, None]).ravel(), plan.hdg[0] + turn * laps)
    every, _ = spirals_through(x, y, hdg, np.array([0, len(x)]))
    lap = slice(laps // 2 * arcs, (laps // 2 + 1) * arcs)
    columns = {item.name: getattr(every, item.name)[lap] for item in fields(PlanView)[1:]}
    columns |= {"s": columns["s"] - columns["s"][0], "hdg": columns["hdg"] - turn * (laps // 2)}
    new = PlanView(plan.start, **columns)
    old, borders = (np.append(item.s, item.length.sum()) for item in (plan, new))
    return new, np.interp(s, old, borders)


def _sides(outline: FloatArray, most: float) -> BoolArray:
    """Say which segments, (nodes - 1,), are more than `most`, m, off a circle of the outline's length."""
    size = hypot(*np.diff(outline, axis=0).T)
    radius = float(size.sum()) / (2 * np.pi)
    half = np.minimum(size / 2, radius)
    return np.asarray(radius - np.sqrt(radius**2 - half**2) > most)


def _with_points_on_sides(outline: FloatArray, side: BoolArray) -> tuple[FloatArray, list[int]]:
    """Return a line with points along those segments that are straight sides, and the indices of its nodes."""
    size = hypot(*np.diff(outline, axis=0).T)
    parts = np.where(side, np.ceil(size / defaults.RING_SIDE), 1).astype(np.int64)
    lines = [
        one + (other - one) * np.arange(count)[:, None] / count
        for one, other, count in zip(outline[:-1], outline[1:], parts.tolist(), strict=True)
    ]
    return np.concatenate([*lines, outline[-1:]]), starts(parts).tolist()


def _circle(points: FloatArray, closed: bool) -> tuple[PlanView, FloatArray] | None:
    """Return the circle that passes nearest to points and s of each; None where a point lies too far off.

    Least squares of the algebraic distance (Kåsa 1976, doi:10.1109/TIM.1976.6312298). Its bias towards small circles
    is negligible: the points of a ring lie all around.
    """
    middle = points.mean(axis=0)
    u, v = np.ascontiguousarray((points - middle).T)
    square = u * u + v * v
    uu, uv, vv = (float(product.sum()) for product in (u * u, u * v, v * v))
    right_u, right_v = 0.5 * float((u * square).sum()), 0.5 * float((v * square).sum())
    determinant = uu * vv - uv * uv
    if determinant <= _ON_A_LINE * (uu + vv) ** 2:
        return None
    x, y = (right_u * vv - right_v * uv) / determinant, (right_v * uu - right_u * uv) / determinant
    radius = math.sqrt(x * x + y * y + (uu + vv) / len(points))
    dx, dy = u - x, v - y
    x, y = x + middle[0], y + middle[1]
    off = hypot(dx, dy) - radius
    if np.abs(off).max() > defaults.RING_TOLERANCE or np.sqrt((off**2).mean()) > defaults.RING_CIRCLE_RMS:
        return None
    angle = np.unwrap(arctan2(dy, dx))
    if closed:
        step = wrapped(np.diff(angle, append=angle[0]))
        around = round(float(step.sum()) / (2 * np.pi))
        turn = 2 * np.pi * around
        if abs(around) != 1:
            return None
    else:
        turn = float(angle[-1] - angle[0])
    side = float(np.sign(turn))
    s = side * (angle - angle[0]) * radius
    start = x + radius * cosine(angle[0]), y + radius * sine(angle[0]), angle[0] + side * np.pi / 2
    columns = (np.array([value]) for value in (0.0, *start, abs(turn) * radius, side / radius))
    return PlanView(np.array([0, 1]), *columns), s


def _cut_at_intersections(plan: PlanView, s: FloatArray, first: Sequence[int]) -> tuple[PlanView, list[FloatArray]]:
    """Cut a ring's curve where its legs begin and end; also return s of each leg's nodes on the leg's own curve."""
    curve = np.zeros(len(first), np.int64)
    cut = snap_cuts(plan, curve, s[np.array(first)], _SLIVER)
    cut[0], cut[-1] = 0.0, s[-1]
    if (np.diff(cut) < _SLIVER).any():
        cut = s[np.array(first)]
    parts = cut_curves(plan, cut[:-1], cut[1:], curve[:-1])
    legs = []
    for k, (lo, hi) in enumerate(pairwise(first)):
        own = np.clip(s[lo : hi + 1], cut[k], cut[k + 1]) - cut[k]
        own[0], own[-1] = 0.0, cut[k + 1] - cut[k]
        legs.append(own)
    return parts, legs
