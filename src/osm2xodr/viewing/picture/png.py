"""Pictures as PNG with Pillow: drawn larger than wanted, then averaged, which makes edges smooth; and small ones.

Pillow is a wheel of a few megabytes that loads in a twentieth of a second; matplotlib brings ten packages and takes a
second. Small pictures of a road network show its reference lines alone.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Final

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from osm2xodr.curves import starts
from osm2xodr.errors import InputError
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.viewing.colours import Pixels
from osm2xodr.viewing.picture.contents import Picture
from osm2xodr.viewing.picture.details import INK, PAPER, SOFT, Line, Polygon, Shape
from osm2xodr.viewing.picture.legend import Text, legend

# Samples per pixel in either direction, fewer where there would be more samples in all than the second (450 MB).
_SAMPLES: Final = 3
_MOST_SAMPLES: Final = 150_000_000
# Colours of small pictures, which have few.
_SHADES: Final = 8
_ANCHORS: Final = {"start": "ls", "middle": "ms", "end": "rs"}

# Width and height, pixels, and the share of them that is margin on each side.
_SIDE: Final = 80
_MARGIN: Final = 0.04
# Width of roads, and of roads through junctions, pixels.
_WIDTHS: Final = (1.0, 0.7)
_NUMBER: Final = rb'="([-+.\deE]+)"'
_RECORD: Final = re.compile(
    rb"<geometry s" + _NUMBER + rb" x" + _NUMBER + rb" y" + _NUMBER + rb" hdg" + _NUMBER + rb" length" + _NUMBER
)
_ROAD: Final = re.compile(rb'<road [^>]*junction="([^"]*)"')


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


def draw_thumbnail(xodr: Path) -> bytes:
    """Return a picture of a file that osm2xodr wrote, as PNG; the same file gives the same bytes.

    Raises `InputError` if it cannot be read, or has no roads.
    """
    try:
        text = xodr.read_bytes()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(f"{xodr} cannot be read: {reason}; check the path") from error
    through, corners, start = _lines(text)
    if not len(through):
        raise InputError(f"{xodr} has no roads that can be drawn; give a file that osm2xodr wrote")
    low, high = corners.min(axis=0), corners.max(axis=0)
    scale = _SIDE * (1.0 - 2.0 * _MARGIN) / max(float((high - low).max()), 1.0)
    pixels = 0.5 * _SIDE + scale * (corners - 0.5 * (low + high)) * (1.0, -1.0)
    # Roads lie over the ways through junctions.
    order = np.argsort(~through, kind="stable").tolist()
    begin, end = start[:-1].tolist(), start[1:].tolist()
    shapes = [Line(pixels[begin[k] : end[k]], SOFT if through[k] else INK, _WIDTHS[int(through[k])]) for k in order]
    return shapes_as_png(shapes, _SIDE, _SIDE)


def _lines(text: bytes) -> tuple[BoolArray, FloatArray, IntArray]:
    """Return whether each road leads through a junction, (roads,), and the corners of its reference line.

    These are (n, 2), m, and where those of each road begin, and the last ends, (roads + 1,).
    """
    roads, records = list(_ROAD.finditer(text)), list(_RECORD.finditer(text))
    values = np.array([found.groups() for found in records], np.float64).reshape(-1, 5)
    at = np.array([found.start() for found in records], np.int64)
    count = np.diff(np.searchsorted(at, [*(road.start() for road in roads), len(text)]))
    drawn = np.flatnonzero(count)
    start = starts(count[drawn] + 1)
    # Each line has the end of its last record as well.
    x, y, heading, length = values[np.cumsum(count[drawn]) - 1, 1:].T
    corners = np.empty((start[-1], 2))
    ends = np.zeros(len(corners), bool)
    ends[start[1:] - 1] = True
    corners[~ends] = values[:, 1:3]
    corners[ends] = np.column_stack([x + length * np.cos(heading), y + length * np.sin(heading)])
    through = np.array([road[1] != b"-1" for road in roads], bool)
    return through[drawn], corners, start
