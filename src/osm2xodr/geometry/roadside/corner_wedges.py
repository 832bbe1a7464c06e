"""How the sidewalks of two arms share the place between their kerbs before a corner that they cannot get round else.

Each of them gets what lies on its side of the middle between both kerbs, and both end in one tip. The one with more
room where it ends narrows down to the width of the other one there; that one begins where the first one's back edge
lies, so that nothing is left open between them.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

from osm2xodr.curves import arctan2, cosine, heading_at, hypot, pose, project, sine, smooth_step
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.roadside import defaults
from osm2xodr.geometry.roadside.strips import Wedge
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.system import record

# Least width of a sidewalk where it ends in a wedge, m: about a kerbstone's. A choice.
_LEAST_WIDTH: Final = 0.1
# Where both kerbs end farther apart than this, m, is no tip: sidewalks are at least so wide, m, or none is led on
# there. Choices.
_LARGEST_TIP: Final = 4.0
_LEAST_PATH: Final = 0.5
# Distances from where a road ends at which room is looked for, m: wedges are no longer than the last one. Choices.
_PLACES: Final = np.array(
    [0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0]
)
# Share of their road that wedges take at most: where two meet, the narrower one counts.
_SHARE_OF_ROAD: Final = 0.95
# Sidewalks that only lanes or the bend of the corner narrow, and those of arms that part at less than this, rad,
# and stay side by side for more than this, m, become narrower by such a slope. Choices.
_PARALLEL: Final = 0.15
_LONG: Final = 12.0
_GENTLE: Final = 0.25
_GENTLER: Final = 0.05
# Arms that part at more than this, rad (150 degrees), leave room for any sidewalk between them. Arms side by side may
# come closer by this angle, rad, away from the junction.
_LARGEST_ANGLE: Final = 2.6
_MOST_CLOSING: Final = 0.5
# Room for so much more than a sidewalk is room for anything, m. A choice.
_PLENTY: Final = 1.0
# The back edge of a corner may be nearer by this to the centre of its bend than if it were as wide as at its narrower
# end, m: of the radius round tips.
_FOLD: Final = defaults.CORNER_TIP_RADIUS
# Shares of the way beyond the first road's end at which it is looked for.
_SHARES: Final = np.linspace(1.0, 0.0, 5)[:-1]
# Widths of wedges are off by this at most, m: few records. A choice.
_TOLERANCE: Final = 0.01


def wedges(parts: RoadParts, rows: ConnectingRoads, share: float) -> list[tuple[int, Wedge]]:
    """Return the wedges, by road end, in which sidewalks of corners end with a share of the room between both kerbs.

    The one with more room is as wide as the bend of the corner allows.
    """
    one = _Kerbs.of(parts, rows.entry, rows.entry_lane, rows.entry_width)
    other = _Kerbs.of(parts, rows.exit, rows.exit_lane, rows.exit_width)
    facing, angle = _facing(one, other)
    rooms = [np.where(facing[:, None], here.shared(there), np.inf) for here, there in ((one, other), (other, one))]
    # The one with more room is drawn first.
    swapped = rooms[0][:, 0] < rooms[1][:, 0]
    first, second = one.mixed(other, swapped), other.mixed(one, swapped)
    room = np.minimum(np.where(swapped[:, None], rooms[1], rooms[0]), first.full[:, None] + _PLENTY)
    more, less = room[:, 0], np.where(swapped, rooms[0][:, 0], rooms[1][:, 0])
    slack = 1.1 * defaults.CORNER_TIP_RADIUS
    narrower = np.minimum(first.full, second.full)
    width = _rounded(share * np.minimum(np.where(facing, less - slack, np.inf), narrower))
    (x0, y0, _), (x1, y1, _) = first.places(), second.places()
    enough = (hypot(x1 - x0, y1 - y0)[:, 0] <= _LARGEST_TIP) | (width >= _LEAST_PATH)
    # What is left of its way beyond the first one's end: straight on, then round the tip.
    straight = np.where(
        facing, np.maximum(first.ahead(*second.aside(width[:, None], np.zeros((len(width), 1)))), 0.0), 0.0
    )
    bend = (np.pi - angle) * (width / 2 + defaults.CORNER_TIP_RADIUS)
    last = np.divide(bend, straight + bend, out=np.ones(len(bend)), where=straight > 0.0)
    wide = np.minimum(share * (more - slack), width + _FOLD / smooth_step(last))
    wide = np.maximum(width, np.where(facing, _rounded(np.minimum(wide, first.full)), width))
    slope = np.where(facing, _GENTLER, _GENTLE)
    parallel = (room < first.full[:, None]).all(axis=1) & (angle < _PARALLEL) & (first.u[:, -1] > _LONG)
    slope = np.where(facing & ~parallel, np.inf, slope)
    begin, narrow = _narrowed(first, room, wide, np.where(more >= first.full, np.minimum(slope, _GENTLE), slope))
    line = (_round_corner(first, wide, width, straight, last), first.aside(narrow, begin))
    x, y = (np.hstack(columns) for columns in zip(*line, strict=True))
    beyond, left = _left_over(second, x, y, width, slope)
    found: list[tuple[int, Wedge]] = []
    for kerbs, u, sizes in ((first, begin, narrow), (second, beyond, left)):
        columns = (item.tolist() for item in (kerbs.end, kerbs.side, kerbs.full, u, sizes))
        for keep, (end, side, full, places, widths) in zip(enough.tolist(), zip(*columns, strict=True), strict=True):
            if keep and widths[0] < full - defaults.SAME_PLACE:
                points = simple(_upwards(zip(places, widths, strict=True), full))
                found.append((end, Wedge(int(side), end % 2 == 1, points)))
    return found


def _rounded(width: FloatArray) -> FloatArray:
    return np.asarray(np.floor(100.0 * np.maximum(width, _LEAST_WIDTH)) / 100.0)


@record(eq=False)
class _Kerbs:
    """Kerbs beside the last metres of roads before junctions, (n,)."""

    parts: RoadParts
    end: IntArray
    side: FloatArray  # Left 1, right -1, seen along the road
    t: FloatArray
    full: FloatArray  # How wide the sidewalk is there, m
    u: FloatArray  # (n, m) Distances from the end, m, at which they are looked at

    @classmethod
    def of(cls, parts: RoadParts, end: IntArray, lane: IntArray, full: FloatArray) -> _Kerbs:
        """Return the kerbs at the ends of roads, at the sides of lanes."""
        sections = [parts.at_end(item).section for item in end.tolist()]
        t = np.where(lane > 0, [item.left_edge for item in sections], [item.right_edge for item in sections])
        scale = np.minimum(1.0, _SHARE_OF_ROAD * parts.length[end // 2] / _PLACES[-1])
        return cls(parts, end, np.sign(lane).astype(np.float64), t, full, scale[:, None] * _PLACES)

    def mixed(self, other: _Kerbs, swapped: BoolArray) -> _Kerbs:
        """Return them with some of others in their places."""
        names = ("end", "side", "t", "full", "u")
        columns = [(getattr(self, name), getattr(other, name)) for name in names]
        return _Kerbs(self.parts, *(np.where(swapped.reshape(-1, *[1] * (a.ndim - 1)), b, a) for a, b in columns))

    def places(self, u: FloatArray | None = None) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return x, y and the heading away from the junction, (n, m), at u or at given distances from the end.

        Beyond the end, at distances below 0, kerbs go on straight.
        """
        u = self.u if u is None else u
        road, out = self.end // 2, self.end % 2 == 1
        s = np.where(out[:, None], self.parts.length[road][:, None] - np.maximum(u, 0.0), np.maximum(u, 0.0))
        x, y, hdg = pose(self.parts.plan_view, np.repeat(road, u.shape[1]), s.ravel())
        x, y, hdg = (item.reshape(u.shape) for item in (x, y, hdg))
        t, away = self.t[:, None], hdg + np.where(out, np.pi, 0.0)[:, None]
        before = np.minimum(u, 0.0)
        return x - t * sine(hdg) + before * cosine(away), y + t * cosine(hdg) + before * sine(away), away

    def aside(self, width: FloatArray, u: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Return x and y so far beyond the kerbs, m, all (n, m)."""
        x, y, hdg = self.places(u)
        left = (self.side * np.where(self.end % 2 == 1, -1.0, 1.0))[:, None]
        return x - left * width * sine(hdg), y + left * width * cosine(hdg)

    def beside(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return how far from the end, and how far beyond the kerb, places lie, m, and the heading there, (n, m)."""
        road, out = np.repeat(self.end // 2, x.shape[1]), (self.end % 2 == 1)[:, None]
        s, t, distance = (item.reshape(x.shape) for item in project(self.parts.plan_view, road, x.ravel(), y.ravel()))
        hdg = heading_at(self.parts.plan_view, road, s.ravel()).reshape(x.shape)
        u = np.where(out, self.parts.length[self.end // 2][:, None] - s, s)
        # Nothing lies beside a road beyond its other end; beyond this one it goes on straight.
        far = (distance > np.abs(t) + defaults.SAME_PLACE) & (u > 0.0)
        v = np.where(far, np.inf, self.side[:, None] * (t - self.t[:, None]))
        return u, v, hdg + np.where(out, np.pi, 0.0)

    def ahead(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return how far places (n, 1) lie beyond the end of the road, in its direction there, (n,), m."""
        x0, y0, hdg = self.places(np.zeros_like(x))
        return np.asarray(((x0 - x) * cosine(hdg) + (y0 - y) * sine(hdg))[:, 0])

    def shared(self, other: _Kerbs) -> FloatArray:
        """Return how wide a sidewalk may be beside each place, (n, m), m: up to the middle, or the other's back edge.

        Over its width the other kerb counts as straight.
        """
        x, y, hdg = self.places()
        _, room, there = other.beside(x, y)
        cos = cosine(hdg - there)
        middle = room / np.maximum(1.0 + cos, _TOLERANCE)
        over = room - other.full[:, None]
        whole = np.where(cos > _TOLERANCE, over / np.maximum(cos, _TOLERANCE), np.where(over >= 0.0, np.inf, -np.inf))
        return np.asarray(np.maximum(middle, whole))


def _facing(one: _Kerbs, other: _Kerbs) -> tuple[BoolArray, FloatArray]:
    """Say whether the place between two kerbs is narrow: they part at an acute angle, rad, or nearly side by side."""
    away, there = one.places()[2][:, 0], other.places()[2][:, 0]
    left = one.side * np.where(one.end % 2 == 1, -1.0, 1.0)
    angle = arctan2(left * sine(there - away), cosine(there - away))
    return (angle < _LARGEST_ANGLE) & (angle > -_MOST_CLOSING), angle


def _round_corner(
    kerbs: _Kerbs, wide: FloatArray, width: FloatArray, straight: FloatArray, last: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return places on the back edge of a corner beyond the end of its first road, the farthest first, (n, m)."""
    share = _SHARES * (1.0 - last[:, None])
    step = smooth_step(share)
    return kerbs.aside(wide[:, None] + step * (width - wide)[:, None], -_SHARES * straight[:, None])


def _narrowed(kerbs: _Kerbs, room: FloatArray, width: FloatArray, slope: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return places and how wide sidewalks are there that end with a given width, (n, m), m.

    They fill their `room`, (n, m), but for the little that they leave at the end, or grow wider by a `slope`, (n,).
    """
    full, row = kerbs.full, np.arange(len(room))
    hit = np.where((room >= full[:, None]).any(axis=1), (room >= full[:, None]).argmax(axis=1), room.shape[1] - 1)
    before = np.maximum(hit - 1, 0)
    # Exactly where they are as wide as elsewhere.
    u, low = kerbs.u.copy(), room[row, before]
    rise = np.maximum(room[row, hit] - low, defaults.SAME_PLACE)
    u[row, hit] = u[row, before] + np.clip((full - low) / rise, 0.0, 1.0) * (u[row, hit] - u[row, before])
    spare = (room[:, 0] - width)[:, None] * np.maximum(1.0 - u / np.maximum(u[row, hit], _TOLERANCE)[:, None], 0.0)
    narrow = np.where(np.arange(u.shape[1]) < hit[:, None], room - spare, full[:, None])
    even = np.isfinite(slope)[:, None]
    u = np.where(even, kerbs.u, u)
    narrow = np.where(even, _evenly(width, slope, u), narrow)
    narrow = np.clip(narrow, _LEAST_WIDTH, full[:, None])
    narrow[:, 0] = np.minimum(width, full)
    return u, narrow


def _left_over(
    kerbs: _Kerbs, x: FloatArray, y: FloatArray, width: FloatArray, slope: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return places and how wide sidewalks are there that reach up to a line x, y, (n, m), from the junction away, m.

    They grow wider by a `slope`, (n,), instead where that is finite.
    """
    u, v, _ = kerbs.beside(x, y)
    even, places = np.isfinite(slope)[:, None], np.linspace(0.0, kerbs.u[:, -1], u.shape[1], axis=1)
    u, v = np.where(even, places, u), np.where(even, _evenly(width, slope, places), v)
    return np.hstack([np.zeros((len(u), 1)), u]), np.hstack([np.minimum(width, kerbs.full)[:, None], v])


def _evenly(width: FloatArray, slope: FloatArray, u: FloatArray) -> FloatArray:
    return np.asarray(width[:, None] + np.where(np.isfinite(slope), slope, 0.0)[:, None] * u)


def _upwards(points: Iterable[tuple[float, float]], full: float) -> list[tuple[float, float]]:
    """Return the places of a wedge in order, from the junction to where it is as wide as elsewhere."""
    out: list[tuple[float, float]] = []
    for u, width in points:
        if out and u <= out[-1][0] + _TOLERANCE:
            continue
        if width >= full:
            u0, w0 = out[-1]
            share = (full - w0) / (width - w0) if np.isfinite(width) else 1.0
            return [*out, (u0 + max(share * (u - u0), _TOLERANCE), full)]
        out.append((u, max(width, _LEAST_WIDTH)))
    u0, w0 = out[-1]
    return [*out, (u0 + (full - w0), full)]


def simple(points: list[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Return places without those that lie on straight lines between others."""
    first, last = points[0], points[-1]
    if len(points) < 3:
        return tuple(points)
    slope = (last[1] - first[1]) / (last[0] - first[0])
    off = [abs(width - first[1] - slope * (u - first[0])) for u, width in points]
    worst = max(range(len(points)), key=off.__getitem__)
    if off[worst] <= _TOLERANCE:
        return first, last
    return (*simple(points[: worst + 1])[:-1], *simple(points[worst:]))
