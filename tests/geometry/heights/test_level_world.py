"""Bridges and tunnels on a world of one height."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from elevation_helpers import Ground, RoadSpec, Solved, connector_between, make_problem, solve, straight

from osm2xodr.curves.cubics import cubic_value
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.heights import Pins, ProfileProblem, solve_profiles
from osm2xodr.geometry.heights.defaults import CLEARANCE_OTHER, RAMP_REACH
from osm2xodr.geometry.options import ElevationOptions

Z = 12.0
LEVEL = Ground(lambda x, y: np.full(len(x), Z))
BRIDGE, TUNNEL = (1, 1), (2, -1)


def crossing(structure: tuple[int, int], reach: float = 900.0) -> list[RoadSpec]:
    """Return a road from west to east, and one in five pieces from south to north that crosses it at 0, 0."""
    ends = [-reach, -reach + 50.0, -40.0, 40.0, reach - 50.0, reach]
    across = [
        straight(
            (0.0, a),
            (0.0, b),
            start_link=-1 if k == 0 else 2 * k + 1,
            end_link=-1 if k == 4 else 2 * k + 4,
            spans=((0.0, *structure),) if k == 2 else ((0.0, 0, 0),),
        )
        for k, (a, b) in enumerate(pairwise(ends))
    ]
    return [straight((-reach, 0.0), (reach, 0.0)), *across]


@pytest.mark.parametrize(("structure", "side"), [(BRIDGE, 1.0), (TUNNEL, -1.0)])
def test_they_keep_clear_of_what_they_cross(structure: tuple[int, int], side: float) -> None:
    found = solve(crossing(structure), LEVEL)
    over, along = (float(found.z(road, np.array([s]))[0]) for road, s in ((3, 40.0), (0, 900.0)))
    assert side * (over - along) == pytest.approx(CLEARANCE_OTHER, abs=0.1)
    assert found.solution.statistics["layer_crossings_too_close"] == 0.0
    assert found.solution.statistics["grade_max"] < 0.1
    assert found.solution.report is not None
    assert [item.kind for item in found.solution.report.structures] == ["bridge" if side > 0 else "tunnel"]


def test_beyond_their_ramps_all_roads_are_exactly_level() -> None:
    found = solve(crossing(BRIDGE), LEVEL)
    far = 900.0 - 50.0 - RAMP_REACH
    assert far > 0
    for road in (1, 5):
        assert found.z(road, np.linspace(0.0, 50.0, 11)).tolist() == [Z] * 11
    # The pieces beside the bridge are ramps, and end exactly where these two begin.
    assert found.solution.end_z[2].tolist()[0] == found.solution.end_z[4].tolist()[1] == Z
    assert found.solution.end_grade[2].tolist()[0] == found.solution.end_grade[4].tolist()[1] == 0.0
    assert found.z(2, np.array([0.0]))[0] == Z


@pytest.mark.parametrize(
    ("roads", "options"),
    [
        (crossing((0, 0)), ElevationOptions()),
        (crossing(BRIDGE), ElevationOptions(structures=False)),
        ([straight((-900.0, 950.0), (900.0, 950.0)), *crossing(BRIDGE)[1:]], ElevationOptions()),
    ],
    ids=["no bridge", "no structures", "nothing below"],
)
def test_all_else_is_level(roads: list[RoadSpec], options: ElevationOptions) -> None:
    solution = solve_profiles(make_problem(roads), LEVEL, Diagnostics(), options)
    assert solution.report is None
    assert set(solution.elevation.a.tolist()) == {Z}
    assert not np.any([solution.elevation.b, solution.elevation.c, solution.elevation.d])


def test_tags_of_grades_and_heights_do_not_count() -> None:
    plain = crossing(BRIDGE)
    tagged = make_problem([replace(road, grade=0.05) for road in plain])
    tagged = replace(tagged, ele_road=np.array([2]), ele_s=np.array([500.0]), ele_z=np.array([40.0]))
    without, given = (solve_profiles(item, LEVEL, Diagnostics()) for item in (make_problem(plain), tagged))
    np.testing.assert_array_equal(given.elevation.a, without.elevation.a)


def held(problem: ProfileProblem, z: float) -> Solved:
    """Return the solution with the first road held to z and level, m, in its middle."""
    pins = Pins(np.array([0]), np.array([900.0]), np.array([z]), np.array([0.0]))
    problem = replace(problem, pins=pins)
    return Solved(problem, solve_profiles(problem, LEVEL, Diagnostics()), Diagnostics())


def test_heights_at_borders_hold() -> None:
    """A neighbour's bridge, which this area does not see, may reach over the border."""
    found = held(make_problem([straight((-900.0, 0.0), (900.0, 0.0))]), Z + 0.75)
    middle = cubic_value(found.solution.elevation, np.array([0]), np.array([900.0]))
    assert middle[0] == pytest.approx(Z + 0.75, abs=1e-6)
    assert held(make_problem(crossing((0, 0))), Z).solution.report is None


def hairpin_below_a_tunnel(here: int, across: int, back: int) -> list[RoadSpec]:
    """Return two tunnels from junction 0 that both come up 300 m west of it, and one that crosses them, by layers.

    They part at so sharp an angle that they lie on each other 20 m from it, where the third one crosses them.
    """
    return [
        straight((-700.0, 0.0), (-300.0, 0.0), end_link=2),
        straight((-300.0, 0.0), (-6.0, 0.0), start_link=1, end=0, spans=[(0.0, 2, here)]),
        straight((-6.0, 1.0), (-300.0, 6.0), start=0, end_link=6, spans=[(0.0, 2, back)]),
        straight((-300.0, 6.0), (-700.0, 12.8), start_link=5),
        straight((-20.0, -600.0), (-20.0, -200.0), end_link=10),
        straight((-20.0, -200.0), (-20.0, 200.0), start_link=9, end_link=12, spans=[(0.0, 2, across)]),
        straight((-20.0, 200.0), (-20.0, 600.0), start_link=11),
    ]


@pytest.mark.parametrize("layers", [(-3, -2, -3), (-1, -2, -1), (-1, -2, -3), (-3, -2, -1)])
def test_tunnels_whose_layers_contradict_each_other_keep_clear_all_the_same(layers: tuple[int, int, int]) -> None:
    way = connector_between((-6.0, 0.0), (-6.0, 1.0), (3, 4))
    found = solve(hairpin_below_a_tunnel(*layers), LEVEL, [(0.0, 0.0)], connectors=lambda _: way)
    here, across, back = (float(found.z(road, s)[0]) for road, s in ((1, 280.0), (5, 200.0), (2, 14.0)))
    if layers[0] == layers[2]:
        # They are one surface there: the third one passes over both of them or under both of them.
        assert here == pytest.approx(back, abs=0.1)
        assert (here > across) == (layers[0] > layers[1])
        assert found.solution.statistics["grade_max"] < 0.05
    # None of them is in the air: the lower one goes deeper instead, on ramps as long as its tunnel.
    assert max(float(found.along(road)[3].max()) for road in (1, 2, 5)) < Z + 0.1
    if layers[0] == layers[2]:
        assert found.codes() == set()
    else:
        assert "clearance" in found.codes()
