"""Roads end, and lanes change, beyond tight bends.

Readers that step along the reference line step too far on an outer lane of a tight bend. Inside a road that is a
matter of its shape, but at its ends and where its lanes change they lose their way.
"""

from __future__ import annotations

import numpy as np

from osm2xodr import defaults
from osm2xodr.geometry.curves import find_record
from osm2xodr.geometry.street_ends import StreetEnds
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

_PROBES = np.arange(0.0, 3.01, 0.25)
_SHIFTS = (0.0, *(sign * step for step in np.arange(2.0, 20.1, 2.0) for sign in (1.0, -1.0)))


def beyond_bends(ends: StreetEnds, junction: IntArray, trim: FloatArray) -> FloatArray:
    """Return trims moved outwards over bends in which lanes are much longer than the reference line, (ends,), m.

    Connecting roads run along the middle of their lane, so inside a junction a bend does no harm; on a road with
    lanes beside the reference line, readers that step along it step too far in the outer lane.

    Parameters
    ----------
    ends
        All street ends.
    junction : (ends,)
        -1 for ends in no junction, whose trims stay.
    trim : (ends,)
        m.
    """
    trim = trim.copy()
    candidates = np.flatnonzero(junction >= 0)
    for _ in range(3):
        bent, beyond = _first_bend(ends, candidates, trim[candidates])
        left = ends.length[candidates] - beyond - trim[candidates ^ 1]
        near = beyond - trim[candidates] < defaults.BEND_IN_JUNCTION
        move = bent & near & (left > defaults.SHORTEST_STREET_BETWEEN_JUNCTIONS)
        if not move.any():
            break
        # Both ends of a street must not move at once, lest they meet.
        twice = np.isin(candidates ^ 1, candidates[move]) & (candidates % 2 == 1)
        move &= ~twice
        trim[candidates[move]] = beyond[move]
        candidates = candidates[move | twice]
    return trim


def _first_bend(ends: StreetEnds, end: IntArray, trim: FloatArray) -> tuple[BoolArray, FloatArray]:
    """Say which ends lie at a tight bend, and at which distance from the node it is over."""
    plan = ends.plan_view
    aside = np.maximum(np.maximum(ends.left[end], -ends.right[end]) - defaults.HALF_LANE, 0.0)
    bent = np.zeros(len(end), bool)
    beyond = trim.copy()
    at_end = end % 2 == 1
    for probe in _PROBES:
        u = np.minimum(trim + probe, ends.length[end])
        s = np.where(at_end, ends.length[end] - u, u)
        k = find_record(plan.start, plan.s, end // 2, s)
        tight = np.abs(plan.curvature[k]) * aside > defaults.TIGHT_BEND
        over = np.where(at_end, ends.length[end] - plan.s[k], plan.s[k] + plan.length[k])
        beyond = np.where(tight, np.maximum(beyond, over), beyond)
        bent |= tight
    return bent, beyond


def out_of_bends(plan: PlanView, curve: IntArray, s: FloatArray, aside: FloatArray, length: FloatArray) -> FloatArray:
    """Return places moved along their curves, by as little as possible, to where no bend is tight, (n,), m.

    A place stays where there is no such place near enough.

    Parameters
    ----------
    plan, length
        Curves, and the length of each.
    curve, s
        Places.
    aside
        Distance of the outermost lane's middle from the reference line, m.
    """
    moved = s.copy()
    found = np.zeros(len(s), bool)
    for shift in _SHIFTS:
        at = s + shift
        fits = ~found & (at > _PROBES[-1]) & (at < length[curve] - _PROBES[-1])
        for probe in (*-_PROBES[:0:-1], *_PROBES):
            k = find_record(plan.start, plan.s, curve, at + probe)
            fits &= np.abs(plan.curvature[k]) * aside <= defaults.TIGHT_BEND
        moved = np.where(fits, at, moved)
        found |= fits
    return moved
