"""Arcs whose polylines end in equal steps."""

from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.curves import pose
from osm2xodr.model import PlanView
from osm2xodr.xodrWriter.even_arcs import with_even_ends


def one_record(length: float, curvature: float, rate: float = 0.0) -> PlanView:
    """A curve of one record that starts at (3, 4)."""
    values = [np.array([value]) for value in (0.0, 3.0, 4.0, 0.5, length, curvature, rate)]
    return PlanView(np.array([0, 1]), *values)


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
def test_the_last_two_steps_are_equal(length: float, pieces: list[float]) -> None:
    plan = one_record(length, -0.1)
    found = with_even_ends(plan, np.array([True]), 2.0)
    assert found.length == pytest.approx(pieces, abs=1e-12)
    assert found.start.tolist() == [0, len(pieces)]
    assert found.s == pytest.approx(np.cumsum([0.0, *pieces[:-1]]), abs=1e-12)
    # The curve is the same.
    s = np.linspace(0.0, length, 9)
    same = zip(pose(found, np.zeros(9, int), s), pose(plan, np.zeros(9, int), s), strict=True)
    assert all(one == pytest.approx(other, abs=1e-12) for one, other in same)


@pytest.mark.parametrize(("curvature", "rate", "chosen"), [(0.0, 0.0, True), (0.0, 0.01, True), (0.1, 0.0, False)])
def test_lines_spirals_and_other_curves_stay(curvature: float, rate: float, chosen: bool) -> None:
    assert len(with_even_ends(one_record(4.25, curvature, rate), np.array([chosen]), 2.0).s) == 1
