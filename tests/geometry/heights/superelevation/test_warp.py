"""Arms of junctions that are warped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import Ground, RoadSpec, make_problem, straight

from osm2xodr.curves.cubics import cubic_slope, cubic_value
from osm2xodr.geometry.heights import ProfileProblem, sloping_junctions
from osm2xodr.geometry.heights.superelevation import warp_ends, warp_profiles
from osm2xodr.geometry.heights.superelevation.warp import longest_warp
from osm2xodr.model import CubicProfile, FloatArray

# The largest twist, rad/m, and the vertical acceleration of the outer lane, m/s², at 50 km/h and 3 m from the middle.
TWIST, ACCELERATION = 0.015, 0.5
SPEED, HALF = 50.0 / 3.6, 3.0


def streets(*roads: RoadSpec, junctions: int = 2) -> ProfileProblem:
    places = [(0.0, 0.0), (500.0, 0.0)][:junctions]
    return replace(make_problem(roads, places), warped=np.ones(junctions, bool))


def profile(ends: list[tuple[float, float]], lengths: list[float]) -> CubicProfile | None:
    roads = [straight((0.0, 9.0 * k), (length, 9.0 * k), start=0, end=1) for k, length in enumerate(lengths)]
    return warp_profiles(streets(*roads), np.array(ends))


def values(found: CubicProfile | None, road: int, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return value, slope and curvature of a profile."""
    assert found is not None
    at = np.full(len(s), road)
    slope = cubic_slope(found, at, s)
    return cubic_value(found, at, s), slope, np.gradient(slope, s)


@pytest.mark.parametrize(("slope", "sloping"), [(0.029, False), (0.031, True), (-0.2, True)])
@pytest.mark.parametrize("hdg", [0.0, 0.8, 2.5])
def test_junctions_are_sloping_where_the_ground_is(slope: float, sloping: bool, hdg: float) -> None:
    problem = make_problem([straight((0.0, 0.0), (90.0, 0.0), start=0)], [(0.0, 0.0), (300.0, 50.0)])
    ground = Ground(lambda x, y: slope * (np.cos(hdg) * x + np.sin(hdg) * y), cell_size=30.0, sigma=2.0)
    assert sloping_junctions(problem, ground).tolist() == [sloping, sloping]


def test_level_worlds_and_networks_without_junctions_have_no_sloping_ones() -> None:
    road = straight((0.0, 0.0), (90.0, 0.0))
    steep = Ground(lambda x, y: 0.2 * x, cell_size=30.0, sigma=2.0)
    assert sloping_junctions(make_problem([road]), steep).tolist() == []
    assert sloping_junctions(make_problem([road], [(0.0, 0.0)]), Ground(steep.height)).tolist() == [False]
    # A bump at a junction is no slope: what lies 40 m to either side counts.
    bump = Ground(lambda x, y: 8.0 * np.exp(-(x**2 + y**2) / 300.0), cell_size=1.0, sigma=0.1)
    assert sloping_junctions(make_problem([road], [(0.0, 0.0)]), bump).tolist() == [False]


@pytest.mark.parametrize("length", [4.0, 20.0, 100.0])
def test_longest_warp_is_bounded_by_twist_and_acceleration(length: float) -> None:
    problem = streets(straight((0.0, 0.0), (length, 0.0), start=0))
    (most,) = longest_warp(problem)
    # A smooth step of height c over L twists by 1.5 c / L and bends by 6 c / L².
    by_twist, by_bend = TWIST * length / 1.5, ACCELERATION / (HALF * SPEED**2) * length**2 / 6.0
    assert most == pytest.approx(min(by_twist, by_bend))
    assert (by_twist < by_bend) == (length > 50.0)


def test_longest_warp_goes_by_the_wider_carriageway_and_its_speed() -> None:
    problem = streets(straight((0.0, 0.0), (20.0, 0.0), start=0))
    (usual,) = longest_warp(problem)
    faster = replace(problem, span_speed=np.array([2.0 * SPEED]))
    wider = replace(problem, span_width=np.array([8.0]), span_middle=np.array([-2.0]))
    assert longest_warp(faster) == pytest.approx([usual / 4.0])
    # 4 m and the middle 2 m to the side.
    assert longest_warp(wider) == pytest.approx([usual / 2.0])


def test_warped_ends_have_the_slope_of_the_plane_across() -> None:
    roads = [
        straight((5.0, 0.0), (300.0, 0.0), start=0),
        straight((0.0, 300.0), (0.0, 5.0), end=0),
        straight((-4.0, -3.0), (-240.0, -180.0), start=0),
        straight((300.0, 300.0), (500.0, 5.0), end=1),
    ]
    problem = replace(streets(*roads), warped=np.array([True, False]))
    ends = warp_ends(problem, np.array([[50.0, 0.12, 0.04], [60.0, 0.2, 0.1]]))
    # To the left of east lies north, of south east; of the third (-0.8, -0.6) the direction (0.6, -0.8).
    assert np.tan(ends[:3].ravel()) == pytest.approx([0.04, 0.0, 0.0, 0.12, 0.6 * 0.12 - 0.8 * 0.04, 0.0], abs=2e-5)
    assert ends[3].tolist() == [0.0, 0.0]
    assert warp_ends(replace(problem, warped=None), np.zeros((2, 3))).tolist() == [[0.0, 0.0]] * 4
    none = replace(problem, warped=np.zeros(2, bool))
    assert warp_ends(none, np.ones((2, 3))).tolist() == [[0.0, 0.0]] * 4


def test_steepest_warp_is_as_steep_as_streets_are() -> None:
    problem = streets(straight((5.0, 0.0), (400.0, 0.0), start=0))
    ends = warp_ends(problem, np.array([[0.0, 0.0, -0.5], [0.0, 0.0, 0.0]]))
    assert np.tan(ends[0]) == pytest.approx([-0.3, 0.0], abs=2e-5)


def test_short_roads_take_as_much_as_can_run_out() -> None:
    one, both = straight((5.0, 0.0), (15.0, 0.0), start=0), straight((5.0, 9.0), (15.0, 9.0), start=0, end=1)
    problem = streets(one, both)
    most = float(longest_warp(problem)[0])
    assert most < 0.1
    ends = np.tan(warp_ends(problem, np.array([[0.0, 0.0, 0.2], [0.0, 0.0, -0.1]])))
    # What is too much is taken from the only warped end, or from both alike.
    assert ends[0] == pytest.approx([most, 0.0], abs=1e-4)
    assert ends[1] == pytest.approx([0.05 + 0.5 * most, 0.05 - 0.5 * most], abs=1e-4)
    # From end to end in one slope there is nothing to run out.
    even = np.tan(warp_ends(problem, np.array([[0.0, 0.0, 0.2], [0.0, 0.0, 0.2]])))
    assert even[1] == pytest.approx([0.2, 0.2], abs=1e-4)


def test_roads_that_are_level_at_both_ends_have_no_warp() -> None:
    assert profile([(0.0, 0.0), (0.0, 0.0)], [100.0, 50.0]) is None
    found = profile([(0.0, 0.0), (0.1, 0.0)], [100.0, 100.0])
    assert found is not None
    assert np.diff(found.start).tolist() == [0, 2]


@pytest.mark.parametrize(
    ("begin", "end", "length"), [(0.2, 0.0, 90.0), (0.0, -0.15, 90.0), (0.2, 0.1, 150.0), (-0.1, 0.25, 160.0)]
)
def test_warp_runs_out_in_smooth_steps(begin: float, end: float, length: float) -> None:
    found = profile([(begin, end)], [length])
    s = np.linspace(0.0, length, 2001)
    value, slope, bend = values(found, 0, s)
    assert value[[0, -1]] == pytest.approx([begin, end], abs=1e-12)
    assert slope[[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-12)
    # It goes to level and stays there.
    assert (np.abs(value) < 1e-12).any()
    assert np.abs(value).max() == pytest.approx(max(abs(begin), abs(end)))
    assert np.abs(np.diff(value)).max() < 1.01 * TWIST * (s[1] - s[0])
    assert np.abs(slope).max() < TWIST + 1e-9
    assert np.abs(bend).max() * HALF * SPEED**2 < ACCELERATION + 1e-6
    # It is as long as it must be: one of the bounds is reached.
    assert max(np.abs(slope).max() / TWIST, np.abs(bend).max() * HALF * SPEED**2 / ACCELERATION) > 0.98


@pytest.mark.parametrize(("begin", "end"), [(0.2, 0.1), (0.2, 0.2), (0.0, 0.2)])
def test_warp_goes_from_end_to_end_where_there_is_no_room_to_run_out(begin: float, end: float) -> None:
    length = 30.0
    value, slope, _ = values(profile([(begin, end)], [length]), 0, np.linspace(0.0, length, 301))
    u = np.linspace(0.0, 1.0, 301)
    assert value == pytest.approx(begin + (end - begin) * u * u * (3.0 - 2.0 * u), abs=1e-12)
    assert slope[[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_what_warp_ends_allow_runs_out_within_the_bounds() -> None:
    """Whatever the plane and the length."""
    for length in (6.0, 15.0, 40.0, 120.0):
        problem = streets(straight((5.0, 0.0), (5.0 + length, 0.0), start=0, end=1))
        for first, last in ((0.3, -0.3), (0.25, 0.0), (0.1, 0.2)):
            ends = warp_ends(problem, np.array([[0.0, 0.0, first], [0.0, 0.0, last]]))
            found = warp_profiles(problem, ends)
            if found is None:
                assert np.abs(ends).max() == 0.0
                continue
            _, slope, bend = values(found, 0, np.linspace(0.0, length, 601))
            assert np.abs(slope).max() < TWIST + 1e-5
            assert np.abs(bend).max() * HALF * SPEED**2 < 1.02 * ACCELERATION
