"""What a picture shows from near: road marks, what is painted on roads, and what stands beside them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, Final

import numpy as np

from osm2xodr.model import FloatArray
from osm2xodr.opendrive import OpenDrive
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

# From so many pixels per metre on: marks, and objects and signals.
MARKED: Final = 3.0
FURNISHED: Final = 2.0

# Of road marks, m: width, dash and gap, distance of double lines.
_WIDTH, _DASH, _GAP, _DOUBLE = 0.15, 3.0, 6.0, 0.14
_BROKEN: Final = 2
# Of one line.
_DASHES_MAX: Final = 20_000
_KERB_COLOUR: Final = "#8c8a84"
_UNPAINTED: Final = frozenset({"", "none", "curb", "grass"})
_PAINT: Final = WHITE
# Of objects by type; what is not listed is drawn in the last.
_FILLS: Final = {
    "trafficIsland": "#c4c0b4",
    "patch": "#c98f2b",
    "roadSurface": "#c98f2b",
    "obstacle": "#8d6e63",
    "barrier": "#43484d",
    "railing": "#43484d",
    "gantry": "#43484d",
    "soundBarrier": "#43484d",
    "vegetation": "#7ba268",
    "building": "#cbc6bd",
    "parkingSpace": "#4f7fbf",
}
_OTHER: Final = "#b9b4aa"
# Things seen as discs: colour, radius where none is stated, m, least pixels.
_DISCS: Final = {
    "tree": ("#6f9a5d", 1.5, 2.0),
    "streetLamp": ("#e0a800", 0.3, 2.0),
    "pole": ("#555b61", 0.2, 1.5),
}
# Order in which objects cover each other.
_ORDER: Final = {"patch": 0, "roadSurface": 0, "parkingSpace": 0, "crosswalk": 1, "roadMark": 1}
_LAST: Final = {"tree": 4, "streetLamp": 5, "pole": 5}
# Size of a symbol: m, least and most pixels.
_SYMBOL, _SYMBOL_LEAST, _SYMBOL_MOST = 0.9, 5.0, 16.0

_Pixels = Callable[[float, float], tuple[float, float]]


def mark_lines(grid: FloatArray, kinds: Sequence[Sequence[Any]], scale: float) -> list[Line]:
    """Return the marks on the borders of a strip.

    Parameters
    ----------
    grid : (stations, borders, 2)
        Pixels.
    kinds
        Of each border: name, style and colour, as `osm2xodr.viewing.marks` says.
    scale
        Pixels per metre.
    """
    out: list[Line] = []
    width = max(_WIDTH * scale, 0.5)
    for k, (name, style, colour) in enumerate(kinds):
        # Those on the outside lie within, or they would be lost on the paper.
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
    """Yield where the objects and signals of some roads stand, x, y, z, m, and their shapes.

    Parameters
    ----------
    file
        The network.
    roads
        Indices of the roads.
    pixels
        Takes x, y, m, to pixels.
    scale
        Pixels per metre.
    """
    things = placed_objects(file, roads)
    things.sort(key=lambda thing: _ORDER.get(_type(thing), _LAST.get(_type(thing), 2)))
    for thing in things:
        yield (thing.x, thing.y, thing.z), list(_object(thing, pixels, scale))
    size = min(max(_SYMBOL * scale, _SYMBOL_LEAST), _SYMBOL_MOST)
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
        yield _disc(x, y, max(0.3 * scale, 1.5), _OTHER)
    elif kind == "crosswalk":
        yield from _crosswalk(thing, subtype, pixels, scale)
    elif kind == "roadMark":
        yield from _painted(thing, subtype, pixels)
    else:
        yield _area(thing.corners, _FILLS.get(kind, _OTHER), pixels)


def _crosswalk(thing: PlacedObject, subtype: str, pixels: _Pixels, scale: float) -> Iterator[Shape]:
    """Yield the bars of a crosswalk; one that is not painted is but outlined."""
    corners = _open(thing.corners)
    if subtype == "virtual" or len(corners) != 4:
        around = np.array([pixels(*corner) for corner in (*corners, corners[0])])
        for piece in _dashed(around, 0.5 * scale, 0.5 * scale):
            yield Line(piece, _PAINT, max(0.1 * scale, 0.5))
        return
    for bar in bars(corners):
        yield _area(bar, _PAINT, pixels)


def _painted(thing: PlacedObject, subtype: str, pixels: _Pixels) -> Iterator[Shape]:
    """Yield what is painted on a lane: arrows, lines to stop or to give way at."""
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
    """Return corners without the first at the end."""
    out = list(corners)
    return out[:-1] if len(out) > 3 and math.dist(out[0], out[-1]) < 1e-6 else out


def _area(corners: Iterable[tuple[float, float]], colour: str, pixels: _Pixels) -> Polygon:
    """Return an area with corners in x and y, m."""
    return Polygon(np.array([pixels(*corner) for corner in corners]), colour, outlined=False)


def _disc(x: float, y: float, radius: float, colour: str) -> Polygon:
    """Return a disc, pixels."""
    return Polygon(np.array([(x + u, y + v) for u, v in disc(radius)]), colour)


def _moved(line: FloatArray, aside: float) -> FloatArray:
    """Move a line to its side, pixels."""
    if not aside or len(line) < 2:
        return line
    along = np.gradient(line, axis=0)
    length = np.hypot(along[:, 0], along[:, 1])
    length[length == 0.0] = 1.0
    moved: FloatArray = line + aside * np.stack((-along[:, 1], along[:, 0]), axis=1) / length[:, None]
    return moved


def _dashed(line: FloatArray, dash: float, gap: float) -> Iterator[FloatArray]:
    """Yield the dashes of a line, pixels."""
    line = line[np.isfinite(line).all(axis=1)]
    if len(line) < 2:
        return
    at = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))))
    # Beyond what roads have, as a damaged file may, nobody tells dashes from a line.
    if not at[-1] < _DASHES_MAX * (dash + gap):
        yield line
        return
    begin = 0.0
    while begin < at[-1]:
        end = min(begin + dash, float(at[-1]))
        inner = at[(at > begin) & (at < end)]
        where = np.concatenate(([begin], inner, [end]))
        yield np.stack([np.interp(where, at, line[:, k]) for k in (0, 1)], axis=1)
        begin += dash + gap
