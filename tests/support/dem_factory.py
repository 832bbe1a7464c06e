"""Small elevation models with known heights."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import rasterio
from affine import Affine
from pyproj import Transformer

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import FloatArray, LocalFrame
from osm2xodr.projection import make_frame
from osm2xodr.surface import DemSurface, SurfaceOptions, read_surface

Height = Callable[[FloatArray, FloatArray], FloatArray]

BAVARIA = make_frame(49.5, 11.5)
MALTA = make_frame(35.9, 14.5)
OREGON = make_frame(45.5, -122.7)


def in_crs(frame: LocalFrame, crs: Any, x: npt.ArrayLike, y: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Convert local x, y to a CRS via longitude and latitude."""
    lon, lat = Transformer.from_crs(frame.proj, 4326, always_xy=True).transform(x, y)
    px, py = Transformer.from_crs(4326, crs, always_xy=True).transform(lon, lat)
    return np.asarray(px, np.float64), np.asarray(py, np.float64)


def place(transform: Affine, col: FloatArray, row: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return x, y in the raster's CRS at fractional cells, counted from the centre of the first."""
    u, v = col + 0.5, row + 0.5
    return transform.a * u + transform.b * v + transform.c, transform.d * u + transform.e * v + transform.f


def centres(transform: Affine, rows: int, cols: int) -> tuple[FloatArray, FloatArray]:
    """Return x, y of all cell centres in the raster's CRS, (rows, cols)."""
    col, row = np.meshgrid(np.arange(cols, dtype=np.float64), np.arange(rows, dtype=np.float64))
    return place(transform, col, row)


def moved(transform: Affine, x: float, y: float) -> Affine:
    """Return a transform moved by x, y of its CRS."""
    a, b, c, d, e, f = tuple(transform)[:6]
    return Affine(a, b, c + x, d, e, f + y)


def to_local(frame: LocalFrame, crs: Any, px: npt.ArrayLike, py: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Convert positions in a CRS to local x, y."""
    x, y = Transformer.from_crs(crs, frame.proj, always_xy=True).transform(px, py)
    return np.asarray(x, np.float64), np.asarray(y, np.float64)


def write_raster(path: Path, cells: npt.NDArray[Any], transform: Affine | None, crs: Any, **profile: Any) -> Path:
    """Write cells (rows, cols) or (bands, rows, cols)."""
    units, scale, offset = profile.pop("units", None), profile.pop("scale", None), profile.pop("offset", None)
    tags = profile.pop("tags", {})
    bands = cells if cells.ndim == 3 else cells[None]
    place = {} if transform is None else {"transform": transform}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with rasterio.open(
            path, "w", driver=profile.pop("driver", "GTiff"), height=bands.shape[1], width=bands.shape[2],
            count=bands.shape[0], dtype=bands.dtype, crs=crs, **place, **profile,
        ) as dataset:  # fmt: skip
            dataset.write(bands)
            if tags:
                dataset.update_tags(**tags)
            if units is not None:
                dataset.units = [units] * bands.shape[0]
            if scale is not None:
                dataset.scales = [scale] * bands.shape[0]
            if offset is not None:
                dataset.offsets = [offset] * bands.shape[0]
    return path


def around(frame: LocalFrame, crs: Any, cell: float, half: float = 1000.0) -> tuple[Affine, int, int]:
    """Return transform, rows and cols of a north-up raster that reaches `half` metres around the frame's origin.

    `cell` is in the units of the CRS. Cell centres lie at odd positions, so that half a cell's error shows.
    """
    edge = np.linspace(-half, half, 9)
    px, py = in_crs(
        frame,
        crs,
        np.r_[edge, edge, 0 * edge - half, 0 * edge + half],
        np.r_[0 * edge - half, 0 * edge + half, edge, edge],
    )
    west, north = px.min() - 0.3 * cell, py.max() + 0.4 * cell
    rows, cols = int(np.ceil((north - py.min()) / cell)), int(np.ceil((px.max() - west) / cell))
    return Affine(cell, 0.0, west, 0.0, -cell, north), rows, cols


def scatter(half: float = 900.0, count: int = 500, seed: int = 3) -> tuple[FloatArray, FloatArray]:
    """Return random local positions in a square around the origin."""
    rng = np.random.default_rng(seed)
    return rng.uniform(-half, half, count), rng.uniform(-half, half, count)


def read(
    paths: Path | list[Path], frame: LocalFrame, x: npt.ArrayLike, y: npt.ArrayLike, **options: Any
) -> tuple[DemSurface, Diagnostics]:
    """Read a surface and its diagnostics; bilinear by default, which can be checked by hand."""
    options = {"method": "bilinear", **options}
    diagnostics = Diagnostics()
    files = [paths] if isinstance(paths, Path) else paths
    surface = read_surface(
        files, frame, np.asarray(x, np.float64), np.asarray(y, np.float64), SurfaceOptions(**options), diagnostics
    )
    return surface, diagnostics
