"""Connecting roads that turn where the streets inside their junction turn.

A junction of several nodes may hold streets with corners between them. One curve from arm to arm would swing far out
of such streets, or cut through what lies between them: each corner then gets a turn of its own.

The radii of turns at the corners between two streets: what they should have, and what would cut the corner.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import (
    blocks,
    chain_curves,
    cosine,
    curve_ends,
    dubins_without_slivers,
    heading_change,
    hypot,
    lengths,
    pose,
    repeated,
    replace_curves,
    smallest_radius,
    sorted_unique,
    starts,
    wrapped,
)
from osm2xodr.defaults import LEAST_TURN_BACK
from osm2xodr.geometry.connections import defaults
from osm2xodr.geometry.connections.defaults import (
    LEAST_REDRAWN_RADIUS,
    LONGEST_REDRAWN,
    SMOOTH_CORNER,
    TURNING_RADIUS,
)
from osm2xodr.geometry.connections.pose_to_pose import connect, detours, has_kinks, legs_through
from osm2xodr.geometry.connections.street_paths import LanePaths, StreetPaths, poses_on, turning
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

# A way through a junction that turns to and fro, or by more than this in all, rad (140 degrees), has several corners.
# A connecting road that strays from it by more than this, m, turns at each of them instead, if it then strays by less
# than this share of that; between corners it runs straight from this far beyond one to this far before the next, m.
_TURN_OF_SEVERAL_CORNERS: Final = 2.44
_STRAY_FROM_CORNERS: Final = 3.0
_STRAY_LESS: Final = 0.8
_CORNER_LEAD: Final = 7.5

# Corners are looked for at stations this far apart, m, by how far the way turns from this many stations before one to
# as many behind.
_STATION_SPACING: Final = 1.0
_STATIONS_AROUND: Final = 2
# Where curves and ways are compared, as shares of their lengths.
_COMPARED_SHARES: Final = np.linspace(0.04, 0.96, 24)
# As many rows as the processor's cache holds.
_ROWS_AT_ONCE: Final = 256
# What an arc cuts off a square corner, measured from either side, in radii.
_SQUARE_CUT: Final = 0.2929


def follow_corners(plan: PlanView, lanes: LanePaths) -> PlanView:
    """Replace those curves, (n,), that stray far from a way through their junction that has several corners."""
    paths = lanes.paths
    # A curve from a place to the same place has no records.
    whole, net = turning(lanes)
    several = ~paths.on_ring[lanes.path] & ((whole - net > SMOOTH_CORNER) | (whole > _TURN_OF_SEVERAL_CORNERS))
    rows = np.flatnonzero(several & (np.diff(plan.start) > 0))
    lanes = lanes.chosen(rows)
    if not len(rows):
        return plan
    # Lanes beside each other go the same way. Most are soon seen not to stray; the rest is looked at more closely.
    curve, way = _sampled(plan, rows, lanes)
    for measure in (_side_by_side, _apart_at_most):
        strays = measure(curve, way)
        far = _any_above(_STRAY_FROM_CORNERS, strays, lanes)
        rows, lanes, strays = rows[far], lanes.chosen(far), strays[far]
        curve, way = curve[:, far], way[:, far]
    if not len(rows):
        return plan
    gaps = _corner_gaps(paths, lanes.streets, sorted_unique(lanes.path))
    least = np.minimum(smallest_radius(plan)[rows], LEAST_REDRAWN_RADIUS) - 1e-9
    for single in (False, True):
        if not len(rows):
            break
        turned = _turned_at_corners(plan, rows, lanes, gaps, single)
        nowhere = np.flatnonzero(np.diff(turned.start) == 0)
        turned = replace_curves(turned, nowhere, plan, rows[nowhere])
        stays_off = _apart_at_most(*_sampled(turned, np.arange(len(rows)), lanes))
        bad = (smallest_radius(turned) < least) | (stays_off > _STRAY_LESS * strays)
        # A way that goes to and fro turns round on the spot, and no curve does.
        bad |= detours(turned) | has_kinks(turned)
        # Where arms meet at an acute angle far from their node, nobody drives there and back.
        longer = lengths(turned) > LONGEST_REDRAWN * lengths(plan, rows)
        bad |= (np.abs(heading_change(plan, rows)) < LEAST_TURN_BACK) & longer
        good = ~_any_above(0.5, bad.astype(float), lanes)
        plan = replace_curves(plan, rows[good], turned, np.flatnonzero(good))
        rows, lanes, strays, least = rows[~good], lanes.chosen(~good), strays[~good], least[~good]
    return plan


def _any_above(limit: float, value: FloatArray, lanes: LanePaths) -> BoolArray:
    """Say which connecting roads belong to a path with a value above the limit, (n,)."""
    most = np.full(len(lanes.paths.length), -np.inf)
    np.maximum.at(most, lanes.path, value)
    return most[lanes.path] > limit


def _sampled(plan: PlanView, row: IntArray, lanes: LanePaths) -> tuple[FloatArray, FloatArray]:
    """Return places along curves, and along the lanes' ways over the streets at the same share, (2, n, m)."""
    n, m = len(row), len(_COMPARED_SHARES)
    share = np.tile(_COMPARED_SHARES, n)
    each = np.repeat(np.arange(n), m)
    x, y, _ = pose(plan, row[each], share * lengths(plan)[row[each]])
    px, py, _ = lanes.at_share(each, share)
    return np.stack([x, y]).reshape(2, n, m), np.stack([px, py]).reshape(2, n, m)


def _side_by_side(curve: FloatArray, way: FloatArray) -> FloatArray:
    """Return the largest distance of places at the same share: an upper bound of `_apart_at_most`, (n,), m."""
    return np.asarray(hypot(*(curve - way)).max(1))


def _apart_at_most(curve: FloatArray, way: FloatArray) -> FloatArray:
    """Return how far curves and ways lie apart at most, as their Hausdorff distance, (n,), m."""
    return np.maximum(_apart(curve, way), _apart(way, curve))


def _apart(points: FloatArray, line: FloatArray) -> FloatArray:
    """Return the largest distance of points from a polyline, both (2, n, m); (n,), m."""
    out = np.zeros(points.shape[1])
    for part in blocks(len(out), _ROWS_AT_ONCE):
        (x, y), (ax, ay) = (np.ascontiguousarray(item[:, part].transpose(0, 2, 1)) for item in (points, line))
        along_x, along_y = np.diff(ax, axis=0), np.diff(ay, axis=0)
        size = np.maximum(along_x * along_x + along_y * along_y, 1e-12)
        nearest = np.full(x.shape, np.inf)
        for k in range(len(size)):
            dx, dy = x - ax[k], y - ay[k]
            at = dx * along_x[k]
            at += dy * along_y[k]
            at /= size[k]
            np.maximum(at, 0.0, out=at)
            np.minimum(at, 1.0, out=at)
            dx -= at * along_x[k]
            dy -= at * along_y[k]
            dx *= dx
            dy *= dy
            dx += dy
            np.minimum(nearest, dx, out=nearest)
        out[part] = np.sqrt(nearest.max(axis=0))
    return out


def _corner_gaps(paths: StreetPaths, streets: PlanView, numbers: IntArray) -> dict[int, list[tuple[float, float]]]:
    """Return between which chainages paths run from one of their corners to the next, by number of the path, m."""
    length = paths.length[numbers]
    count = np.maximum((length / _STATION_SPACING).astype(np.int64), 1)
    start = starts(count)
    each = repeated(count)
    chainage = (np.arange(start[-1]) - start[each] + 0.5) * (length / count)[each]
    hdg = poses_on(paths, streets, numbers[each], chainage, np.zeros(len(each)))[2]
    first, last = _corners(hdg, start, each)
    # One corner is over where the next of the same path begins.
    joint = np.flatnonzero(each[last[:-1]] == each[first[1:]])
    out: dict[int, list[tuple[float, float]]] = {number: [] for number in numbers.tolist()}
    owner = numbers[each[last[joint]]]
    over, begin = chainage[last[joint]], chainage[first[joint + 1]]
    for number, gap in zip(owner.tolist(), zip(over.tolist(), begin.tolist(), strict=True), strict=True):
        out[number].append(gap)
    return out


def _corners(hdg: FloatArray, start: IntArray, each: IntArray) -> tuple[IntArray, IntArray]:
    """Return the first and the last station of each corner, (corners,).

    `hdg`, rad, and `each`, its path, are those of each station; `start` (paths + 1,) has each path's first station.
    """
    at = np.arange(len(hdg))
    turn = np.where(np.diff(each, prepend=-1) > 0, 0.0, np.abs(wrapped(np.diff(hdg, prepend=0.0))))
    run = np.cumsum(turn)
    ahead = np.minimum(at + _STATIONS_AROUND, start[each + 1] - 1)
    behind = np.maximum(at - _STATIONS_AROUND, start[each])
    bent = run[ahead] - run[behind] > SMOOTH_CORNER / 2
    goes_on = np.append(each[1:] == each[:-1], False) & bent & np.append(bent[1:], False)
    last = np.flatnonzero(bent & ~goes_on)
    first = np.flatnonzero(bent & ~np.append(False, goes_on[:-1]))
    sharp = run[last] - run[first] > SMOOTH_CORNER
    return first[sharp], last[sharp]


def _between_corners(gaps: list[tuple[float, float]], single: bool) -> FloatArray:
    """Return the chainages on a path, (places,), m, where a car drives straight between one corner and the next.

    With `single`, there is one place between two corners, in the middle, however far they are apart.
    """
    out: list[float] = []
    for a, b in gaps:
        if not single and b - a > 2 * _CORNER_LEAD:
            out += [a + _CORNER_LEAD, b - _CORNER_LEAD]
        else:
            out.append((a + b) / 2)
    return np.array(out)


def _turned_at_corners(
    plan: PlanView, row: IntArray, lanes: LanePaths, gaps: dict[int, list[tuple[float, float]]], single: bool
) -> PlanView:
    """Return curves that start and end as those in the rows do and pass the places between corners straight on."""
    chainages = [_between_corners(gaps[number], single) for number in lanes.path.tolist()]
    count = np.array([len(item) for item in chainages], np.int64)
    passed = lanes.at_chainage(repeated(count), np.concatenate(chainages))
    begin, end = curve_ends(plan, row)
    here, there, first = legs_through(begin, passed, end, count)
    pieces = connect(*here, *there, radius=TURNING_RADIUS)
    sharp = np.flatnonzero(smallest_radius(pieces) < LEAST_REDRAWN_RADIUS)
    if len(sharp):
        radius = np.full(len(sharp), TURNING_RADIUS)
        wide = dubins_without_slivers(*(column[sharp] for column in (*here, *there)), radius=radius)
        found = np.flatnonzero(lengths(wide) > 0)
        pieces = replace_curves(pieces, sharp[found], wide, found)
    return chain_curves(pieces, first)


def turning_radii(
    ends: StreetEnds,
    entry: IntArray,
    exit_: IntArray,
    t_in: FloatArray,
    t_out: FloatArray,
    width: FloatArray,
    turn: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the radii that turns should have, and the largest that do not cut their corner, (n,), m.

    The turns lead from lanes t_in left of street ends `entry` to lanes t_out left of street ends `exit_`, seen from
    the junction, m, which are `width` wide, m; `turn` is their change of heading, left positive, rad.

    Lanes beside each other turn about one centre: to the radius of their inner edge comes what lies between it and
    the lane. A kerb of that radius would cut off as much of an acute corner as one of `KERB_RADIUS` does of a square
    one, or up to `LARGEST_KERB` times as much. No arc leaves the carriageways by more than `OFF_CARRIAGEWAY`.
    """
    kerb = np.minimum(ends.kerb[entry], ends.kerb[exit_])
    right = np.maximum(ends.left[entry] - t_in, t_out - ends.right[exit_])
    left = np.maximum(t_in - ends.right[entry], ends.left[exit_] - t_out)
    beside = np.maximum(np.where(turn < 0, right, left), width / 2)
    edge = kerb * _SQUARE_CUT / np.maximum(1 - cosine(turn / 2), 1e-6)
    stretched = defaults.LARGEST_KERB * edge
    wanted = (
        np.maximum(np.minimum(kerb, edge), np.minimum(defaults.TURNING_RADIUS - width / 2, stretched)) + width / 2
    )
    # The lane nearer to its street's line leaves the carriageways first.
    aside = np.minimum(np.where(turn < 0, t_in, -t_in), np.where(turn < 0, -t_out, t_out))
    half = np.maximum(half_carriageways(ends, entry), half_carriageways(ends, exit_))
    inside = (half + defaults.OFF_CARRIAGEWAY - aside) / np.maximum(1 - cosine(turn / 2), 1e-6)
    least = defaults.TURNING_RADIUS_ACUTE
    return np.maximum(np.minimum(wanted, inside), least), np.maximum(np.minimum(stretched + beside, inside), least)


def half_carriageways(ends: StreetEnds, end: IntArray) -> FloatArray:
    """Return half of the widths of the carriageways at street ends, at least those of narrow ones, (n,), m."""
    return np.maximum((ends.left[end] - ends.right[end]) / 2, defaults.HALF_NARROW_CARRIAGEWAY)
