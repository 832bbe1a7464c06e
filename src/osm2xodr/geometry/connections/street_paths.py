"""Ways through junctions over OSM's streets, and connecting roads that keep to them.

A curve from arm to arm is what a car drives at a crossing. Where a street only runs on through a long junction (a
ramp joins it, a roundabout's ring passes arm after arm), the curve must follow the street itself.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import (
    cosine,
    cosine_sine,
    curve_ends,
    find_record,
    heading_at,
    heading_change,
    lengths,
    owners,
    pose,
    ranks,
    repeated,
    replace_curves,
    sine,
    smallest_radius,
    smooth_step,
    starts,
    wrapped,
)
from osm2xodr.geometry.connections.defaults import SMOOTH_CORNER, TURNING_RADIUS
from osm2xodr.geometry.defaults import CORNER_RADIUS_OTHER
from osm2xodr.geometry.junctions import Movement
from osm2xodr.geometry.plan_view import StreetEnds, fit_polylines
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView
from osm2xodr.system import record

# A connecting road on a smooth street follows it where it would stray farther from it than this, m: on a roundabout's
# ring, and elsewhere, where cars drive straight on through slight bends of OSM's lines.
_STRAY_ON_RING: Final = 0.25
_STRAY: Final = 3.0
# Where that is looked at, as shares of the way.
_STRAY_SHARES: Final = np.linspace(0.1, 0.9, 9)
# Where streets part or join at an acute angle, cars do not slow down as at a corner: what is drawn instead of a
# direct curve has this radius at least, m, or that of the curve. A choice: 60 km/h with 2.3 m/s2.
LEAST_RADIUS_ON_STREET: Final = 120.0
# Points of the street that a curve is fitted to are at most this far apart, m; it starts and ends straight over this
# length, m, so that its headings stay.
_POINT_SPACING: Final = 2.0
_STRAIGHT_LEAD: Final = 1.5

Poses = tuple[FloatArray, FloatArray, FloatArray]
"""x, y, m, and heading, rad, each (n,)."""


@record(eq=False)
class StreetPaths:
    """OSM's ways through junctions along the curves of streets, one per movement."""

    start: IntArray  # (paths + 1,) Index of each path's first leg
    curve: IntArray  # (legs,) Street
    # (legs,) Where on the street the leg runs, m; downwards where traffic runs against the street
    s_from: FloatArray
    s_to: FloatArray
    chainage: FloatArray  # (legs,) Length of the path before the leg, m
    length: FloatArray  # (paths,) m
    sharpest: FloatArray  # (paths,) Largest corner between two legs, rad
    cornered: FloatArray  # (paths,) All corners between legs together, rad
    # (paths,) Middles of the outermost lanes of the inner streets that run the way of the path, left of OSM's lines
    # in the direction of travel, m; infinitely far out without inner streets
    inner_right: FloatArray
    inner_left: FloatArray
    on_ring: BoolArray  # (paths,) Whether an inner street belongs to a roundabout
    # (legs,) How far left of the line of OSM, in the direction of travel, the street's curve lies, m
    aside: FloatArray


def lay_out_paths(
    movements: list[Movement], ends: StreetEnds, trim: FloatArray, lanes: Callable[[int, bool], tuple[float, float]]
) -> StreetPaths:
    """Lay out the way of each movement through its junction; parameters as in `build_connecting_roads`."""
    entry = np.array([item.entry for item in movements], np.int64)
    exit_ = np.array([item.exit for item in movements], np.int64)
    inner = [(k, *leg) for k, item in enumerate(movements) if item.inner for leg in item.inner]
    of, street, along = np.array(inner, np.int64).reshape(-1, 3).T
    count = 2 + np.bincount(of, minlength=len(movements))
    start = starts(count)
    owner = repeated(count)
    # Street ends at which legs begin and end. The first begins, and the last ends, where its street is cut.
    near, far = np.zeros(start[-1], np.int64), np.zeros(start[-1], np.int64)
    between = np.ones(start[-1], bool)
    between[start[:-1]] = between[start[1:] - 1] = False
    near[between] = 2 * street + 1 - along
    far[between] = near[between] ^ 1
    near[start[:-1]] = far[start[:-1]] = entry
    near[start[1:] - 1] = far[start[1:] - 1] = exit_
    at_end = np.arange(len(trim)) % 2 == 1
    node_s = np.where(at_end, ends.length, 0.0)
    trim_s = np.where(at_end, ends.length - trim, trim)
    s_from, s_to = node_s[near], node_s[far]
    s_from[start[:-1]], s_to[start[1:] - 1] = trim_s[entry], trim_s[exit_]
    joint = np.flatnonzero(owner[1:] == owner[:-1])
    sharpest = np.zeros(len(count))
    corner = np.abs(wrapped(ends.hdg[near[joint + 1]] - ends.hdg[far[joint]] - np.pi))
    np.maximum.at(sharpest, owner[joint], corner)
    cornered = np.bincount(owner[joint], corner, len(count)).astype(np.float64)
    ring = np.zeros(len(count), bool)
    ring[of[ends.roundabout[2 * street]]] = True
    inner_right, inner_left = _inner_sides(inner, len(count), lanes)
    curve = near // 2
    size = np.abs(s_to - s_from)
    chainage = _sums_before(size, start)
    return StreetPaths(
        start=start,
        curve=curve,
        s_from=s_from,
        s_to=s_to,
        chainage=chainage,
        length=(chainage + size)[start[1:] - 1],
        sharpest=sharpest,
        cornered=cornered,
        inner_right=inner_right,
        inner_left=inner_left,
        on_ring=ring,
        aside=ends.aside[2 * curve] * np.where(s_to < s_from, -1.0, 1.0),
    )


def _sums_before(size: FloatArray, start: IntArray) -> FloatArray:
    """Return the sum of what comes before each leg in its path, (legs,); every path has a leg.

    It is the same to the last bit whatever other paths there are.
    """
    out, count = np.zeros(len(size)), np.diff(start)
    for k in range(1, int(count.max(initial=1))):
        leg = start[:-1][count > k] + k
        out[leg] = out[leg - 1] + size[leg - 1]
    return out


def _inner_sides(
    inner: Sequence[tuple[int, int, bool]], paths: int, lanes: Callable[[int, bool], tuple[float, float]]
) -> tuple[FloatArray, FloatArray]:
    """Return the middles of the outermost lanes that all inner streets of each path have, (paths,), m."""
    known = {leg: lanes(*leg) for leg in dict.fromkeys((street, along) for _, street, along in inner)}
    right, left = np.full(paths, -np.inf), np.full(paths, np.inf)
    of = np.array([path for path, _, _ in inner], np.int64)
    sides = np.array([known[street, along] for _, street, along in inner]).reshape(-1, 2)
    np.maximum.at(right, of, sides[:, 0])
    np.minimum.at(left, of, sides[:, 1])
    return right, np.maximum(right, left)


@record(eq=False)
class LanePaths:
    """Where the lanes of connecting roads would run over the streets inside their junctions."""

    paths: StreetPaths
    streets: PlanView  # The curves that the paths run on
    path: IntArray  # (n,) The path of each connecting road, in ascending order
    # (n,) Where its entry lane and its exit lane lie left of OSM's lines in the direction of travel, m
    t_in: FloatArray
    t_out: FloatArray

    @property
    def length(self) -> FloatArray:
        """Lengths of the paths, (n,), m."""
        return self.paths.length[self.path]

    def chosen(self, rows: IntArray | BoolArray) -> LanePaths:
        """Return some of them."""
        return replace(self, path=self.path[rows], t_in=self.t_in[rows], t_out=self.t_out[rows])

    def at_share(self, row: IntArray, share: FloatArray) -> Poses:
        """Return x, y and heading at shares of the ways of some rows, all (m,)."""
        return self._poses(row, share, share * self.paths.length[self.path[row]])

    def at_chainage(self, row: IntArray, chainage: FloatArray) -> Poses:
        """Return x, y and heading at chainages of some rows, all (m,)."""
        return self._poses(row, chainage / self.paths.length[self.path[row]], chainage)

    def _poses(self, row: IntArray, share: FloatArray, chainage: FloatArray) -> Poses:
        path, t_in, t_out = self.path[row], self.t_in[row], self.t_out[row]
        direct = t_in + (t_out - t_in) * smooth_step(share)
        inside = np.clip(direct, self.paths.inner_right[path], self.paths.inner_left[path])
        # The lane of the inner street is reached and left over a third of the way.
        weight = np.clip(3 * np.minimum(share, 1 - share), 0.0, 1.0)
        return poses_on(self.paths, self.streets, path, chainage, direct + weight * (inside - direct))


def lane_paths(
    paths: StreetPaths, streets: PlanView, path: IntArray, t_in: FloatArray, t_out: FloatArray
) -> LanePaths:
    """Return the ways of lanes that lie t_in and t_out left of the streets' curves, (n,), m."""
    first, last = paths.start[path], paths.start[path + 1] - 1
    return LanePaths(paths, streets, path, t_in + paths.aside[first], t_out + paths.aside[last])


def poses_on(
    paths: StreetPaths, streets: PlanView, path: IntArray, chainage: FloatArray, offset: FloatArray
) -> Poses:
    """Return x, y and heading at places along paths, moved to the left of the direction of travel; all (n,)."""
    leg = find_record(paths.start, paths.chainage, path, chainage)
    sign = np.sign(paths.s_to[leg] - paths.s_from[leg])
    s = paths.s_from[leg] + sign * (chainage - paths.chainage[leg])
    x, y, hdg = pose(streets, paths.curve[leg], s)
    left = (offset - paths.aside[leg]) * np.where(sign < 0, -1.0, 1.0)
    cos, sin = cosine_sine(hdg)
    return x - left * sin, y + left * cos, hdg + np.where(sign < 0, np.pi, 0.0)


def follow_streets(direct: PlanView, lanes: LanePaths) -> PlanView:
    """Replace those of the direct curves, (n,), that stray from the smooth street they should keep to."""
    paths = lanes.paths
    smooth = paths.sharpest[lanes.path] < SMOOTH_CORNER
    long = lanes.length > 6 * _STRAIGHT_LEAD
    rows = np.flatnonzero(long & (smooth | paths.on_ring[lanes.path]))
    wanted = rows[_strays(direct, rows, lanes.chosen(rows))]
    if not len(wanted):
        return direct
    followed = _followed(direct, wanted, lanes.chosen(wanted))
    sharpest = np.where(hardly_turn(direct, wanted, lanes.chosen(wanted)), LEAST_RADIUS_ON_STREET, TURNING_RADIUS)
    better = smallest_radius(followed) >= np.minimum(smallest_radius(direct)[wanted], sharpest)
    return replace_curves(direct, wanted[better], followed, np.flatnonzero(better))


def _strays(direct: PlanView, row: IntArray, lanes: LanePaths) -> BoolArray:
    """Say which curves lie aside of their lanes' ways over the streets, (n,)."""
    total = lengths(direct, row)
    out = np.zeros(len(row), bool)
    most = np.where(lanes.paths.on_ring[lanes.path], _STRAY_ON_RING, _STRAY)
    todo = np.arange(len(row))
    for share in _STRAY_SHARES:
        px, py, _ = lanes.at_share(todo, np.full(len(todo), share))
        x, y, hdg = pose(direct, row[todo], share * total[todo])
        out[todo] = np.abs((py - y) * cosine(hdg) - (px - x) * sine(hdg)) > most[todo]
        todo = todo[~out[todo]]
    return out


def _followed(direct: PlanView, row: IntArray, lanes: LanePaths) -> PlanView:
    """Fit curves through points along the paths that start and end in the poses of the direct curves."""
    (x0, y0, h0), (x1, y1, h1) = curve_ends(direct, row)
    room = lanes.length - 4 * _STRAIGHT_LEAD
    inside = np.maximum(np.floor(room / _POINT_SPACING).astype(np.int64), 0) + 1
    owner = repeated(inside)
    number = ranks(inside)
    chainage = 2 * _STRAIGHT_LEAD + room[owner] * (number + 0.5) / inside[owner]
    px, py, _ = lanes.at_chainage(owner, chainage)
    # Per curve: its start and the end of its lead, the points, and the same at its end.
    start = starts(inside + 4)
    points = np.zeros((start[-1], 2))
    fixed = np.zeros(start[-1], bool)
    points[start[:-1][owner] + 2 + number] = np.column_stack([px, py])
    for place, x, y in (
        (start[:-1], x0, y0),
        (start[:-1] + 1, x0 + _STRAIGHT_LEAD * cosine(h0), y0 + _STRAIGHT_LEAD * sine(h0)),
        (start[1:] - 2, x1 - _STRAIGHT_LEAD * cosine(h1), y1 - _STRAIGHT_LEAD * sine(h1)),
        (start[1:] - 1, x1, y1),
    ):
        points[place] = np.column_stack([x, y])
        fixed[place] = True
    return fit_polylines(points, start, np.full(len(row), CORNER_RADIUS_OTHER), fixed=fixed).plan_view


def turning(lanes: LanePaths) -> tuple[FloatArray, FloatArray]:
    """Return by how much ways over the streets turn to and fro in all, and from start to end, (n,), rad."""
    paths, streets = lanes.paths, lanes.streets
    h0 = heading_at(streets, paths.curve, paths.s_from)
    h1 = heading_at(streets, paths.curve, paths.s_to)
    against = np.where(paths.s_to < paths.s_from, np.pi, 0.0)
    owner = owners(paths.start)
    joint = np.flatnonzero(owner[1:] == owner[:-1])
    corner = wrapped((h0 + against)[joint + 1] - (h1 + against)[joint])
    turns = np.concatenate([h1 - h0, corner])
    of = np.concatenate([owner, owner[joint]])
    whole: FloatArray = np.bincount(of, np.abs(turns), len(paths.length)).astype(float)
    net: FloatArray = np.abs(np.bincount(of, turns, len(paths.length)))
    return whole[lanes.path], net[lanes.path]


def hardly_turn(direct: PlanView, rows: IntArray, lanes: LanePaths) -> BoolArray:
    """Say which curves hardly turn, nor do their ways over the streets, (rows,): streets part, join or run on."""
    smooth = (lanes.paths.sharpest[lanes.path] < SMOOTH_CORNER) & (turning(lanes)[0] < 2 * SMOOTH_CORNER)
    return np.asarray(smooth & (np.abs(heading_change(direct, rows)) < SMOOTH_CORNER))
