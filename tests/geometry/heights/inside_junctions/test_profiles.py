"""Heights of connecting roads: equal to the roads' at their ends, to each other's where they cross."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from elevation_helpers import Ground, RoadSpec, Solved, cross, make_problem, plan_view, solve, straight
from hypothesis import given, settings, strategies as st
from scipy.spatial import cKDTree

from osm2xodr.curves.cubics import cubic_slope, cubic_value
from osm2xodr.curves.plan_views import lengths
from osm2xodr.curves.records import pose
from osm2xodr.geometry.connections.pose_to_pose import connect as curves_between
from osm2xodr.geometry.heights import ConnectorProblem, ProfileProblem, connector_profiles
from osm2xodr.geometry.heights.elements import end_poses
from osm2xodr.geometry.heights.inside_junctions.profiles import _blend, _grade_along_lane, _limit_twist, _sample
from osm2xodr.geometry.heights.inside_junctions.surface import junction_surfaces, surface_heights
from osm2xodr.model import CubicProfile, FloatArray

TILTED = Ground(lambda x, y: 200.0 + 0.1 * x + 0.06 * y)


@dataclass
class Connected:
    """Connecting roads and their heights."""

    connectors: ConnectorProblem
    elevation: CubicProfile
    superelevation: CubicProfile

    def at(self, connector: int, s: FloatArray) -> FloatArray:
        return cubic_value(self.elevation, np.full(len(s), connector), s)

    def slope(self, connector: int, s: FloatArray) -> FloatArray:
        return cubic_slope(self.elevation, np.full(len(s), connector), s)


def connect(found: Solved, ways: list[tuple[int, int, float, float, RoadSpec]]) -> Connected:
    """Return connecting roads (road end left, road end reached, t at both, curve)."""
    connectors = asked(found.problem, ways)
    return Connected(connectors, *connector_profiles(found.problem, connectors, found.solution))


def asked(problem: ProfileProblem, ways: list[tuple[int, int, float, float, RoadSpec]]) -> ConnectorProblem:
    start, end = np.array([w[0] for w in ways], np.int64), np.array([w[1] for w in ways], np.int64)
    return ConnectorProblem(
        plan_view=plan_view([w[4] for w in ways]),
        junction=problem.end_junction.ravel()[start],
        start_end=start,
        end_end=end,
        start_t=np.array([w[2] for w in ways], np.float64),
        end_t=np.array([w[3] for w in ways], np.float64),
        half_width=np.full(len(ways), 1.6),
    )


def point_beside(problem: ProfileProblem, end: int, t: float) -> FloatArray:
    x, y, hdg = (value[end] for value in end_poses(problem))
    return np.array([x - t * np.sin(hdg), y + t * np.cos(hdg)])


def lane_point(found: Solved, end: int, t: float) -> FloatArray:
    return point_beside(found.problem, end, t)


def line(found: Solved, a: int, b: int, ta: float, tb: float) -> tuple[int, int, float, float, RoadSpec]:
    return line_of(found.problem, a, b, ta, tb)


def line_of(problem: ProfileProblem, a: int, b: int, ta: float, tb: float) -> tuple[int, int, float, float, RoadSpec]:
    p, q = point_beside(problem, a, ta), point_beside(problem, b, tb)
    return a, b, ta, tb, straight((p[0], p[1]), (q[0], q[1]))


# Ends at the junction in `cross`: roads 0 and 1 end there, roads 2 and 3 start there.
ENDS = [1, 3, 4, 6]


def crossing() -> tuple[Solved, Connected]:
    found = solve(cross(trim=10.0), TILTED, [(0.0, 0.0)], connectors=through(ENDS))
    ways = [line(found, 1, 4, t, t) for t in (-1.75, 1.75)] + [line(found, 3, 6, t, t) for t in (-1.75, 1.75)]
    return found, connect(found, ways)


def test_ends_are_those_of_the_roads() -> None:
    found, made = crossing()
    z, g = found.solution.end_z.ravel(), found.solution.end_grade.ravel()
    length = lengths(made.connectors.plan_view)
    every = np.arange(4)
    assert cubic_value(made.elevation, every, np.zeros(4)) == pytest.approx(z[made.connectors.start_end], abs=1e-9)
    assert cubic_value(made.elevation, every, length) == pytest.approx(z[made.connectors.end_end], abs=1e-9)
    assert cubic_slope(made.elevation, every, np.zeros(4)) == pytest.approx(g[made.connectors.start_end], abs=1e-9)
    assert cubic_slope(made.elevation, every, length) == pytest.approx(g[made.connectors.end_end], abs=1e-9)


def test_crossing_roads_have_one_height_where_they_cross() -> None:
    _, made = crossing()
    for a, ta in ((0, -1.75), (1, 1.75)):
        for b, tb in ((2, -1.75), (3, 1.75)):
            # Along the first the second's offset lies at 10 + tb' from its start, turned by a right angle.
            za = made.at(a, np.array([10.0 - tb]))
            zb = made.at(b, np.array([10.0 + ta]))
            assert za == pytest.approx(zb, abs=0.012)


def test_cross_slope_is_level_at_the_ends_and_that_of_the_ground_between() -> None:
    _, made = crossing()
    length = lengths(made.connectors.plan_view)
    s = made.superelevation
    every = np.arange(4)
    assert cubic_value(s, every, np.zeros(4)) == pytest.approx(np.zeros(4), abs=1e-12)
    assert cubic_value(s, every, length) == pytest.approx(np.zeros(4), abs=1e-12)
    assert cubic_slope(s, every, length) == pytest.approx(np.zeros(4), abs=1e-12)
    hdg = made.connectors.plan_view.hdg
    across = -np.sin(hdg) * 0.1 + np.cos(hdg) * 0.06
    middle = np.tan(cubic_value(s, every, 0.5 * length))
    # Half-way the arms that they cross and their own, which are level across, have their say.
    assert (middle / across > 0.2).all()
    assert (middle / across < 1.0).all()


def test_level_junction_needs_no_superelevation() -> None:
    found = solve(cross(), Ground(lambda x, y: np.zeros(len(x)) + 7.0), [(0.0, 0.0)])
    made = connect(found, [line(found, 1, 4, -1.75, -1.75)])
    assert made.elevation.a.tolist() == [7.0]
    assert made.superelevation.start.tolist() == [0, 0]


def test_u_turn_stays_level_across() -> None:
    found = solve(cross(trim=10.0), TILTED, [(0.0, 0.0)])
    hdg = end_poses(found.problem)[2][1]
    p = lane_point(found, 1, -1.75)
    turn = RoadSpec(p[0], p[1], float(hdg), np.pi * 1.75, curvature=1 / 1.75)
    made = connect(found, [(1, 1, -1.75, 1.75, turn)])
    s = np.linspace(0.0, np.pi * 1.75, 50)
    g = float(found.solution.end_grade.ravel()[1])
    assert made.slope(0, s[[0, -1]]) == pytest.approx([g, -g], abs=1e-9)
    assert np.abs(made.slope(0, s)).max() < 0.2
    assert made.at(0, s[-1:]) == pytest.approx(made.at(0, s[:1]), abs=1e-9)


@pytest.mark.parametrize("gap", [0.1, 0.5, 2.0])
def test_very_short_connecting_roads_do_not_overshoot(gap: float) -> None:
    roads = [
        straight((-200.0, 0.0), (0.0, 0.0), end=0),
        straight((gap, 0.0), (200.0, 30.0), start=0),
        straight((gap, -0.5), (200.0, -120.0), start=0),
    ]
    ground = Ground(lambda x, y: 0.25 * y + 0.1 * x)
    lines = [(1, 2, 0.0, 0.0), (1, 4, 0.0, 0.0)]
    found = solve(roads, ground, [(0.0, 0.0)], connectors=lambda p: asked(p, [line_of(p, *way) for way in lines]))
    made = connect(found, [line(found, *way) for way in lines])
    for k, length in enumerate(lengths(made.connectors.plan_view)):
        s = np.linspace(0.0, float(length), 30)
        z = made.at(k, s)
        assert np.abs(made.slope(k, s)).max() < 0.35
        low, high = min(z[0], z[-1]), max(z[0], z[-1])
        assert z.min() > low - 0.05
        assert z.max() < high + 0.05


def steps(made: Connected) -> FloatArray:
    """Return by how much connecting roads disagree in height where their lanes lie over each other, m.

    Places up to 5 cm apart count as one; half of a metre from end to end is looked at.
    """
    plan = made.connectors.plan_view
    long = lengths(plan)
    count = np.ceil(long / 0.5).astype(np.int64) + 1
    road = np.repeat(np.arange(len(long)), 5 * count)
    s = np.concatenate([np.repeat(np.linspace(0.0, run, n), 5) for run, n in zip(long.tolist(), count, strict=True)])
    t = np.tile(np.linspace(-1.6, 1.6, 5), int(count.sum()))
    x, y, hdg = pose(plan, road, s)
    bank = np.zeros(len(s))
    tilted = np.diff(made.superelevation.start)[road] > 0
    bank[tilted] = cubic_value(made.superelevation, road[tilted], s[tilted])
    z = cubic_value(made.elevation, road, s) + t * np.sin(bank)
    across = t * np.cos(bank)
    place = np.column_stack([x - np.sin(hdg) * across, y + np.cos(hdg) * across])
    a, b = cKDTree(place).query_pairs(0.05, output_type="ndarray").T
    apart = road[a] != road[b]
    return np.asarray(np.abs(z[a] - z[b])[apart])


def ways_between(problem: ProfileProblem, ends: list[int], t: float) -> ConnectorProblem:
    """Return curved connecting roads from each end to all others; all keep t to the right of the arms' middle."""
    pairs = np.array([(p, q) for p in ends for q in ends if p != q], np.int64).T
    hdg = end_poses(problem)[2]
    leave, reach = pairs % 2 == np.array([[1], [0]])
    side = np.where(leave, -t, t), np.where(reach, -t, t)
    (x0, y0), (x1, y1) = (
        np.array([point_beside(problem, end, at) for end, at in zip(row.tolist(), t_row.tolist(), strict=True)]).T
        for row, t_row in zip(pairs, side, strict=True)
    )
    turned = hdg[pairs[0]] + np.where(leave, 0.0, np.pi), hdg[pairs[1]] + np.where(reach, 0.0, np.pi)
    return ConnectorProblem(
        plan_view=curves_between(x0, y0, turned[0], x1, y1, turned[1]),
        junction=np.zeros(pairs.shape[1], np.int64),
        start_end=pairs[0],
        end_end=pairs[1],
        start_t=side[0],
        end_t=side[1],
        half_width=np.full(pairs.shape[1], 1.6),
    )


def through(ends: list[int]) -> Callable[[ProfileProblem], ConnectorProblem]:
    """Return what asks for all connecting roads between ends."""
    return lambda problem: ways_between(problem, ends, 1.6)


def all_ways(found: Solved, ends: list[int], t: float) -> Connected:
    """Return these connecting roads and their heights."""
    connectors = ways_between(found.problem, ends, t)
    return Connected(connectors, *connector_profiles(found.problem, connectors, found.solution))


@pytest.mark.parametrize("angle", [0.0, 0.4, 0.8])
@pytest.mark.parametrize("slope", [(0.12, 0.09), (0.16, 0.11)])
def test_connecting_roads_of_a_steep_junction_agree(angle: float, slope: tuple[float, float]) -> None:
    # 15 and 19 % in all: the arms that run along the slope are steep, the others level.
    ground = Ground(lambda x, y: slope[0] * x + slope[1] * y)
    found = solve(cross(trim=9.0, angle=angle), ground, [(0.0, 0.0)], connectors=through(ENDS), warped=True)
    # At 20 km/h none has to leave the surface because it bends too sharply.
    found.problem = replace(found.problem, span_speed=np.full(4, 20.0 / 3.6))
    apart = steps(all_ways(found, ENDS, 1.6))
    assert len(apart) > 250
    assert apart.max() < 0.03
    assert np.percentile(apart, 95) < 0.022


# Level arms follow the ground of precise models apart, and the ways between them have to make up for it.
@pytest.mark.parametrize(("warped", "most"), [(False, 0.13), (True, 0.085)])
@pytest.mark.parametrize(("half_gap", "steepest"), [(3.4, 0.11), (3.8, 0.18), (4.5, 0.18)])
@pytest.mark.parametrize("rise", [0.08, 0.12, 0.15])
def test_connecting_roads_agree_where_carriageways_part_on_a_slope(
    half_gap: float, most: float, steepest: float, rise: float, warped: bool
) -> None:
    # The carriageways leave side by side, 6 m wide, one above the other on the slope.
    roads = [
        straight((-150.0, 0.0), (-12.0, 0.0), end=0),
        straight((10.0, half_gap), (150.0, half_gap), start=0),
        straight((10.0, -half_gap), (150.0, -half_gap - 20.0), start=0),
    ]
    ground = Ground(lambda x, y: 0.02 * x + rise * y)
    found = solve(roads, ground, [(0.0, 0.0)], connectors=through([1, 2, 4]), warped=warped)
    made = all_ways(found, [1, 2, 4], 1.6)
    assert steps(made).max() < most
    long = lengths(made.connectors.plan_view)
    every = np.arange(len(long))
    grade = [cubic_slope(made.elevation, every, share * long) for share in np.linspace(0.0, 1.0, 41)]
    assert np.abs(grade).max() < steepest


def test_grade_of_a_connecting_road_is_the_slope_of_the_surface_along_it() -> None:
    found = solve(cross(trim=9.0, angle=0.4), TILTED, [(0.0, 0.0)], connectors=through(ENDS))
    found.problem = replace(found.problem, span_speed=np.full(4, 20.0 / 3.6))
    made = all_ways(found, ENDS, 1.6)
    surfaces = junction_surfaces(found.problem, made.connectors, found.solution)
    along = _sample(made.connectors)
    x, y, hdg = pose(made.connectors.plan_view, along.curve, along.s)
    z, gx, gy = surface_heights(surfaces, np.zeros(len(x), np.int64), x, y)
    # What is left at the ends is no part of the surface.
    first, last = along.start[:-1], along.start[1:] - 1
    grade = gx * np.cos(hdg) + gy * np.sin(hdg)
    z0, z1 = (cubic_value(made.elevation, along.curve[k], along.s[k]) - z[k] for k in (first, last))
    g0, g1 = (cubic_slope(made.elevation, along.curve[k], along.s[k]) - grade[k] for k in (first, last))
    dz, dg = along.blend(np.minimum(along.length, 12.0), (z0, g0, z1, g1))
    assert cubic_slope(made.elevation, along.curve, along.s) == pytest.approx(grade + dg, abs=0.00201)
    assert cubic_value(made.elevation, along.curve, along.s) == pytest.approx(z + dz, abs=0.01201)


def test_grade_does_not_swing_between_ramps_that_come_together() -> None:
    # A ramp beside a motorway, on a slope across both: all lanes go down evenly by 3.6 %.
    roads = [
        straight((-300.0, 0.0), (-5.0, 0.0), end=0, highway="motorway"),
        straight((-300.0, -8.0), (-8.0, -8.0), end=0, highway="motorway_link"),
        straight((45.0, 0.0), (300.0, 0.0), start=0, highway="motorway"),
    ]
    ground = Ground(lambda x, y: 50.0 - 0.036 * x + 0.07 * y)
    lines = [(1, 4, 1.75, 1.75), (3, 4, 0.0, -1.75)]
    found = solve(roads, ground, [(0.0, 0.0)], connectors=lambda p: asked(p, [line_of(p, *way) for way in lines]))
    made = connect(found, [line(found, *way) for way in lines])
    for k, length in enumerate(lengths(made.connectors.plan_view).tolist()):
        s = np.linspace(0.0, length, 200)
        grade = made.slope(k, s)
        assert grade == pytest.approx(np.full(200, -0.036), abs=0.008)
        # At 100 km/h a change of 0.1 % per metre is 0.8 m/s².
        assert np.abs(np.diff(grade)).max() / (s[1] - s[0]) < 0.0025


@pytest.mark.parametrize(("highway", "most"), [("residential", 0.0205), ("motorway", 0.0095)])
def test_twist_stays_within_what_cars_follow(highway: str, most: float) -> None:
    roads = [replace(road, highway=highway) for road in cross(trim=7.0)]
    ground = Ground(lambda x, y: 0.14 * x + 0.1 * y, cell_size=1.0, sigma=0.05)
    found = solve(roads, ground, [(0.0, 0.0)], connectors=through(ENDS))
    made = all_ways(found, ENDS, 1.6)
    tilted = np.flatnonzero(np.diff(made.superelevation.start))
    assert len(tilted) >= 4
    for k in tilted.tolist():
        s = np.linspace(0.0, float(lengths(made.connectors.plan_view)[k]), 100)
        assert np.abs(cubic_slope(made.superelevation, np.full(100, k), s)).max() < most


def test_grade_goes_on_along_the_lane_where_a_road_ends_in_a_bend() -> None:
    # A bend to the left of 50 m: a lane 2 m inside of it is 4 % shorter, one 2 m outside 4 % longer.
    bend = RoadSpec(0.0, 0.0, 0.0, 60.0, curvature=0.02, end=0)
    x, y, hdg = (float(value[0]) for value in pose(plan_view([bend]), np.array([0]), np.array([60.0])))
    way = x + 20.0 * np.cos(hdg), y + 20.0 * np.sin(hdg)
    roads = [bend, straight(way, (way[0] + 100.0 * np.cos(hdg), way[1] + 100.0 * np.sin(hdg)), start=0)]
    slope = Ground(lambda x, y: 0.08 * np.hypot(x, y))
    found = solve(roads, slope, [(float(np.mean([x, way[0]])), float(np.mean([y, way[1]])))])
    made = connect(found, [line(found, 1, 2, t, t) for t in (2.0, -2.0)])
    g = float(found.solution.end_grade[0, 1])
    assert g > 0.05
    start = [float(made.slope(k, np.zeros(1))[0]) for k in (0, 1)]
    assert start == pytest.approx([g / 0.96, g / 1.04], abs=1e-6)
    # The road beyond is straight.
    assert made.slope(0, lengths(made.connectors.plan_view)[:1]) == pytest.approx([found.solution.end_grade[1, 0]])


def test_grade_does_not_leave_that_of_the_reference_line_by_much() -> None:
    bend = replace(straight((0.0, 0.0), (1.0, 0.0), end=0), length=60.0, curvature=0.1)
    problem = make_problem([bend], [(0.0, 0.0)])
    grade = _grade_along_lane(problem, np.array([1, 1, 0]), np.array([4.0, -4.0, 0.0]), np.array([0.1, 0.1, 0.2]))
    assert grade == pytest.approx([0.1045, 0.0955, 0.2])


@pytest.mark.parametrize("t", [0.0, -1.75, 3.5])
def test_lines_beside_those_of_tilted_arms_begin_on_their_surface(t: float) -> None:
    """Superelevation raises what lies left of the line by t sin χ."""
    found = solve(cross(trim=10.0), TILTED, [(0.0, 0.0)])
    across = np.zeros((4, 2))
    across[0, 1], across[2, 0] = 0.03, 0.05
    found = replace(found, solution=replace(found.solution, end_superelevation=across))
    made = connect(found, [line(found, 1, 4, t, t)])
    z, length = found.solution.end_z.ravel(), float(lengths(made.connectors.plan_view)[0])
    begin, end = made.at(0, np.array([0.0, length]))
    assert begin == pytest.approx(z[1] + t * np.sin(0.03), abs=1e-9)
    assert end == pytest.approx(z[4] + t * np.sin(0.05), abs=1e-9)


def test_superelevation_is_held_between_ramps() -> None:
    roads = cross(trim=10.0)
    found = solve(roads, TILTED, [(0.0, 0.0)])
    along = _sample(connect(found, [line(found, 1, 4, 0.0, 0.0)]).connectors)
    s, length = along.s, float(along.length[0])
    step = np.where(np.abs(s - 0.5 * length) < 2.6, 0.2, 0.0)
    held = _limit_twist(along, step, np.array([0.01]), np.zeros((2, 1)))
    assert np.abs(np.diff(held) / np.diff(s)).max() <= 0.01 + 1e-12
    assert held[[0, -1]].tolist() == [0.0, 0.0]
    assert held.max() == pytest.approx(0.1, abs=0.02)
    gentle = 0.004 * np.minimum(s, length - s)
    assert _limit_twist(along, gentle, np.array([0.01]), np.zeros((2, 1))) == pytest.approx(gentle, abs=1e-12)
    assert _limit_twist(along, -gentle, np.array([0.01]), np.zeros((2, 1))) == pytest.approx(-gentle, abs=1e-12)


def test_what_is_left_at_an_end_does_not_reach_far() -> None:
    s, run, reach = np.linspace(0.0, 40.0, 401), np.full(401, 40.0), np.full(401, 8.0)
    value, slope = _blend(s, run, reach, tuple(np.full(401, v) for v in (0.1, -0.05, 0.2, 0.04)))
    assert value[[0, -1]].tolist() == pytest.approx([0.1, 0.2])
    assert slope[[0, -1]].tolist() == pytest.approx([-0.05, 0.04])
    assert value[(s >= 8.0) & (s <= 32.0)].tolist() == [0.0] * 241
    assert slope == pytest.approx(np.gradient(value, s), abs=2e-3)
    # Over the whole length it is the one cubic of these values and slopes.
    value, _ = _blend(s, run, run, tuple(np.full(401, v) for v in (0.1, -0.05, 0.2, 0.04)))
    cubic = np.polyfit(s, value, 3)
    assert np.polyval(cubic, s) == pytest.approx(value, abs=1e-9)
    assert np.polyval(np.polyder(cubic), [0.0, 40.0]) == pytest.approx([-0.05, 0.04], abs=1e-9)


def test_no_connecting_roads() -> None:
    found = solve(cross(), TILTED, [(0.0, 0.0)])
    made = connect(found, [])
    assert made.elevation.start.tolist() == [0]
    assert made.superelevation.start.tolist() == [0]


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.floats(-0.15, 0.15), st.floats(-0.15, 0.15), st.floats(0.0, 1.5), st.floats(6.0, 15.0))
def test_all_ways_through_a_crossing_join_without_a_kink(a: float, b: float, angle: float, trim: float) -> None:
    found = solve(cross(trim=trim, angle=angle), Ground(lambda x, y: a * x + b * y), [(0.0, 0.0)])
    ways = [
        line(found, p, q, -1.7 if p % 2 else 1.7, -1.7 if q % 2 == 0 else 1.7) for p in ENDS for q in ENDS if p != q
    ]
    made = connect(found, ways)
    z, g = found.solution.end_z.ravel(), found.solution.end_grade.ravel()
    for k, (p, q, _, _, _) in enumerate(ways):
        ends = np.array([0.0, float(lengths(made.connectors.plan_view)[k])])
        assert made.at(k, ends) == pytest.approx([z[p], z[q]], abs=1e-9)
        leave, reach = g[p] if p % 2 else -g[p], g[q] if q % 2 == 0 else -g[q]
        assert made.slope(k, ends) == pytest.approx([leave, reach], abs=1e-9)
        assert np.abs(made.slope(k, np.linspace(ends[0], ends[1], 60))).max() < 0.35


def test_a_level_world_needs_no_surface() -> None:
    """What is skipped there gives the same as the surface would."""
    found = solve(cross(trim=9.0), Ground(lambda x, y: np.zeros(len(x)) + 7.0), [(0.0, 0.0)])
    made = all_ways(found, ENDS, 1.6)
    count = len(made.connectors.junction)
    assert made.elevation.start.tolist() == list(range(count + 1))
    assert made.elevation.a.tolist() == [7.0] * count
    assert not np.any([made.elevation.s, made.elevation.b, made.elevation.c, made.elevation.d])
    assert made.superelevation.start.tolist() == [0] * (count + 1)
