"""The heights that were found, as tables for the report: how far from the ground, how steep, and all structures."""

from __future__ import annotations

import numpy as np

from osm2xodr.geometry import defaults
from osm2xodr.geometry.heights.elements import Elements, Samples, element_at
from osm2xodr.geometry.heights.problem import ProfileProblem, span_at
from osm2xodr.geometry.heights.report import Outcome, too_close
from osm2xodr.model import ElevationReport, FloatArray, IntArray, LayerCrossing, RoadPlace, Structure, StructureRecord

# So many of the roads that lie farthest from the elevation model are named.
WORST = 10


def elevation_report(
    problem: ProfileProblem, elements: Elements, samples: Samples, outcome: Outcome
) -> ElevationReport:
    """Return the tables of a solution."""
    ds, reading = samples.ds, outcome.reading
    on_ground = elements.structure[samples.element] == Structure.GROUND
    held = np.flatnonzero(on_ground & reading.measured)
    off = (outcome.z - reading.surface_z)[held]
    weight = ds[held] / max(float(ds[held].sum()), 1e-9)
    return ElevationReport(
        measured_share=float(ds[reading.measured].sum() / max(float(ds.sum()), 1e-9)),
        bias=float(weight @ off),
        rms=float(np.sqrt(weight @ off**2)),
        p95=float(np.percentile(np.abs(off), 95)) if len(off) else 0.0,
        farthest=_farthest(problem, elements, samples, held, off),
        steep=_steep(problem, elements, outcome),
        structures=_structures(problem, elements, samples, outcome),
        tight=_tight(problem, outcome),
    )


def _road_ids(problem: ProfileProblem) -> IntArray:
    return np.arange(len(problem.end_junction), dtype=np.int64) if problem.road_id is None else problem.road_id


def _worst_per_road(road: IntArray, value: FloatArray) -> IntArray:
    """Return the index of the largest value on each road, the road with the largest first."""
    order = np.lexsort((np.arange(len(road)), -value, road))
    first = order[np.r_[True, np.diff(road[order]) != 0]] if len(order) else order
    out: IntArray = first[np.lexsort((road[first], -value[first]))]
    return out


def _farthest(
    problem: ProfileProblem, elements: Elements, samples: Samples, held: IntArray, off: FloatArray
) -> tuple[RoadPlace, ...]:
    ids = _road_ids(problem)
    element = samples.element[held]
    worst = _worst_per_road(elements.road[element], np.abs(off))[:WORST].tolist()
    return tuple(
        RoadPlace(
            int(ids[elements.road[element[k]]]),
            int(problem.span_way[elements.span[element[k]]]),
            float(samples.s[held[k]]),
            float(off[k]),
            0.0,
        )
        for k in worst
    )


def _steep(problem: ProfileProblem, elements: Elements, outcome: Outcome) -> tuple[RoadPlace, ...]:
    ids = _road_ids(problem)
    steep = np.flatnonzero(outcome.grade > outcome.limit)
    worst = steep[_worst_per_road(elements.road[steep], (outcome.grade / outcome.limit)[steep])].tolist()
    return tuple(
        RoadPlace(
            int(ids[elements.road[e]]),
            int(problem.span_way[elements.span[e]]),
            float(elements.s[e] + 0.5 * elements.h[e]),
            float(outcome.grade[e]),
            float(outcome.limit[e]),
        )
        for e in worst
    )


def _tight(problem: ProfileProblem, outcome: Outcome) -> tuple[LayerCrossing, ...]:
    crossings, ids = outcome.crossings, _road_ids(problem)
    upper = problem.span_way[span_at(problem, crossings.upper, crossings.upper_s)]
    lower = problem.span_way[span_at(problem, crossings.lower, crossings.lower_s)]
    short = np.flatnonzero(too_close(outcome))
    order = short[np.argsort((outcome.clearance - crossings.clearance)[short], kind="stable")]
    return tuple(
        LayerCrossing(
            int(ids[crossings.upper[k]]),
            int(ids[crossings.lower[k]]),
            int(upper[k]),
            int(lower[k]),
            float(outcome.clearance[k]),
            float(crossings.clearance[k]),
        )
        for k in order.tolist()
    )


def _structures(
    problem: ProfileProblem, elements: Elements, samples: Samples, outcome: Outcome
) -> tuple[StructureRecord, ...]:
    ids = _road_ids(problem)
    crossed = _crossed(problem, elements, outcome)
    heights = _above_ground(elements, samples, outcome)
    on = np.flatnonzero(outcome.chain >= 0)
    order = on[np.argsort(outcome.chain[on], kind="stable")]
    cuts = np.flatnonzero(np.diff(outcome.chain[order])) + 1
    records = []
    for members in np.split(order, cuts) if len(order) else []:
        chain = int(outcome.chain[members[0]])
        tightest = min(crossed.get(chain, []), default=None)
        # The class counts where the chain is steepest against its limit.
        worst = members[np.argmax(outcome.grade[members] / outcome.limit[members])]
        records.append(
            StructureRecord(
                kind=Structure(int(elements.structure[members[0]])).name.lower(),
                osm_way_ids=tuple(dict.fromkeys(problem.span_way[elements.span[members]].tolist())),
                roads=tuple(dict.fromkeys(ids[elements.road[members]].tolist())),
                length=float(elements.h[members].sum()),
                above_ground=heights.get(chain),
                clearance=None if tightest is None else tightest[0],
                crossed_way=None if tightest is None else tightest[1],
                grade=float(outcome.grade[worst]),
                grade_limit=float(outcome.limit[worst]),
            )
        )
    return tuple(sorted(records, key=lambda record: (record.osm_way_ids, record.roads)))


def _crossed(problem: ProfileProblem, elements: Elements, outcome: Outcome) -> dict[int, list[tuple[float, int]]]:
    """Return the clearances and crossed ways of each chain."""
    crossings = outcome.crossings
    ends = ((crossings.upper, crossings.upper_s), (crossings.lower, crossings.lower_s))
    out: dict[int, list[tuple[float, int]]] = {}
    for (road, s), (other, other_s) in (ends, ends[::-1]):
        chain = outcome.chain[element_at(elements, road, s)]
        way = problem.span_way[span_at(problem, other, other_s)]
        for k in np.flatnonzero(chain >= 0).tolist():
            out.setdefault(int(chain[k]), []).append((float(outcome.clearance[k]), int(way[k])))
    return out


def _above_ground(elements: Elements, samples: Samples, outcome: Outcome) -> dict[int, float]:
    """Return for each chain its height where it is farthest above the ground, or below it in tunnels, m."""
    chain = outcome.chain[samples.element]
    used = np.flatnonzero((chain >= 0) & outcome.reading.measured)
    height = (outcome.z - outcome.reading.surface_z)[used]
    sign = np.where(elements.structure[samples.element[used]] == Structure.TUNNEL, -1.0, 1.0)
    order = np.lexsort((-sign * height, chain[used]))
    first = order[np.r_[True, np.diff(chain[used][order]) != 0]] if len(order) else order
    return dict(zip(chain[used][first].tolist(), height[first].tolist(), strict=True))


def figures(elements: Elements, outcome: Outcome, told: ElevationReport) -> dict[str, float]:
    """Return the figures of a solution by their names in reports."""
    steep = outcome.grade > outcome.limit
    return {
        "height_measured_share": told.measured_share,
        "height_above_surface_mean_m": told.bias,
        "height_above_surface_rms_m": told.rms,
        "height_above_surface_p95_m": told.p95,
        "grade_max": float(outcome.grade.max(initial=0.0)),
        "grade_over_class_limit_km": float(elements.h[steep].sum()) / 1000.0,
        "junction_tilt_max": float(outcome.tilt.max(initial=0.0)),
        "layer_crossings": float(len(outcome.clearance)),
        "layer_crossings_too_close": float(len(told.tight)),
        "structures": float(len(told.structures)),
        "structures_too_steep": float(
            sum(record.grade > defaults.GRADE_SLACK * record.grade_limit + 0.002 for record in told.structures)
        ),
    }
