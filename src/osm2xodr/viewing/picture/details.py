"""What a picture shows at large scales: road marks, paint on roads, and what stands beside them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, Final

import numpy as np

from osm2xodr.model import FloatArray
from osm2xodr.opendrive import OpenDrive
from osm2xodr.viewing.colours import colours_by_name
from osm2xodr.viewing.furniture import PlacedObject, placed_objects, placed_signals
from osm2xodr.viewing.picture.shapes import (
    WHITE,
    Line,
    Polygon,
    Shape,
    arrow,
    bars,
    disc,
    light_symbol,
    sign_symbol,
)

# Pixels per metre from which marks, and objects and signals are drawn.
MARKS_FROM: Final = 3.0
FURNITURE_FROM: Final = 2.0

# Road marks, m: width, dash and gap, distance of each line of a double mark from the middle.
_WIDTH: Final = 0.15
_DASH: Final = 3.0
_GAP: Final = 6.0
_DOUBLE: Final = 0.14
_BROKEN: Final = 2
# Dashes of one line at most; damaged files have longer ones, which are drawn solid.
_MOST_DASHES: Final = 20_000
_KERB_COLOUR: Final = "#8c8a84"
_UNPAINTED: Final = frozenset({"", "none", "curb", "grass"})
_PAINT: Final = WHITE
# Colours of objects by type, and of all others.
_FILLS: Final = colours_by_name(
    {
        "#c4c0b4": "trafficIsland",
        "#c98f2b": "patch roadSurface",
        "#8d6e63": "obstacle",
        "#43484d": "barrier railing gantry soundBarrier",
        "#7ba268": "vegetation",
        "#cbc6bd": "building",
        "#4f7fbf": "parkingSpace",
    }
)
_OTHER_FILL: Final = "#b9b4aa"
# Objects drawn as discs: colour, radius where none is stated, m, least radius, pixels.
_DISCS: Final = {
    "tree": ("#6f9a5d", 1.5, 2.0),
    "streetLamp": ("#e0a800", 0.3, 2.0),
    "pole": ("#555b61", 0.2, 1.5),
}
# Layers in which objects cover each other by type, and that of all others.
_LAYERS: Final = {
    "patch": 0,
    "roadSurface": 0,
    "parkingSpace": 0,
    "crosswalk": 1,
    "roadMark": 1,
    "tree": 4,
    "streetLamp": 5,
    "pole": 5,
}
_OTHER_LAYER: Final = 2
# Size of a symbol, m, and its limits, pixels.
_SYMBOL: Final = 0.9
_SMALLEST_SYMBOL: Final = 5.0
_LARGEST_SYMBOL: Final = 16.0

_Pixels = Callable[[float, float], tuple[float, float]]


def mark_lines(grid: FloatArray, kinds: Sequence[Sequence[Any]], scale: float) -> list[Line]:
    """Return the marks on the borders of a strip, of which `grid` gives the places, (stations, borders, 2), pixels.

    `kinds` are name, style and colour of each border's mark, as of `border_marks`; `scale` is pixels per metre.
    """
    out: list[Line] = []
    width = max(_WIDTH * scale, 0.5)
    for k, (name, style, colour) in enumerate(kinds):
        # Marks on the outermost borders are moved inwards, or they could not be seen on the paper.
        inward = 0.5 * width * ((k == 0) - (k == len(kinds) - 1))
        line = _moved(grid[:, k], inward)
        if name == "curb":
            out.append(Line(line, _KERB_COLOUR, width))
        if name in _UNPAINTED or not style:
            continue
        words = name.split()
        sides = (-_DOUBLE, _DOUBLE) if len(words) == 2 and name != "botts dots" else (0.0,)
        styles = [_BROKEN if word == "broken" else 1 for word in words] if len(sides) > 1 else [style]
        for side, own in zip(sides, styles, strict=True):
            moved = _moved(line, side * scale)
            pieces = _dashed(moved, _DASH * scale, _GAP * scale) if own == _BROKEN else [moved]
            out += [Line(piece, colour, width) for piece in pieces]
    return out


def furniture_shapes(
    file: OpenDrive, roads: frozenset[int], pixels: _Pixels, scale: float
) -> Iterator[tuple[tuple[float, float, float], list[Shape]]]:
    """Yield x, y, z (m) and the shapes of the objects and signals of some roads, the lowest layer first.

    `pixels` converts x, y (m) to pixels, of which there are `scale` per metre.
    """
    things = placed_objects(file, roads)
    things.sort(key=lambda thing: _LAYERS.get(_type(thing), _OTHER_LAYER))
    for thing in things:
        yield (thing.x, thing.y, thing.z), list(_object(thing, pixels, scale))
    size = min(max(_SYMBOL * scale, _SMALLEST_SYMBOL), _LARGEST_SYMBOL)
    light = light_symbol()
    for signal in placed_signals(file, roads):
        attributes = signal.item.attributes
        face = light if signal.is_light else sign_symbol(attributes.get("type", ""), attributes.get("name", ""))
        x, y = pixels(signal.x, signal.y)
        yield (
            (signal.x, signal.y, signal.z),
            [
                Polygon(np.array([(x + size * a, y + size * b) for a, b in corners]), colour)
                for corners, colour in face
            ],
        )


def _type(thing: PlacedObject) -> str:
    """Return the type of an object."""
    return thing.item.attributes.get("type", "")


def _object(thing: PlacedObject, pixels: _Pixels, scale: float) -> Iterator[Shape]:
    """Yield the shapes of one object."""
    kind, subtype = _type(thing), thing.item.attributes.get("subtype", "")
    if kind in _DISCS:
        colour, radius, least = _DISCS[kind]
        own = thing.item.radius if thing.item.radius > 0.0 else radius
        x, y = pixels(thing.x, thing.y)
        yield _disc(x, y, max(own * scale, least), colour)
    elif len(thing.corners) < 3:
        x, y = pixels(thing.x, thing.y)
        yield _disc(x, y, max(0.3 * scale, 1.5), _OTHER_FILL)
    elif kind == "crosswalk":
        yield from _crosswalk(thing, subtype, pixels, scale)
    elif kind == "roadMark":
        yield from _painted(thing, subtype, pixels)
    else:
        yield _area(thing.corners, _FILLS.get(kind, _OTHER_FILL), pixels)


def _crosswalk(thing: PlacedObject, subtype: str, pixels: _Pixels, scale: float) -> Iterator[Shape]:
    """Yield the bars of a crosswalk, or a dashed outline if it has no bars."""
    corners = _open(thing.corners)
    if subtype == "virtual" or len(corners) != 4:
        around = np.array([pixels(*corner) for corner in (*corners, corners[0])])
        for piece in _dashed(around, 0.5 * scale, 0.5 * scale):
            yield Line(piece, _PAINT, max(0.1 * scale, 0.5))
        return
    for bar in bars(corners):
        yield _area(bar, _PAINT, pixels)


def _painted(thing: PlacedObject, subtype: str, pixels: _Pixels) -> Iterator[Shape]:
    """Yield the paint on a lane: arrows, stop lines, give-way lines."""
    corners = _open(thing.corners)
    if subtype.startswith("arrow"):
        cos, sin = math.cos(thing.heading), math.sin(thing.heading)
        for part in arrow(subtype, thing.item.length):
            turned = [(thing.x + cos * u - sin * v, thing.y + sin * u + cos * v) for u, v in part]
            yield _area(turned, _PAINT, pixels)
    elif "giveWay" in subtype and len(corners) == 4:
        for piece in bars(corners):
            yield _area(piece, _PAINT, pixels)
    else:
        yield _area(corners, _PAINT, pixels)


def _open(corners: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return corners without a repetition of the first at the end."""
    out = list(corners)
    return out[:-1] if len(out) > 3 and math.dist(out[0], out[-1]) < 1e-6 else out


def _area(corners: Iterable[tuple[float, float]], colour: str, pixels: _Pixels) -> Polygon:
    """Return an area with corners at x, y, m."""
    return Polygon(np.array([pixels(*corner) for corner in corners]), colour, outlined=False)


def _disc(x: float, y: float, radius: float, colour: str) -> Polygon:
    """Return a disc; all in pixels."""
    return Polygon(np.array([(x + u, y + v) for u, v in disc(radius)]), colour)


def _moved(line: FloatArray, aside: float) -> FloatArray:
    """Move a line sideways, pixels."""
    if not aside or len(line) < 2:
        return line
    along = np.gradient(line, axis=0)
    length = np.hypot(along[:, 0], along[:, 1])
    length[length == 0.0] = 1.0
    return np.asarray(line + aside * np.stack((-along[:, 1], along[:, 0]), axis=1) / length[:, None])


def _dashed(line: FloatArray, dash: float, gap: float) -> Iterator[FloatArray]:
    """Yield the dashes of a line, pixels."""
    line = line[np.isfinite(line).all(axis=1)]
    if len(line) < 2:
        return
    at = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))))
    if not at[-1] < _MOST_DASHES * (dash + gap):
        yield line
        return
    begin = 0.0
    while begin < at[-1]:
        end = min(begin + dash, float(at[-1]))
        inner = at[(at > begin) & (at < end)]
        where = np.concatenate(([begin], inner, [end]))
        yield np.stack([np.interp(where, at, line[:, k]) for k in (0, 1)], axis=1)
        begin += dash + gap
