"""Libraries as this program uses them: GDAL and PROJ with their own data, offline and silent; linear algebra.

Linear algebra runs on one thread.
"""

from __future__ import annotations

import contextlib
import ctypes
import logging
import os
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, MutableMapping
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Final

from osm2xodr.errors import Osm2xodrError

# Formats with cells in local files. Others (web services, databases, archives) are not tried.
RASTER_DRIVERS: Final = (
    "GTiff", "SRTMHGT", "AAIGrid", "EHdr", "ENVI", "HFA", "DTED", "USGSDEM", "BT", "SAGA", "RRASTER", "XYZ",
    "GS7BG", "GSBG", "GSAG", "netCDF", "JP2OpenJPEG", "PNG", "JPEG",
)  # fmt: skip
VIRTUAL_DRIVER: Final = "VRT"
# What other programs (conda, QGIS, OSGeo4W, SUMO) set, which leads to data, plug-ins and settings of other versions.
DATA_OF_OTHERS: Final = ("PROJ_DATA", "PROJ_LIB")
_SETTINGS_OF_OTHERS: Final = ("GDAL_", "OGR_", "OSR_", "CPL_", "VSI_", "GTIFF_", "VRT_")

# What keeps the libraries of a process that is yet to start from making threads at all.
_VARIABLES: Final = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
ONE_THREAD_ENVIRONMENT: Final = MappingProxyType(dict.fromkeys(_VARIABLES, "1"))
# Modules of NumPy and SciPy that are linked with a library of linear algebra; each package may bring its own.
_LINKED: Final = ("numpy.linalg._umath_linalg", "scipy.linalg._fblas", "scipy.sparse.linalg._dsolve._superlu")
# Functions that get and set the number of threads: of OpenBLAS by the names that its builds give them, MKL and BLIS.
_CALLS: Final = (
    *(
        (f"{prefix}openblas_get_num_threads{suffix}", f"{prefix}openblas_set_num_threads{suffix}")
        for prefix in ("scipy_", "")
        for suffix in ("64_", "")
    ),
    ("MKL_Get_Max_Threads", "MKL_Set_Num_Threads"),
    ("bli_thread_get_num_threads", "bli_thread_set_num_threads"),
)


class _Process:
    """Whether the process is this program's own, and how much of GDAL has been taken away in it."""

    own = False
    bare = False


def library_environment(environment: MutableMapping[str, str]) -> None:
    """Make an environment one in which libraries use their own data, one thread, and no network."""
    for name in tuple(environment):
        if name in DATA_OF_OTHERS or name.startswith(_SETTINGS_OF_OTHERS):
            del environment[name]
    # Where no file of settings is named, GDAL reads those of the system and of the user.
    environment.update(ONE_THREAD_ENVIRONMENT, PROJ_NETWORK="OFF", GDAL_CONFIG_FILE=os.devnull)


def own_process() -> None:
    """Say that the process is the command's: no other part of it uses GDAL, whose other drivers are taken away."""
    library_environment(os.environ)
    _Process.own = True


@contextmanager
def gdal(**settings: str) -> Iterator[Any]:
    """Yield rasterio, with GDAL silent, offline, single-threaded, with a small cache, and further settings.

    It lists no folders. In a command (`own_process`) it has no drivers but those of `RASTER_DRIVERS` and for virtual
    rasters, so that nothing it opens by itself can be anything else. A program that uses the library keeps its own.
    """
    # Takes a third of a second to load, which only users of elevation models should pay.
    import rasterio
    import rasterio.windows

    # GDAL's messages would reach standard error through Python's logging; our errors replace them.
    logger = logging.getLogger("rasterio")
    level = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        with (
            warnings.catch_warnings(),
            rasterio.Env(
                GDAL_NUM_THREADS="1",
                GDAL_CACHEMAX=64,
                GDAL_DISABLE_READDIR_ON_OPEN="TRUE",
                GDAL_VRT_ENABLE_PYTHON="NO",
                # Sources are checked before; GDAL would allow only those beside a virtual raster.
                GDAL_VRT_RAWRASTERBAND_ALLOWED_SOURCE="ALL",
                CPL_VSIL_CURL_ALLOWED_EXTENSIONS="{no file at all}",
                GTIFF_REPORT_COMPD_CS="YES",
                GTIFF_POINT_GEO_IGNORE="NO",
                **settings,
            ),
        ):
            if _Process.own and not _Process.bare:
                _remove_drivers(rasterio)
            warnings.simplefilter("ignore")
            yield rasterio
    finally:
        logger.setLevel(level)


def raster_errors(rasterio: Any) -> tuple[type[Exception], ...]:
    """Return what rasterio raises where a raster cannot be read."""
    return rasterio.errors.RasterioError, rasterio._err.CPLE_BaseError, OSError, ValueError, TypeError


def _library(rasterio: Any) -> ctypes.CDLL:
    """Return the library with GDAL's functions that rasterio uses; `Osm2xodrError` where it is not found."""
    # Most systems look a name up in a module and all that it is linked with, Windows in the module alone: there GDAL
    # lies beside the package in wheels, with other libraries in conda.
    beside = Path(rasterio.__file__).parent.with_name("rasterio.libs").glob("gdal*.dll")
    for file in (Path(rasterio._env.__file__), *sorted(beside), Path(sys.prefix, "Library", "bin", "gdal.dll")):
        with suppress(OSError):
            library = ctypes.CDLL(str(file))
            if hasattr(library, "GDALDeregisterDriver"):
                return library
    raise Osm2xodrError(
        "GDAL is not found in this installation of rasterio, so that its drivers for the network cannot be taken"
        " away; install its wheel with pip"
    )


def _remove_drivers(rasterio: Any) -> None:
    """Take away all drivers that are not meant; GDAL's own list of drivers to skip is too late once it has begun."""
    library = _library(rasterio)
    get, name, remove = library.GDALGetDriver, library.GDALGetDriverShortName, library.GDALDeregisterDriver
    get.restype, get.argtypes = ctypes.c_void_p, [ctypes.c_int]
    name.restype, name.argtypes = ctypes.c_char_p, [ctypes.c_void_p]
    remove.restype, remove.argtypes = None, [ctypes.c_void_p]
    # Virtual rasters that are warped, and copies that GDAL makes, lie in memory.
    kept = {*RASTER_DRIVERS, VIRTUAL_DRIVER, "MEM"}
    for driver in [get(number) for number in range(library.GDALGetDriverCount())]:
        if name(driver).decode() not in kept:
            remove(driver)
    _Process.bare = True


class _Hold:
    """How many want one thread, and what undoes it for the last of them."""

    lock = threading.Lock()
    count = 0
    undo: ClassVar[list[Callable[[], object]]] = []


@contextlib.contextmanager
def one_thread() -> Iterator[None]:
    """Keep the linear algebra of this process to one thread, and give it back its threads afterwards.

    It holds for NumPy and SciPy as far as they are loaded, in all threads of the program, from the first block that
    is entered to the last that is left.
    """
    with _Hold.lock:
        if not _Hold.count:
            _Hold.undo = _limit()
        _Hold.count += 1
    try:
        yield
    finally:
        with _Hold.lock:
            _Hold.count -= 1
            while not _Hold.count and _Hold.undo:
                _Hold.undo.pop()()


def _limit() -> list[Callable[[], object]]:
    """Set all libraries to one thread, and return what undoes it."""
    undo: list[Callable[[], object]] = []
    for module in _LINKED:
        path = getattr(sys.modules.get(module), "__file__", None)
        if path is None:
            continue
        # A name is looked up in the module and all that it is linked with.
        library = ctypes.CDLL(path)
        for getter, setter in _CALLS:
            get, put = getattr(library, getter, None), getattr(library, setter, None)
            if get is not None and put is not None and (count := int(get())) > 1:
                put(1)
                undo.append(partial(put, count))
    return undo
