"""Reference lines: plan views of all shapes as functions of s.

Many places are evaluated block by block, so that what is needed on the way stays small beside the result.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, TypeVar, cast
from weakref import WeakKeyDictionary

import numpy as np

from osm2xodr.curves import arc_step, find_record
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive.tables import GeometryTable, OpenDrive, Shape

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


@dataclass(frozen=True, eq=False)
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


_CACHE: WeakKeyDictionary[GeometryTable, _Polynomials] = WeakKeyDictionary()


def _polynomials(plan: GeometryTable) -> _Polynomials:
    """Return the polynomials of a plan view; measured once, then remembered."""
    if plan in _CACHE:
        return _CACHE[plan]
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
    found = _CACHE[plan] = _Polynomials(record, row, u, v, end, arc, scale)
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
