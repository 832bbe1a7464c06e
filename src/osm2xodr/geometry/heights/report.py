"""Reports on the heights that were found: diagnostics, figures, and tables of places and structures."""

from __future__ import annotations

import math
from typing import Final, TypeVar

import numpy as np

from osm2xodr.curves import dot, hypot
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.crossings import Crossings
from osm2xodr.geometry.heights.elements import Elements, Network, element_at
from osm2xodr.geometry.heights.limits import deepest_cuts
from osm2xodr.geometry.heights.observations import earthwork_samples
from osm2xodr.geometry.heights.problem import ProfileProblem, curve_spans
from osm2xodr.geometry.heights.readings import Reading
from osm2xodr.model import (
    BoolArray,
    ElevationReport,
    FloatArray,
    IntArray,
    LayerCrossing,
    RoadPlace,
    Structure,
    StructureRecord,
    applied,
    unused,
)
from osm2xodr.system import record

# So many places are tabulated that are farthest from the ground.
_WORST: Final = 10
# Ways are reported that are off the ground by this more than their class may be, m: limits give way by centimetres.
_OFF_GROUND_FROM: Final = 0.5
# What keeps a road off the ground lies within this distance along it, m. A choice.
_REASON_REACH: Final = 100.0
# Shorter stretches without heights are not reported, m.
_GAP_FROM: Final = 1.0
# Elastic limits are exceeded a little wherever they are at work: grades above them by less are not reported.
_GRADE_TOLERANCE: Final = 0.002
# A road within this distance of a height that the user knows, m, is where it should be: centimetres are lost where
# records are made. A choice.
_KNOWN_TOLERANCE: Final = 0.1
_LEVEL: Final = "all ground is at one height; give an elevation model"
# Stands in for a length of 0 in quotients, m.
_SHORTEST: Final = 1e-9

_Number = TypeVar("_Number", float, FloatArray)


@record(eq=False)
class Outcome:
    """A solution, as its reports need it."""

    z: FloatArray  # (n,) Height of the road at each sample, m
    knots: FloatArray  # (knots, 2) Height, m, and grade at each knot
    planes: FloatArray  # (J, 3) Height, m, and gradient of each junction's plane about its origin
    reading: Reading  # The ground there
    floating: BoolArray  # (R,) Roads that no measured ground holds
    grade: FloatArray  # (E,) Largest grade of each element
    limit: FloatArray  # (E,) Limit of its class
    # Where layers cross, and the height between them, m
    crossings: Crossings
    clearance: FloatArray
    chain: IntArray  # (E,) Chain of structures of each element, -1 on the ground


def element_grades(elements: Elements, knots: FloatArray) -> FloatArray:
    """Return the largest grade of each element, (E,), from z and g of the knots, (knots, 2)."""
    a, b = knots[elements.knot], knots[elements.knot + 1]
    secant = (b[:, 0] - a[:, 0]) / elements.h
    # The grade is a parabola in u; where its vertex lies within the element it may be the steepest place.
    curve, slope = 3 * (a[:, 1] + b[:, 1] - 2 * secant), 2 * (3 * secant - 2 * a[:, 1] - b[:, 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        u = np.clip(np.nan_to_num(-slope / (2 * curve), nan=0.0, posinf=0.0, neginf=0.0), 0.0, 1.0)
    vertex = a[:, 1] + slope * u + curve * u * u
    out: FloatArray = np.max(np.abs([a[:, 1], b[:, 1], vertex]), axis=0)
    return out


def tolerated_grade(limit: _Number) -> _Number:
    """Return the grade above which a road whose class has this limit is reported as too steep."""
    return defaults.GRADE_SLACK * limit + _GRADE_TOLERANCE


def tolerated_clearance(wanted: _Number) -> _Number:
    """Return the clearance, m, below which a place where so much is wanted is reported as too close."""
    return wanted - defaults.CLEARANCE_TOLERANCE


def _too_close(outcome: Outcome) -> IntArray:
    """Return for each place with less clearance than wanted where it has least against it."""
    short = outcome.crossings.clearance - outcome.clearance
    found = np.flatnonzero(outcome.clearance < tolerated_clearance(outcome.crossings.clearance))
    worst: IntArray = found[_largest_of_each(outcome.crossings.place[found], short[found])]
    return worst


def _crossing_ways(problem: ProfileProblem, crossings: Crossings) -> tuple[IntArray, IntArray]:
    """Return the OSM ways of the upper and of the lower road at each crossing."""
    upper = curve_spans(problem, crossings.upper, crossings.upper_s)
    lower = curve_spans(problem, crossings.lower, crossings.lower_s)
    return problem.span_way[upper], problem.span_way[lower]


def _samples_on_ground(network: Network, outcome: Outcome) -> IntArray:
    """Return the samples on the ground whose heights are measured."""
    ground = network.elements.structure[network.samples.element] == Structure.GROUND
    return np.flatnonzero(ground & outcome.reading.measured)


# ---------------------------------------------------------------- diagnostics


def report(network: Network, outcome: Outcome, diagnostics: Diagnostics) -> None:
    """Report which heights are guesses and which limits are not met."""
    _report_gaps(network, outcome, diagnostics)
    report_limits(network, outcome, diagnostics)
    _report_inclines(network.problem, diagnostics)
    _report_off_ground(network, outcome, diagnostics)


def report_limits(network: Network, outcome: Outcome, diagnostics: Diagnostics) -> None:
    """Report which limits of grades and clearances are not met."""
    _report_grades(network, outcome, diagnostics)
    _report_crossings(network.problem, outcome, diagnostics)


def _length_by_way(network: Network, samples: IntArray) -> dict[int, float]:
    """Return the length of road that samples stand for by OSM way, m, in order of ways."""
    span = network.elements.span[network.samples.element[samples]]
    way, index = np.unique(network.problem.span_way[span], return_inverse=True)
    total = np.bincount(index, network.samples.ds[samples], minlength=len(way))
    return dict(zip(way.tolist(), total.tolist(), strict=True))


def _report_gaps(network: Network, outcome: Outcome, diagnostics: Diagnostics) -> None:
    elements, element = network.elements, network.samples.element
    floating = outcome.floating[elements.road[element]]
    gap = ~outcome.reading.measured & ((elements.structure[element] == Structure.GROUND) | floating)
    unknown = gap & (outcome.reading.away > defaults.UNKNOWN_FROM)
    if unknown.any():
        total = float(network.samples.ds[unknown].sum()) / 1000.0
        diagnostics.guessed(
            "height-unknown",
            "",
            f"the heights of {total:.1f} km of roads are not known: nothing within "
            f"{defaults.UNKNOWN_FROM / 1000.0:g} km of them is measured. They follow the trend of what is; give an "
            "elevation model that covers them.",
        )
    for way, length in _length_by_way(network, np.flatnonzero(gap)).items():
        if length >= _GAP_FROM:
            diagnostics.guessed(
                "no-height",
                f"way/{way}",
                f"the elevation model has no heights along {length:.0f} m of it, they are filled from around",
            )
    for way, length in _length_by_way(network, np.flatnonzero(outcome.reading.measured & floating)).items():
        diagnostics.guessed(
            "no-ground",
            f"way/{way}",
            f"nothing it is connected to lies on the ground, {length:.0f} m of it take the ground's height",
        )


def _report_grades(network: Network, outcome: Outcome, diagnostics: Diagnostics) -> None:
    largest: dict[int, tuple[float, float]] = {}
    for e in np.flatnonzero(outcome.grade > tolerated_grade(outcome.limit)).tolist():
        way = int(network.problem.span_way[network.elements.span[e]])
        found = (float(outcome.grade[e]), float(outcome.limit[e]))
        largest[way] = max(largest.get(way, found), found)
    for way, (grade, limit) in sorted(largest.items()):
        diagnostics.note(
            "steep",
            f"way/{way}",
            f"its grade reaches {100 * grade:.1f} %, more than the {100 * limit:.0f} % usual for its class",
        )


def _report_crossings(problem: ProfileProblem, outcome: Outcome, diagnostics: Diagnostics) -> None:
    upper, lower = _crossing_ways(problem, outcome.crossings)
    # Rounded, and 0 without a sign.
    clearance = np.round(outcome.clearance, 1) + 0.0
    for k in _too_close(outcome).tolist():
        diagnostics.note(
            "clearance",
            f"way/{upper[k]}",
            f"it passes {clearance[k]:.1f} m above way/{lower[k]} instead of {outcome.crossings.clearance[k]:.1f} m, "
            "more would make the roads too steep",
        )


def report_known_heights(problem: ProfileProblem, z: FloatArray | None, diagnostics: Diagnostics) -> None:
    """Report corrections of heights; `z` (n,) are the heights of the solution there, m, None on a level world."""
    if problem.known is None:
        return
    for k, (node, wanted) in enumerate(zip(problem.known.node.tolist(), problem.known.z.tolist(), strict=True)):
        if z is None:
            unused(diagnostics, f"node/{node}", "z", _LEVEL)
        elif abs(float(z[k]) - wanted) > _KNOWN_TOLERANCE:
            why = f"the road is at {z[k]:.2f} m there instead of {wanted:.2f} m, which would be too steep"
            unused(diagnostics, f"node/{node}", "z", why)
        else:
            applied(diagnostics, f"node/{node}", "z", f"the road is at {z[k]:.2f} m there")


def report_known_clearances(problem: ProfileProblem, crossings: Crossings | None, diagnostics: Diagnostics) -> None:
    """Report corrections of clearances; None for no crossings."""
    if problem.span_clearance is None:
        return
    known = np.isfinite(problem.span_clearance)
    used = set() if crossings is None or crossings.known_by is None else set(crossings.known_by.tolist())
    for way in np.unique(problem.span_way[known]).tolist():
        wanted = float(problem.span_clearance[known & (problem.span_way == way)][0])
        if way in used:
            message = f"{wanted:g} m from road to road where others pass over or under it"
            applied(diagnostics, f"way/{way}", "clearance", message)
        else:
            why = "no road passes over or under it, or one with a correction of its own"
            unused(diagnostics, f"way/{way}", "clearance", why)


def _report_inclines(problem: ProfileProblem, diagnostics: Diagnostics) -> None:
    wrong = np.isfinite(problem.span_grade) & (np.abs(problem.span_grade) > defaults.INCLINE_MAX)
    for way in np.unique(problem.span_way[wrong]).tolist():
        diagnostics.dropped("incline", f"way/{way}", "its incline is steeper than any street, it is ignored")


def _report_off_ground(network: Network, outcome: Outcome, diagnostics: Diagnostics) -> None:
    """Report ways that lie farther off the ground than cuts and fills of their class are deep, and why."""
    at = np.flatnonzero(earthwork_samples(network, outcome.reading))
    off = (outcome.z - outcome.reading.z)[at]
    beyond = np.abs(off) - deepest_cuts(network, outcome.reading, at)
    way = network.problem.span_way[network.elements.span[network.samples.element[at]]]
    for k in _largest_of_each(way, beyond).tolist():
        if beyond[k] > _OFF_GROUND_FROM:
            side = "above" if off[k] > 0.0 else "below"
            diagnostics.note(
                "off-ground",
                f"way/{way[k]}",
                f"it lies up to {abs(off[k]):.1f} m {side} the ground of the elevation model, "
                f"{beyond[k]:.1f} m more than roads of its class are cut or filled: "
                + _reason(network, outcome, int(at[k])),
            )


def _reason(network: Network, outcome: Outcome, sample: int) -> str:
    """Return what keeps a road off the ground at a sample."""
    problem, elements, samples = network.problem, network.elements, network.samples
    element, s = int(samples.element[sample]), float(samples.s[sample])
    road = int(elements.road[element])
    near = np.flatnonzero((elements.road == road) & (np.abs(elements.s + 0.5 * elements.h - s) < _REASON_REACH))
    crossings = outcome.crossings
    for curve, place in ((crossings.upper, crossings.upper_s), (crossings.lower, crossings.lower_s)):
        if ((curve == road) & (np.abs(place - s) < _REASON_REACH)).any():
            return "it keeps clear of the roads above or below"
    if (outcome.grade[near] > 0.98 * defaults.GRADE_SLACK * outcome.limit[near]).any():
        return f"it is as steep as it may be, {100 * float(outcome.grade[near].max()):.0f} %"
    length = float(elements.s[elements.end_elements[road, 1]] + elements.h[elements.end_elements[road, 1]])
    start, end = (int(j) for j in problem.end_junction[road])
    if (start >= 0 and s < _REASON_REACH) or (end >= 0 and length - s < _REASON_REACH):
        return "it meets the other roads of its junction"
    return "it bends no more than cars take, or than the ground's heights are sure"


# ---------------------------------------------------------------- figures and tables


def statistics(elements: Elements, outcome: Outcome, tables: ElevationReport) -> dict[str, float]:
    """Return the figures of a solution by their names in reports."""
    steep = outcome.grade > outcome.limit
    too_steep = sum(item.grade > tolerated_grade(item.grade_limit) for item in tables.structures)
    return {
        "height_above_surface_mean_m": tables.bias,
        "height_above_surface_rms_m": tables.rms,
        "height_above_surface_p95_m": tables.p95,
        "grade_max": float(outcome.grade.max(initial=0.0)),
        "grade_over_class_limit_km": float(elements.h[steep].sum()) / 1000.0,
        "junction_tilt_max": float(hypot(outcome.planes[:, 1], outcome.planes[:, 2]).max(initial=0.0)),
        "layer_crossings": float(len(np.unique(outcome.crossings.place))),
        "layer_crossings_too_close": float(len(tables.tight)),
        "structures": float(len(tables.structures)),
        "structures_too_steep": float(too_steep),
    }


def tabulate(network: Network, outcome: Outcome) -> ElevationReport:
    """Return the tables of a solution: how far from the ground, how steep, and all structures."""
    ds, reading = network.samples.ds, outcome.reading
    held = _samples_on_ground(network, outcome)
    off = (outcome.z - reading.surface_z)[held]
    weight = ds[held] / max(float(ds[held].sum()), _SHORTEST)
    return ElevationReport(
        bias=dot(weight, off),
        rms=math.sqrt(dot(weight, off * off)),
        p95=float(np.percentile(np.abs(off), 95)) if len(off) else 0.0,
        farthest=_farthest(network, held, off),
        steep=_steep(network, outcome),
        structures=_structures(network, outcome),
        tight=_tight(network.problem, outcome),
    )


def _road_ids(problem: ProfileProblem) -> IntArray:
    """Return the ids of roads, and behind them those of connecting roads, which go on from the last one."""
    ids = np.arange(len(problem.end_junction), dtype=np.int64) if problem.road_id is None else problem.road_id
    connecting = 0 if problem.connectors is None else len(problem.connectors.junction)
    more = ids.max(initial=-1) + 1 + np.arange(connecting, dtype=np.int64)
    return np.concatenate([ids, more])


def _largest_of_each(group: IntArray, value: FloatArray) -> IntArray:
    """Return the index of the first largest value of each group, groups ascending."""
    order = np.lexsort((-value, group))
    first: IntArray = order[np.diff(group[order], prepend=-1) != 0]
    return first


def _worst_first(road: IntArray, value: FloatArray) -> list[int]:
    """Return the index of the largest value on each road, the road with the largest first."""
    worst = _largest_of_each(road, value)
    indices: list[int] = worst[np.lexsort((road[worst], -value[worst]))].tolist()
    return indices


def _road_place(network: Network, element: int, s: float, value: float, wanted: float) -> RoadPlace:
    problem, elements = network.problem, network.elements
    road, way = _road_ids(problem)[elements.road[element]], problem.span_way[elements.span[element]]
    return RoadPlace(int(road), int(way), float(s), float(value), float(wanted))


def _farthest(network: Network, held: IntArray, off: FloatArray) -> tuple[RoadPlace, ...]:
    element, s = network.samples.element[held], network.samples.s[held]
    worst = _worst_first(network.elements.road[element], np.abs(off))[:_WORST]
    return tuple(_road_place(network, element[k], s[k], off[k], 0.0) for k in worst)


def _steep(network: Network, outcome: Outcome) -> tuple[RoadPlace, ...]:
    elements, grade, limit = network.elements, outcome.grade, outcome.limit
    steep = np.flatnonzero(grade > limit)
    worst = steep[_worst_first(elements.road[steep], (grade / limit)[steep])].tolist()
    middle = elements.s + 0.5 * elements.h
    return tuple(_road_place(network, e, middle[e], grade[e], limit[e]) for e in worst)


def _tight(problem: ProfileProblem, outcome: Outcome) -> tuple[LayerCrossing, ...]:
    crossings, ids = outcome.crossings, _road_ids(problem)
    upper, lower = _crossing_ways(problem, crossings)
    short = _too_close(outcome)
    order = short[np.argsort((outcome.clearance - crossings.clearance)[short], kind="stable")]
    columns = (ids[crossings.upper], ids[crossings.lower], upper, lower, outcome.clearance, crossings.clearance)
    return tuple(LayerCrossing(*row) for row in zip(*(column[order].tolist() for column in columns), strict=True))


def _structures(network: Network, outcome: Outcome) -> tuple[StructureRecord, ...]:
    problem, elements = network.problem, network.elements
    ids, crossed, heights = _road_ids(problem), _crossed(network, outcome), _above_ground(network, outcome)
    on = np.flatnonzero(outcome.chain >= 0)
    order = on[np.argsort(outcome.chain[on], kind="stable")]
    cuts = np.flatnonzero(np.diff(outcome.chain[order])) + 1
    records = []
    for members in np.split(order, cuts) if len(order) else []:
        chain = int(outcome.chain[members[0]])
        clearance, crossed_way = min(crossed.get(chain, []), default=(None, None))
        # The class counts where the chain is steepest against its limit.
        worst = members[np.argmax(outcome.grade[members] / outcome.limit[members])]
        records.append(
            StructureRecord(
                kind=Structure(int(elements.structure[members[0]])).name.lower(),
                osm_way_ids=tuple(dict.fromkeys(problem.span_way[elements.span[members]].tolist())),
                roads=tuple(dict.fromkeys(ids[elements.road[members]].tolist())),
                length=float(elements.h[members].sum()),
                above_ground=heights.get(chain),
                clearance=clearance,
                crossed_way=crossed_way,
                grade=float(outcome.grade[worst]),
                grade_limit=float(outcome.limit[worst]),
            )
        )
    return tuple(sorted(records, key=lambda record: (record.osm_way_ids, record.roads)))


def _crossed(network: Network, outcome: Outcome) -> dict[int, list[tuple[float, int]]]:
    """Return the clearances, m, and crossed ways of each chain."""
    crossings = outcome.crossings
    upper_way, lower_way = _crossing_ways(network.problem, crossings)
    out: dict[int, list[tuple[float, int]]] = {}
    for road, s, way in (
        (crossings.upper, crossings.upper_s, lower_way),
        (crossings.lower, crossings.lower_s, upper_way),
    ):
        plain = np.flatnonzero(road < len(network.problem.end_junction))
        chain = outcome.chain[element_at(network.elements, road[plain], s[plain])]
        for k, of in zip(plain[chain >= 0].tolist(), chain[chain >= 0].tolist(), strict=True):
            out.setdefault(of, []).append((float(outcome.clearance[k]), int(way[k])))
    return out


def _above_ground(network: Network, outcome: Outcome) -> dict[int, float]:
    """Return for each chain its height where it is farthest above the ground, or below it in tunnels, m."""
    element = network.samples.element
    chain = outcome.chain[element]
    used = np.flatnonzero((chain >= 0) & outcome.reading.measured)
    height = (outcome.z - outcome.reading.surface_z)[used]
    sign = np.where(network.elements.structure[element[used]] == Structure.TUNNEL, -1.0, 1.0)
    first = _largest_of_each(chain[used], sign * height)
    return dict(zip(chain[used][first].tolist(), height[first].tolist(), strict=True))
