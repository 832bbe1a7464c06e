"""Draws a picture as SVG."""

from __future__ import annotations

import html
import itertools
import math
from typing import Final

from osm2xodr.model import FloatArray
from osm2xodr.viewing.picture.contents import Picture
from osm2xodr.viewing.picture.details import PAPER, Polygon
from osm2xodr.viewing.picture.legend import Text, legend

# Points farther away than this many times the width and height are moved there: viewers fail on huge numbers.
_REACH: Final = 20


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
