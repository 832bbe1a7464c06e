"""Draws a picture as PNG with Pillow: larger than wanted, then averaged, which makes edges smooth.

Pillow is a wheel of a few megabytes that loads in a twentieth of a second; matplotlib brings ten packages and takes a
second.
"""

from __future__ import annotations

import io
from collections.abc import Iterable
from typing import Final

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from osm2xodr.model import FloatArray
from osm2xodr.viewing.colours import Pixels
from osm2xodr.viewing.picture.contents import Picture
from osm2xodr.viewing.picture.details import PAPER, Polygon, Shape
from osm2xodr.viewing.picture.legend import Text, legend

# Samples per pixel in either direction, fewer where there would be more samples in all than the second (450 MB).
_SAMPLES: Final = 3
_MOST_SAMPLES: Final = 150_000_000
# Colours of small pictures, which have few.
_SHADES: Final = 8
_ANCHORS: Final = {"start": "ls", "middle": "ms", "end": "rs"}


def draw_png(picture: Picture) -> bytes:
    """Return the picture as PNG; the same picture gives the same bytes."""
    whole = Image.new("RGB", (picture.width, picture.height), PAPER)
    whole.paste(_drawn(picture.shapes, picture.width, picture.map_height, picture.outline), (0, 0))
    _draw_legend(whole, picture)
    return _encoded(whole)


def shapes_as_png(shapes: Iterable[Shape], width: int, height: int) -> bytes:
    """Return shapes alone, in pixels, as PNG; the same shapes give the same bytes."""
    return _encoded(_drawn(shapes, width, height, 0.0).quantize(_SHADES))


def _drawn(shapes: Iterable[Shape], width: int, height: int, outline_width: float) -> Image.Image:
    """Draw shapes; `outline_width` is that of areas in their own colour, pixels."""
    n = _SAMPLES
    while n > 1 and n * n * width * height > _MOST_SAMPLES:
        n -= 1
    large = Image.new("RGB", (n * width, n * height), PAPER)
    pen = ImageDraw.Draw(large)
    outline = max(1, round(outline_width * n))
    for shape in shapes:
        corners = _corners(shape.corners, n)
        if len(corners) < 2:
            continue
        if isinstance(shape, Polygon):
            # Pillow's own outline of a polygon lies inside it.
            pen.polygon(corners, fill=shape.colour)
            if shape.outlined:
                pen.line([*corners, corners[0]], fill=shape.colour, width=outline)
        else:
            pen.line(corners, fill=shape.colour, width=max(1, round(shape.width * n)))
    return large.reduce(n)


def as_png(pixels: Pixels) -> bytes:
    """Return pixels, (rows, columns, 3), as PNG; the same pixels give the same bytes."""
    return _encoded(Image.fromarray(np.ascontiguousarray(pixels)))


def _encoded(image: Image.Image) -> bytes:
    """Return an image as PNG."""
    stream = io.BytesIO()
    image.save(stream, "PNG", optimize=True)
    return stream.getvalue()


def _draw_legend(image: Image.Image, picture: Picture) -> None:
    """Draw the band below the map, in place."""
    pen = ImageDraw.Draw(image)
    for item in legend(picture):
        if isinstance(item, Text):
            font = ImageFont.load_default(item.size)
            # Pillow's font has no bold letters: they are drawn twice, half a pixel apart.
            for shift in (0.0, 0.5) if item.bold else (0.0,):
                place = (item.x + shift, item.y)
                pen.text(place, item.text, fill=item.colour, font=font, anchor=_ANCHORS[item.anchor])
        else:
            pen.polygon(_corners(item.corners, 1), fill=item.colour)


def _corners(points: FloatArray, samples: int) -> list[tuple[float, float]]:
    """Return the corners whose place is known, in samples."""
    known = points[np.isfinite(points).all(axis=1)]
    return [(x, y) for x, y in (samples * known).tolist()]
