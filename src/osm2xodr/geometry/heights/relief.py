"""How much more roads bend than usual: where the land around bends, and where they turn on a slope."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import exp, lengths, log, pose, wrapped
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.elements import Network
from osm2xodr.geometry.heights.readings import Reading
from osm2xodr.model import BoolArray, FloatArray, Structure

# Distance between the three heights whose second difference shows the ground's curvature, m: several cells of fine
# models, and less than a hill.
_LAG: Final = 30.0
# The grade of the ground is taken over this length, m: streets follow no shorter one. A choice.
_GRADE_WINDOW: Final = 50.0
# Shorter windows count as this long, m: keeps quotients finite.
_SHORTEST: Final = 1.0
# Curvature is averaged over squares of this size, m, with at least so many places. Choices: a quarter of a town.
_SQUARE: Final = 400.0
_FEWEST: Final = 20
# Median of the square of a normal deviate: averages must not follow walls.
_MEDIAN_SQUARE: Final = 0.4549


def road_flexibility(network: Network, reading: Reading, usual: FloatArray) -> FloatArray:
    """Return the flexibility of roads, (E,), 1/m, from that of their class on plains, `usual`, (E,), 1/m.

    Relief multiplies it. On ground that rises across the road by m, a bend of curvature k has the vertical curvature
    m k, which is no bend of the ground.
    """
    elements, at = network.elements, network.samples.element
    plan_view = network.problem.plan_view
    begin, end = (pose(plan_view, elements.road, s)[2] for s in (elements.s, elements.s + elements.h))
    curvature = wrapped(end - begin) / elements.h
    count = np.maximum(np.bincount(at, minlength=len(elements.h)), 1)
    across = np.bincount(at, reading.across, len(elements.h)) / count
    return np.asarray(usual * _relief_factor(network, reading) + (across * curvature) ** 2 * elements.h)


def estimated_elements(network: Network, reading: Reading) -> BoolArray:
    """Return the elements whose ground was estimated from coarse cells, (E,)."""
    known = network.samples.element[np.isfinite(reading.log_relief)]
    return np.asarray(np.bincount(known, minlength=len(network.elements.h)) > 0)


def ground_grades(network: Network, reading: Reading) -> FloatArray:
    """Return the size of the grade of bare ground along each element, over `_GRADE_WINDOW` at most, (E,).

    0 on structures, and where the ground is not measured.
    """
    elements, samples = network.elements, network.samples
    if not len(samples.s):
        return np.zeros(len(elements.h))
    place, road = _one_axis(network), elements.road[samples.element]
    first, last = (np.searchsorted(road, road, side=side) for side in ("left", "right"))
    begin = np.maximum(samples.s - 0.5 * _GRADE_WINDOW, samples.s[first])
    end = np.minimum(samples.s + 0.5 * _GRADE_WINDOW, samples.s[last - 1])
    rise = (np.interp(place - samples.s + s, place, reading.z) for s in (end, begin))
    grade = np.abs(next(rise) - next(rise)) / np.maximum(end - begin, _SHORTEST)
    bare = reading.measured & ~reading.covered & (elements.structure[samples.element] == Structure.GROUND)
    out = np.zeros(len(elements.h))
    np.maximum.at(out, samples.element[bare], grade[bare])
    return out


def _one_axis(network: Network) -> FloatArray:
    """Return the places of samples along an axis on which roads follow each other, (n,), m."""
    length = lengths(network.problem.plan_view)
    origin = np.cumsum(length + 1.0) - length
    return np.asarray(origin[network.elements.road[network.samples.element]] + network.samples.s)


def _relief_factor(network: Network, reading: Reading) -> FloatArray:
    """Return the factor on the flexibility of elements that the relief around calls for, 1 at least, (E,)."""
    at, elements = network.samples.element, len(network.elements.h)
    # Along a line through relief of spectrum A / k⁴ curvature has the density A k / 4.
    log_density = reading.log_relief + log(defaults.RELIEF_WAVE / 4.0)
    log_density = np.where(np.isfinite(log_density), log_density, _log_curvature(network, reading))
    known = np.isfinite(log_density)
    count = np.bincount(at[known], minlength=elements)
    mean = np.bincount(at[known], log_density[known], elements) / np.maximum(count, 1)
    quotient = np.where(count > 0, mean - log(defaults.ROAD_FLEXIBILITY), 0.0)
    return np.asarray(exp(defaults.RELIEF_SHARE * np.maximum(quotient, 0.0)))


def _log_curvature(network: Network, reading: Reading) -> FloatArray:
    """Return the logarithm of the density of the ground's curvature along roads, 1/m, around samples, (n,).

    NaN where too little bare ground is measured. White curvature of density q gives second differences over a
    distance L the variance 2/3 q L³, and errors of heights six times their own.
    """
    samples, road = network.samples, network.elements.road[network.samples.element]
    length = lengths(network.problem.plan_view)
    place = _one_axis(network)
    bare = reading.measured & ~reading.covered
    inside = (samples.s > _LAG) & (samples.s < length[road] - _LAG) & bare
    at = np.flatnonzero(inside)
    out = np.full(len(place), np.nan)
    if not len(at):
        return out
    z = [np.interp(place[at] + step, place, reading.z) for step in (-_LAG, 0.0, _LAG)]
    square = (z[0] - 2.0 * z[1] + z[2]) ** 2
    tile = np.floor(np.column_stack([samples.x, samples.y]) / _SQUARE).astype(np.int64)
    key = (tile[:, 0] - tile[:, 0].min()) * (np.ptp(tile[:, 1]) + 1) + tile[:, 1] - tile[:, 1].min()
    for one in np.unique(key[at]).tolist():
        here = key[at] == one
        if here.sum() < _FEWEST:
            continue
        variance = (
            float(np.median(square[here])) / _MEDIAN_SQUARE - 6.0 * float(np.median(reading.sigma[at][here])) ** 2
        )
        if variance > 0.0:
            out[key == one] = log(variance / (2.0 / 3.0 * (_LAG * _LAG * _LAG)))
    return out
