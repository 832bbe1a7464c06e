"""Reading elevation models."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from pyproj import CRS, Transformer

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.model import BoolArray
from osm2xodr.surface.grids.containers import archive_of, beside, gdal_name, is_virtual, read_virtual, virtual_sources
from osm2xodr.surface.grids.crs import (
    AS_STATED,
    Encoding,
    Unstated,
    codes,
    crs_of,
    heights_of,
    horizontal_crs,
    likely_encoding,
    unit_of,
)
from osm2xodr.surface.grids.grid import Affine, Cells, GridFrame, empty_cells
from osm2xodr.surface.grids.quality import named_cover
from osm2xodr.system import RASTER_DRIVERS, VIRTUAL_DRIVER, gdal, raster_errors, record

# Largest block of cells that is unpacked as a whole, bytes; usual blocks have up to a few MB.
_BLOCK_MAX: Final = 2**28
# Heights of larger magnitude than the first are not heights, m (Everest: 8849 m). Nor are these values, which stand
# for "no data" in models that do not declare it, below the second height, m: no road is lower (shore of the Dead Sea:
# -430 m), in whatever unit.
_HEIGHT_MAX: Final = 9000.0
_HEIGHT_MIN: Final = -450.0
_SENTINELS: Final = (-32768.0, -32767.0, -9999.0, -99999.0, -999999.0)

_NETWORK: Final = re.compile(r"^/vsi\w+(/|$)|^[a-z][a-z0-9+.-]+:/", re.IGNORECASE)
# What GDAL opens as a raster where it lies beside one: masks and overviews. What it reads there as text, by endings
# that take the place of the raster's own: positions, coordinate reference systems, headers, descriptions.
_RASTERS_BESIDE: Final = (".msk", ".MSK", ".ovr", ".OVR")
_TEXTS_BESIDE: Final = (
    *(".aux", ".clr", ".hdr", ".imd", ".prj", ".rpb", ".stx", ".tab", ".tfw", ".tifw", ".wld", ".xml"),
)
# Cells that are read at a time, to bound memory.
_STRIP_CELLS: Final = 2**22
# Edge of the sample of a further band that tells whether it is the same everywhere, cells.
_BAND_SAMPLE: Final = 256
# Metadata with descriptions of a raster, and how much of each is read, characters.
_DESCRIPTIONS: Final = (
    *("TIFFTAG_IMAGEDESCRIPTION", "TIFFTAG_DOCUMENTNAME", "DESCRIPTION", "description", "TITLE", "title"),
)
_DESCRIPTION_MAX: Final = 1000
# Metadata that say whom the data are owed.
_CREDITS: Final = ("TIFFTAG_COPYRIGHT", "ATTRIBUTION", "attribution", "COPYRIGHT", "copyright")
# Bounds of the area of cells and of positions, in degrees or metres (squared): beyond them floating-point arithmetic
# breaks down.
_AREA_MIN: Final = 1e-18
_AREA_MAX: Final = 1e18
_POSITION_MAX: Final = 1e12


@record(eq=False)
class DemSource:
    """The description of an elevation model in its file."""

    # The file, its format and the type of its cells
    path: Path
    driver: str
    dtype: str
    coloured: bool  # Whether heights are coded as colours in the first three bands
    crs: CRS  # Horizontal CRS
    # As in `GridFrame`
    affine: Affine
    rows: int
    cols: int
    nodata: float | None  # Value of cells without a height; None if the file declares none
    # Heights are value * scale + offset, in `unit`
    scale: float
    offset: float
    # Name of the unit of heights, and its length in metres
    unit: str
    metres: float
    datum: CRS | None  # CRS of heights: vertical, or geographic with ellipsoidal heights; None if unknown
    # Whether its name or description is that of a surface model (canopy and roofs); None if they do not say
    covered: bool | None
    attribution: str  # Whom its data are owed, in one line; empty if it does not say

    @property
    def quantum(self) -> float:
        """Step between heights that neighbouring whole numbers stand for, m."""
        return abs(self.metres * self.scale)

    def frame(self, to_crs: Transformer) -> GridFrame:
        """Return the frame of all cells; `to_crs` leads from local positions to the CRS."""
        return GridFrame(self.crs, to_crs, self.affine, self.rows, self.cols)


@contextmanager
def _opened(rasterio: Any, path: Path, drivers: Sequence[str] | None = None) -> Iterator[Any]:
    """Open a raster with the first of some drivers that accepts it; of all, where none is given, and on disk VRT."""
    with ExitStack() as stack:
        name = gdal_name(path)
        if drivers is None and archive_of(path) is None and is_virtual(path):
            drivers, names = (VIRTUAL_DRIVER,), dict[Path, str]()
            for virtual in read_virtual(path):
                memory = stack.enter_context(rasterio.MemoryFile(virtual.text(names), ext=".vrt"))
                names[virtual.path] = name = memory.name
        # Other than `rasterio.open` it takes several drivers, and no name for anything but a file.
        yield stack.enter_context(rasterio.io.DatasetReader(name, driver=list(drivers or RASTER_DRIVERS)))


def describe_dem(path: Path, diagnostics: Diagnostics, known: Unstated = AS_STATED) -> DemSource:
    """Read the description of an elevation model, and check that the file is one.

    `known` is what holds where the file says nothing.
    `InputError` if it is not an existing local file, not a raster, an image, or without CRS or position.
    """
    _check_path(path)
    with gdal() as rasterio:
        try:
            sources = _sources(path)
            for source in sources:
                _check_texts(source)
            with _opened(rasterio, path) as dataset:
                _check_parts(rasterio, path, dataset, sources)
                encoding = _encoding(path, dataset, known)
                _check_bands(path, dataset, encoding, diagnostics)
                crs = crs_of(path, dataset, known)
                a, b, c, d, e, f = (float(value) for value in tuple(dataset.transform)[:6])
                if not _is_placed(dataset, crs):
                    remedy = "georeference it with gdal_translate -a_ullr"
                    raise InputError(f"{path}: the raster does not say where it lies; {remedy}")
                if encoding is None:
                    unit, metres = unit_of(path, dataset, crs, known, diagnostics)
                    scale, offset = float(dataset.scales[0]), float(dataset.offsets[0])
                else:
                    unit, metres, (scale, offset) = "metre", 1.0, encoding
                if not (np.isfinite([scale, offset]).all() and scale != 0.0):
                    remedy = "correct them with gdal_edit.py"
                    raise InputError(f"{path}: scale {scale} and offset {offset} are not valid for heights; {remedy}")
                return DemSource(
                    path, dataset.driver, dataset.dtypes[0], encoding is not None,
                    horizontal_crs(crs), (a, b, c, d, e, f),
                    dataset.height, dataset.width, dataset.nodata, scale, offset, unit, metres,
                    heights_of(crs), named_cover(path.name, _descriptions(dataset)), _attribution(dataset),
                )  # fmt: skip
        except raster_errors(rasterio):
            raise InputError(f"{path}: {_unreadable(path)}") from None


def read_heights(
    source: DemSource,
    frame: GridFrame,
    first_col: int,
    first_row: int,
    block: int,
    single: bool,
    diagnostics: Diagnostics,
) -> Cells:
    """Read a window of an elevation model's first band: heights (rows, cols), m; NaN in voids.

    `frame` is that of the window, `first_col` and `first_row` its first cell. Each of its cells is the mean of block
    x block cells of the model (of those with a height), in single precision if asked for. Values that are not heights
    are reported. A damaged file raises `InputError`.
    """
    heights = empty_cells(frame.rows, frame.cols, single)
    strip = max(1, _STRIP_CELLS // (frame.cols * block * block))
    sentinels: dict[float, int] = {}
    with gdal() as rasterio:
        try:
            with _opened(rasterio, source.path) as dataset:
                for row in range(0, frame.rows, strip):
                    count = min(strip, frame.rows - row)
                    place = first_col, first_row + row * block, frame.cols * block, count * block
                    window = rasterio.windows.Window(*place)
                    raw = dataset.read((1, 2, 3) if source.coloured else 1, window=window, masked=True)
                    raw = codes(raw) if source.coloured else raw
                    heights[row : row + count] = _block_means(_metres(source, raw, sentinels), block)
                place = first_col, first_row, frame.cols * block, frame.rows * block
                _report_constant(source, dataset, rasterio.windows.Window(*place), heights, diagnostics)
        except raster_errors(rasterio):
            virtual = source.driver == "VRT"
            why = "refers to a file that is missing or damaged" if virtual else "is damaged or cut short"
            raise InputError(f"{source.path}: the raster {why}, its cells cannot be read; get it whole") from None
    if sentinels:
        values = ", ".join(f"{value:g}" for value in sorted(sentinels)[:4])
        diagnostics.repaired(
            "dem-sentinel",
            "",
            f"{source.path}: {sum(sentinels.values())} cells hold values that are not heights ({values}) and that "
            "the file does not declare as nodata; they were taken for voids.",
        )
    return heights


def _report_constant(source: DemSource, dataset: Any, window: Any, heights: Cells, diagnostics: Diagnostics) -> None:
    """Report where the first of several bands is the same everywhere around the roads, and another one is not."""
    if source.coloured or dataset.count < 2 or heights.size < 2 or np.ptp(heights) != 0.0:
        return
    shape = tuple(min(size, _BAND_SAMPLE) for size in heights.shape)
    for band in range(2, dataset.count + 1):
        other = dataset.read(band, window=window, out_shape=shape, masked=True).compressed()
        if len(other) and np.ptp(other) > 0.0:
            diagnostics.guessed(
                "dem-constant",
                "",
                f"{source.path}: the first of the raster's {dataset.count} bands, which was taken for heights, is "
                f"{heights.flat[0]:g} m everywhere around the roads, and band {band} goes from {other.min():g} to "
                f"{other.max():g}; if heights stand there, give gdal_translate -b {band} of it.",
            )
            return


def _metres(source: DemSource, raw: Any, sentinels: dict[float, int]) -> npt.NDArray[np.float64]:
    """Convert cells to heights, m, with NaN for voids, and count undeclared nodata values in `sentinels`."""
    data: npt.NDArray[Any] = raw.data
    heights = data.astype(np.float64)
    void: BoolArray = ~np.isfinite(heights) | raw.mask
    heights = (heights * source.scale + source.offset) * source.metres
    # The lowest number of a signed type is not a height, whatever the scale.
    lowest = float(np.iinfo(data.dtype).min) if data.dtype.kind == "i" and data.dtype.itemsize > 1 else np.nan
    with np.errstate(invalid="ignore"):
        odd: BoolArray = (heights < _HEIGHT_MIN) | (heights > _HEIGHT_MAX) | (data == lowest)
    odd &= ~void
    suspects = data[odd].astype(np.float64)
    beyond = np.abs(heights[odd]) > _HEIGHT_MAX
    odd[odd] = beyond | np.isin(suspects, _SENTINELS) | (suspects == lowest)
    for value, count in zip(*np.unique(data[odd], return_counts=True), strict=True):
        sentinels[float(value)] = sentinels.get(float(value), 0) + int(count)
    heights[void | odd] = np.nan
    return heights


def _block_means(heights: npt.NDArray[np.float64], block: int) -> npt.NDArray[np.float64]:
    """Average blocks of cells over the cells with a height."""
    if block == 1:
        return heights
    rows, cols = heights.shape[0] // block, heights.shape[1] // block
    blocks = heights.reshape(rows, block, cols, block)
    known = np.isfinite(blocks)
    count = known.sum(axis=(1, 3))
    total = np.where(known, blocks, 0.0).sum(axis=(1, 3))
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _check_path(path: Path) -> None:
    """Raise an error unless a path is an existing local file that may be opened."""
    if _NETWORK.search(str(path)):
        raise InputError(f"{path}: elevation models are read from local files only; download it first")
    if archive_of(path) is not None:
        return
    if not path.exists():
        raise InputError(f"{path}: there is no such elevation model; check the path")
    if not path.is_file():
        remedy = "give the raster itself"
        raise InputError(f"{path}: an elevation model is one file; {remedy}")
    try:
        path.open("rb").close()
    except OSError as error:
        why = f"cannot be opened ({error.strerror}); check its permissions"
        raise InputError(f"{path}: the elevation model {why}") from None


def _unreadable(path: Path) -> str:
    """Return the likely reason why a file is not a raster."""
    name = path.name.lower()
    if name.endswith(".hgt"):
        return "the tile cannot be read; name it after its south-west corner, like N42E001.hgt, or get it whole"
    if name.endswith((".gz", ".bz2", ".xz", ".7z", ".tar", ".tgz", ".rar")):
        return "elevation models are not read from such archives; unpack it first"
    return "the file is not a raster that can be read, or it is damaged; give a GeoTIFF, HGT or VRT file"


def _encoding(path: Path, dataset: Any, known: Unstated) -> Encoding | None:
    """Return how the colours of a picture code heights, None if it is none; refuse those that code nothing known."""
    colours = {interpretation.name for interpretation in dataset.colorinterp}
    if dataset.count == 0 or not all(dtype in ("uint8", "int8") for dtype in dataset.dtypes):
        return None
    if dataset.count in (3, 4):
        if known.encoding is not None:
            return known.encoding
        if likely := likely_encoding(dataset):
            text = f"the raster is a picture whose colours seem to code heights as Terrain-RGB ({likely}) does"
            raise InputError(f"{path}: {text}; if so, say it with --dem-encoding {likely}")
    if dataset.count in (3, 4) or "palette" in colours:
        remedy = "give the elevation model itself, or say with --dem-encoding (terrarium, mapbox) how colours code it"
        raise InputError(f"{path}: the raster is a picture in colours, which are no heights by themselves; {remedy}")
    return None


def _check_bands(path: Path, dataset: Any, encoding: Encoding | None, diagnostics: Diagnostics) -> None:
    """Report further bands, and refuse what holds no heights."""
    if dataset.count == 0:
        remedy = "extract one with gdal_translate"
        raise InputError(f"{path}: the file has no raster band but maybe several rasters; {remedy}")
    if encoding is not None:
        return
    colours = {interpretation.name for interpretation in dataset.colorinterp}
    if dataset.dtypes[0].startswith("complex"):
        raise InputError(f"{path}: the raster holds complex numbers and no heights; give an elevation model")
    if dataset.count > 1 and not (dataset.count == 2 and "alpha" in colours):
        text = f"{path}: of the raster's {dataset.count} bands the first was taken for heights."
        diagnostics.note("dem-bands", "", text)


def _is_placed(dataset: Any, crs: CRS) -> bool:
    """Whether a raster has a position on Earth, and cells with an area."""
    a, b, c, d, e, f = (float(value) for value in tuple(dataset.transform)[:6])
    if dataset.transform.is_identity:
        return False
    # Written so that NaN fails.
    if not (_AREA_MIN <= abs(a * e - b * d) <= _AREA_MAX and max(abs(c), abs(f)) <= _POSITION_MAX):
        return False
    if not crs.is_geographic:
        return True
    across, down = d * dataset.width, e * dataset.height
    # Reaching half a cell beyond a pole is usual.
    return bool(max(map(abs, (f, f + across, f + down, f + across + down))) <= 90.0 + min(abs(d) + abs(e), 1.0))


def _sources(path: Path) -> list[Path]:
    """Return the rasters with cells that are read where a raster is: itself, or those behind a virtual one."""
    if archive_of(path) is not None or not is_virtual(path):
        return [path]
    return [source for source in virtual_sources(path) if source.is_file() and not is_virtual(source)]


def _check_texts(path: Path) -> None:
    """Refuse what GDAL would read with a raster, as soon as that is opened, and wait for."""
    endings = (*_TEXTS_BESIDE, f"{path.suffix[:2]}{path.suffix[-1:]}w", f"{path.suffix}w")
    stems = [path.stem + ending for ending in (*endings, *map(str.upper, endings))]
    beside(path, [*stems, f"{path.name}.aux", f"{path.name}.AUX", f"{path.name}.aux.xml", f"{path.name}.xml"])


def _check_parts(rasterio: Any, path: Path, dataset: Any, sources: Sequence[Path]) -> None:
    """Refuse a raster that leads GDAL elsewhere, or whose blocks of cells are too large to be unpacked.

    Looked at are the raster, or all sources of a virtual one, and what GDAL opens with each.
    """
    if dataset.driver != VIRTUAL_DRIVER:
        _check_raster(rasterio, path, dataset)
        return
    _check_blocks(path, dataset)
    for source in sources:
        with _opened(rasterio, source) as part:
            _check_raster(rasterio, source, part)


def _check_raster(rasterio: Any, path: Path, dataset: Any) -> None:
    """Refuse a raster that is no virtual one as `_check_parts` does."""
    _check_blocks(path, dataset)
    if dataset.tags(ns="OVERVIEWS"):
        remedy = "make a copy without them with gdal_translate"
        raise InputError(f"{path}: the raster names another file for its overviews, which is not read; {remedy}")
    for part in beside(path, [path.name + ending for ending in _RASTERS_BESIDE]):
        _check_texts(part)
        try:
            with _opened(rasterio, part, ("GTiff",)) as opened:
                _check_raster(rasterio, part, opened)
        except raster_errors(rasterio):
            raise InputError(
                f"{path}: {part.name}, which is read with it, is no GeoTIFF or damaged; remove it"
            ) from None


def _check_blocks(path: Path, dataset: Any) -> None:
    """Refuse blocks of cells that are too large to be unpacked."""
    for (rows, cols), dtype in zip(dataset.block_shapes, dataset.dtypes, strict=True):
        size = rows * cols * np.dtype(dtype).itemsize
        if size <= _BLOCK_MAX:
            continue
        remedy = "pack it in tiles with gdal_translate -co TILED=YES"
        raise InputError(f"{path}: the raster's cells are packed in blocks of {size / 1e6:,.0f} MB; {remedy}")


def _attribution(dataset: Any) -> str:
    """Return whom the data of a raster are owed, by its metadata, in one line."""
    tags = dataset.tags()
    found = next((str(tags[key]) for key in _CREDITS if str(tags.get(key, "")).strip()), "")
    return " ".join(found[:_DESCRIPTION_MAX].split())


def _descriptions(dataset: Any) -> list[str]:
    """Return the descriptions in a raster's metadata."""
    own = [str(dataset.tags().get(key, "")) for key in _DESCRIPTIONS]
    return [text[:_DESCRIPTION_MAX] for text in (*own, dataset.descriptions[0] or "")]
