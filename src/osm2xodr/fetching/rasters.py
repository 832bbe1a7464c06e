"""Windows of elevation models: read from a server or from a file, and put together. All that knows rasterio here.

Files on servers are read in part as if they were local. Cells are neither resampled nor converted: what is written
has the values of the model.
"""

from __future__ import annotations

import os
from collections import OrderedDict
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from osm2xodr import defaults
from osm2xodr.errors import InputError
from osm2xodr.fetching.connection import Connection, Response, again, mark_of, range_of, shown
from osm2xodr.fetching.models import ElevationModel
from osm2xodr.fetching.options import ServerError
from osm2xodr.fetching.place import Box
from osm2xodr.projection import WGS84
from osm2xodr.system import gdal, raster_errors, record

# Cells beyond the area on each side, for interpolation and for the noise estimate at the border; a choice. More of
# coarse ones are of use.
_MARGIN_CELLS: Final = 8
# Most cells of a file that is written (512 MB in single precision); a choice.
CELLS_MAX: Final = 2**27
# Largest block of cells that is unpacked as a whole, bytes, as where elevation models are converted.
_BLOCK_MAX: Final = 2**28
# Rasters share a grid if the corner of one lies this near to a corner of cells of the other, cells.
_SAME_GRID: Final = 0.01
# Value of cells without a height where a model declares none: lower than any road.
_NODATA: Final = -32768.0
# Points on each side of a box whose sides are curves in another coordinate reference system.
_SIDE_POINTS: Final = 33

Cells = npt.NDArray[Any]

# Bytes that are asked for at the least, and at the most: where one part after the other is read, twice as many each
# time. And how much is kept of a file, in parts. Choices: 16 kB (the head of usual files), 4 MB and 64 MB.
PART: Final = 1 << 14
_PARTS_AT_ONCE: Final = 256
_PARTS_KEPT: Final = 4096


@record(eq=False)
class Raster:
    """A part of an elevation model."""

    cells: Cells  # (rows, cols) As in the model
    transform: Any  # Affine, from columns and rows to x and y in `crs`
    crs: str  # Coordinate reference system, WKT
    nodata: float  # Value of cells without a height
    # Heights are value * scale + offset, in `unit`, which may be empty
    scale: float
    offset: float
    unit: str

    def grid(self) -> tuple[Any, ...]:
        """Return what rasters must have in common to be put together, apart from where their cells lie."""
        a, b, _, d, e, _ = tuple(self.transform)[:6]
        steps = tuple(float(f"{value:.9g}") for value in (a, b, d, e))
        return self.crs, str(self.cells.dtype), self.nodata, self.scale, self.offset, self.unit, steps


class RasterError(Exception):
    """A file is no raster, or cannot be read to its end."""


def bounds_in(crs: str, box: Box) -> Box:
    """Return the bounds of a box (west, south, east, north, degrees) in another coordinate reference system."""
    with gdal() as rasterio:
        try:
            west, south, east, north = _bounds(crs, box)
        except raster_errors(rasterio) as error:
            raise InputError(f"crs {crs!r} of an elevation model is none ({error}); see docs/fetch.md") from None
    return west, south, east, north


def _bounds(crs: Any, box: Box) -> Box:
    import rasterio.warp

    found: Box = rasterio.warp.transform_bounds(WGS84, crs, *box, densify_pts=_SIDE_POINTS)
    return found


def read_window(file: Path | RemoteFile, box: Box, model: ElevationModel) -> Raster | None:
    """Return the part of a file in a box of degrees; None if it does not reach there.

    Raises `RasterError` if it cannot be read, `InputError` if it can, but is of no use, and the fault of a server.
    """
    with gdal(GDAL_PAM_ENABLED="NO") as rasterio:
        try:
            with _opened(rasterio, file) as dataset:
                found = _read(rasterio, dataset, box, model)
        except raster_errors(rasterio) as error:
            _raise_fault(file)
            raise RasterError(" ".join(str(error).split())) from error
        except (InputError, SystemError):
            # As what is wrong may look to those who have read only part of it.
            _raise_fault(file)
            raise
    _raise_fault(file)
    return found


def _opened(rasterio: Any, file: Path | RemoteFile) -> Any:
    if isinstance(file, Path):
        return rasterio.open(file, driver="GTiff")
    return rasterio.io.FilePath(file).open(driver="GTiff")


def _raise_fault(file: Path | RemoteFile) -> None:
    if isinstance(file, RemoteFile) and file.fault is not None:
        raise file.fault


def _read(rasterio: Any, dataset: Any, box: Box, model: ElevationModel) -> Raster | None:
    what = f"the file of {model.title}"
    if dataset.count < 1 or dataset.transform.is_identity:
        raise InputError(f"{what} does not say where it lies; choose another model with --dem-model")
    if dataset.tags(ns="OVERVIEWS"):
        raise InputError(f"{what} names another file, which is not read; choose another model with --dem-model")
    rows, cols = dataset.block_shapes[0]
    if rows * cols * np.dtype(dataset.dtypes[0]).itemsize > _BLOCK_MAX:
        raise InputError(
            f"{what} is packed in blocks that are too large to read; choose another one with --dem-model"
        )
    a, b, _, d, e, _ = tuple(dataset.transform)[:6]
    if b or d or a <= 0.0 or e >= 0.0:
        raise InputError(f"{what} is not laid out from north to south; choose another model with --dem-model")
    # Some services leave out what they were asked for.
    crs = dataset.crs or rasterio.crs.CRS.from_user_input(model.crs)
    west, south, east, north = _bounds(crs, box)
    corners = [_cell_at(dataset.transform, *corner) for corner in ((west, north), (east, south))]
    margin = defaults.COARSE_MARGIN_CELLS if model.cell >= defaults.COARSE_CELL else _MARGIN_CELLS
    left, top = (int(np.floor(value)) - margin for value in corners[0])
    right, bottom = (int(np.ceil(value)) + margin for value in corners[1])
    left, top = max(left, 0), max(top, 0)
    right, bottom = min(right, dataset.width), min(bottom, dataset.height)
    if left >= right or top >= bottom:
        return None
    _check_size((right - left) * (bottom - top), model)
    window = rasterio.windows.Window(left, top, right - left, bottom - top)
    cells = dataset.read(1, window=window, masked=True)
    nodata = dataset.nodata
    if nodata is None:
        nodata = _NODATA
        if not np.can_cast(np.int16, cells.dtype):
            # Such numbers have no room for it; single precision has, and keeps each of them.
            cells = cells.astype(np.float32)
    if model.datum and not _has_heights(crs):
        crs = _with_datum(rasterio, crs, model.datum)
    return Raster(
        np.asarray(cells.filled(nodata)),
        dataset.window_transform(window),
        crs.to_wkt(),
        float(nodata),
        float(dataset.scales[0]),
        float(dataset.offsets[0]),
        dataset.units[0] or "",
    )


def _cell_at(transform: Any, x: float, y: float) -> tuple[float, float]:
    """Return column and row of a place, counted from the corner of the first cell."""
    return (x - transform.c) / transform.a, (y - transform.f) / transform.e


def _has_heights(crs: Any) -> bool:
    return "VERT" in crs.to_wkt()


def _with_datum(rasterio: Any, crs: Any, datum: str) -> Any:
    """Return a coordinate reference system with that of heights; the same where it has no code."""
    code = crs.to_epsg()
    if code is None:
        return crs
    return rasterio.crs.CRS.from_user_input(f"EPSG:{code}+{datum.partition(':')[2]}")


def _check_size(cells: float, model: ElevationModel) -> None:
    """Refuse more cells than are written."""
    if cells > CELLS_MAX:
        raise InputError(
            f"the area has {cells / 1e6:,.0f} million cells of {model.title}, more than the {CELLS_MAX / 1e6:,.0f} "
            "million that are read; give a smaller area, or a coarser model with --dem-model"
        )


def joined(rasters: Sequence[Raster], model: ElevationModel) -> list[Raster]:
    """Put rasters together that share a grid; where several have a height, that of the first one is taken."""
    groups: list[list[Raster]] = []
    for raster in rasters:
        group = next((group for group in groups if _same_grid(group[0], raster)), None)
        if group is None:
            groups.append([raster])
        else:
            group.append(raster)
    return [group[0] if len(group) == 1 else _join(group, model) for group in groups]


def _same_grid(one: Raster, other: Raster) -> bool:
    if one.grid() != other.grid():
        return False
    offsets = np.array(_cell_at(one.transform, other.transform.c, other.transform.f))
    return bool((np.abs(offsets - np.round(offsets)) < _SAME_GRID).all())


def _join(group: Sequence[Raster], model: ElevationModel) -> Raster:
    first = group[0]
    places = np.array(
        [np.round(_cell_at(first.transform, item.transform.c, item.transform.f)) for item in group], np.int64
    )
    left, top = places.min(axis=0).tolist()
    sizes = np.array([item.cells.shape[::-1] for item in group], np.int64)
    right, bottom = (places + sizes).max(axis=0).tolist()
    _check_size((right - left) * (bottom - top), model)
    cells = np.full((bottom - top, right - left), first.nodata, first.cells.dtype)
    for item, (col, row) in zip(group, places.tolist(), strict=True):
        rows, cols = item.cells.shape
        part = cells[row - top : row - top + rows, col - left : col - left + cols]
        np.copyto(part, item.cells, where=_is_void(part, first.nodata))
    a, _, c, _, e, f = tuple(first.transform)[:6]
    transform = type(first.transform)(a, 0.0, c + left * a, 0.0, e, f + top * e)
    return Raster(cells, transform, first.crs, first.nodata, first.scale, first.offset, first.unit)


def _is_void(cells: Cells, nodata: float) -> npt.NDArray[np.bool_]:
    found: npt.NDArray[np.bool_] = np.isnan(cells) if np.isnan(nodata) else cells == nodata
    return found


def void_share(raster: Raster) -> float:
    """Return the share of cells without a height."""
    return float(np.mean(_is_void(raster.cells, raster.nodata)))


def packed(raster: Raster, description: str, attribution: str) -> bytes:
    """Return a raster as the bytes of a GeoTIFF, which says what it is and whom its data are owed."""
    rows, cols = raster.cells.shape
    predictor = 3 if raster.cells.dtype.kind == "f" else 2
    with gdal(GDAL_PAM_ENABLED="NO") as rasterio, rasterio.MemoryFile() as memory:
        with memory.open(
            driver="GTiff", width=cols, height=rows, count=1, dtype=raster.cells.dtype.name,
            crs=rasterio.crs.CRS.from_wkt(raster.crs), transform=raster.transform, nodata=raster.nodata,
            tiled=True, compress="deflate", predictor=predictor, bigtiff="IF_SAFER",
        ) as dataset:  # fmt: skip
            dataset.write(raster.cells, 1)
            dataset.scales, dataset.offsets = (raster.scale,), (raster.offset,)
            if raster.unit:
                dataset.units = (raster.unit,)
            dataset.update_tags(TIFFTAG_IMAGEDESCRIPTION=description, TIFFTAG_COPYRIGHT=attribution)
        return bytes(memory.getbuffer())


def unpacked(path: Path) -> Raster:
    """Return a raster that `packed` has made; `RasterError` if the file is damaged."""
    with gdal(GDAL_PAM_ENABLED="NO") as rasterio:
        try:
            with rasterio.open(path, driver="GTiff") as dataset:
                return Raster(
                    dataset.read(1),
                    dataset.transform,
                    dataset.crs.to_wkt(),
                    float(dataset.nodata),
                    float(dataset.scales[0]),
                    float(dataset.offsets[0]),
                    dataset.units[0] or "",
                )
        except raster_errors(rasterio) as error:
            raise RasterError(str(error)) from error


class RemoteFile:
    """A file on a server, which GDAL reads through rasterio.

    GDAL's callbacks must not fail: the first fault is kept in `fault`, and nothing is read from then on.
    """

    # Rasterio opens a file anew by its file system, which is this object too.
    path = mode = "rb"

    def __init__(self, connection: Connection, url: str, size: int, mark: str, head: bytes) -> None:
        self.fault: BaseException | None = None
        self._connection = connection
        self._url, self._size, self._mark = url, size, mark
        self._place = 0
        self._parts = OrderedDict({0: head}) if len(head) == min(PART, size) else OrderedDict[int, bytes]()
        self._next, self._run = -1, 1
        self._received = 0

    @property
    def fs(self) -> RemoteFile:
        """Return what opens the file."""
        return self

    def open(self, *_: Any) -> RemoteFile:
        """Return the file."""
        return self

    def close(self) -> None:
        """Do nothing: no connection stays open."""

    def tell(self) -> int:
        """Return where it is read next."""
        return self._place

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Set where it is read next, and return that."""
        start = {os.SEEK_SET: 0, os.SEEK_CUR: self._place, os.SEEK_END: self._size}[whence]
        self._place = max(0, start + offset)
        return self._place

    def read(self, count: int = -1) -> bytes:
        """Return what follows; less of it where the file ends, or where a fault is kept."""
        end = self._size if count < 0 else min(self._place + count, self._size)
        found = bytearray()
        try:
            while self.fault is None and self._place < end:
                number, first = divmod(self._place, PART)
                piece = self._part(number, (end - 1) // PART)[first : first + end - self._place]
                found += piece
                self._place += len(piece)
        except BaseException as error:
            self.fault = error
        return bytes(found) if self.fault is None else b""

    def _part(self, number: int, last: int) -> bytes:
        """Return a part; with it those up to another one are fetched, as far as none of them is there."""
        if number not in self._parts:
            self._run = min(2 * self._run, _PARTS_AT_ONCE) if number == self._next else 1
            count = 1
            most = min(max(last - number + 1, self._run), _PARTS_AT_ONCE, -(-self._size // PART) - number)
            while count < most and number + count not in self._parts:
                count += 1
            content = self._fetch(number * PART, min((number + count) * PART, self._size))
            for place in range(count):
                self._parts[number + place] = content[place * PART : (place + 1) * PART]
            self._next = number + count
            while len(self._parts) > _PARTS_KEPT:
                self._parts.popitem(last=False)
        self._parts.move_to_end(number)
        return self._parts[number]

    def _fetch(self, begin: int, end: int) -> bytes:
        """Return the bytes from `begin` up to `end`."""

        def read(response: Response) -> bytes:
            begins, size = range_of(response)
            mark = mark_of(response)
            if response.status != 206 or size != self._size or (mark and self._mark and mark != self._mark):
                raise ServerError(f"{shown(self._url)} has changed while it was read; start the same command again")
            if begins != begin:
                raise again("sends another part than it was asked for")
            content = bytearray()
            for chunk in self._connection.chunks(response):
                content += chunk
                if len(content) > end - begin:
                    break
            if len(content) != end - begin:
                raise again("sends another part than it was asked for")
            return bytes(content)

        self._received += end - begin
        most = self._connection.network.download_max
        if self._received > most:
            raise ServerError(
                f"{shown(self._url)} takes over {most / 1e6:,.1f} MB to be read, but --max-download allows no more; "
                "allow more, or give another address with --dem-url"
            )
        wanted = {"Range": f"bytes={begin}-{end - 1}"}
        return self._connection.ask(self._url, "--dem-url", read, lambda: wanted)
