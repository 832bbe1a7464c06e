"""A survey of elevation models: their properties, and how well heights between their cells are found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from pyproj import Transformer

from osm2xodr.defaults import LATITUDE_MAX_DEG
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import CoverageError, InputError
from osm2xodr.projection import WGS84, make_frame, transformer_from, transformer_to
from osm2xodr.surface.comparison import GridComparison, Patch, compare_grid
from osm2xodr.surface.grids import (
    DemSource,
    GridFrame,
    Unstated,
    describe_dem,
    estimate_sigma,
    looks_covered,
    quantum_of,
    rasters_in,
    read_heights,
    unstated,
)
from osm2xodr.surface.mosaic import void_outliers

Box = tuple[float, float, float, float]

# Number of cells that interpolations are compared on, which takes a few seconds; of larger models, as many patches in
# either direction are taken, evenly spread. With fewer cells in a row than the last nothing is compared.
_CELLS_MAX: Final = 2**19
_PATCHES: Final = 3
_CELLS_IN_ROW_MIN: Final = 12
# Points in either direction of a box that are projected to find its cells.
_BOX_POINTS: Final = 21


@dataclass(frozen=True, slots=True, eq=False)
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


@dataclass(frozen=True, slots=True, eq=False)
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
