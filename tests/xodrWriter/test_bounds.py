from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from sample_road_maps import plan_view

from osm2xodr.xodrWriter.bounds import plan_view_bounds


def test_line() -> None:
    plan = plan_view([[(0.0, 1.0, 2.0, math.pi / 6.0, 10.0, 0.0)]])
    assert plan_view_bounds(plan) == pytest.approx((1.0, 2.0, 1.0 + 10.0 * math.sqrt(0.75), 7.0), abs=1e-12)


@pytest.mark.parametrize(
    ("hdg", "turn", "bounds"),
    [
        # A half circle of radius 5 m from the origin: what it reaches, by its start heading and sense.
        (0.0, 1, (0.0, 0.0, 5.0, 10.0)),
        (0.0, -1, (0.0, -10.0, 5.0, 0.0)),
        (math.pi / 2.0, 1, (-10.0, 0.0, 0.0, 5.0)),
        (math.pi, 1, (-5.0, -10.0, 0.0, 0.0)),
        (-math.pi / 2.0, -1, (-10.0, -5.0, 0.0, 0.0)),
        (5.0 * math.pi / 2.0, 1, (-10.0, 0.0, 0.0, 5.0)),
    ],
)
def test_half_circles(hdg: float, turn: int, bounds: tuple[float, float, float, float]) -> None:
    plan = plan_view([[(0.0, 0.0, 0.0, hdg, 5.0 * math.pi, turn / 5.0)]])
    assert plan_view_bounds(plan) == pytest.approx(bounds, abs=1e-9)


def test_a_whole_circle() -> None:
    plan = plan_view([[(0.0, 3.0, 4.0, 1.0, 2.0 * math.pi * 7.0, -1.0 / 7.0)]])
    x, y = 3.0 + 7.0 * math.sin(1.0), 4.0 - 7.0 * math.cos(1.0)
    assert plan_view_bounds(plan) == pytest.approx((x - 7.0, y - 7.0, x + 7.0, y + 7.0), abs=1e-9)


@given(
    st.floats(min_value=-10.0, max_value=10.0),
    st.one_of(st.floats(min_value=-0.3, max_value=0.3), st.floats(min_value=-1e-9, max_value=1e-9)),
    st.floats(min_value=0.1, max_value=100.0),
)
def test_arcs_against_many_points_on_them(hdg: float, curvature: float, length: float) -> None:
    west, south, east, north = plan_view_bounds(plan_view([[(0.0, 10.0, -20.0, hdg, length, curvature)]]))
    ds = np.linspace(0.0, length, 20001)
    half = 0.5 * curvature * ds
    x = 10.0 + ds * np.sinc(half / np.pi) * np.cos(hdg + half)
    y = -20.0 + ds * np.sinc(half / np.pi) * np.sin(hdg + half)
    # Between two of the points an arc of these curvatures rises by less than this.
    rise = abs(curvature) * (length / 20000.0) ** 2 + 1e-9
    assert west == pytest.approx(x.min(), abs=rise)
    assert south == pytest.approx(y.min(), abs=rise)
    assert east == pytest.approx(x.max(), abs=rise)
    assert north == pytest.approx(y.max(), abs=rise)
