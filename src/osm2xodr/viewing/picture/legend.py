"""The band below a picture: title, meaning of the colours, scale bar, north arrow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.furniture_shapes import DECAL_COLOUR
from osm2xodr.viewing.colours import Categories, Ramp
from osm2xodr.viewing.picture.contents import CREDIT_LINE, CREDIT_SIZE, Picture
from osm2xodr.viewing.picture.details import HATCHING, INK, PAPER, SOFT, Polygon

# Width of a letter as a share of its size: rather too wide, so that texts do not overlap.
_LETTER: Final = 0.6
# What red strokes across roads mean, and outlines of things that are flat on them.
_HATCHED: Final = "hatched: height not measured"
_DECALS: Final = "outlined: other objects"
# Boxes that a ramp is drawn with.
_STEPS: Final = 64


@dataclass(frozen=True)
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
