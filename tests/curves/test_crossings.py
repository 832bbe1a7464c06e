"""Which curves and segments cross."""

from __future__ import annotations

import numpy as np
import pytest
from junction_cases import CASES

from osm2xodr.curves.crossings import curves_cross, rays_to_segments, segments_cross
from osm2xodr.curves.plan_views import lengths
from osm2xodr.curves.records import pose


def test_segments_cross_where_each_parts_the_ends_of_the_other() -> None:
    a, b = np.array([0.0, 0.0]), np.array([10.0, 0.0])
    c = np.array([[5.0, 1.0], [5.0, 2.0], [12.0, -1.0], [5.0, 0.0]])
    d = np.array([[5.0, -1.0], [5.0, 1.0], [12.0, 1.0], [5.0, 3.0]])
    # The last one only touches.
    assert segments_cross(a, b, c, d).tolist() == [True, False, False, False]
    assert segments_cross(c, d, a, b).tolist() == [True, False, False, False]


def test_curves_that_cross() -> None:
    """Turns of a square crossing whose lanes are 1.5 m off the middle cross as drawn by hand."""
    roads = CASES["x"].case.build()
    inner = np.array([k for k, road in enumerate(roads.roads) if road.junction is not None])
    one, other = (grid.ravel() for grid in np.meshgrid(inner, inner))
    found = curves_cross(roads.plan_view, one, other).reshape(len(inner), -1)
    assert (found == found.T).all()
    assert not np.diag(found).any()
    # By dense samples: two curves cross where some points of one are within 3 cm of the other, away from their ends.
    length = lengths(roads.plan_view)
    for i, a in enumerate(inner.tolist()):
        for j, b in enumerate(inner.tolist()[:i]):
            if roads.roads[a].predecessor == roads.roads[b].predecessor:
                continue
            if roads.roads[a].successor == roads.roads[b].successor:
                continue
            lines = []
            for curve in (a, b):
                s = np.linspace(0.05 * length[curve], 0.95 * length[curve], 1500)
                x, y, _ = pose(roads.plan_view, np.full(len(s), curve), s)
                lines.append(x + 1j * y)
            gap = np.abs(lines[0][:, None] - lines[1][None, ::5]).min()
            assert found[i, j] == (gap < 0.03), (a, b, gap)


def test_rays_meet_segments_on_their_lines() -> None:
    begin, end = np.array([[2.0, -1.0], [-3.0, -1.0], [5.0, 1.0]]), np.array([[2.0, 1.0], [-3.0, 1.0], [5.0, 2.0]])
    rays = np.array([[1.0, 0.0], [0.0, 1.0], [0.6, 0.8]])
    far = rays_to_segments(np.zeros((1, 2)), rays, begin, end)
    assert far.tolist() == [[2.0, -3.0, np.inf], [np.inf] * 3, [np.inf] * 3]
    (other,) = rays_to_segments(np.array([[2.0, -2.5]]), rays[2:], begin, end)
    assert other.tolist() == [np.inf, np.inf, pytest.approx(5.0)]
