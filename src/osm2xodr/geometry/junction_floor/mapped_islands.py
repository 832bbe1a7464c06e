"""Islands that OSM maps as areas, less what lanes and tram tracks need: raised places between carriageways."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import numpy as np

from osm2xodr.curves import (
    PointTree,
    cubic_value,
    hypot,
    inside_outline,
    lengths,
    profile_of,
    project,
    running_lengths,
    sample_curves,
    sorted_unique,
)
from osm2xodr.geometry.junction_floor import defaults
from osm2xodr.geometry.junction_floor.islands import ring_of
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

# Lanes that an island must not lie on.
_CLEAR: Final = VEHICLE_LANES | {LaneType.BIKING, LaneType.PARKING, LaneType.SIDEWALK}
# Size of cells in which islands are cut to what is clear of lanes, m: half of what kerbs stay off these.
_CELL: Final = 0.2
# Roads whose line runs within this distance of an island may have lanes on it, m: half of a wide carriageway.
_REACH: Final = 20.0
# A place lies abreast of a curve, not beyond its ends, if its distance is |t| up to this, m.
_ABREAST: Final = 0.01


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
