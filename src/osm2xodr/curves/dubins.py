"""The shortest curves between poses whose arcs have a radius: three arcs, or two with a line between."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from osm2xodr import defaults
from osm2xodr.curves.plan_views import SHORTEST_PIECE, curves_of, replaced, wrapped
from osm2xodr.model import BoolArray, FloatArray, PlanView

# An arc of almost a full turn is one of almost none, rad.
_FULL = 2 * np.pi - 1e-9
# Curves whose lengths differ by less are equally short, m: the one whose shortest record is the longest is taken.
# That does not depend on the side they turn to, nor on the direction in which they are driven.
_SHORTER = 1e-3
# Shorter records are not written, m: with a radius larger by one of these factors there is none, or a longer one.
_SLIVER = 0.02
_LARGER = (1.03, 1.07, 1.15, 1.3)


_Found = tuple[BoolArray, FloatArray, float]
_Places = npt.NDArray[np.complex128]


def shortest_curves(
    x0: FloatArray,
    y0: FloatArray,
    hdg0: FloatArray,
    x1: FloatArray,
    y1: FloatArray,
    hdg1: FloatArray,
    *,
    radius: float | FloatArray,
) -> PlanView:
    """Return the shortest curves from poses 0 to poses 1, (n,), whose arcs have a radius, one for all or (n,), m.

    Three arcs, or two with a line between (Dubins 1957, doi:10.2307/2372560), but none that turns forth and back by
    more than `MOST_SWING` in all (`MOST_SWING_BACK` to turn back): a full circle is no turn. Where there is none, the
    curve has no records.
    """
    n = len(x0)
    radius = np.broadcast_to(np.asarray(radius, np.float64), n)
    net = np.abs(wrapped(hdg1 - hdg0))
    most = np.where(net > defaults.SWING_BACK, defaults.MOST_SWING_BACK, defaults.MOST_SWING)
    p0, p1 = (x0 + 1j * y0) / radius, (x1 + 1j * y1) / radius
    wholes, choices, senses = [], [], []
    for first in (1.0, -1.0):
        for last in (1.0, -1.0):
            c0 = p0 + first * 1j * np.exp(1j * hdg0)
            c1 = p1 + last * 1j * np.exp(1j * hdg1)
            found = [_by_line(c0, c1, hdg0, hdg1, first, last)]
            if first == last:
                found += [_by_arc(c0, c1, hdg0, hdg1, first, side) for side in (1.0, -1.0)]
            for possible, pieces, middle in found:
                turned = pieces[:, 0] + np.abs(middle) * pieces[:, 1] + pieces[:, 2]
                wholes.append(np.where(possible & (turned - net < most), pieces.sum(axis=1), np.inf))
                choices.append(pieces)
                senses.append((first, middle, last))
    whole = np.stack(wholes) * radius
    size = np.stack(choices) * radius[:, None]
    shortest_record = np.where(size > SHORTEST_PIECE, size, np.inf).min(axis=2)
    equal = whole <= whole.min(axis=0) + _SHORTER
    best = np.where(equal, shortest_record, -1.0).argmax(axis=0)
    there = np.isfinite(whole.min(axis=0))[:, None]
    lengths_ = np.where(there, size[best, np.arange(n)], 0.0)
    curvatures = np.where(there, np.array(senses)[best] / radius[:, None], 0.0)
    return curves_of(x0, y0, hdg0, lengths_, curvatures)


def wide_curves(
    x0: FloatArray,
    y0: FloatArray,
    hdg0: FloatArray,
    x1: FloatArray,
    y1: FloatArray,
    hdg1: FloatArray,
    *,
    radius: FloatArray,
) -> PlanView:
    """Return what `shortest_curves` does, with radii a little larger, (n,), where a record would be tiny."""
    out = shortest_curves(x0, y0, hdg0, x1, y1, hdg1, radius=radius)
    for larger in _LARGER:
        owner = np.repeat(np.arange(len(x0)), np.diff(out.start))
        row = np.unique(owner[out.length < _SLIVER])
        if not len(row):
            break
        again = (column[row] for column in (x0, y0, hdg0, x1, y1, hdg1))
        out = replaced(out, row, shortest_curves(*again, radius=larger * radius[row]), np.arange(len(row)))
    return out


def _by_line(c0: _Places, c1: _Places, hdg0: FloatArray, hdg1: FloatArray, first: float, last: float) -> _Found:
    """Return where an arc, a line and an arc do, their lengths (n, 3) in radii, and the sense of the middle."""
    apart, bearing = np.abs(c1 - c0), np.angle(c1 - c0)
    cross = first != last
    possible = apart >= 2.0 if cross else apart >= 0.0
    line = np.sqrt(np.maximum(apart**2 - 4.0, 0.0)) if cross else apart
    lean = first * np.arcsin(np.clip(2.0 / np.maximum(apart, 1e-12), 0.0, 1.0)) if cross else 0.0
    hdg = bearing + lean
    return possible, np.stack([_turn(first * (hdg - hdg0)), line, _turn(last * (hdg1 - hdg))], axis=1), 0.0


def _by_arc(c0: _Places, c1: _Places, hdg0: FloatArray, hdg1: FloatArray, sense: float, side: float) -> _Found:
    """Return where three arcs do, their lengths (n, 3) in radii, and the sense of the middle one."""
    apart, bearing = np.abs(c1 - c0), np.angle(c1 - c0)
    out = bearing + side * np.arccos(np.clip(apart / 4.0, 0.0, 1.0))
    middle = c0 + 2.0 * np.exp(1j * out)
    hdg_a = out + sense * np.pi / 2
    hdg_b = np.angle(c1 - middle) - sense * np.pi / 2
    pieces = [_turn(sense * (hdg_a - hdg0)), _turn(sense * (hdg_a - hdg_b)), _turn(sense * (hdg1 - hdg_b))]
    return apart <= 4.0, np.stack(pieces, axis=1), -sense


def _turn(angle: FloatArray) -> FloatArray:
    turn = angle % (2 * np.pi)
    out: FloatArray = np.where(turn > _FULL, 0.0, turn)
    return out
