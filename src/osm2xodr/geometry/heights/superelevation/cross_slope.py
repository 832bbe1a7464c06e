"""Cross slope of fast roads, as a fine model shows it or as they are designed."""

from __future__ import annotations

from typing import Final

import numpy as np
import scipy.sparse as sp

from osm2xodr.conventions import MEASURED, NO_SUPERELEVATION
from osm2xodr.curves import (
    arctan2,
    connected_groups,
    cosine,
    lengths,
    sine,
)
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.elements import Network, assemble, bending_matrices, hermite, tension_matrices
from osm2xodr.geometry.heights.problem import (
    ProfileProblem,
    fast_spans,
    one_way_fast_ends,
    span_roads,
)
from osm2xodr.geometry.heights.records import Knots, only_curves, thin_records
from osm2xodr.geometry.heights.sparse import System
from osm2xodr.model import BoolArray, CubicProfile, FloatArray, IntArray, Rule, Structure, Surface

_GRAVITY: Final = 9.81


def designed_crossfall(network: Network) -> FloatArray:
    """Return the rise per metre to the left that roads are designed with, at samples, (n,); NaN where there is none.

    Carriageways of one direction fall to the side of slow traffic. In a bend of curvature k, at speed V, they fall to
    the inside where falling outwards would leave more than `ADVERSE_FRICTION` to the tyres, by e_max R_min |k|
    (method 1 of the Green Book, 3.3.5), R_min = V² / (g (e_max + f_max)), and at least by the least crossfall. Roads
    of both directions are crowned, which is level here, but for such bends.
    """
    problem, span = network.problem, network.elements.span[network.samples.element]
    slope = np.full(len(span), np.nan)
    row = np.flatnonzero(_designed_spans(problem)[span])
    if not len(row):
        return slope
    span, k = span[row], _mean_curvature(network, row)
    speed = _design_speed(problem)[span]
    asked = speed**2 * np.abs(k) / _GRAVITY
    adverse = asked > defaults.CROSSFALL_ADVERSE_FRICTION
    friction = np.interp(speed, defaults.SIDE_FRICTION_SPEEDS, defaults.SIDE_FRICTION)
    most = defaults.CROSSFALL_DESIGN_MAX
    demand = most * np.minimum(asked / (most + friction), 1.0)
    oneway = np.zeros(len(span)) if problem.span_oneway is None else problem.span_oneway[span]
    outward = defaults.CROSSFALL_LEAST * np.where(problem.rule is Rule.RIGHT_HAND, 1.0, -1.0) * oneway
    slope[row] = np.where(adverse, -np.sign(k) * np.maximum(demand, defaults.CROSSFALL_LEAST), outward)
    return slope


def _design_speed(problem: ProfileProblem) -> FloatArray:
    """Return the speed of each span, (K,), m/s: the limit up to what its class is designed for, 0 if for none."""
    given = np.full(len(problem.span_s), np.nan) if problem.span_speed is None else problem.span_speed
    fastest = np.array([defaults.DESIGN_SPEED.get(highway, 0.0) for highway in problem.span_highway])
    return np.fmin(given, fastest)


def _designed_spans(problem: ProfileProblem) -> BoolArray:
    """Return which spans have room for a cross slope between the junctions of their roads, (K,)."""
    fast = fast_spans(problem)
    if not fast.any():
        return fast
    return fast & _roads_with_room(problem)[span_roads(problem)]


def _roads_with_room(problem: ProfileProblem) -> BoolArray:
    """Return which roads, (R,), with those that continue them, are long enough to run off at each level end.

    Ends are level at junctions that no crossfall runs through: where one of its arms has no room, none does.
    """
    junction = problem.end_junction
    carried = np.zeros(len(problem.junction_xy), bool) if problem.carried is None else problem.carried.copy()
    chain = _chains(problem)
    total = np.bincount(chain, lengths(problem.plan_view))[chain]
    ends = (junction >= 0) | (problem.end_link < 0)
    while True:
        level = ends & ~((junction >= 0) & carried[junction]) if len(carried) else ends
        wanted = 0.5 * defaults.CROSSFALL_ROOM * np.bincount(chain, level.sum(axis=1))[chain]
        room: BoolArray = total >= wanted
        lost = junction[~room]
        lost = lost[lost >= 0]
        if not carried[lost].any():
            return room
        carried[lost] = False


def _chains(problem: ProfileProblem) -> IntArray:
    """Return the number of the chain of roads that continue one another that each road belongs to, (R,)."""
    link = np.where(problem.end_junction < 0, problem.end_link, -1)
    road, end = np.nonzero(link >= 0)
    return connected_groups(len(link), road, link[road, end] // 2)


def _mean_curvature(network: Network, row: IntArray) -> FloatArray:
    """Return the mean curvature of the reference line around some samples, 1/m, over `CROSSFALL_WINDOW` at most."""
    elements, samples = network.elements, network.samples
    road = elements.road[samples.element]
    hdg = np.unwrap(samples.hdg)
    # One axis for all roads, each behind the other.
    origin = np.concatenate([[0.0], np.cumsum(lengths(network.problem.plan_view) + 1.0)[:-1]])[road]
    first, last = (np.searchsorted(road, road[row], side=side) for side in ("left", "right"))
    half = 0.5 * defaults.CROSSFALL_WINDOW
    begin = np.maximum(samples.s[row] - half, samples.s[first])
    end = np.minimum(samples.s[row] + half, samples.s[last - 1])
    place = origin + samples.s
    turn = np.interp(origin[row] + end, place, hdg) - np.interp(origin[row] + begin, place, hdg)
    along = end - begin
    return np.divide(turn, along, out=np.zeros_like(turn), where=along > 0.0)


# ---------------------------------------------------------------- the cross slope

# Places across the carriageway that are read, and their distance from its edges, m.
_ACROSS: Final = 7
_EDGE: Final = 0.5
# Rounds in which readings that stand out lose weight, by Geman-McClure's loss.
_ROUNDS: Final = 4
# Tension as a share of what makes beam and tension equally stiff over the length of the beam: damps overshoots.
_TENSION_SHARE: Final = 0.1
# Keeps stretches without any reading determinate, as a share of a reading's weight.
_NO_READING: Final = 1e-6


def road_superelevation(
    network: Network, surface: Surface, choice: str, diagnostics: Diagnostics
) -> tuple[CubicProfile | None, FloatArray]:
    """Find the superelevation of motorways and trunk roads.

    Returns R curves, rad, continuous in value and slope along every road and across every link, with slope 0 at
    junctions, and their values at both ends, (R, 2): 0 at junctions, but where these are `carried`, and there the
    same for all arms, seen along their traffic. A road without superelevation has no records. No curves where
    `choice`, one of `SUPERELEVATION`, is to have none. The diagnostics receive a note if an elevation model alone is
    asked, and shows none, and a guess for each way that falls as it would be designed.
    """
    if choice == NO_SUPERELEVATION:
        return None, np.zeros(network.problem.end_junction.shape)
    problem, elements, samples = network.problem, network.elements, network.samples
    fast = fast_spans(problem)[elements.span]
    slope = np.full(len(samples.s), np.nan) if choice == MEASURED else designed_crossfall(network)
    designed = np.isfinite(slope)
    use = np.flatnonzero(fast[samples.element] & (elements.structure[samples.element] == Structure.GROUND))
    read, good = _read_across(network, use, surface)
    slope[use[good]] = read[good]
    designed[use[good]] = False
    seen = np.zeros(len(elements.h), bool)
    seen[samples.element[np.isfinite(slope)]] = True
    warranted = fast & (seen | (elements.structure != Structure.GROUND))
    warranted[_cut_elements(network)] = False
    use = np.flatnonzero(np.isfinite(slope))
    knots = np.zeros((len(elements.knot_s), 2))
    if len(use):
        knots = _smooth(network, use, slope[use], _free_knots(network, warranted))
    elif choice == MEASURED:
        cell = f"{defaults.CROSSFALL_CELL_MAX:.0f} m"
        diagnostics.note(
            "superelevation",
            "",
            f"no motorway or trunk road lies on an elevation model of the ground with cells of {cell} or less: no "
            "superelevation was written",
        )
    value = arctan2(np.clip(knots[:, 0], -defaults.CROSSFALL_MAX, defaults.CROSSFALL_MAX), 1.0)
    turn = np.where(np.abs(knots[:, 0]) <= defaults.CROSSFALL_MAX, knots[:, 1] * cosine(value) ** 2, 0.0)
    value, turn = np.round(value, defaults.RECORD_DECIMALS), np.round(turn, defaults.RECORD_SLOPE_DECIMALS)
    tilted = np.maximum.reduceat(np.abs(value), elements.knot_start[:-1]) > 0
    tolerance = defaults.CROSSFALL_TOLERANCE
    records = thin_records(Knots(elements.knot_start, elements.knot_s, value, turn), tolerance, tolerance)
    banked = tilted[elements.road[samples.element]] & designed & (slope != 0.0)
    for way in np.unique(problem.span_way[elements.span[samples.element[banked]]]).tolist():
        diagnostics.guessed("crossfall", f"way/{way}", "its crossfall is that of roads of its class and speed")
    return only_curves(records, tilted), value[elements.end_knots]


def _cut_elements(network: Network) -> IntArray:
    """Return the elements in which roads are cut at the border of an area."""
    pins = network.problem.pins
    if pins is None:
        return np.zeros(0, np.int64)
    return np.unique(network.place(pins.road, pins.s)[0])


def _read_across(network: Network, use: IntArray, surface: Surface) -> tuple[FloatArray, BoolArray]:
    """Return the rise per metre to the left at samples, and where it can be trusted, (n,).

    The median of the slopes between all pairs of places (Theil 1950, Sen 1968): up to a quarter of the places may
    be outliers.
    """
    problem, elements, samples = network.problem, network.elements, network.samples
    span = elements.span[samples.element[use]]
    width = problem.span_width[span] if problem.span_width is not None else np.zeros(len(span))
    middle = problem.span_middle[span] if problem.span_middle is not None else np.zeros(len(span))
    half = np.maximum(0.5 * width - _EDGE, defaults.CROSSFALL_HALF_WIDTH_MIN)
    t = middle[:, None] + half[:, None] * np.linspace(-1.0, 1.0, _ACROSS)
    x = samples.x[use, None] - sine(samples.hdg[use, None]) * t
    y = samples.y[use, None] + cosine(samples.hdg[use, None]) * t
    z, measured = surface.heights(x.ravel(), y.ravel())
    quality = surface.quality(samples.x[use], samples.y[use])
    z = z.reshape(t.shape)
    a, b = np.triu_indices(_ACROSS, 1)
    slope: FloatArray = np.median((z[:, b] - z[:, a]) / (t[:, b] - t[:, a]), axis=1) if len(use) else np.zeros(0)
    good = measured.reshape(t.shape).all(axis=1) & ~quality.covered
    # What has no cells is no model: it is level because nothing is known.
    good &= (
        (quality.cell_size > 0.0)
        & (quality.cell_size <= defaults.CROSSFALL_CELL_MAX)
        & (quality.sigma <= defaults.CROSSFALL_SIGMA_MAX)
    )
    return slope, good & (np.abs(slope) <= defaults.CROSSFALL_PLAUSIBLE)


def _free_knots(network: Network, warranted: BoolArray) -> sp.csr_matrix:
    """Return the matrix from unknowns to value and slope of every knot, (2 knots, N); other knots stay level."""
    problem, elements = network.problem, network.elements
    free = np.ones(len(elements.knot_s), bool)
    free[elements.knot[~warranted]] = free[elements.knot[~warranted] + 1] = False
    end = elements.end_knots.ravel()
    junction, link = problem.end_junction.ravel(), problem.end_link.ravel()
    carried, first = _carried_ends(problem, free[end])
    free[end[(junction >= 0) & ~carried]] = False
    linked = np.flatnonzero((junction < 0) & (link >= 0))
    free[end[linked]] &= free[end[link[linked]]]
    owner, sign = np.arange(len(free)), np.ones(len(free))
    second = linked[link[linked] < linked]
    owner[end[second]] = end[link[second]]
    # Where two starts or two ends touch, left of one is right of the other: value changes its sign, slope does not.
    sign[end[second]] = np.where((second - link[second]) % 2 == 0, -1.0, 1.0)
    # Seen along the traffic, all arms of a junction have one value, and slope 0.
    traffic = one_way_fast_ends(problem)
    owner[end[carried]], sign[end[carried]] = end[first], traffic[first] * traffic[carried]
    turns = np.ones(len(free))
    turns[end[carried]] = 0.0
    own = free & (owner == np.arange(len(free)))
    number = np.cumsum(own) - 1
    k = np.flatnonzero(free)
    rows, cols = (np.concatenate([2 * index, 2 * index + 1]) for index in (k, number[owner[k]]))
    values = np.concatenate([sign[k], turns[k]])
    return sp.coo_matrix((values, (rows, cols)), (2 * len(free), 2 * int(own.sum()))).tocsr()


def _carried_ends(problem: ProfileProblem, free: BoolArray) -> tuple[BoolArray, IntArray]:
    """Return which road ends, (2 R,), keep their crossfall at a junction, and for each of these its first such end.

    `free` (2 R,) are the ends that may have a crossfall: a junction has none unless all of its arms may.
    """
    junction = problem.end_junction.ravel()
    if problem.carried is None or not problem.carried.any():
        return np.zeros(len(junction), bool), np.zeros(0, np.int64)
    kept = problem.carried.copy()
    kept[junction[(junction >= 0) & ~free]] = False
    carried: BoolArray = (junction >= 0) & kept[junction]
    ends = np.flatnonzero(carried)
    _, at, number = np.unique(junction[ends], return_index=True, return_inverse=True)
    return carried, ends[at[number]]


def _smooth(network: Network, use: IntArray, slope: FloatArray, to_knots: sp.csr_matrix) -> FloatArray:
    """Return value and slope at all knots, (knots, 2), of a beam through the readings."""
    elements, samples = network.elements, network.samples
    if not to_knots.shape[1]:
        return np.zeros((len(elements.knot_s), 2))
    length = defaults.CROSSFALL_LENGTH
    area = length * length
    matrices = area * area * bending_matrices(elements.h) + _TENSION_SHARE * area * tension_matrices(elements.h)
    stiffness = to_knots.T @ assemble(elements, matrices) @ to_knots
    stiffness = stiffness + _NO_READING * sp.identity(stiffness.shape[0])
    rows = network.knot_rows(samples.element[use], samples.u[use], hermite) @ to_knots
    system = System([stiffness], [rows])
    system.put_in_order(rows)
    transposed, plain = rows.T.tocsr(), system.placed(stiffness)
    x, factor = np.zeros(to_knots.shape[1]), np.ones(len(use))
    for _ in range(_ROUNDS):
        weight = samples.ds[use] * factor
        x = system.solve(plain + system.normal(rows, transposed, weight), transposed @ (weight * slope))
        factor = 1.0 / (1.0 + ((slope - rows @ x) / defaults.CROSSFALL_SIGMA) ** 2) ** 2
    knots: FloatArray = (to_knots @ x[system.place]).reshape(-1, 2)
    return knots
