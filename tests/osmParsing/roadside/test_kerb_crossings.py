from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.model import FloatArray
from osm2xodr.osmParsing.defaults import KERB_REACH
from osm2xodr.osmParsing.roadside.kerbs import (
    Segments,
    Stations,
    covered_edges,
    find_crossings,
    nearest_edges,
)


def stations(*x: float) -> Stations:
    """Return places on a street from west to east along y = 0."""
    return Stations(
        np.array([[value, 0.0] for value in x]), np.tile((1.0, 0.0), (len(x), 1)), np.zeros(len(x), np.int64)
    )


def segments(*lines: list[tuple[float, float]], layer: int = 0) -> Segments:
    return Segments.of_lines([np.array(line) for line in lines], [layer] * len(lines))


def box(west: float, south: float, east: float, north: float) -> list[tuple[float, float]]:
    return [(west, south), (east, south), (east, north), (west, north), (west, south)]


def edges(
    area: list[list[tuple[float, float]]], *x: float, lines: bool = False
) -> list[tuple[float | None, float | None]]:
    """Return the left and right edge of each station."""
    found = find_crossings(stations(*x), segments(*area))
    left, right = (nearest_edges if lines else covered_edges)(found, len(x))

    def known(values: FloatArray) -> list[float | None]:
        return [None if np.isnan(value) else round(float(value), 6) for value in values]

    return list(zip(known(left), known(right), strict=True))


def test_a_line_is_crossed_where_it_lies_abreast() -> None:
    found = find_crossings(stations(10.0, 60.0), segments([(0.0, 2.0), (40.0, 6.0)]))
    assert found.station.tolist() == [0]
    assert found.t == pytest.approx([3.0])
    assert found.along.tolist() == [True]


def test_a_node_on_the_line_across_counts_once() -> None:
    found = find_crossings(stations(10.0), segments([(0.0, 3.0), (10.0, 3.0), (20.0, 3.0)]))
    assert found.t == pytest.approx([3.0])


def test_lines_out_of_reach_or_on_another_layer_are_not_found() -> None:
    line = [(0.0, KERB_REACH + 0.1), (40.0, KERB_REACH + 0.1)]
    assert not len(find_crossings(stations(10.0), segments(line)).t)
    assert not len(find_crossings(stations(10.0), segments([(0.0, 3.0), (40.0, 3.0)], layer=1)).t)


def test_the_nearest_line_on_each_side_is_the_edge() -> None:
    kerbs = [[(0.0, y), (40.0, y)] for y in (9.0, 3.5, -2.5, -6.0)]
    assert edges(kerbs, 20.0, lines=True) == [(3.5, -2.5)]
    assert edges(kerbs[:2], 20.0, lines=True) == [(3.5, None)]


def test_a_nearest_line_that_does_not_run_along_is_no_edge() -> None:
    kerbs = [[(0.0, 3.0), (40.0, 3.0)], [(18.0, -1.0), (22.0, -4.0)], [(0.0, -3.5), (40.0, -3.5)]]
    assert edges(kerbs, 10.0, 20.0, lines=True) == [(3.0, -3.5), (3.0, None)]


def test_areas_side_by_side_are_one() -> None:
    lower, upper = box(0.0, -4.0, 40.0, -1.0), box(0.0, -0.8, 40.0, 5.0)
    assert edges([lower, upper], 20.0) == [(5.0, -4.0)]


def test_areas_with_a_verge_between_them_are_two() -> None:
    assert edges([box(0.0, -4.0, 40.0, 3.0), box(0.0, 4.0, 40.0, 9.0)], 20.0) == [(3.0, -4.0)]


def test_areas_that_overlap_end_where_the_wider_one_does() -> None:
    assert edges([box(0.0, -4.0, 40.0, 3.0), box(0.0, -3.0, 40.0, 5.0)], 20.0) == [(5.0, -4.0)]


def test_what_no_area_covers_has_no_edge() -> None:
    assert edges([box(0.0, 2.0, 40.0, 8.0)], 20.0, 60.0) == [(None, None), (None, None)]


def test_an_area_that_reaches_out_of_sight_tells_nothing_and_leaves_others_alone() -> None:
    wide = box(0.0, -30.0, 40.0, 4.0)
    assert edges([wide, box(50.0, -4.0, 90.0, 3.0)], 20.0, 70.0) == [(None, None), (3.0, -4.0)]


def test_an_edge_that_does_not_run_along_is_none() -> None:
    mouth = [(0.0, -3.0), (40.0, -3.0), (40.0, 3.0), (24.0, 3.0), (16.0, 9.0), (0.0, 9.0), (0.0, -3.0)]
    assert edges([mouth], 10.0, 20.0, 30.0) == [(9.0, -3.0), (None, -3.0), (3.0, -3.0)]
