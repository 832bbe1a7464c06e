"""Where a file's coordinates are on Earth."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pyproj import CRS, Transformer
from pyproj.exceptions import CRSError, ProjError

from osm2xodr.model import FloatArray, LocalFrame
from osm2xodr.opendrive.tables import Header
from osm2xodr.projection import WGS84, frame_of_proj


@dataclass(frozen=True, eq=False)
class Frame:
    """Converts inertial coordinates of a file to WGS 84 and back.

    The header's ``<offset>`` lies between the file's coordinates and those of its projection, as OpenDRIVE defines
    it: x, y are turned by its hdg, then moved by its x, y; z is moved by its z. Heights are those of the projection,
    whatever their datum.
    """

    crs: CRS  # Of the projection, in metres
    local: LocalFrame | None  # If the projection is that of a local frame
    offset: tuple[float, float, float, float]  # x, y, z (m) and hdg (rad) of the header

    @cached_property
    def _forward(self) -> Transformer:
        return Transformer.from_crs(self.crs, WGS84, always_xy=True)

    @cached_property
    def _back(self) -> Transformer:
        return Transformer.from_crs(WGS84, self.crs, always_xy=True)

    def to_geographic(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return longitude and latitude (degrees, WGS 84) of inertial x, y, m; not finite outside the projection."""
        return _transformed(self._forward, *self.to_projected(x, y))

    def to_projected(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return coordinates of the projection, east and north, m, of inertial x, y, m."""
        east, north, _, turn = self.offset
        cos, sin = math.cos(turn), math.sin(turn)
        return cos * x - sin * y + east, sin * x + cos * y + north

    def to_inertial(self, lon_deg: FloatArray, lat_deg: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return inertial x, y (m) of longitude and latitude, degrees, WGS 84; not finite outside the projection."""
        east, north, _, turn = self.offset
        cos, sin = math.cos(turn), math.sin(turn)
        u, v = _transformed(self._back, lon_deg, lat_deg)
        u, v = u - east, v - north
        # Places beyond the projection are infinite.
        with np.errstate(invalid="ignore"):
            return cos * u + sin * v, cos * v - sin * u

    def height(self, z: FloatArray) -> FloatArray:
        """Return heights of the projection for inertial z, m."""
        return z + self.offset[2]


def _transformed(transformer: Transformer, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return transformed coordinates."""
    if np.size(x) == 1:
        # pyproj converts an array of one element to a number, which numpy deprecates.
        one, other = transformer.transform(float(np.ravel(x)[0]), float(np.ravel(y)[0]))
        return np.full(np.shape(x), one), np.full(np.shape(y), other)
    first, second = transformer.transform(x, y)
    return np.asarray(first, np.float64), np.asarray(second, np.float64)


def frame_of(header: Header) -> tuple[Frame | None, str]:
    """Return the frame that a header describes, or None and a sentence that says why not."""
    text = header.geo_reference
    if not text:
        return None, "the file has no geoReference, so where it lies on Earth is unknown"
    offset = header.offset or (0.0, 0.0, 0.0, 0.0)
    if not all(math.isfinite(item) for item in offset):
        # The reader has reported the missing parts; guessing them would put the file somewhere else.
        return None, "the header's offset has numbers that are missing or unreadable"
    try:
        crs = CRS.from_user_input(text)
        if not crs.is_projected:
            return None, f"the geoReference {_short(text)} is not a projection in metres"
        if any(abs(axis.unit_conversion_factor - 1.0) > 1e-12 for axis in crs.axis_info[:2]):
            return None, f"the geoReference {_short(text)} is not in metres"
        Transformer.from_crs(crs, WGS84, always_xy=True)
    except (CRSError, ProjError) as error:
        return None, f"the geoReference {_short(text)} cannot be used ({' '.join(str(error).split())})"
    return Frame(crs, frame_of_proj(text), offset), ""


def _short(text: str) -> str:
    """Return a text short enough for a sentence."""
    line = " ".join(text.split())
    return repr(line if len(line) <= 80 else f"{line[:77]}...")
