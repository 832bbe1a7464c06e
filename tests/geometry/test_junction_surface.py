"""Heights of connecting roads: equal to the roads' at their ends, to each other's where they cross."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from elevation_helpers import Ground, RoadSpec, Solved, cross, plan_view, solve, straight
from hypothesis import given, settings
from hypothesis import strategies as st

from osm2xodr.geometry.curves import cubic_slope, cubic_value, lengths
from osm2xodr.geometry.elevation import ConnectorProblem, connector_profiles
from osm2xodr.geometry.profile_system import end_poses
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
    start, end = np.array([w[0] for w in ways], np.int64), np.array([w[1] for w in ways], np.int64)
    connectors = ConnectorProblem(
        plan_view=plan_view([w[4] for w in ways]),
        junction=found.problem.end_junction.ravel()[start],
        start_end=start,
        end_end=end,
        start_t=np.array([w[2] for w in ways], np.float64),
        end_t=np.array([w[3] for w in ways], np.float64),
        half_width=np.full(len(ways), 1.6),
    )
    return Connected(connectors, *connector_profiles(found.problem, connectors, found.solution))


def lane_point(found: Solved, end: int, t: float) -> FloatArray:
    x, y, hdg = (value[end] for value in end_poses(found.problem))
    return np.array([x - t * np.sin(hdg), y + t * np.cos(hdg)])


def line(found: Solved, a: int, b: int, ta: float, tb: float) -> tuple[int, int, float, float, RoadSpec]:
    p, q = lane_point(found, a, ta), lane_point(found, b, tb)
    return a, b, ta, tb, straight((p[0], p[1]), (q[0], q[1]))


# Ends at the junction in `cross`: roads 0 and 1 end there, roads 2 and 3 start there.
ENDS = [1, 3, 4, 6]


def crossing() -> tuple[Solved, Connected]:
    found = solve(cross(trim=10.0), TILTED, [(0.0, 0.0)])
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


def test_cross_slope_is_level_at_the_ends_and_that_of_the_plane_between() -> None:
    found, made = crossing()
    length = lengths(made.connectors.plan_view)
    s = made.superelevation
    every = np.arange(4)
    assert cubic_value(s, every, np.zeros(4)) == pytest.approx(np.zeros(4), abs=1e-12)
    assert cubic_value(s, every, length) == pytest.approx(np.zeros(4), abs=1e-12)
    assert cubic_slope(s, every, length) == pytest.approx(np.zeros(4), abs=1e-12)
    plane = found.solution.junction_plane[0, 1:]
    hdg = made.connectors.plan_view.hdg
    across = -np.sin(hdg) * plane[0] + np.cos(hdg) * plane[1]
    middle = np.tan(cubic_value(s, every, 0.5 * length))
    # Half-way the plane and both arms have their say.
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
    found = solve(roads, Ground(lambda x, y: 0.25 * y + 0.1 * x), [(0.0, 0.0)])
    made = connect(found, [line(found, 1, 2, 0.0, 0.0), line(found, 1, 4, 0.0, 0.0)])
    for k, length in enumerate(lengths(made.connectors.plan_view)):
        s = np.linspace(0.0, float(length), 30)
        z = made.at(k, s)
        assert np.abs(made.slope(k, s)).max() < 0.35
        low, high = min(z[0], z[-1]), max(z[0], z[-1])
        assert z.min() > low - 0.05
        assert z.max() < high + 0.05


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
