"""What the user may choose about elevation models, and which files are meant by paths, patterns and folders.

Imports nothing heavy: the command line reads it first.
"""

from __future__ import annotations

import glob
import math
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from osm2xodr.conventions import Group, flag, option
from osm2xodr.defaults import POLYNOMIAL_ORDER, SURFACE_METHOD
from osm2xodr.errors import InputError
from osm2xodr.system import record

METHODS = ("nearest", "bilinear", "bicubic", "polynomial")
DEM_TYPES = ("auto", "dtm", "dsm")
DEM_ENCODINGS = ("terrarium", "mapbox")

# Endings of elevation models in a folder, in small letters.
DEM_ENDINGS: Final = (".tif", ".tiff", ".hgt", ".vrt", ".asc", ".img", ".zip")


def _check_sigma(sigma: float) -> float:
    """Return a standard error, m; InputError if it is none."""
    if not 0.0 < sigma < math.inf:
        raise InputError(f"the elevation model's standard error {sigma} m is not above 0; give metres")
    return sigma


@record
class SurfaceOptions:
    """How heights are made from elevation models; `InputError` if a value is not offered."""

    # ``polynomial`` is the trend alone, which loses terrain shorter than about 1 km
    method: str = option(
        "surface",
        Group.HEIGHTS,
        "How heights between the cells of the elevation model are found.",
        default=SURFACE_METHOD,
        choices=METHODS,
    )
    polynomial_order: int = option(
        "polynomial_order",
        Group.MORE,
        "Degree of the trend that fills gaps of the elevation model.",
        int,
        default=POLYNOMIAL_ORDER,
        metavar="2-5",
        least=2,
        most=5,
    )
    dem_type: str = option(
        "dem_type",
        Group.HEIGHTS,
        "Whether elevation models show the ground (dtm), or canopy and roofs (dsm), which roads then see through.",
        default="auto",
        choices=DEM_TYPES,
    )
    sigma: float | None = option(
        "dem_sigma",
        Group.HEIGHTS,
        "Standard error of the elevation models' heights.  [default: estimated]",
        float,
        metavar="METRES",
        parse=_check_sigma,
        needs_dem=True,
    )
    vertical_datum: str | None = option(
        "vertical_datum",
        Group.HEIGHTS,
        "Turn heights into this datum: ellipsoid, or a code such as EPSG:3855 (EGM2008).  [default: as they are]",
        metavar="DATUM",
        needs_dem=True,
    )
    dem_vertical_datum: str | None = option(
        "dem_vertical_datum",
        Group.HEIGHTS,
        "Datum of the elevation models' heights, likewise.  [default: as the files say]",
        metavar="DATUM",
        needs_dem=True,
    )
    dem_crs: str | None = option(
        "dem_crs",
        Group.HEIGHTS,
        "CRS of elevation models that do not say theirs, such as EPSG:25832.  [default: they are refused]",
        metavar="CRS",
        needs_dem=True,
    )
    dem_unit: str | None = option(
        "dem_unit",
        Group.HEIGHTS,
        "Unit of heights of elevation models that do not say theirs, such as ft or us-ft.  [default: m]",
        metavar="UNIT",
        needs_dem=True,
    )
    dem_encoding: str | None = option(
        "dem_encoding",
        Group.HEIGHTS,
        "How elevation models that are pictures (Terrain-RGB) code heights as colours.  [default: they are refused]",
        choices=DEM_ENCODINGS,
        needs_dem=True,
    )
    allow_partial: bool = flag(
        "allow_partial",
        Group.HEIGHTS,
        "Accept elevation models that cover less than half of the roads, and maps that their server did not send in"
        " full.",
    )
    # Whatever `allow_partial` says
    coverage_least: float | None = option(
        "fail_below_coverage",
        Group.HEIGHTS,
        "Fail if elevation models cover less than this share of the roads, 0 to 1.  [default: half of them]",
        float,
        metavar="SHARE",
        least=0,
        most=1,
        needs_dem=True,
    )

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise InputError(f"surface '{self.method}' is not known; choose one of {', '.join(METHODS)}")
        if self.polynomial_order not in range(2, 6):
            raise InputError(f"the surface's polynomial order {self.polynomial_order} is not offered; choose 2 to 5")
        if self.sigma is not None:
            _check_sigma(self.sigma)
        if self.dem_type not in DEM_TYPES:
            remedy = f"choose one of {', '.join(DEM_TYPES)}"
            raise InputError(f"the type of elevation model '{self.dem_type}' is not known; {remedy}")
        if self.dem_vertical_datum is not None and self.vertical_datum is None:
            raise InputError(
                "the vertical datum of the elevation models is used only to convert heights to another; give "
                "--vertical-datum too"
            )


def expand(patterns: Iterable[str | os.PathLike[str]]) -> tuple[Path, ...]:
    """Return the files that are meant, each once; those of one pattern in the order of their names.

    `patterns` are paths, which need not exist; patterns with ``*``, ``?``, ``[...]`` and ``**``; folders, which stand
    for the elevation models in them. Raises `InputError` where a pattern or folder has no file.
    """
    found: dict[Path, None] = {}
    for given in patterns:
        path, pattern = Path(given), os.fspath(given)
        if path.is_dir():
            files = sorted(item for item in path.iterdir() if item.suffix.lower() in DEM_ENDINGS)
            if not files:
                raise InputError(f"there are no elevation models in the folder {pattern}; name their files")
        elif path.exists() or not glob.has_magic(pattern):
            files = [path]
        else:
            files = sorted(item for item in map(Path, glob.glob(pattern, recursive=True)) if item.is_file())
            if not files:
                raise InputError(f"no file is called like {pattern}; check the pattern")
        found.update(dict.fromkeys(files))
    return tuple(found)
