"""Arcs cut for readers that make polylines of them, with points at equal steps from the start of each record.

The rest behind the last step may be a few centimetres long. Where such a reader moves its polyline aside, as to a
lane, so short a piece turns by degrees, or folds back on itself.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import advance, owners, ranks, starts
from osm2xodr.model import BoolArray, PlanView

# Shorter rests, as a share of the step, are made equal to the step before them. A choice.
_SHORT_REST: Final = 0.25
# Share of a step that counts as a rounding error.
_ROUNDING: Final = 1e-9


def with_even_ends(plan: PlanView, curves: BoolArray, step: float) -> PlanView:
    """Cut arcs of some curves, (curves,), so that the last two pieces of their polylines are equally long.

    `step` is the distance between their points, m. Lines and spirals stay.
    """
    count = np.ceil(plan.length / step - _ROUNDING)
    rest = plan.length - step * (count - 1.0)
    short = curves[owners(plan.start)] & (plan.curvature != 0.0) & (plan.rate == 0.0)
    short &= (count > 1) & (rest < _SHORT_REST * step)
    pieces = np.where(short, np.where(count > 2, 3, 2), 1)
    row, rank = np.repeat(np.arange(len(pieces)), pieces), ranks(pieces)
    ds = np.where(rank > 0, plan.length[row] - (pieces[row] - rank) * 0.5 * (step + rest[row]), 0.0)
    end = np.where(rank + 1 < pieces[row], np.roll(ds, -1), plan.length[row])
    pose = plan.x[row], plan.y[row], plan.hdg[row], plan.curvature[row]
    x, y, hdg = advance(*pose, ds, plan.rate[row])
    start = starts(pieces)[plan.start]
    return PlanView(start, plan.s[row] + ds, x, y, hdg, end - ds, plan.curvature[row], plan.rate[row])
