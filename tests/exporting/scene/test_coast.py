"""The sea beside coastlines that are not whole in the file."""

from __future__ import annotations

import numpy as np
import shapely

from osm2xodr.exporting.scene.water import sea_of
from osm2xodr.model import FloatArray

BOX = shapely.box(-1000.0, -1000.0, 1000.0, 1000.0)
NOWHERE = np.zeros((0, 2))


def is_sea(lines: list[list[tuple[float, float]]], on_land: FloatArray, *at: tuple[float, float]) -> list[bool]:
    areas = sea_of([np.array(line, float) for line in lines], BOX, on_land)
    return [any(area.contains(shapely.Point(place)) for area in areas) for place in at]


def test_a_missing_piece_of_coast_is_closed() -> None:
    # A cape in the north-west, whose point is not in the file: the sea is east of it.
    south, north = [(-900.0, -100.0), (700.0, -20.0)], [(700.0, 20.0), (-900.0, 100.0)]
    inside, beyond, above, below = (600.0, 0.0), (800.0, 0.0), (0.0, 300.0), (0.0, -300.0)
    assert is_sea([north[::-1], south[::-1]], NOWHERE, inside, beyond, above, below) == [True, False, False, False]
    assert is_sea([north, south], NOWHERE, inside, beyond, above, below) == [False, True, True, True]


def test_a_ring_that_lacks_a_piece_is_an_island() -> None:
    ring = [(0.0, 0.0), (300.0, 0.0), (300.0, 300.0), (0.0, 300.0), (0.0, 100.0)]
    places = (150.0, 150.0), (-50.0, 50.0), (900.0, 900.0)
    assert is_sea([ring], NOWHERE, *places) == [False, True, True]
    assert is_sea([ring[::-1]], NOWHERE, *places) == [True, False, False]


def test_a_wide_gap_goes_on_to_the_sides() -> None:
    # Two coasts of a strait, closer to the sides than to each other.
    lines = [[(-900.0, -500.0), (900.0, -500.0)], [(900.0, 500.0), (-900.0, 500.0)]]
    places = (0.0, 0.0), (0.0, 700.0), (0.0, -700.0), (980.0, 0.0)
    assert is_sea(lines, NOWHERE, *places) == [False, True, True, False]


def test_a_coast_goes_on_so_that_roads_lie_on_land() -> None:
    # The sea is in the south; the nearest side to the last place is in the north.
    line = [(-900.0, 0.0), (300.0, 600.0)]
    road = np.column_stack([np.linspace(320.0, 700.0, 200), np.linspace(700.0, 900.0, 200)])
    beside = (600.0, 620.0), (600.0, 500.0), (600.0, 900.0)
    assert is_sea([line], NOWHERE, *beside) == [True, True, True]
    assert is_sea([line], road, *beside) == [False, True, False]
    # Few places of roads do not count, as on quays.
    inland = np.column_stack([np.linspace(-900.0, -500.0, 4000), np.full(4000, 700.0)])
    assert is_sea([line], np.concatenate([inland, road[:3]]), *beside) == [True, True, True]
