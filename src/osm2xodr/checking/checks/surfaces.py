"""Surfaces: connecting roads that overlap at different heights, carriageways that overlap at the same height."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.spatial import cKDTree

from osm2xodr.checking import defaults
from osm2xodr.checking.checks.common import above, road_place, worst_of
from osm2xodr.checking.checks.index import LaneIndex
from osm2xodr.checking.findings import Findings
from osm2xodr.curves import ranks
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, OpenDrive, elevation, grade, lane_borders, pose, section_at, superelevation
from osm2xodr.system import available_jobs, map_parallel

# Surfaces of junctions: step of the samples along a road, m, and their shares of the carriageway's width; samples of
# two roads that are nearer than the last, m, are one place.
_STEP: Final = 1.0
_SHARES: Final = (0.05, 0.35, 0.65, 0.95)
_ONE_PLACE: Final = 0.12
# Overlaps are counted in cells of this size, m, this far from the edges and the ends of a carriageway, m.
_CELL: Final = 0.7
_EDGE_MARGIN: Final = 0.4
_END_MARGIN: Final = 1.5
# Roads shorter than this are too short to overlap another for long, m.
_SHORTEST: Final = 4.0
# Roads longer, carriageways wider and places farther away than these are left out, m: they come from damaged numbers,
# which other rules report, and would take all memory.
_LONGEST: Final = 1e6
_WIDEST: Final = 1e3
_FARTHEST: Final = 1e9
# More than the cells of any file along y.
_CELLS: Final = 1 << 31
# Stations whose surfaces are compared at once, about: more would take much memory.
_BLOCK: Final = 1 << 17


@dataclass(frozen=True)
class Carriageways:
    """Carriageways at stations of roads, from the leftmost to the rightmost driving lane."""

    # (n,) Places on the reference line, m, rad; slope along (m/m) and across the road (rad)
    road: IntArray
    s: FloatArray
    x: FloatArray
    y: FloatArray
    z: FloatArray
    hdg: FloatArray
    grade: FloatArray
    bank: FloatArray
    # (n,) t of the right and the left edge, m
    low: FloatArray
    high: FloatArray

    def points(self, row: IntArray, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return x, y, z beside stations."""
        level = np.cos(self.bank)
        return (
            self.x[row] - (np.sin(self.hdg) * level)[row] * t,
            self.y[row] + (np.cos(self.hdg) * level)[row] * t,
            self.z[row] + np.sin(self.bank)[row] * t,
        )

    def gradients(self, row: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the slope of the surface along x and y at stations, m/m."""
        cos, sin, rise, bank = np.cos(self.hdg[row]), np.sin(self.hdg[row]), self.grade[row], np.tan(self.bank[row])
        return rise * cos - bank * sin, rise * sin + bank * cos


def check_surfaces(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check places that belong to several roads."""
    if findings.wants("junction-surface"):
        _check_junctions(drive, lanes, findings)
    if findings.wants("overlap"):
        _check_overlaps(drive, lanes, findings)


def carriageways(drive: OpenDrive, lanes: LaneIndex, roads: IntArray, step: float) -> Carriageways:
    """Return the carriageways of some roads at every `step` along them, m."""
    length = drive.roads.length[roads]
    count = np.maximum((length / step).astype(np.int64) + 1, 2)
    road = np.repeat(roads, count)
    k = ranks(count)
    s = np.repeat(length, count) * k / np.repeat(count - 1, count)
    section = section_at(drive, road, s)
    first, last = _outer_driving(drive, lanes)
    known = (section != ABSENT) & (_at(first, section) >= 0)
    road, s, section = road[known], s[known], section[known]
    left = lane_borders(drive, first[section], s)
    right = lane_borders(drive, last[section], s)
    x, y, hdg = pose(drive, road, s)
    high, low = np.maximum(*left), np.minimum(*right)
    z, rise, bank = elevation(drive, road, s), grade(drive, road, s), superelevation(drive, road, s)
    # Comparisons with NaN are false.
    good = (np.abs(x) < _FARTHEST) & (np.abs(y) < _FARTHEST) & (high - low < _WIDEST) & (np.abs(high) < _WIDEST)
    good &= np.isfinite(z) & np.isfinite(rise) & np.isfinite(bank) & np.isfinite(hdg)
    columns = (road, s, x, y, z, hdg, rise, bank, low, high)
    return Carriageways(*(column[good] for column in columns))


def _outer_driving(drive: OpenDrive, lanes: LaneIndex) -> tuple[IntArray, IntArray]:
    """Return the leftmost and the rightmost driving lane of each section; -1 where there is none."""
    section = drive.lanes.section
    first, last = (np.full(len(drive.sections.s), -1, np.int64) for _ in range(2))
    row = np.flatnonzero(lanes.driving)
    # Lanes are stored from left to right; of several assignments the last one stays.
    first[section[row[::-1]]] = row[::-1]
    last[section[row]] = row
    return first, last


def _at(values: IntArray, index: IntArray) -> IntArray:
    """Return values by index; -1 where there is none."""
    return np.asarray(np.append(values, -1)[np.where(index == ABSENT, len(values), index)])


def has_length(drive: OpenDrive) -> BoolArray:
    """Whether roads have a length, (roads,), so that something can lie on them."""
    return np.asarray((drive.roads.length < _LONGEST) & (drive.roads.length > 0))


def _check_junctions(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check connecting roads: one finding for each pair, where it is worst."""
    parts = map_parallel(
        lambda roads: _steps(drive, carriageways(drive, lanes, roads, _STEP)), _by_junction(drive), available_jobs()
    )
    low, high, apart, road, s = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    worst = worst_of(low * len(drive.roads.id) + high, apart)
    other = high[worst]
    findings.add(
        "junction-surface",
        value=apart[worst],
        other=lambda k: f"road {drive.roads.id[int(other[k])]}",
        **road_place(drive, road[worst], s[worst]),
    )


def _by_junction(drive: OpenDrive) -> list[IntArray]:
    """Return all connecting roads, in parts that have whole junctions."""
    roads = np.flatnonzero(has_length(drive) & (drive.roads.junction >= 0))
    roads = roads[np.argsort(drive.roads.junction[roads], kind="stable")]
    junction = drive.roads.junction[roads]
    block = (np.cumsum(drive.roads.length[roads]) / (_BLOCK * _STEP)).astype(np.int64)
    # A junction belongs to the block of its first road.
    ends = np.searchsorted(junction, junction[np.flatnonzero(np.diff(block)) + 1])
    return np.split(roads, np.unique(ends[ends > 0]))


def _steps(drive: OpenDrive, ways: Carriageways) -> tuple[IntArray, IntArray, FloatArray, IntArray, FloatArray]:
    """Return steps between surfaces: both roads, the lower first, the step, m, and road and s of a place of it."""
    n = len(ways.road)
    if n == 0:
        none = np.zeros(0, np.int64)
        return none, none, np.zeros(0), none, np.zeros(0)
    row = np.tile(np.arange(n), len(_SHARES))
    share = np.repeat(_SHARES, n)
    x, y, z = ways.points(row, ways.low[row] + share * (ways.high - ways.low)[row])
    # The junction as a third coordinate keeps junctions apart.
    place = np.column_stack([x, y, drive.roads.junction[ways.road[row]].astype(np.float64)])
    pairs = cKDTree(place).query_pairs(_ONE_PLACE, output_type="ndarray")
    road = ways.road[row]
    a, b = road[pairs[:, 0]], road[pairs[:, 1]]
    dx, dy, dz = (values[pairs[:, 0]] - values[pairs[:, 1]] for values in (x, y, z))
    # The two places are near each other, but not the same: what the surfaces rise between them is no step.
    gradients = (ways.gradients(row[pairs[:, k]]) for k in (0, 1))
    rise_x, rise_y = ((one + two) / 2 for one, two in zip(*gradients, strict=True))
    apart = np.abs(dz - dx * rise_x - dy * rise_y)
    wanted = np.flatnonzero((a != b) & above("junction-surface", apart) & (apart < defaults.LEVEL_HEIGHT))
    low, high = np.minimum(a, b)[wanted], np.maximum(a, b)[wanted]
    first = np.where(a[wanted] <= b[wanted], pairs[wanted, 0], pairs[wanted, 1])
    return low, high, apart[wanted], road[first], ways.s[row[first]]


@dataclass(frozen=True)
class _Shared:
    """Cells that belong to two roads at one height: indices of both roads, the lower first, and an s of that one."""

    low: IntArray
    high: IntArray
    s: FloatArray


def _check_overlaps(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check roads outside of junctions: one finding for each pair, with the area that belongs to both."""
    length = drive.roads.length
    roads = np.flatnonzero(has_length(drive) & (drive.roads.junction == -1) & (length > _SHORTEST))
    rough = _shared_by_bands(drive, lanes, roads, _STEP, _CELL)
    # At this spacing cells are missed. The few roads that overlap are sampled again, closely.
    roads = np.union1d(rough.low, rough.high)
    shared = _shared_by_bands(drive, lanes, roads, _CELL / 2, _CELL / 2)
    pair, first, cells = np.unique(shared.low * len(length) + shared.high, return_index=True, return_counts=True)
    area = cells * _CELL**2
    bad = np.flatnonzero(above("overlap", area))
    one, other = pair[bad] // len(length), pair[bad] % len(length)
    findings.add(
        "overlap",
        value=area[bad],
        other=lambda k: f"road {drive.roads.id[int(other[k])]}",
        **road_place(drive, one, shared.s[first[bad]]),
    )


def _shared_by_bands(drive: OpenDrive, lanes: LaneIndex, roads: IntArray, step: float, spacing: float) -> _Shared:
    """Return the cells that belong to two of some roads, from points at a step along and a spacing across, m."""

    def shared(band: tuple[IntArray, tuple[float, float]]) -> _Shared:
        some, columns = band
        return _shared_cells(drive, carriageways(drive, lanes, some, step), spacing, columns)

    parts = list(map_parallel(shared, list(_bands(drive, lanes, roads, step)), available_jobs()))
    return _Shared(*(np.concatenate([getattr(part, name) for part in parts]) for name in ("low", "high", "s")))


def _bands(
    drive: OpenDrive, lanes: LaneIndex, roads: IntArray, step: float
) -> Iterator[tuple[IntArray, tuple[float, float]]]:
    """Yield roads that reach into a band of columns of cells, and the first column and that behind the last."""
    stations = drive.roads.length[roads] / step
    blocks = np.split(roads, np.flatnonzero(np.diff((np.cumsum(stations) / _BLOCK).astype(np.int64))) + 1)
    if len(blocks) == 1:
        yield roads, (-np.inf, np.inf)
        return
    west, east = np.full(len(drive.roads.id), np.inf), np.full(len(drive.roads.id), -np.inf)
    for block in blocks:
        ways = carriageways(drive, lanes, block, step)
        for t in (ways.low, ways.high):
            column = np.floor(ways.points(np.arange(len(t)), t)[0] / _CELL)
            # What lies between both edges may be rounded into the next column.
            np.minimum.at(west, ways.road, column - 1)
            np.maximum.at(east, ways.road, column + 1)
    order = np.argsort(west[roads], kind="stable")
    block = (np.cumsum(stations[order]) / _BLOCK).astype(np.int64)
    bounds = np.unique(west[roads][order][np.flatnonzero(np.diff(block)) + 1])
    bounds = bounds[np.isfinite(bounds)]
    for first, last in zip([-np.inf, *bounds], [*bounds, np.inf], strict=True):
        yield roads[(west[roads] < last) & (east[roads] >= first)], (float(first), float(last))


def _shared_cells(drive: OpenDrive, ways: Carriageways, spacing: float, columns: tuple[float, float]) -> _Shared:
    """Return the cells in some columns that belong to two roads, from points at a spacing across, m."""
    inside = np.flatnonzero((ways.s > _END_MARGIN) & (ways.s < drive.roads.length[ways.road] - _END_MARGIN))
    room = (ways.high - ways.low)[inside] - 2 * _EDGE_MARGIN
    count = np.maximum(np.ceil(room / spacing), 0).astype(np.int64)
    row = np.repeat(inside, count)
    k = ranks(count)
    x, y, z = ways.points(row, ways.low[row] + _EDGE_MARGIN + k * spacing)
    column = np.floor(x / _CELL)
    key = column.astype(np.int64) * _CELLS + np.floor(y / _CELL).astype(np.int64)
    within = (column >= columns[0]) & (column < columns[1])
    if not within.all():
        key, z, row = key[within], z[within], row[within]
    del x, y, k, column, within
    road = ways.road[row]
    several = _with_several(key, road)
    key, z, row, road = key[several], z[several], row[several], road[several]
    # One entry for each cell and road, then in each cell from below.
    order = np.lexsort((road, key))
    order = order[_changes(key[order], road[order])]
    order = order[np.lexsort((z[order], key[order]))]
    key, road, z, row = key[order], road[order], z[order], row[order]
    both = np.flatnonzero((key[1:] == key[:-1]) & (z[1:] - z[:-1] < defaults.LEVEL_HEIGHT))
    first = np.where(road[both] < road[both + 1], both, both + 1)
    last = np.where(road[both] < road[both + 1], both + 1, both)
    return _Shared(road[first], road[last], ways.s[row[first]])


def _with_several(key: IntArray, road: IntArray) -> IntArray:
    """Return the entries whose keys belong to several roads, ascending; few do."""
    order = np.argsort(key)
    first = np.flatnonzero(_changes(key[order]))
    if not len(first):
        return first
    of = road[order]
    several = np.minimum.reduceat(of, first) != np.maximum.reduceat(of, first)
    return np.sort(order[np.repeat(several, np.diff(np.append(first, len(key))))])


def _changes(*columns: IntArray) -> BoolArray:
    """Whether each row differs from the one before it, (n,)."""
    out = np.ones(len(columns[0]), bool)
    out[1:] = np.any([column[1:] != column[:-1] for column in columns], axis=0)
    return out
