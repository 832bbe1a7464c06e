"""Where areas lie on the map of the page: outlines in the Mercator projection, in units of the drawing.

The Mercator projection is conformal, so small areas keep their shape at any latitude. Formula: J. P. Snyder, Map
Projections: A Working Manual, USGS 1987, eq. 7-1 and 7-2, on the sphere.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

Ring = tuple[tuple[float, float], ...]
Point = tuple[float, float]

# Radius of the sphere, m: the semi-major axis of WGS 84, as in web maps.
RADIUS: Final = 6378137.0
# Width of the drawing, units: numbers stay short, and fine enough for browsers, which keep seven digits.
WIDTH: Final = 1000.0
# Latitude at which the map ends, degrees: there a map of the whole earth is a square.
_LAST_LATITUDE: Final = 85.05
# Least width and height of what is drawn, m: a single area may be a point.
_LEAST_EXTENT: Final = 300.0
# Margin on each side as a share of the width.
_MARGIN: Final = 0.03
# Least and largest height of the drawing as a share of its width.
_LEAST_ASPECT: Final = 1 / 3
_LARGEST_ASPECT: Final = 3.0


@dataclass(frozen=True, slots=True)
class Shape:
    """An area on the map."""

    path: str  # Its outline, as data of an SVG path; empty for a point
    # Its middle, units to the right and down
    x: float
    y: float
    # Units
    width: float
    height: float


@dataclass(frozen=True, slots=True)
class Map:
    """Areas on the map."""

    shapes: tuple[Shape | None, ...]  # Of each area; None where its place is unknown
    # Of the drawing, units
    width: float
    height: float
    unit: float  # Metres of the sphere's equator per unit
    # Mercator's x and y of the drawing's left upper corner, m
    left: float
    top: float


def make_map(outlines: Sequence[Sequence[Ring]]) -> Map:
    """Return a map of outlines (rings of longitude and latitude, degrees).

    The map is cut on the far side of the areas, so that areas on both sides of the 180th meridian are neighbours.
    """
    joined = [[_joined(ring) for ring in rings if ring] for rings in outlines]
    cut = _cut([_middle([lon for ring in rings for lon, _ in ring]) for rings in joined if rings])
    placed = [[_projected(ring) for ring in _turned(rings, cut)] for rings in joined]
    xs = [x for rings in placed for ring in rings for x, _ in ring]
    ys = [y for rings in placed for ring in rings for _, y in ring]
    if not xs:
        return Map(tuple(None for _ in outlines), WIDTH, WIDTH / 2.0, 1.0, 0.0, 0.0)
    across, down = (max(max(values) - min(values), _LEAST_EXTENT) for values in (xs, ys))
    unit = across * (1.0 + 2.0 * _MARGIN) / WIDTH
    height = min(max(down + 2.0 * _MARGIN * across, _LEAST_ASPECT * across) / unit, _LARGEST_ASPECT * WIDTH)
    unit = max(unit, (down + 2.0 * _MARGIN * across) / height)
    left, top = _middle(xs) - unit * WIDTH / 2.0, _middle(ys) + unit * height / 2.0
    shapes = tuple(_shape(rings, left, top, unit) for rings in placed)
    return Map(shapes, WIDTH, height, unit, left, top)


def _joined(ring: Ring) -> list[Point]:
    """Return a ring that does not jump at the 180th meridian; one all round the earth stays as it is."""
    out = [ring[0]]
    for (before, _), (lon, lat) in pairwise(ring):
        step = lon - before
        out.append((out[-1][0] + (math.remainder(step, 360.0) if abs(step) < 360.0 else step), lat))
    return out


def _middle(values: Sequence[float]) -> float:
    return (min(values) + max(values)) / 2.0


def _cut(longitudes: Sequence[float]) -> float:
    """Return the meridian, degrees from -180, in the middle of the widest gap between longitudes."""
    sorted_deg = sorted(longitude % 360.0 for longitude in longitudes)
    if not sorted_deg:
        return -180.0
    gaps = [(b - a, a) for a, b in pairwise([*sorted_deg, sorted_deg[0] + 360.0])]
    width, begin = max(gaps, key=lambda gap: (gap[0], -gap[1]))
    return (begin + width / 2.0 + 180.0) % 360.0 - 180.0


def _turned(rings: list[list[Point]], cut: float) -> list[list[Point]]:
    """Return rings with longitudes within the 360 degrees from the cut on; rings of one area stay together."""
    if not rings:
        return []
    middle = _middle([lon for ring in rings for lon, _ in ring])
    turn = cut + (middle - cut) % 360.0 - middle
    return [[(lon + turn, lat) for lon, lat in ring] for ring in rings]


def _projected(ring: list[Point]) -> list[Point]:
    """Return x and y of the Mercator projection, m."""
    out = []
    for lon, lat in ring:
        y = math.asinh(math.tan(math.radians(min(max(lat, -_LAST_LATITUDE), _LAST_LATITUDE))))
        out.append((RADIUS * math.radians(lon), RADIUS * y))
    return out


def _shape(rings: list[list[Point]], left: float, top: float, unit: float) -> Shape | None:
    """Return the shape of an area; None without rings."""
    if not rings:
        return None
    drawn = [[((x - left) / unit, (top - y) / unit) for x, y in ring] for ring in rings]
    xs, ys = [x for ring in drawn for x, _ in ring], [y for ring in drawn for _, y in ring]
    path = "".join(
        "M" + "L".join(f"{number(x)} {number(y)}" for x, y in ring) + "Z" for ring in drawn if len(ring) > 2
    )
    return Shape(path, _middle(xs), _middle(ys), max(xs) - min(xs), max(ys) - min(ys))


def number(value: float) -> str:
    """Return a number of units, short."""
    text = f"{value:.3f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
