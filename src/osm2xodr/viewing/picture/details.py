"""What a picture shows at large scales: road marks, paint on roads, and what stands beside them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from osm2xodr.furniture_shapes import (
    DASH,
    DASH_GAP,
    DRAWN_MARK_WIDTH,
    LARGEST_SYMBOL,
    SMALLEST_SYMBOL,
    SYMBOL,
    Corners,
    Disc,
    Form,
    PlacedObject,
    PlacedSignal,
    Stroke,
    dashed,
    disc,
    face_of,
    forms_of,
    in_layers,
    mark_pattern,
    placed_objects,
    placed_signals,
)
from osm2xodr.model import FloatArray
from osm2xodr.opendrive import OpenDrive
from osm2xodr.viewing.picture.shapes import Line, Polygon, Shape

_Pixels = Callable[[float, float], tuple[float, float]]
# Width of lines at least, pixels.
_LEAST_WIDTH = 0.5


def mark_lines(grid: FloatArray, kinds: Sequence[Sequence[Any]], scale: float) -> list[Line]:
    """Return the marks on the borders of a strip, of which `grid` gives the places, (stations, borders, 2), pixels.

    `kinds` are name, style and colour of each border's mark, as of `border_marks`; `scale` is pixels per metre.
    """
    out: list[Line] = []
    width = max(DRAWN_MARK_WIDTH * scale, _LEAST_WIDTH)
    for k, (name, style, colour) in enumerate(kinds):
        # Marks on the outermost borders are moved inwards, or they could not be seen on the paper.
        inward = 0.5 * width * ((k == 0) - (k == len(kinds) - 1))
        line = _moved(grid[:, k], inward)
        for lateral, broken, shade in mark_pattern(name, style, colour):
            moved = _moved(line, lateral * scale)
            pieces = dashed(moved, DASH * scale, DASH_GAP * scale) if broken else [moved]
            out += [Line(piece, shade, width) for piece in pieces]
    return out


def furniture_shapes(
    file: OpenDrive, roads: frozenset[int], pixels: _Pixels, scale: float
) -> Iterator[tuple[PlacedObject | PlacedSignal, list[Shape]]]:
    """Yield the objects and signals of some roads with their shapes, the lowest layer first.

    `pixels` converts x, y (m) to pixels, of which there are `scale` per metre.
    """
    for thing in in_layers(placed_objects(file, roads)):
        yield thing, [_shape(form, pixels, scale) for form in forms_of(thing)]
    size = min(max(SYMBOL * scale, SMALLEST_SYMBOL), LARGEST_SYMBOL)
    for signal in placed_signals(file, roads):
        x, y = pixels(signal.x, signal.y)
        yield (
            signal,
            [
                Polygon(np.array([(x + size * a, y + size * b) for a, b in corners]), colour)
                for corners, colour in face_of(signal)
            ],
        )


def _shape(form: Form, pixels: _Pixels, scale: float) -> Shape:
    """Return a form in pixels."""
    if isinstance(form, Disc):
        x, y = pixels(form.x, form.y)
        radius = max(form.radius * scale, form.least)
        return Polygon(np.array([(x + u, y + v) for u, v in disc(radius)]), form.colour)
    if isinstance(form, Stroke):
        return Line(_placed(form.corners, pixels), form.colour, max(form.width * scale, _LEAST_WIDTH))
    return Polygon(_placed(form.corners, pixels), form.colour, outlined=False)


def _placed(corners: Corners, pixels: _Pixels) -> FloatArray:
    """Return corners in pixels."""
    return np.array([pixels(*corner) for corner in corners])


def _moved(line: FloatArray, lateral: float) -> FloatArray:
    """Move a line sideways, pixels."""
    if not lateral or len(line) < 2:
        return line
    along = np.gradient(line, axis=0)
    length = np.hypot(along[:, 0], along[:, 1])
    length[length == 0.0] = 1.0
    return np.asarray(line + lateral * np.stack((-along[:, 1], along[:, 0]), axis=1) / length[:, None])
