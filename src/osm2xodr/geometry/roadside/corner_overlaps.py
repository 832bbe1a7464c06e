"""Whether strips round the corners of junctions lie on lanes for cars."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import cosine, pose, project, repeated, runs, sine, smooth_step, sorted_unique, unique_inverse
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.roadside import defaults
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Shares of a path at which it is compared with lanes for cars: every few metres of a corner.
PROBES: Final = np.linspace(0.0, 1.0, 9)[1:-1]
# A place lies abreast of a curve, not beyond its ends, if its distance is |t| up to this, m.
_ABREAST: Final = 0.01
# What reaches less far onto a lane only touches it, m: above errors of rounding, below anything that is built.
_TOUCHING: Final = 0.001


def at_probes(start: FloatArray, end: FloatArray) -> FloatArray:
    """Return values that change from start to end as a smooth step, (rows,), at all probes, (rows, probes)."""
    return start[:, None] + (end - start)[:, None] * smooth_step(PROBES)


def probes(rows: ConnectingRoads, start: FloatArray, end: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return x, y along lines beside reference lines, at t that changes from start to end as a smooth step.

    All (rows, probes), m.
    """
    curve = np.repeat(np.arange(len(rows.length)), len(PROBES))
    x, y, hdg = pose(rows.plan_view, curve, (rows.length[:, None] * PROBES).ravel())
    t = at_probes(start, end).ravel()
    shape = len(rows.length), len(PROBES)
    return (x - t * sine(hdg)).reshape(shape), (y + t * cosine(hdg)).reshape(shape)


def onto_lanes(
    rows: ConnectingRoads, cars: ConnectingRoads, x: FloatArray, y: FloatArray, half: FloatArray
) -> BoolArray:
    """Say which strips lie on a lane for cars through their junction, (rows,).

    A strip is the places x, y, and `half` of its width to either side, all (rows, probes), m.
    """
    row, car = _pairs(rows.junction, cars.junction)
    lane = np.minimum(cars.entry_width, cars.exit_width) / 2
    used, place = unique_inverse(car)
    s = np.linspace(0.0, 1.0, len(PROBES)) * cars.length[used][:, None]
    px, py, _ = (v.reshape(s.shape) for v in pose(cars.plan_view, np.repeat(used, len(PROBES)), s.ravel()))
    # A curve leaves the box of its probes by less than a quarter of the way between two of them.
    slack = 0.25 * cars.length[used] / (len(PROBES) - 1)
    widest = half.max(axis=1)
    near = np.ones(len(row), bool)
    for one, other in ((x, px), (y, py)):
        gap = slack[place] + widest[row] + lane[car]
        near &= (one.min(1)[row] < other.max(1)[place] + gap) & (one.max(1)[row] > other.min(1)[place] - gap)
    row, car = row[near], car[near]
    _, _, distance = project(cars.plan_view, np.repeat(car, len(PROBES)), x[row].ravel(), y[row].ravel())
    reach = half[row] + lane[car, None] - _TOUCHING
    out = np.zeros(len(rows.length), bool)
    out[row[(distance.reshape(-1, len(PROBES)) < reach).any(axis=1)]] = True
    return out


def onto_roads(junction: IntArray, parts: RoadParts, x: FloatArray, y: FloatArray) -> BoolArray:
    """Say which paths x, y (paths, probes), m, run over the carriageway of an arm of their junction (paths,)."""
    arms = np.flatnonzero(parts.end_junction.ravel() >= 0)
    arms = arms[np.argsort(parts.end_junction.ravel()[arms], kind="stable")]
    path, arm = _pairs(junction, parts.end_junction.ravel()[arms])
    end = arms[arm]
    road = np.repeat(end // 2, len(PROBES))
    _, t, distance = project(parts.plan_view, road, x[path].ravel(), y[path].ravel())
    sections = {int(k): parts.at_end(int(k)).section for k in sorted_unique(end)}
    left = np.repeat([sections[k].left_edge for k in end.tolist()], len(PROBES))
    right = np.repeat([sections[k].right_edge for k in end.tolist()], len(PROBES))
    beside = np.abs(distance - np.abs(t)) < _ABREAST
    on = beside & (t < left - defaults.CORNER_ONTO_LANE) & (t > right + defaults.CORNER_ONTO_LANE)
    out = np.zeros(len(junction), bool)
    out[path[on.reshape(-1, len(PROBES)).any(axis=1)]] = True
    return out


def _pairs(one: IntArray, other: IntArray) -> tuple[IntArray, IntArray]:
    """Return the indices of all pairs of rows of the same junction; `other` is ascending."""
    first = np.searchsorted(other, one)
    count = np.searchsorted(other, one, side="right") - first
    row = repeated(count)
    return row, runs(first, count)
