"""Where nodes are: latitude and longitude, and the coordinates that Autoware reads beside them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray
from osm2xodr.opendrive import OpenDrive, frame_of
from osm2xodr.projection import make_frame, to_geographic, to_utm

LOCAL: Final = "local"
MGRS: Final = "mgrs"
PROJECTORS: Final = (LOCAL, MGRS)

# Squares of MGRS, m, and the letters of its bands, columns and rows: NGA.STND.0037, Universal Grids and Grid
# Reference Systems, 2014, chapter 3.
_SQUARE: Final = 100_000.0
_BANDS: Final = "CDEFGHJKLMNPQRSTUVWX"
_COLUMNS: Final = ("STUVWXYZ", "ABCDEFGH", "JKLMNPQR")
_ROWS: Final = "ABCDEFGHJKLMNPQRSTUV"
_BAND_HEIGHT_DEG: Final = 8.0
_ZONE_WIDTH_DEG: Final = 6.0
_SOUTHERNMOST_DEG: Final = -80.0
_NORTHERNMOST_DEG: Final = 84.0
# Digits of each half of a grid reference: to 1 m.
_DIGITS: Final = 5


@dataclass(frozen=True)
class Places:
    """Nodes on Earth and in the coordinates of Autoware."""

    # (n,) Degrees, WGS 84
    lat: FloatArray
    lon: FloatArray
    height: FloatArray  # (n,) m, in whatever datum the file was made with
    # (n,) `LOCAL`: those of the file; `MGRS`: east and north in the square, m
    local_x: FloatArray
    local_y: FloatArray
    square: str  # Of MGRS; empty without


def place(file: OpenDrive, points: FloatArray, projector: str) -> tuple[Places, str]:
    """Return where points (n, 3) of a file are, and a sentence if that is not known; then they lie around 0° N, 0° E.

    All count from the square of MGRS that their middle lies in. `InputError` if MGRS has no place for them.
    """
    x, y, z = points.T
    frame, reason = frame_of(file.header)
    if frame is None:
        if projector == MGRS:
            raise InputError(f"{file.path}: {reason}, and MGRS counts from there; leave the projector out, or local")
        lon, lat = to_geographic(make_frame(0.0, 0.0), x, y)
        return Places(lat, lon, z, x, y, ""), f"{reason}; latitude and longitude count from 0, 0"
    lon, lat = frame.to_geographic(x, y)
    height = frame.height(z)
    if not np.isfinite(lon + lat).all():
        raise InputError(f"{file.path}: some lanes lie outside the projection of the file; osm2xodr check lists them")
    if projector != MGRS or not len(x):
        return Places(lat, lon, height, x, y, ""), ""
    east, north, square = _grid(lat, lon)
    return Places(lat, lon, height, east, north, square), ""


def projector_info(projector: str, square: str) -> str:
    """Return Autoware's map_projector_info.yaml.

    Heights of elevation models are mostly above the geoid, which Autoware knows as EGM2008.
    """
    if projector == LOCAL:
        return "projector_type: Local\n"
    return f"projector_type: MGRS\nvertical_datum: EGM2008\nmgrs_grid: {square}\n"


def grid_references(places: Places) -> list[str]:
    """Return the grid reference of each node, to 1 m."""
    most = 10**_DIGITS - 1
    halves = [np.clip(column, 0, most).astype(np.int64) for column in (places.local_x, places.local_y)]
    return [f"{places.square}{x:0{_DIGITS}d}{y:0{_DIGITS}d}" for x, y in zip(*halves, strict=True)]


def _grid(lat: FloatArray, lon: FloatArray) -> tuple[FloatArray, FloatArray, str]:
    """Return east and north (m) from the corner of the square that the middle of places lies in, and its name."""
    lat_0, lon_0 = float(lat.min() + lat.max()) / 2, float(lon.min() + lon.max()) / 2
    if not _SOUTHERNMOST_DEG <= lat_0 < _NORTHERNMOST_DEG:
        raise InputError(f"MGRS in zones of UTM ends at 80° S and 84° N, and the map lies at {lat_0:.2f}; use local")
    zone = _zone(lat_0, lon_0)
    band = _BANDS[min(int((lat_0 - _SOUTHERNMOST_DEG) // _BAND_HEIGHT_DEG), len(_BANDS) - 1)]
    east, north = to_utm(lon, lat, zone, south=lat_0 < 0)
    column = math.floor((east.min() + east.max()) / 2 / _SQUARE)
    row = math.floor((north.min() + north.max()) / 2 / _SQUARE)
    # Rows of even zones begin five letters later.
    letters = _COLUMNS[zone % 3][column - 1] + _ROWS[(row + (0 if zone % 2 else 5)) % len(_ROWS)]
    return east - column * _SQUARE, north - row * _SQUARE, f"{zone}{band}{letters}"


def _zone(lat: float, lon: float) -> int:
    """Return the zone of UTM of a place, degrees; Norway and Svalbard have wider ones."""
    zone = int((lon + 180.0) % 360.0 // _ZONE_WIDTH_DEG) + 1
    if 56.0 <= lat < 64.0 and 3.0 <= lon < 12.0:
        return 32
    if lat >= 72.0 and 0.0 <= lon < 42.0:
        return 31 if lon < 9.0 else 33 if lon < 21.0 else 35 if lon < 33.0 else 37
    return zone
