"""Which area each piece of road belongs to, and the heights that two areas have in common where roads are cut."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from elevation_helpers import Ground, Solved, make_problem, straight

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import CoverageError
from osm2xodr.geometry.borders.defaults import BORDER_PIECE, BORDER_STUB
from osm2xodr.geometry.borders.division import find_borders
from osm2xodr.geometry.borders.heights import chosen_roads, with_border_heights
from osm2xodr.geometry.heights.solve import ProfileProblem, solve_profiles
from osm2xodr.model import Borders, FloatArray, LocalFrame, Outline, Partition, Surface

WEST, EAST = 0, 1


def square(west: float, south: float, size: float = 1000.0) -> Outline:
    corners = [(west, south), (west + size, south), (west + size, south + size), (west, south + size)]
    return Outline((np.array(corners),))


def partition(own: int = WEST, *outlines: Outline) -> Partition:
    found = outlines or (square(-1000.0, -500.0), square(0.0, -500.0))
    names = tuple("abcd"[: len(found)])
    return Partition(LocalFrame("", 0.0, 0.0), names, found, tuple(range(1, len(found) + 1)), own)


def borders_of(problem: ProfileProblem, areas: Partition) -> Borders:
    return find_borders(areas, problem.plan_view, problem.end_junction, problem.junction_xy)


def listed(borders: Borders, road: int) -> list[tuple[float, int]]:
    part = slice(borders.piece_start[road], borders.piece_start[road + 1])
    return [
        (round(float(s), 4), int(area))
        for s, area in zip(borders.piece_s[part], borders.piece_area[part], strict=True)
    ]


def test_a_road_is_cut_where_it_crosses_the_border() -> None:
    problem = make_problem([straight((-203.21, 0.0), (300.0, 0.0)), straight((-300.0, 5.0), (-100.0, 5.0))])
    borders = borders_of(problem, partition())
    assert listed(borders, 0) == [(0.0, WEST), (203.21, EAST)]
    assert listed(borders, 1) == [(0.0, WEST)]
    assert borders.piece_start.tolist() == [0, 2, 3]


def test_the_border_of_no_neighbour_cuts_as_well() -> None:
    problem = make_problem([straight((-1200.0, 0.0), (300.0, 0.0))])
    assert listed(borders_of(problem, partition()), 0) == [(0.0, -1), (200.0, WEST), (1200.0, EAST)]


def test_a_junction_keeps_the_first_metres_of_its_arms() -> None:
    """A junction just east of the border has arms that lie west of it."""
    arms = [straight((3.0, 0.0), (-300.0, 0.0), start=0), straight((4.0, 5.0), (4.0, 300.0), start=0)]
    borders = borders_of(make_problem(arms, [(5.0, 0.0)]), partition())
    assert borders.junction_area.tolist() == [EAST]
    assert listed(borders, 0) == [(0.0, EAST), (BORDER_STUB, WEST)]
    assert listed(borders, 1) == [(0.0, EAST)]


def test_a_short_road_between_junctions_of_two_areas_is_shared_in_the_middle() -> None:
    road = straight((-2.0, 0.0), (28.0, 0.0), start=0, end=1)
    borders = borders_of(make_problem([road], [(-4.0, 0.0), (30.0, 0.0)]), partition())
    assert listed(borders, 0) == [(0.0, WEST), (15.0, EAST)]


def test_a_road_along_the_border_is_not_cut_again_and_again() -> None:
    """It winds about the border with a wave of 60 m, and ends in the west."""
    wave = [(20.0 * np.sin(0.1 * y) - 5.0, y) for y in np.arange(-200.0, 200.0, 15.0)]
    roads = [straight(a, b) for a, b in pairwise(wave)]
    problem = make_problem(roads)
    # One road of many records, instead of many roads.
    plan = problem.plan_view
    s = np.concatenate([[0.0], np.cumsum(plan.length)])
    line = replace(plan, start=np.array([0, len(s) - 1], np.int64), s=s[:-1])
    borders = find_borders(partition(), line, np.array([[-1, -1]]), np.zeros((0, 2)))
    lengths = np.diff([*borders.piece_s, s[-1]])
    assert lengths.min() >= BORDER_PIECE
    assert (np.diff(borders.piece_area) != 0).all()


def test_three_areas_agree_about_a_corner_that_is_cut_off() -> None:
    """Seven metres of the road lie in none of them, and go to one neighbour."""
    outlines = (square(-1000.0, -1000.0), square(0.0, -1000.0), square(0.0, 0.0))
    problem = make_problem([straight((-200.0, -195.0), (200.0, 205.0))])
    found = [listed(borders_of(problem, partition(own, *outlines)), 0) for own in range(3)]
    assert found[0] == found[1] == found[2]
    assert [area for _, area in found[0]] == [0, 2]


HILLS = Ground(lambda x, y: 20.0 * np.sin(x / 90.0) + 15.0 * np.cos(y / 70.0) + 0.02 * x, cell_size=30.0, sigma=1.5)


def solved_for(
    problem: ProfileProblem, areas: Partition, surface: Surface, border: Surface
) -> tuple[Solved, ProfileProblem]:
    borders = borders_of(problem, areas)
    diagnostics = Diagnostics()
    pinned = with_border_heights(problem, borders, lambda x, y: border, None, diagnostics)
    return Solved(pinned, solve_profiles(pinned, surface, diagnostics), diagnostics), pinned


def test_both_areas_find_the_same_height_from_different_surfaces() -> None:
    """Each area has other roads far off, and thinks otherwise of the noise."""
    common = [straight((-600.0, 40.0), (500.0, 70.0)), straight((-400.0, -100.0), (600.0, -130.0))]
    west, east = straight((-900.0, 0.0), (-700.0, 300.0)), straight((950.0, 0.0), (800.0, -300.0))
    noisy = Ground(lambda x, y: HILLS.height(x, y) + 2.0 * np.sin(x * y), cell_size=30.0, sigma=4.0)
    one, pinned = solved_for(make_problem([*common, west]), partition(WEST), HILLS, HILLS)
    other, _ = solved_for(make_problem([east, *common]), partition(EAST), noisy, HILLS)
    assert pinned.pins is not None
    assert pinned.pins.road.tolist() == [0, 1]
    for road, s in zip(pinned.pins.road.tolist(), pinned.pins.s.tolist(), strict=True):
        assert one.z(road, s)[0] == pytest.approx(other.z(road + 1, s)[0], abs=2e-3)
        assert one.grade(road, s)[0] == pytest.approx(other.grade(road + 1, s)[0], abs=3e-4)
    without = [
        Solved(make_problem(roads), solve_profiles(make_problem(roads), surface, Diagnostics()))
        for roads, surface in (([*common, west], HILLS), ([east, *common], noisy))
    ]
    s = pinned.pins.s[0]
    assert abs(without[0].z(0, s)[0] - without[1].z(1, s)[0]) > 0.05


def test_where_no_elevation_model_reaches_the_border_it_is_said() -> None:
    problem = make_problem([straight((-600.0, 40.0), (500.0, 70.0))])
    areas = partition()

    def none(x: FloatArray, y: FloatArray) -> Surface:
        raise CoverageError("nothing here")

    diagnostics = Diagnostics()
    same = with_border_heights(problem, borders_of(problem, areas), none, None, diagnostics)
    assert same is problem
    assert [item.message for item in diagnostics] == ["no elevation model reaches the border with b"]


def test_some_roads_make_the_problem_that_they_would_make_alone() -> None:
    roads = [
        straight((0.0, 0.0), (100.0, 0.0), end=0, highway="primary", grade=0.01, name=3),
        straight((500.0, 0.0), (600.0, 0.0)),
        straight((110.0, 0.0), (200.0, 0.0), start=0, end_link=6, spans=((0.0, 0, 0), (20.0, 1, 1))),
        straight((200.0, 0.0), (300.0, 0.0), start_link=5, end=1),
    ]
    problem = make_problem(roads, [(105.0, 0.0), (310.0, 0.0)])
    part = chosen_roads(problem, np.array([0, 2], np.int64))
    alone = make_problem([roads[0], replace(roads[2], end_link=-1)], [(105.0, 0.0)])
    for name in ("end_junction", "end_link", "junction_xy", "span_start", "span_s", "span_structure", "span_layer"):
        np.testing.assert_array_equal(getattr(part, name), getattr(alone, name))
    assert part.span_highway == alone.span_highway
    assert part.span_way.tolist() == [100, 102, 103]
    for name in ("start", "s", "x", "y", "hdg", "length", "curvature"):
        np.testing.assert_array_equal(getattr(part.plan_view, name), getattr(alone.plan_view, name))
