"""Heights of roads on ground of known shape."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import Ground, RoadSpec, cross, make_problem, solve, straight
from hypothesis import given, settings, strategies as st
from scipy.ndimage import gaussian_filter, map_coordinates

from osm2xodr.curves.cubics import cubic_slope, cubic_value
from osm2xodr.curves.plan_views import lengths
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.heights import ground_around, solve_profiles
from osm2xodr.geometry.heights.ground_windows import CORE
from osm2xodr.geometry.options import ElevationOptions
from osm2xodr.model import FloatArray

PLANE = Ground(lambda x, y: 300.0 + 0.025 * x - 0.015 * y)


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
    assert found.solution.junction_plane[0] == pytest.approx([300.0, 0.025, -0.015], abs=0.001)
    assert len(found.solution.elevation.s) <= 8
    assert found.solution.statistics["height_above_surface_p95_m"] < 0.01


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


def test_hole_in_the_model_is_bridged_smoothly() -> None:
    ground = Ground(
        lambda x, y: np.where(np.abs(x) < 60.0, -500.0, 0.03 * x), known=lambda x, y: np.asarray(np.abs(x) >= 60.0)
    )
    found = solve([straight((-300.0, 0.0), (300.0, 0.0))], ground)
    _, x, _, z = found.along(0)
    assert z == pytest.approx(0.03 * x, abs=0.3)


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


def test_main_roads_are_smoother() -> None:
    """The stiffer the class, the less a road follows waves of 60 m length."""
    ground = Ground(lambda x, y: 0.3 * np.sin(x / 10.0), cell_size=5.0, sigma=0.5)

    def roughness(highway: str) -> float:
        found = solve([straight((0.0, 0.0), (400.0, 0.0), highway=highway)], ground)
        return float(np.abs(found.grade(0, np.linspace(0.0, 400.0, 500))).mean())

    classes = ("motorway", "trunk", "primary", "secondary", "residential")
    found = [roughness(highway) for highway in classes]
    assert found == sorted(found)
    assert found[0] < 0.9 * found[2] < 0.9 * found[4]
    assert roughness("motorway_link") == roughness("primary_link") == found[2]
    assert roughness("secondary_link") == found[3]
    assert roughness("service") == found[4]


def rough_ground(seed: int) -> tuple[Ground, Ground]:
    """Return hills whose spectrum falls as k⁻⁴ with banks, and a model with errors as global ones have."""
    rng, cell, n = np.random.default_rng(seed), 30.0, 128
    k = np.hypot(np.fft.fftfreq(n, cell)[:, None], np.fft.rfftfreq(n, cell)[None, :]) * 2 * np.pi
    field = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((n, n))) / np.maximum(k, 2 * np.pi / 1500.0) ** 2, (n, n))
    field *= 0.04 / float(np.hypot(*np.gradient(field, cell)).std())
    field += 6.0 * np.tanh(gaussian_filter(rng.standard_normal((n, n)), 12.0) * 80.0)
    correlated = gaussian_filter(rng.standard_normal((n, n)), 1.5)
    noisy = field + rng.normal(0.0, 1.0, (n, n)) + 1.5 * correlated / correlated.std()
    return _gridded(field, cell), _gridded(noisy, cell)


def _gridded(z: FloatArray, cell: float) -> Ground:
    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        place = [np.asarray(y) / cell + 64.0, np.asarray(x) / cell + 64.0]
        return np.asarray(map_coordinates(z, place, order=1, mode="nearest"))

    return Ground(height, cell_size=cell, sigma=1.8)


@pytest.mark.parametrize("seed", [1, 3, 4])
def test_rough_hills_are_followed_closer_than_by_draping(seed: int) -> None:
    truth, model = rough_ground(seed)
    roads = [
        straight((-1200.0, y), (1200.0, y + 300.0), spans=[(0.0, 0, 0)])
        for y in (-900.0, -500.0, -100.0, 300.0, 700.0)
    ]
    found, fine = solve(roads, model), solve(roads, replace(truth, cell_size=10.0, sigma=0.3))
    errors, draped = [], []
    for road in range(len(roads)):
        s, x, y, z = found.along(road)
        wanted = fine.z(road, s)
        errors.append(z - wanted)
        draped.append(model.height(x, y) - wanted)
    ratio = np.sqrt(np.mean(np.concatenate(errors) ** 2) / np.mean(np.concatenate(draped) ** 2))
    assert ratio < 1.0


def test_dead_ends_on_steep_hills_keep_to_their_ground() -> None:
    # A hill of which the street that the dead end leaves shows nothing: it climbs at once, bends over and is level.
    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        relief = 4.0 * np.sin(np.asarray(x) / 90.0) * np.sin(np.asarray(y) / 110.0)
        return np.asarray(relief + 30.0 / (1.0 + np.exp(-(np.asarray(y) - 30.0) / 15.0)))

    roads = [
        straight((-200.0, 0.0), (-5.0, 0.0), end=0),
        straight((5.0, 0.0), (200.0, 0.0), start=0),
        straight((0.0, 5.0), (0.0, 90.0), start=0),
    ]
    found = solve(roads, Ground(height, cell_size=30.0, sigma=2.0), junctions=[(0.0, 0.0)])
    _, x, y, z = found.along(2)
    assert np.abs(z - height(x, y))[-1] < 7.0


def assert_smooth(problem: object, solution: object) -> None:
    """Assert that height and grade are continuous in every road and across links."""
    from osm2xodr.geometry.heights import ProfileProblem, ProfileSolution

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
        assert np.abs(found.grade(road, s)).max() < 0.34


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
    assert plane[1:] == pytest.approx([0.04, 0.0], abs=0.025)


# ---------------------------------------------------------------- ground that is estimated ahead


def test_what_is_estimated_ahead_does_not_depend_on_where_roads_are_expected() -> None:
    ground = Ground(lambda x, y: 5.0 * np.sin(x / 70.0) + 0.04 * y, cell_size=30.0, sigma=2.0)
    problem = make_problem(cross(), [(0.0, 0.0)])
    x, y = (np.linspace(-200.0, 200.0, 9) * f for f in (np.cos(0.3), np.sin(0.3)))
    found = [
        solve_profiles(problem, ground, Diagnostics(), None, ground_around(ground, px, py, None, (-500.0, -400.0)))
        for px, py in ((np.r_[x, -y], np.r_[y, x]), (np.array([900.0]), np.array([900.0])))
    ]
    # Windows beyond the roads change what a road's own windows fade out to.
    assert found[0].end_z == pytest.approx(found[1].end_z, abs=0.015)
    assert found[0].end_grade == pytest.approx(found[1].end_grade, abs=5e-4)


@pytest.mark.parametrize(("before", "windows"), [(39.0, 2), (41.0, 1)])
def test_ground_is_estimated_up_to_40_m_from_where_roads_are_expected(before: float, windows: int) -> None:
    """Windows have cores of a number of cells; the place lies before the border between two of them."""
    ground = Ground(lambda x, y: 0.01 * x, cell_size=30.0, sigma=2.0)
    core = CORE * 30.0
    (layer,) = ground_around(ground, np.array([core - before]), np.array([core / 2]), None, (0.0, 0.0)).layers
    assert len(layer.number) == windows


def test_ground_of_another_smoothing_is_refused() -> None:
    ground = Ground(lambda x, y: 5.0 * np.sin(x / 70.0), cell_size=30.0, sigma=2.0)
    problem = make_problem(cross(), [(0.0, 0.0)])
    ahead = ground_around(ground, np.zeros(1), np.zeros(1), ElevationOptions(smoothing=2.0))
    assert ahead.smoothing == 16.0
    assert ground_around(ground, np.zeros(1), np.zeros(1)).smoothing == 1.0
    with pytest.raises(ValueError, match="the ground must be estimated with the smoothing that the roads are"):
        solve_profiles(problem, ground, Diagnostics(), None, ahead)
