"""Points and outlines: analytic, and the properties that neighbours need.

How far along a polyline its points are.

Which curves and segments cross.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, strategies as st
from junction_cases import CASES

from osm2xodr.curves import running_lengths
from osm2xodr.curves.plan_views import lengths
from osm2xodr.curves.polygons import (
    area_at,
    curves_cross,
    distance_to_outline,
    inside_outline,
    rays_to_segments,
    segments_cross,
)
from osm2xodr.curves.records import pose
from osm2xodr.model import LocalFrame, Outline, Partition


def box(west: float, south: float, east: float, north: float) -> Outline:
    return Outline((np.array([[west, south], [east, south], [east, north], [west, north]]),))


def test_a_hole_is_outside() -> None:
    hole = np.array([[4.0, 4.0], [6.0, 4.0], [6.0, 6.0], [4.0, 6.0]])
    outline = Outline((*box(0.0, 0.0, 10.0, 10.0).rings, hole))
    x, y = np.array([1.0, 5.0, 11.0, 5.0]), np.array([1.0, 5.0, 5.0, 7.0])
    assert inside_outline(outline, x, y).tolist() == [True, False, False, True]
    assert distance_to_outline(outline, x, y, np.inf).tolist() == [0.0, 1.0, 1.0, 0.0]


@pytest.mark.parametrize(
    ("x", "y", "expected"),
    [(-3.0, 5.0, 3.0), (5.0, 14.0, 4.0), (13.0, 14.0, 5.0), (5.0, 5.0, 0.0), (-6.0, -8.0, 10.0)],
)
def test_distance_to_a_square(x: float, y: float, expected: float) -> None:
    found = distance_to_outline(box(0.0, 0.0, 10.0, 10.0), np.array([x]), np.array([y]), np.inf)
    assert found[0] == pytest.approx(expected, abs=1e-12)


def test_distances_of_many_points_are_those_of_each() -> None:
    dice = np.random.default_rng(3)
    x, y = dice.uniform(-20.0, 30.0, (2, 20_000))
    found = distance_to_outline(box(0.0, 0.0, 10.0, 10.0), x, y, np.inf)
    dx, dy = np.maximum(np.maximum(-x, x - 10.0), 0.0), np.maximum(np.maximum(-y, y - 10.0), 0.0)
    np.testing.assert_allclose(found, np.hypot(dx, dy), atol=1e-9)


corner = st.floats(-50.0, 50.0).map(lambda value: round(value, 2))


@given(
    cuts=st.lists(corner, min_size=1, max_size=4, unique=True),
    points=st.lists(st.tuples(corner, corner), min_size=1, max_size=30),
)
def test_each_point_is_in_one_of_the_strips_side_by_side(
    cuts: list[float], points: list[tuple[float, float]]
) -> None:
    """Points on the common edges are in one of both strips, never in none or two."""
    edges = [-100.0, *sorted(cuts), 100.0]
    strips = [box(west, -60.0, east, 60.0) for west, east in pairwise(edges)]
    x, y = np.array(points).T
    count = np.sum([inside_outline(strip, x, y) for strip in strips], axis=0)
    assert count.tolist() == [1] * len(points)


def test_where_areas_overlap_the_first_has_it() -> None:
    frame = LocalFrame("+proj=tmerc", 0.0, 0.0)
    outlines = (box(0.0, 0.0, 10.0, 10.0), box(5.0, 0.0, 15.0, 10.0))
    partition = Partition(frame, ("a", "b"), outlines, (1, 1001), 0)
    x = np.array([2.0, 7.0, 12.0, 17.0])
    assert area_at(partition, x, np.full(4, 5.0)).tolist() == [0, 0, 1, -1]
    assert area_at(partition, np.zeros(0), np.zeros(0)).tolist() == []


def test_running_lengths_adds_up_what_lies_between_points() -> None:
    points = np.array([[1.0, 1.0], [4.0, 5.0], [4.0, 5.0], [16.0, 0.0]])
    np.testing.assert_array_equal(running_lengths(points), [0.0, 5.0, 5.0, 18.0])


def test_one_point_is_at_the_start() -> None:
    np.testing.assert_array_equal(running_lengths(np.array([[7.0, 8.0]])), [0.0])


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
