"""Islands in junctions: places that carriageways go round and that streets enclose, and areas that OSM maps."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from osm2xodr.curves import (
    PointTree,
    connected_groups,
    cosine,
    cubic_value,
    hypot,
    inside_outline,
    lengths,
    profile_of,
    project,
    rays_to_segments,
    running_lengths,
    sample_curves,
    sine,
    sorted_unique,
    unique_first,
)
from osm2xodr.geometry.junction_floor import defaults
from osm2xodr.geometry.junction_floor.cells import FACE
from osm2xodr.geometry.junction_floor.gaps import Grids
from osm2xodr.model import (
    VEHICLE_LANES,
    BoolArray,
    FloatArray,
    IntArray,
    Island,
    LaneType,
    Outline,
    RoadMap,
    RoadsideKind,
    RoadsideThing,
)
from osm2xodr.system import record

# Directions in which streets are looked for around an island.
_RAYS: Final = 24
# So many corners of cells before and behind each are averaged: a step of an outline and the next.
_AROUND: Final = 3

# Lanes that an island must not lie on.
_CLEAR: Final = VEHICLE_LANES | {LaneType.BIKING, LaneType.PARKING, LaneType.SIDEWALK}
# Size of cells in which islands are cut to what is clear of lanes, m: half of what kerbs stay off these.
_CELL: Final = 0.2
# Roads whose line runs within this distance of an island may have lanes on it, m: half of a wide carriageway.
_REACH: Final = 20.0
# A place lies abreast of a curve, not beyond its ends, if its distance is |t| up to this, m.
_ABREAST: Final = 0.01


@record(eq=False)
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
    if not len(holes.area):
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
        beside = grids.cells[start + (below + row.min() - 1) * wide + over + low.min() - 1]
        if (beside < 0).any() or not cars[beside].all():
            continue
        corner = grids.corner[grid] + (int(low.min()) - 1, int(row.min()) - 1)
        hole = hole_of(cells, corner * defaults.GAP_CELL, int(beside[0]))
        found += [] if hole is None else [(hole, max(FACE - int(grids.cells[holes.first[a]]), 0))]
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


def raised_islands(
    things: Iterable[RoadsideThing], road_map: RoadMap, between: Sequence[Island]
) -> tuple[tuple[Island, ...], list[str]]:
    """Return all islands of a road map, and the OSM ids of areas that have no place: they lie on lanes, or are tiny.

    `between` are those that carriageways go round: areas in the same place count instead, and none lies on a track.
    """
    areas, tracks = [], []
    for thing in things:
        if thing.kind is RoadsideKind.ISLAND:
            areas.append(thing)
        elif thing.kind is RoadsideKind.TRAM_TRACK:
            tracks.append(thing.points)
    ends = np.concatenate([np.zeros((0, 4)), *(np.column_stack([line[:-1], line[1:]]) for line in tracks)])
    mapped: list[Island] = []
    left_out: list[str] = []
    if areas:
        curve, x, y = sample_curves(road_map.plan_view, np.arange(len(road_map.roads)))
        tree = PointTree(np.column_stack([x, y]))
    for area in areas:
        ring = area.points[:-1]
        middle = ring.mean(axis=0)
        reach = float(hypot(*(ring - middle).T).max()) + _REACH
        near = sorted_unique(curve[tree.within(middle[None], reach)[1]])
        found = list(_on_roads(area, near, road_map, ends)) if len(near) else []
        mapped += found
        left_out += [] if found else [area.osm_id]
    kept = (item for item in between if not any(_meet(item.corners, other.corners) for other in mapped))
    return (*(item for item in kept if not _on_track(item.corners, ends)), *mapped), left_out


def _on_roads(area: RoadsideThing, near: IntArray, road_map: RoadMap, tracks: FloatArray) -> Iterator[Island]:
    """Yield the parts of an area that lanes of the roads near it, by index, and tracks leave."""
    ring = area.points[:-1]
    size = 0.5 * float(np.sum(ring[:, 0] * np.roll(ring[:, 1], -1) - ring[:, 1] * np.roll(ring[:, 0], -1)))
    if not defaults.ISLAND_MAPPED_LEAST <= abs(size) <= defaults.ISLAND_LARGEST_AREA:
        return
    low = ring.min(axis=0) - 2 * _CELL
    columns, rows = np.ceil((ring.max(axis=0) + 2 * _CELL - low) / _CELL).astype(int).tolist()
    x, y = (v.ravel() for v in np.meshgrid(*(_CELL * (np.arange(n) + 0.5) for n in (columns, rows))))
    inside = np.flatnonzero(inside_outline(Outline((ring,)), x + low[0], y + low[1]))
    x, y = x[inside] + low[0], y[inside] + low[1]
    taken = _on_tracks(x, y, tracks)
    for road in near.tolist():
        taken |= _on_lanes(x, y, road, road_map)
    _, _, distance = project(road_map.plan_view, near, *np.repeat(ring.mean(axis=0)[:, None], len(near), axis=1))
    road = int(near[np.argmin(distance)])
    if not taken.any():
        yield Island(-1, road, ring[:: 1 if size > 0 else -1].copy(), area.osm_id)
        return
    # It takes long to load, and few areas need it.
    from scipy import ndimage

    cells = np.zeros(rows * columns, bool)
    cells[inside[~taken]] = True
    parts, count = ndimage.label(ndimage.binary_opening(cells.reshape(rows, columns), iterations=2))
    least = max(defaults.ISLAND_MAPPED_LEAST, defaults.ISLAND_MAPPED_SHARE * abs(size)) / _CELL**2
    for part in range(1, count + 1):
        if (body := parts == part).sum() >= least:
            yield Island(-1, road, low + ring_of(body, _CELL, 0.0), area.osm_id)


def _on_lanes(x: FloatArray, y: FloatArray, road: int, road_map: RoadMap) -> BoolArray:
    """Say which places, (n,), m, lie on lanes of a road, or too near to them."""
    curve = np.full(len(x), road)
    s, t, distance = project(road_map.plan_view, curve, x, y)
    out = np.zeros(len(x), bool)
    beside = np.flatnonzero(distance - np.abs(t) < _ABREAST)
    s, t = s[beside], t[beside] - cubic_value(road_map.lane_offset, curve[beside], s[beside])
    sections = road_map.roads[road].lane_sections
    length = float(lengths(road_map.plan_view, np.array([road]))[0])
    for section, end in zip(sections, [*(item.s for item in sections[1:]), length + 1.0], strict=True):
        here = np.flatnonzero((s >= section.s) & (s < end))
        for side in (1, -1) if len(here) else ():
            inner, first = np.zeros(len(here)), np.zeros(len(here), np.int64)
            lanes = sorted((lane for lane in section.lanes if lane.id * side > 0), key=lambda lane: abs(lane.id))
            for lane in lanes:
                outer = inner + cubic_value(profile_of([lane.widths]), first, s[here] - section.s)
                if lane.type in _CLEAR:
                    off, clear = side * t[here], defaults.ISLAND_CLEARANCE
                    wide = outer > inner
                    out[beside[here[wide & (off > inner - clear) & (off < outer + clear)]]] = True
                inner = outer
    return out


def _on_tracks(x: FloatArray, y: FloatArray, tracks: FloatArray) -> BoolArray:
    """Say which places, (n,), m, trams need on their tracks, x, y of both ends of segments, (m, 4)."""
    out = np.zeros(len(x), bool)
    reach = defaults.TRAM_HALF_WIDTH
    if not len(x):
        return out
    low, high = np.minimum(tracks[:, :2], tracks[:, 2:]), np.maximum(tracks[:, :2], tracks[:, 2:])
    near = (low[:, 0] < x.max() + reach) & (high[:, 0] > x.min() - reach)
    near &= (low[:, 1] < y.max() + reach) & (high[:, 1] > y.min() - reach)
    for x0, y0, x1, y1 in tracks[near].tolist():
        dx, dy = x1 - x0, y1 - y0
        share = np.clip(((x - x0) * dx + (y - y0) * dy) / max(dx * dx + dy * dy, 1e-12), 0.0, 1.0)
        out |= hypot(x - x0 - share * dx, y - y0 - share * dy) < reach
    return out


def _on_track(corners: FloatArray, tracks: FloatArray) -> bool:
    """Whether a track leads over an island, whose kerbs are looked at every cell."""
    ring = np.concatenate([corners, corners[:1]])
    along = running_lengths(ring)
    at = np.linspace(0.0, along[-1], int(along[-1] / _CELL) + 2)
    x, y = (np.interp(at, along, column) for column in ring.T)
    return bool(_on_tracks(x, y, tracks).any())


def _meet(one: FloatArray, other: FloatArray) -> bool:
    """Whether a corner or the middle of one polygon lies in the other."""
    return any(
        bool(inside_outline(Outline((ring,)), *np.vstack([places, places.mean(axis=0)]).T).any())
        for ring, places in ((one, other), (other, one))
    )
