"""Points and outlines: analytic, and the properties that neighbours need."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, strategies as st

from osm2xodr.curves.polygons import area_at, distance_to_outline, inside_outline
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
