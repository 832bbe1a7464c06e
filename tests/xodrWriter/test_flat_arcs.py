"""Arcs of radii beyond what readers can compute with."""

from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.curves import pose
from osm2xodr.model import PlanView
from osm2xodr.xodrWriter.flat_arcs import LARGEST_RADIUS, without_flat_arcs


def one_arc(length: float, radius: float, rate: float = 0.0) -> PlanView:
    """A curve of one record that starts at (3, 4)."""
    values = [np.array([value]) for value in (0.0, 3.0, 4.0, 0.5, length, 1.0 / radius, rate)]
    return PlanView(np.array([0, 1]), *values)


@pytest.mark.parametrize(
    ("radius", "length", "count"),
    [
        (32e6, 130.0, 1),
        (-1e6, 80.0, 1),
        # 89.4 m of such an arc lie within 1 mm of a line.
        (1e6, 100.0, 2),
        (-300e3, 150.0, 4),
    ],
)
def test_flat_arcs_become_lines_along_them(radius: float, length: float, count: int) -> None:
    plan = one_arc(length, radius)
    found = without_flat_arcs(plan)
    assert found.start.tolist() == [0, count]
    assert found.curvature.tolist() == [0.0] * count
    assert found.length.tolist() == pytest.approx([length / count] * count, abs=1e-12)
    assert found.s == pytest.approx(np.arange(count) * length / count, abs=1e-12)
    s = np.linspace(0.0, length, 33)
    (x, y, hdg), (x0, y0, hdg0) = (pose(item, np.zeros(33, int), s) for item in (found, plan))
    off = np.hypot(x - x0, y - y0)
    assert 0.1e-3 * (abs(radius) < 1e7) < off.max() < 1e-3
    assert off[0] < 1e-9
    assert off[-1] < 1e-6
    assert np.abs(hdg - hdg0).max() < 1e-4


def test_other_records_stay() -> None:
    for plan in (one_arc(50.0, 0.99 * LARGEST_RADIUS), one_arc(50.0, 1e6, 1e-6), one_arc(50.0, np.inf)):
        assert without_flat_arcs(plan) is plan


def test_neighbours_of_flat_arcs_stay() -> None:
    values = [[0.0, 50.0, 150.0], [0.0, 50.0, 150.0], [0.0] * 3, [0.0] * 3, [50.0, 100.0, 20.0], [0.0, 1e-6, 0.01]]
    plan = PlanView(np.array([0, 1, 3]), *(np.array(item) for item in values))
    found = without_flat_arcs(plan)
    assert found.start.tolist() == [0, 1, 4]
    assert found.curvature.tolist() == [0.0, 0.0, 0.0, 0.01]
    assert found.hdg.tolist() == pytest.approx([0.0, 25e-6, 75e-6, 0.0], abs=1e-12)
