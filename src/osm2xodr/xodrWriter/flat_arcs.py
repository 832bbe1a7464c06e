"""Arcs of radii that readers cannot compute with, written as lines.

CARLA goes to the centre of an arc and back (``GeometryArc::PosFromDist``) in numbers of single precision: with a
radius of 30,000 km the places along such a road lie 2 m apart, with 1000 km still 3 cm beside it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.model import PlanView
from osm2xodr.xodrWriter.even_steps import cut_records

# Radius beyond which arcs become lines, m: numbers of single precision are 1.6 cm apart there.
LARGEST_RADIUS: Final = 200e3
# How far such a line may lie beside its arc, m; a choice. Headings then change by 0.006 degrees at its ends.
_SAGITTA: Final = 0.001


def without_flat_arcs(plan: PlanView) -> PlanView:
    """Replace arcs of large radii by lines between places on them."""
    bent = (plan.rate == 0.0) & (plan.curvature != 0.0)
    flat = np.flatnonzero(bent & (np.abs(plan.curvature) * LARGEST_RADIUS < 1.0))
    if not len(flat):
        return plan
    count = np.ceil(plan.length[flat] * np.sqrt(np.abs(plan.curvature[flat]) / (8.0 * _SAGITTA))).astype(np.int64)
    count = np.maximum(count, 1)
    cuts = [(row, plan.length[row] * k / n) for row, n in zip(flat, count.tolist(), strict=True) for k in range(1, n)]
    row, ds = np.array(cuts, float).reshape(-1, 2).T
    out = cut_records(plan, row.astype(np.int64), ds)
    lines = (out.rate == 0.0) & (np.abs(out.curvature) * LARGEST_RADIUS < 1.0)
    # Chords: the ends of arcs as flat as these lie less than a micrometre farther along the line.
    hdg = np.where(lines, out.hdg + 0.5 * out.curvature * out.length, out.hdg)
    return replace(out, hdg=hdg, curvature=np.where(lines, 0.0, out.curvature))
