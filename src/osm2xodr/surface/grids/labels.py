"""What a raster's file says about its CRS and its unit of heights, and what users know where it says nothing.

Heights may be coded as colours: Terrain-RGB, in which web maps get elevation models as pictures. Sources: Mapbox,
*Mapbox Terrain-RGB v1*; Mapzen and Tilezen, *Terrain tiles: Terrarium*.
"""

from __future__ import annotations

import functools
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from pyproj import CRS
from pyproj.exceptions import CRSError, ProjError

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.projection import transformer_from
from osm2xodr.surface.grids.vertical_crs import horizontal_crs, metres_per, vertical_unit
from osm2xodr.system import DATA_OF_OTHERS


@dataclass(frozen=True, slots=True, eq=False)
class Unstated:
    """What users know about elevation models whose files do not say it."""

    crs: CRS | None = None  # CRS, perhaps with one of heights
    unit: tuple[str, float] | None = None  # Name of the unit of heights, and its length in metres
    encoding: Encoding | None = None  # How pictures code heights as colours


AS_STATED: Final = Unstated()


def unstated(crs: str | None, unit: str | None, encoding: str | None = None) -> Unstated:
    """Return what is known of elevation models that do not say it.

    `InputError` if there is no such CRS, unit or encoding.
    """
    system = length = None
    if crs is not None:
        remedy = "give a code such as EPSG:25832"
        try:
            system = CRS.from_user_input(crs.strip())
        except CRSError:
            raise InputError(f"--dem-crs {crs}: this coordinate reference system is not known; {remedy}") from None
        if not (system.is_geographic or system.is_projected or system.is_compound):
            raise InputError(f"--dem-crs {crs}: {system.name} has no positions on Earth; {remedy}")
    if unit is not None:
        metres = metres_per(unit)
        if metres is None:
            raise InputError(f"--dem-unit {unit}: this unit is not known; give one such as m, ft or us-ft")
        length = unit, metres
    return Unstated(system, length, encoding_of(encoding))


def crs_of(path: Path, dataset: Any, known: Unstated) -> CRS:
    """Return the CRS of a raster, including that of its heights if any."""
    remedy = "assign the right one, for example with gdal_edit.py -a_srs EPSG:4326"
    if others := [name for name in DATA_OF_OTHERS if name in os.environ]:
        # In programs that use the library; commands do without these.
        remedy = f"unset {' and '.join(others)}, which may lead to the database of another version, or {remedy}"
    if dataset.crs is None and known.crs is None:
        name = "name it with --dem-crs, such as --dem-crs EPSG:25832"
        raise InputError(f"{path}: the raster has no coordinate reference system; {name}")
    try:
        crs = known.crs if dataset.crs is None and known.crs is not None else _parsed(dataset.crs.to_wkt())
        placed = crs.is_geographic or crs.is_projected or crs.is_compound
        if placed:
            # Raises an error for other planets and for impossible parameters.
            transformer_from(horizontal_crs(crs))
    except ProjError as error:
        planet = "celestial body" in str(error)
        why = "is not one on Earth" if planet else "cannot be converted to longitude and latitude"
        raise InputError(f"{path}: the raster's coordinate reference system {why}; {remedy}") from None
    except CRSError:
        raise InputError(f"{path}: the raster's coordinate reference system is not understood; {remedy}") from None
    if not placed:
        why = f"'{crs.name}' is not one on Earth; {remedy}"
        raise InputError(f"{path}: the raster's coordinate reference system {why}")
    return crs


@functools.lru_cache(maxsize=32)
def _parsed(wkt: str) -> CRS:
    """Return the CRS of a text; tiles by the thousand have the same."""
    return CRS.from_wkt(wkt)


def unit_of(path: Path, dataset: Any, crs: CRS, known: Unstated, diagnostics: Diagnostics) -> tuple[str, float]:
    """Return name and metres of the unit of heights: the band's, else the CRS's, the known one, metres."""
    if named := (dataset.units[0] or "").strip():
        metres = metres_per(named)
        if metres is not None:
            return named, metres
        if known.unit is not None:
            return known.unit
        text = f"{path}: the unit of heights '{named}' is not known; they were taken as metres."
        diagnostics.guessed("dem-unit", "", text)
        return "metre", 1.0
    if vertical := vertical_unit(crs):
        return vertical
    if known.unit is not None:
        return known.unit
    if crs.is_projected and abs(crs.axis_info[0].unit_conversion_factor - 1.0) > 1e-9:
        diagnostics.guessed(
            "dem-unit",
            "",
            f"{path}: positions are in {crs.axis_info[0].unit_name}, but heights have no unit; they were taken as "
            "metres. If they are feet, say so with --dem-unit ft.",
        )
    return "metre", 1.0


class Encoding(NamedTuple):
    """Heights are (65536 red + 256 green + blue) * step + lowest, m."""

    step: float
    lowest: float


ENCODINGS: Final = {"terrarium": Encoding(1.0 / 256.0, -32768.0), "mapbox": Encoding(0.1, -10000.0)}
# Edge of the sample of a picture that tells how its colours may code heights, cells.
_SAMPLE: Final = 256
# Heights on Earth, m; hardly any picture of something else has these alone, in either encoding.
_HEIGHTS: Final = (-500.0, 9000.0)


def encoding_of(name: str | None) -> Encoding | None:
    """Return an encoding by its name; `InputError` if it is not known."""
    if name is not None and name not in ENCODINGS:
        raise InputError(f"the encoding of heights '{name}' is not known; choose one of {', '.join(ENCODINGS)}")
    return None if name is None else ENCODINGS[name]


def codes(bands: Any) -> Any:
    """Return the numbers that three bands of bytes (3, rows, cols) code, masked where all of them are."""
    red, green, blue = bands.data.astype(np.uint32)
    masked: Any = np.ma
    return masked.masked_array((red << 16) | (green << 8) | blue, masked.getmaskarray(bands).all(axis=0))


def likely_encoding(dataset: Any) -> str | None:
    """Return the name of the encoding in which all colours of a picture are heights on Earth; None if in neither."""
    shape = tuple(min(size, _SAMPLE) for size in dataset.shape)
    found = codes(dataset.read((1, 2, 3), out_shape=(3, *shape), masked=True)).compressed()
    # Black is what pictures have outside the model.
    found = found[found > 0]
    for name, encoding in ENCODINGS.items():
        z = found * encoding.step + encoding.lowest
        if len(z) and z.min() >= _HEIGHTS[0] and z.max() <= _HEIGHTS[1]:
            return name
    return None
