"""What pictures are made of, in pixels from the top left, and the outlines of what is painted on roads and of signs.

On the road: corners u forward, v to the left, m. Symbols: x to the right, y down, in sizes of the symbol.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, TypeAlias

from osm2xodr.model import FloatArray

Corners: TypeAlias = list[tuple[float, float]]

PAPER, INK, SOFT, EDGE = "#f6f7f5", "#1d2630", "#5a6672", "#3d4853"
RED, AMBER, GREEN, DARK, WHITE, BLUE = "#c1272d", "#f2b134", "#3fa35b", "#1d2630", "#ffffff", "#2f74b9"

# Strokes across roads whose heights were not measured: they stand out from every colour of roads.
HATCHING: Final = "#f0323c"
# Bars of a crosswalk and the gaps between them, and of a give-way line, m.
_BAR: Final = 0.5
# Arrows: half the width of the shaft, and of the head, m; the head's share of the length.
_SHAFT: Final = 0.1
_HEAD: Final = 0.4
_HEAD_SHARE: Final = 0.3
# Words in the names of signs, and the face of such signs; the first match holds.
_FACES: Final = (
    (("city", "town"), "board"),
    (("stop",), "octagon"),
    (("give_way", "give way", "yield"), "triangle"),
    (("maxspeed", "speed", "limit"), "ring"),
    (("priority",), "diamond"),
)
# Codes of Germany, which CARLA and esmini read everywhere.
_CODES: Final = {
    "206": "octagon",
    "205": "triangle",
    "274": "ring",
    "306": "diamond",
    "301": "diamond",
    "310": "board",
    "311": "board",
}


@dataclass(frozen=True, eq=False)
class Polygon:
    """A filled area."""

    corners: FloatArray  # (n, 2)
    colour: str  # Of the area
    # Whether it has an outline of the same colour, so that no seam shows between neighbours
    outlined: bool = True


@dataclass(frozen=True, eq=False)
class Line:
    """A line."""

    corners: FloatArray  # (n, 2)
    # By default those of the edge of a carriageway
    colour: str = EDGE
    width: float = 0.6


Shape: TypeAlias = Polygon | Line


def bars(corners: Corners) -> list[Corners]:
    """Return the bars of a crosswalk from its four corners: they lie along the road, across its longer side."""
    a, b, c, d = corners
    # The two edges across the road, from kerb to kerb.
    first, second = ((a, d), (b, c)) if math.dist(a, d) >= math.dist(a, b) else ((a, b), (d, c))
    width = math.dist(*first)
    count = max(1, int((width + _BAR) / (2.0 * _BAR)))
    margin = 0.5 * (width - (2 * count - 1) * _BAR)
    out = []
    for k in range(count):
        low, high = ((margin + (2 * k + part) * _BAR) / width if width else 0.0 for part in (0, 1))
        out.append([_between(*first, low), _between(*first, high), _between(*second, high), _between(*second, low)])
    return out


def arrow(subtype: str, length: float) -> list[Corners]:
    """Return the parts of an arrow on a lane; its directions are named in its subtype."""
    word = subtype.lower()
    sides = [side for name, side in (("left", 1.0), ("right", -1.0)) if name in word]
    through = "straight" in word or "through" in word or not sides
    head = _HEAD_SHARE * length
    tip = 0.5 * length
    end = tip - head if through else tip - 0.5 * head
    out = [[(-tip, -_SHAFT), (end, -_SHAFT), (end, _SHAFT), (-tip, _SHAFT)]]
    if through:
        out.append([(tip - head, -_HEAD), (tip, 0.0), (tip - head, _HEAD)])
    for side in sides:
        at = tip - (1.6 if through else 0.5) * head
        root, reach = side * _SHAFT, side * (_SHAFT + 1.2 * _HEAD)
        out.append(
            [(at - 0.12 * head, 0.0), (at + 0.12 * head, 0.0), (at + 0.12 * head, reach), (at - 0.12 * head, reach)]
        )
        out.append([(at - 0.5 * head, root + 0.5 * reach), (at + 0.5 * head, root + 0.5 * reach), (at, 1.7 * reach)])
    return out


def disc(radius: float, corners: int = 14) -> Corners:
    """Return a circle's corners."""
    turns = [2.0 * math.pi * (k + 0.5) / corners for k in range(corners)]
    return [(radius * math.cos(turn), radius * math.sin(turn)) for turn in turns]


def light_symbol() -> list[tuple[Corners, str]]:
    """Return a traffic light with its three lamps."""
    box = [(-0.32, -0.8), (0.32, -0.8), (0.32, 0.8), (-0.32, 0.8)]
    lamps = ((-0.48, RED), (0.0, AMBER), (0.48, GREEN))
    return [(box, DARK), *(([(x, y + shift) for x, y in disc(0.2)], colour) for shift, colour in lamps)]


def sign_symbol(type_: str, name: str) -> list[tuple[Corners, str]]:
    """Return the face of a sign by its code or its name."""
    face = _CODES.get(type_) or next(
        (face for words, face in _FACES if any(word in name.lower() for word in words)), "square"
    )
    if face == "octagon":
        return [(disc(0.75, 8), WHITE), (disc(0.65, 8), RED)]
    if face == "triangle":
        return [(_triangle(0.8), RED), (_triangle(0.42), WHITE)]
    if face == "ring":
        return [(disc(0.7), RED), (disc(0.45), WHITE)]
    if face == "diamond":
        return [(_turned(disc(0.8, 4)), WHITE), (_turned(disc(0.5, 4)), AMBER)]
    if face == "board":
        return [([(-0.9, -0.45), (0.9, -0.45), (0.9, 0.45), (-0.9, 0.45)], AMBER)]
    return [(disc(0.8, 4), WHITE), (disc(0.62, 4), BLUE)]


def _triangle(size: float) -> Corners:
    """Return a triangle on its tip."""
    return [(-size, -0.6 * size), (size, -0.6 * size), (0.0, 1.1 * size)]


def _turned(corners: Corners) -> Corners:
    """Turn a square onto its corner."""
    half = math.sqrt(0.5)
    return [(half * (x - y), half * (x + y)) for x, y in corners]


def _between(a: tuple[float, float], b: tuple[float, float], share: float) -> tuple[float, float]:
    """Return a point between two."""
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])
