"""A small picture of a road network: its reference lines alone.

They are searched for in the text, which takes a tenth of the time that reading all of the file does: a batch draws
thousands of them.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

import numpy as np

from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray
from osm2xodr.viewing.picture.png import shapes_as_png
from osm2xodr.viewing.picture.shapes import INK, SOFT, Line

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


def draw_thumbnail(xodr: Path) -> bytes:
    """Return a picture of a file that osm2xodr wrote, as PNG; the same file gives the same bytes.

    Raises `InputError` if it cannot be read, or has no roads.
    """
    try:
        text = xodr.read_bytes()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(f"{xodr} cannot be read: {reason}; check the path") from error
    lines = _lines(text)
    if not lines:
        raise InputError(f"{xodr} has no roads that can be drawn; give a file that osm2xodr wrote")
    corners = np.concatenate([corners for _, corners in lines])
    low, high = corners.min(axis=0), corners.max(axis=0)
    scale = _SIDE * (1.0 - 2.0 * _MARGIN) / max(float((high - low).max()), 1.0)
    middle = 0.5 * (low + high)
    shapes = [
        Line(
            0.5 * _SIDE + scale * (corners - middle) * (1.0, -1.0),
            SOFT if through else INK,
            _WIDTHS[through],
        )
        for through, corners in lines
    ]
    # Roads lie over the ways through junctions.
    shapes.sort(key=lambda line: line.width)
    return shapes_as_png(shapes, _SIDE, _SIDE)


def _lines(text: bytes) -> list[tuple[bool, FloatArray]]:
    """Return the reference line of each road, (n, 2), m, and whether the road leads through a junction."""
    roads = list(_ROAD.finditer(text))
    bounds = [*(road.start() for road in roads), len(text)]
    out = []
    for road, begin, end in zip(roads, bounds, bounds[1:], strict=False):
        plan_end = text.find(b"</planView>", begin, end)
        records = np.array(
            [found.groups() for found in _RECORD.finditer(text, begin, max(plan_end, begin))], np.float64
        )
        if len(records):
            x, y, heading, length = records[-1, 1:]
            last = x + length * np.cos(heading), y + length * np.sin(heading)
            out.append((road[1] != b"-1", np.vstack([records[:, 1:3], last])))
    return out
