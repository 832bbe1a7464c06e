"""Dubins curves: the shortest curves between two poses whose arcs have a given radius.

Each is arc, line, arc or three arcs (Dubins 1957, doi:10.2307/2372560).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
import numpy.typing as npt

from osm2xodr import defaults
from osm2xodr.curves.plan_views import SHORTEST_PIECE, curves_of, replace_curves, wrapped
from osm2xodr.curves.ragged import owners, sorted_unique
from osm2xodr.curves.trigonometry import arccosine, arcsine, arctan2, cosine_sine, hypot
from osm2xodr.model import BoolArray, FloatArray, PlanView

# An arc of all but a full turn is a rounding error of no arc at all, rad.
_FULL_TURN: Final = 2 * np.pi - 1e-9
# Curves whose lengths differ by less are equally short, m: the one whose shortest record is longest is taken. That
# depends neither on the side they turn to nor on the direction in which they are driven.
_EQUALLY_LONG: Final = 1e-3
# Records shorter than this are not worth writing, m: with a radius larger by one of these factors (choices) the
# record disappears or becomes longer.
_SLIVER: Final = 0.02
_LARGER_RADII: Final = (1.03, 1.07, 1.15, 1.3)

# Where the curve exists, the lengths of its pieces (n, 3) in radii, and their senses: 1 left, -1 right, 0 straight.
_Candidate = tuple[BoolArray, FloatArray, tuple[float, float, float]]
_Points = npt.NDArray[np.complex128]


def dubins_curves(
    x0: FloatArray,
    y0: FloatArray,
    hdg0: FloatArray,
    x1: FloatArray,
    y1: FloatArray,
    hdg1: FloatArray,
    *,
    radius: float | FloatArray,
    most_swing: float = defaults.MOST_SWING,
) -> PlanView:
    """Return the shortest curves from poses 0 to poses 1, (n,), with arcs of a radius, one for all or (n,), m.

    Curves that turn forth and back by `most_swing` or more in all, rad, (`MOST_SWING_BACK` for turns back) do not
    count: a full circle is no turn. Where none is left, the curve has no records.
    """
    n = len(x0)
    radius = np.broadcast_to(np.asarray(radius, np.float64), n)
    net = np.abs(wrapped(hdg1 - hdg0))
    most = np.where(net >= defaults.LEAST_TURN_BACK, defaults.MOST_SWING_BACK, most_swing)
    p0, p1 = (np.asarray(x + 1j * y, np.complex128) / radius for x, y in ((x0, y0), (x1, y1)))
    candidates = list(_candidates(p0, p1, hdg0, hdg1))
    totals = []
    for possible, pieces, (_, middle, _) in candidates:
        turned = pieces[:, 0] + np.abs(middle) * pieces[:, 1] + pieces[:, 2]
        totals.append(np.where(possible & (turned - net < most), pieces.sum(axis=1), np.inf))
    total = np.stack(totals) * radius
    size = np.stack([pieces for _, pieces, _ in candidates]) * radius[:, None]
    shortest_record = np.where(size > SHORTEST_PIECE, size, np.inf).min(axis=2)
    equal = total <= total.min(axis=0) + _EQUALLY_LONG
    best = np.where(equal, shortest_record, -1.0).argmax(axis=0)
    exists = np.isfinite(total.min(axis=0))[:, None]
    length = np.where(exists, size[best, np.arange(n)], 0.0)
    curvature = np.where(exists, np.array([sense for _, _, sense in candidates])[best] / radius[:, None], 0.0)
    return curves_of(x0, y0, hdg0, length, curvature)


def dubins_without_slivers(
    x0: FloatArray,
    y0: FloatArray,
    hdg0: FloatArray,
    x1: FloatArray,
    y1: FloatArray,
    hdg1: FloatArray,
    *,
    radius: FloatArray,
    most_swing: float = defaults.MOST_SWING,
) -> PlanView:
    """Return what `dubins_curves` does, with radii (n,) a little larger where a record would be tiny."""
    out = dubins_curves(x0, y0, hdg0, x1, y1, hdg1, radius=radius, most_swing=most_swing)
    for larger in _LARGER_RADII:
        row = sorted_unique(owners(out.start)[out.length < _SLIVER])
        if not len(row):
            break
        poses = (column[row] for column in (x0, y0, hdg0, x1, y1, hdg1))
        wider = dubins_curves(*poses, radius=larger * radius[row], most_swing=most_swing)
        out = replace_curves(out, row, wider, np.arange(len(row)))
    return out


def _candidates(p0: _Points, p1: _Points, hdg0: FloatArray, hdg1: FloatArray) -> Iterator[_Candidate]:
    """Yield the curves of all kinds between poses, in radii."""
    for first in (1.0, -1.0):
        for last in (1.0, -1.0):
            c0 = p0 + first * 1j * _unit(hdg0)
            c1 = p1 + last * 1j * _unit(hdg1)
            yield _arc_line_arc(c0, c1, hdg0, hdg1, first, last)
            if first == last:
                for side in (1.0, -1.0):
                    yield _three_arcs(c0, c1, hdg0, hdg1, first, side)


def _arc_line_arc(
    c0: _Points, c1: _Points, hdg0: FloatArray, hdg1: FloatArray, first: float, last: float
) -> _Candidate:
    """Join circles about c0 and c1 of unit radius, (n,), by their common tangent."""
    apart, bearing = _size(c1 - c0), _angle(c1 - c0)
    cross = first != last
    possible = apart >= 2.0 if cross else apart >= 0.0
    line = np.sqrt(np.maximum(apart**2 - 4.0, 0.0)) if cross else apart
    lean = first * arcsine(np.clip(2.0 / np.maximum(apart, 1e-12), 0.0, 1.0)) if cross else 0.0
    hdg = bearing + lean
    pieces = np.stack([_turn(first * (hdg - hdg0)), line, _turn(last * (hdg1 - hdg))], axis=1)
    return possible, pieces, (first, 0.0, last)


def _three_arcs(
    c0: _Points, c1: _Points, hdg0: FloatArray, hdg1: FloatArray, sense: float, side: float
) -> _Candidate:
    """Join circles about c0 and c1 of unit radius, (n,), by a third one on either side that touches both."""
    apart, bearing = _size(c1 - c0), _angle(c1 - c0)
    out = bearing + side * arccosine(np.clip(apart / 4.0, 0.0, 1.0))
    middle = c0 + 2.0 * _unit(out)
    hdg_a = out + sense * np.pi / 2
    hdg_b = _angle(c1 - middle) - sense * np.pi / 2
    pieces = [_turn(sense * (hdg_a - hdg0)), _turn(sense * (hdg_a - hdg_b)), _turn(sense * (hdg1 - hdg_b))]
    return apart <= 4.0, np.stack(pieces, axis=1), (sense, -sense, sense)


def _unit(hdg: FloatArray) -> _Points:
    """Return the vectors of length 1 in some directions."""
    along, across = cosine_sine(hdg)
    return np.asarray(along + 1j * across)


def _size(vector: _Points) -> FloatArray:
    """Return the lengths of vectors."""
    return hypot(vector.real, vector.imag)


def _angle(vector: _Points) -> FloatArray:
    """Return the directions of vectors, rad."""
    return arctan2(vector.imag, vector.real)


def _turn(angle: FloatArray) -> FloatArray:
    """Return angles as turns from 0 to less than 2 pi."""
    turn = angle % (2 * np.pi)
    return np.where(turn > _FULL_TURN, 0.0, turn)
