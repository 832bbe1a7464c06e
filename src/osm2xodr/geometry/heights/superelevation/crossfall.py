"""Cross slope that fast roads are designed with, where no elevation model shows it.

Motorways and trunk roads fall to one side: to the outer edge of each carriageway where they are straight, to the
inside of bends that would otherwise throw cars out, and the more the sharper the bend is for the speed.
"""

from __future__ import annotations

from typing import Final

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from osm2xodr.curves import lengths
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.elements import Network
from osm2xodr.geometry.heights.problem import ProfileProblem, fast_spans, span_roads
from osm2xodr.model import BoolArray, FloatArray, IntArray, Rule

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
    count = len(link)
    # Older versions of SciPy want these integers.
    pairs = road.astype(np.int32), (link[road, end] // 2).astype(np.int32)
    graph = sp.coo_array((np.ones(len(road), np.int8), pairs), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], np.int64)


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
