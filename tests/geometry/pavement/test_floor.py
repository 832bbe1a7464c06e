"""The floor of junctions: which gaps between lanes get strips, where these begin and how wide they are."""

from __future__ import annotations

import math

import numpy as np
import pytest
from floor_cases import Line, connecting
from road_measures import width_at

from osm2xodr.geometry.pavement import lay_floor
from osm2xodr.geometry.pavement.widths import width_records
from osm2xodr.model import Rule

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)

# Lanes of 3 m around a gap, 4 m from west to east and 2 m from south to north: south, east, north and west of it.
AROUND: tuple[Line, ...] = ((-3, -1.5, 7, -1.5), (5.5, -3, 5.5, 5), (7, 3.5, -3, 3.5), (-1.5, 5, -1.5, -3))


@EITHER
def test_a_strip_at_a_long_side_closes_the_gap(rule: Rule) -> None:
    floor = lay_floor(connecting(AROUND), rule)
    assert floor.right == {}
    ((road, widths),) = floor.left.items()
    assert road in (0, 2)
    # The gap begins 3 m behind the start of both long sides.
    assert [width_at(widths, s) for s in (3.1, 5.0, 6.9)] == pytest.approx([2.05] * 3, abs=0.05)
    assert [width_at(widths, s) for s in (0.0, 2.0, 8.0, 10.0)] == [0.0] * 4


def test_lanes_the_other_way_round_have_it_on_the_other_side() -> None:
    floor = lay_floor(connecting([(x1, y1, x0, y0) for x0, y0, x1, y1 in AROUND]), Rule.RIGHT_HAND)
    assert floor.left == {}
    assert len(floor.right) == 1


def test_a_place_that_is_open_to_a_side_stays_open() -> None:
    floor = lay_floor(connecting(AROUND[:3]), Rule.RIGHT_HAND)
    assert (floor.left, floor.right) == ({}, {})


def test_lanes_of_two_junctions_enclose_nothing() -> None:
    floor = lay_floor(connecting(AROUND, [0, 0, 1, 1]), Rule.RIGHT_HAND)
    assert (floor.left, floor.right) == ({}, {})


@pytest.mark.parametrize(("size", "closed"), [(7.5, True), (8.5, False)])
def test_blocks_between_roads_stay_open(size: float, closed: bool) -> None:
    """The largest gap is 65 m²."""
    low, high = -1.5, size + 1.5
    square = (
        (-3, low, size + 3, low),
        (high, -3, high, size + 3),
        (size + 3, high, -3, high),
        (low, size + 3, low, -3),
    )
    assert bool(lay_floor(connecting(square), Rule.RIGHT_HAND).left) is closed


def test_a_strip_goes_on_to_the_tip_of_a_wedge() -> None:
    """Two lanes part by 0.1 m a metre; a third one crosses them 10 m on."""
    slope = math.atan(0.1)
    # The left lane's right edge and the right lane's left one begin at the same point.
    left = (-1.5 * math.sin(slope), 1.5 * math.cos(slope))
    lines = (
        (0.0, -1.5, 14.0, -1.5),
        (*left, left[0] + 14 * math.cos(slope), left[1] + 14 * math.sin(slope)),
        (11.5, -6.0, 11.5, 6.0),
    )
    floor = lay_floor(connecting(lines), Rule.RIGHT_HAND)
    widths = floor.left.get(0) or floor.right[1]
    for s in (2.0, 4.0, 6.0, 8.0, 9.5):
        assert width_at(widths, s) == pytest.approx(0.1 * s + 0.05, abs=0.06)


def test_no_roads_have_no_floor() -> None:
    none = connecting(AROUND).chosen(np.zeros(4, bool))
    floor = lay_floor(none, Rule.RIGHT_HAND)
    assert (floor.left, floor.right) == ({}, {})


def test_widths_become_few_lines() -> None:
    s = np.linspace(0.0, 8.0, 41)
    width = np.where(s < 3.9, 0.0, np.where(s < 6.0, 2.0 + 0.01 * np.sin(9 * s), 2.0 - (s - 6.0)))
    one, other = width_records(np.repeat([0, 1], 41), np.tile(s, 2), np.concatenate([width, 0 * s]), 2, 0.04)
    assert 4 <= len(one) <= 6
    for place, wanted in zip(s.tolist(), width.tolist(), strict=True):
        assert width_at(one, place) == pytest.approx(wanted, abs=0.041)
    assert [(item.s, item.a, item.b) for item in other] == [(0.0, 0.0, 0.0)]


def test_widths_that_end_in_nothing_are_nowhere_below_it() -> None:
    """Places are rounded to millimetres, up at the end of a road."""
    length = 7.0004
    (widths,) = width_records(np.zeros(3, np.int64), np.array([0.0, 6.9, length]), np.array([0.0, 1.0, 0.0]), 1, 0.04)
    assert width_at(widths, length) >= 0.0
