"""The floor of junctions: which gaps between lanes get strips, where these begin and how wide they are."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from floor_cases import Line, connecting
from road_measures import width_at

from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junction_floor import Faces, lay_floor
from osm2xodr.geometry.junction_floor.cross_sections import CrossSections, LaneEdges
from osm2xodr.geometry.junction_floor.filling import room_before_ends, width_records
from osm2xodr.geometry.junction_floor.gaps import room_inside
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.model import LaneType, PlanView, Rule

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


@pytest.mark.parametrize(
    ("wide", "deep", "sidewalk", "enclosed", "paved"),
    [
        (2.5, 2.0, False, True, True),  # Too small
        (6.0, 3.0, False, True, False),
        (6.0, 3.0, False, False, True),
        (6.0, 3.0, True, True, True),  # Sidewalks bring their own kerb
    ],
)
def test_a_gap_is_paved_unless_it_is_an_island(
    wide: float, deep: float, sidewalk: bool, enclosed: bool, paved: bool
) -> None:
    roads = connecting(
        [
            (
                x0 + (wide - 4) * (x0 > 3),
                y0 + (deep - 2) * (y0 > 1),
                x1 + (wide - 4) * (x1 > 3),
                y1 + (deep - 2) * (y1 > 1),
            )
            for x0, y0, x1, y1 in AROUND
        ]
    )
    if sidewalk:
        roads = replace(roads, lane_type=(*roads.lane_type[:2], LaneType.SIDEWALK, roads.lane_type[3]))
    floor = lay_floor(roads, Rule.RIGHT_HAND, is_island=lambda hole: enclosed)
    assert len(floor.left) == 1
    assert floor.paved_left == (set(floor.left) if paved else set())
    assert floor.paved_right == set()


def test_the_end_of_a_road_that_nothing_goes_on_from_closes_a_gap() -> None:
    """The road ends at x = 0, where pavement becomes narrower to the south of its middle: 1 m on 3 m."""
    x, y = np.linspace(0.0, 6.0, 60), np.linspace(2.0, 0.0, 60)
    lines = np.array([[0.0, 2.0, 6.0, 0.0], [0.0, 2.0, 0.0, 0.0]])
    at, left, right = np.array([1]), np.array([3.5]), np.array([-1.5])
    faces = Faces(np.zeros(120, np.int64), np.append(x, 0 * x), np.append(y, y), lines, at, left, right)
    roads = replace(connecting([(0.0, -1.5, 12.0, -1.5)]), entry=np.array([1]), exit=np.array([2]))
    assert lay_floor(roads, Rule.RIGHT_HAND).left == {}
    floor = lay_floor(roads, Rule.RIGHT_HAND, faces)
    assert floor.paved_left == {0}
    for s in (0.9, 1.8, 2.7, 3.6, 4.5):
        assert width_at(floor.left[0], s) == pytest.approx((6.0 - s) / 3 + 0.05, abs=0.06)
    assert width_at(floor.left[0], 8.0) == 0.0


def test_end_faces_are_where_half_of_a_carriageway_ends() -> None:
    """A road of 10 m to the east, 6 m wide; a lane of 3 m leads on from the right side of its end."""
    zero = np.zeros(1)
    section = SimpleNamespace(left_edge=3.0, right_edge=-3.0)
    parts = cast(
        RoadParts,
        SimpleNamespace(
            plan_view=PlanView(np.arange(2), zero, zero, zero, zero, zero + 10.0, zero),
            length=zero + 10.0,
            at_end=lambda end: SimpleNamespace(section=section),
        ),
    )
    end, lane, t = np.array([1]), np.array([-1]), np.array([-1.5])
    one = connecting([(10.0, -1.5, 22.0, -1.5)], [4])
    right = replace(one, entry=end, exit=end, entry_lane=lane, exit_lane=lane, entry_t=t, exit_t=t)
    faces = Faces.of(parts, right, Rule.RIGHT_HAND)
    assert set(faces.junction.tolist()) == {4}
    assert (faces.end.tolist(), faces.left.tolist(), faces.right.tolist()) == ([1], [3.0], [-3.0])
    assert faces.lines.tolist() == [
        pytest.approx([9.85, 3.4, 9.85, -3.4]),
        pytest.approx([9.85, 3.0, 19.0, 0.0]),
    ]
    whole = replace(right, entry_t=zero, exit_t=zero, entry_width=zero + 6.0, exit_width=zero + 6.0)
    assert not len(Faces.of(parts, whole, Rule.RIGHT_HAND).lines)
    # Parking of 2 m ends between the carriageway and a sidewalk of 3 m that goes on.
    walk = replace(right, entry_t=zero + 6.5, exit_t=zero + 6.5, lane_type=(LaneType.SIDEWALK,))
    beside = Faces.of(parts, whole.joined(walk), Rule.RIGHT_HAND)
    assert beside.lines.tolist() == [pytest.approx([9.85, 2.6, 9.85, 5.4])]
    assert not len(beside.end)
    at_kerb = replace(walk, entry_t=zero + 4.5, exit_t=zero + 4.5)
    assert not len(Faces.of(parts, whole.joined(at_kerb), Rule.RIGHT_HAND).lines)


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


@pytest.mark.parametrize("aside", [0.0, 0.13, 0.27])
def test_a_narrow_slit_is_closed_as_far_as_it_goes(aside: float) -> None:
    """A slit of 0.4 m becomes one of 0.1 m over 40 m, wherever it lies in the cells of the grid."""
    lines = ((-20.0, -1.5, 20.0, -1.5), (-20.0, 1.9, 20.0, 1.6), (-19.0, -6.0, -19.0, 6.0), (19.0, -6.0, 19.0, 6.0))
    floor = lay_floor(connecting([(x0, y0 + aside, x1, y1 + aside) for x0, y0, x1, y1 in lines]), Rule.RIGHT_HAND)
    widths = floor.left.get(0) or floor.right[1]
    for s in (5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0):
        assert width_at(widths, s) == pytest.approx(0.45 - 0.0075 * s, abs=0.06)
    # Between the arms it is open to both sides.
    assert width_at(widths, 0.0) <= 0.2
    assert width_at(widths, 40.0) <= 0.2


def test_a_strip_ends_with_the_lane_beyond_it() -> None:
    """A slit of 0.4 m, open from x = 5.5 on; of two lanes in the north, which see half of it, one ends at x = 5."""
    north, across = ((-20.0, 1.9, -7.0, 1.9), (-8.0, 1.9, 5.0, 1.9)), ((-19, -6, -19, 6), (4, -6, 4, 6))
    floor = lay_floor(connecting([(-20.0, -1.5, 20.0, -1.5), *north, *across]), Rule.RIGHT_HAND)
    widths = floor.left[0]
    assert [width_at(widths, s) for s in (10.0, 22.0)] == pytest.approx([0.45, 0.45], abs=0.05)
    assert [width_at(widths, s) for s in (26.5, 27.5, 30.0, 39.0)] == [0.0] * 4


def test_strips_reach_the_outermost_lanes_of_their_arm_where_they_end() -> None:
    """Two lanes of 3 m begin side by side at the end of road 0; at the start of road 3 the first one is alone."""
    roads = connecting([(0.0, -1.5, 20.0, -1.5), (0.0, 1.5, 20.0, 8.0)])
    roads = replace(
        roads, entry=np.array([1, 1]), exit=np.array([6, 8]), entry_t=np.array([-1.5, 1.5]), exit_t=np.zeros(2)
    )
    edges, rows = LaneEdges.of(roads, Rule.RIGHT_HAND), np.arange(2)
    sections = CrossSections.of(roads, edges, 0.28, rows)
    left, right = room_before_ends(sections, rows, roads, edges, Faces.none())
    first = sections.road == 0
    s = sections.s[first]
    assert left[first] == pytest.approx(0.2 + np.minimum(3.0 + s, 20.0 - s))
    assert right[first] == pytest.approx(0.2 + np.minimum(s, 20.0 - s))
    # The carriageway of road 3, driven on towards its end, is 7 m wide.
    faces = replace(Faces.none(), end=np.array([6]), left=np.array([2.5]), right=np.array([-4.5]))
    left, right = room_before_ends(sections, rows, roads, edges, faces)
    assert left[first][-1] == pytest.approx(0.2 + 1.0)
    assert right[first][-1] == pytest.approx(0.2 + 3.0)


def arc(turn: float, aside: float) -> ConnectingRoads:
    """Return a road along an arc of 5 m by a turn, left or right, rad, whose lane of 3 m lies aside of it, m."""
    roads = connecting([(0.0, 0.0, 5.0 * abs(turn), 0.0)])
    plan = replace(roads.plan_view, curvature=np.full(1, math.copysign(0.2, turn)))
    return replace(roads, plan_view=plan, entry_aside=np.full(1, aside), exit_aside=np.full(1, aside))


@pytest.mark.parametrize(("aside", "most"), [(-6.0, 0.28 * 1.7 / 2.5), (-1.5, 0.28), (6.0, 0.28)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_cross_sections_are_closer_where_edges_outside_of_a_bend_are_far_apart(
    sign: float, aside: float, most: float
) -> None:
    """An edge 7.5 m outside of a bend of 5 m is 2.5 times as long as the line."""
    roads = arc(sign * 3.0, sign * aside)
    edges = LaneEdges.of(roads, Rule.RIGHT_HAND)
    sections = CrossSections.of(roads, edges, 0.28, np.arange(1))
    assert sections.spacing[0] == pytest.approx(most, rel=0.02)
    assert sections.spacing[0] <= most


@pytest.mark.parametrize(("radius", "left"), [(0.5, 0.075), (5.0, 0.1)])
def test_strips_inside_of_a_bend_end_before_its_centre(radius: float, left: float) -> None:
    roads = connecting([(0.0, 0.0, 3.0, 0.0)])
    roads = replace(roads, plan_view=replace(roads.plan_view, curvature=np.full(1, 1.0 / radius)))
    sections = CrossSections.of(roads, LaneEdges.of(roads, Rule.RIGHT_HAND), 0.28, np.arange(1))
    room = room_inside(sections, 1, np.arange(len(sections.s)))
    assert room + 1.5 == pytest.approx(radius - left)


def test_no_strip_folds_inside_of_a_bend_whatever_lies_beyond_its_centre() -> None:
    """A bend of 5 m by 149 degrees, whose gap goes on past its centre to lanes 1.5 m north and 1 m west of it."""
    radius, turn = 5.0, 2.6
    length = radius * turn
    x, y = radius * math.sin(turn), radius * (1.0 - math.cos(turn))
    onward = (x, y, x + 5.0 * math.cos(turn), y + 5.0 * math.sin(turn))
    lines: list[Line] = [(0, 0, length, 0), onward, (-2.5, -3, -2.5, 14), (-5, 8.0, 14, 8.0), (0, 0, -4, 0)]
    roads = connecting(lines)
    curvature = np.array([1.0 / radius, *np.zeros(len(lines) - 1)])
    floor = lay_floor(replace(roads, plan_view=replace(roads.plan_view, curvature=curvature)), Rule.RIGHT_HAND)
    widest = max(width_at(floor.left[0], s) for s in np.linspace(0.0, length, 200).tolist())
    # It keeps 0.1 m of the radius, but for what widths are off by.
    assert 1.5 + widest < radius - 0.05
    assert 1.5 + widest > radius - 0.15


def test_no_roads_have_no_floor() -> None:
    none = connecting(AROUND).chosen(np.zeros(4, bool))
    floor = lay_floor(none, Rule.RIGHT_HAND)
    assert (floor.left, floor.right) == ({}, {})


def test_strips_have_no_teeth() -> None:
    """The end of a strip in Malta whose points esmini 3.6 never found."""
    s = np.array([0.0, 0.27, 0.54, 0.81, 1.08, 1.35])
    width = np.array([0.0, 0.406, 0.703, 0.406, 0.473, 0.2])
    strips, places = np.repeat([0, 1], 6), np.tile(s, 2)
    one, other = width_records(strips, places, np.concatenate([width, width[::-1]]), 2, 0.001)
    assert [cubic.a for cubic in one] == pytest.approx([0.0, 0.406, 0.703, 0.473, 0.473])
    assert [cubic.a for cubic in other] == pytest.approx([0.2, 0.473, 0.473, 0.703, 0.406])


def test_widths_become_few_lines() -> None:
    s = np.linspace(0.0, 8.0, 41)
    width = np.where(s < 3.9, 0.0, np.where(s < 6.0, 2.0 + 0.01 * np.sin(9 * s), 2.0 - (s - 6.0)))
    one, other = width_records(np.repeat([0, 1], 41), np.tile(s, 2), np.concatenate([width, 0 * s]), 2, 0.04)
    assert 4 <= len(one) <= 6
    for place, wanted in zip(s.tolist(), width.tolist(), strict=True):
        assert width_at(one, place) == pytest.approx(wanted, abs=0.041)
    assert [(item.s, item.a, item.b) for item in other] == [(0.0, 0.0, 0.0)]


@pytest.mark.parametrize("before", [7, 8])
def test_widths_of_a_strip_do_not_depend_on_other_strips(before: int) -> None:
    s = np.linspace(0.0, 8.0, 41)
    width = 1.0 + np.sin(s)
    (alone,) = width_records(np.zeros(41, np.int64), s, width, 1, 0.04)
    more, places, zigzag = np.zeros(before, np.int64), 0.2 * np.arange(before), 1.0 * (np.arange(before) > before / 2)
    strips, every = np.append(more, more[:1].repeat(41) + 1), np.append(places, s)
    assert width_records(strips, every, np.append(zigzag, width), 2, 0.04)[1] == alone


def test_widths_that_end_in_nothing_are_nowhere_below_it() -> None:
    """Places are rounded to millimetres, up at the end of a road."""
    length = 7.0004
    (widths,) = width_records(np.zeros(3, np.int64), np.array([0.0, 6.9, length]), np.array([0.0, 1.0, 0.0]), 1, 0.04)
    assert width_at(widths, length) >= 0.0
