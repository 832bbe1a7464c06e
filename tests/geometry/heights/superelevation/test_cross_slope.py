"""Superelevation from fine elevation models."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import Ground, RoadSpec, Solved, make_problem, solve, straight

from osm2xodr.curves.cubics import cubic_slope, cubic_value
from osm2xodr.curves.plan_views import lengths
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.heights import solve_profiles
from osm2xodr.geometry.options import ElevationOptions
from osm2xodr.model import CubicProfile, FloatArray

WANTED = ElevationOptions(superelevation="model")
# Falls to the south by 4 %, along a road to the east that rises by 1 %.
TILTED = Ground(lambda x, y: 300.0 + 0.01 * x + 0.04 * y, cell_size=1.0, sigma=0.1)
EAST = straight((0.0, 0.0), (800.0, 0.0), highway="motorway")


def superelevation(found: Solved) -> CubicProfile:
    assert found.solution.superelevation is not None
    return found.solution.superelevation


def cross(found: Solved, road: int, s: FloatArray) -> FloatArray:
    """Return the rise per metre to the left."""
    return np.tan(cubic_value(superelevation(found), np.full(len(s), road), s))


def wide(ground: Ground, width: float = 7.0, middle: float = 0.0) -> Solved:
    """Solve for one road to the east with a carriageway of known width."""
    problem = replace(make_problem([EAST]), span_width=np.array([width]), span_middle=np.array([middle]))
    diagnostics = Diagnostics()
    return Solved(problem, solve_profiles(problem, ground, diagnostics, WANTED), diagnostics)


def rough(seed: int, size: float) -> Ground:
    """The tilted plane with errors from cell to cell of one metre."""
    error = size * np.random.default_rng(seed).standard_normal((64, 1024))

    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        row, column = np.round(y).astype(int) % 64, np.round(x).astype(int) % 1024
        return np.asarray(TILTED.height(x, y) + error[row, column], np.float64)

    return Ground(height, cell_size=1.0, sigma=size)


def test_none_is_none() -> None:
    assert solve([EAST], TILTED, options=ElevationOptions(superelevation="none")).solution.superelevation is None


def test_a_fine_model_counts_more_than_what_is_designed() -> None:
    found = solve([replace(EAST, oneway=1)], TILTED, options=ElevationOptions())
    assert cross(found, 0, np.linspace(0.0, 800.0, 81)) == pytest.approx(np.full(81, 0.04), abs=1e-3)
    assert "crossfall" not in found.codes()


def test_plane_along_a_road_is_met() -> None:
    found = solve([EAST], TILTED, options=WANTED)
    s = np.linspace(0.0, 800.0, 81)
    assert cross(found, 0, s) == pytest.approx(np.full(81, 0.04), abs=1e-3)
    assert found.z(0, s) == pytest.approx(300.0 + 0.01 * s, abs=0.02)


@pytest.mark.parametrize("seed", range(4))
def test_noise_of_a_laser_model_is_smoothed(seed: int) -> None:
    found = wide(rough(seed, 0.05))
    s = np.linspace(0.0, 800.0, 81)
    error = cross(found, 0, s) - 0.04
    assert np.sqrt(np.mean(error**2)) < 0.003
    assert abs(np.mean(error)) < 0.001


def test_barrier_and_lorries_do_not_count() -> None:
    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        barrier = np.where(np.abs(y - 1.0) < 0.3, 0.8, 0.0)
        lorry = np.where((x % 90 < 15) & (np.abs(y + 1.2) < 1.2), 3.5, 0.0)
        return np.asarray(TILTED.height(x, y) + barrier + lorry, np.float64)

    found = wide(Ground(height, cell_size=1.0, sigma=0.1))
    assert cross(found, 0, np.linspace(0.0, 800.0, 81)) == pytest.approx(np.full(81, 0.04), abs=0.003)


@pytest.mark.parametrize(
    "ground",
    [
        replace(TILTED, cell_size=30.0, sigma=3.0),
        replace(TILTED, cell_size=5.0),
        replace(TILTED, sigma=1.0),
        replace(TILTED, covered=True),
        replace(TILTED, known=lambda x, y: np.zeros(len(x), bool)),
    ],
)
def test_models_that_do_not_show_it_give_none(ground: Ground) -> None:
    found = solve([EAST], ground, options=WANTED)
    assert superelevation(found).start.tolist() == [0, 0]
    assert "superelevation" in found.codes()


def test_streets_have_none() -> None:
    found = solve([replace(EAST, highway="residential")], TILTED, options=WANTED)
    assert superelevation(found).start.tolist() == [0, 0]
    assert "superelevation" in found.codes()


def test_roads_are_level_at_junctions() -> None:
    roads = [
        straight((-500.0, 0.0), (-10.0, 0.0), highway="motorway", end=0),
        straight((10.0, 0.0), (500.0, 0.0), highway="motorway", start=0),
        straight((0.0, -300.0), (0.0, -10.0), end=0),
    ]
    found = solve(roads, TILTED, [(0.0, 0.0)], WANTED)
    profile = superelevation(found)
    near, far = np.array([490.0, 0.0]), np.array([200.0, 290.0])
    for road in (0, 1):
        assert cubic_value(profile, np.array([road]), near[road : road + 1]) == pytest.approx([0.0], abs=1e-12)
        assert cubic_slope(profile, np.array([road]), near[road : road + 1]) == pytest.approx([0.0], abs=1e-12)
        assert cross(found, road, far[road : road + 1]) == pytest.approx([0.04], abs=0.002)
    assert np.diff(profile.start)[2] == 0


@pytest.mark.parametrize("flip", [False, True])
def test_links_share_it(flip: bool) -> None:
    first = straight((0.0, 0.0), (300.0, 0.0), highway="motorway", end_link=3 if flip else 2)
    p, q = (300.0, 0.0), (600.0, 0.0)
    second = (
        straight(q, p, highway="motorway", end_link=1) if flip else straight(p, q, highway="motorway", start_link=1)
    )
    ground = Ground(lambda x, y: (0.04 - 1e-4 * x) * y, cell_size=1.0, sigma=0.1)
    found = solve([first, second], ground, options=WANTED)
    profile = superelevation(found)
    end, touch = np.array([300.0]), np.array([300.0 if flip else 0.0])
    sign = -1.0 if flip else 1.0
    a, b = cubic_value(profile, np.array([0]), end), cubic_value(profile, np.array([1]), touch)
    assert a == pytest.approx(np.arctan(0.01), abs=1e-3)
    assert b == pytest.approx(sign * a, abs=1e-9)
    a, b = cubic_slope(profile, np.array([0]), end), cubic_slope(profile, np.array([1]), touch)
    assert a == pytest.approx(-1e-4, abs=2e-5)
    assert b == pytest.approx(a, abs=1e-9)


def test_it_ends_where_the_motorway_does() -> None:
    roads = [
        straight((0.0, 0.0), (300.0, 0.0), highway="motorway", end_link=2),
        straight((300.0, 0.0), (600.0, 0.0), highway="primary", start_link=1),
    ]
    found = solve(roads, TILTED, options=WANTED)
    profile = superelevation(found)
    assert cross(found, 0, np.array([100.0])) == pytest.approx([0.04], abs=0.002)
    assert cubic_value(profile, np.array([0]), np.array([300.0])) == pytest.approx([0.0], abs=1e-12)
    assert np.diff(profile.start)[1] == 0


def test_bridge_takes_it_over_from_the_road_on_both_sides() -> None:
    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        return np.asarray(TILTED.height(x, y) - np.where((x > 380) & (x < 420), 12.0 + 0.3 * y, 0.0), np.float64)

    road = replace(EAST, spans=((0.0, 0, 0), (380.0, 1, 1), (420.0, 0, 0)))
    found = solve([road], Ground(height, cell_size=1.0, sigma=0.1), options=WANTED)
    assert cross(found, 0, np.linspace(0.0, 800.0, 81)) == pytest.approx(np.full(81, 0.04), abs=0.002)


def test_it_is_bounded() -> None:
    found = solve([EAST], Ground(lambda x, y: 0.1 * y, cell_size=1.0, sigma=0.1), options=WANTED)
    assert cross(found, 0, np.linspace(0.0, 800.0, 81)) == pytest.approx(np.full(81, 0.08), abs=1e-5)
    steep = solve([EAST], Ground(lambda x, y: 0.5 * y, cell_size=1.0, sigma=0.1), options=WANTED)
    assert superelevation(steep).start.tolist() == [0, 0]


def test_width_of_the_carriageway_is_what_is_read() -> None:
    # Two lanes to the right of the line lean to the right; the verge beyond them falls to the left.
    ground = Ground(lambda x, y: np.where(np.abs(y + 3.5) <= 3.5, 0.025 * y, -0.1 * y), cell_size=1.0, sigma=0.1)
    found = wide(ground, middle=-3.5)
    assert cross(found, 0, np.linspace(0.0, 800.0, 81)) == pytest.approx(np.full(81, 0.025), abs=1e-3)


def test_change_of_side_between_bends_is_followed_and_joins_smoothly() -> None:
    radius = 1000.0
    left = RoadSpec(0.0, 0.0, 0.0, 600.0, curvature=1 / radius, highway="motorway")
    # Leans by 5 % toward the bend's middle.
    ground = Ground(lambda x, y: 0.05 * (np.hypot(x, y - radius) - radius), cell_size=1.0, sigma=0.1)
    found = solve([left], ground, options=WANTED)
    assert float(lengths(found.problem.plan_view)[0]) == 600.0
    assert cross(found, 0, np.linspace(0.0, 600.0, 61)) == pytest.approx(np.full(61, -0.05), abs=1e-3)


def test_readings_that_stand_out_hardly_count() -> None:
    """Every fifth one leans by 7.5 % more, by almost four standard errors."""
    ground = Ground(lambda x, y: y * np.where(x % 15.0 < 3.0, 0.115, 0.04), cell_size=1.0, sigma=0.1)
    found = solve([EAST], ground, options=WANTED)
    assert cross(found, 0, np.linspace(50.0, 750.0, 71)) == pytest.approx(np.full(71, 0.04), abs=5e-4)


@pytest.mark.parametrize(("cell", "sigma", "seen"), [(2.0, 0.4, True), (2.2, 0.4, False), (2.0, 0.6, False)])
def test_it_is_read_from_cells_of_two_metres_that_are_good_for_half_a_metre(
    cell: float, sigma: float, seen: bool
) -> None:
    found = solve([EAST], replace(TILTED, cell_size=cell, sigma=sigma), options=WANTED)
    assert (superelevation(found).start.tolist() != [0, 0]) == seen
    notes = [item.message for item in found.diagnostics if item.code == "superelevation"]
    text = "no motorway or trunk road lies on an elevation model of the ground with cells of 2 m or less: "
    assert notes == [f"{text}no superelevation was written"] * (not seen)


@pytest.mark.parametrize(("slope", "written"), [(0.119, 0.08), (-0.119, -0.08), (0.07, 0.07), (0.121, None)])
def test_it_is_8_percent_at_most_and_more_than_12_are_not_believed(slope: float, written: float | None) -> None:
    found = solve([EAST], Ground(lambda x, y: slope * y, cell_size=1.0, sigma=0.1), options=WANTED)
    if written is None:
        assert superelevation(found).start.tolist() == [0, 0]
    else:
        assert cross(found, 0, np.linspace(0.0, 800.0, 81)) == pytest.approx(np.full(81, written), abs=1e-5)


@pytest.mark.parametrize(("width", "middle", "reach"), [(7.0, 0.0, 3.0), (11.0, 2.0, 5.0), (2.0, 0.0, 1.5)])
def test_it_is_read_up_to_half_a_metre_from_the_edges(width: float, middle: float, reach: float) -> None:
    seen: list[FloatArray] = []

    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        seen.append(y)
        return np.asarray(0.04 * y)

    found = wide(Ground(height, cell_size=1.0, sigma=0.1), width, middle)
    assert cross(found, 0, np.array([400.0])) == pytest.approx([0.04], abs=1e-5)
    # The ground under the road is read beside it at most once on either side.
    across = max((np.unique(np.round(y, 6)) for y in seen), key=len)
    assert across == pytest.approx(middle + reach * np.linspace(-1.0, 1.0, 7))


def test_roads_are_level_where_no_model_shows_how_they_lean() -> None:
    """Cells of 1 m up to 400 m, of 30 m from there."""
    ground = replace(TILTED, cells=lambda x, y: np.where(x < 400.0, 1.0, 30.0))
    found = solve([EAST], ground, options=WANTED)
    assert cross(found, 0, np.linspace(0.0, 280.0, 29)) == pytest.approx(np.full(29, 0.04), abs=0.003)
    assert cross(found, 0, np.linspace(410.0, 800.0, 40)) == pytest.approx(np.zeros(40), abs=1e-9)


def test_it_stays_at_its_bound_without_a_turn() -> None:
    """The ground leans by 6 % at first and by 11 % at 200 m: from 80 m on by more than 8 %."""
    ground = Ground(lambda x, y: (0.06 + 2.5e-4 * np.minimum(x, 200.0)) * y, cell_size=1.0, sigma=0.1)
    found = solve([EAST], ground, options=WANTED)
    profile, s = superelevation(found), np.linspace(140.0, 780.0, 65)
    road = np.zeros(65, np.int64)
    assert cubic_value(profile, road, s) == pytest.approx(np.full(65, np.arctan(0.08)), abs=1e-5)
    assert cubic_slope(profile, road, s) == pytest.approx(np.zeros(65), abs=1e-6)
    before = np.array([40.0])
    assert cross(found, 0, before) == pytest.approx([0.07], abs=1e-3)
    assert cubic_slope(profile, road[:1], before) == pytest.approx([2.5e-4], abs=3e-5)
