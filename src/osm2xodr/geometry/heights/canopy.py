"""Whether heights that stand out of a surface model stand on canopy and roofs after all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.solver import LEAST_FACTOR, Robust
from osm2xodr.model import BoolArray, FloatArray, IntArray


def bare_runs(road: IntArray, s: FloatArray, z: FloatArray, out: BoolArray) -> BoolArray:
    """Return which heights that stand out are those of the ground, (n,).

    What stands on the ground has walls: heights change abruptly at its edge, where it begins and ends along the road.
    A stretch of road that stands out as a whole without any is a hill that the road, made stiff to see through
    canopy and roofs, did not follow: the model is no surface model there.

    Parameters
    ----------
    road, s : (n,)
        Where the heights are, in the order of roads and along them.
    z : (n,)
        Heights, m.
    out : (n,)
        Which stand out.
    """
    n = len(road)
    if not n:
        return np.zeros(0, bool)
    same = road[1:] == road[:-1]
    rise, step = np.abs(np.diff(z)), np.maximum(np.diff(s), 1e-6)
    wall = same & (rise > defaults.WALL_HEIGHT) & (rise > defaults.WALL_SLOPE * step)
    begins = out & np.r_[True, ~(same & out[:-1])]
    run = np.cumsum(begins) - 1
    runs = int(begins.sum())
    walled = np.zeros(max(runs, 1), bool)
    # A wall between two heights is one of the run on either side of it.
    k = np.flatnonzero(wall)
    walled[run[k[out[k]]]] = True
    walled[run[k[out[k + 1]] + 1]] = True
    bare: BoolArray = out & ~walled[run]
    return bare


def keep_ground(
    robust: Robust, factors: FloatArray, covered: BoolArray, road: IntArray, s: FloatArray, z: FloatArray
) -> Robust:
    """Give what is the ground after all its weight back, and see that the ground keeps some from then on.

    Without that, the few heights of a short road that lie lowest can win over all others: nothing that is higher
    counts for much.

    Parameters
    ----------
    robust
        How observations lose weight.
    factors : (n,)
        What stiff roads left of the weights; weights that are given back are changed in place.
    covered : (n,)
        Which may stand on canopy or roofs.
    road, s, z : (m,)
        Road, place along it and height of the first m observations, in order; the others lie on no road.
    """
    out = covered[: len(z)] & (factors[: len(z)] < defaults.COVERED_OUT)
    factors[: len(z)][bare_runs(road, s, z, out)] = 1.0
    ground = covered & (factors >= defaults.COVERED_OUT)
    return replace(robust, least=np.where(ground, defaults.COVERED_LEAST, LEAST_FACTOR))
