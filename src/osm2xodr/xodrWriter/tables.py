"""The long tables of a road map (plan views and profiles) as XML records, many at a time.

Formatting a thousand records with one ``%`` is several times faster than one element at a time in any XML library.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import end_curvature, starts
from osm2xodr.model import CubicProfile, FloatArray, PlanView
from osm2xodr.xodrWriter.formatting import CURVATURE, NUMBER, POSITION_DECIMALS, rounded

_GEOMETRY: Final = f'<geometry s="{NUMBER}" x="{NUMBER}" y="{NUMBER}" hdg="{NUMBER}" length="{NUMBER}">'
_ARC: Final = f'{_GEOMETRY}<arc curvature="{CURVATURE}"/></geometry>\n'
_SPIRAL: Final = f'{_GEOMETRY}<spiral curvStart="{CURVATURE}" curvEnd="{CURVATURE}"/></geometry>\n'
_LINE: Final = f"{_GEOMETRY}<line/></geometry>\n"
_CUBIC: Final = f'<%s s="{NUMBER}" a="{NUMBER}" b="{NUMBER}" c="{NUMBER}" d="{NUMBER}"/>\n'
# Separates the texts of curves while they are made together; not allowed in XML, so in none of them.
_BETWEEN: Final = "\0"

# Decimals of what headings and the terms of a cubic come to at the end of their record (10 nm): readers compute
# positions from them to well below a micrometre, and no digit is superfluous.
_END_DECIMALS: Final = 8


def plan_view_texts(plan: PlanView, first: int, last: int) -> list[str]:
    """Return the ``<geometry>`` elements of the curves from `first` up to `last`, one text per curve.

    Every curve has records.
    """
    start = plan.start[first : last + 1]
    records = slice(int(start[0]), int(start[-1]))
    curvature, end, bends = plan.curvature[records], end_curvature(plan, records), plan.rate[records] != 0.0
    s, x, y, length = (rounded(item[records], POSITION_DECIMALS) for item in (plan.s, plan.x, plan.y, plan.length))
    hdg = rounded(plan.hdg[records], _END_DECIMALS + np.ceil(np.log10(np.maximum(length, 1.0))))
    shape = np.where(bends, 2, curvature != 0.0).astype(np.int64)
    patterns = [(_LINE, _ARC, _SPIRAL)[k] for k in shape.tolist()]
    for record in (start[1:-1] - start[0]).tolist():
        patterns[record] = _BETWEEN + patterns[record]
    table = np.column_stack([s, x, y, hdg, length, curvature, end])
    written = np.ones(table.shape, np.bool_)
    written[:, -2], written[:, -1] = shape > 0, bends
    return _per_curve("".join(patterns) % tuple(table[written].tolist()), last - first)


def cubic_texts(profile: CubicProfile, lengths: FloatArray, element: str, first: int, last: int) -> list[str]:
    """Return the records of the curves from `first` up to `last` as `element`, one text per curve.

    It is empty for curves that are 0 everywhere or have no records. `lengths` (curves,), m, are those of all curves:
    where last records end.
    """
    start = profile.start[first : last + 1] - profile.start[first]
    table = np.column_stack(_cubic_columns(profile, lengths, first, last))
    before = starts(table[:, 1:].any(axis=1))
    written = np.diff(before[start]) > 0
    counts = np.diff(start)
    values = table[np.repeat(written, counts)].ravel()
    pattern = _CUBIC.replace("%s", element)
    patterns = [pattern * count if count else "" for count in np.where(written, counts, 0).tolist()]
    return _per_curve(_BETWEEN.join(patterns) % tuple(values.tolist()), last - first)


def _cubic_columns(profile: CubicProfile, lengths: FloatArray, first: int, last: int) -> list[FloatArray]:
    """Return s, a, b, c, d with as many decimals as they need: the longer a record, the more for its higher terms."""
    start = profile.start[first : last + 1]
    records = slice(int(start[0]), int(start[-1]))
    s = profile.s[records]
    end = np.append(s[1:], 0.0)
    filled = np.diff(start) > 0
    end[start[1:][filled] - 1 - records.start] = lengths[first:last][filled]
    digits = np.ceil(np.log10(np.maximum(end - s, 1.0)))
    coefficients = (profile.a, profile.b, profile.c, profile.d)
    return [
        rounded(s, POSITION_DECIMALS),
        rounded(profile.a[records], POSITION_DECIMALS),
        *(rounded(coefficients[k][records], _END_DECIMALS + k * digits) for k in (1, 2, 3)),
    ]


def _per_curve(text: str, count: int) -> list[str]:
    """Cut the text of several curves."""
    return text.split(_BETWEEN) if count else []
