"""What pictures are made of, in pixels from the top left; what they show at large scales, and what lies above what.

Large scales show road marks, paint on roads, and what stands beside them. What lies below, as under bridges, is drawn
first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final, TypeAlias

import numpy as np

from osm2xodr.curves import blocks, overlap_depths, overlapping_pairs
from osm2xodr.furniture_shapes import (
    DASH,
    DASH_GAP,
    DRAWN_MARK_WIDTH,
    LARGEST_SYMBOL,
    LEVEL_APART,
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
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import OpenDrive
from osm2xodr.system import record
from osm2xodr.viewing.scene import Scene

PAPER: Final = "#f6f7f5"
INK: Final = "#1d2630"
SOFT: Final = "#5a6672"
EDGE: Final = "#3d4853"
# Strokes across roads whose heights were not measured: they stand out from every colour of roads.
HATCHING: Final = "#f0323c"

_Pixels = Callable[[float, float], tuple[float, float]]
# Width of lines at least, pixels.
_LEAST_WIDTH = 0.5

# Parts reach into each other by this at least, m: more than chords of bends that lie side by side.
_DEPTH: Final = 0.2
# More decks than any interchange has; ramps that wind up over themselves would have any number. A choice.
_MOST_LEVELS: Final = 8


@record(eq=False)
class Polygon:
    """A filled area."""

    corners: FloatArray  # (n, 2)
    colour: str  # Of the area
    # Whether it has an outline of the same colour, so that no seam shows between neighbours
    outlined: bool = True


@record(eq=False)
class Line:
    """A line."""

    corners: FloatArray  # (n, 2)
    # By default those of the edge of a carriageway
    colour: str = EDGE
    width: float = 0.6


Shape: TypeAlias = Polygon | Line


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


class Parts:
    """The parts of strips between stations, with the levels on which they lie.

    A part is named by the station at which it begins; the last station of a strip has none.
    """

    def __init__(self, scene: Scene) -> None:
        x, y, z = scene.border_places()
        count = scene.strip_borders[scene.station_strip]
        left = np.concatenate([[0], np.cumsum(count)[:-1]]).astype(np.int64)
        right = left + count - 1
        last = np.zeros(len(scene.s), bool)
        last[scene.station_start[1:] - 1] = True
        at = np.flatnonzero(~last)
        corner = np.stack([left[at], right[at], right[at + 1], left[at + 1]], axis=1)
        corners, height = np.stack([x[corner], y[corner]], axis=2), np.nan_to_num(z)[corner].mean(axis=1)
        known = np.isfinite(corners).all(axis=(1, 2))
        self._at, self._corners, self._z = at[known], corners[known], height[known]
        self.level = np.zeros(len(scene.s), np.int64)
        self.level[self._at] = self._levels(scene.station_strip[self._at])
        self._road = scene.station_road[self._at]
        self._low, self._high = self._corners.min(axis=1), self._corners.max(axis=1)

    def _levels(self, strip: IntArray) -> IntArray:
        """Return on how many levels each part lies above others; parts that overlap at one height share theirs."""
        level = np.zeros(len(strip), np.int64)
        if not len(strip) or np.ptp(self._z) < LEVEL_APART:
            return level
        i, j = overlapping_pairs(self._corners, np.ones(len(strip), bool), strip)
        off = self._z[j] - self._z[i]
        apart = np.flatnonzero(np.abs(off) > LEVEL_APART)
        apart = apart[self._overlap(i[apart], j[apart])]
        over, under = np.where(off[apart] > 0, j[apart], i[apart]), np.where(off[apart] > 0, i[apart], j[apart])
        beside = np.flatnonzero((np.abs(off) <= LEVEL_APART) & ~((strip[i] == strip[j]) & (j - i == 1)))
        beside = beside[self._near(i[beside], j[beside], over)]
        beside = beside[self._overlap(i[beside], j[beside])]
        one, other = i[beside], j[beside]
        for _ in range(_MOST_LEVELS):
            before = level.copy()
            np.maximum.at(level, over, level[under] + 1)
            highest = np.maximum(level[one], level[other])
            np.maximum.at(level, one, highest)
            np.maximum.at(level, other, highest)
            if (level == before).all():
                break
        return level

    def _near(self, i: IntArray, j: IntArray, over: IntArray) -> BoolArray:
        """Say which pairs hang together with parts that lie above others."""
        reached = np.zeros(len(self._z), bool)
        reached[over] = True
        for _ in range(_MOST_LEVELS):
            reached[i[reached[j]]] = reached[j[reached[i]]] = True
        out: BoolArray = reached[i] & reached[j]
        return out

    def _overlap(self, i: IntArray, j: IntArray) -> BoolArray:
        """Say which pairs of parts reach into each other, block by block, which saves memory."""
        out = np.zeros(len(i), bool)
        for rows in blocks(len(i)):
            out[rows] = overlap_depths(self._corners[i[rows]], self._corners[j[rows]]) > _DEPTH
        return out

    def above(self, places: FloatArray, z: float, road: int) -> int | None:
        """Return the lowest level of what lies over places, (n, 2), m, above z, m, save one road; None: nothing."""
        low, high = places.min(axis=0), places.max(axis=0)
        near = (self._low <= high).all(axis=1) & (self._high >= low).all(axis=1)
        rows = np.flatnonzero(near & (self._z > z) & (self._road != road))
        inside = (self._low[rows, None] <= places).all(axis=2) & (self._high[rows, None] >= places).all(axis=2)
        levels = self.level[self._at[rows[inside.any(axis=1)]]]
        return int(levels.min()) if len(levels) else None
