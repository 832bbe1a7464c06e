"""A small picture of a road network: its reference lines alone.

They are searched for in the text, which takes a tenth of the time that reading all of the file does: a batch draws
thousands of them.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

import numpy as np

from osm2xodr.curves import starts
from osm2xodr.errors import InputError
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.viewing.picture.details import INK, SOFT, Line
from osm2xodr.viewing.picture.png import shapes_as_png

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
