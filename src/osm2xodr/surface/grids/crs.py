"""What a raster's file says about its CRS, its vertical datum and its unit of heights, and what users know of them.

Heights are converted to another datum only on request, and only with the best transformation that PROJ knows.

They may be coded as colours: Terrain-RGB, in which web maps get elevation models as pictures. Sources: Mapbox,
*Mapbox Terrain-RGB v1*; Mapzen and Tilezen, *Terrain tiles: Terrarium*.
"""

from __future__ import annotations

import functools
import os
import warnings
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, NamedTuple

import numpy as np
from pyproj import CRS, Transformer
from pyproj.crs.crs import CompoundCRS
from pyproj.exceptions import CRSError, ProjError
from pyproj.transformer import TransformerGroup

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray
from osm2xodr.projection import offline, transformer_from
from osm2xodr.surface.grids.grid import Cells, GridFrame
from osm2xodr.surface.grids.voids import interpolate_lattice
from osm2xodr.system import DATA_OF_OTHERS, record

# Spacing of the points at which the difference between two vertical datums is computed, m: geoids are smoother.
_DATUM_SPACING: Final = 1000.0
# Rows that are converted at a time, to bound memory.
_STRIP: Final = 256

# The user's word for heights above the WGS 84 ellipsoid.
_ELLIPSOID: Final = "ellipsoid"
_WGS84: Final = 4326

# The international foot is 0.3048 m by definition (1959), the US survey foot 1200/3937 m.
FOOT: Final = 0.3048
_US_SURVEY_FOOT: Final = 1200.0 / 3937.0
_METRES: Final = MappingProxyType(
    {
        **dict.fromkeys(("m", "metre", "metres", "meter", "meters", "mtr"), 1.0),
        **dict.fromkeys(("dm", "decimetre", "decimeter", "decimetres", "decimeters"), 0.1),
        **dict.fromkeys(("cm", "centimetre", "centimeter", "centimetres", "centimeters"), 0.01),
        **dict.fromkeys(("mm", "millimetre", "millimeter", "millimetres", "millimeters"), 0.001),
        **dict.fromkeys(("km", "kilometre", "kilometer", "kilometres", "kilometers"), 1000.0),
        **dict.fromkeys(("ft", "foot", "feet", "international foot", "international feet"), FOOT),
        "foot international": FOOT,
        **dict.fromkeys(("us-ft", "us ft", "ftus", "sft", "us survey foot", "us survey feet"), _US_SURVEY_FOOT),
        **dict.fromkeys(("us foot", "us feet", "survey foot", "foot us"), _US_SURVEY_FOOT),
        **dict.fromkeys(("u.s. survey foot", "u.s. survey feet"), _US_SURVEY_FOOT),
        **dict.fromkeys(("yd", "yard", "yards"), 3.0 * FOOT),
        **dict.fromkeys(("fathom", "fathoms"), 6.0 * FOOT),
    }
)


@record(eq=False)
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


def metres_per(unit: str) -> float | None:
    """Return the metres in a unit of length as rasters name it, None if the name is not known."""
    return _METRES.get(unit.strip().strip("[]()").replace("_", " ").casefold())


def vertical_unit(crs: CRS) -> tuple[str, float] | None:
    """Return name and metres of the unit of a CRS's heights, None if it has no heights."""
    vertical = [part for part in crs.sub_crs_list if part.is_vertical]
    axes = vertical[0].axis_info if vertical else crs.axis_info[2:3]
    return (axes[0].unit_name, axes[0].unit_conversion_factor) if axes else None


@functools.lru_cache(maxsize=32)
def horizontal_crs(crs: CRS) -> CRS:
    """Return the CRS without its heights."""
    plain = next((part for part in crs.sub_crs_list if not part.is_vertical), crs) if crs.is_compound else crs
    return plain.to_2d()


def parse_datum(text: str) -> CRS:
    """Return the CRS of the heights that a user names; `InputError` if it has none.

    That is ``ellipsoid`` (WGS 84), or a vertical, compound or three-dimensional CRS in any form that PROJ reads, such
    as ``EPSG:3855`` (EGM2008) or ``EPSG:5773`` (EGM96).
    """
    remedy = f"give '{_ELLIPSOID}' or the code of a vertical reference system, such as EPSG:3855 (EGM2008)"
    if text.strip().casefold() == _ELLIPSOID:
        return CRS.from_epsg(_WGS84).to_3d()
    try:
        crs = CRS.from_user_input(text.strip())
    except CRSError:
        raise InputError(f"the vertical datum '{text}' is not known; {remedy}") from None
    heights = heights_of(crs)
    if heights is None:
        raise InputError(f"'{text}' ({crs.name}) has no heights; {remedy}")
    return heights


@functools.lru_cache(maxsize=32)
def heights_of(crs: CRS) -> CRS | None:
    """Return the CRS of a CRS's heights: vertical, or geographic with ellipsoidal heights; None if it has none."""
    for part in crs.sub_crs_list if crs.is_compound else (crs,):
        if part.is_vertical:
            return part
    geodetic = crs.geodetic_crs
    return geodetic.to_3d() if geodetic is not None and len(crs.axis_info) == 3 and not crs.is_geocentric else None


def convert_heights(
    path: Path, z: Cells, frame: GridFrame, source: CRS, target: CRS, diagnostics: Diagnostics
) -> Cells:
    """Return heights z (rows, cols), m, NaN in voids, converted from one vertical datum to another (`parse_datum`).

    The difference between two datums is computed at points about 1 km apart and interpolated, as geoids change by
    centimetres over kilometres. The transformation and the shift are reported. `InputError` if there is no
    transformation, or if it needs a grid that is not installed or does not reach the cells.
    """
    if source.equals(target, ignore_axis_order=True) or _label(source) == _label(target):
        return z
    stride = max(1, int(_DATUM_SPACING / max(frame.steps())))
    rows, cols = (-(-size // stride) + 1 for size in z.shape)
    col, row = np.meshgrid(np.arange(cols) * float(stride), np.arange(rows) * float(stride))
    known = np.isfinite(z)
    height = float(np.median(z[known])) if known.any() else 0.0
    shift, how = _shift(path, frame, col.reshape(-1), row.reshape(-1), height, source, target)
    lattice = shift.reshape(rows, cols)
    out = z.copy()
    for first in range(0, len(z), _STRIP):
        strip = slice(first, min(first + _STRIP, len(z)))
        out[strip] += interpolate_lattice(lattice, stride, strip, z.shape[1])
    diagnostics.note(
        "vertical-datum",
        "",
        f"{path}: heights were converted from {_label(source)} to {_label(target)} ({how}), which changed them by "
        f"{shift.min():.2f} to {shift.max():.2f} m.",
    )
    return out


def _shift(
    path: Path, frame: GridFrame, col: FloatArray, row: FloatArray, height: float, source: CRS, target: CRS
) -> tuple[FloatArray, str]:
    """Return the increase of heights at col, row (n,), m, and the name of the transformation."""
    geodetic = frame.crs.geodetic_crs
    if geodetic is None:
        why = "so that heights cannot be converted to another vertical datum; leave --vertical-datum out"
        raise InputError(f"{path}: the raster's coordinate reference system has no datum, {why}")
    # Heights in a vertical CRS belong to the raster's own positions, ellipsoidal ones to those on their ellipsoid.
    base = geodetic.to_2d() if source.is_vertical else source.to_2d()
    lon, lat = Transformer.from_crs(frame.crs, base, always_xy=True).transform(*frame.in_crs(col, row))
    begin, end = _with_heights(base, source), _with_heights(CRS.from_epsg(_WGS84), target)
    unit, new_unit = (crs.axis_info[-1].unit_conversion_factor for crs in (begin, end))
    with offline():
        try:
            transformer = Transformer.from_crs(begin, end, always_xy=True, allow_ballpark=False, only_best=True)
            heights = transformer.transform(lon, lat, np.full(len(lon), height / unit), errcheck=True)[2]
            how = transformer.get_last_used_operation().description
        except ProjError:
            raise _refusal(path, begin, end, source, target) from None
        if not np.isfinite(heights).all():
            raise _refusal(path, begin, end, source, target)
    return np.asarray(heights, np.float64) * new_unit - height, how


def _with_heights(base: CRS, heights: CRS) -> CRS:
    """Return a geographic CRS with heights, above its ellipsoid or in a vertical CRS."""
    return CompoundCRS(f"{base.name} + {heights.name}", [base, heights]) if heights.is_vertical else base.to_3d()


def _refusal(path: Path, begin: CRS, end: CRS, source: CRS, target: CRS) -> InputError:
    """Explain why heights cannot be converted from one datum to another."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            unavailable = TransformerGroup(begin, end, always_xy=True, allow_ballpark=False).unavailable_operations
        except ProjError:
            unavailable = []
    lacking = [
        [grid.short_name for grid in operation.grids if not grid.available]
        for operation in unavailable
        if all(grid.available or grid.url for grid in operation.grids)
    ]
    what = f"{path}: heights cannot be converted from {_label(source)} to {_label(target)}"
    if lacking:
        grids = min(lacking, key=len)
        commands = " and ".join(f"'pyproj sync --file {name}'" for name in grids)
        remedy = f"get it with {commands}, or leave --vertical-datum out"
        return InputError(f"{what}: PROJ lacks the grid {', '.join(grids)}, or it does not reach there; {remedy}")
    remedy = "give another --vertical-datum, or leave it out"
    return InputError(f"{what}: PROJ knows no transformation that is valid there; {remedy}")


def _label(crs: CRS) -> str:
    """Return the code and name of a datum."""
    if not crs.is_vertical:
        return f"heights above the ellipsoid of {crs.name}"
    code = crs.to_json_dict().get("id")
    return f"{crs.name} ({code['authority']}:{code['code']})" if code else crs.name
