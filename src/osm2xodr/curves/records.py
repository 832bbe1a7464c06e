"""Places on curves by their records: found, evaluated, and those nearest to points."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from osm2xodr.curves import spirals, trigonometry
from osm2xodr.model import FloatArray, IntArray, PlanView

# How far behind a place a record must begin to hold there when the limit from the left is asked for, m.
_LEFT_LIMIT: Final = 1e-9
# Records may end this far from where the next begins, m.
_GAP: Final = 0.01
_INFINITE: Final = math.inf
_Pose = tuple[FloatArray, FloatArray, FloatArray]


def find_record(
    start: IntArray, record_s: FloatArray, curve: IntArray, s: FloatArray, *, before: bool = False
) -> IntArray:
    """Return the index of the record that holds at s of a curve, both (n,); `before`: just before s.

    Positions before a curve's first record belong to the first, those beyond its end to the last.
    """
    out = np.empty(len(curve), np.int64)
    records_at(start, record_s, curve, s - _LEFT_LIMIT if before else s, out)
    return out


def records_at(start: IntArray, record_s: FloatArray, curve: IntArray, s: FloatArray, out: IntArray) -> None:
    """Write the records that hold at places, (n,)."""
    for k in range(len(curve)):
        out[k] = record_at(record_s, start[curve[k]], start[curve[k] + 1], float(s[k]))


def record_at(record_s: FloatArray, first: int, end: int, s: float) -> int:
    """Return the last of the records from first up to end that begins at s or before, or the first."""
    left = end - first
    while left > 1:
        half = left >> 1
        if record_s[first + half] <= s:
            first += half
        left -= half
    return first


def pose(plan: PlanView, curve: IntArray, s: FloatArray) -> _Pose:
    """Return x, y and heading at s of curves, all (n,), m and rad. The heading is not wrapped."""
    out = np.empty((3, len(curve)))
    poses(plan.start, plan.s, plan.x, plan.y, plan.hdg, plan.curvature, plan.rate, curve, s, out)
    return out[0], out[1], out[2]


def poses(
    start: IntArray,
    record_s: FloatArray,
    x: FloatArray,
    y: FloatArray,
    hdg: FloatArray,
    curvature: FloatArray,
    rate: FloatArray,
    curve: IntArray,
    s: FloatArray,
    out: FloatArray,
) -> None:
    """Write x, y and heading at s of curves, (3, n)."""
    for k in range(len(curve)):
        i = record_at(record_s, start[curve[k]], start[curve[k] + 1], float(s[k]))
        ds = float(s[k]) - float(record_s[i])
        out[0, k], out[1, k], out[2, k] = spirals.end(
            float(x[i]), float(y[i]), float(hdg[i]), float(curvature[i]), float(rate[i]), ds
        )


def project(plan: PlanView, curve: IntArray, x: FloatArray, y: FloatArray) -> _Pose:
    """Project points x, y, each on the curve of a given index: s, t (left positive) and distance, all (n,), m.

    Points before the start or beyond the end of a curve get its start or end; their distance is then more than |t|.
    """
    out = np.full((3, len(curve)), np.nan)
    columns = plan.start, plan.s, plan.x, plan.y, plan.hdg, plan.length, plan.curvature, plan.rate
    projections(*columns, curve, x, y, out)
    return out[0], out[1], out[2]


def projections(
    start: IntArray,
    s: FloatArray,
    x: FloatArray,
    y: FloatArray,
    hdg: FloatArray,
    length: FloatArray,
    curvature: FloatArray,
    rate: FloatArray,
    curve: IntArray,
    px: FloatArray,
    py: FloatArray,
    out: FloatArray,
) -> None:
    """Write s, t and distance of points, (3, n)."""
    for k in range(len(curve)):
        first, last = start[curve[k]], start[curve[k] + 1] - 1
        at_x, at_y = float(px[k]), float(py[k])
        least = _INFINITE
        for i in range(first, last + 1):
            least = min(least, _apart(at_x - float(x[i]), at_y - float(y[i])))
        best = _INFINITE
        for i in range(first, last + 1):
            # No record is farther away than its start, nor nearer than half of what both of its ends are farther
            # than its length.
            if first < last:
                nearest = _apart(at_x - float(x[i]), at_y - float(y[i])) - float(length[i])
                if i < last:
                    nearest = 0.5 * (nearest + _apart(at_x - float(x[i + 1]), at_y - float(y[i + 1])))
                if nearest > least + _GAP:
                    continue
            bend, rise, dx, dy = float(curvature[i]), float(rate[i]), at_x - float(x[i]), at_y - float(y[i])
            sine, cosine = trigonometry.sine_cosine(float(hdg[i]))
            along = nearest_on_record(bend, rise, float(length[i]), cosine * dx + sine * dy, cosine * dy - sine * dx)
            there_x, there_y, heading = spirals.end(float(x[i]), float(y[i]), float(hdg[i]), bend, rise, along)
            dx, dy = at_x - there_x, at_y - there_y
            distance = _apart(dx, dy)
            if not distance >= best:
                best = distance
                sine, cosine = trigonometry.sine_cosine(heading)
                out[0, k], out[1, k], out[2, k] = float(s[i]) + along, dy * cosine - dx * sine, distance


def nearest_on_record(curvature: float, rate: float, length: float, u: float, v: float) -> float:
    """Return how far along a record the place nearest to the point (u, v), in the frame of its start, lies, m."""
    mean = curvature + 0.5 * rate * length
    along = u
    if mean != 0.0:
        # Angle about the centre (0, 1/k) of the arc, counted along it, wrapped about the arc's middle. It is a guess
        # for spirals.
        side = 1.0 if mean > 0.0 else -1.0
        angle = trigonometry.arctangent(side * u, side * (1.0 / mean - v))
        middle = 0.5 * length * mean
        along = (middle + trigonometry.wrap(angle - middle)) / mean
    if rate != 0.0:
        return spirals.nearest_on_spiral(curvature, rate, length, u, v, along)
    return min(max(along, 0.0), length)


def _apart(x: float, y: float) -> float:
    """Return the length of a vector."""
    return math.sqrt(x * x + y * y)
