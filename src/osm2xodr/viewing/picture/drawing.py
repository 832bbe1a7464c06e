"""A picture as SVG, or as PNG with Pillow, and the band below it: title, legend, scale bar, north arrow.

PNG is drawn larger than wanted, then averaged, which makes edges smooth. Pillow is a wheel of a few megabytes that
loads in a twentieth of a second; matplotlib brings ten packages and takes a second. Thumbnails show reference lines
alone.
"""

from __future__ import annotations

import html
import io
import itertools
import math
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Final

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from osm2xodr.curves import starts
from osm2xodr.errors import InputError
from osm2xodr.furniture_shapes import DECAL_COLOUR
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.system import record
from osm2xodr.viewing.colours import Categories, Pixels, Ramp
from osm2xodr.viewing.picture.contents import CREDIT_LINE, CREDIT_SIZE, Picture
from osm2xodr.viewing.picture.details import HATCHING, INK, PAPER, SOFT, Line, Polygon, Shape

# Width of a letter as a share of its size: rather too wide, so that texts do not overlap.
_LETTER: Final = 0.6
# What red strokes across roads mean, and outlines of things that are flat on them.
_HATCHED: Final = "hatched: height not measured"
_DECALS: Final = "outlined: other objects"
# Boxes that a ramp is drawn with.
_STEPS: Final = 64

# Points farther away than this many times the width and height are moved there: viewers fail on huge numbers.
_REACH: Final = 20

# Samples per pixel in either direction, fewer where there would be more samples in all than the second (450 MB).
_SAMPLES: Final = 3
_MOST_SAMPLES: Final = 150_000_000
# Colours of small pictures, which have few.
_THUMBNAIL_SHADES: Final = 8
_ANCHORS: Final = {"start": "ls", "middle": "ms", "end": "rs"}

# Width and height, pixels, and the share of them that is margin on each side.
_THUMBNAIL_SIDE: Final = 80
_MARGIN: Final = 0.04
# Width of roads, and of roads through junctions, pixels.
_THUMBNAIL_WIDTHS: Final = (1.0, 0.7)
_NUMBER: Final = rb'="([-+.\deE]+)"'
_RECORD: Final = re.compile(
    rb"<geometry s" + _NUMBER + rb" x" + _NUMBER + rb" y" + _NUMBER + rb" hdg" + _NUMBER + rb" length" + _NUMBER
)
_ROAD: Final = re.compile(rb'<road [^>]*junction="([^"]*)"')


@record
class Text:
    """A line of text."""

    text: str
    # Of the anchor on the base line, and size of letters, pixels
    x: float
    y: float
    size: float
    anchor: str = "start"  # Or ``middle`` or ``end``
    colour: str = INK
    bold: bool = False


def legend(picture: Picture) -> list[Text | Polygon]:
    """Return the contents of the band in drawing order."""
    top, band, width = picture.map_height, picture.band, picture.width
    size = max(11.0, 0.27 * band)
    edge = 0.35 * band
    items: list[Text | Polygon] = [
        _box(0, top, width, picture.height - top, "#ffffff"),
        _box(0, top, width, max(1.0, 0.02 * band), SOFT),
    ]
    items += [
        Text(line, edge, top + band + CREDIT_LINE * (k + 0.75), CREDIT_SIZE, colour=SOFT)
        for k, line in enumerate(picture.credits)
    ]
    bar = picture.bar * picture.scale
    base = top + 0.72 * band
    right = width - edge
    items += [
        _box(right - bar, base - 0.1 * band, bar, 0.1 * band, INK),
        _box(right - bar / 2, base - 0.075 * band, bar / 2 - 0.025 * band, 0.05 * band, PAPER),
        Text(_length(picture.bar), right, top + 0.45 * band, size, "end"),
        Text("N", right - bar - 1.6 * size, top + 0.78 * band, size, "middle", bold=True),
        _north(right - bar - 1.6 * size, top + 0.14 * band, 0.36 * band),
    ]
    room = right - bar - 2.6 * size - edge
    title = Text(picture.mode.title, edge, top + 0.6 * band, size, bold=True)
    items.append(title)
    begin = edge + _LETTER * size * (len(title.text) + 2)
    notes = [(_HATCHED, HATCHING)] * picture.hatched + [(_DECALS, DECAL_COLOUR)] * picture.decals
    for text, colour in notes:
        room -= _LETTER * size * (len(text) + 2)
        items.append(Text(text, room + size, top + 0.6 * band, size, colour=colour))
    scale = picture.mode.scale
    if isinstance(scale, Ramp):
        return items + _ramp(scale, picture.mode.digits, begin, min(room - begin, 22 * size), top, band, size)
    return items + _kinds(scale, begin, room, top, band, size)


def _ramp(
    scale: Ramp, digits: int, left: float, width: float, top: float, band: float, size: float
) -> list[Text | Polygon]:
    """Return a strip of colours with numbers below it."""
    if width < 4 * size:
        return []
    shades = scale.colours(np.linspace(scale.low, scale.high, _STEPS)).tolist()
    step = width / _STEPS
    items: list[Text | Polygon] = [
        # Each is a little too wide, so that no gap shows; the next one covers the excess.
        _box(
            left + k * step,
            top + 0.2 * band,
            step * (1.0 if k == _STEPS - 1 else 1.5),
            0.25 * band,
            f"#{r:02x}{g:02x}{b:02x}",
        )
        for k, (r, g, b) in enumerate(shades)
    ]
    for share, anchor in ((0.0, "start"), (0.5, "middle"), (1.0, "end")):
        value = scale.low + share * (scale.high - scale.low)
        items.append(Text(f"{value:.{digits}f}", left + share * width, top + 0.84 * band, size, anchor, SOFT))
    return items


def _kinds(
    scale: Categories, left: float, right: float, top: float, band: float, size: float
) -> list[Text | Polygon]:
    """Return a box and a label for each kind, as many as there is room for."""
    items: list[Text | Polygon] = []
    for shade, label, present in zip(scale.colours, scale.labels, scale.present, strict=True):
        width = 1.6 * size + _LETTER * size * (len(label) + 2)
        if present and left + width < right:
            items.append(_box(left, top + 0.6 * band - 0.75 * size, 1.2 * size, 0.8 * size, shade))
            items.append(Text(label, left + 1.6 * size, top + 0.6 * band, size))
            left += width
    return items


def _north(x: float, y: float, height: float) -> Polygon:
    """Return a north arrow with its tip at x, y."""
    half = 0.3 * height
    return Polygon(np.array(((x, y), (x + half, y + height), (x, y + 0.75 * height), (x - half, y + height))), INK)


def _box(x: float, y: float, width: float, height: float, colour: str) -> Polygon:
    """Return a box."""
    return Polygon(np.array(((x, y), (x + width, y), (x + width, y + height), (x, y + height))), colour)


def _length(metres: float) -> str:
    """Return a length in words."""
    return f"{metres / 1000:g} km" if metres >= 1000 else f"{metres:g} m"


def draw_svg(picture: Picture) -> bytes:
    """Return the picture as SVG, UTF-8; the same picture gives the same bytes."""
    width, height = picture.width, picture.height
    font = "DejaVu Sans, Verdana, sans-serif"
    out = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}"',
        f'viewBox="0 0 {width} {height}" font-family="{font}">',
        f"<title>{_safe(picture.title)}</title>",
        f'<clipPath id="map"><rect width="{width}" height="{picture.map_height}"/></clipPath>',
        f'<rect width="{width}" height="{height}" fill="{PAPER}"/>',
        f'<g clip-path="url(#map)" stroke-width="{picture.outline:.2f}" stroke-linejoin="round">',
    ]
    # Without a stroke of their own colour the paper would show between neighbours.
    for shape in picture.shapes:
        path = _path(shape.corners, picture)
        if path and isinstance(shape, Polygon):
            stroke = shape.colour if shape.outlined else "none"
            out.append(f'<path d="{path}Z" fill="{shape.colour}" stroke="{stroke}"/>')
        elif path and not isinstance(shape, Polygon):
            stroke = f'stroke="{shape.colour}" stroke-width="{shape.width:.1f}"'
            out.append(f'<path d="{path}" fill="none" {stroke}/>')
    out.append("</g>")
    for item in legend(picture):
        if isinstance(item, Text):
            weight = ' font-weight="bold"' if item.bold else ""
            place = f'x="{item.x:.1f}" y="{item.y:.1f}" font-size="{item.size:.1f}" text-anchor="{item.anchor}"'
            out.append(f'<text {place} fill="{item.colour}"{weight}>{_safe(item.text)}</text>')
        else:
            corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in item.corners.tolist())
            out.append(f'<polygon points="{corners}" fill="{item.colour}"/>')
    out.append("</svg>\n")
    return "\n".join(out).encode("utf-8", "replace")


def _path(points: FloatArray, picture: Picture) -> str:
    """Return points as the data of a path, relative and in tenths of pixels; empty if fewer than two are known."""
    known = [(round(10 * x), round(10 * y)) for x, y in points.tolist() if math.isfinite(x) and math.isfinite(y)]
    far = 10 * _REACH * (picture.width + picture.map_height)
    known = [(max(-far, min(far, x)), max(-far, min(far, y))) for x, y in known]
    if len(known) < 2:
        return ""
    steps = [f"M{_tenths(known[0][0])} {_tenths(known[0][1])}l"]
    for (x0, y0), (x1, y1) in itertools.pairwise(known):
        steps.append(f"{_tenths(x1 - x0)} {_tenths(y1 - y0)} ")
    return "".join(steps).rstrip()


def _tenths(value: int) -> str:
    """Return tenths as a decimal number."""
    return f"{value / 10:.1f}".removesuffix(".0")


def _safe(text: str) -> str:
    """Return text fit for XML, without the characters that XML does not allow."""
    return html.escape("".join(letter for letter in text if letter.isprintable()))


def draw_png(picture: Picture) -> bytes:
    """Return the picture as PNG; the same picture gives the same bytes."""
    whole = Image.new("RGB", (picture.width, picture.height), PAPER)
    whole.paste(_drawn(picture.shapes, picture.width, picture.map_height, picture.outline), (0, 0))
    _draw_legend(whole, picture)
    return _encoded(whole)


def shapes_as_png(shapes: Iterable[Shape], width: int, height: int) -> bytes:
    """Return shapes alone, in pixels, as PNG; the same shapes give the same bytes."""
    return _encoded(_drawn(shapes, width, height, 0.0).quantize(_THUMBNAIL_SHADES))


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
    scale = _THUMBNAIL_SIDE * (1.0 - 2.0 * _MARGIN) / max(float((high - low).max()), 1.0)
    pixels = 0.5 * _THUMBNAIL_SIDE + scale * (corners - 0.5 * (low + high)) * (1.0, -1.0)
    # Roads lie over the ways through junctions.
    order = np.argsort(~through, kind="stable").tolist()
    begin, end = start[:-1].tolist(), start[1:].tolist()
    shapes = [
        Line(pixels[begin[k] : end[k]], SOFT if through[k] else INK, _THUMBNAIL_WIDTHS[int(through[k])])
        for k in order
    ]
    return shapes_as_png(shapes, _THUMBNAIL_SIDE, _THUMBNAIL_SIDE)


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
