"""The bounding box of reference lines."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

_CARDINAL: Final = (0.0, np.pi / 2.0, np.pi, -np.pi / 2.0)


def plan_view_bounds(plan: PlanView) -> tuple[float, float, float, float]:
    """Return west, south, east, north of all reference lines, m.

    Exact for arcs too: where an arc runs parallel to an axis it may reach farther than its ends, so the points at
    which its heading is a multiple of 90 degrees count as well.

    Parameters
    ----------
    plan
        At least one record.
    """
    x, y = _points(plan, slice(None), plan.length)
    xs, ys = [plan.x, x], [plan.y, y]
    arcs = np.flatnonzero(plan.curvature)
    turn = plan.curvature[arcs] * plan.length[arcs]
    for heading in _CARDINAL:
        ahead, inside = _turn_to(heading, plan.hdg[arcs], turn)
        records = arcs[inside]
        x, y = _points(plan, records, ahead[inside] / plan.curvature[records])
        xs.append(x)
        ys.append(y)
    all_x, all_y = np.concatenate(xs), np.concatenate(ys)
    return float(all_x.min()), float(all_y.min()), float(all_x.max()), float(all_y.max())


def _points(plan: PlanView, records: IntArray | slice, ds: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Local x, y at ds (n,) from the start of n records, by the chord, which is stable for any curvature."""
    hdg = plan.hdg[records]
    half = 0.5 * plan.curvature[records] * ds
    chord = ds * np.sinc(half / np.pi)
    return plan.x[records] + chord * np.cos(hdg + half), plan.y[records] + chord * np.sin(hdg + half)


def _turn_to(heading: float, hdg: FloatArray, turn: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Angle from each start heading to `heading` in the sense of the turn, and where the arc gets that far."""
    ahead = np.mod(np.where(turn >= 0.0, heading - hdg, hdg - heading), 2.0 * np.pi)
    return np.copysign(ahead, turn), ahead <= np.abs(turn)
