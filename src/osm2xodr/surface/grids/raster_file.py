"""Reads elevation models. The only module that knows rasterio, and it loads it only when a file is to be read."""

from __future__ import annotations

import logging
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from pyproj import CRS, Transformer
from pyproj.exceptions import CRSError, ProjError

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.model import BoolArray
from osm2xodr.projection import WGS84
from osm2xodr.surface.grids.grid import Affine, GridFrame
from osm2xodr.surface.grids.interpolation import Cells, empty_cells
from osm2xodr.surface.grids.surface_type import named_cover
from osm2xodr.surface.grids.units import horizontal_crs, metres_per, vertical_unit
from osm2xodr.surface.grids.vertical_datum import heights_of
from osm2xodr.surface.grids.vrt import is_virtual, virtual_sources

# Largest block of cells that a file may ask to be unpacked as a whole, bytes; usual ones have up to some MB.
_DEM_BLOCK_MAX: Final = 2**28
# Magnitude above which a height is no height, m: no road is higher (Everest: 8849 m) or lower. Below the second
# height no road lies either (shore of the Dead Sea: -430 m), so that values there that stand for "nothing" in
# models without a nodata tag give themselves away in whatever unit.
_HEIGHT_LIMIT: Final = 9000.0
_HEIGHT_LOWEST: Final = -450.0
_HEIGHT_SENTINELS: Final = (-32768.0, -32767.0, -9999.0, -99999.0, -999999.0)

# Formats that hold their cells in local files. Others (web services, databases, archives) are not even tried.
_DRIVERS = (
    "GTiff", "VRT", "SRTMHGT", "AAIGrid", "EHdr", "ENVI", "HFA", "DTED", "USGSDEM", "BT", "SAGA", "RRASTER", "XYZ",
    "GS7BG", "GSBG", "GSAG", "netCDF", "JP2OpenJPEG", "PNG", "JPEG",
)  # fmt: skip
_NETWORK = re.compile(r"^/vsi\w+(/|$)|^[a-z][a-z0-9+.-]+:/", re.IGNORECASE)
_STRIP_CELLS = 2**22
# Metadata in which rasters describe themselves.
_DESCRIPTIONS = ("TIFFTAG_IMAGEDESCRIPTION", "TIFFTAG_DOCUMENTNAME", "DESCRIPTION", "description", "TITLE", "title")

# Areas of cells, and positions, that a raster on Earth can have, in degrees or metres (squared): with any others the
# arithmetic of floating point has no meaning.
_LEAST_AREA, _LARGEST_AREA, _FARTHEST = 1e-18, 1e18, 1e12


@dataclass(frozen=True, slots=True, eq=False)
class DemSource:
    """What an elevation model's file says about its heights."""

    # The file, its format and the type of its cells
    path: Path
    driver: str
    dtype: str
    crs: CRS  # Horizontal CRS
    # As in `GridFrame`
    affine: Affine
    rows: int
    cols: int
    nodata: float | None  # Value that stands for no height; None where the file names none
    # Heights are value * scale + offset, in `unit`
    scale: float
    offset: float
    # Name of the unit of heights and what it is in metres
    unit: str
    metres: float
    datum: CRS | None  # What heights count from: a vertical CRS, a geographic one with ellipsoidal heights, or None
    # Whether its name or description is that of a surface model (canopy and roofs); None if it says nothing
    covered: bool | None


@contextmanager
def _gdal() -> Iterator[Any]:
    """Give rasterio with GDAL kept quiet, off the network, small and single-threaded."""
    # Takes a third of a second to load, which only those with an elevation model should pay.
    import rasterio
    import rasterio.windows

    # GDAL's own messages would reach standard error through Python's logging; ours say what went wrong.
    logger = logging.getLogger("rasterio")
    level = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        with (
            warnings.catch_warnings(),
            rasterio.Env(
                GDAL_NUM_THREADS="1",
                GDAL_CACHEMAX=64,
                GDAL_VRT_ENABLE_PYTHON="NO",
                CPL_VSIL_CURL_ALLOWED_EXTENSIONS="{no file at all}",
                GTIFF_REPORT_COMPD_CS="YES",
                GTIFF_POINT_GEO_IGNORE="NO",
            ),
        ):
            warnings.simplefilter("ignore")
            yield rasterio
    finally:
        logger.setLevel(level)


def _open(rasterio: Any, path: Path) -> Any:
    """Open a raster with the first driver that takes it."""
    for driver in _DRIVERS[:-1]:
        try:
            return rasterio.open(path.absolute(), driver=driver)
        except rasterio.errors.RasterioIOError:
            continue
    return rasterio.open(path.absolute(), driver=_DRIVERS[-1])


def describe_dem(path: Path, diagnostics: Diagnostics) -> DemSource:
    """Read what an elevation model's file says about its heights, and check that it is one.

    Raises
    ------
    InputError
        Not an existing local file, not a raster, an image, without CRS or position.
    """
    _check_path(path)
    with _gdal() as rasterio:
        try:
            with _open(rasterio, path) as dataset:
                _check_bands(path, dataset, diagnostics)
                _check_blocks(rasterio, path, dataset)
                crs = _crs_of(path, dataset)
                a, b, c, d, e, f = (float(value) for value in tuple(dataset.transform)[:6])
                if not _is_placed(dataset, crs):
                    raise InputError(
                        f"{path}: the raster does not say where it lies; georeference it with gdal_translate -a_ullr"
                    )
                unit, metres = _unit_of(path, dataset, crs, diagnostics)
                scale, offset = float(dataset.scales[0]), float(dataset.offsets[0])
                if not (np.isfinite([scale, offset]).all() and scale != 0.0):
                    raise InputError(
                        f"{path}: scale {scale} and offset {offset} make no heights; correct them with gdal_edit.py"
                    )
                return DemSource(
                    path, dataset.driver, dataset.dtypes[0], horizontal_crs(crs), (a, b, c, d, e, f),
                    dataset.height, dataset.width, dataset.nodata, scale, offset, unit, metres,
                    heights_of(crs), named_cover(path.name, _descriptions(dataset)),
                )  # fmt: skip
        except (rasterio.errors.RasterioError, OSError, ValueError):
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
    """Read a window of an elevation model's first band.

    Parameters
    ----------
    source
        The model.
    frame
        Frame of the window; it says how many cells are wanted.
    first_col, first_row
        The window's first cell.
    block
        Each cell wanted is the mean of block x block cells of the model (those of them that have a height).
    single
        Whether to keep heights in single precision.

    Returns
    -------
    (rows, cols)
        Heights, m; NaN where there are none.

    Raises
    ------
    InputError
        The file is damaged.
    """
    heights = empty_cells(frame.rows, frame.cols, single)
    strip = max(1, _STRIP_CELLS // (frame.cols * block * block))
    sentinels: dict[float, int] = {}
    with _gdal() as rasterio:
        try:
            with _open(rasterio, source.path) as dataset:
                for row in range(0, frame.rows, strip):
                    count = min(strip, frame.rows - row)
                    window = rasterio.windows.Window(
                        first_col, first_row + row * block, frame.cols * block, count * block
                    )
                    raw = dataset.read(1, window=window, masked=True)
                    heights[row : row + count] = _block_means(_metres(source, raw, sentinels), block)
        except (rasterio.errors.RasterioError, OSError, ValueError):
            why = (
                "refers to a file that is missing or damaged" if source.driver == "VRT" else "is damaged or cut short"
            )
            raise InputError(f"{source.path}: the raster {why}, its cells cannot be read; get it whole") from None
    if sentinels:
        values = ", ".join(f"{value:g}" for value in sorted(sentinels)[:4])
        diagnostics.repaired(
            "dem-sentinel",
            "",
            f"{source.path}: {sum(sentinels.values())} cells hold values that are no heights ({values}) and that the "
            "file does not declare as nodata; they were taken for voids.",
        )
    return heights


def _metres(source: DemSource, raw: Any, sentinels: dict[float, int]) -> npt.NDArray[np.float64]:
    """Turn cells into heights, m, with NaN for voids, and count undeclared values that are none."""
    data: npt.NDArray[Any] = raw.data
    heights = data.astype(np.float64)
    void: BoolArray = ~np.isfinite(heights) | raw.mask
    heights = (heights * source.scale + source.offset) * source.metres
    # The lowest number of a signed type is nobody's height, whatever the scale.
    lowest = float(np.iinfo(data.dtype).min) if data.dtype.kind == "i" and data.dtype.itemsize > 1 else np.nan
    with np.errstate(invalid="ignore"):
        odd: BoolArray = (heights < _HEIGHT_LOWEST) | (heights > _HEIGHT_LIMIT) | (data == lowest)
    odd &= ~void
    suspects = data[odd].astype(np.float64)
    beyond = np.abs(heights[odd]) > _HEIGHT_LIMIT
    odd[odd] = beyond | np.isin(suspects, _HEIGHT_SENTINELS) | (suspects == lowest)
    for value, count in zip(*np.unique(data[odd], return_counts=True), strict=True):
        sentinels[float(value)] = sentinels.get(float(value), 0) + int(count)
    heights[void | odd] = np.nan
    return heights


def _block_means(heights: npt.NDArray[np.float64], block: int) -> npt.NDArray[np.float64]:
    """Average blocks of cells over those that have a height."""
    if block == 1:
        return heights
    rows, cols = heights.shape[0] // block, heights.shape[1] // block
    blocks = heights.reshape(rows, block, cols, block)
    known = np.isfinite(blocks)
    count = known.sum(axis=(1, 3))
    total = np.where(known, blocks, 0.0).sum(axis=(1, 3))
    out: npt.NDArray[np.float64] = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    return out


def _check_path(path: Path) -> None:
    """Refuse anything that is not an existing local file that may be opened."""
    if _NETWORK.search(str(path)):
        raise InputError(f"{path}: elevation models are read from local files only; download it first")
    if not path.exists():
        raise InputError(f"{path}: there is no such elevation model; check the path")
    if not path.is_file():
        raise InputError(
            f"{path}: an elevation model is one file; give the raster itself, several with several --dem"
        )
    try:
        if is_virtual(path):
            virtual_sources(path)
    except OSError as error:
        raise InputError(
            f"{path}: the elevation model cannot be opened ({error.strerror}); check its permissions"
        ) from None


def _unreadable(path: Path) -> str:
    """Say why a file might not be a raster."""
    name = path.name.lower()
    if name.endswith(".hgt"):
        return (
            "the tile cannot be read; name it after its south-west corner, like N42E001.hgt, and see that it is whole"
        )
    if name.endswith((".gz", ".zip", ".bz2", ".xz", ".7z", ".tar", ".tgz", ".rar")):
        return "elevation models are not read from archives; unpack it first"
    return "the file is not a raster that can be read, or it is damaged; give a GeoTIFF, HGT or VRT file"


def _check_bands(path: Path, dataset: Any, diagnostics: Diagnostics) -> None:
    """Refuse images, and say so where more than one band is there."""
    if dataset.count == 0:
        raise InputError(
            f"{path}: the file holds no raster band but maybe several rasters; extract one with gdal_translate"
        )
    colours = {interpretation.name for interpretation in dataset.colorinterp}
    is_byte = all(dtype in ("uint8", "int8") for dtype in dataset.dtypes)
    if is_byte and (dataset.count in (3, 4) or "palette" in colours):
        raise InputError(
            f"{path}: the raster is a picture in colours and holds no heights; give the elevation model itself"
        )
    if dataset.dtypes[0].startswith("complex"):
        raise InputError(f"{path}: the raster holds complex numbers and no heights; give an elevation model")
    if dataset.count > 1 and not (dataset.count == 2 and "alpha" in colours):
        diagnostics.note(
            "dem-bands", "", f"{path}: of the raster's {dataset.count} bands the first was taken for heights."
        )


def _is_placed(dataset: Any, crs: CRS) -> bool:
    """Say whether a raster lies somewhere on Earth, with cells that have an area."""
    a, b, c, d, e, f = (float(value) for value in tuple(dataset.transform)[:6])
    if dataset.transform.is_identity:
        return False
    # Written so that NaN is out of all bounds.
    if not (_LEAST_AREA <= abs(a * e - b * d) <= _LARGEST_AREA and max(abs(c), abs(f)) <= _FARTHEST):
        return False
    if not crs.is_geographic:
        return True
    across, down = d * dataset.width, e * dataset.height
    # Half a cell beyond a pole is usual.
    return bool(max(map(abs, (f, f + across, f + down, f + across + down))) <= 90.0 + min(abs(d) + abs(e), 1.0))


def _check_blocks(rasterio: Any, path: Path, dataset: Any) -> None:
    """Refuse files, and sources of virtual rasters, whose cells are packed in blocks too large to be unpacked."""
    rows, cols = dataset.block_shapes[0]
    size = rows * cols * np.dtype(dataset.dtypes[0]).itemsize
    if size > _DEM_BLOCK_MAX:
        raise InputError(
            f"{path}: the raster's cells are packed in blocks of {size / 1e6:,.0f} MB;"
            " pack it in tiles with gdal_translate -co TILED=YES"
        )
    for name in dataset.files if dataset.driver == "VRT" else ():
        if Path(name).is_file() and not path.samefile(name):
            with _open(rasterio, Path(name)) as source:
                _check_blocks(rasterio, Path(name), source)


def _descriptions(dataset: Any) -> list[str]:
    """Return what a raster says about itself."""
    own = [str(dataset.tags().get(key, "")) for key in _DESCRIPTIONS]
    return [text[:1000] for text in (*own, dataset.descriptions[0] or "")]


def _crs_of(path: Path, dataset: Any) -> CRS:
    """Return the CRS of a raster, heights included where it has any."""
    remedy = "assign the right one, for example with gdal_edit.py -a_srs EPSG:4326"
    if dataset.crs is None:
        raise InputError(f"{path}: the raster has no coordinate reference system; {remedy}")
    try:
        crs = CRS.from_wkt(dataset.crs.to_wkt())
        placed = crs.is_geographic or crs.is_projected or crs.is_compound
        if placed:
            # Raises for what is on another planet, or has numbers that no projection can have.
            Transformer.from_crs(WGS84, horizontal_crs(crs), always_xy=True)
    except ProjError as error:
        planet = "celestial body" in str(error)
        why = "is not one on Earth" if planet else "cannot be turned into longitude and latitude"
        raise InputError(f"{path}: the raster's coordinate reference system {why}; {remedy}") from None
    except CRSError:
        raise InputError(f"{path}: the raster's coordinate reference system is not understood; {remedy}") from None
    if not placed:
        raise InputError(
            f"{path}: the raster's coordinate reference system '{crs.name}' is not one on Earth; {remedy}"
        )
    return crs


def _unit_of(path: Path, dataset: Any, crs: CRS, diagnostics: Diagnostics) -> tuple[str, float]:
    """Return name and metres of the unit of heights: the band's, else that of the CRS's heights, else metres."""
    named = (dataset.units[0] or "").strip()
    if named:
        metres = metres_per(named)
        if metres is not None:
            return named, metres
        diagnostics.guessed(
            "dem-unit", "", f"{path}: the unit of heights '{named}' is not known; they were taken as metres."
        )
        return "metre", 1.0
    vertical = vertical_unit(crs)
    if vertical is not None:
        return vertical
    if crs.is_projected and abs(crs.axis_info[0].unit_conversion_factor - 1.0) > 1e-9:
        diagnostics.guessed(
            "dem-unit",
            "",
            f"{path}: positions are in {crs.axis_info[0].unit_name}, but heights have no unit; they were taken as "
            "metres. If they are feet, say so in the file with gdal_edit.py -units ft.",
        )
    return "metre", 1.0
