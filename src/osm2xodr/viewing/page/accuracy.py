"""Compares roads with their sources: ways of OpenStreetMap along them, and heights of elevation models below them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from osm2xodr.curves import sorted_unique
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import CoverageError
from osm2xodr.exporting import places_around, read_heights
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import Frame, OpenDrive, Places, RoadFinder, pose
from osm2xodr.osmParsing import (
    ACCESS_TAGS,
    ParseOptions,
    RawNodes,
    RawWay,
    open_osm_file,
    read_nodes,
    read_ways,
    reason_left_out,
)
from osm2xodr.surface import SurfaceOptions
from osm2xodr.system import record
from osm2xodr.viewing.options import ReportOptions
from osm2xodr.viewing.scene import Scene

# Distance of points along ways, m; how far beside a lane a point still counts as on it, m (a way drawn on the kerb);
# how far the directions of a way and of its road may differ, rad (30 degrees).
_WAY_SPACING: Final = 10.0
_SLACK: Final = 1.0
_ANGLE: Final = 0.5236
# A map whose every way lies farther from all roads than this is one of another place, m: a choice.
_ELSEWHERE: Final = 1000.0
# Least length of a way on a road that is listed with it, m; half of the road is enough.
LEAST_MATCH: Final = 15.0
_TAGS = frozenset({*ACCESS_TAGS, "highway", "name", "ref", "bridge", "tunnel"})
_NO = frozenset({"no", ""})

# Points of the grid that shows the ground, which make the page 40 kB larger; and how far the grid extends beyond the
# roads at least, m, and as a share of their extent. Choices.
_GRID_POINTS: Final = 40_000
_LEAST_MARGIN: Final = 60.0
_MARGIN_SHARE: Final = 0.03


@record
class WayCover:
    """How much of a way lies on a carriageway."""

    # OSM id and tags
    way: int
    highway: str
    name: str
    structure: str  # ``bridge``, ``tunnel`` or empty
    # m
    length: float
    covered: float
    # The middle of what is not covered, or else of the way, m
    x: float
    y: float


@record
class WayOnRoad:
    """A stretch of a road that follows a way."""

    # Index of the road, and of the `WayCover`
    road: int
    way: int
    # s, m
    begin: float
    end: float


@record(eq=False)
class _Points:
    """Points along ways at even distances, (n,)."""

    way: IntArray  # Index of the way
    # m
    x: FloatArray
    y: FloatArray
    direction: FloatArray  # Of the way, rad
    weight: FloatArray  # Length that the point stands for, m


def compare_with_osm(path: Path, file: OpenDrive, frame: Frame) -> tuple[list[WayCover], list[WayOnRoad]]:
    """Compare the roads of a file with the ways for cars that ``convert`` uses by default.

    Raises
    ------
    InputError
        The OSM file cannot be read.
    CoverageError
        It is the map of another place.
    """
    options = ParseOptions()
    source = open_osm_file(path)
    found, _ = read_ways(source, options.ways.highways, _TAGS)
    ways = [way for way in found if reason_left_out(way.tags, options.ways, options.include_private) is None]
    nodes = read_nodes(source, sorted_unique(np.fromiter((ref for way in ways for ref in way.refs), np.int64)))
    points = _points(ways, nodes, frame)
    places = RoadFinder(file).find(points.x, points.y)
    if len(places.distance) and places.distance.min() > _ELSEWHERE:
        away = places.distance.min() / 1e3
        raise CoverageError(
            f"{path}: its ways lie {away:,.0f} km and more from the roads of {file.path};"
            " give the OSM file of that area"
        )
    covered = np.zeros(len(points.x), np.bool_)
    covered[places.point[places.distance <= _SLACK]] = True
    return _covers(ways, points, covered), _on_roads(file, points, places, len(ways))


def structure_of(tags: dict[str, str]) -> str:
    """Return ``bridge`` or ``tunnel`` if a way is one, else an empty text."""
    for kind in ("bridge", "tunnel"):
        if tags.get(kind, "no") not in _NO:
            return kind
    return ""


def _points(ways: list[RawWay], nodes: RawNodes, frame: Frame) -> _Points:
    """Cut ways into pieces of even length and return the middles of the pieces."""
    x, y = frame.to_inertial(nodes.lon_deg, nodes.lat_deg)
    columns = [(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0))]
    for row, way in enumerate(ways):
        refs = np.asarray(way.refs, np.int64)
        at = np.searchsorted(nodes.ids, refs)
        there = at < len(nodes.ids)
        there[there] = nodes.ids[at[there]] == refs[there]
        px, py = x[at[there]], y[at[there]]
        usable = np.isfinite(px) & np.isfinite(py)
        px, py = px[usable], py[usable]
        dx, dy = np.diff(px), np.diff(py)
        length = np.concatenate(([0.0], np.cumsum(np.hypot(dx, dy))))
        if len(px) < 2 or length[-1] <= 0.0:
            continue
        pieces = max(1, int(np.ceil(length[-1] / _WAY_SPACING)))
        middle = (np.arange(pieces) + 0.5) * length[-1] / pieces
        segment = np.clip(np.searchsorted(length, middle, "right") - 1, 0, len(dx) - 1)
        at_x, at_y = np.interp(middle, length, px), np.interp(middle, length, py)
        weight = np.full(pieces, length[-1] / pieces)
        columns.append((np.full(pieces, float(row)), at_x, at_y, np.arctan2(dy[segment], dx[segment]), weight))
    way_row, *others = (np.concatenate(column) for column in zip(*columns, strict=True))
    return _Points(way_row.astype(np.int64), *others)


def _covers(ways: list[RawWay], points: _Points, covered: BoolArray) -> list[WayCover]:
    """Sum up by way; ways without a length are left out."""
    out = []
    rows_of_ways = np.split(np.arange(len(points.way)), np.searchsorted(points.way, range(1, len(ways))))
    for way, rows in zip(ways, rows_of_ways, strict=False):
        if not len(rows):
            continue
        missing = rows[~covered[rows]]
        shown = missing if len(missing) else rows
        middle = shown[len(shown) // 2]
        out.append(
            WayCover(
                way.id,
                way.tags["highway"],
                way.tags.get("name", way.tags.get("ref", "")),
                structure_of(dict(way.tags)),
                float(points.weight[rows].sum()),
                float(points.weight[rows][covered[rows]].sum()),
                float(points.x[middle]),
                float(points.y[middle]),
            )
        )
    return out


def _on_roads(file: OpenDrive, points: _Points, places: Places, ways: int) -> list[WayOnRoad]:
    """Return which stretches of roads outside of junctions follow which ways, in order of roads and s.

    A road follows a way whose points lie on its lanes and whose direction is its own. Heights are not compared, so a
    road may also follow a way above or below it.
    """
    rows = np.flatnonzero((places.distance <= _SLACK) & (file.roads.junction[places.road] == -1))
    heading = pose(file, places.road[rows], places.s[rows])[2]
    along = np.abs(np.cos(heading - points.direction[places.point[rows]]))
    rows = rows[along >= np.cos(_ANGLE)]
    if not len(rows):
        return []
    road, way, s = places.road[rows], points.way[places.point[rows]], places.s[rows]
    half = 0.5 * points.weight[places.point[rows]]
    # Indices of WayCover, which leaves out ways without a length.
    kept_ways = np.full(ways, -1)
    present = sorted_unique(points.way)
    kept_ways[present] = np.arange(len(present))
    order = np.lexsort((s, way, road))
    road, way, s, half = road[order], way[order], s[order], half[order]
    first = np.flatnonzero((np.diff(road, prepend=-1) != 0) | (np.diff(way, prepend=-1) != 0))
    last = np.append(first[1:], len(road)) - 1
    out = []
    for a, b in zip(first.tolist(), last.tolist(), strict=True):
        length = float(file.roads.length[road[a]])
        begin, end = max(0.0, float(s[a] - half[a])), min(length, float(s[b] + half[b]))
        if float(2.0 * half[a : b + 1].sum()) >= min(LEAST_MATCH, 0.5 * length):
            out.append(WayOnRoad(int(road[a]), int(kept_ways[way[a]]), begin, end))
    return sorted(out, key=lambda item: (item.road, item.begin, item.end, item.way))


@record(eq=False)
class Terrain:
    """The ground as a grid."""

    # South-western point, m
    x: float
    y: float
    # Spacing of columns and rows, m
    dx: float
    dy: float
    z: FloatArray  # (rows, columns) Heights, m, from south to north; NaN where nothing is measured


@record
class HeightErrors:
    """Height of some roads above the ground."""

    label: str  # Which roads
    length: float  # Length with known heights, m
    # m; p95 and largest are of the magnitude
    mean: float
    rms: float
    p95: float
    largest: float


def read_ground(
    about: ReportOptions, scene: Scene, frame: Frame, diagnostics: Diagnostics
) -> tuple[FloatArray, Terrain, Callable[[FloatArray, FloatArray], FloatArray]]:
    """Return the height of the ground at the stations, (stations,), m, NaN where it is not measured, and on a grid.

    Heights are those of the file: the header's offset is subtracted. Also returned is what gives them at other
    inertial x, y around the roads.

    Raises
    ------
    InputError
        An elevation model cannot be used.
    CoverageError
        No elevation model has heights at the roads.
    """
    columns, rows, corner, steps = _grid(scene)
    grid_x, grid_y = np.meshgrid(corner[0] + steps[0] * np.arange(columns), corner[1] + steps[1] * np.arange(rows))
    around = places_around(scene.x, scene.y)
    x = np.concatenate((around[0], grid_x.ravel()))
    y = np.concatenate((around[1], grid_y.ravel()))
    # Heights are shown as they are, with trees and roofs if the model has them.
    options = SurfaceOptions(
        dem_type="dtm", dem_crs=about.dem_crs, dem_unit=about.dem_unit, dem_encoding=about.dem_encoding
    )
    height, _ = read_heights(about.dem, frame, x, y, options, diagnostics)
    z = height(grid_x.ravel(), grid_y.ravel()).reshape(rows, columns)
    return height(scene.x, scene.y), Terrain(corner[0], corner[1], steps[0], steps[1], z), height


def _grid(scene: Scene) -> tuple[int, int, tuple[float, float], tuple[float, float]]:
    """Return columns, rows, south-western point and spacings (m) of a grid around the roads."""
    west, east = float(np.min(scene.x)), float(np.max(scene.x))
    south, north = float(np.min(scene.y)), float(np.max(scene.y))
    margin = max(_LEAST_MARGIN, _MARGIN_SHARE * max(east - west, north - south))
    width, height = east - west + 2.0 * margin, north - south + 2.0 * margin
    step = float(np.sqrt(width * height / _GRID_POINTS))
    columns, rows = max(2, int(width / step) + 1), max(2, int(height / step) + 1)
    return columns, rows, (west - margin, south - margin), (width / (columns - 1), height / (rows - 1))


def station_lengths(scene: Scene) -> FloatArray:
    """Return the length that each station stands for, (stations,), m: half of the distances to its neighbours."""
    gap = np.diff(scene.s)
    gap[np.diff(scene.station_strip) != 0] = 0.0
    out = np.zeros(len(scene.s))
    out[:-1] += 0.5 * gap
    out[1:] += 0.5 * gap
    return out


def height_errors(scene: Scene, groups: Sequence[tuple[str, BoolArray]]) -> list[HeightErrors]:
    """Summarise heights above the ground by groups of stations, each weighted by the length it stands for.

    Groups without a known height are left out.
    """
    heights, lengths = scene.z - scene.ground, station_lengths(scene)
    out = []
    for label, rows in groups:
        kept = rows & np.isfinite(heights) & (lengths > 0.0)
        if not kept.any():
            continue
        error, weight = heights[kept], lengths[kept]
        size = np.abs(error)
        order = np.argsort(size, kind="stable")
        reached = np.searchsorted(np.cumsum(weight[order]), 0.95 * weight.sum())
        mean, square = (float(np.average(values, weights=weight)) for values in (error, error**2))
        p95 = float(size[order][min(int(reached), len(order) - 1)])
        out.append(HeightErrors(label, float(weight.sum()), mean, math.sqrt(square), p95, float(size.max())))
    return out


def worst_stations(value: FloatArray, scene: Scene, rows: BoolArray, most: int) -> IntArray:
    """Return the station with the largest magnitude on each road, the largest first, at most `most`."""
    at = np.flatnonzero(rows & np.isfinite(value))
    road = scene.station_road[at]
    order = np.lexsort((at, -np.abs(value[at]), road))
    first = np.diff(road[order], prepend=-1) != 0
    best = at[order][first]
    return np.asarray(best[np.lexsort((best, -np.abs(value[best])))][:most])
