"""Reference lines whose polylines have no short pieces."""

from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.curves import pose
from osm2xodr.model import PlanView
from osm2xodr.xodrWriter.document import cut_at, with_even_ends


def one_record(length: float, curvature: float, rate: float = 0.0) -> PlanView:
    """A curve of one record that starts at (3, 4)."""
    values = [np.array([value]) for value in (0.0, 3.0, 4.0, 0.5, length, curvature, rate)]
    return PlanView(np.array([0, 1]), *values)


def check_same(found: PlanView, plan: PlanView, length: float) -> None:
    """Both are the same curve, record by record."""
    s = np.linspace(0.0, length, 9)
    same = zip(pose(found, np.zeros(9, int), s), pose(plan, np.zeros(9, int), s), strict=True)
    assert all(one == pytest.approx(other, abs=1e-9) for one, other in same)
    assert found.s == pytest.approx(np.cumsum([0.0, *found.length[:-1]]), abs=1e-12)
    assert found.start.tolist() == [0, len(found.s)]


@pytest.mark.parametrize(("curvature", "rate"), [(-0.1, 0.0), (0.0, 0.0), (-0.05, 0.002)])
@pytest.mark.parametrize(
    ("length", "pieces"),
    [
        (4.25, [2.0, 1.125, 1.125]),
        (2.25, [1.125, 1.125]),
        (20.25, [18.0, 1.125, 1.125]),
        # The rest is long enough, or there is none, or one step is all there is.
        (4.5, [4.5]),
        (6.0, [6.0]),
        (1.5, [1.5]),
    ],
)
def test_the_last_two_steps_are_equal(length: float, pieces: list[float], curvature: float, rate: float) -> None:
    plan = one_record(length, curvature, rate)
    found = with_even_ends(plan, np.array([True]), 2.0)
    assert found.length == pytest.approx(pieces, abs=1e-12)
    check_same(found, plan, length)


def test_other_curves_stay() -> None:
    assert len(with_even_ends(one_record(4.25, 0.1), np.array([False]), 2.0).s) == 1


@pytest.mark.parametrize(
    ("places", "pieces"),
    [
        ([3.0], [3.0, 7.0]),
        ([7.25, 3.0], [3.0, 4.25, 2.75]),
        # Too near to an end, or to each other.
        ([0.0, 0.4, 9.6, 10.0], [10.0]),
        ([3.0, 3.25, 5.0], [3.0, 2.0, 5.0]),
        ([], [10.0]),
    ],
)
def test_records_are_cut(places: list[float], pieces: list[float]) -> None:
    plan = one_record(10.0, -0.05, 0.01)
    found = cut_at(plan, np.zeros(len(places), np.int64), np.array(places, float), 0.5)
    assert found.length == pytest.approx(pieces, abs=1e-12)
    assert found.curvature == pytest.approx(-0.05 + 0.01 * found.s, abs=1e-12)
    check_same(found, plan, 10.0)
    line = one_record(10.0, 0.0)
    assert len(cut_at(line, np.zeros(len(places), np.int64), np.array(places, float), 0.5).s) == 1
