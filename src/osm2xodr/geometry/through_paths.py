"""Connecting roads that keep to the streets inside their junction.

A curve from arm to arm is what a car drives at a crossing. Where a street only runs on through a long junction (a
ramp joins it, a roundabout's ring passes arm after arm), the curve must follow the street itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from osm2xodr import defaults
from osm2xodr.geometry.curves import lengths, pose, smallest_radius
from osm2xodr.geometry.movements import Movement
from osm2xodr.geometry.plan_fit import fit_polylines, replaced
from osm2xodr.geometry.street_ends import StreetEnds
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

_SPACING = 2.0
_LEAD = 1.5
_CHECKS = np.linspace(0.1, 0.9, 9)


@dataclass(frozen=True, slots=True, eq=False)
class StreetPaths:
    """OSM's ways through junctions along the curves of streets, one per movement.

    Parameters
    ----------
    start : (paths + 1,)
        Index of each path's first leg.
    curve : (legs,)
        Street.
    s_from, s_to : (legs,)
        Where on the street the leg runs, m; downwards where traffic runs against the street.
    chainage : (legs,)
        Length of the path before the leg, m.
    length : (paths,)
        m.
    sharpest : (paths,)
        Largest corner between two legs, rad.
    inner_right, inner_left : (paths,)
        Middles of the outermost lanes of the inner streets that run the way of the path, left of OSM's lines in the
        direction of travel, m; without inner streets infinitely far out.
    aside : (legs,)
        How far left of the line of OSM, in the direction of travel, the street's curve lies, m.
    on_ring : (paths,)
        Whether an inner street belongs to a roundabout.
    """

    start: IntArray
    curve: IntArray
    s_from: FloatArray
    s_to: FloatArray
    chainage: FloatArray
    length: FloatArray
    sharpest: FloatArray
    inner_right: FloatArray
    inner_left: FloatArray
    on_ring: BoolArray
    aside: FloatArray


def street_paths(
    movements: list[Movement], ends: StreetEnds, trim: FloatArray, lanes: Callable[[int, bool], tuple[float, float]]
) -> StreetPaths:
    """Lay out the way of each movement through its junction.

    Parameters
    ----------
    movements
        The ways through junctions.
    ends, trim
        Street ends and what they give to their junctions, m.
    lanes
        For a street and whether it is driven along, t of the middles of its outermost lanes, right and left in the
        direction of travel, m.
    """
    legs: list[tuple[int, float, float]] = []
    count: list[int] = []
    sharpest: list[float] = []
    sides: list[tuple[float, float]] = []
    ring: list[bool] = []
    node_s = np.where(np.arange(len(trim)) % 2 == 1, ends.length, 0.0).tolist()
    trim_s = np.where(np.arange(len(trim)) % 2 == 1, ends.length - trim, trim).tolist()
    hdg = ends.hdg.tolist()
    for item in movements:
        own = [(item.entry // 2, trim_s[item.entry], node_s[item.entry])]
        last, corner = item.entry, 0.0
        for street, along in item.inner:
            near = 2 * street + (0 if along else 1)
            own.append((street, node_s[near], node_s[near ^ 1]))
            corner = max(corner, _corner(hdg, last, near))
            last = near ^ 1
        corner = max(corner, _corner(hdg, last, item.exit))
        own.append((item.exit // 2, node_s[item.exit], trim_s[item.exit]))
        legs += own
        count.append(len(own))
        sharpest.append(corner)
        ring.append(any(bool(ends.roundabout[2 * street]) for street, _ in item.inner))
        inside = [lanes(street, along) for street, along in item.inner]
        right, left = zip(*inside, strict=True) if inside else ((-np.inf,), (np.inf,))
        sides.append((max(right), max(*right, min(left))))
    curve = np.array([leg[0] for leg in legs], np.int64)
    s_from = np.array([leg[1] for leg in legs])
    s_to = np.array([leg[2] for leg in legs])
    start = np.concatenate([[0], np.cumsum(count)]).astype(np.int64)
    size = np.abs(s_to - s_from)
    before = np.concatenate([[0.0], np.cumsum(size)])
    owner = np.repeat(np.arange(len(count)), count)
    return StreetPaths(
        start=start,
        curve=curve,
        s_from=s_from,
        s_to=s_to,
        chainage=before[:-1] - before[start[:-1]][owner],
        length=before[start[1:]] - before[start[:-1]],
        sharpest=np.array(sharpest),
        inner_right=np.array([right for right, _ in sides]),
        inner_left=np.array([left for _, left in sides]),
        on_ring=np.array(ring, bool),
        aside=ends.aside[2 * curve] * np.where(s_to < s_from, -1.0, 1.0),
    )


def _corner(hdg: list[float], arriving: int, leaving: int) -> float:
    """Return the turn from one street end to another at their node, rad."""
    turn = hdg[leaving] - hdg[arriving] - np.pi
    return float(abs((turn + np.pi) % (2 * np.pi) - np.pi))


def poses_on(
    paths: StreetPaths, streets: PlanView, path: IntArray, chainage: FloatArray, offset: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y and heading at places along paths, moved to the left of the direction of travel; all (n,)."""
    leg = paths.start[path].copy()
    last = paths.start[path + 1] - 1
    for _ in range(int(np.diff(paths.start).max(initial=1))):
        further = (leg < last) & (paths.chainage[np.minimum(leg + 1, len(paths.curve) - 1)] <= chainage)
        leg = leg + further
    sign = np.sign(paths.s_to[leg] - paths.s_from[leg])
    s = paths.s_from[leg] + sign * (chainage - paths.chainage[leg])
    x, y, hdg = pose(streets, paths.curve[leg], s)
    left = (offset - paths.aside[leg]) * np.where(sign < 0, -1.0, 1.0)
    return x - left * np.sin(hdg), y + left * np.cos(hdg), hdg + np.where(sign < 0, np.pi, 0.0)


def lane_offsets(paths: StreetPaths, path: IntArray, t0: FloatArray, t1: FloatArray, share: FloatArray) -> FloatArray:
    """Return the offset at a share of the way: from the entry lane to the exit lane, within inner lanes between."""
    ease = share * share * (3 - 2 * share)
    direct = t0 + (t1 - t0) * ease
    inside = np.clip(direct, paths.inner_right[path], paths.inner_left[path])
    # The lane of the inner street is reached and left over a third of the way.
    weight = np.clip(3 * np.minimum(share, 1 - share), 0.0, 1.0)
    out: FloatArray = direct + weight * (inside - direct)
    return out


def follow_streets(
    simple: PlanView,
    paths: StreetPaths,
    streets: PlanView,
    path: IntArray,
    t0: FloatArray,
    t1: FloatArray,
) -> PlanView:
    """Replace those curves that stray from the street they should keep to.

    Parameters
    ----------
    simple
        Direct curves of the connecting roads.
    paths, streets
        OSM's ways through the junctions, and the curves they run on.
    path : (n,)
        The path of each connecting road.
    t0, t1 : (n,)
        Where its entry and exit lanes lie left of the streets' curves in the direction of travel, m.
    """
    n = len(path)
    if not n:
        return simple
    t0 = t0 + paths.aside[paths.start[path]]
    t1 = t1 + paths.aside[paths.start[path + 1] - 1]
    total = lengths(simple)
    smooth = paths.sharpest[path] < defaults.SMOOTH_CORNER
    rows = np.arange(n)
    stray = np.zeros(n)
    for share in _CHECKS:
        offset = lane_offsets(paths, path, t0, t1, np.full(n, share))
        px, py, _ = poses_on(paths, streets, path, share * paths.length[path], offset)
        x, y, hdg = pose(simple, rows, share * total)
        stray = np.maximum(stray, np.abs((py - y) * np.cos(hdg) - (px - x) * np.sin(hdg)))
    long = paths.length[path] > 6 * _LEAD
    wanted = np.flatnonzero(long & (stray > defaults.STRAY) & (smooth | paths.on_ring[path]))
    if not len(wanted):
        return simple
    followed = _followed(simple, paths, streets, path[wanted], wanted, t0[wanted], t1[wanted])
    better = smallest_radius(followed) >= np.minimum(smallest_radius(simple)[wanted], defaults.CONNECTING_RADIUS)
    return replaced(simple, wanted[better], followed, np.flatnonzero(better))


def _followed(
    simple: PlanView,
    paths: StreetPaths,
    streets: PlanView,
    path: IntArray,
    row: IntArray,
    t0: FloatArray,
    t1: FloatArray,
) -> PlanView:
    """Fit curves through points along the paths that start and end in the poses of the direct curves."""
    x0, y0, h0 = pose(simple, row, np.zeros(len(row)))
    x1, y1, h1 = pose(simple, row, lengths(simple)[row])
    inside = np.maximum(np.floor((paths.length[path] - 4 * _LEAD) / _SPACING).astype(np.int64), 0) + 1
    owner = np.repeat(np.arange(len(row)), inside)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(inside) - inside, inside)
    room = paths.length[path] - 4 * _LEAD
    chainage = 2 * _LEAD + room[owner] * (number + 0.5) / inside[owner]
    share = chainage / paths.length[path][owner]
    offset = lane_offsets(paths, path[owner], t0[owner], t1[owner], share)
    px, py, _ = poses_on(paths, streets, path[owner], chainage, offset)
    size = inside + 4
    start = np.concatenate([[0], np.cumsum(size)]).astype(np.int64)
    points = np.zeros((start[-1], 2))
    fixed = np.zeros(start[-1], bool)
    points[start[:-1][owner] + 2 + number] = np.column_stack([px, py])
    for place, (x, y) in (
        (start[:-1], (x0, y0)),
        (start[:-1] + 1, (x0 + _LEAD * np.cos(h0), y0 + _LEAD * np.sin(h0))),
        (start[1:] - 2, (x1 - _LEAD * np.cos(h1), y1 - _LEAD * np.sin(h1))),
        (start[1:] - 1, (x1, y1)),
    ):
        points[place] = np.column_stack([x, y])
        fixed[place] = True
    return fit_polylines(points, start, np.full(len(row), defaults.CORNER_RADIUS_OTHER), fixed=fixed).plan_view
