"""The bounding box of reference lines."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.model import BoolArray, FloatArray, PlanView

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
    x, y = _points(plan, plan.length)
    xs, ys = [plan.x, x], [plan.y, y]
    turn = plan.curvature * plan.length
    for heading in _CARDINAL:
        ahead, inside = _turn_to(heading, plan.hdg, turn)
        ds = np.divide(ahead, plan.curvature, out=np.zeros_like(ahead), where=inside)
        x, y = _points(plan, ds)
        xs.append(x)
        ys.append(y)
    all_x, all_y = np.concatenate(xs), np.concatenate(ys)
    return float(all_x.min()), float(all_y.min()), float(all_x.max()), float(all_y.max())


def _points(plan: PlanView, ds: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Local x, y at ds (records,) from the start of each record, by the chord, which is stable for any curvature."""
    half = 0.5 * plan.curvature * ds
    chord = ds * np.sinc(half / np.pi)
    return plan.x + chord * np.cos(plan.hdg + half), plan.y + chord * np.sin(plan.hdg + half)


def _turn_to(heading: float, hdg: FloatArray, turn: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Angle from each start heading to `heading` in the sense of the turn, and where the arc gets that far."""
    ahead = np.mod(np.where(turn >= 0.0, heading - hdg, hdg - heading), 2.0 * np.pi)
    return np.copysign(ahead, turn), (turn != 0.0) & (ahead <= np.abs(turn))
