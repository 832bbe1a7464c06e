"""Limits on grades, tilts and clearances."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import Ground, RoadSpec, Solved, connector_between, cross, make_problem, solve, straight

from osm2xodr.geometry.heights import ElevationOptions, parse_grade_limits
from osm2xodr.geometry.heights.crossings import Crossings
from osm2xodr.geometry.heights.elements import Network, build_elements, build_samples, number_unknowns
from osm2xodr.geometry.heights.limits import limit_clearances, limit_grades, limit_tilts
from osm2xodr.geometry.heights.stiffness import Beams


def network_of(roads: list[RoadSpec], junctions: list[tuple[float, float]], spacing: float = 25.0) -> Network:
    """Return roads cut into elements of at most 25 m with samples this far apart, m."""
    problem = make_problem(roads, junctions)
    elements = build_elements(problem, 25.0)
    samples = build_samples(problem, elements, np.full(len(roads), spacing))
    return Network(problem, elements, samples, number_unknowns(problem, elements))


def beams_of(network: Network) -> Beams:
    elements = len(network.elements.h)
    return Beams(np.full(elements, 5e-5), np.full(elements, 0.05))


# Stiffness of these beams against being turned and lifted.
TURN = np.sqrt(2.0) * (0.05 / 5e-5**3) ** 0.25
LIFT = 2.0 * np.sqrt(2.0) * (0.05**3 / 5e-5) ** 0.25


def one_crossing(lower: int = 1, lower_s: float = 50.0) -> Crossings:
    """Return where road 0 passes over another curve."""
    zero, at = np.zeros(1, np.int64), np.array([50.0])
    return Crossings(zero, at, zero + lower, np.array([lower_s]), np.array([5.2]), zero, np.zeros((1, 2)))


def test_grades_are_limited_by_class_at_quarters_and_firmly_all_along() -> None:
    network = network_of([straight((0.0, 0.0), (50.0, 0.0))], [])
    by_class, firm = limit_grades(network, np.full(2, 0.15), beams_of(network))
    assert by_class.high.tolist() == (-by_class.low).tolist() == [1.25 * 0.15] * 4
    assert by_class.stiffness == pytest.approx(np.full(4, 60.0 * TURN))
    assert by_class.cap == pytest.approx(np.full(4, 1.5 * TURN))
    assert firm.high.tolist() == (-firm.low).tolist() == [0.31] * 10
    assert firm.cap.tolist() == [np.inf] * 10
    assert by_class.own.all()
    assert firm.own.all()


def test_tilts_are_limited_by_the_class_of_the_arms_and_firmly() -> None:
    network = network_of([straight((5.0, 0.0), (50.0, 0.0), start=0)], [(0.0, 0.0)])
    by_class, firm, step = limit_tilts(network, np.array([[0.06, 0.25]]), np.array([0.05]))
    assert by_class.high == pytest.approx(np.full(4, 1.25 * 0.06))
    assert by_class.cap == pytest.approx(np.full(4, 3.0 * TURN))
    assert firm.high.tolist() == [0.2] * 4
    assert firm.cap.tolist() == [np.inf] * 4
    assert len(step.high) == 0
    # Four directions, 45 degrees apart.
    assert np.abs(firm.rows.toarray()[:, 1:3]).max(axis=1) == pytest.approx([1.0, np.sqrt(0.5), 1.0, np.sqrt(0.5)])


@pytest.mark.parametrize(("sigma", "push"), [(0.05, 1.0), (1.0, 10.0), (6.0, 50.0)])
def test_clearance_is_a_limit_against_another_road(sigma: float, push: float) -> None:
    network = network_of([straight((-50.0, 0.0), (50.0, 0.0)), straight((0.0, -50.0), (0.0, 50.0))], [])
    crossings = one_crossing()
    found = limit_clearances(network, crossings, beams_of(network), np.array([sigma]))
    assert (found.low.tolist(), found.high.tolist(), found.own.tolist()) == ([5.2], [np.inf], [False])
    assert found.stiffness == pytest.approx([60.0 * LIFT])
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
    assert found.stiffness == pytest.approx([60.0 * LIFT])


def test_limits_against_other_roads_can_be_made_void() -> None:
    network = network_of([straight((-50.0, 0.0), (50.0, 0.0)), straight((0.0, -50.0), (0.0, 50.0))], [])
    crossings = one_crossing()
    found = limit_clearances(network, crossings, beams_of(network), np.ones(1))
    assert found.force(np.zeros(1)) == pytest.approx([-10.0 * LIFT])
    assert found.own_only().force(np.zeros(1)).tolist() == [0.0]
    (grades, _) = limit_grades(network, np.full(8, 0.1), beams_of(network))
    assert grades.own_only().force(np.full(16, 0.2)).tolist() == grades.force(np.full(16, 0.2)).tolist()


def test_class_limit_yields_beyond_its_cap_and_the_firm_one_does_not() -> None:
    network = network_of([straight((0.0, 0.0), (25.0, 0.0))], [])
    by_class, firm = limit_grades(network, np.array([0.15]), beams_of(network))
    grade = 1.25 * 0.15 + np.array([0.0, 0.01])
    assert by_class.force(grade) == pytest.approx([0.0, 0.6 * TURN], abs=1e-9)
    assert by_class.force(np.array([-0.5, 0.5])) == pytest.approx([-1.5 * TURN, 1.5 * TURN])
    assert firm.force(np.full(5, 0.5)) == pytest.approx(np.full(5, 60.0 * 0.19 * TURN))


def test_step_becomes_a_ramp_within_the_limit_of_the_class() -> None:
    found = solve([straight((-200.0, 0.0), (200.0, 0.0))], Ground(lambda x, y: np.where(x > 0.0, 5.0, 0.0)))
    s, _, _, z = found.along(0)
    assert np.abs(found.grade(0, s)).max() < 1.25 * 0.15 + 0.005
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


def bridge_between_junctions(arms: int) -> Solved:
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
    ground = Ground(lambda x, y: 0.001 * x, cell_size=2.0, sigma=0.1)
    return solve(roads, ground, [(-15.0, 0.0), (15.0, 0.0)])


def test_ramps_become_long_and_steep_before_clearance_yields() -> None:
    found = bridge_between_junctions(arms=3)
    assert float(found.z(0, 15.0)[0] - found.z(1, 300.0)[0]) > 5.2
    assert "clearance" not in found.codes()
    # Steeper than a motorway's 6 % and a quarter.
    steepest = max(float(np.abs(found.grade(k, np.arange(0.0, 260.0))).max()) for k in range(2, 8))
    assert 0.075 < steepest < 0.12


def test_clearance_that_cannot_be_met_is_reported() -> None:
    # Precise heights hold more roads down than the bridge can lift.
    found = bridge_between_junctions(arms=60)
    notes = [item for item in found.diagnostics if item.code == "clearance"]
    assert [item.osm_id for item in notes] == ["way/100"]
    assert "way/101" in notes[0].message
    assert found.solution.statistics["layer_crossings_too_close"] == 1.0
    assert found.solution.statistics["layer_crossings"] == 1.0


def test_no_road_is_steeper_than_the_firm_limit() -> None:
    roads = cross(trim=10.0)
    found = solve(roads, Ground(lambda x, y: 0.6 * x), [(0.0, 0.0)])
    for road in range(4):
        assert np.abs(found.grade(road, np.linspace(0.0, 190.0, 400))).max() < 0.32
    assert np.hypot(*found.solution.junction_plane[0, 1:]) < 0.23


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
    allowed = 0.06 + 0.15 * gap
    assert abs(z[3] - z[1]) == pytest.approx(allowed, rel=0.1)
