"""Shores that are not whole in the file, and on which side of them there is water."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from osm2xodr.exporting.scene.water import closed_water
from osm2xodr.model import FloatArray

AREA = shapely.box(0.0, 0.0, 200.0, 100.0)
SOUTH = np.array([(-30.0, 20.0), (90.0, 30.0), (230.0, 20.0)])
NORTH = np.array([(-10.0, 70.0), (110.0, 60.0), (210.0, 70.0)])


def roads(*corners: tuple[float, float]) -> FloatArray:
    """Return 50 places of roads at each corner."""
    return np.repeat(np.array(corners, float), 50, axis=0)


def found(shores: list[FloatArray], on_land: FloatArray, *at: tuple[float, float]) -> list[bool] | None:
    shape = closed_water(shores, AREA, on_land)
    return None if shape is None else shapely.contains_xy(shape, np.array(at, float)).tolist()


def test_a_river_lies_between_its_shores() -> None:
    shape = closed_water([SOUTH, NORTH], AREA, roads((20.0, 90.0), (120.0, 5.0)))
    south, north = (np.interp([0.0, 200.0], *shore.T) for shore in (SOUTH, NORTH))
    below = 0.5 * (south[0] + 30.0) * 90.0 + 0.5 * (30.0 + south[1]) * 110.0
    above = 0.5 * (north[0] + 60.0) * 110.0 + 0.5 * (60.0 + north[1]) * 90.0
    assert shape is not None
    assert shape.area == pytest.approx(above - below)


def test_one_shore_has_water_where_no_roads_are() -> None:
    at = ((100.0, 5.0), (100.0, 60.0))
    assert found([SOUTH], roads((20.0, 90.0)), *at) == [True, False]
    assert found([SOUTH], roads((20.0, 5.0)), *at) == [False, True]


def test_islands_and_pieces_in_any_order_and_direction() -> None:
    island = np.array([(90.0, 40.0), (110.0, 40.0), (100.0, 50.0), (90.0, 40.0)])
    pieces = [NORTH[1:], island, SOUTH[::-1], NORTH[:2][::-1]]
    at = ((100.0, 44.0), (50.0, 45.0), (50.0, 90.0), (50.0, 5.0))
    assert found(pieces, roads((20.0, 90.0)), *at) == [False, True, False, False]


def test_shores_that_end_within_go_straight_on_to_the_side() -> None:
    inside = SOUTH.clip((6.0, 0.0), (195.0, 100.0))
    at = ((2.0, 10.0), (198.0, 10.0), (2.0, 30.0), (198.0, 30.0))
    assert found([inside], roads((20.0, 90.0)), *at) == [True, True, False, False]


@pytest.mark.parametrize(
    ("shores", "on_land"),
    [
        ([SOUTH], roads((20.0, 90.0), (20.0, 5.0))),  # Roads on both sides
        ([SOUTH], np.zeros((0, 2))),  # Nothing that tells the sides
        ([np.array([(90.0, 40.0), (95.0, 50.0)])], roads((20.0, 90.0))),  # More would be guessed than is known
    ],
)
def test_what_is_not_clear_is_no_water(shores: list[FloatArray], on_land: FloatArray) -> None:
    assert closed_water(shores, AREA, on_land) is None


def test_shores_elsewhere_are_none_here() -> None:
    shape = closed_water([SOUTH - (0.0, 500.0)], AREA, roads((20.0, 90.0)))
    assert shape is not None
    assert shape.is_empty
