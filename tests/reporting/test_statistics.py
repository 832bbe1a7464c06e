from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from sample_road_maps import crossing, profile

from osm2xodr.model import Stretches
from osm2xodr.reporting.statistics import profile_range, summarize


def test_summarize() -> None:
    found = summarize(crossing())
    assert (found.roads, found.connecting_roads, found.junctions) == (2, 2, 1)
    assert found.road_length == pytest.approx(180.0 + 10.0 * math.pi)
    assert found.connecting_length == pytest.approx(20.0)
    assert found.lowest == 1000.0
    ds = 10.0 * math.pi
    assert found.highest == pytest.approx(1003.8 + 0.02 * ds - 1e-4 * ds**2 + 2e-7 * ds**3)
    assert found.dem_coverage is None
    assert found.further == {"streets": 2.0}


def test_coverage_is_the_share_of_all_roads_that_is_measured() -> None:
    whole = crossing()
    length = 200.0 + 10.0 * math.pi
    # 30 m of the first road; all of the last one, up to what rounding adds to its end.
    gaps = Stretches(np.array([0, 2, 2, 2, 3]), np.array([0.0, 50.0, 0.0]), np.array([10.0, 70.0, 10.004]))
    found = summarize(replace(whole, unmeasured=gaps))
    assert found.dem_coverage == pytest.approx(1.0 - 40.0 / length, abs=1e-12)
    none = Stretches(np.zeros(5, np.int64), np.zeros(0), np.zeros(0))
    assert summarize(replace(whole, unmeasured=none)).dem_coverage == 1.0


def test_a_hill_and_a_hollow_between_the_ends() -> None:
    # A parabola that peaks at 10 + 4 in the middle of 40 m, then one that sags to 10 - 1 in the middle of 20 m.
    table = profile([[(0.0, 10.0, 0.4, -0.01, 0.0), (40.0, 10.0, -0.2, 0.01, 0.0)]])
    assert profile_range(table, np.array([60.0])) == pytest.approx((9.0, 14.0))


def test_curves_without_records_do_not_disturb() -> None:
    table = profile([[], [(0.0, 1.0, 1.0, 0.0, 0.0)], [], [(0.0, -5.0, 0.0, 0.0, 0.0)], []])
    assert profile_range(table, np.array([7.0, 3.0, 7.0, 1.0, 7.0])) == pytest.approx((-5.0, 4.0))


coefficient = st.floats(min_value=-1.0, max_value=1.0)


@given(coefficient, coefficient, coefficient, coefficient, st.floats(min_value=0.1, max_value=20.0))
def test_against_many_points(a: float, b: float, c: float, d: float, length: float) -> None:
    low, high = profile_range(profile([[(0.0, a, b, c, d)]]), np.array([length]))
    ds = np.linspace(0.0, length, 4001)
    z = a + ds * (b + ds * (c + ds * d))
    slack = (abs(c) + 3.0 * abs(d) * length) * (length / 4000.0) ** 2 + 1e-9
    assert low == pytest.approx(z.min(), abs=slack)
    assert high == pytest.approx(z.max(), abs=slack)
