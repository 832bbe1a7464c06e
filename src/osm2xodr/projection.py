"""The local frame: a transverse Mercator projection centred on the data.

With scale 1 it keeps lengths true to 1 ppm within 10 km, and coordinates small, which readers with coordinates of
single precision need; CARLA 0.9.16 understands no other kind of georeference.
"""

from __future__ import annotations

import contextlib
import functools
import re
from collections.abc import Hashable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from osm2xodr.curves import from_mercator, to_mercator
from osm2xodr.model import LocalFrame

if TYPE_CHECKING:
    from pyproj import Transformer

WGS84 = "EPSG:4326"


def make_frame(lat_0_deg: float, lon_0_deg: float) -> LocalFrame:
    """Return the local frame with its origin at a place, degrees, WGS 84.

    The origin is rounded to 5 decimals (about 1 m), so that the georeference states it exactly.
    """
    lat, lon = round(lat_0_deg, 5), round(lon_0_deg, 5)
    return LocalFrame(_proj(lat, lon), lat, lon)


def frame_of_proj(proj: str) -> LocalFrame | None:
    """Return the local frame that PROJ's words for a projection describe as `make_frame` does, None for others."""
    origin = re.search(r"\+lat_0=(-?\d+\.\d{5}) \+lon_0=(-?\d+\.\d{5}) ", proj)
    frame = make_frame(float(origin[1]), float(origin[2])) if origin else None
    return frame if frame is not None and frame.proj == proj else None


def _proj(lat_0_deg: float, lon_0_deg: float) -> str:
    origin = f"+lat_0={lat_0_deg:.5f} +lon_0={lon_0_deg:.5f}"
    return f"+proj=tmerc {origin} +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +vunits=m"


def to_local(
    frame: LocalFrame, lon_deg: npt.ArrayLike, lat_deg: npt.ArrayLike
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Project longitude and latitude (degrees, WGS 84) to local x (east) and y (north), m."""
    lon, lat = np.asarray(lon_deg, np.float64), np.asarray(lat_deg, np.float64)
    if frame.proj == _proj(frame.lat_0_deg, frame.lon_0_deg):
        return to_mercator(lon, lat, frame.lon_0_deg, frame.lat_0_deg)
    x, y = _transformer(WGS84, frame.proj).transform(lon, lat)
    return np.asarray(x, np.float64), np.asarray(y, np.float64)


def to_geographic(
    frame: LocalFrame, x: npt.ArrayLike, y: npt.ArrayLike
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Take local x, y (m) back to longitude and latitude (degrees, WGS 84)."""
    x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
    if frame.proj == _proj(frame.lat_0_deg, frame.lon_0_deg):
        return from_mercator(x, y, frame.lon_0_deg, frame.lat_0_deg)
    lon, lat = _transformer(frame.proj, WGS84).transform(x, y)
    return np.asarray(lon, np.float64), np.asarray(lat, np.float64)


def to_utm(
    lon_deg: npt.ArrayLike, lat_deg: npt.ArrayLike, zone: int, *, south: bool
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Project longitude and latitude (degrees, WGS 84) to easting and northing (m) of a zone of UTM."""
    code = (32700 if south else 32600) + zone
    lon, lat = np.asarray(lon_deg, np.float64), np.asarray(lat_deg, np.float64)
    x, y = _transformer(WGS84, f"EPSG:{code}").transform(lon, lat)
    return np.asarray(x, np.float64), np.asarray(y, np.float64)


def bounds_deg(lon_deg: npt.ArrayLike, lat_deg: npt.ArrayLike) -> tuple[float, float, float, float]:
    """Return west, south, east, north of points, degrees; east is above 180 where they lie on both sides of it."""
    lon, lat = np.asarray(lon_deg, np.float64), np.asarray(lat_deg, np.float64)
    if lon.max() - lon.min() > 180.0:
        lon = np.where(lon < 0.0, lon + 360.0, lon)
    return float(lon.min()), float(lat.min()), float(lon.max()), float(lat.max())


def transformer_to(frame: LocalFrame, crs: object) -> Transformer:
    """Return the transformation from local x, y (m) to x, y of another CRS, in its own units."""
    return _transformer(frame.proj, crs)


def transformer_from(crs: object) -> Transformer:
    """Return the transformation from x, y of another CRS, in its own units, to longitude and latitude (WGS 84)."""
    return _transformer(crs, WGS84)


@contextlib.contextmanager
def offline() -> Iterator[None]:
    """Keep PROJ off the network whatever its settings say: a grid that is absent must not be fetched."""
    # Here as below. The types of some versions of pyproj do not know these functions.
    from pyproj import network

    switch: Any = network
    was = switch.is_network_enabled()
    switch.set_network_enabled(False)
    try:
        yield
    finally:
        switch.set_network_enabled(was)


@functools.lru_cache(maxsize=32)
def _transformer(source: Hashable, target: Hashable) -> Transformer:
    # PROJ takes a while to import, and to look through its database for the ways from a national CRS to others.
    from pyproj import Transformer

    return Transformer.from_crs(source, target, always_xy=True)
