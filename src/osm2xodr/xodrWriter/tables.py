"""The long tables of a road map (plan views and profiles) as XML records, many at a time.

Formatting a thousand records with one ``%`` is several times faster than one element at a time in any XML library.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.model import CubicProfile, FloatArray, PlanView
from osm2xodr.xodrWriter.formatting import NUMBER, snapped

_GEOMETRY: Final = (
    f'      <geometry s="{NUMBER}" x="{NUMBER}" y="{NUMBER}" hdg="{NUMBER}" length="{NUMBER}">%s</geometry>\n'
)
_ARC: Final = f'<arc curvature="{NUMBER}"/>'
_LINE: Final = "<line/>"
_CUBIC: Final = f'      <%s s="{NUMBER}" a="{NUMBER}" b="{NUMBER}" c="{NUMBER}" d="{NUMBER}"/>\n'

# Below these, values are the dust of floating-point sums. Over a record of 2 km the coefficients' limits come to less
# than 1 nm.
_POSITION_DUST: Final = 1e-10
_HEADING_DUST: Final = 1e-13
_COEFFICIENT_DUST: Final = (1e-10, 1e-13, 1e-16, 1e-20)


def plan_view_texts(plan: PlanView, first: int, last: int) -> list[str]:
    """Return the ``<geometry>`` elements of the curves from `first` up to `last`, one text per curve."""
    records = slice(int(plan.start[first]), int(plan.start[last]))
    shapes = [_LINE if bend == 0.0 else _ARC % bend for bend in plan.curvature[records].tolist()]
    columns = [
        snapped(plan.s[records], _POSITION_DUST),
        snapped(plan.x[records], _POSITION_DUST),
        snapped(plan.y[records], _POSITION_DUST),
        snapped(plan.hdg[records], _HEADING_DUST),
        plan.length[records],
    ]
    values = _interleaved(columns, 6)
    values[5::6] = shapes
    return _per_curve(_GEOMETRY * len(shapes) % tuple(values), plan.start[first : last + 1].tolist())


def cubic_texts(profile: CubicProfile, element: str, first: int, last: int) -> list[str]:
    """Return the records of the curves from `first` up to `last` as `element`, one text per curve, maybe empty."""
    records = slice(int(profile.start[first]), int(profile.start[last]))
    coefficients = (profile.a, profile.b, profile.c, profile.d)
    columns = [snapped(profile.s[records], _POSITION_DUST)]
    columns += [snapped(values[records], dust) for values, dust in zip(coefficients, _COEFFICIENT_DUST, strict=True)]
    template = _CUBIC.replace("%s", element)
    text = template * len(columns[0]) % tuple(_interleaved(columns, 5))
    return _per_curve(text, profile.start[first : last + 1].tolist())


def says_nothing(profile: CubicProfile, first: int, last: int) -> list[bool]:
    """Return for each curve from `first` up to `last` whether its profile is 0 everywhere, or has no records."""
    records = slice(int(profile.start[first]), int(profile.start[last]))
    coefficients = (profile.a, profile.b, profile.c, profile.d)
    nonzero = np.zeros(records.stop - records.start, dtype=np.bool_)
    for values, dust in zip(coefficients, _COEFFICIENT_DUST, strict=True):
        nonzero |= np.abs(values[records]) >= dust
    before = np.concatenate([[0], np.cumsum(nonzero)])
    start = profile.start[first : last + 1] - records.start
    return [bool(count == 0) for count in np.diff(before[start])]


def curve_lengths(plan: PlanView) -> FloatArray:
    """Return the length of each curve, m (curves,): where its last record ends."""
    last = plan.start[1:] - 1
    ends: FloatArray = plan.s[last] + plan.length[last]
    return ends


def _interleaved(columns: list[FloatArray], width: int) -> list[object]:
    """Columns of equal length as one list, record by record, with room for `width` values in each."""
    values: list[object] = [None] * (width * len(columns[0]))
    for index, column in enumerate(columns):
        values[index::width] = column.tolist()
    return values


def _per_curve(text: str, start: list[int]) -> list[str]:
    """Cut the text of many records, one per line, into one text per curve."""
    lines = text.splitlines(keepends=True)
    base = start[0]
    return ["".join(lines[a - base : b - base]) for a, b in pairwise(start)]


def all_finite(*tables: PlanView | CubicProfile) -> bool:
    """Whether every number of the tables is finite."""
    return all(
        bool(np.isfinite(getattr(table, name)).all()) for table in tables for name in type(table).__dataclass_fields__
    )
