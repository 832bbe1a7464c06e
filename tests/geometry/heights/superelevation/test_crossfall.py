"""Crossfall that fast roads are designed with."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from elevation_helpers import Ground, RoadSpec, Solved, make_problem, solve, straight

from osm2xodr.curves.cubics import cubic_slope, cubic_value
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.heights import Pins, solve_profiles
from osm2xodr.geometry.options import ElevationOptions
from osm2xodr.model import FloatArray, Rule

FLAT = Ground(lambda x, y: np.zeros(len(x)))
COARSE = Ground(lambda x, y: 0.01 * x + 0.04 * y, cell_size=30.0, sigma=1.0)
# 600 m; neither end lies at a junction.
AHEAD = straight((0.0, 0.0), (600.0, 0.0), highway="motorway", oneway=1)
S = np.linspace(0.0, 600.0, 61)


def left_rise(found: Solved, s: FloatArray = S, road: int = 0) -> FloatArray:
    """Return the rise per metre to the left."""
    profile = found.solution.superelevation
    assert profile is not None
    return np.tan(cubic_value(profile, np.full(len(s), road), s))


def solved(road: RoadSpec, ground: Ground = FLAT, **more: Any) -> Solved:
    """Solve for one road, of a problem with further attributes."""
    problem = replace(make_problem([road]), **more)
    diagnostics = Diagnostics()
    return Solved(problem, solve_profiles(problem, ground, diagnostics, ElevationOptions()), diagnostics)


@pytest.mark.parametrize("ground", [FLAT, COARSE])
@pytest.mark.parametrize(
    ("oneway", "rule", "expected"),
    [(1, Rule.RIGHT_HAND, 0.025), (-1, Rule.RIGHT_HAND, -0.025), (1, Rule.LEFT_HAND, -0.025)],
)
def test_straight_carriageways_fall_to_the_side_of_slow_traffic(
    ground: Ground, oneway: int, rule: Rule, expected: float
) -> None:
    found = solved(replace(AHEAD, oneway=oneway), ground, rule=rule)
    assert left_rise(found) == pytest.approx(np.full(61, expected), abs=1e-5)
    assert [item.osm_id for item in found.diagnostics if item.code == "crossfall"] == ["way/100"]


@pytest.mark.parametrize(
    ("radius", "speed", "expected"),
    [
        # Falls outwards still: 130 km/h asks 0.0222 of the tyres at 6000 m.
        (6000.0, np.inf, 0.025),
        # 0.0333 at 4000 m; 0.06 / 4 at the least radius of 949 m times 4.2 would be less than the least crossfall.
        (3900.0, np.inf, -0.025),
        (2000.0, np.inf, -0.06 * 949.4 / 2000.0),
        (900.0, np.inf, -0.06),
        # At 100 km/h: friction 0.12, least radius 437 m.
        (900.0, 100 / 3.6, -0.06 * 436.97 / 900.0),
        (-2000.0, np.inf, 0.06 * 949.4 / 2000.0),
    ],
)
def test_bends_fall_to_the_inside_as_speed_and_radius_call_for(radius: float, speed: float, expected: float) -> None:
    found = solved(replace(AHEAD, curvature=1.0 / radius), span_speed=np.array([speed]))
    assert left_rise(found) == pytest.approx(np.full(61, expected), abs=2e-5)


def test_limits_above_what_ramps_are_built_for_do_not_count() -> None:
    ramp = replace(AHEAD, highway="motorway_link", curvature=1 / 300.0)
    # 80 km/h: friction 0.14, least radius 251.7 m.
    for speed in (np.nan, 130 / 3.6):
        found = solved(ramp, span_speed=np.array([speed]))
        assert left_rise(found) == pytest.approx(np.full(61, -0.06 * 251.69 / 300.0), abs=2e-5)


def test_roads_of_both_directions_are_crowned_but_for_bends() -> None:
    trunk = replace(AHEAD, highway="trunk", oneway=0)
    assert left_rise(solved(trunk)) == pytest.approx(np.zeros(61))
    bend = left_rise(solved(replace(trunk, curvature=1 / 800.0)))
    assert bend == pytest.approx(np.full(61, -0.06 * 436.97 / 800.0), abs=2e-5)


def test_streets_stay_level() -> None:
    found = solved(replace(AHEAD, highway="primary"))
    assert left_rise(found) == pytest.approx(np.zeros(61))
    assert "crossfall" not in found.codes()


@pytest.mark.parametrize(("length", "banked"), [(210.0, True), (190.0, False)])
def test_it_runs_off_before_junctions_where_there_is_room(length: float, banked: bool) -> None:
    roads = [straight((0.0, 0.0), (length, 0.0), highway="motorway", oneway=1, start=0, end=1)]
    found = solve(roads, FLAT, [(0.0, 0.0), (length, 0.0)], ElevationOptions())
    profile = found.solution.superelevation
    assert profile is not None
    ends, road = np.array([0.0, length]), np.zeros(2, np.int64)
    assert cubic_value(profile, road, ends) == pytest.approx([0.0, 0.0], abs=1e-12)
    assert cubic_slope(profile, road, ends) == pytest.approx([0.0, 0.0], abs=1e-12)
    assert (left_rise(found, np.array([length / 2]))[0] > 0.02) == banked
    s = np.linspace(0.0, length, 200)
    # RAA 2008: edges 7.5 m from the axis rise by 0.9 % at most.
    assert np.abs(cubic_slope(profile, np.zeros(200, np.int64), s)).max() <= 0.009 / 7.5


def test_roads_that_continue_one_another_are_one() -> None:
    roads = [
        straight((0.0, 0.0), (150.0, 0.0), highway="motorway", oneway=1, end_link=2),
        straight((150.0, 0.0), (300.0, 0.0), highway="motorway", oneway=1, start_link=1),
    ]
    found = solve(roads, FLAT, options=ElevationOptions())
    for road in (0, 1):
        assert left_rise(found, np.linspace(0.0, 150.0, 16), road) == pytest.approx(np.full(16, 0.025), abs=1e-5)


def test_it_is_level_where_areas_meet() -> None:
    nothing = np.full(1, np.nan)
    pins = Pins(np.zeros(1, np.int64), np.array([301.0]), nothing, nothing)
    found = solved(AHEAD, COARSE, pins=pins)
    assert left_rise(found, np.array([301.0])) == pytest.approx([0.0], abs=1e-12)
    assert left_rise(found, np.array([150.0, 450.0])) == pytest.approx([0.025, 0.025], abs=1e-3)


def test_corners_of_the_line_are_smoothed_away() -> None:
    """Arcs of 10 m at every 80 m of a bend of 2000 m count as the bend."""
    n = 8
    curvature = np.zeros(2 * n)
    curvature[1::2] = 80.0 / 2000.0 / 10.0
    length = np.tile([70.0, 10.0], n)
    hdg = np.concatenate([[0.0], np.cumsum(curvature * length)[:-1]])
    chord = length * np.sinc(curvature * length / 2 / np.pi)
    middle = hdg + curvature * length / 2
    x, y = (np.concatenate([[0.0], np.cumsum(chord * f(middle))[:-1]]) for f in (np.cos, np.sin))
    problem = make_problem([replace(AHEAD, length=float(length.sum()))])
    start = np.array([0, 2 * n], np.int64)
    s = np.concatenate([[0.0], np.cumsum(length)[:-1]])
    plan = replace(problem.plan_view, start=start, s=s, x=x, y=y, hdg=hdg, length=length, curvature=curvature)
    problem = replace(problem, plan_view=plan)
    found = Solved(problem, solve_profiles(problem, FLAT, Diagnostics(), ElevationOptions()))
    inside = np.linspace(100.0, 540.0, 45)
    assert left_rise(found, inside) == pytest.approx(np.full(45, -0.06 * 949.4 / 2000.0), abs=0.003)


def parted(carried: bool, ground: Ground) -> Solved:
    """Solve for a motorway that goes on behind a junction, and a ramp that leaves it there 5 m to its right."""
    roads = [
        straight((-600.0, 0.0), (0.0, 0.0), highway="motorway", oneway=1, end=0),
        straight((30.0, 0.0), (600.0, 0.0), highway="motorway", oneway=1, start=0),
        # It is driven against its line.
        straight((400.0, -45.0), (30.0, -5.0), highway="motorway_link", oneway=-1, end=0),
    ]
    problem = replace(make_problem(roads, [(0.0, 0.0)]), carried=np.array([carried]))
    diagnostics = Diagnostics()
    return Solved(problem, solve_profiles(problem, ground, diagnostics, ElevationOptions()), diagnostics)


@pytest.mark.parametrize("ground", [FLAT, COARSE])
def test_it_runs_through_where_carriageways_part(ground: Ground) -> None:
    """All arms have it, seen along their traffic, and the plane through their lines falls as they do."""
    found = parted(True, ground)
    across = found.solution.end_superelevation
    assert across is not None
    assert np.tan([across[0, 1], across[1, 0], -across[2, 1]]) == pytest.approx(np.full(3, 0.025), abs=2e-4)
    assert left_rise(found, np.array([600.0]))[0] == pytest.approx(0.025, abs=2e-4)
    assert found.solution.junction_plane[0, 2] == pytest.approx(0.025, abs=0.002)
    # The ramp's line begins on the carriageway's surface, 5 m aside.
    z = found.solution.end_z
    assert z[1, 0] - z[2, 1] == pytest.approx(5 * 0.025, abs=0.01)


@pytest.mark.parametrize("ground", [FLAT, COARSE])
def test_it_ends_before_other_junctions(ground: Ground) -> None:
    across = parted(False, ground).solution.end_superelevation
    assert across is not None
    assert across[[0, 1, 2], [1, 0, 1]].tolist() == [0.0, 0.0, 0.0]


def test_short_ramps_between_junctions_need_no_room() -> None:
    """A ramp of 150 m has room to run off at one end, but not at both."""
    for level_ends, wanted in ((0, 0.025), (1, 0.025), (2, 0.0)):
        road = straight((0.0, 0.0), (150.0, 0.0), highway="motorway_link", oneway=1, start=0, end=1)
        carried = np.array([level_ends < 2, level_ends < 1])
        problem = replace(make_problem([road], [(0.0, 0.0), (150.0, 0.0)]), carried=carried)
        found = Solved(problem, solve_profiles(problem, FLAT, Diagnostics(), ElevationOptions()))
        assert left_rise(found, np.array([20.0]))[0] == pytest.approx(wanted, abs=0.002)
