"""Heights of elevation models below roads, and how far the roads are above or below them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.exporting import places_around, read_heights
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import Frame
from osm2xodr.surface import SurfaceOptions
from osm2xodr.viewing.options import ReportOptions
from osm2xodr.viewing.scene import Scene

# Points of the grid that shows the ground, which make the page 40 kB larger; and how far the grid extends beyond the
# roads at least, m, and as a share of their extent. Choices.
_GRID_POINTS: Final = 40_000
_LEAST_MARGIN: Final = 60.0
_MARGIN_SHARE: Final = 0.03


@dataclass(frozen=True, eq=False)
class Terrain:
    """The ground as a grid."""

    # South-western point, m
    x: float
    y: float
    # Spacing of columns and rows, m
    dx: float
    dy: float
    z: FloatArray  # (rows, columns) Heights, m, from south to north; NaN where nothing is measured


@dataclass(frozen=True)
class HeightErrors:
    """Height of some roads above the ground."""

    label: str  # Which roads
    length: float  # Length with known heights, m
    # m; p95 and largest are of the magnitude
    mean: float
    rms: float
    p95: float
    largest: float


def read_ground(
    about: ReportOptions, scene: Scene, frame: Frame, diagnostics: Diagnostics
) -> tuple[FloatArray, Terrain, Callable[[FloatArray, FloatArray], FloatArray]]:
    """Return the height of the ground at the stations, (stations,), m, NaN where it is not measured, and on a grid.

    Heights are those of the file: the header's offset is subtracted. Also returned is what gives them at other
    inertial x, y around the roads.

    Raises
    ------
    InputError
        An elevation model cannot be used.
    CoverageError
        No elevation model has heights at the roads.
    """
    columns, rows, corner, steps = _grid(scene)
    grid_x, grid_y = np.meshgrid(corner[0] + steps[0] * np.arange(columns), corner[1] + steps[1] * np.arange(rows))
    around = places_around(scene.x, scene.y)
    x = np.concatenate((around[0], grid_x.ravel()))
    y = np.concatenate((around[1], grid_y.ravel()))
    # Heights are shown as they are, with trees and roofs if the model has them.
    options = SurfaceOptions(
        dem_type="dtm", dem_crs=about.dem_crs, dem_unit=about.dem_unit, dem_encoding=about.dem_encoding
    )
    height, _ = read_heights(about.dem, frame, x, y, options, diagnostics)
    z = height(grid_x.ravel(), grid_y.ravel()).reshape(rows, columns)
    return height(scene.x, scene.y), Terrain(corner[0], corner[1], steps[0], steps[1], z), height


def _grid(scene: Scene) -> tuple[int, int, tuple[float, float], tuple[float, float]]:
    """Return columns, rows, south-western point and spacings (m) of a grid around the roads."""
    west, east = float(np.min(scene.x)), float(np.max(scene.x))
    south, north = float(np.min(scene.y)), float(np.max(scene.y))
    margin = max(_LEAST_MARGIN, _MARGIN_SHARE * max(east - west, north - south))
    width, height = east - west + 2.0 * margin, north - south + 2.0 * margin
    step = float(np.sqrt(width * height / _GRID_POINTS))
    columns, rows = max(2, int(width / step) + 1), max(2, int(height / step) + 1)
    return columns, rows, (west - margin, south - margin), (width / (columns - 1), height / (rows - 1))


def station_lengths(scene: Scene) -> FloatArray:
    """Return the length that each station stands for, (stations,), m: half of the distances to its neighbours."""
    gap = np.diff(scene.s)
    gap[np.diff(scene.station_strip) != 0] = 0.0
    out = np.zeros(len(scene.s))
    out[:-1] += 0.5 * gap
    out[1:] += 0.5 * gap
    return out


def height_errors(scene: Scene, groups: Sequence[tuple[str, BoolArray]]) -> list[HeightErrors]:
    """Summarise heights above the ground by groups of stations, each weighted by the length it stands for.

    Groups without a known height are left out.
    """
    heights, lengths = scene.z - scene.ground, station_lengths(scene)
    out = []
    for label, rows in groups:
        kept = rows & np.isfinite(heights) & (lengths > 0.0)
        if not kept.any():
            continue
        error, weight = heights[kept], lengths[kept]
        size = np.abs(error)
        order = np.argsort(size, kind="stable")
        reached = np.searchsorted(np.cumsum(weight[order]), 0.95 * weight.sum())
        mean, square = (float(np.average(values, weights=weight)) for values in (error, error**2))
        p95 = float(size[order][min(int(reached), len(order) - 1)])
        out.append(HeightErrors(label, float(weight.sum()), mean, math.sqrt(square), p95, float(size.max())))
    return out


def worst_stations(value: FloatArray, scene: Scene, rows: BoolArray, most: int) -> IntArray:
    """Return the station with the largest magnitude on each road, the largest first, at most `most`."""
    at = np.flatnonzero(rows & np.isfinite(value))
    road = scene.station_road[at]
    order = np.lexsort((at, -np.abs(value[at]), road))
    first = np.diff(road[order], prepend=-1) != 0
    best = at[order][first]
    return np.asarray(best[np.lexsort((best, -np.abs(value[best])))][:most])
