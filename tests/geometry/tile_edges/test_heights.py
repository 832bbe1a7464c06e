"""The heights that two areas have in common where roads are cut."""

from __future__ import annotations

import numpy as np
import pytest
from division_cases import EAST, WEST, borders_of, partition
from elevation_helpers import Ground, Solved, make_problem, straight

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import CoverageError
from osm2xodr.geometry.heights import ProfileProblem, solve_profiles
from osm2xodr.geometry.tile_edges.heights import with_border_heights
from osm2xodr.model import FloatArray, Partition, Surface

HILLS = Ground(lambda x, y: 20.0 * np.sin(x / 90.0) + 15.0 * np.cos(y / 70.0) + 0.02 * x, cell_size=30.0, sigma=1.5)


def solved_for(
    problem: ProfileProblem, areas: Partition, surface: Surface, border: Surface
) -> tuple[Solved, ProfileProblem]:
    borders = borders_of(problem, areas)
    diagnostics = Diagnostics()
    pinned = with_border_heights(problem, borders, lambda x, y: border, None, diagnostics)
    return Solved(pinned, solve_profiles(pinned, surface, diagnostics), diagnostics), pinned


def test_both_areas_find_the_same_height_from_different_surfaces() -> None:
    """Each area has other roads far off, and thinks otherwise of the noise."""
    common = [straight((-600.0, 40.0), (500.0, 70.0)), straight((-400.0, -100.0), (600.0, -130.0))]
    west, east = straight((-900.0, 0.0), (-700.0, 300.0)), straight((950.0, 0.0), (800.0, -300.0))
    noisy = Ground(lambda x, y: HILLS.height(x, y) + 2.0 * np.sin(x * y), cell_size=30.0, sigma=4.0)
    one, pinned = solved_for(make_problem([*common, west]), partition(WEST), HILLS, HILLS)
    other, _ = solved_for(make_problem([east, *common]), partition(EAST), noisy, HILLS)
    assert pinned.pins is not None
    assert pinned.pins.road.tolist() == [0, 1]
    for road, s in zip(pinned.pins.road.tolist(), pinned.pins.s.tolist(), strict=True):
        assert one.z(road, s)[0] == pytest.approx(other.z(road + 1, s)[0], abs=2e-3)
        assert one.grade(road, s)[0] == pytest.approx(other.grade(road + 1, s)[0], abs=3e-4)
    without = [
        Solved(make_problem(roads), solve_profiles(make_problem(roads), surface, Diagnostics()))
        for roads, surface in (([*common, west], HILLS), ([east, *common], noisy))
    ]
    s = pinned.pins.s[0]
    assert abs(without[0].z(0, s)[0] - without[1].z(1, s)[0]) > 0.05


def test_where_no_elevation_model_reaches_the_border_it_is_said() -> None:
    problem = make_problem([straight((-600.0, 40.0), (500.0, 70.0))])
    areas = partition()

    def none(x: FloatArray, y: FloatArray) -> Surface:
        raise CoverageError("nothing here")

    diagnostics = Diagnostics()
    same = with_border_heights(problem, borders_of(problem, areas), none, None, diagnostics)
    assert same is problem
    assert [item.message for item in diagnostics] == ["no elevation model reaches the border with b"]
