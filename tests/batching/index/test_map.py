"""Where areas lie on the map of the page."""

from __future__ import annotations

import math
import re

import pytest
from batch_results import Ring, rectangle

from osm2xodr.batching.index.map import RADIUS, Map, Shape, make_map, number


def place(chart: Map, shape: Shape | None) -> tuple[float, float]:
    """Return longitude and latitude of a shape's middle, degrees."""
    assert shape is not None
    x, y = chart.left + shape.x * chart.unit, chart.top - shape.y * chart.unit
    return math.degrees(x / RADIUS), math.degrees(math.atan(math.sinh(y / RADIUS)))


def test_places_come_back_as_they_were() -> None:
    chart = make_map([rectangle(11.3, 48.0, 0.04, 0.02), rectangle(11.9, 48.3, 0.04, 0.02), ()])
    assert place(chart, chart.shapes[0]) == pytest.approx((11.32, 48.01), abs=1e-5)
    assert place(chart, chart.shapes[1]) == pytest.approx((11.92, 48.31), abs=1e-5)
    assert chart.shapes[2] is None


@pytest.mark.parametrize("lat", [-60.0, 0.0, 47.0, 70.0])
def test_squares_stay_square(lat: float) -> None:
    width = 0.02 / math.cos(math.radians(lat))
    chart = make_map([rectangle(20.0, lat - 0.01, width, 0.02), rectangle(21.0, lat, width, 0.02)])
    shape = chart.shapes[0]
    assert shape is not None
    assert shape.width / shape.height == pytest.approx(1.0, rel=1e-3)


def test_everything_is_inside() -> None:
    outlines = [rectangle(-122.4, 47.5, 0.1, 0.1), rectangle(115.7, -32.1, 0.1, 0.1), rectangle(18.9, 69.6, 0.1, 0.1)]
    chart = make_map(outlines)
    for shape in chart.shapes:
        assert shape is not None
        assert shape.width / 2 <= shape.x <= chart.width - shape.width / 2
        assert shape.height / 2 <= shape.y <= chart.height - shape.height / 2


def test_areas_on_both_sides_of_the_date_line_are_neighbours() -> None:
    across: tuple[Ring] = (((179.9, -17.0), (-179.9, -17.0), (-179.9, -16.9), (179.9, -16.9)),)
    chart = make_map([rectangle(179.6, -17.0, 0.2, 0.1), across, rectangle(-179.8, -17.0, 0.2, 0.1)])
    assert chart.unit * chart.width < 100_000.0
    xs = [shape.x for shape in chart.shapes if shape]
    assert xs == sorted(xs)
    middle = chart.shapes[1]
    assert middle is not None
    assert middle.width * chart.unit == pytest.approx(math.radians(0.2) * RADIUS, rel=1e-6)


def test_holes_and_parts_are_in_one_path() -> None:
    outline = (*rectangle(7.0, 43.0, 0.3, 0.3), *rectangle(7.1, 43.1, 0.1, 0.1))
    shape = make_map([outline]).shapes[0]
    assert shape is not None
    assert re.fullmatch(r"(M[\d.]+ [\d.]+(L[\d.]+ [\d.]+){3}Z){2}", shape.path)


def test_a_point_has_a_place_but_no_outline() -> None:
    chart = make_map([(((7.0, 43.0),),)])
    shape = chart.shapes[0]
    assert shape is not None
    assert shape.path == ""
    assert place(chart, shape) == pytest.approx((7.0, 43.0), abs=1e-6)
    assert 300.0 <= chart.unit * chart.width < 330.0


def test_the_map_ends_before_the_poles() -> None:
    chart = make_map([rectangle(-180.0, -90.0, 360.0, 180.0)])
    shape = chart.shapes[0]
    assert shape is not None
    assert math.isfinite(chart.height)
    assert shape.height == pytest.approx(shape.width, rel=0.01)


@pytest.mark.parametrize(
    ("value", "text"), [(1.0, "1"), (0.1239, "0.124"), (-0.0001, "0"), (-2.5, "-2.5"), (100.0, "100")]
)
def test_numbers_are_short(value: float, text: str) -> None:
    assert number(value) == text
