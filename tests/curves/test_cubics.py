"""Piecewise cubics against their closed formulas, and parts of them against the whole."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, strategies as st

from osm2xodr.curves.cubics import (
    cubic_slope,
    cubic_value,
    part_of_cubics,
    part_of_profile,
    profile_of,
    stack_profiles,
)
from osm2xodr.model import Cubic, CubicProfile, FloatArray

coefficient = st.floats(min_value=-1.0, max_value=1.0)
cubics = st.builds(Cubic, st.just(0.0), coefficient, coefficient, coefficient, coefficient)
# Records of 0.05 to 20 m, end to end.
lengths_of_records = st.lists(st.floats(min_value=0.05, max_value=20.0), min_size=1, max_size=6)
shares = st.floats(min_value=0.0, max_value=1.0)


@st.composite
def curves(draw: st.DrawFn) -> tuple[list[Cubic], float]:
    """Draw piecewise cubics, and where they end."""
    length = draw(lengths_of_records)
    starts = np.concatenate([[0.0], np.cumsum(length)])
    pieces = [draw(cubics) for _ in length]
    whole = [Cubic(s, p.a, p.b, p.c, p.d) for s, p in zip(starts.tolist(), pieces, strict=False)]
    return whole, float(starts[-1])


def evaluated(profile: CubicProfile, curve: int, s: FloatArray) -> FloatArray:
    """Return value and slope, (2, n)."""
    which = np.full(len(s), curve, np.int64)
    return np.stack([cubic_value(profile, which, s), cubic_slope(profile, which, s)])


@given(st.lists(curves(), min_size=1, max_size=3), st.data())
def test_parts_say_what_the_whole_says(several: list[tuple[list[Cubic], float]], data: st.DataObject) -> None:
    whole = profile_of([[], *(cubic for cubic, _ in several)])
    curve, begin, end = [0], [0.0], [10.0]
    for k, (_, length) in enumerate(several, start=1):
        cuts = sorted(data.draw(st.lists(shares, max_size=3)))
        places = [0.0, *(length * cut for cut in cuts), length]
        # Pieces are never shorter.
        ends = [(a, b) for a, b in pairwise(places) if b - a > 1e-3]
        curve += [k] * len(ends)
        begin += [a for a, _ in ends]
        end += [b for _, b in ends]
    parts = part_of_profile(whole, np.array(curve), np.array(begin), np.array(end))
    assert parts.start[1] == 0
    for row, (k, a, b) in enumerate(zip(curve, begin, end, strict=True)):
        own = parts.s[parts.start[row] : parts.start[row + 1]]
        if k:
            assert own[0] == 0.0
        assert (np.diff(own) > 0.0).all()
        assert (own < b - a).all()
        # Clear of the borders of records, where a value may jump in these curves.
        s = np.linspace(a, b, 23)[1:-1]
        borders = whole.s[whole.start[k] : whole.start[k + 1]]
        s = s[(np.abs(s[:, None] - borders[None, :]) > 1e-5).all(axis=1)]
        assert evaluated(parts, row, s - a) == pytest.approx(evaluated(whole, k, s), rel=1e-9, abs=1e-9)


@given(curves(), shares, shares)
def test_parts_of_widths_say_what_the_whole_says(curve: tuple[list[Cubic], float], one: float, other: float) -> None:
    whole, length = curve
    begin, end = min(one, other) * length, max(one, other) * length
    if end - begin < 1e-3:
        return
    part = part_of_cubics(whole, begin, end)
    tables = profile_of([whole]), profile_of([part])
    assert part[0].s == 0.0
    s = np.linspace(begin, end, 23)[1:-1]
    s = s[(np.abs(s[:, None] - tables[0].s[None, :]) > 1e-5).all(axis=1)]
    assert evaluated(tables[1], 0, s - begin) == pytest.approx(evaluated(tables[0], 0, s), rel=1e-9, abs=1e-9)


def test_curves_that_are_not_cut_keep_their_numbers() -> None:
    whole = profile_of([[Cubic(0.0, 0.1, 0.2, 0.3, 0.4), Cubic(7.0, 1 / 3)], [Cubic(0.0, 5.0)]])
    same = part_of_profile(whole, np.arange(2), np.zeros(2), np.array([9.0, 4.0]))
    for name in CubicProfile.__dataclass_fields__:
        assert getattr(same, name).tolist() == getattr(whole, name).tolist()


def test_a_cut_within_rounding_of_a_record_leaves_nothing_of_it() -> None:
    whole = profile_of([[Cubic(0.0, 1.0), Cubic(7.0, 2.0), Cubic(12.0, 3.0)]])
    curve = np.zeros(2, np.int64)
    for cut in (7.0 - 1e-9, 7.0, 7.0 + 1e-9):
        parts = part_of_profile(whole, curve, np.array([0.0, cut]), np.array([cut, 20.0]))
        assert parts.start.tolist() == [0, 1, 3]
        assert parts.a.tolist() == [1.0, 2.0, 3.0]
        assert parts.s.tolist() == [0.0, 0.0, 12.0 - cut]


def test_nothing_before_the_first_record_but_the_first_record() -> None:
    assert part_of_cubics([Cubic(0.0, 1.0, 0.5), Cubic(4.0, 3.0)], -2.0, 3.0) == (Cubic(0.0, 0.0, 0.5),)
    assert part_of_cubics((), 1.0, 3.0) == ()


def test_cubics_and_their_slopes() -> None:
    profile = profile_of([[Cubic(0.0, 1.0, 2.0, 3.0, 4.0), Cubic(10.0, 5.0, -1.0)], [], [Cubic(0.0, 7.0)]])
    curve = np.array([0, 0, 0, 1, 2])
    s = np.array([0.0, 2.0, 12.0, 3.0, 99.0])
    assert cubic_value(profile, curve, s).tolist() == [1.0, 1 + 4 + 12 + 32, 3.0, 0.0, 7.0]
    assert cubic_slope(profile, curve, s).tolist() == [2.0, 2 + 12 + 48, -1.0, 0.0, 0.0]
    assert cubic_value(profile, curve, s, order=2).tolist() == [6.0, 6 + 48, 0.0, 0.0, 0.0]
    end = np.array([10.0])
    assert cubic_value(profile, curve[:1], end).tolist() == [5.0]
    assert cubic_value(profile, curve[:1], end, before=True).tolist() == [1 + 20 + 300 + 4000]


def test_a_profile_of_no_cubics() -> None:
    profile = profile_of([[], []])
    assert profile.start.tolist() == [0, 0, 0]
    assert cubic_value(profile, np.array([0, 1]), np.array([1.0, 2.0])).tolist() == [0.0, 0.0]
    assert cubic_slope(profile, np.array([0, 1]), np.array([1.0, 2.0])).tolist() == [0.0, 0.0]


def test_stacked_tables_hold_the_curves_of_both() -> None:
    joined = stack_profiles(profile_of([[Cubic(0.0, 1.0)], []]), profile_of([[], [Cubic(0.0, 2.0), Cubic(1.0, 3.0)]]))
    assert joined.start.tolist() == [0, 1, 1, 1, 3]
    assert cubic_value(joined, np.array([0, 1, 2, 3]), np.full(4, 2.0)).tolist() == [1.0, 0.0, 0.0, 3.0]


def test_a_cubic_that_begins_later_is_the_same_curve() -> None:
    cubic = Cubic(10.0, 1.0, -0.5, 0.25, 0.125)
    later = cubic.begun_later(2.0, 12.0)
    assert (cubic.at(0.0), cubic.at(2.0)) == (1.0, 2.0)
    assert later == Cubic(12.0, 2.0, 2.0, 1.0, 0.125)
    assert [later.at(ds) for ds in (0.0, 1.0, 3.0)] == [cubic.at(2.0 + ds) for ds in (0.0, 1.0, 3.0)]
    assert (cubic.is_flat, Cubic(0.0, 3.0).is_flat) == (False, True)
