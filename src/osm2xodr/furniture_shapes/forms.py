"""What is painted on roads and stands beside them, as areas, discs and lines in metres; faces of signs and lights.

Page, picture and exported scene show the same forms. Outlines on the road have corners u forward, v to the left, m;
symbols x to the right, y down, in sizes of the symbol.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import Final, TypeAlias

import numpy as np

from osm2xodr.curves import running_lengths, sine_cosine
from osm2xodr.furniture_shapes.placing import PlacedObject, PlacedSignal
from osm2xodr.model import FloatArray
from osm2xodr.system import record

# Surfaces farther apart in height belong to different levels, m; traffic needs 4 m (`CLEARANCE_LEAST`), and roads
# that meet are closer. A choice between both.
LEVEL_APART: Final = 1.5
# Lane types in the order in which they cover each other: bicycle lanes are painted across junctions, what is driven
# on shows, what lies beside it gives way. All others are driven on.
_FIRST: Final = "biking"
_COVERED: Final = ("tram", "rail", "stop", "parking", "shoulder", "walking", "sidewalk", "curb")
_LAST: Final = ("median", "border", "none", "")


def rank_of(kind: str) -> int:
    """Return the place of a type of lanes in the order in which they cover each other; 0 covers all."""
    if kind in _COVERED:
        return 2 + _COVERED.index(kind)
    if kind in _LAST:
        return 2 + len(_COVERED) + _LAST.index(kind)
    return 0 if kind == _FIRST else 1


# ---------------------------------------------------------------- forms

Corners: TypeAlias = list[tuple[float, float]]
# Parts of a symbol, the lowest first, each with its colour
Symbol: TypeAlias = list[tuple[Corners, str]]


def colours_by_name(names_of: Mapping[str, str]) -> Mapping[str, str]:
    """Return colours by name, from the names that share each colour."""
    return MappingProxyType({name: colour for colour, names in names_of.items() for name in names.split()})


RED, AMBER, GREEN, DARK, WHITE, BLUE = "#c1272d", "#f2b134", "#3fa35b", "#1d2630", "#ffffff", "#2f74b9"
# Pixels per metre from which marks, and objects and signals are drawn.
MARKS_FROM: Final = 3.0
FURNITURE_FROM: Final = 2.0
# Road marks, m: width, dash and gap, distance of each line of a double mark from the middle.
DRAWN_MARK_WIDTH: Final = 0.15
DASH: Final = 3.0
DASH_GAP: Final = 6.0
_DOUBLE: Final = 0.14
_BROKEN: Final = 2
_KERB_COLOUR: Final = "#8c8a84"
_UNPAINTED: Final = frozenset({"", "none", "curb", "grass"})
# Size of a symbol, m, and its limits, pixels.
SYMBOL: Final = 0.9
SMALLEST_SYMBOL: Final = 5.0
LARGEST_SYMBOL: Final = 16.0
# Dashes of one line at most; damaged files have longer ones, which are drawn solid.
_MOST_DASHES: Final = 20_000
# Bars of a crosswalk at most, likewise.
_MOST_BARS: Final = 1_000
# Outlines of crosswalks without bars: dash, gap and width, m.
_OUTLINE_DASH: Final = 0.5
_OUTLINE_WIDTH: Final = 0.1
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
# Objects drawn as discs: colour, radius where none is stated, m, least radius, pixels. The last are those of objects
# without an outline.
_DISCS: Final = {
    "tree": ("#6f9a5d", 1.5, 2.0),
    "streetLamp": ("#e0a800", 0.3, 2.0),
    "pole": ("#555b61", 0.2, 1.5),
}
_OTHER_DISC: Final = (_OTHER_FILL, 0.3, 1.5)
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
# Flat objects of a type that OpenDRIVE does not know, such as the stains and cracks that RoadRunner writes with type
# -1, lie below all paint: only their outline is drawn, of this colour and width, m, or they would hide lanes.
_DECAL_LAYER: Final = -1
DECAL_COLOUR: Final = "#a39d92"
_DECAL_WIDTH: Final = 0.06
# What is lower is flat, m.
_FLAT: Final = 0.05
# Types of objects (OpenDRIVE 1.8, e_objectType) that have neither a colour nor a layer here.
_FURTHER_TYPES: Final = frozenset(
    {"bike", "bus", "car", "motorbike", "pedestrian", "trailer", "train", "tram", "van", "wind"}
)
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


@record
class Area:
    """A filled area."""

    corners: Corners  # x, y, m
    colour: str


@record
class Disc:
    """A disc that does not vanish from afar."""

    # Of the middle, and radius, m
    x: float
    y: float
    radius: float
    least: float  # Radius at least, pixels
    colour: str


@record
class Stroke:
    """A line."""

    corners: Corners  # x, y, m
    colour: str
    width: float  # m


Form: TypeAlias = Area | Disc | Stroke


def mark_pattern(name: str, style: int, colour: str) -> list[tuple[float, bool, str]]:
    """Return the lines of a road mark: distance to the right of the border (m), whether broken, colour.

    Name, style and colour are those of `border_marks`.
    """
    if name == "curb":
        return [(0.0, False, _KERB_COLOUR)]
    if name in _UNPAINTED or not style:
        return []
    words = name.split()
    if len(words) == 2 and name != "botts dots":
        return [(side, word == "broken", colour) for side, word in zip((-_DOUBLE, _DOUBLE), words, strict=True)]
    return [(0.0, style == _BROKEN, colour)]


def in_layers(things: Iterable[PlacedObject]) -> list[PlacedObject]:
    """Return objects in the order in which they are drawn, the lowest layer first."""
    return sorted(things, key=_layer)


def _layer(thing: PlacedObject) -> int:
    return _DECAL_LAYER if is_decal(thing) else _LAYERS.get(type_of(thing), _OTHER_LAYER)


def is_decal(thing: PlacedObject) -> bool:
    """Whether an object is flat, and of a type that OpenDRIVE does not know."""
    kind, item = type_of(thing), thing.item
    known = kind in _FILLS or kind in _DISCS or kind in _LAYERS or kind in _FURTHER_TYPES
    heights = (item.height, *(height for outline in item.outlines for _, _, _, height in outline))
    return not known and len(thing.corners) >= 3 and not any(height > _FLAT for height in heights)


def type_of(thing: PlacedObject) -> str:
    """Return the type of an object."""
    return thing.item.attributes.get("type", "")


def is_painted(thing: PlacedObject) -> bool:
    """Whether an object is flat on the road."""
    return _layer(thing) < _OTHER_LAYER


def forms_of(thing: PlacedObject) -> Iterator[Form]:
    """Yield the forms of an object."""
    kind, subtype = type_of(thing), thing.item.attributes.get("subtype", "")
    if kind in _DISCS or len(thing.corners) < 3:
        colour, radius, least = _DISCS.get(kind, _OTHER_DISC)
        own = thing.item.radius if kind in _DISCS and thing.item.radius > 0.0 else radius
        yield Disc(thing.x, thing.y, own, least, colour)
    elif is_decal(thing):
        corners = _open(thing.corners)
        for edge in zip(corners, [*corners[1:], corners[0]], strict=True):
            yield Stroke(list(edge), DECAL_COLOUR, _DECAL_WIDTH)
    elif kind == "crosswalk":
        yield from _crosswalk(thing, subtype)
    elif kind == "roadMark":
        yield from _painted(thing, subtype)
    else:
        yield Area(list(thing.corners), _FILLS.get(kind, _OTHER_FILL))


def face_of(signal: PlacedSignal) -> Symbol:
    """Return the symbol of a traffic light or a sign."""
    if signal.is_light:
        return light_symbol()
    attributes = signal.item.attributes
    return sign_symbol(attributes.get("type", ""), attributes.get("name", ""))


def _crosswalk(thing: PlacedObject, subtype: str) -> Iterator[Form]:
    """Yield the bars of a crosswalk, or a dashed outline if it has no bars."""
    corners = _open(thing.corners)
    if subtype == "virtual" or len(corners) != 4:
        for piece in dashed(np.array([*corners, corners[0]]), _OUTLINE_DASH, _OUTLINE_DASH):
            yield Stroke([(x, y) for x, y in piece.tolist()], WHITE, _OUTLINE_WIDTH)
        return
    for bar in bars(corners):
        yield Area(bar, WHITE)


def _painted(thing: PlacedObject, subtype: str) -> Iterator[Form]:
    """Yield the paint on a lane: arrows, stop lines, give-way lines."""
    corners = _open(thing.corners)
    if subtype.startswith("arrow"):
        sin, cos = sine_cosine(thing.heading)
        for part in arrow(subtype, thing.item.length):
            yield Area([(thing.x + cos * u - sin * v, thing.y + sin * u + cos * v) for u, v in part], WHITE)
    elif "giveWay" in subtype and len(corners) == 4:
        for piece in bars(corners):
            yield Area(piece, WHITE)
    else:
        yield Area(corners, WHITE)


def _open(corners: Iterable[tuple[float, float]]) -> Corners:
    """Return corners without a repetition of the first at the end."""
    out = list(corners)
    return out[:-1] if len(out) > 3 and math.dist(out[0], out[-1]) < 1e-6 else out


def dashed(line: FloatArray, dash: float, gap: float) -> Iterator[FloatArray]:
    """Yield the dashes of a line, all in one unit."""
    line = line[np.isfinite(line).all(axis=1)]
    if len(line) < 2:
        return
    at = running_lengths(line)
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


def bars(corners: Corners) -> list[Corners]:
    """Return the bars of a crosswalk from its four corners: they lie along the road, across its longer side."""
    a, b, c, d = corners
    # The two edges across the road, from kerb to kerb.
    first, second = ((a, d), (b, c)) if math.dist(a, d) >= math.dist(a, b) else ((a, b), (d, c))
    width = math.dist(*first)
    if not width < _MOST_BARS * 2.0 * _BAR:
        return [corners]
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


def light_symbol() -> Symbol:
    """Return a traffic light with its three lamps."""
    box = [(-0.32, -0.8), (0.32, -0.8), (0.32, 0.8), (-0.32, 0.8)]
    lamps = ((-0.48, RED), (0.0, AMBER), (0.48, GREEN))
    return [(box, DARK), *(([(x, y + shift) for x, y in disc(0.2)], colour) for shift, colour in lamps)]


def sign_symbol(type_: str, name: str) -> Symbol:
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
