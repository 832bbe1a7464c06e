"""Which area each piece of road belongs to."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from division_cases import EAST, WEST, borders_of, listed, partition, square
from elevation_helpers import make_problem, straight

from osm2xodr.geometry.tile_edges.defaults import BORDER_PIECE, BORDER_STUB
from osm2xodr.geometry.tile_edges.pieces import find_borders


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
