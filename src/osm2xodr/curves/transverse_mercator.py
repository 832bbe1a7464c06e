"""The transverse Mercator projection of the local frame, with the same last digit on every machine.

Krüger's series to the sixth order of the third flattening (Karney 2011, Transverse Mercator with an accuracy of a few
nanometers, equations 35 and 36; for latitudes Karney 2023, On auxiliary latitudes): within 1000 km of the origin they
are exact to 1e-8 m, and PROJ's `tmerc`, which has the same, agrees to that.
"""

from __future__ import annotations

from functools import cache
from typing import Final

import numpy as np

from osm2xodr.curves.exponentials import exp, log
from osm2xodr.curves.trigonometry import arctan2, cosine, hypot, sine
from osm2xodr.model import FloatArray

# WGS 84: semi-major axis, m, and flattening.
_A: Final = 6378137.0
_F: Final = 1.0 / 298.257223563
_N: Final = _F / (2.0 - _F)
# Radius of the sphere whose meridians are as long, m.
_RADIUS: Final = _A / (1.0 + _N) * (1.0 + _N * _N * (1.0 / 4.0 + _N * _N * (1.0 / 64.0 + _N * _N / 256.0)))
# As far as this from the central meridian, in units of the radius, the series are of use: 150 degrees.
_FARTHEST: Final = 2.6
_DEGREE: Final = np.pi / 180.0

# Coefficients of the sines of 2, 4, … 12 times an angle: each a polynomial of the third flattening, whose first power
# is the number of the sine.
_TO_CONFORMAL: Final = (
    (-2.0, 2 / 3, 4 / 3, -82 / 45, 32 / 45, 4642 / 4725),
    (5 / 3, -16 / 15, -13 / 9, 904 / 315, -1522 / 945),
    (-26 / 15, 34 / 21, 8 / 5, -12686 / 2835),
    (1237 / 630, -12 / 5, -24832 / 14175),
    (-734 / 315, 109598 / 31185),
    (444337 / 155925,),
)
_FROM_CONFORMAL: Final = (
    (2.0, -2 / 3, -2.0, 116 / 45, 26 / 45, -2854 / 675),
    (7 / 3, -8 / 5, -227 / 45, 2704 / 315, 2323 / 945),
    (56 / 15, -136 / 35, -1262 / 105, 73814 / 2835),
    (4279 / 630, -332 / 35, -399572 / 14175),
    (4174 / 315, -144838 / 6237),
    (601676 / 22275,),
)
_TO_PLANE: Final = (
    (1 / 2, -2 / 3, 5 / 16, 41 / 180, -127 / 288, 7891 / 37800),
    (13 / 48, -3 / 5, 557 / 1440, 281 / 630, -1983433 / 1935360),
    (61 / 240, -103 / 140, 15061 / 26880, 167603 / 181440),
    (49561 / 161280, -179 / 168, 6601661 / 7257600),
    (34729 / 80640, -3418889 / 1995840),
    (212378941 / 319334400,),
)
_FROM_PLANE: Final = (
    (-1 / 2, 2 / 3, -37 / 96, 1 / 360, 81 / 512, -96199 / 604800),
    (-1 / 48, -1 / 15, 437 / 1440, -46 / 105, 1118711 / 3870720),
    (-17 / 480, 37 / 840, 209 / 4480, -5569 / 90720),
    (-4397 / 161280, 11 / 504, 830251 / 7257600),
    (-4583 / 161280, 108847 / 3991680),
    (-20648693 / 638668800,),
)


def to_mercator(
    lon_deg: FloatArray, lat_deg: FloatArray, lon_0_deg: float, lat_0_deg: float
) -> tuple[FloatArray, FloatArray]:
    """Return x (east) and y (north), m, of places, degrees; both infinite where the projection ends."""
    lat = np.clip(lat_deg, -90.0, 90.0) * _DEGREE
    off = lon_deg - lon_0_deg
    lon = (off - 360.0 * np.rint(off / 360.0)) * _DEGREE
    lat = lat + _series(_TO_CONFORMAL, lat, np.zeros_like(lat))[0]
    across, along = cosine(lat) * sine(lon), cosine(lat) * cosine(lon)
    with np.errstate(divide="ignore", invalid="ignore"):
        xi, eta = arctan2(sine(lat), along), 0.5 * log((1.0 + across) / (1.0 - across))
    good = np.abs(eta) < _FARTHEST
    more_xi, more_eta = _series(_TO_PLANE, xi, np.where(good, eta, 0.0))
    x, y = _RADIUS * (eta + more_eta), _RADIUS * (xi + more_xi) - _of_origin(lat_0_deg)
    return np.where(good, x, np.inf), np.where(good, y, np.inf)


def from_mercator(x: FloatArray, y: FloatArray, lon_0_deg: float, lat_0_deg: float) -> tuple[FloatArray, FloatArray]:
    """Return longitude and latitude, degrees, of places, m; both infinite where the projection ends."""
    xi, eta = (y + _of_origin(lat_0_deg)) / _RADIUS, x / _RADIUS
    good = np.abs(eta) < _FARTHEST
    eta = np.where(good, eta, 0.0)
    more_xi, more_eta = _series(_FROM_PLANE, xi, eta)
    xi, up = xi + more_xi, exp(eta + more_eta)
    across = 0.5 * (up - 1.0 / up)
    lat = arctan2(sine(xi), hypot(across, cosine(xi)))
    lat = lat + _series(_FROM_CONFORMAL, lat, np.zeros_like(lat))[0]
    lon = lon_0_deg + arctan2(across, cosine(xi)) / _DEGREE
    lon = lon - 360.0 * np.rint(lon / 360.0)
    return np.where(good, lon, np.inf), np.where(good, lat / _DEGREE, np.inf)


@cache
def _of_origin(lat_0_deg: float) -> float:
    """Return how far north of the equator a latitude lies on its meridian, m."""
    lat = np.array([lat_0_deg * _DEGREE])
    lat = lat + _series(_TO_CONFORMAL, lat, np.zeros(1))[0]
    return _RADIUS * float((lat + _series(_TO_PLANE, lat, np.zeros(1))[0])[0])


def _series(terms: tuple[tuple[float, ...], ...], xi: FloatArray, eta: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the real and imaginary parts of a sum of sines of 2, 4, … times the complex angles xi + i eta."""
    sin, cos, up = sine(2.0 * xi), cosine(2.0 * xi), exp(2.0 * eta)
    wide: FloatArray = 0.5 * (up + 1.0 / up)
    high: FloatArray = 0.5 * (up - 1.0 / up)
    sin_k, cos_k, wide_k, high_k = sin, cos, wide, high
    real, imaginary = np.zeros_like(sin), np.zeros_like(sin)
    for number, polynomial in enumerate(terms, 1):
        value = 0.0
        for coefficient in reversed(polynomial):
            value = value * _N + coefficient
        for _ in range(number):
            value *= _N
        real += value * sin_k * wide_k
        imaginary += value * cos_k * high_k
        sin_k, cos_k = sin_k * cos + cos_k * sin, cos_k * cos - sin_k * sin
        wide_k, high_k = wide_k * wide + high_k * high, high_k * wide + wide_k * high
    return real, imaginary
