"""Limits on grades, tilts and clearances."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from elevation_helpers import (
    Ground,
    RoadSpec,
    Solved,
    connector_between,
    cross,
    make_problem,
    plan_view,
    solve,
    straight,
)

from osm2xodr.geometry.heights import ProfileProblem
from osm2xodr.geometry.heights.arm_limits import _arm_pairs, limit_arms
from osm2xodr.geometry.heights.crossings import Crossings
from osm2xodr.geometry.heights.elements import Network, build_elements, build_samples, number_unknowns
from osm2xodr.geometry.heights.limits import (
    limit_clearances,
    limit_curvatures,
    limit_cut_and_fill,
    limit_grades,
    limit_structures,
)
from osm2xodr.geometry.heights.readings import Reading
from osm2xodr.geometry.heights.stiffness import Beams
from osm2xodr.geometry.options import ElevationOptions, parse_grade_limits
from osm2xodr.model import FloatArray, PlanView


def network_of(roads: list[RoadSpec], junctions: list[tuple[float, float]], spacing: float = 25.0) -> Network:
    """Return roads cut into elements of at most 25 m with samples this far apart, m."""
    return network_of_problem(make_problem(roads, junctions), spacing)


def network_of_problem(problem: ProfileProblem, spacing: float = 25.0) -> Network:
    elements = build_elements(problem, 25.0)
    samples = build_samples(problem, elements, np.full(len(problem.end_junction), spacing))
    return Network(problem, elements, samples, number_unknowns(problem, elements))


def beams_of(network: Network) -> Beams:
    elements = len(network.elements.h)
    return Beams(np.full(elements, 5e-5), np.full(elements, 0.05))


def on_ground(network: Network, slope: float = 0.0) -> Reading:
    """Return bare ground that rises along the roads of a network."""
    one, none = np.ones(len(network.samples.s)), np.zeros(len(network.samples.s))
    z = slope * network.samples.s
    return Reading(z, z, one, one, one, one > 0, none > 0, np.nan * one, none, none)


# Stiffness of these beams against being turned and lifted.
TURN = np.sqrt(2.0) * (0.05 / 5e-5**3) ** 0.25
LIFT = 2.0 * np.sqrt(2.0) * (0.05**3 / 5e-5) ** 0.25
# Stiffness of the arms of junctions on such ground against being turned, and the moment of ground that is off by 1 m.
ARM_TURN = np.sqrt(2.0) * (0.05 / 5e-5**3) ** 0.25
MOMENT = np.sqrt(2.0 * 0.05 / 5e-5)


def one_crossing(lower: int = 1, lower_s: float = 50.0) -> Crossings:
    """Return where road 0 passes over another curve."""
    zero, at = np.zeros(1, np.int64), np.array([50.0])
    return Crossings(zero, at, zero + lower, np.array([lower_s]), np.array([5.2]), zero, np.zeros((1, 2)))


def test_grades_are_limited_by_class_at_quarters_and_firmly_all_along() -> None:
    network = network_of([straight((0.0, 0.0), (50.0, 0.0))], [])
    known = np.array([False, True])
    by_class, firm = limit_grades(network, on_ground(network), np.full(2, 0.15), known, beams_of(network))
    assert by_class.high.tolist() == (-by_class.low).tolist() == [1.25 * 0.15] * 4
    assert by_class.stiffness == pytest.approx(np.full(4, 60.0 * TURN))
    # Two forces along 25 m of road whose ground is off by 10 m, or by 50 m where the user knows the grade.
    assert by_class.cap == pytest.approx(np.array([10.0, 10.0, 50.0, 50.0]) * LIFT * 25.0 / 2)
    assert firm.high.tolist() == (-firm.low).tolist() == [0.31] * 10
    assert firm.cap == pytest.approx(np.full(10, 50.0 * LIFT * 25.0 / 5))
    assert by_class.own.all()
    assert firm.own.all()


def test_streets_are_as_steep_as_the_ground_but_where_the_user_knows_better() -> None:
    network = network_of([straight((0.0, 0.0), (50.0, 0.0))], [])
    for slope, bound in ((0.1, 1.25 * 0.15), (0.25, 0.25), (0.4, 0.31)):
        ground, known = on_ground(network, slope), np.array([False, True])
        by_class, _ = limit_grades(network, ground, np.full(2, 0.15), known, beams_of(network))
        assert by_class.high == pytest.approx([bound, bound, 1.25 * 0.15, 1.25 * 0.15])
    canopy = replace(on_ground(network, 0.25), covered=np.ones(len(network.samples.s), bool))
    by_class, _ = limit_grades(network, canopy, np.full(2, 0.15), np.zeros(2, bool), beams_of(network))
    assert by_class.high == pytest.approx(np.full(4, 1.25 * 0.15))


def test_vertical_curvature_is_limited_firmly_by_speed_and_bend() -> None:
    # 40 m straight on, then a bend of 20 m in radius, where 0.3 g allow 28 km/h.
    problem = make_problem([straight((0.0, 0.0), (40.0, 0.0)), RoadSpec(40.0, 0.0, 0.0, 20.0, curvature=0.05)])
    limit = limit_curvatures(network_of_problem(problem), beams := beams_of(network_of_problem(problem)))
    assert limit.high == pytest.approx([2.5 / (50 / 3.6) ** 2] * 4 + [2.5 * 0.05 / 3.0] * 2)
    assert limit.stiffness == pytest.approx(60.0 * 20.0 / beams.flexibility[0])
    # The moment of ground that is off by 50 m over the length that the road gives way over.
    assert limit.cap == pytest.approx(np.full(6, 50.0 * np.sqrt(0.05 / 5e-5) * 20.0 / 2))
    # A parabola has its own curvature at both ends of an element.
    heights = np.array([[0.01 * s * s, 0.02 * s] for s in (0.0, 20.0, 40.0)]).ravel()
    knots = network_of_problem(problem).unknowns.to_knots[:6].toarray()
    x = np.linalg.lstsq(knots, heights, rcond=None)[0]
    assert (limit.rows @ x)[:4] == pytest.approx([0.02] * 4)
    fast = replace(problem, span_speed=np.array([np.inf, np.nan]))
    limit = limit_curvatures(network_of_problem(fast), beams)
    assert limit.high == pytest.approx([2.5 / (130 / 3.6) ** 2] * 4 + [2.5 * 0.05 / 3.0] * 2)


def test_vertical_curvature_is_limited_by_the_speed_behind_an_end_too() -> None:
    # One element of 20 m; from 3 to 7 m 100 km/h hold, else 50.
    spans = [(0.0, 0, 0), (3.0, 0, 0), (7.0, 0, 0)]
    problem = make_problem([straight((0.0, 0.0), (20.0, 0.0), spans=spans)])
    network = network_of_problem(replace(problem, span_speed=np.array([50.0, 100.0, 50.0]) / 3.6))
    assert len(network.elements.h) == 1
    limit = limit_curvatures(network, beams_of(network))
    # Curvature that falls from an end to 0 at the other has come down to three quarters at 5 m.
    assert limit.high == pytest.approx([2.5 / (100 / 3.6) ** 2 / 0.75, 2.5 / (50 / 3.6) ** 2])


def test_vertical_curvature_before_a_bend_is_limited_by_the_speed_there() -> None:
    # The last 2 m of 20 m are a bend of 4 m in radius.
    problem = make_problem([straight((0.0, 0.0), (20.0, 0.0))])
    plan = PlanView(
        np.array([0, 2]), *np.array([[0.0, 18.0], [0.0, 18.0], [0.0, 0.0], [0.0, 0.0], [18.0, 2.0], [0.0, 0.25]])
    )
    network = network_of_problem(replace(problem, plan_view=plan))
    limit = limit_curvatures(network, beams_of(network))
    # At 18 m half of a wheelbase is in the bend; at 15 m none is.
    in_bend, before = 2.5 * 0.125 / 3.0 / 0.9, 2.5 / (50 / 3.6) ** 2 / 0.75
    assert in_bend > before
    assert limit.high[1] == pytest.approx(before)


def test_tunnel_beneath_a_road_near_by_does_not_throw_cars() -> None:
    # A street that dives below another one 15 m before it ends beside it, on precise heights.
    roads = [
        straight((0.0, 0.0), (60.0, 0.0), end=0, spans=((0.0, 0, 0), (20.0, 2, -1), (50.0, 0, 0))),
        straight((35.0, -60.0), (35.0, 60.0)),
        straight((60.0, 0.0), (120.0, 0.0), start=0),
    ]
    found = solve(roads, Ground(lambda x, y: 0.0 * x, sigma=0.3, cell_size=30.0), [(60.0, 0.0)])
    s = np.linspace(0.0, 60.0, 241)
    bend = np.diff(found.grade(0, s)) / np.diff(s)
    assert np.abs(bend).max() < 1.1 * 2.5 / (50 / 3.6) ** 2
    assert float(found.z(0, 35.0)[0]) < float(found.z(1, 60.0)[0]) - 1.0


@pytest.mark.parametrize(
    ("highway", "width", "bound"),
    [
        ("residential", 3.0, 0.06),
        ("residential", 12.0, 0.1 / 6.0),
        ("motorway", 6.0, 0.025),
        ("motorway", 12.0, 0.1 / 6.0),
    ],
)
def test_tilt_across_arms_is_limited_by_class_and_width(highway: str, width: float, bound: float) -> None:
    road = straight((0.0, 5.0), (0.0, 50.0), start=0, highway=highway)
    problem = replace(make_problem([road], [(0.0, 0.0)]), span_width=np.array([width]), span_middle=np.zeros(1))
    across, *_, beside = limit_arms(network_of_problem(problem), np.array([0.05]), np.array([2.0]))
    assert across.high == pytest.approx([bound])
    assert across.low == pytest.approx([-bound])
    assert across.stiffness == pytest.approx([60.0 * ARM_TURN])
    # It gives way to ground that is off by 1 m.
    assert across.cap == pytest.approx([1.0 * MOMENT])
    # The road runs along y: across it is x.
    assert np.abs(across.rows.toarray()[0, :3]) == pytest.approx([0.0, 1.0, 0.0])
    assert len(beside.high) == 0


def beside(gap: float, behind: float, angle: float, out: bool = True) -> FloatArray:
    """Return the limits on steps between two roads of 6 m that end at a junction."""
    first = straight((-100.0, 0.0), (0.0, 0.0), end=0)
    x, y, dx, dy = -behind, 6.0 + gap, 100.0 * np.cos(angle), 100.0 * np.sin(angle)
    second = straight((x - dx, y + dy), (x, y), end=0) if out else straight((x, y), (x + dx, y - dy), start=0)
    network = network_of([first, second], [(0.0, 0.0)])
    *_, steps = limit_arms(network, np.array([0.05]), np.array([2.0]))
    return steps.high


def test_arms_beside_each_other_meet_at_one_height() -> None:
    # 6 cm over the distance of their middles.
    assert beside(1.0, 0.0, 0.0) == pytest.approx([0.06 / 7.0])
    assert beside(2.9, 24.0, 0.0) == pytest.approx([0.06 / 8.9])
    assert len(beside(3.1, 0.0, 0.0)) == 0
    assert len(beside(1.0, 26.0, 0.0)) == 0
    assert len(beside(1.0, 0.0, 0.49)) == 1
    assert len(beside(1.0, 0.0, 0.51)) == 0
    # The other side of the junction is not beside.
    assert len(beside(1.0, 0.0, 0.0, out=False)) == 0


def test_ramp_and_motorway_come_together_level_on_a_slope() -> None:
    roads = [
        straight((-300.0, 0.0), (-5.0, 0.0), end=0, highway="motorway"),
        straight((-300.0, -8.0), (-5.0, -8.0), end=0, highway="motorway_link"),
        straight((40.0, 0.0), (300.0, 0.0), start=0, highway="motorway"),
    ]
    found = solve(roads, Ground(lambda x, y: 0.1 * y), [(0.0, 0.0)])
    apart = np.abs(found.z(0, 295.0) - found.z(1, 295.0))
    assert apart < 0.075
    assert np.abs(found.z(0, 0.0) - found.z(1, 0.0)) > 0.5


@pytest.mark.parametrize(("sigma", "push"), [(0.005, 1.0), (0.05, 5.0), (1.0, 100.0), (6.0, 500.0)])
def test_clearance_is_a_limit_against_another_road(sigma: float, push: float) -> None:
    network = network_of([straight((-50.0, 0.0), (50.0, 0.0)), straight((0.0, -50.0), (0.0, 50.0))], [])
    crossings = one_crossing()
    found = limit_clearances(network, crossings, beams_of(network), np.array([sigma]))
    assert (found.low.tolist(), found.high.tolist(), found.own.tolist()) == ([5.2], [np.inf], [False])
    # At its cap where it is short by 0.1 m.
    assert found.stiffness == pytest.approx([max(60.0, push / 0.1) * LIFT])
    assert found.cap == pytest.approx([push * LIFT])
    # The height of the upper road less that of the lower one.
    assert found.rows.toarray().sum(axis=1).tolist() == [0.0]


def test_clearance_over_a_connecting_road_is_that_over_its_junctions_plane() -> None:
    roads = [
        straight((-50.0, 3.0), (50.0, 3.0), spans=[(0.0, 1, 1)]),
        straight((0.0, -50.0), (0.0, -8.0), end=0),
        straight((0.0, 8.0), (0.0, 50.0), start=0),
    ]
    problem = replace(
        make_problem(roads, [(1.0, 1.0)]), connectors=connector_between((0.0, -8.0), (0.0, 8.0), (3, 4))
    )
    network = replace(network_of(roads, [(1.0, 1.0)]), problem=problem)
    found = limit_clearances(network, one_crossing(lower=3, lower_s=11.0), beams_of(network), np.ones(1))
    x = np.zeros(network.unknowns.to_knots.shape[1])
    x[:3] = 7.0, 0.1, 0.02
    # At (0, 3): the plane is 7 m high at (1, 1).
    assert found.rows @ x == pytest.approx([-(7.0 - 0.1 + 0.04)])
    assert found.stiffness == pytest.approx([1000.0 * LIFT])


def test_tunnels_are_held_below_measured_ground_and_bridges_above_it() -> None:
    spans = [(0.0, 0, 0), (25.0, 2, -1), (75.0, 1, 1)]
    network = network_of([straight((0.0, 0.0), (100.0, 0.0), spans=spans)], [], spacing=12.5)
    n = len(network.samples.s)
    assert n == 8
    z, one, no = 300.0 + np.arange(8.0), np.ones(n), np.zeros(n, bool)
    reading = Reading(z, z, one, one, one, np.arange(8) != 3, no, one, 0.0 * one, 0.0 * one)
    beams = beams_of(network)
    limit = limit_structures(network, reading, beams, np.zeros(1, bool), mean=290.0)
    # The third sample of four in the tunnel lies in a gap of the model. Two more are on the bridge, which may lie a
    # standard error below the ground.
    assert limit.high.tolist() == [12.0, 14.0, 15.0, np.inf, np.inf]
    assert limit.low.tolist() == [-np.inf] * 3 + [15.0, 16.0]
    assert limit.cap == pytest.approx([10.0 * 0.05 * 12.5] * 5)
    assert limit.stiffness == pytest.approx([60.0 * 0.05 * 12.5] * 5)
    assert not limit.own.any()
    # The rows give the road's height at these samples.
    knots = network.unknowns.to_knots.toarray()
    x = np.linalg.lstsq(knots, np.column_stack([network.elements.knot_s, np.ones(5)]).ravel(), rcond=None)[0]
    assert limit.rows @ x == pytest.approx(network.samples.s[[2, 4, 5, 6, 7]])
    assert len(limit_structures(network, reading, beams, np.ones(1, bool), mean=290.0).high) == 0


def test_limits_against_other_roads_can_be_made_void() -> None:
    network = network_of([straight((-50.0, 0.0), (50.0, 0.0)), straight((0.0, -50.0), (0.0, 50.0))], [])
    crossings = one_crossing()
    found = limit_clearances(network, crossings, beams_of(network), np.ones(1))
    assert found.force(np.zeros(1)) == pytest.approx([-100.0 * LIFT])
    assert found.own_only().force(np.zeros(1)).tolist() == [0.0]
    (grades, _) = limit_grades(network, on_ground(network), np.full(8, 0.1), np.zeros(8, bool), beams_of(network))
    assert grades.own_only().force(np.full(16, 0.2)).tolist() == grades.force(np.full(16, 0.2)).tolist()


def test_limits_push_with_their_caps_at_most() -> None:
    network = network_of([straight((0.0, 0.0), (25.0, 0.0))], [])
    by_class, firm = limit_grades(network, on_ground(network), np.array([0.15]), np.zeros(1, bool), beams_of(network))
    grade = 1.25 * 0.15 + np.array([0.0, 0.0005])
    assert by_class.force(grade) == pytest.approx([0.0, 0.03 * TURN], abs=1e-9)
    # Ground that is off by 10 m wins over the class's grade; the firm limit holds it.
    most = 10.0 * LIFT * 25.0 / 2
    assert by_class.force(np.array([-99.0, 99.0])) == pytest.approx([-most, most])
    assert firm.force(np.full(5, 0.312)) == pytest.approx(np.full(5, 240.0 * 0.002 * TURN))


def test_step_of_exact_ground_becomes_a_ramp_as_steep_as_roads_are() -> None:
    found = solve([straight((-200.0, 0.0), (200.0, 0.0))], Ground(lambda x, y: np.where(x > 0.0, 5.0, 0.0)))
    s, _, _, z = found.along(0)
    assert np.abs(found.grade(0, s)).max() < 0.315
    assert z[0] == pytest.approx(0.0, abs=0.05)
    assert z[-1] == pytest.approx(5.0, abs=0.05)
    # The ramp is as far above as below the step.
    assert z == pytest.approx(5.0 - z[::-1], abs=0.1)


@pytest.mark.parametrize("which", ["bridge", "tunnel"])
def test_layers_that_cross_keep_clear(which: str) -> None:
    upper = [(0.0, 0, 0), (250.0, 1, 1), (350.0, 0, 0)] if which == "bridge" else [(0.0, 0, 0)]
    lower = [(0.0, 0, 0)] if which == "bridge" else [(0.0, 0, 0), (250.0, 2, -1), (350.0, 0, 0)]
    ground = Ground(lambda x, y: 0.01 * x, cell_size=10.0, sigma=1.0)
    roads = [straight((-300.0, 0.0), (300.0, 0.0), spans=upper), straight((0.0, -300.0), (0.0, 300.0), spans=lower)]
    found = solve(roads, ground)
    gap = float(found.z(0, 300.0)[0] - found.z(1, 300.0)[0])
    assert 5.2 - 0.1 < gap < 6.0
    assert found.solution.statistics["layer_crossings"] == 1.0
    assert found.solution.statistics["layer_crossings_too_close"] == 0.0
    assert np.abs(found.grade(0, np.arange(600.0))).max() < 1.25 * 0.15 + 0.005


def bridge_between_junctions(arms: int, sigma: float = 0.1) -> Solved:
    """Return a motorway bridge between junctions 15 m from what it crosses, where so many motorways lead away."""
    roads = [
        straight((-15.0, 0.0), (15.0, 0.0), start=0, end=1, spans=[(0.0, 1, 1)], highway="motorway"),
        straight((0.0, -300.0), (0.0, 300.0)),
    ]
    for j, side in enumerate((-1.0, 1.0)):
        roads += [
            straight((side * 20.0, 5.0 * c), (side * 300.0, 200.0 * c), start=j, highway="motorway")
            for c in np.linspace(-1.0, 1.0, arms).tolist()
        ]
    ground = Ground(lambda x, y: 0.001 * x, cell_size=2.0, sigma=sigma)
    return solve(roads, ground, [(-15.0, 0.0), (15.0, 0.0)])


def test_ramps_become_long_and_steep_before_clearance_yields() -> None:
    found = bridge_between_junctions(arms=3)
    assert float(found.z(0, 15.0)[0] - found.z(1, 300.0)[0]) > 5.15
    assert "clearance" not in found.codes()
    # Steeper than a motorway's 6 % and a quarter.
    steepest = max(float(np.abs(found.grade(k, np.arange(0.0, 260.0))).max()) for k in range(2, 8))
    assert 0.075 < steepest < 0.12


def test_clearance_that_cannot_be_met_is_reported() -> None:
    # Precise heights hold more roads down than the bridge can lift.
    found = bridge_between_junctions(arms=60, sigma=0.01)
    notes = [item for item in found.diagnostics if item.code == "clearance"]
    assert [item.osm_id for item in notes] == ["way/100"]
    assert "way/101" in notes[0].message
    assert found.solution.statistics["layer_crossings_too_close"] == 1.0
    assert found.solution.statistics["layer_crossings"] == 1.0


def test_no_road_is_steeper_than_the_firm_limit() -> None:
    # The ground is 29 m off a slope of 31 % at the ends: it gives way to the limit by 50 m.
    found = solve(cross(size=100.0, trim=10.0), Ground(lambda x, y: 0.6 * x), [(0.0, 0.0)])
    for road in range(4):
        assert np.abs(found.grade(road, np.linspace(0.0, 90.0, 400))).max() < 0.35


def test_ends_that_nearly_touch_are_level_with_each_other() -> None:
    # A road that parts into two on a steep slope, 4 m apart from each other sideways.
    roads = [
        straight((-200.0, 0.0), (0.0, 0.0), end=0),
        straight((4.0, 2.0), (200.0, 40.0), start=0),
        straight((4.0, -2.0), (200.0, -40.0), start=0),
    ]
    found = solve(roads, Ground(lambda x, y: 0.3 * y), [(0.0, 0.0)])
    assert abs(float(found.z(1, 0.0)[0] - found.z(2, 0.0)[0])) < 0.5


def test_step_of_the_ground_becomes_a_passable_ramp() -> None:
    # A wall of 6 m across the road, on a laser model: the road climbs it no steeper than roads are.
    found = solve([straight((-300.0, 0.0), (300.0, 0.0))], Ground(lambda x, y: np.where(x < 0, 0.0, 6.0), 1.0, 0.15))
    s, x, _, z = found.along(0)
    assert z[x < -60.0] == pytest.approx(0.0, abs=0.35)
    assert z[x > 60.0] == pytest.approx(6.0, abs=0.35)
    assert np.abs(found.grade(0, s)).max() < 0.315


def test_user_limits_hold_roads_back() -> None:
    ground = Ground(lambda x, y: 8.0 * np.tanh(x / 60.0), cell_size=10.0, sigma=1.5)
    road = [straight((-400.0, 0.0), (400.0, 0.0))]
    s = np.linspace(0.0, 800.0, 801)
    free = solve(road, ground)
    held = solve(road, ground, options=ElevationOptions(grade_limit=parse_grade_limits("residential=5%")))
    assert np.abs(free.grade(0, s)).max() > 0.1
    assert np.abs(held.grade(0, s)).max() < 1.25 * 0.05 + 0.01
    report = held.solution.report
    assert report is not None
    assert [(place.osm_way_id, place.wanted) for place in report.steep] == [(100, 0.05)]
    assert free.solution.report is not None
    assert free.solution.report.steep == ()


@pytest.mark.parametrize(("highway", "wanted"), [("motorway", 5.4), ("residential", 5.2), ("service", 4.2)])
def test_clearance_is_that_of_the_class_below(highway: str, wanted: float) -> None:
    upper = [(0.0, 0, 0), (250.0, 1, 1), (350.0, 0, 0)]
    ground = Ground(lambda x, y: 0.001 * x, cell_size=10.0, sigma=1.0)
    roads = [
        straight((-300.0, 0.0), (300.0, 0.0), spans=upper),
        straight((0.0, -300.0), (0.0, 300.0), highway=highway),
    ]
    found = solve(roads, ground)
    gap = float(found.z(0, 300.0)[0] - found.z(1, 300.0)[0])
    assert wanted - 0.1 < gap < wanted + 0.3


@pytest.mark.parametrize("gap", [0.0, 1.0])
@pytest.mark.parametrize("rise", [0.1, 0.18])
def test_ends_whose_edges_touch_are_all_but_level(gap: float, rise: float) -> None:
    # A ring's end and, beside it, that of the arm that joins it; both 6 m wide, the ground rises across them.
    roads = [
        straight((-150.0, 0.0), (0.0, 0.0), end=0),
        straight((-140.0, 6.0 + gap), (0.0, 6.0 + gap), end=0),
        straight((12.0, 3.0), (150.0, 3.0), start=0),
    ]
    found = solve(roads, Ground(lambda x, y: rise * y), [(0.0, 3.0)])
    z = found.solution.end_z.ravel()
    assert abs(z[3] - z[1]) == pytest.approx(0.06, rel=0.2)


def test_all_arms_of_a_junction_are_paired_and_those_of_others_are_not() -> None:
    a, b = _arm_pairs(np.array([1, -1, 0, 1, -1, 0, 1, 2]), 4)
    assert sorted(zip(a.tolist(), b.tolist(), strict=True)) == [(0, 3), (0, 6), (2, 5), (3, 6)]


def test_excess_and_force_have_the_sign_of_what_is_beyond() -> None:
    network = network_of([straight((0.0, 0.0), (25.0, 0.0))], [])
    (by_class, _) = limit_grades(network, on_ground(network), np.array([0.08]), np.zeros(1, bool), beams_of(network))
    assert by_class.excess(np.array([-0.15, 0.15])) == pytest.approx([-0.05, 0.05])
    assert by_class.excess(np.array([0.1, -0.1])) == pytest.approx([0.0, 0.0])
    one = np.array([1])
    assert by_class.excess(np.array([0.3]), one) == pytest.approx([0.2])
    assert by_class.force(np.array([0.1005]), one) == pytest.approx([0.03 * TURN])
    # The rows are grades at a quarter and at three quarters of each element.
    z = network.unknowns.to_knots
    assert z.shape[1] == 4
    slope_at_ends = np.array([0.0, 0.2, 2.5, 0.0])
    u = np.array([0.25, 0.75])
    expected = 6 * (u - u * u) * 0.1 + 0.2 * (1 - 4 * u + 3 * u * u)
    knots = np.linalg.solve(z.toarray(), slope_at_ends)
    assert by_class.rows @ knots == pytest.approx(expected)


def unknowns_of(network: Network, z: FloatArray, grade: FloatArray, plane: list[float] | None = None) -> FloatArray:
    """Return the unknowns that give these heights and grades at the knots, and this plane to junction 0."""
    knots = np.column_stack([z, grade]).ravel()
    x = np.asarray(np.linalg.lstsq(network.unknowns.to_knots.toarray(), knots, rcond=None)[0])
    if plane is not None:
        x[:3] = plane
    return x


@pytest.mark.parametrize(
    ("highway", "deepest"),
    [("residential", 2.0), ("track", 2.0), ("tertiary", 4.0), ("secondary", 6.0), ("motorway", 15.0)],
)
def test_cut_and_fill_are_limited_by_class(highway: str, deepest: float) -> None:
    network = network_of([straight((0.0, 0.0), (100.0, 0.0), highway=highway)], [], spacing=12.5)
    one, no = np.ones(8), np.zeros(8, bool)
    z = 300.0 + np.arange(8.0)
    reading = Reading(z, z, 0.5 * one, 4.0 * one, one, np.arange(8) != 3, no, one, 0.0 * one, 0.0 * one)
    limit = limit_cut_and_fill(network, reading, mean=290.0)
    # What is not measured has no limit.
    ground = np.delete(10.0 + np.arange(8.0), 3)
    # What the model does not show, a standard error of 0.5 m, counts for neither side.
    assert limit.low == pytest.approx(ground - deepest - 0.5)
    assert limit.high == pytest.approx(ground + deepest + 0.5)
    # As ground that is off by 3 m, which weighs 1 / (4 m (0.5 m)²) per metre.
    assert limit.cap == pytest.approx(np.full(7, 3.0 * 12.5))
    assert limit.stiffness == pytest.approx(np.full(7, 60.0 * 12.5))
    assert limit.own.all()
    s = network.elements.knot_s
    x = unknowns_of(network, 0.1 * s, np.full(len(s), 0.1))
    assert limit.rows @ x == pytest.approx(0.1 * np.delete(network.samples.s, 3))


def test_streets_are_not_cut_deeper_than_streets_are() -> None:
    """A knoll of 12 m: a street goes over it, a motorway through it."""
    ground = Ground(lambda x, y: 12.0 * np.exp(-((x / 60.0) ** 2)), cell_size=10.0, sigma=1.0)
    cut = {}
    for highway in ("residential", "motorway"):
        found = solve([straight((-500.0, 0.0), (500.0, 0.0), highway=highway)], ground)
        _, x, y, z = found.along(0)
        cut[highway] = float(np.abs(z - ground.height(x, y)).max())
    assert cut["residential"] < 2.0 + 1.0
    assert cut["residential"] < cut["motorway"] < 15.0


def turning(angle: float, into: bool = False) -> tuple[ProfileProblem, float]:
    """Return two arms, the second at an angle to the first, and a way of 12 m from one to the other."""
    cos, sin = float(np.cos(angle)), float(np.sin(angle))
    a, b = (8.0 * cos, 8.0 * sin), (90.0 * cos, 90.0 * sin)
    other = straight(b, a, end=0) if into else straight(a, b, start=0)
    problem = make_problem([straight((-90.0, 0.0), (-8.0, 0.0), end=0), other], [(0.0, 0.0)])
    connectors = connector_between((0.0, 0.0), (12.0, 0.0), (1, 3 if into else 2))
    return replace(problem, connectors=connectors, warped=np.ones(1, bool)), 12.0


@pytest.mark.parametrize("into", [False, True])
@pytest.mark.parametrize("angle", [0.5 * np.pi, -0.5 * np.pi, 0.3])
def test_ways_between_warped_arms_twist_no_faster_than_cars_follow(angle: float, into: bool) -> None:
    problem, length = turning(angle, into)
    network = network_of_problem(problem)
    _, _, usual, firm, *_ = limit_arms(network, np.array([0.05]), np.array([2.0]))
    x = np.zeros(network.unknowns.to_knots.shape[1])
    x[:3] = 50.0, 0.1, 0.06
    # The plane rises to the left of whoever enters by 0.06, and of whoever leaves at this angle by so much.
    assert usual.rows @ x[:3] == pytest.approx([-0.1 * np.sin(angle) + 0.06 * np.cos(angle) - 0.06])
    assert usual.high == pytest.approx([0.015 * length])
    assert firm.high == pytest.approx([0.033 * length])
    # It gives way to half a standard error of 2 m; the firm one as to none.
    assert usual.cap == pytest.approx([1.0 * MOMENT])
    assert firm.cap == pytest.approx([50.0 * MOMENT])


def test_warped_arms_may_have_the_slope_that_runs_out_along_them() -> None:
    roads = [
        straight((5.0, 0.0), (305.0, 0.0), start=0),
        straight((0.0, 5.0), (0.0, 15.0), start=0, end=1),
    ]
    problem = replace(make_problem(roads, [(0.0, 0.0), (0.0, 20.0)]), warped=np.ones(2, bool))
    single, change, *_ = limit_arms(network_of_problem(problem), np.full(2, 0.05), np.array([2.0, 4.0]))
    # 10 m: a step that bends by 6 c / L² lifts 3 m at 50 km/h with 0.5 m/s².
    most = 0.5 * 10.0**2 / (6.0 * 3.0 * (50.0 / 3.6) ** 2)
    # A long road, and one between two warped arms, whose ends differ by what its length allows.
    assert single.high == pytest.approx([0.3, 0.3, 0.3])
    assert single.cap == pytest.approx([1.0 * MOMENT, 1.0 * MOMENT, 2.0 * MOMENT])
    assert change.high == pytest.approx([most])
    lone = replace(problem, end_junction=np.array([[0, -1], [0, -1]]))
    single, change, *_ = limit_arms(network_of_problem(lone), np.full(2, 0.05), np.array([2.0, 4.0]))
    assert single.high == pytest.approx([0.3, most])
    assert len(change.high) == 0


@pytest.mark.parametrize("warped", [False, True])
def test_ways_through_junctions_are_limited_as_cubics_between_their_lanes(warped: bool) -> None:
    """From the end of the first road, 2 m to its right, to the start of the second one, 1 m to its left."""
    roads = [straight((-90.0, 0.0), (-8.0, 0.0), end=0), straight((8.0, 3.0), (90.0, 3.0), start=0)]
    connectors = connector_between((-8.0, -2.0), (8.0, 4.0), (1, 2))
    connectors = replace(connectors, start_t=np.array([-2.0]), end_t=np.array([1.0]))
    length = float(np.hypot(16.0, 6.0))
    problem = replace(make_problem(roads, [(0.0, 0.0)]), connectors=connectors, warped=np.array([warped]))
    network = network_of_problem(problem)
    middle, begin, end = limit_arms(network, np.array([0.05]), np.array([2.0]))[-5:-2]
    s = network.elements.knot_s
    first = np.arange(len(s)) < network.elements.knot_start[1]
    z = np.where(first, 50.0 + 0.1 * (s - 82.0), 51.0 - 0.05 * s)
    x = unknowns_of(network, z, np.where(first, 0.1, -0.05), [50.0, 0.1, 0.2])
    # Warped lanes beside the middle of their arms lie on the plane's slope across, 0.2.
    z0, z1 = (50.0 - 0.4, 51.0 + 0.2) if warped else (50.0, 51.0)
    u = np.polynomial.Polynomial([z0, 0.1])
    c = (3.0 * (z1 - z0) / length - 2.0 * 0.1 + 0.05) / length
    d = (0.1 - 0.05 - 2.0 * (z1 - z0) / length) / length**2
    path = u + np.polynomial.Polynomial([0.0, 0.0, c, d])
    assert path(length) == pytest.approx(z1)
    assert path.deriv()(length) == pytest.approx(-0.05)
    assert middle.rows @ x == pytest.approx([path.deriv()(0.5 * length)])
    assert middle.high == pytest.approx([0.31])
    bends = path.deriv(2)
    # In grades: a quarter of curvature times length.
    for limit, place, sign in ((begin, 0.0, 1.0), (end, length, -1.0)):
        assert limit.rows @ x == pytest.approx([sign * 0.25 * length * bends(place)])
        assert limit.high == pytest.approx([0.25 * length * 2.5 / (50.0 / 3.6) ** 2])
        assert limit.cap == pytest.approx([50.0 * MOMENT])


@pytest.mark.parametrize("warped", [False, True])
def test_ways_have_one_surface_where_they_part(warped: bool) -> None:
    """They are 16.5 m long, end 8 m apart, and are wider than that up to half-way, where they are 4 m apart."""
    roads = [straight((-90.0, 0.0), (-8.0, 0.0), end=0)]
    roads += [straight((8.0, y), (90.0, y), start=0) for y in (4.0, -4.0)]
    left, right = (connector_between((-8.0, 0.0), (8.0, y), (1, end)) for y, end in ((4.0, 2), (-4.0, 4)))
    both = {f.name: np.concatenate([getattr(left, f.name), getattr(right, f.name)]) for f in fields(left)[1:7]}
    plan = plan_view([straight((-8.0, 0.0), (8.0, y)) for y in (4.0, -4.0)])
    connectors = replace(left, plan_view=plan, **both)
    problem = replace(make_problem(roads, [(0.0, 0.0)]), connectors=connectors, warped=np.array([warped]))
    network = network_of_problem(problem)
    parting = limit_arms(network, np.array([0.05]), np.array([2.0]))[-2]
    knots, length = network.elements, float(np.hypot(16.0, 4.0))
    road = np.searchsorted(knots.knot_start, np.arange(len(knots.knot_s)), side="right") - 1
    x = unknowns_of(network, np.array([50.0, 51.0, 49.5])[road], np.array([0.0, 0.0, 0.02])[road], [50.0, 0.1, 0.2])
    difference = 0.5 * (51.0 - 49.5) + length / 8.0 * 0.02
    assert parting.rows @ x == pytest.approx([difference / 4.0 - (0.2 if warped else 0.0)])
    assert parting.high == pytest.approx([max(0.06, 0.5 * 0.015 * length / 2.0)])
    assert parting.low == -parting.high
    assert parting.cap == pytest.approx([3.0 * MOMENT])


@pytest.mark.parametrize("warped", [False, True])
def test_steps_are_those_from_one_surface_to_the_other(warped: bool) -> None:
    """The second arm's end lies 7 m to the left of the first one's and 4 m before it."""
    roads = [straight((-100.0, 0.0), (0.0, 0.0), end=0), straight((-104.0, 7.0), (-4.0, 7.0), end=0)]
    problem = replace(make_problem(roads, [(3.0, 3.0)]), warped=np.array([warped]))
    network = network_of_problem(problem)
    *_, steps = limit_arms(network, np.array([0.05]), np.array([2.0]))
    s = network.elements.knot_s
    first = np.arange(len(s)) < network.elements.knot_start[1]
    z, grade = np.where(first, 50.0 + 0.1 * (s - 100.0), 50.5), np.where(first, 0.1, 0.0)
    x = unknowns_of(network, z, grade, [50.0, 0.1, 0.02])
    # The first one's surface is 0.4 m lower there, and 0.14 m higher if it is warped.
    surface = 50.0 - 0.4 + (0.14 if warped else 0.0)
    assert steps.rows @ x == pytest.approx([(50.5 - surface) / 7.0])
    assert steps.cap == pytest.approx([50.0 * MOMENT])
