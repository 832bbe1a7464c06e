"""The elevation model read where the roads are, and how far it can be trusted, place by place."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Final

import numpy as np

from osm2xodr.curves import (
    PointTree,
    cosine,
    hypot,
    lengths,
    pose,
    ranks,
    sine,
)
from osm2xodr.defaults import GUESS_LENGTH, GUESS_SIGMA
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.elements import Samples
from osm2xodr.geometry.heights.ground import Ground, cell_class, complete_ground, is_coarse, read_ground
from osm2xodr.geometry.heights.problem import ProfileProblem
from osm2xodr.model import BoolArray, FloatArray, IntArray, Surface
from osm2xodr.system import record

# Distance of the places at which a road's cell size is looked up, m: below the ramp that blends elevation models.
_LOOK_UP: Final = 50.0
# Least distance to the side over which the slope across a road is read, m; half a cell where that is more.
_LATERAL: Final = 2.0


def noise_length(cell: FloatArray) -> FloatArray:
    """Return the length over which an elevation model's errors are correlated, m."""
    return np.maximum(defaults.NOISE_LENGTH_MIN, defaults.NOISE_LENGTH_CELLS * cell)


@record(eq=False)
class Spacing:
    """How finely each road is cut, by the finest cells along it."""

    cell: FloatArray  # (R,) Smallest cell size along each road, m
    # (R,) Longest element, and distance between samples, m
    knots: FloatArray
    samples: FloatArray


def road_spacing(problem: ProfileProblem, surface: Surface) -> Spacing:
    """Return how finely each road is to be cut."""
    length = lengths(problem.plan_view)
    count = np.maximum(1, np.ceil(length / _LOOK_UP)).astype(np.int64)
    road = np.repeat(np.arange(len(length), dtype=np.int64), count)
    x, y, _ = pose(problem.plan_view, road, (ranks(count) + 0.5) * (length / count)[road])
    cell = np.full(len(length), np.inf)
    np.minimum.at(cell, road, surface.quality(x, y).cell_size)
    knots = np.full(len(cell), defaults.KNOT_SPACING[-1][1])
    for least, spacing in reversed(defaults.KNOT_SPACING):
        knots[cell >= least] = spacing
    samples = np.clip(cell / defaults.SAMPLES_PER_CELL, defaults.SAMPLE_SPACING_MIN, defaults.SAMPLE_SPACING_MAX)
    return Spacing(cell, knots, samples)


@record(eq=False)
class Reading:
    """The ground at places."""

    # (n,) Height to go by, and that of the surface itself, m
    z: FloatArray
    surface_z: FloatArray
    # (n,) Standard error of z and length over which it is correlated, m
    sigma: FloatArray
    correlation: FloatArray
    cell: FloatArray  # (n,) Cell size of the elevation model there, m
    measured: BoolArray  # (n,) Whether the surface has heights there
    covered: BoolArray  # (n,) Whether z may lie on canopy or roofs
    log_relief: FloatArray  # (n,) ln A of the ground's spectrum A / k⁴ around; NaN where it was not estimated
    away: FloatArray  # (n,) Distance from the nearest place of the network whose height is measured, m; 0 where it is
    across: FloatArray  # (n,) Rise of the ground per metre to the left of the road; 0 at junctions

    @property
    def density(self) -> FloatArray:
        """Weight per metre of road, 1/m³."""
        return 1.0 / (self.correlation * self.sigma**2)

    def part(self, index: slice) -> Reading:
        """Return the reading at some of the places."""
        return Reading(*(getattr(self, item.name)[index] for item in fields(self)))


def read_heights(
    surface: Surface, samples: Samples, junction_xy: FloatArray, ground: Ground
) -> tuple[Reading, Reading]:
    """Return the readings at the samples and at the junctions' origins (J, 2), m, from what was estimated so far.

    Where cells are coarse the ground estimated from them is read, elsewhere the surface itself. The standard error at
    the samples has a part for cuts and fills that cells do not show: how much the ground rises across the road over
    the distance by which it is cut into the slope.
    """
    n = len(samples.x)
    x, y = np.concatenate([samples.x, junction_xy[:, 0]]), np.concatenate([samples.y, junction_xy[:, 1]])
    surface_z, measured = surface.heights(x, y)
    quality = surface.quality(x, y)
    found = read_ground(complete_ground(ground, surface, quality, x, y), quality.cell_size, x, y)
    known, away = np.isfinite(found.z), _distance_from_measured(x, y, measured)
    sigma = np.where(known, np.minimum(found.sigma, defaults.GROUND_SIGMA_SHARE * quality.sigma), quality.sigma)
    correlation = np.maximum(noise_length(quality.cell_size), np.where(known, defaults.GROUND_LENGTH, 0.0))
    everywhere = Reading(
        np.where(known, found.z, surface_z),
        surface_z,
        np.where(measured, np.maximum(sigma, defaults.HEIGHT_SIGMA_MIN), _guess_sigma(away)),
        np.where(measured, correlation, GUESS_LENGTH),
        quality.cell_size,
        measured,
        quality.covered & ~is_coarse(quality.cell_size) & measured,
        np.where(measured, found.log_relief, np.nan),
        away,
        np.zeros(len(x)),
    )
    across = cosine(samples.hdg) * found.slope_y[:n] - sine(samples.hdg) * found.slope_x[:n]
    fine = np.flatnonzero(~known[:n])
    across[fine] = _slope_across(surface, samples, quality.cell_size[:n], fine)
    middle = everywhere.part(slice(n))
    off = np.minimum(defaults.POSITION_ERROR_CELLS * middle.cell, defaults.POSITION_ERROR_MAX)
    sigma = hypot(middle.sigma, across * off)
    return replace(middle, sigma=sigma, across=across), everywhere.part(slice(n, None))


def _distance_from_measured(x: FloatArray, y: FloatArray, measured: BoolArray) -> FloatArray:
    """Return how far places, (n,), m, are from the nearest one that is measured, m; infinite if none is."""
    away = np.where(measured, 0.0, np.inf)
    if measured.any() and not measured.all():
        places = np.column_stack([x, y])
        away[~measured] = PointTree(places[measured]).nearest(places[~measured])[0]
    return away


def _guess_sigma(away: FloatArray) -> FloatArray:
    """Return the standard error of heights so far away from all that is measured, (n,), m: it grows with it."""
    return GUESS_SIGMA * (1.0 + np.where(np.isfinite(away), away, 0.0) / defaults.UNKNOWN_FROM)


def _slope_across(surface: Surface, samples: Samples, cell: FloatArray, some: IntArray) -> FloatArray:
    """Return the rise of the surface per metre to the left at some of the samples, 0 where it is not known."""
    lateral = np.maximum(_LATERAL, 0.5 * cell[some])
    x, y, hdg = samples.x[some], samples.y[some], samples.hdg[some]
    nx, ny = -sine(hdg) * lateral, cosine(hdg) * lateral
    left, left_measured = surface.heights(x + nx, y + ny)
    right, right_measured = surface.heights(x - nx, y - ny)
    return np.where(left_measured & right_measured, (left - right) / (2 * lateral), 0.0)


def typical_ground(reading: Reading, cell: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the median weight per metre of road, 1/m³, and standard error, m, of heights where cells are as large.

    Cells of about these sizes, (n,), m.
    """
    measured = reading.measured if reading.measured.any() else np.ones(len(reading.z), bool)
    size, wanted = cell_class(reading.cell[measured]), cell_class(cell)
    out = []
    for value in (reading.density[measured], reading.sigma[measured]):
        of = np.full(len(cell), float(np.median(value)) if len(value) else 1.0)
        for one in np.unique(size).tolist():
            of[wanted == one] = float(np.median(value[size == one]))
        out.append(of)
    return out[0], out[1]
