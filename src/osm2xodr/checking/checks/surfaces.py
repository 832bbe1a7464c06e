"""Surfaces: roads that overlap at one height or at different ones, and how much room one leaves above another."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.checking.checks.common import LaneIndex, above, road_place, worst_of
from osm2xodr.checking.findings import LEVEL_HEIGHT, RULES, Findings
from osm2xodr.curves import (
    CLEARANCE_STEP,
    PointTree,
    RoadGraph,
    Stations,
    Table,
    close_places,
    join_tables,
    ranks,
    repeated,
    runs,
    sorted_unique,
    unique_all,
)
from osm2xodr.errors import InputError
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import (
    ABSENT,
    LinkKind,
    OpenDrive,
    elevation,
    grade,
    lane_borders,
    pose,
    refuse_crowds,
    section_at,
    superelevation,
)
from osm2xodr.system import available_jobs, map_parallel, record

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
# Below this slope, m/m, the widest carriageways lie in one cell from edge to edge.
_FALL: Final = 1e-4
# Bits of more than the cells of any file along y.
_BITS: Final = 31
_CELLS: Final = 1 << _BITS
# Cells along each side of a square, as a power of two: about as many as carriageways are wide, so that most squares
# have one road.
_SQUARE: Final = 4
# More than the stations of any road.
_MOST_STATIONS: Final = 1 << 23
# Slots of the table in which cells of several roads are looked for, more than there are cells in a block; and a prime
# number by which neighbours along x lie apart there, more than most carriageways have cells along y.
_SLOTS: Final = 1 << 22
_APART: Final = 8191
# Stations whose surfaces are compared at once, about, and points of them: more would take much memory.
_BLOCK: Final = 1 << 17
_POINTS: Final = 1 << 20
# Most points in squares that roads share, or for each record of the plan view if that is more. Choices: of 20 files
# of this program and 4 of another one the densest has 200 for each record.
_SHARED: Final = 5e7
_SHARED_EACH: Final = 5e3


@record
class Carriageways:
    """Carriageways at stations of roads, from the leftmost to the rightmost driving lane."""

    # (n,) Places on the reference line, m, rad; slope across the road, rad
    road: IntArray
    k: IntArray  # Which of the road's stations
    s: FloatArray
    x: FloatArray
    y: FloatArray
    z: FloatArray
    hdg: FloatArray
    bank: FloatArray
    # (n,) t of the right and the left edge, m
    low: FloatArray
    high: FloatArray

    def points(self, row: IntArray, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return x, y, z beside stations."""
        return *self.places(row, t), self.heights(row, t)

    def places(self, row: IntArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return x, y beside stations."""
        level = np.cos(self.bank)
        return (
            self.x[row] - (np.sin(self.hdg) * level)[row] * t,
            self.y[row] + (np.cos(self.hdg) * level)[row] * t,
        )

    def heights(self, row: IntArray, t: FloatArray) -> FloatArray:
        """Return z beside stations."""
        return np.asarray(self.z[row] + np.sin(self.bank[row]) * t)

    def gradients(self, drive: OpenDrive, row: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the slope of the surface along x and y at stations, m/m."""
        rise = grade(drive, self.road[row], self.s[row])
        cos, sin, bank = np.cos(self.hdg[row]), np.sin(self.hdg[row]), np.tan(self.bank[row])
        return rise * cos - bank * sin, rise * sin + bank * cos


def check_surfaces(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check places that belong to several roads."""
    if any(map(findings.wants, ("junction-surface", "overlap", "clearance"))):
        refuse_crowds(drive)
    if findings.wants("junction-surface"):
        _check_junctions(drive, lanes, findings)
    if findings.wants("overlap"):
        _check_overlaps(drive, lanes, findings)


def carriageways(drive: OpenDrive, lanes: LaneIndex, roads: IntArray, step: float) -> Carriageways:
    """Return the carriageways of some roads at every `step` along them, m."""
    count = _station_count(drive, roads, step)
    return carriageways_at(drive, lanes, np.repeat(roads, count), ranks(count), step)


def carriageways_at(drive: OpenDrive, lanes: LaneIndex, road: IntArray, k: IntArray, step: float) -> Carriageways:
    """Return what `carriageways` does, at some of the places: the k-th ones of roads."""
    s = drive.roads.length[road] * k / (_station_count(drive, road, step) - 1)
    section = section_at(drive, road, s)
    first, last = _outer_driving(drive, lanes)
    known = (section != ABSENT) & (_at(first, section) >= 0)
    road, k, s, section = road[known], k[known], s[known], section[known]
    left = lane_borders(drive, first[section], s)
    right = lane_borders(drive, last[section], s)
    x, y, hdg = pose(drive, road, s)
    high, low = np.maximum(*left), np.minimum(*right)
    z, bank = elevation(drive, road, s), superelevation(drive, road, s)
    # Comparisons with NaN are false.
    good = (np.abs(x) < _FARTHEST) & (np.abs(y) < _FARTHEST) & (high - low < _WIDEST) & (np.abs(high) < _WIDEST)
    # Where a height is known, so is the grade.
    good &= np.isfinite(z) & np.isfinite(bank) & np.isfinite(hdg)
    columns = (road, k, s, x, y, z, hdg, bank, low, high)
    return Carriageways(*(column[good] for column in columns))


def _station_count(drive: OpenDrive, roads: IntArray, step: float) -> IntArray:
    """Return the number of places at every `step` along roads, (n,)."""
    return np.asarray(np.maximum((drive.roads.length[roads] / step).astype(np.int64) + 1, 2))


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
    return np.split(roads, _cuts(drive.roads.junction[roads], drive.roads.length[roads] / _STEP))


def _cuts(group: IntArray, stations: FloatArray | IntArray, most: int | None = None) -> IntArray:
    """Return where to cut rows with so many stations into blocks; ascending groups stay whole, (blocks - 1,)."""
    block = (np.cumsum(stations) / (most or _BLOCK)).astype(np.int64)
    # A group belongs to the block of its first row.
    cuts = np.searchsorted(group, group[np.flatnonzero(np.diff(block)) + 1])
    return sorted_unique(cuts[cuts > 0])


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
    pairs = np.column_stack(PointTree(place).within(place, _ONE_PLACE))
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]
    road = ways.road[row]
    a, b = road[pairs[:, 0]], road[pairs[:, 1]]
    dx, dy, dz = (values[pairs[:, 0]] - values[pairs[:, 1]] for values in (x, y, z))
    # The two places are near each other, but not the same: what the surfaces rise between them is no step.
    gradients = (ways.gradients(drive, row[pairs[:, k]]) for k in (0, 1))
    rise_x, rise_y = ((one + two) / 2 for one, two in zip(*gradients, strict=True))
    apart = np.abs(dz - dx * rise_x - dy * rise_y)
    wanted = np.flatnonzero((a != b) & above("junction-surface", apart) & (apart < LEVEL_HEIGHT))
    low, high = np.minimum(a, b)[wanted], np.maximum(a, b)[wanted]
    first = np.where(a[wanted] <= b[wanted], pairs[wanted, 0], pairs[wanted, 1])
    return low, high, apart[wanted], road[first], ways.s[row[first]]


@record
class _Shared(Table):
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
    pair, first, _, cells = unique_all(shared.low * len(length) + shared.high)
    area = cells * _CELL**2
    bad = np.flatnonzero(above("overlap", area))
    one, other = pair[bad] // len(length), pair[bad] % len(length)
    findings.add(
        "overlap",
        value=area[bad],
        other=lambda k: f"road {drive.roads.id[int(other[k])]}",
        **road_place(drive, one, shared.s[first[bad]]),
    )


@record
class _Stretches(Table):
    """Stretches of roads in squares of cells: keys of the squares, roads, first and last station, m across there."""

    key: IntArray
    road: IntArray
    first: IntArray
    last: IntArray
    across: FloatArray

    def points(self, spacing: float) -> FloatArray:
        """Return the number of points in each, about, at a spacing across, m."""
        return np.asarray((self.last - self.first + 1) * np.ceil(self.across / spacing))


def _shared_by_bands(drive: OpenDrive, lanes: LaneIndex, roads: IntArray, step: float, spacing: float) -> _Shared:
    """Return the cells that belong to two of some roads, from points at a step along and a spacing across, m."""
    blocks = np.split(roads, _cuts(np.arange(len(roads)), drive.roads.length[roads] / step))
    parts = map_parallel(
        lambda block: _in_squares(drive, carriageways(drive, lanes, block, step)), blocks, available_jobs()
    )
    in_squares = join_tables(parts)
    # Most squares have one road: nothing in them is looked at.
    near = in_squares.chosen(_with_several(in_squares.key, in_squares.road))
    points = near.points(spacing)
    if float(points.sum()) > max(_SHARED, _SHARED_EACH * len(drive.plan_view.s)):
        name = drive.roads.id[int(near.road[points.argmax()])]
        raise InputError(
            f"{drive.path}: roads lie on or beside each other over too large an area to compare them, such as road"
            f" {name!r}; check it in parts, or with --ignore overlap"
        )

    def shared(band: _Stretches) -> _Shared:
        return _shared_cells(drive, _ways_in(drive, lanes, band, step), spacing, band)

    return join_tables(map_parallel(shared, _bands(near, spacing), available_jobs()))


def _in_squares(drive: OpenDrive, ways: Carriageways) -> _Stretches:
    """Return the stretches of roads in squares, from stations of all of them; several where a road comes back."""
    at = np.flatnonzero(_inside(drive, ways))
    edges = [np.floor([axis / _CELL for axis in ways.places(at, t[at])]) for t in (ways.low, ways.high)]
    # What lies between both edges may be rounded into the next cell.
    first, last = np.minimum(*edges) - 1, np.maximum(*edges) + 1
    bounds = [*(first.astype(np.int64) >> _SQUARE), *(last.astype(np.int64) >> _SQUARE)]
    # Neighbours are mostly in the same squares.
    changes = _changes(ways.road[at], *bounds)
    begin, end = np.flatnonzero(changes), np.flatnonzero(np.append(changes[1:], [True] * (len(at) > 0)))
    left, low, right, high = (bound[begin] for bound in bounds)
    across = high - low + 1
    count = (right - left + 1) * across
    run, rank = repeated(count), ranks(count)
    # Lines count from one far below, so that keys tell columns.
    key = (left[run] + rank // across[run]) * _CELLS + (_CELLS // 2 + low[run] + rank % across[run])
    widest = np.maximum.reduceat((ways.high - ways.low)[at], begin) if len(begin) else np.zeros(0)
    columns = (ways.road[at[begin]], ways.k[at[begin]], ways.k[at[end]], np.minimum(widest, _CELL * 2**_SQUARE))
    return _Stretches(key, *(column[run] for column in columns))


def _bands(near: _Stretches, spacing: float) -> list[_Stretches]:
    """Divide stretches into bands of columns of squares, each with about as many points as are compared at once."""
    near = near.chosen(np.argsort(near.key, kind="stable"))
    cuts = _cuts(near.key >> _BITS, near.points(spacing), _POINTS)
    return [near.chosen(rows) for rows in np.split(np.arange(len(near.key)), cuts)]


def _ways_in(drive: OpenDrive, lanes: LaneIndex, band: _Stretches, step: float) -> Carriageways:
    """Return the carriageways at the stations of stretches."""
    count = band.last - band.first + 1
    station = sorted_unique(np.repeat(band.road, count) * _MOST_STATIONS + runs(band.first, count))
    return carriageways_at(drive, lanes, station // _MOST_STATIONS, station % _MOST_STATIONS, step)


def _inside(drive: OpenDrive, ways: Carriageways) -> BoolArray:
    """Whether stations are not near the ends of their roads, and wide enough to have points, (n,)."""
    along = (ways.s > _END_MARGIN) & (ways.s < drive.roads.length[ways.road] - _END_MARGIN)
    return np.asarray(along & (ways.high - ways.low > 2 * _EDGE_MARGIN))


def _shared_cells(drive: OpenDrive, ways: Carriageways, spacing: float, band: _Stretches) -> _Shared:
    """Return the cells that belong to two roads in a band, from points at a spacing across, m."""
    inside = np.flatnonzero(_inside(drive, ways))
    # In other bands not all stations with these cells are known.
    ends = band.key[[0, -1]] >> _BITS if len(band.key) else np.array([0, -1])
    first, end = _across(ways, inside, spacing, (ends + np.arange(2)) * (_CELL * 2**_SQUARE))
    count = np.maximum(end - first, 0)
    row = np.repeat(inside, count)
    t = ways.low[row] + _EDGE_MARGIN + runs(first, count) * spacing
    column, line = (np.floor(axis / _CELL).astype(np.int64) for axis in ways.places(row, t))
    key = column * _CELLS + line
    square = column >> _SQUARE
    within = np.flatnonzero((square >= ends[0]) & (square <= ends[1]))
    several = within[_with_several(key[within], ways.road[row[within]])]
    key, row = key[several], row[several]
    road, z = ways.road[row], ways.heights(row, t[several])
    # One entry for each cell and road, then in each cell from below.
    order = np.lexsort((road, key))
    order = order[_changes(key[order], road[order])]
    order = order[np.lexsort((z[order], key[order]))]
    key, road, z, row = key[order], road[order], z[order], row[order]
    both = np.flatnonzero((key[1:] == key[:-1]) & (z[1:] - z[:-1] < LEVEL_HEIGHT))
    first = np.where(road[both] < road[both + 1], both, both + 1)
    last = np.where(road[both] < road[both + 1], both + 1, both)
    return _Shared(road[first], road[last], ways.s[row[first]])


def _across(ways: Carriageways, row: IntArray, spacing: float, west_east: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the first point across stations that may lie in a band, and the one behind the last, (rows,)."""
    begin = ways.low[row] + _EDGE_MARGIN
    whole = np.maximum(np.ceil(((ways.high - ways.low)[row] - 2 * _EDGE_MARGIN) / spacing), 0.0)
    # x falls with t by this. Where it hardly does, all points may.
    fall = np.sin(ways.hdg[row]) * np.cos(ways.bank[row])
    steep = np.abs(fall) > _FALL
    at = ((ways.x[row] - west_east[:, None]) / np.where(steep, fall, 1.0) - begin) / spacing
    first = np.where(steep, np.clip(np.floor(at.min(axis=0)), 0.0, whole), 0.0)
    end = np.where(steep, np.clip(np.ceil(at.max(axis=0)) + 1.0, 0.0, whole), whole)
    return first.astype(np.int64), end.astype(np.int64)


def _with_several(key: IntArray, road: IntArray) -> IntArray:
    """Return the entries whose keys belong to several roads, ascending; few do."""
    # Keys share slots of a table; those in slots of one road alone need no sorting.
    slot = ((key >> _BITS) * _APART + key) & (_SLOTS - 1)
    table, shared = np.empty(_SLOTS, np.int64), np.zeros(_SLOTS, bool)
    table[slot] = road
    shared[slot[table[slot] != road]] = True
    some = np.flatnonzero(shared[slot])
    return some[_sorted_with_several(key[some], road[some])]


def _sorted_with_several(key: IntArray, road: IntArray) -> IntArray:
    """Return what `_with_several` does, by sorting all keys."""
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


def check_clearances(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check places where carriageways that do not meet lie over each other: one finding for each, at its worst."""
    if not findings.wants("clearance"):
        return
    limit = RULES["clearance"].limit
    assert limit is not None
    found = close_places(iter((_stations(drive, lanes),)), _graph(drive), limit.value)
    findings.add(
        "clearance",
        value=found.height,
        other=lambda k: f"road {drive.roads.id[int(found.other[k])]}",
        **road_place(drive, found.road, found.s),
    )


def _stations(drive: OpenDrive, lanes: LaneIndex) -> Stations:
    """Return the edges of all carriageways."""
    ways = carriageways(drive, lanes, np.flatnonzero(has_length(drive)), CLEARANCE_STEP)
    row = np.arange(len(ways.s))
    right, left = (np.column_stack(ways.points(row, t)) for t in (ways.low, ways.high))
    return Stations(ways.road, ways.s, ways.hdg, right, left)


def _graph(drive: OpenDrive) -> RoadGraph:
    """Return which roads of a file meet."""
    roads = drive.roads
    at_junction = (roads.link_kind == LinkKind.JUNCTION) & (roads.link >= 0)
    inside = roads.junction >= 0
    junction = np.where(at_junction, roads.link, -1)
    junction[inside] = roads.junction[inside, None]
    road, end = np.nonzero((roads.link_kind == LinkKind.ROAD) & (roads.link >= 0))
    return RoadGraph(roads.length, inside, junction, road.astype(np.int64), roads.link[road, end])
