from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from osm2xodr.model import FloatArray, Street
from osm2xodr.surface.reading import points_along


def street(points: list[tuple[float, float]]) -> Street:
    return Street(0, 0, 1, np.array(points, dtype=np.float64), np.arange(len(points)), ())


def test_points_are_evenly_spaced_around_corners() -> None:
    x, y = points_along([street([(0.0, 0.0), (30.0, 0.0), (30.0, 70.0)])], step=25.0)
    assert x == pytest.approx([0.0, 25.0, 30.0, 30.0, 30.0])
    assert y == pytest.approx([0.0, 0.0, 20.0, 45.0, 70.0])


def test_streets_do_not_run_into_each_other() -> None:
    streets = [street([(0.0, 0.0), (10.0, 0.0)]), street([(1000.0, 5.0), (1000.0, 65.0)])]
    x, y = points_along(streets, step=50.0)
    assert x == pytest.approx([0.0, 10.0, 1000.0, 1000.0, 1000.0])
    assert y == pytest.approx([0.0, 0.0, 5.0, 35.0, 65.0])


coordinate = st.floats(min_value=-1000.0, max_value=1000.0)


def lengths(points: FloatArray) -> FloatArray:
    return np.asarray(np.hypot(*np.diff(points, axis=0).T), np.float64)


@given(st.lists(st.lists(st.tuples(coordinate, coordinate), min_size=2, max_size=6), min_size=1, max_size=5))
def test_each_street_is_covered_from_end_to_end(lines: list[list[tuple[float, float]]]) -> None:
    x, y = points_along([street(line) for line in lines], step=50.0)
    first = 0
    for line in lines:
        points = np.array(line)
        count = max(int(np.ceil(lengths(points).sum() / 50.0)), 1) + 1
        found = np.column_stack([x[first : first + count], y[first : first + count]])
        assert found[0] == pytest.approx(points[0], abs=1e-6)
        assert found[-1] == pytest.approx(points[-1], abs=1e-6)
        assert lengths(found).max() <= 50.0 + 1e-6
        first += count
    assert first == len(x)
