"""Islands in junctions: places of some size that carriageways go round and that mapped streets enclose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from osm2xodr.curves import connected_groups, cosine, hypot, rays_to_segments, sine, unique_first
from osm2xodr.geometry.junction_floor import defaults
from osm2xodr.geometry.junction_floor.gaps import Grids
from osm2xodr.model import BoolArray, FloatArray

# Directions in which streets are looked for around an island.
_RAYS: Final = 24
# So many corners of cells before and behind each are averaged: a step of an outline and the next.
_AROUND: Final = 3


@dataclass(frozen=True, slots=True, eq=False)
class Hole:
    """A place that the lanes of a junction enclose and none covers."""

    road: int  # A connecting road of the junction
    corners: FloatArray  # (n, 2) x, y of what is clear of the lanes, counter-clockwise, m
    area: float  # Of all of it, m²


def find_holes(grids: Grids, cars: BoolArray) -> list[tuple[Hole, int]]:
    """Return the places of some size that lanes for cars, `cars` (roads,), go round.

    Each comes with the number of its gap in the grids, 0 where it is too large for one.
    """
    found: list[tuple[Hole, int]] = []
    holes = grids.holes
    if holes is None or not len(holes.area):
        return found
    begin = unique_first(holes.area)[1].tolist()
    for a, b in zip(begin, [*begin[1:], len(holes.area)], strict=True):
        grid = int(holes.grid[a])
        start, wide = int(grids.start[grid]), int(grids.wide[grid])
        first, last = holes.first[a:b] - start, holes.last[a:b] - start
        row, low = first // wide, first % wide
        cells = np.zeros((int(row.max() - row.min()) + 3, int((low + last - first).max() - low.min()) + 2), bool)
        for at, left, count in zip(
            (row - row.min()).tolist(), (low - low.min()).tolist(), (last - first).tolist(), strict=True
        ):
            cells[at + 1, left + 1 : left + 1 + count] = True
        below, over = np.nonzero(_grown(cells) & ~cells)
        beside = grids.road[start + (below + row.min() - 1) * wide + over + low.min() - 1]
        if (beside < 0).any() or not cars[beside].all():
            continue
        corner = grids.corner[grid] + (int(low.min()) - 1, int(row.min()) - 1)
        hole = hole_of(cells, corner * defaults.GAP_CELL, int(beside[0]))
        found += [] if hole is None else [(hole, int(grids.gap[holes.first[a]]))]
    return found


def hole_of(cells: BoolArray, low: FloatArray, road: int) -> Hole | None:
    """Return the hole whose cells (rows, columns) are marked; None where too little is clear of the lanes.

    No cell at the edge of the grid is. `low` is x, y of the corner of the first cell, m.
    """
    inner = ~_grown(~cells) & cells
    # Most are slivers, whatever their parts.
    if not inner.any() or inner.sum() * defaults.GAP_CELL**2 < defaults.ISLAND_LEAST_CLEAR:
        return None
    largest = largest_part(inner)
    if largest.sum() * defaults.GAP_CELL**2 < defaults.ISLAND_LEAST_CLEAR:
        return None
    body = _grown(largest) & cells
    ring = ring_of(body, defaults.GAP_CELL, defaults.ISLAND_CLEARANCE)
    return Hole(road, low + ring, float(cells.sum()) * defaults.GAP_CELL**2)


def ring_of(body: BoolArray, cell: float, inset: float) -> FloatArray:
    """Return the smoothed outline of connected cells of a size, so far within them, counter-clockwise, (n, 2), m."""
    ring = _smoothed(_outline(body)) * cell
    along = np.roll(ring, -1, axis=0) - np.roll(ring, 1, axis=0)
    along /= np.maximum(hypot(*along.T), 1e-9)[:, None]
    ring += inset * np.column_stack([-along[:, 1], along[:, 0]])
    return _simplified(ring, defaults.ISLAND_TOLERANCE)


def _grown(cells: BoolArray) -> BoolArray:
    """Return the marked cells and those that share a side with one of them, (rows, columns)."""
    out = cells.copy()
    out[1:] |= cells[:-1]
    out[:-1] |= cells[1:]
    out[:, 1:] |= cells[:, :-1]
    out[:, :-1] |= cells[:, 1:]
    return out


def largest_part(cells: BoolArray) -> BoolArray:
    """Return the marked cells of the largest part whose cells share sides, of several the first."""
    count = int(cells.sum())
    number = np.full(cells.shape, -1, np.int32)
    number[cells] = np.arange(count)
    beside = ((number[1:], number[:-1]), (number[:, 1:], number[:, :-1]))
    pairs = np.hstack([np.array([one, other])[:, (one >= 0) & (other >= 0)] for one, other in beside])
    part = connected_groups(count, *pairs)
    size = np.bincount(part)[part]
    out = np.zeros(cells.shape, bool)
    out[cells] = part == part[size.argmax()]
    return out


def _outline(inside: NDArray[np.bool_]) -> FloatArray:
    """Return the corners of the outline of cells that are connected, counter-clockwise, as column and row, (n, 2)."""
    follows: dict[tuple[int, int], tuple[int, int]] = {}
    # Along each side of a cell that has none beyond it, with the cell on the left.
    for (dx, dy), (ax, ay), (bx, by) in (
        ((0, -1), (0, 0), (1, 0)),
        ((1, 0), (1, 0), (1, 1)),
        ((0, 1), (1, 1), (0, 1)),
        ((-1, 0), (0, 1), (0, 0)),
    ):
        row, column = np.nonzero(inside & ~np.roll(inside, (-dy, -dx), axis=(0, 1)))
        for x, y in zip(column.tolist(), row.tolist(), strict=True):
            follows[x + ax, y + ay] = x + bx, y + by
    at = first = min(follows)
    ring = [first]
    while (at := follows[at]) != first and len(ring) <= len(follows):
        ring.append(at)
    return np.array(ring, float)


def _smoothed(ring: FloatArray) -> FloatArray:
    """Return a ring without the steps of cells: means of corners and those before and behind them."""
    return np.asarray(sum(np.roll(ring, k, axis=0) for k in range(-_AROUND, _AROUND + 1)) / (2 * _AROUND + 1))


def _simplified(ring: FloatArray, tolerance: float) -> FloatArray:
    """Return a ring with fewer corners, by Douglas and Peucker (1973) from its farthest corners on."""
    start = int(np.argmax(hypot(*(ring - ring.mean(axis=0)).T)))
    ring = np.roll(ring, -start, axis=0)
    ring = np.concatenate([ring, ring[:1]])
    keep = np.zeros(len(ring), bool)
    opposite = int(np.argmax(hypot(*(ring - ring[0]).T)))
    keep[[0, opposite, -1]] = True
    spans = [(0, opposite), (opposite, len(ring) - 1)]
    while spans:
        a, b = spans.pop()
        if b - a < 2:
            continue
        along, off = ring[b] - ring[a], ring[a + 1 : b] - ring[a]
        aside = np.abs(along[0] * off[:, 1] - along[1] * off[:, 0]) / max(float(hypot(*along)), 1e-9)
        k = int(aside.argmax())
        if aside[k] > tolerance:
            keep[a + 1 + k] = True
            spans += [(a, a + 1 + k), (a + 1 + k, b)]
    return np.asarray(ring[:-1][keep[:-1]])


def is_island(hole: Hole, begin: FloatArray, end: FloatArray) -> bool:
    """Say whether street lines, from begin to end (n, 2), go round a hole, and it fills most of what they leave."""
    place = hole.corners.mean(axis=0)
    angle = np.arange(_RAYS) * (2.0 * np.pi / _RAYS)
    far = rays_to_segments(place[None], np.column_stack([cosine(angle), sine(angle)]), begin, end)
    far = np.where(far > 0.0, far, np.inf).min(axis=1, initial=np.inf)
    if not np.isfinite(far).all():
        return False
    within = 0.5 * float((far * np.roll(far, -1)).sum()) * sine(2.0 * np.pi / _RAYS)
    return bool(hole.area >= defaults.ISLAND_SHARE * within)
