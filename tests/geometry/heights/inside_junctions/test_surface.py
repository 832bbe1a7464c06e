"""Surfaces of junctions: level across at arms, smooth between them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import Ground, RoadSpec, Solved, cross, plan_view, solve, straight

from osm2xodr.geometry.heights import ConnectorProblem
from osm2xodr.geometry.heights.elements import end_poses
from osm2xodr.geometry.heights.inside_junctions.surface import JunctionSurfaces, junction_surfaces, surface_heights
from osm2xodr.model import FloatArray

TILTED = Ground(lambda x, y: 200.0 + 0.1 * x + 0.06 * y)
# Ends at the junction in `cross`: roads 0 and 1 end there, roads 2 and 3 start there.
ENDS = [1, 3, 4, 6]


def surfaces_of(found: Solved, ends: list[int], t: float = 1.6) -> JunctionSurfaces:
    """Return the surfaces where connecting roads of 3.2 m touch t and -t of arms."""
    end = np.array(ends, np.int64)
    connectors = ConnectorProblem(
        plan_view=plan_view([straight((0.0, 0.0), (1.0, 0.0))] * len(end)),
        junction=found.problem.end_junction.ravel()[end],
        start_end=end,
        end_end=end,
        start_t=np.full(len(end), t),
        end_t=np.full(len(end), -t),
        half_width=np.full(len(end), 1.6),
    )
    return junction_surfaces(found.problem, connectors, found.solution)


def at(surfaces: JunctionSurfaces, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    return surface_heights(surfaces, np.zeros(len(x), np.int64), x, y)


def test_gradient_of_the_surface_is_that_of_its_height() -> None:
    surfaces = surfaces_of(solve(cross(trim=9.0), TILTED, [(0.0, 0.0)]), ENDS)
    x, y = (np.ravel(v) for v in np.meshgrid(np.linspace(-12.0, 12.0, 25), np.linspace(-12.0, 12.0, 25)))
    h = 1e-5
    _, gx, gy = at(surfaces, x, y)
    right, left, up, down = (at(surfaces, x + dx, y + dy)[0] for dx, dy in ((h, 0.0), (-h, 0.0), (0.0, h), (0.0, -h)))
    assert gx == pytest.approx((right - left) / (2 * h), abs=1e-6)
    assert gy == pytest.approx((up - down) / (2 * h), abs=1e-6)


def test_arms_end_almost_level_on_the_surface() -> None:
    found = solve(cross(trim=9.0), TILTED, [(0.0, 0.0)])
    surfaces = surfaces_of(found, ENDS)
    z, g = found.solution.end_z.ravel(), found.solution.end_grade.ravel()
    x0, y0, hdg = end_poses(found.problem)
    plane = found.solution.junction_plane[0, 1:]
    for end in ENDS:
        t = np.linspace(-3.2, 3.2, 9)
        height, gx, gy = at(surfaces, x0[end] - t * np.sin(hdg[end]), y0[end] + t * np.cos(hdg[end]))
        tilt = -np.sin(hdg[end]) * plane[0] + np.cos(hdg[end]) * plane[1]
        # The plane would be off by 3.2 m times the tilt; a fifth of it is left to cubics at the ends.
        assert np.abs(height - z[end]).max() < 0.2 * abs(tilt) * 3.2 + 1e-6
        along = gx * np.cos(hdg[end]) + gy * np.sin(hdg[end])
        assert along == pytest.approx(np.full(9, g[end]), abs=0.015)


def test_surface_is_smoother_than_what_clings_to_its_arms() -> None:
    # Grades along the middle, from arm to arm, stay close to that of the plane.
    found = solve(cross(trim=9.0, angle=0.0), TILTED, [(0.0, 0.0)], warped=True)
    surfaces = surfaces_of(found, ENDS)
    x = np.linspace(-9.0, 9.0, 181)
    _, gx, _ = at(surfaces, x, np.zeros(181))
    plane = found.solution.junction_plane[0, 1]
    assert gx == pytest.approx(np.full(181, plane), abs=0.3 * abs(plane))
    assert np.abs(np.diff(gx)).max() / 0.1 < 0.01


def test_a_level_junction_is_a_plane() -> None:
    found = solve(cross(trim=9.0), Ground(lambda x, y: np.full(len(x), 7.0), sigma=1.0), [(0.0, 0.0)])
    x, y = np.linspace(-9.0, 9.0, 50), np.linspace(5.0, -5.0, 50)
    height, gx, gy = at(surfaces_of(found, ENDS), x, y)
    assert height == pytest.approx(np.full(50, 7.0), abs=1e-9)
    assert np.abs([gx, gy]).max() < 1e-9


def test_a_single_arm_goes_on_level_across() -> None:
    found = solve([straight((-100.0, 0.0), (0.0, 0.0), end=0)], Ground(lambda x, y: 0.05 * x), [(2.0, 0.0)])
    surfaces = surfaces_of(found, [1])
    t = np.linspace(-4.0, 4.0, 9)
    height = at(surfaces, np.full(9, 3.0), t)[0]
    assert height == pytest.approx(np.full(9, height[4]), abs=0.01)


def test_each_junction_has_its_own_surface() -> None:
    # Two equal crossings 2 km apart, of which one is shifted in height.
    roads = cross(trim=9.0)
    far = [replaced_x(road, 2000.0, 1) for road in roads]
    ground = Ground(lambda x, y: 0.1 * (x - np.where(x > 1000.0, 2000.0, 0.0)) + np.where(x > 1000.0, 30.0, 0.0))
    found = solve([*roads, *far], ground, [(0.0, 0.0), (2000.0, 0.0)])
    surfaces = surfaces_of(found, [*ENDS, *(8 + end for end in ENDS)])
    x, y = np.linspace(-8.0, 8.0, 30), np.linspace(-3.0, 3.0, 30)
    one = surface_heights(surfaces, np.zeros(30, np.int64), x, y)[0]
    other = surface_heights(surfaces, np.ones(30, np.int64), x + 2000.0, y)[0]
    assert other - 30.0 == pytest.approx(one, abs=0.02)


def replaced_x(road: RoadSpec, dx: float, junction: int) -> RoadSpec:
    """Return a road moved along x whose ends at junction 0 are at another one."""
    start, end = (junction if node == 0 else node for node in (road.start, road.end))
    return replace(road, x=road.x + dx, start=start, end=end)


def test_no_places() -> None:
    surfaces = surfaces_of(solve(cross(), TILTED, [(0.0, 0.0)]), ENDS)
    assert [len(part) for part in at(surfaces, np.zeros(0), np.zeros(0))] == [0, 0, 0]
