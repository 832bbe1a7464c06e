"""Reference lines cut for readers that make polylines of them.

Their points lie at equal steps from the start of each record, and where lane sections and lane offsets begin. The
rest behind the last step, or before such a place, may be a few centimetres long. Where a polyline is moved aside, as
to a lane, so short a piece turns by degrees, or folds back on itself.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import cut_records, find_record, owners
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView, RoadMap

# Shorter rests, as a share of the step, are made equal to the step before them; records are cut no nearer than that
# to their ends. A choice.
_SHORT_REST: Final = 0.25
# Share of a step that counts as a rounding error.
_ROUNDING: Final = 1e-9


def plan_of_even_steps(road_map: RoadMap, step: float) -> PlanView:
    """Cut the reference lines of roads outside junctions so that their polylines have no short pieces.

    `step` is the distance between points of the polylines, m.
    """
    plain = np.array([road.junction is None for road in road_map.roads], bool)
    sections = [(k, section.s) for k, road in enumerate(road_map.roads) for section in road.lane_sections[1:]]
    curve, s = np.array(sections, float).reshape(-1, 2).T
    offset = road_map.lane_offset
    curve, s = np.concatenate([curve.astype(np.int64), owners(offset.start)]), np.concatenate([s, offset.s])
    chosen = plain[curve]
    plan = cut_at(road_map.plan_view, curve[chosen], s[chosen], _SHORT_REST * step)
    return with_even_ends(plan, plain, step)


def cut_at(plan: PlanView, curve: IntArray, s: FloatArray, least: float) -> PlanView:
    """Cut arcs and spirals at places (n,), m, none nearer than `least` to a record's ends or the place before it."""
    row = find_record(plan.start, plan.s, curve, s)
    ds = s - plan.s[row]
    bent = (plan.curvature[row] != 0.0) | (plan.rate[row] != 0.0)
    inside = bent & (ds >= least) & (plan.length[row] - ds >= least)
    order = np.lexsort((ds[inside], row[inside]))
    row, ds = row[inside][order], ds[inside][order]
    apart = np.ones(len(row), bool)
    apart[1:] = (row[1:] != row[:-1]) | (ds[1:] - ds[:-1] >= least)
    return cut_records(plan, row[apart], ds[apart])


def with_even_ends(plan: PlanView, curves: BoolArray, step: float) -> PlanView:
    """Cut records of some curves, (curves,), so that the last two pieces of their polylines are equally long.

    `step` is the distance between their points, m.
    """
    count = np.ceil(plan.length / step - _ROUNDING)
    rest = plan.length - step * (count - 1.0)
    short = np.flatnonzero(curves[owners(plan.start)] & (count > 1) & (rest < _SHORT_REST * step))
    half, end = 0.5 * (step + rest[short]), plan.length[short]
    long = count[short] > 2
    row = np.concatenate([short[long], short])
    return cut_records(plan, row, np.concatenate([end[long] - 2.0 * half[long], end - half]))
