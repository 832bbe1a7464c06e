"""What the elevation model says where the roads are, and how far it can be trusted, place by place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from osm2xodr import defaults
from osm2xodr.geometry.curves import lengths, pose
from osm2xodr.geometry.ground_trend import read_ground
from osm2xodr.geometry.profile_problem import ProfileProblem
from osm2xodr.geometry.profile_system import Samples
from osm2xodr.model import BoolArray, FloatArray, IntArray, Surface

# Cell sizes within this share of each other are one, as those of the rows of a geographic grid are.
_SAME_CELL = 0.1
# Distance of the places at which a road's cell size is looked up, m: below the ramp that blends elevation models.
_LOOK_UP = 50.0


def noise_length(cell: FloatArray) -> FloatArray:
    """Return the length over which an elevation model's errors are correlated, m."""
    return np.maximum(defaults.NOISE_LENGTH_MIN, defaults.NOISE_LENGTH_CELLS * cell)


def is_coarse(cell: FloatArray) -> BoolArray:
    """Return where the ground has to be estimated from the cells around a road."""
    return np.asarray(cell >= defaults.COARSE_CELL)


@dataclass(frozen=True, slots=True, eq=False)
class Spacing:
    """How finely each road is cut, by the finest cells along it.

    Parameters
    ----------
    cell : (R,)
        Smallest cell size along each road, m.
    knots, samples : (R,)
        Longest element, and distance between samples, m.
    """

    cell: FloatArray
    knots: FloatArray
    samples: FloatArray


def road_spacing(problem: ProfileProblem, surface: Surface) -> Spacing:
    """Return how finely each road is to be cut."""
    length = lengths(problem.plan_view)
    count = np.maximum(1, np.ceil(length / _LOOK_UP)).astype(np.int64)
    start = np.cumsum(count) - count
    road = np.repeat(np.arange(len(length), dtype=np.int64), count)
    s = (np.arange(len(road)) - start[road] + 0.5) * (length / count)[road]
    x, y, _ = pose(problem.plan_view, road, s)
    cells = surface.quality(x, y).cell_size
    cell: FloatArray = np.minimum.reduceat(cells, start) if len(start) else np.zeros(0)
    knots = np.full(len(cell), defaults.KNOT_SPACING[-1][1])
    for least, spacing in reversed(defaults.KNOT_SPACING):
        knots[cell >= least] = spacing
    samples = np.clip(cell / defaults.SAMPLES_PER_CELL, defaults.SAMPLE_SPACING_MIN, defaults.SAMPLE_SPACING_MAX)
    return Spacing(cell, knots, samples)


@dataclass(frozen=True, slots=True, eq=False)
class Reading:
    """The ground at places.

    Parameters
    ----------
    z, surface_z : (n,)
        Height to go by, and what the surface itself says, m.
    sigma, correlation : (n,)
        Standard error of z and length over which it is correlated, m.
    cell : (n,)
        Cell size of the elevation model there, m.
    measured : (n,)
        Whether the surface has heights there.
    covered : (n,)
        Whether z may lie on canopy or roofs.
    """

    z: FloatArray
    surface_z: FloatArray
    sigma: FloatArray
    correlation: FloatArray
    cell: FloatArray
    measured: BoolArray
    covered: BoolArray

    @property
    def density(self) -> FloatArray:
        """Weight per metre of road, 1/m³."""
        return 1.0 / (self.correlation * self.sigma**2)

    def part(self, index: slice) -> Reading:
        """Return the reading at some of the places."""
        return Reading(
            self.z[index],
            self.surface_z[index],
            self.sigma[index],
            self.correlation[index],
            self.cell[index],
            self.measured[index],
            self.covered[index],
        )


def _read(surface: Surface, x: FloatArray, y: FloatArray, smoothing: float) -> Reading:
    """Read the surface, or the ground estimated from it where its cells are coarse."""
    surface_z, measured = surface.heights(x, y)
    quality = surface.quality(x, y)
    z = surface_z.copy()
    sigma = np.maximum(quality.sigma, defaults.HEIGHT_SIGMA_MIN)
    correlation = noise_length(quality.cell_size)
    covered = quality.covered & ~is_coarse(quality.cell_size)
    size = _cell_class(quality.cell_size)
    for one in np.unique(size[is_coarse(quality.cell_size)]).tolist():
        here = np.flatnonzero(is_coarse(quality.cell_size) & (size == one))
        cell, noise = float(np.median(quality.cell_size[here])), float(np.median(sigma[here]))
        ground = read_ground(surface, x[here], y[here], cell, noise, smoothing)
        known = np.isfinite(ground.z)
        here = here[known]
        z[here] = ground.z[known]
        sigma[here] = np.maximum(ground.sigma[known], defaults.HEIGHT_SIGMA_MIN)
        correlation[here] = np.maximum(ground.correlation[known], correlation[here])
    return Reading(
        z,
        surface_z,
        np.where(measured, sigma, defaults.GUESS_SIGMA),
        np.where(measured, correlation, defaults.GUESS_LENGTH),
        quality.cell_size,
        measured,
        covered & measured,
    )


def read_heights(
    surface: Surface, samples: Samples, junction_xy: FloatArray, smoothing: float
) -> tuple[Reading, Reading]:
    """Read the ground at the samples and at the junctions' origins.

    The standard error at the samples has a part for the road's position: what the ground rises across the road
    over that distance.

    Parameters
    ----------
    surface
        Height of the ground, and how far it can be trusted.
    samples
        Where it is read.
    junction_xy : (J, 2)
        Origins of the junctions, m.
    smoothing
        Factor on the penalty on the ground's roughness.
    """
    cell = surface.quality(samples.x, samples.y).cell_size
    aside = np.maximum(2.0, 0.5 * cell)
    nx, ny = -np.sin(samples.hdg) * aside, np.cos(samples.hdg) * aside
    n = len(samples.x)
    x = np.concatenate([samples.x, samples.x + nx, samples.x - nx, junction_xy[:, 0]])
    y = np.concatenate([samples.y, samples.y + ny, samples.y - ny, junction_xy[:, 1]])
    everywhere = _read(surface, x, y, smoothing)
    middle, left, right = (everywhere.part(slice(k * n, (k + 1) * n)) for k in range(3))
    slope = np.where(left.measured & right.measured, (left.z - right.z) / (2 * aside), 0.0)
    sigma = np.hypot(middle.sigma, slope * (defaults.POSITION_ERROR + defaults.POSITION_ERROR_CELLS * cell))
    reading = Reading(
        middle.z, middle.surface_z, sigma, middle.correlation, middle.cell, middle.measured, middle.covered
    )
    return reading, everywhere.part(slice(3 * n, None))


def _cell_class(cell: FloatArray) -> IntArray:
    """Return equal numbers for cell sizes that are about the same."""
    out: IntArray = np.round(np.log(np.maximum(cell, 1e-3)) / _SAME_CELL).astype(np.int64)
    return out


def typical_density(reading: Reading, cell: FloatArray) -> FloatArray:
    """Return the weight per metre of road that is usual at places with cells of these sizes, (n,), 1/m³."""
    measured = reading.measured if reading.measured.any() else np.ones(len(reading.z), bool)
    density, size = reading.density[measured], _cell_class(reading.cell[measured])
    wanted = _cell_class(cell)
    out = np.full(len(cell), float(np.median(density)) if len(density) else 1.0)
    for one in np.unique(size).tolist():
        out[wanted == one] = float(np.median(density[size == one]))
    return out
