"""A survey of elevation models: their properties, and how well interpolations and polynomials predict heights.

Every other row and column of a grid is kept, and the cells between are predicted from them and compared with their
true heights. Cells are then twice as far apart as in the grid, so that errors are larger than those of a road; they
show which method is better, and by how much. Polynomials have far fewer terms than there are cells and are compared
with the very heights that they are fitted to.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from pyproj import Transformer

from osm2xodr.defaults import LATITUDE_MAX_DEG
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import CoverageError, InputError
from osm2xodr.model import FloatArray
from osm2xodr.projection import WGS84, make_frame, transformer_from, transformer_to
from osm2xodr.surface.grids import (
    Cells,
    DemSource,
    GridFrame,
    Unstated,
    all_corners,
    describe_dem,
    estimate_sigma,
    fill_voids,
    fit_polynomial,
    looks_covered,
    make_interpolator,
    quantum_of,
    rasters_in,
    read_heights,
    term_count,
    unstated,
)
from osm2xodr.surface.mosaic import void_outliers
from osm2xodr.system import record

Box = tuple[float, float, float, float]

# Number of cells that interpolations are compared on, which takes a few seconds; of larger models, as many patches in
# either direction are taken, evenly spread. With fewer cells in a row than the last nothing is compared.
_CELLS_MAX: Final = 2**19
_PATCHES: Final = 3
_CELLS_IN_ROW_MIN: Final = 12
# Points in either direction of a box that are projected to find its cells.
_BOX_POINTS: Final = 21

_INTERPOLATIONS: Final = ("nearest", "bilinear", "bicubic")
_ORDERS: Final = (2, 3, 4, 5)  # Total degrees of polynomials


@record(eq=False)
class DemComparison:
    """An elevation model, and the errors of methods to find its heights."""

    # As in the file; `crs` is the name
    path: Path
    driver: str
    crs: str
    dtype: str
    unit: str
    cell_size: float  # Geometric mean of the lengths of a column and a row, m
    size: tuple[int, int]  # Columns and rows of the whole model, or of the part within the box
    # Number of cells that were read, of those without a height, and of removed outliers among these
    cells: int
    voids: int
    outliers: int
    sigma: float  # Estimated standard error of heights, m
    covered: bool  # Whether it is taken for a surface model (canopy and roofs)
    grid: GridComparison


@record(eq=False)
class SurfaceComparison:
    """Comparisons of methods on a user's elevation models."""

    box_deg: Box | None  # West, south, east, north of the box asked for, degrees, WGS 84; None for whole models
    models: tuple[DemComparison, ...]  # In the order given


def compare_surfaces(
    paths: Sequence[Path],
    bbox: Box | None,
    diagnostics: Diagnostics,
    *,
    dem_crs: str | None = None,
    dem_unit: str | None = None,
    dem_encoding: str | None = None,
) -> SurfaceComparison:
    """Compare interpolations and polynomials on elevation models: local raster files, one or more.

    `bbox` is west, south, east, north, degrees, WGS 84; None for the whole of each. `dem_crs`, `dem_unit` and
    `dem_encoding` hold for models that do not say theirs, as in `SurfaceOptions`. Of large parts, evenly spread
    patches are taken. Diagnostics get what is guessed or repaired.

    Raises
    ------
    InputError
        A file is missing, damaged or no elevation model; the box is not valid; there are too few cells.
    CoverageError
        A model has no heights in the box.
    """
    if not paths:
        raise InputError("no elevation model was given; name at least one file")
    if bbox is not None:
        west, south, east, north = bbox
        if not (-360.0 <= west < east <= 360.0 and -90.0 <= south < north <= 90.0 and east - west <= 360.0):
            remedy = "give west, south, east, north in degrees, the smaller ones first"
            raise InputError(f"{west:g},{south:g},{east:g},{north:g} is not a box; {remedy}")
    known = unstated(dem_crs, dem_unit, dem_encoding)
    rasters = [raster for path in paths for raster in rasters_in(path)]
    return SurfaceComparison(bbox, tuple(_compare(path, known, bbox, diagnostics) for path in rasters))


def _compare(path: Path, known: Unstated, box: Box | None, diagnostics: Diagnostics) -> DemComparison:
    """Compare methods on one elevation model."""
    source = describe_dem(path, diagnostics, known)
    first_col, first_row, cols, rows = _window(source, box)
    if min(cols, rows) < _CELLS_IN_ROW_MIN:
        remedy = "give a larger elevation model or --bbox"
        raise InputError(f"{path}: {cols} x {rows} cells are too few to compare anything; {remedy}")
    frame = _frame(source, first_col, first_row, cols, rows)
    patches, outliers = _patches(source, frame, first_col, first_row, diagnostics)
    z = max((patch.z for patch in patches), key=lambda part: int(np.isfinite(part).sum()))
    if not np.isfinite(z).any():
        raise CoverageError(f"{path}: there are no heights to compare, all is nodata; give another part with --bbox")
    return DemComparison(
        path,
        source.driver,
        source.crs.name,
        source.dtype,
        source.unit,
        frame.cell_size(),
        (cols, rows),
        sum(patch.z.size for patch in patches),
        sum(int(np.isnan(patch.z).sum()) for patch in patches),
        outliers,
        estimate_sigma(z, frame.steps(), quantum_of(z, source.quantum)),
        looks_covered(z, frame.steps()) if source.covered is None else source.covered,
        compare_grid([_upright(item, frame) for item in patches if np.isfinite(item.z).any()], frame.steps()),
    )


def _window(source: DemSource, box: Box | None) -> tuple[int, int, int, int]:
    """Return the first column and row and the number of columns and rows of the part within a box."""
    if box is None:
        return 0, 0, source.cols, source.rows
    west, south, east, north = box
    t = np.linspace(0.0, 1.0, _BOX_POINTS)
    lon, lat = (place.reshape(-1) for place in np.meshgrid(west + (east - west) * t, south + (north - south) * t))
    col, row = source.frame(Transformer.from_crs(WGS84, source.crs, always_xy=True)).cells(lon, lat)
    inside = np.isfinite(col) & np.isfinite(row)
    low = np.array([np.min(place[inside], initial=np.inf) for place in (col, row)])
    high = np.array([np.max(place[inside], initial=-np.inf) for place in (col, row)])
    size = np.array([source.cols, source.rows])
    if not (np.all(high >= 0) and np.all(low <= size - 1)):
        asked = f"{west:g},{south:g},{east:g},{north:g}; give another --bbox"
        raise CoverageError(f"{source.path}: the elevation model does not reach into the box {asked}")
    first = np.maximum(np.floor(low), 0).astype(np.int64)
    last = np.minimum(np.ceil(high), size - 1).astype(np.int64)
    return int(first[0]), int(first[1]), int(last[0] - first[0]) + 1, int(last[1] - first[1]) + 1


def _frame(source: DemSource, first_col: int, first_row: int, cols: int, rows: int) -> GridFrame:
    """Return the frame of a window, with local positions around its middle."""
    a, b, c, d, e, f = source.affine
    u, v = first_col + 0.5 * cols, first_row + 0.5 * rows
    lon, lat = transformer_from(source.crs).transform(a * u + b * v + c, d * u + e * v + f)
    local = make_frame(float(np.clip(lat, -LATITUDE_MAX_DEG, LATITUDE_MAX_DEG)), float(lon))
    return source.frame(transformer_to(local, source.crs)).window(first_col, first_row, cols, rows)


def _patches(
    source: DemSource, frame: GridFrame, first_col: int, first_row: int, diagnostics: Diagnostics
) -> tuple[list[Patch], int]:
    """Read a small window as a whole, patches of a large one; return them and the number of outliers."""
    cols, rows, times = frame.cols, frame.rows, 1
    if cols * rows > _CELLS_MAX:
        times = _PATCHES
        side = int(np.sqrt(_CELLS_MAX)) // times
        # Patches of a long strip are longer, with the same number of cells.
        cols = min(frame.cols // times, max(side, side**2 // frame.rows))
        rows = min(frame.rows // times, side**2 // cols)
    patches, outliers = [], 0
    for row in _starts(frame.rows, rows, times):
        for col in _starts(frame.cols, cols, times):
            part = frame.window(col, row, cols, rows)
            z = read_heights(source, part, first_col + col, first_row + row, 1, False, diagnostics)
            outliers += void_outliers(source, part, z, 1, diagnostics)
            patches.append(Patch(col, row, z))
    return patches, outliers


def _starts(size: int, part: int, times: int) -> list[int]:
    """Return the starts of parts that are spread evenly over a size."""
    return [k * part + (2 * k + 1) * (size - part * times) // (2 * times) for k in range(times)]


def _upright(patch: Patch, frame: GridFrame) -> Patch:
    """Return a patch with its northernmost row first and its westernmost column first."""
    a, _, _, _, e, _ = frame.affine
    rows, cols = patch.z.shape
    across, down = -1 if a < 0.0 else 1, -1 if e > 0.0 else 1
    return Patch(
        frame.cols - patch.first_col - cols if across < 0 else patch.first_col,
        frame.rows - patch.first_row - rows if down < 0 else patch.first_row,
        patch.z[::down, ::across].copy(),
    )


@record(eq=False)
class Patch:
    """A part of a grid of heights."""

    # Its first cell in the grid
    first_col: int
    first_row: int
    z: Cells  # (rows, cols) Heights, m; NaN in voids


@record(eq=False)
class MethodResult:
    """The errors of one method to find heights."""

    name: str  # The interpolation, or the order of the polynomial
    count: int  # Number of cells that were predicted
    # Mean, root mean square, 95th percentile and maximum of the errors (the last two of their magnitude), predicted
    # minus true, m
    bias: float
    rms: float
    p95: float
    maximum: float
    grade_rms: float  # Root mean square of the error of the grade from cell to cell, rise per metre
    seconds: float  # Computing time
    errors: tuple[FloatArray, ...]  # (rows, cols) of each patch, m; NaN where nothing was predicted


@record(eq=False)
class GridComparison:
    """The errors of all methods on one grid."""

    patches: tuple[Patch, ...]
    steps: tuple[float, float]  # Length of one column and of one row, m
    # Polynomials of high order are left out where there are too few cells
    interpolations: tuple[MethodResult, ...]
    polynomials: tuple[MethodResult, ...]


def compare_grid(patches: Sequence[Patch], steps: tuple[float, float]) -> GridComparison:
    """Compare interpolations and polynomials on patches of one grid.

    There is at least one patch, each with three or more rows and columns and some heights; `steps` are the lengths of
    one column and of one row, m.
    """
    heights = sum(int(np.count_nonzero(np.isfinite(patch.z))) for patch in patches)
    return GridComparison(
        tuple(patches),
        steps,
        tuple(_leave_out(method, patches, steps) for method in _INTERPOLATIONS),
        tuple(_fit(order, patches, steps) for order in _ORDERS if heights >= 2 * term_count(order)),
    )


def _leave_out(method: str, patches: Sequence[Patch], steps: tuple[float, float]) -> MethodResult:
    """Predict the cells between every other row and column."""
    errors, seconds = [], 0.0
    for patch in patches:
        kept = np.ascontiguousarray(patch.z[::2, ::2])
        known = np.isfinite(kept)
        error = np.full(patch.z.shape, np.nan)
        errors.append(error)
        if not known.any():
            continue
        below = partial(_level, float(np.mean(kept[known])))
        filled = fill_voids(kept, below, (2.0 * steps[0], 2.0 * steps[1]), np.inf)
        # Cells beyond the last row and column kept are not predicted.
        rows, cols = 2 * kept.shape[0] - 1, 2 * kept.shape[1] - 1
        row, col = (place.reshape(-1) for place in np.mgrid[:rows, :cols])
        between = (row % 2 == 1) | (col % 2 == 1)
        at_row, at_col = 0.5 * row[between], 0.5 * col[between]
        began = time.perf_counter()
        predicted = make_interpolator(filled, method)(at_col, at_row)
        seconds += time.perf_counter() - began
        fair = all_corners(known, at_col, at_row)
        target = row[between][fair], col[between][fair]
        error[target] = predicted[fair] - patch.z[target]
    return _result(method, patches, errors, seconds, steps)


def _level(height: float, col: FloatArray, row: FloatArray) -> FloatArray:
    """Return one height at all positions."""
    return np.full(len(col), height)


def _fit(order: int, patches: Sequence[Patch], steps: tuple[float, float]) -> MethodResult:
    """Fit a polynomial to all patches."""
    parts = []
    for patch in patches:
        row, col = np.nonzero(np.isfinite(patch.z))
        x, y = (col + patch.first_col) * steps[0], (row + patch.first_row) * steps[1]
        parts.append((x, y, patch.z[row, col].astype(np.float64)))
    x, y, z = (np.concatenate(values) for values in zip(*parts, strict=True))
    began = time.perf_counter()
    trend = fit_polynomial(x, y, z, order)
    seconds = time.perf_counter() - began
    errors = []
    for patch in patches:
        rows, cols = patch.z.shape
        at_x = (np.arange(cols) + patch.first_col) * steps[0]
        at_y = (np.arange(rows) + patch.first_row) * steps[1]
        errors.append(trend.on_grid(at_x, at_y) - patch.z)
    return _result(str(order), patches, errors, seconds, steps)


def _result(
    name: str, patches: Sequence[Patch], errors: Sequence[FloatArray], seconds: float, steps: tuple[float, float]
) -> MethodResult:
    """Summarise errors (rows, cols) of each patch."""
    every = np.concatenate([error[np.isfinite(error)] for error in errors])
    grades = []
    for patch, error in zip(patches, errors, strict=True):
        # Cells that were not predicted have no error, unless they are voids.
        known = np.isfinite(patch.z)
        full = np.where(np.isfinite(error) | ~known, error, 0.0)
        for axis, step in ((1, steps[0]), (0, steps[1])):
            grade = np.diff(full, axis=axis) / step
            grades.append(grade[np.isfinite(grade)])
    size = np.abs(every)
    return MethodResult(
        name,
        len(every),
        float(np.mean(every)) if len(every) else 0.0,
        _rms(every),
        float(np.percentile(size, 95.0)) if len(every) else 0.0,
        float(size.max()) if len(every) else 0.0,
        _rms(np.concatenate(grades)),
        seconds,
        tuple(errors),
    )


def _rms(values: FloatArray) -> float:
    """Return the root mean square, 0 of no values."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0
