"""From road coordinates to inertial ones: reference lines, lanes across the road, and heights as functions of s.

Many places are evaluated block by block, so that what is needed on the way stays small beside the result.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from typing import Any, Final, TypeVar, cast
from weakref import WeakKeyDictionary

import numpy as np

from osm2xodr.curves import arc_step, cubic_value, find_record, runs
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive.tables import ABSENT, GeometryTable, OpenDrive, Shape
from osm2xodr.system import record

# Arc lengths of polynomials: panels per record, and rounds of Newton's method inside one.
_PANELS: Final = 8
_NEWTON_ROUNDS: Final = 8
# Newton's method ends where the arc length is off by less, m: its last step has then squared the error.
_ARC_TOLERANCE: Final = 1e-6
# Least speed of a polynomial curve that steps are divided by, m per unit of its parameter.
_LEAST_SPEED: Final = 1e-12

# Gauss-Legendre nodes of a panel from -1 to 1, and their weights (Abramowitz and Stegun 1964, table 25.4).
_HALF_PANEL: Final = (
    (0.23861918608319690863, 0.46791393457269104739),
    (0.66120938646626451366, 0.36076157304813860757),
    (0.93246951420315202781, 0.17132449237917034504),
)
_PANEL: Final = (*((-node, weight) for node, weight in reversed(_HALF_PANEL)), *_HALF_PANEL)

_Triple = tuple[FloatArray, FloatArray, FloatArray]
_Quadruple = tuple[FloatArray, FloatArray, FloatArray, FloatArray]

# Places of a block: what is needed on the way to their results, some twenty numbers each, stays in caches of 2 MB.
BLOCK: Final = 1 << 14

_Function = TypeVar("_Function", bound=Callable[..., Any])


def pose(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> _Triple:
    """Return x, y (m) and heading (rad, not wrapped) of reference lines at s."""
    x, y, hdg, _ = pose_and_curvature(file, road, s, before=before)
    return x, y, hdg


def in_blocks(function: _Function) -> _Function:
    """Evaluate a function of a file, rows (n,) and s (n,) in blocks; it returns an array (n,), or several of them."""

    @functools.wraps(function)
    def evaluated(file: Any, rows: Any, s: Any, **options: Any) -> Any:
        if len(s) <= BLOCK:
            return function(file, rows, s, **options)
        out: list[Any] = []
        single = False
        for first in range(0, len(s), BLOCK):
            at = slice(first, first + BLOCK)
            found = function(file, rows[at], s[at], **options)
            single = not isinstance(found, tuple)
            columns = (found,) if single else found
            out = out or [np.empty(len(s), column.dtype) for column in columns]
            for whole, column in zip(out, columns, strict=True):
                whole[at] = column
        return out[0] if single else tuple(out)

    return cast("_Function", evaluated)


@in_blocks
def curvature(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return the curvature of reference lines at s, 1/m, positive to the left."""
    plan = file.plan_view
    if not len(plan.s):
        return np.full(len(s), np.nan)
    k, without = _records_at(plan, road, s, before=before)
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        ds = s - plan.s[k]
        start, rate = _start_curvature(plan, k)
        bend = start if rate is None else start + rate * ds
        bent = np.flatnonzero((plan.shape[k] == Shape.POLY3) | (plan.shape[k] == Shape.PARAM_POLY3))
        if len(bent):
            bend[bent] = _polynomial_step(_polynomials(plan), k[bent], ds[bent])[3]
    bend[plan.shape[k] == Shape.UNKNOWN] = np.nan
    return _known(bend, without)


@in_blocks
def pose_and_curvature(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> _Quadruple:
    """Return what `pose` and `curvature` do, at the cost of one."""
    plan = file.plan_view
    if not len(plan.s):
        unknown = np.full(len(s), np.nan)
        return unknown, unknown.copy(), unknown.copy(), unknown.copy()
    k, without = _records_at(plan, road, s, before=before)
    # Damaged records may overflow: then the pose is unknown.
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        u, v, turn, bend = _local_pose(plan, k, s - plan.s[k])
    cos, sin = np.cos(plan.hdg[k]), np.sin(plan.hdg[k])
    x, y = plan.x[k] + cos * u - sin * v, plan.y[k] + sin * u + cos * v
    return _known(x, without), _known(y, without), _known(plan.hdg[k] + turn, without), _known(bend, without)


def _records_at(plan: GeometryTable, road: IntArray, s: FloatArray, *, before: bool) -> tuple[IntArray, IntArray]:
    """Return the records at s of roads, (n,), and the rows of roads without any, which get one all the same."""
    without = np.flatnonzero(plan.start[road + 1] == plan.start[road])
    if not len(without):
        return find_record(plan.start, plan.s, road, s, before=before), without
    k = np.zeros(len(s), np.int64)
    has = np.delete(np.arange(len(s)), without)
    k[has] = find_record(plan.start, plan.s, road[has], s[has], before=before)
    return k, without


def _known(values: FloatArray, without: IntArray) -> FloatArray:
    """Return values with NaN on roads without records and where they are infinite."""
    values[without] = np.nan
    values[np.flatnonzero(np.isinf(values))] = np.nan
    return values


def record_lengths(file: OpenDrive) -> FloatArray:
    """Return the arc length of every plan-view record, (records,), m.

    That is the length as written, except for ParamPoly3, whose parameters say where the curve ends.
    """
    plan = file.plan_view
    out = plan.length.copy()
    table = _polynomials(plan)
    ends = plan.shape[table.record] == Shape.PARAM_POLY3
    out[table.record[ends]] = table.arc[ends, -1]
    return out


def _local_pose(plan: GeometryTable, k: IntArray, ds: FloatArray) -> _Quadruple:
    """Return u, v, the turn and the curvature after ds of records, in the frames of their starts."""
    shape = plan.shape[k]
    bend, rate = _start_curvature(plan, k)
    u, v, turn = arc_step(bend, ds, 0.0 if rate is None else rate)
    if rate is not None:
        bend = bend + rate * ds
    bent = np.flatnonzero((shape == Shape.POLY3) | (shape == Shape.PARAM_POLY3))
    if len(bent):
        u[bent], v[bent], turn[bent], bend[bent] = _polynomial_step(_polynomials(plan), k[bent], ds[bent])
    unknown = shape == Shape.UNKNOWN
    u[unknown] = v[unknown] = turn[unknown] = bend[unknown] = np.nan
    return u, v, turn, bend


def _start_curvature(plan: GeometryTable, k: IntArray) -> tuple[FloatArray, FloatArray | None]:
    """Return the curvature of lines, arcs and spirals at the start of records, (n,), and its rate, if any changes."""
    shape = plan.shape[k]
    bend = np.zeros(len(k))
    curved = np.flatnonzero((shape == Shape.ARC) | (shape == Shape.SPIRAL))
    bend[curved] = plan.parameters[k[curved], 0]
    spiral = curved[shape[curved] == Shape.SPIRAL]
    if not len(spiral):
        return bend, None
    change, length = plan.parameters[k[spiral], 1] - bend[spiral], plan.length[k[spiral]]
    rate = np.zeros(len(k))
    rate[spiral] = np.where(length > 0, change / length, 0.0)
    return bend, rate


@record(eq=False)
class _Polynomials:
    """Poly3 and ParamPoly3 records as curves u(q), v(q), with their arc lengths."""

    record: IntArray  # (rows,) Index of each row's record
    row: IntArray  # (records,) Index of each record's row; 0 for other shapes
    # (rows, 4) Coefficients
    u: FloatArray
    v: FloatArray
    end: FloatArray  # (rows,) q at the end; of Poly3, a q beyond it
    arc: FloatArray  # (rows, panels + 1) Arc length at equal steps of q
    # (rows,) Arc length per s: 1, except where the length of a ParamPoly3 is not as written: all readers let it end
    # where its parameter does.
    scale: FloatArray


_CURVES: WeakKeyDictionary[GeometryTable, _Polynomials] = WeakKeyDictionary()


def _polynomials(plan: GeometryTable) -> _Polynomials:
    """Return the polynomials of a plan view; measured once, then remembered."""
    if plan in _CURVES:
        return _CURVES[plan]
    record = np.flatnonzero((plan.shape == Shape.POLY3) | (plan.shape == Shape.PARAM_POLY3))
    row = np.zeros(len(plan.shape), np.int64)
    row[record] = np.arange(len(record))
    p, length = plan.parameters[record], plan.length[record]
    plain = plan.shape[record] == Shape.POLY3
    u = np.where(plain[:, None], np.array([0.0, 1.0, 0.0, 0.0]), p[:, :4])
    v = np.where(plain[:, None], p[:, :4], p[:, 4:])
    end = np.where(plain | ~plan.normalized[record], length, 1.0)
    arc = np.zeros((len(record), _PANELS + 1))
    for panel in range(_PANELS):
        low, high = end * panel / _PANELS, end * (panel + 1) / _PANELS
        arc[:, panel + 1] = arc[:, panel] + _arc_length(u, v, low, high)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.where(plain, 1.0, np.where(length > 0, arc[:, -1] / length, 0.0))
    found = _CURVES[plan] = _Polynomials(record, row, u, v, end, arc, scale)
    return found


def _polynomial_step(table: _Polynomials, record: IntArray, ds: FloatArray) -> _Quadruple:
    """Return u, v, the turn and the curvature after ds of records, in the frames of their starts."""
    row = table.row[record]
    q = _parameter(table, row, ds)
    u, v = table.u[row], table.v[row]
    du, dv = _slope(u, q), _slope(v, q)
    ddu, ddv = 2 * u[:, 2] + 6 * q * u[:, 3], 2 * v[:, 2] + 6 * q * v[:, 3]
    bend = (du * ddv - dv * ddu) / np.hypot(du, dv) ** 3
    return _value(u, q), _value(v, q), np.arctan2(dv, du), bend


def _parameter(table: _Polynomials, row: IntArray, ds: FloatArray) -> FloatArray:
    """Return the parameters at arc lengths of polynomials, by Newton's method from a table."""
    goal = ds * table.scale[row]
    panel = np.clip((table.arc[row] <= goal[:, None]).sum(1) - 1, 0, _PANELS - 1)
    step = table.end[row] / _PANELS
    low = panel * step
    before, after = table.arc[row, panel], table.arc[row, panel + 1]
    u, v = table.u[row], table.v[row]
    q = np.where(after > before, low + step * (goal - before) / (after - before), low)
    # Inside the panel, unless the place lies beyond the record.
    least = np.where((panel == 0) & (goal < before), -np.inf, low)
    most = np.where((panel == _PANELS - 1) & (goal > after), np.inf, low + step)
    for _ in range(_NEWTON_ROUNDS):
        missing = goal - before - _arc_length(u, v, low, q)
        q = np.clip(q + missing / np.maximum(np.hypot(_slope(u, q), _slope(v, q)), _LEAST_SPEED), least, most)
        if not np.any(np.abs(missing) > _ARC_TOLERANCE):
            break
    return q


def _arc_length(u: FloatArray, v: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the arc length from one parameter to another."""
    half, middle = 0.5 * (high - low), 0.5 * (high + low)
    total = np.zeros(len(low))
    for node, weight in _PANEL:
        at = middle + half * node
        total += weight * np.hypot(_slope(u, at), _slope(v, at))
    return half * total


def _value(c: FloatArray, q: FloatArray) -> FloatArray:
    """Return the values of cubics with coefficients (n, 4)."""
    return c[:, 0] + q * (c[:, 1] + q * (c[:, 2] + q * c[:, 3]))


def _slope(c: FloatArray, q: FloatArray) -> FloatArray:
    """Return the derivatives of cubics with coefficients (n, 4)."""
    return c[:, 1] + q * (2 * c[:, 2] + q * (3 * c[:, 3]))


@in_blocks
def elevation(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return z of reference lines at s, m; 0 where a road has no elevation, as OpenDRIVE defines it."""
    return cubic_value(file.elevation, road, s, before=before)


@in_blocks
def grade(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return the rise of reference lines per metre of s."""
    return cubic_value(file.elevation, road, s, order=1, before=before)


@in_blocks
def superelevation(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return the roll of road surfaces about their reference lines at s, rad; positive where the left is higher."""
    return cubic_value(file.superelevation, road, s, before=before)


@in_blocks
def lane_offset(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return t of centre lanes at s, m."""
    return cubic_value(file.lane_offset, road, s, before=before)


def surface_points(
    file: OpenDrive,
    road: IntArray,
    s: FloatArray,
    t: FloatArray,
    h: FloatArray | float = 0.0,
    *,
    before: bool = False,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y, z of points at s, t of roads and h above their surface, m.

    The t axis is level and square to the reference line's projection, rolled by the superelevation; h is square to
    both. ``<shape>`` records of lateral profiles are left out. `before` asks for the limit from the left.
    """
    x, y, hdg = pose(file, road, s, before=before)
    z = elevation(file, road, s, before=before)
    roll = superelevation(file, road, s, before=before)
    return points_beside(x, y, z, hdg, roll, t, h)


def points_beside(
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    hdg: FloatArray,
    roll: FloatArray,
    t: FloatArray,
    h: FloatArray | float = 0.0,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y, z of points at t, h beside points of reference lines; see `surface_points`."""
    # An infinite roll, as of damaged files, is unknown.
    roll = np.where(np.isfinite(roll), roll, np.nan)
    cos, sin = np.cos(roll), np.sin(roll)
    across = t * cos - h * sin
    return x - np.sin(hdg) * across, y + np.cos(hdg) * across, z + t * sin + h * cos


@record(eq=False)
class LaneRanks:
    """The lanes of all sections, counted from the centre outwards."""

    # (sections,) Row of the lane next to the centre on either side, if there is one
    left: IntArray
    right: IntArray
    # (sections,) Lanes on either side
    left_count: IntArray
    right_count: IntArray
    # (lanes,) 1 for lanes next to the centre, and so on; 0 for centre lanes, -1 for lanes whose id is unreadable
    rank: IntArray


_RANKS: WeakKeyDictionary[OpenDrive, LaneRanks] = WeakKeyDictionary()


def lane_ranks(file: OpenDrive) -> LaneRanks:
    """Count the lanes of every section from the centre outwards; done once, then remembered."""
    if file in _RANKS:
        return _RANKS[file]
    lanes = file.lanes
    sections = len(lanes.start) - 1
    known = lanes.id != ABSENT
    left_count = np.bincount(lanes.section[lanes.id > 0], minlength=sections)
    centres = np.bincount(lanes.section[lanes.id == 0], minlength=sections)
    right_count = np.bincount(lanes.section[known & (lanes.id < 0)], minlength=sections)
    left = lanes.start[:-1] + left_count - 1
    right, row = left + 1 + centres, np.arange(len(lanes.id))
    rank = np.where(lanes.id > 0, left[lanes.section] - row + 1, row - right[lanes.section] + 1)
    rank[lanes.id == 0], rank[~known] = 0, -1
    found = _RANKS[file] = LaneRanks(left, right, left_count, right_count, rank)
    return found


def lane_borders(
    file: OpenDrive, lanes: IntArray, s: FloatArray, *, before: bool = False
) -> tuple[FloatArray, FloatArray]:
    """Return t of the inner and outer borders of lanes (rows of `OpenDrive.lanes`) at s of their roads, each (n,), m.

    Each lane is evaluated in its own section, even where s lies beyond it. Widths add up from the lane offset
    outwards. A lane without widths has its ``<border>``, which counts from the lane offset, too; one without either
    has no width. Lanes whose id is unreadable give NaN. `before` asks for the limit from the left.
    """
    return _borders((file, lane_ranks(file)), lanes, s, before=before)


@in_blocks
def _borders(
    counted: tuple[OpenDrive, LaneRanks], lanes: IntArray, s: FloatArray, *, before: bool
) -> tuple[FloatArray, FloatArray]:
    """Return the borders of lanes of a file whose lanes were counted; see `lane_borders`."""
    file, ranks = counted
    table = file.lanes
    section = table.section[lanes]
    rank = ranks.rank[lanes]
    is_left = table.id[lanes] > 0
    ds = s - file.sections.s[section]
    middle = lane_offset(file, file.sections.road[section], s, before=before)
    inner, outer = middle.copy(), middle.copy()
    for step in range(int(rank.max(initial=0))):
        at = np.flatnonzero(rank > step)
        lane = np.where(is_left[at], ranks.left[section[at]] - step, ranks.right[section[at]] + step)
        width = cubic_value(table.width, lane, ds[at], before=before)
        inner[at] = outer[at]
        beyond = outer[at] + np.where(is_left[at], width, -width)
        bare = np.flatnonzero(
            (table.width.start[lane + 1] == table.width.start[lane])
            & (table.border.start[lane + 1] > table.border.start[lane])
        )
        if len(bare):
            beyond[bare] = middle[at[bare]] + cubic_value(table.border, lane[bare], ds[at[bare]], before=before)
        outer[at] = beyond
    inner[rank < 0] = outer[rank < 0] = np.nan
    return inner, outer


def lane_middles(file: OpenDrive, lanes: IntArray, s: FloatArray) -> FloatArray:
    """Return t of the middles of lanes at s of their roads, (n,), m; NaN for `ABSENT` ones."""
    out = np.full(len(s), np.nan)
    has = np.flatnonzero(lanes != ABSENT)
    inner, outer = lane_borders(file, lanes[has], s[has])
    out[has] = 0.5 * (inner + outer)
    return out


@in_blocks
def section_at(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> IntArray:
    """Return the lane sections at s of roads, (n,): rows of `OpenDrive.sections`; `ABSENT` where a road has none."""
    start = file.sections.start
    out = np.full(len(s), ABSENT)
    has = np.flatnonzero(start[road + 1] > start[road])
    if len(has):
        out[has] = find_record(start, file.sections.s, road[has], s[has], before=before)
    return out


def speed_limits(file: OpenDrive) -> FloatArray:
    """Return the speed limits of all lanes, (lanes,), m/s: their own, or else that of their road where they begin.

    NaN is unknown, infinite without a limit.
    """
    lanes, sections, types = file.lanes, file.sections, file.types
    road, s = sections.road[lanes.section], sections.s[lanes.section]
    out = lanes.speed.copy()
    asks = np.flatnonzero(np.isnan(out) & (types.start[road + 1] > types.start[road]) & np.isfinite(s))
    out[asks] = types.speed[find_record(types.start, types.s, road[asks], s[asks])]
    return out


def lanes_of(file: OpenDrive, section: IntArray) -> tuple[IntArray, IntArray]:
    """Return all lanes of sections (n,), or `ABSENT`: the index into `section` and the row of each lane."""
    known = np.flatnonzero(section != ABSENT)
    first = file.lanes.start[section[known]]
    count = file.lanes.start[section[known] + 1] - first
    return np.repeat(known, count), runs(first, count)


def outermost_lanes(file: OpenDrive, section: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield the outermost lanes of sections (n,), side by side: the index into `section` and the row of each lane."""
    known = np.flatnonzero(section != ABSENT)
    ranks = lane_ranks(file)
    for count, first, sign in ((ranks.left_count, ranks.left, -1), (ranks.right_count, ranks.right, 1)):
        has = known[count[section[known]] > 0]
        yield has, first[section[has]] + sign * (count[section[has]] - 1)
