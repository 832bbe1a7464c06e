"""Heights of roads on ground of known shape."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import Ground, RoadSpec, cross, make_problem, solve, straight
from hypothesis import given, settings, strategies as st

from osm2xodr.curves.cubics import cubic_slope, cubic_value
from osm2xodr.curves.plan_views import lengths
from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.geometry.heights.options import parse_grade_limits
from osm2xodr.geometry.heights.solve import ElevationOptions, solve_profiles
from osm2xodr.model import FloatArray

PLANE = Ground(lambda x, y: 300.0 + 0.05 * x - 0.03 * y)


def test_level_surface_gives_exactly_its_height() -> None:
    found = solve(cross(), Ground(lambda x, y: np.zeros(len(x))), [(0.0, 0.0)])
    elevation = found.solution.elevation
    assert elevation.start.tolist() == [0, 1, 2, 3, 4]
    assert elevation.a.tolist() == [0.0] * 4
    assert not np.any([elevation.b, elevation.c, elevation.d])
    assert found.solution.junction_plane.tolist() == [[0.0, 0.0, 0.0]]


def test_plane_is_met_everywhere_by_few_records() -> None:
    found = solve(cross(), PLANE, [(0.0, 0.0)])
    for road in range(4):
        _, x, y, z = found.along(road)
        assert np.abs(z - PLANE.height(x, y)).max() < 0.01
    assert found.solution.junction_plane[0] == pytest.approx([300.0, 0.05, -0.03], abs=0.002)
    assert len(found.solution.elevation.s) <= 8
    assert found.solution.statistics["height_above_surface_p95_m"] < 0.01
    assert found.solution.statistics["height_measured_share"] == 1.0


def test_one_sided_ramp_is_not_mirrored() -> None:
    found = solve([straight((-150.0, 0.0), (150.0, 0.0))], Ground(lambda x, y: 0.08 * np.maximum(x, 0.0)))
    s, x, _, z = found.along(0)
    assert z[x < -20] == pytest.approx(0.0, abs=0.03)
    assert z[x > 20] == pytest.approx(0.08 * x[x > 20], abs=0.03)
    assert found.grade(0, s[-1:]) == pytest.approx(0.08, abs=0.002)


def test_paraboloid_is_met_on_a_curve() -> None:
    ground = Ground(lambda x, y: 1e-4 * (x * x + 2.0 * y * y) + 0.01 * x)
    found = solve([RoadSpec(-150.0, 20.0, 0.4, 300.0, curvature=-0.004)], ground)
    _, x, y, z = found.along(0)
    assert np.abs(z - ground.height(x, y)).max() < 0.02


def test_step_becomes_a_ramp_within_the_limit_of_the_class() -> None:
    found = solve([straight((-200.0, 0.0), (200.0, 0.0))], Ground(lambda x, y: np.where(x > 0.0, 5.0, 0.0)))
    s, _, _, z = found.along(0)
    assert np.abs(found.grade(0, s)).max() < 1.25 * 0.15 + 0.005
    assert z[0] == pytest.approx(0.0, abs=0.05)
    assert z[-1] == pytest.approx(5.0, abs=0.05)
    # The ramp is as far above as below the step.
    assert z == pytest.approx(5.0 - z[::-1], abs=0.1)


def gorge(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.where(np.abs(x) < 45.0, 100.0 - 40.0 * np.cos(np.pi * x / 90.0) ** 2, 100.0)


def test_bridge_over_a_gorge_stays_level() -> None:
    spans = [(0.0, 0, 0), (140.0, 1, 1), (260.0, 0, 0)]
    found = solve([straight((-200.0, 0.0), (200.0, 0.0), spans=spans)], Ground(gorge))
    _, _, _, z = found.along(0)
    assert z == pytest.approx(100.0, abs=0.05)


def test_without_structures_the_road_follows_the_gorge() -> None:
    spans = [(0.0, 0, 0), (140.0, 1, 1), (260.0, 0, 0)]
    options = ElevationOptions(structures=False)
    found = solve([straight((-200.0, 0.0), (200.0, 0.0), spans=spans)], Ground(gorge), options=options)
    assert found.z(0, 200.0) < 95.0


def test_long_tunnel_under_a_ridge_runs_straight_from_portal_to_portal() -> None:
    # The roads climb toward both portals; what has no tension would arch 25 m high in between.
    ground = Ground(lambda x, y: np.where(np.abs(x) < 950.0, 500.0, 100.0 - 0.05 * (np.abs(x) - 1000.0) + 0.01 * x))
    spans = [(0.0, 0, 0), (300.0, 2, -1), (2300.0, 0, 0)]
    found = solve([straight((-1300.0, 0.0), (1300.0, 0.0), spans=spans)], ground)
    s, x, _, z = found.along(0)
    inside = np.abs(x) < 900.0
    assert np.abs(z[inside] - (100.0 + 0.01 * x[inside])).max() < 8.0
    assert found.grade(0, s[inside]) == pytest.approx(0.01, abs=0.03)
    assert found.z(0, 0.0) == pytest.approx(72.0, abs=0.2)


def test_structures_of_linked_roads_are_one_chord() -> None:
    # Two halves of a bridge that meet head-on, the second one drawn from its far end.
    a = straight((-200.0, 0.0), (0.0, 0.0), end_link=3, spans=[(0.0, 0, 0), (140.0, 1, 1)])
    b = straight((200.0, 0.0), (0.0, 0.0), end_link=1, spans=[(0.0, 0, 0), (140.0, 1, 1)])
    found = solve([a, b], Ground(lambda x, y: gorge(x, y) + 0.02 * x))
    for road in (0, 1):
        _, x, _, z = found.along(road)
        assert z == pytest.approx(100.0 + 0.02 * x, abs=0.05)
    assert found.grade(0, 200.0) == pytest.approx(-found.grade(1, 200.0), abs=1e-12)


def test_tunnel_that_the_edge_cuts_does_not_run_away() -> None:
    spans = [(0.0, 0, 0), (200.0, 2, -1)]
    found = solve([straight((0.0, 0.0), (2000.0, 0.0), spans=spans)], Ground(lambda x, y: 0.05 * x))
    _, _, _, z = found.along(0)
    assert z.max() < 15.0
    assert z.min() > -0.1


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


def test_clearance_that_cannot_be_met_is_told() -> None:
    # The bridge begins and ends at junctions 15 m from what it crosses, and precise heights hold all else down.
    roads = [
        straight((-15.0, 0.0), (15.0, 0.0), start=0, end=1, spans=[(0.0, 1, 1)], highway="motorway"),
        straight((0.0, -300.0), (0.0, 300.0)),
    ]
    for j, side in enumerate((-1.0, 1.0)):
        roads += [
            straight((side * (15.0 + 5.0 * abs(c)), 5.0 * c), (side * 300.0, 150.0 * c), start=j, highway="motorway")
            for c in (-1.0, 0.0, 1.0)
        ]
    ground = Ground(lambda x, y: 0.001 * x, cell_size=2.0, sigma=0.1)
    found = solve(roads, ground, [(-15.0, 0.0), (15.0, 0.0)])
    told = [item for item in found.diagnostics if item.code == "clearance"]
    assert [item.osm_id for item in told] == ["way/100"]
    assert "way/101" in told[0].message
    assert found.z(1, 300.0) > -0.8
    assert found.solution.statistics["layer_crossings_too_close"] == 1.0


def test_ring_closes_smoothly() -> None:
    ring = RoadSpec(0.0, -50.0, 0.0, 2 * np.pi * 50.0, curvature=0.02, start_link=1, end_link=0)
    found = solve([ring], PLANE)
    length = 2 * np.pi * 50.0
    assert found.z(0, 0.0) == pytest.approx(found.z(0, length), abs=1e-9)
    assert found.grade(0, 0.0) == pytest.approx(found.grade(0, length), abs=1e-9)
    _, x, y, z = found.along(0)
    assert np.abs(z - PLANE.height(x, y)).max() < 0.05


def test_loop_road_begins_and_ends_on_one_plane() -> None:
    quarter = RoadSpec(10.0, 0.0, -np.pi / 4, 60 * np.pi, curvature=0.025, start=0, end=0)
    stem = straight((-100.0, 0.0), (-8.0, 0.0), end=0)
    found = solve([quarter, stem], PLANE, [(0.0, 0.0)])
    assert_smooth(found.problem, found.solution)


def test_reversed_roads_have_the_same_heights() -> None:
    ground = Ground(lambda x, y: 3.0 * np.sin(x / 40.0) * np.cos(y / 55.0))
    ahead = solve([straight((0.0, 0.0), (300.0, 80.0), spans=[(0.0, 0, 0), (100.0, 1, 1), (130.0, 0, 0)])], ground)
    length = float(np.hypot(300.0, 80.0))
    spans = [(0.0, 0, 0), (length - 130.0, 1, 1), (length - 100.0, 0, 0)]
    back = solve([straight((300.0, 80.0), (0.0, 0.0), spans=spans)], ground)
    s = np.linspace(0.0, length, 200)
    assert ahead.z(0, s) == pytest.approx(back.z(0, length - s), abs=0.011)


def test_road_without_heights_is_filled_and_told() -> None:
    ground = Ground(lambda x, y: np.where(x < 500.0, 10.0 + 0.02 * x, 20.0), known=lambda x, y: np.asarray(x < 500.0))
    roads = [straight((0.0, 0.0), (400.0, 0.0)), straight((600.0, 0.0), (900.0, 0.0))]
    found = solve(roads, ground)
    assert found.z(1, np.linspace(0.0, 300.0, 9)) == pytest.approx(20.0, abs=0.02)
    told = [item for item in found.diagnostics if item.code == "no-height"]
    assert [(item.kind, item.osm_id) for item in told] == [(Kind.GUESSED, "way/101")]
    assert "300 m" in told[0].message
    assert found.solution.statistics["height_measured_share"] == pytest.approx(4 / 7, abs=0.02)


def test_hole_in_the_model_is_bridged_smoothly() -> None:
    ground = Ground(
        lambda x, y: np.where(np.abs(x) < 60.0, -500.0, 0.03 * x), known=lambda x, y: np.asarray(np.abs(x) >= 60.0)
    )
    found = solve([straight((-300.0, 0.0), (300.0, 0.0))], ground)
    _, x, _, z = found.along(0)
    assert z == pytest.approx(0.03 * x, abs=0.3)


def test_tunnel_alone_lies_level_at_the_height_of_the_ground() -> None:
    found = solve([straight((0.0, 0.0), (300.0, 0.0), spans=[(0.0, 2, -1)])], PLANE)
    assert found.z(0, np.linspace(0.0, 300.0, 9)) == pytest.approx(307.5, abs=0.1)
    assert found.codes() == {"no-ground"}


def test_incline_tags_count_where_heights_say_little() -> None:
    ground = Ground(lambda x, y: np.zeros(len(x)) + 0.0 * x, cell_size=10.0, sigma=8.0)
    plain = solve([straight((0.0, 0.0), (200.0, 0.0))], ground)
    tagged = solve([straight((0.0, 0.0), (200.0, 0.0), grade=0.1)], ground)
    absurd = solve([straight((0.0, 0.0), (200.0, 0.0), grade=0.9)], ground)
    assert plain.grade(0, 100.0) == pytest.approx(0.0, abs=1e-9)
    assert 0.03 < float(tagged.grade(0, 100.0)[0]) < 0.1
    assert absurd.grade(0, 100.0) == pytest.approx(0.0, abs=1e-9)
    assert absurd.codes() == {"incline"}


def with_ele(z: list[float], ground: Ground) -> tuple[FloatArray, FloatArray]:
    """Return x and z of a road of 400 m with ``ele`` at even distances."""
    roads = [straight((-200.0, 0.0), (200.0, 0.0))]
    n = len(z)
    problem = replace(
        make_problem(roads),
        ele_road=np.zeros(n, np.int64),
        ele_s=(np.arange(n) + 0.5) * 400.0 / n,
        ele_z=np.array(z, np.float64),
    )
    solution = solve_profiles(problem, ground, Diagnostics())
    s = np.linspace(0.0, 400.0, 401)
    return s - 200.0, cubic_value(solution.elevation, np.zeros(401, np.int64), s)


def test_ele_tags_count_where_there_are_no_heights() -> None:
    beyond = Ground(
        lambda x, y: np.full(len(x), 40.0), cell_size=10.0, sigma=1.0, known=lambda x, y: np.asarray(x < -100.0)
    )
    x, plain = with_ele([], beyond)
    _, tagged = with_ele([40.0, 40.0, 47.0, 54.0], beyond)
    assert plain == pytest.approx(40.0, abs=0.01)
    # The ground is a guess there, good for 30 m; a tag is good for 5 m.
    assert tagged[x < -150.0] == pytest.approx(40.0, abs=0.6)
    assert 49.0 < tagged[350] < 55.0


def test_ele_tags_hardly_count_against_heights_and_outliers_not_at_all() -> None:
    ground = Ground(lambda x, y: np.full(len(x), 40.0) + 0.01 * x, cell_size=10.0, sigma=1.0)
    plain = with_ele([], ground)[1]
    assert np.abs(with_ele([44.0, 44.0, 44.0, 44.0], ground)[1] - plain).max() < 0.5
    # 48 m: an ellipsoidal height.
    assert np.abs(with_ele([88.0, 88.0, 88.0, 88.0], ground)[1] - plain).max() < 0.05


def test_carriageways_of_one_street_are_level_with_each_other() -> None:
    # On a hillside; 3 % across over 15 m.
    ground = Ground(lambda x, y: 0.03 * y, cell_size=30.0, sigma=6.0)

    def gap(name: int) -> float:
        a = straight((-400.0, 0.0), (400.0, 0.0), oneway=1, name=name)
        b = straight((400.0, 15.0), (-400.0, 15.0), oneway=1, name=name)
        found = solve([a, b], ground)
        return float(found.z(1, 400.0)[0] - found.z(0, 400.0)[0])

    assert gap(-1) == pytest.approx(0.45, abs=0.03)
    assert 0.2 < gap(0) < 0.41


def test_steep_road_is_told_and_smooth_roads_are_not() -> None:
    ground = Ground(lambda x, y: 0.24 * x)
    found = solve([straight((0.0, 0.0), (300.0, 0.0))], ground)
    assert [item.osm_id for item in found.diagnostics if item.code == "steep"] == ["way/100"]
    assert found.solution.statistics["grade_over_class_limit_km"] == pytest.approx(0.3, abs=0.01)
    assert solve([straight((0.0, 0.0), (300.0, 0.0))], PLANE).codes() == set()


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


def test_one_sided_link_is_refused() -> None:
    problem = make_problem([straight((0.0, 0.0), (9.0, 0.0), end_link=2), straight((9.0, 0.0), (20.0, 0.0))])
    with pytest.raises(ValueError, match="symmetric"):
        solve_profiles(problem, PLANE, Diagnostics())


def test_smoothing_makes_the_profile_smoother() -> None:
    ground = Ground(lambda x, y: 0.3 * np.sin(x / 8.0), cell_size=5.0, sigma=0.5)

    def roughness(smoothing: float) -> float:
        options = ElevationOptions(smoothing=smoothing)
        found = solve([straight((0.0, 0.0), (400.0, 0.0))], ground, options=options)
        return float(np.abs(found.grade(0, np.linspace(0.0, 400.0, 500))).mean())

    assert roughness(3.0) < 0.8 * roughness(1.0)


def assert_smooth(problem: object, solution: object) -> None:
    """Assert that height and grade are continuous in every road, across links and on junctions' planes."""
    from osm2xodr.geometry.heights.elements import end_poses
    from osm2xodr.geometry.heights.solve import ProfileProblem, ProfileSolution

    assert isinstance(problem, ProfileProblem)
    assert isinstance(solution, ProfileSolution)
    e = solution.elevation
    length = lengths(problem.plan_view)
    curve = np.repeat(np.arange(len(length)), np.diff(e.start))
    inner = np.flatnonzero(np.diff(curve) == 0)
    h = e.s[inner + 1] - e.s[inner]
    before = e.a[inner] + h * (e.b[inner] + h * (e.c[inner] + h * e.d[inner]))
    slope = e.b[inner] + h * (2 * e.c[inner] + 3 * h * e.d[inner])
    assert before == pytest.approx(e.a[inner + 1], abs=1e-8)
    assert slope == pytest.approx(e.b[inner + 1], abs=1e-8)

    roads = np.repeat(np.arange(len(length)), 2)
    s = np.column_stack([np.zeros(len(length)), length]).ravel()
    z, g = cubic_value(e, roads, s), cubic_slope(e, roads, s)
    assert z == pytest.approx(solution.end_z.ravel(), abs=1e-8)
    assert g == pytest.approx(solution.end_grade.ravel(), abs=1e-8)
    link = problem.end_link.ravel()
    a = np.flatnonzero(link >= 0)
    sign = np.where((a - link[a]) % 2 == 0, -1.0, 1.0)
    assert z[a] == pytest.approx(z[link[a]], abs=1e-8)
    assert g[a] == pytest.approx(sign * g[link[a]], abs=1e-8)
    at = problem.end_junction.ravel()
    b = np.flatnonzero(at >= 0)
    x, y, hdg = (value[b] for value in end_poses(problem))
    plane, origin = solution.junction_plane[at[b]], problem.junction_xy[at[b]]
    on_plane = plane[:, 0] + plane[:, 1] * (x - origin[:, 0]) + plane[:, 2] * (y - origin[:, 1])
    # Ends are rounded to as many digits as are worth writing.
    assert z[b] == pytest.approx(on_plane, abs=1e-5)
    assert g[b] == pytest.approx(plane[:, 1] * np.cos(hdg) + plane[:, 2] * np.sin(hdg), abs=1e-6)


@st.composite
def networks(draw: st.DrawFn) -> list[RoadSpec]:
    """Draw a junction with some arms, each of one or two roads in any direction, some of them bridges."""
    arms = draw(st.integers(3, 5))
    roads: list[RoadSpec] = []
    for k in range(arms):
        angle = 2 * np.pi * k / arms + draw(st.floats(-0.3, 0.3))
        u = np.array([np.cos(angle), np.sin(angle)])
        near, middle = draw(st.floats(5.0, 15.0)), draw(st.floats(20.0, 200.0))
        structure = draw(st.sampled_from([0, 0, 0, 1, 2]))
        spans = [(0.0, 0, 0), ((middle - near) / 2, structure, structure)]
        highway = draw(st.sampled_from(["motorway", "residential", "track"]))
        reverse, more, flip = draw(st.booleans()), draw(st.booleans()), draw(st.booleans())
        index = len(roads)
        link = 2 * (index + 1) + (1 if flip else 0) if more else -1
        p, q = tuple(near * u), tuple(middle * u)
        if reverse:
            roads.append(straight(q, p, end=0, start_link=link, spans=spans, highway=highway))
        else:
            roads.append(straight(p, q, start=0, end_link=link, spans=spans, highway=highway))
        if more:
            back = 2 * index + (0 if reverse else 1)
            r = tuple((middle + draw(st.floats(0.5, 150.0))) * u)
            roads.append(straight(r, q, end_link=back) if flip else straight(q, r, start_link=back))
    return roads


@settings(max_examples=40, deadline=None, derandomize=True)
@given(networks(), st.floats(0.0, 30.0), st.sampled_from([0.0, 10.0, 30.0]))
def test_heights_and_grades_are_continuous_everywhere(roads: list[RoadSpec], size: float, cell: float) -> None:
    ground = Ground(lambda x, y: size * np.sin(x / 60.0 + 1.0) * np.cos(y / 45.0), cell_size=cell, sigma=cell / 15)
    found = solve(roads, ground, [(0.0, 0.0)])
    assert_smooth(found.problem, found.solution)
    for road in range(len(roads)):
        s, _, _, z = found.along(road)
        assert np.isfinite(z).all()
        assert np.abs(found.grade(road, s)).max() < 0.35


def test_same_problem_gives_the_same_bits() -> None:
    ground = Ground(lambda x, y: 5.0 * np.sin(x / 70.0) + 0.04 * y, cell_size=30.0, sigma=2.0)
    first, second = (solve(cross(), ground, [(0.0, 0.0)]).solution for _ in range(2))
    for name in ("s", "a", "b", "c", "d"):
        assert np.array_equal(getattr(first.elevation, name), getattr(second.elevation, name))


def test_no_roads_have_no_heights() -> None:
    found = solve([], Ground(PLANE.height, cell_size=30.0, sigma=2.0))
    assert found.solution.elevation.start.tolist() == [0]
    assert found.solution.end_z.shape == (0, 2)


def shape(name: str) -> Ground:
    return Ground(
        {
            "plane": lambda x, y: 300.0 + 0.06 * x - 0.04 * y,
            # Level to the west, climbing to the east: a mirrored or shifted surface shows.
            "ramp": lambda x, y: 300.0 + np.where(x > 0.0, 0.05 * x, 0.0),
            "paraboloid": lambda x, y: 300.0 + 1e-4 * x * x + 5e-5 * y * y,
        }[name]
    )


@pytest.mark.parametrize("name", ["plane", "ramp", "paraboloid"])
@pytest.mark.parametrize(("cell", "sigma", "allowed"), [(0.0, 0.0, 0.12), (5.0, 0.5, 0.25), (30.0, 2.0, 0.6)])
def test_shapes_are_met(name: str, cell: float, sigma: float, allowed: float) -> None:
    ground = shape(name)
    ground.cell_size, ground.sigma = cell, sigma
    roads = [straight((-500.0, -200.0), (500.0, 300.0)), straight((400.0, -400.0), (-300.0, 450.0))]
    found = solve(roads, ground)
    for road in (0, 1):
        _, x, y, z = found.along(road)
        error = np.abs(z - ground.height(x, y))
        # Where the ramp begins the ground has an edge, which noisy cells do not show.
        assert error[np.abs(x) > 5 * cell].max() < allowed
        assert error.max() < max(allowed, cell / 15)


def test_step_of_the_ground_becomes_a_passable_ramp() -> None:
    # A wall of 6 m across the road, on a laser model: the road climbs it no steeper than roads are.
    found = solve([straight((-300.0, 0.0), (300.0, 0.0))], Ground(lambda x, y: np.where(x < 0, 0.0, 6.0), 1.0, 0.15))
    s, x, _, z = found.along(0)
    assert z[x < -60.0] == pytest.approx(0.0, abs=0.35)
    assert z[x > 60.0] == pytest.approx(6.0, abs=0.35)
    assert np.abs(found.grade(0, s)).max() < 0.315


def test_roundabout_lies_in_one_tilted_plane() -> None:
    # A ring of 18 m radius in four pieces on a slope of 4 % with noise of 30 m cells.
    ground = Ground(
        lambda x, y: 50.0 + 0.04 * x + 1.5 * np.sin(x / 9.0) * np.cos(y / 11.0), cell_size=30.0, sigma=2.0
    )
    radius, quarter = 18.0, 0.5 * np.pi
    ring, nodes = [], []
    for k in range(4):
        a = k * quarter
        trim = 5.0 / radius
        p = radius * np.array([np.cos(a + trim), np.sin(a + trim)])
        length = radius * (quarter - 2 * trim)
        ring.append(RoadSpec(p[0], p[1], a + trim + quarter, length, 1 / radius, start=k, end=(k + 1) % 4, oneway=1))
        nodes.append((radius * np.cos(a), radius * np.sin(a)))
    arms = [
        straight((23.0 * np.cos(k * quarter), 23.0 * np.sin(k * quarter)),
                 (250.0 * np.cos(k * quarter), 250.0 * np.sin(k * quarter)), start=k)
        for k in range(4)
    ]  # fmt: skip
    found = solve([*ring, *arms], ground, nodes)
    places = [found.along(road) for road in range(4)]
    x, y, z = (np.concatenate([place[i] for place in places]) for i in (1, 2, 3))
    design = np.column_stack([np.ones_like(x), x, y])
    plane, *_ = np.linalg.lstsq(design, z, rcond=None)
    assert np.abs(z - design @ plane).max() < 0.12
    assert plane[1:] == pytest.approx([0.04, 0.0], abs=0.02)


def test_user_limits_hold_roads_back() -> None:
    ground = Ground(lambda x, y: 8.0 * np.tanh(x / 60.0), cell_size=10.0, sigma=1.5)
    road = [straight((-400.0, 0.0), (400.0, 0.0))]
    s = np.linspace(0.0, 800.0, 801)
    free = solve(road, ground)
    held = solve(road, ground, options=ElevationOptions(grade_limit=parse_grade_limits("residential=5%")))
    assert np.abs(free.grade(0, s)).max() > 0.1
    assert np.abs(held.grade(0, s)).max() < 1.25 * 0.05 + 0.01
    told = held.solution.report
    assert told is not None
    assert [(place.osm_way_id, place.wanted) for place in told.steep] == [(100, 0.05)]
    assert free.solution.report is not None
    assert free.solution.report.steep == ()


def test_report_names_bridges_and_what_they_cross() -> None:
    upper = [(0.0, 0, 0), (250.0, 1, 1), (350.0, 0, 0)]
    ground = Ground(lambda x, y: 0.01 * x, cell_size=10.0, sigma=1.0)
    roads = [straight((-300.0, 0.0), (300.0, 0.0), spans=upper), straight((0.0, -300.0), (0.0, 300.0))]
    found = solve(roads, ground)
    told = found.solution.report
    assert told is not None
    (bridge,) = told.structures
    assert (bridge.kind, bridge.osm_way_ids, bridge.roads) == ("bridge", (101,), (0,))
    assert bridge.length == pytest.approx(100.0)
    assert bridge.crossed_way == 103
    gap = float(found.z(0, 300.0)[0] - found.z(1, 300.0)[0])
    assert bridge.clearance == pytest.approx(gap, abs=1e-6)
    assert bridge.above_ground is not None
    assert bridge.above_ground == pytest.approx(float(found.z(0, 300.0)[0]), abs=0.3)
    assert bridge.grade == pytest.approx(np.abs(found.grade(0, np.linspace(250.0, 350.0, 400))).max(), abs=1e-3)
    assert bridge.grade_limit == 0.15
    assert told.tight == ()
    assert told.measured_share == 1.0
    assert found.solution.statistics["structures"] == 1.0


def test_report_measures_against_the_surface() -> None:
    # What the road cannot follow: a pit of 3 m over 8 m.
    ground = Ground(lambda x, y: np.where(np.abs(x) < 4.0, -3.0, 0.0) + 0.0 * x, cell_size=4.0, sigma=0.5)
    found = solve([straight((-200.0, 0.0), (200.0, 0.0))], ground)
    told = found.solution.report
    assert told is not None
    _, x, y, z = found.along(0, 0.25)
    off = z - ground.height(x, y)
    assert told.rms == pytest.approx(float(np.sqrt(np.mean(off**2))), rel=0.15)
    assert told.bias == pytest.approx(float(np.mean(off)), abs=0.02)
    assert (told.farthest[0].road, told.farthest[0].osm_way_id) == (0, 100)
    assert told.farthest[0].s == pytest.approx(200.0, abs=4.0)
    assert told.farthest[0].value == pytest.approx(float(off[np.argmax(np.abs(off))]), abs=0.3)


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
