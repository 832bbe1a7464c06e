"""Points looked up by place."""

from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.curves import PointTree
from osm2xodr.model import FloatArray


def scattered(count: int, sides: int) -> FloatArray:
    """Return points on a coarse grid, so that many are equally far from others and some are the same."""
    return np.random.default_rng(count).integers(0, 12, (count, sides)).astype(np.float64)


@pytest.mark.parametrize("sides", [2, 3, 5])
@pytest.mark.parametrize("count", [0, 1, 8, 9, 17, 400])
def test_all_points_within_reach_are_found(count: int, sides: int) -> None:
    points, places = scattered(count, sides), scattered(30, sides) + 0.5 * (sides == 3)
    reach = np.linspace(0.0, 6.0, len(places))
    away = ((places[:, None] - points) ** 2).sum(axis=2)
    for limit in (2.0, reach):
        place, found = PointTree(points).within(places, limit)
        order = np.lexsort((found, place))
        wanted = np.nonzero(away <= np.square(np.broadcast_to(limit, len(places)))[:, None])
        assert (np.diff(place) >= 0).all()
        np.testing.assert_array_equal(np.stack([place, found])[:, order], wanted)


@pytest.mark.parametrize("sides", [2, 3, 5])
@pytest.mark.parametrize("count", [0, 1, 8, 9, 17, 400])
def test_of_equally_near_points_the_first_comes_first(count: int, sides: int) -> None:
    points, places = scattered(count, sides), scattered(30, sides)
    away = np.sqrt(((places[:, None] - points) ** 2).sum(axis=2))
    tree, none = PointTree(points), np.full((len(places), 4), np.inf)
    for reach in (3.0, np.inf):
        # What is as far as the reach is not found.
        allowed = np.column_stack([np.where(away < reach, away, np.inf), none])
        order = np.argsort(allowed, axis=1, kind="stable")[:, :4]
        nearest = np.take_along_axis(allowed, order, axis=1)
        distance, found = tree.neighbours(places, 4, reach)
        np.testing.assert_array_equal(distance, nearest)
        np.testing.assert_array_equal(found, np.where(np.isfinite(nearest), order, -1))
        distance, found = tree.nearest(places, reach)
        np.testing.assert_array_equal(distance, nearest[:, 0])
        np.testing.assert_array_equal(found, np.where(np.isfinite(nearest[:, 0]), order[:, 0], -1))


def test_points_must_be_numbers() -> None:
    with pytest.raises(ValueError, match="points must be finite"):
        PointTree(np.array([[0.0, np.nan]]))
