"""Connecting roads that keep to the streets inside their junction, and what OSM's ways through it measure."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from street_cases import Case, Stages

from osm2xodr.geometry.connections.pose_to_pose import connect
from osm2xodr.geometry.connections.street_paths import (
    LanePaths,
    StreetPaths,
    follow_streets,
    lane_paths,
    lay_out_paths,
)
from osm2xodr.model import PlanView


def paths_of(stages: Stages) -> tuple[StreetPaths, dict[tuple[int, int], int]]:
    """Return the paths of all movements, and their numbers by (from way, to way)."""
    numbers = {
        (stages.way(item.entry), stages.way(item.exit)): number for number, item in enumerate(stages.movements)
    }
    return lay_out_paths(
        stages.movements, stages.ends, stages.layout.trim, lambda street, along: (-1.5, -1.5)
    ), numbers


OFFSET = Case(
    {"w": (-80.0, 0.0), "a": (-4.0, 0.0), "b": (4.0, 0.0), "e": (80.0, 0.0), "s": (-4.0, -80.0), "n": (4.0, 80.0)},
    {1: ("w a", ""), 2: ("b e", ""), 3: ("s a", ""), 4: ("b n", ""), 5: ("a b", "")},
)


def test_paths_run_along_the_streets_that_they_pass() -> None:
    stages = OFFSET.stages()
    paths, numbers = paths_of(stages)
    trim = {(stages.way(end), end % 2): float(stages.layout.trim[end]) for end in range(len(stages.layout.trim))}
    straight, left, back = numbers[(1, 2)], numbers[(3, 1)], numbers[(4, 3)]
    legs = np.diff(paths.start)
    assert (legs[straight], legs[left], legs[back]) == (3, 2, 3)
    assert paths.length[straight] == pytest.approx(trim[(1, 1)] + 8.0 + trim[(2, 0)], abs=0.03)
    assert paths.length[left] == pytest.approx(trim[(3, 1)] + trim[(1, 1)], abs=0.03)
    assert paths.sharpest[straight] == pytest.approx(0.0, abs=0.01)
    assert paths.sharpest[left] == pytest.approx(math.pi / 2, abs=0.01)
    assert paths.chainage[paths.start[:-1]].tolist() == [0.0] * len(numbers)
    assert (paths.inner_right[left], paths.inner_left[left]) == (-math.inf, math.inf)
    assert (paths.inner_right[straight], paths.inner_left[straight]) == (-1.5, -1.5)
    assert not paths.on_ring.any()


def test_legs_meet_at_the_nodes() -> None:
    stages = OFFSET.stages()
    paths, numbers = paths_of(stages)
    first = int(paths.start[numbers[(4, 3)]])
    sizes = np.abs(paths.s_to - paths.s_from)[first : first + 3]
    assert paths.chainage[first : first + 3] == pytest.approx([0.0, sizes[0], sizes[0] + sizes[1]])
    # Against the inner street from its end to its start.
    assert paths.s_from[first + 1] == pytest.approx(8.0, abs=0.03)
    assert paths.s_to[first + 1] == 0.0


def test_paths_measure_the_same_to_the_last_bit_beside_any_others() -> None:
    stages = OFFSET.stages()
    every, _ = paths_of(stages)
    for number, movement in enumerate(stages.movements):
        alone = lay_out_paths([movement], stages.ends, stages.layout.trim, lambda street, along: (-1.5, -1.5))
        legs = slice(int(every.start[number]), int(every.start[number + 1]))
        assert alone.chainage.tolist() == every.chainage[legs].tolist()
        assert alone.length.tolist() == [every.length[number]]


def test_no_movements_have_no_paths() -> None:
    stages = Case({"a": (0.0, 0.0), "b": (50.0, 0.0)}, {1: ("a b", "")}).stages()
    paths, _ = paths_of(stages)
    assert paths.start.tolist() == [0]
    assert len(paths.length) == len(paths.curve) == 0


def bent(degrees: float, inner: float) -> tuple[LanePaths, PlanView]:
    """Lay out a way that bends where it enters a street of 30 m inside its junction, and the direct curve.

    The lane is 1.5 m right of the streets, but `inner` on the one inside.
    """
    angle = math.radians(degrees)
    cos, sin = math.cos(angle), math.sin(angle)
    nodes = {"w": (-60.0, 0.0), "a": (0.0, 0.0), "b": (30 * cos, 30 * sin), "e": (90 * cos, 90 * sin)}
    nodes |= {"s": (0.0, -60.0), "n": (30 * cos, 80.0)}
    stages = Case(nodes, {1: ("w a", ""), 2: ("b e", ""), 3: ("s a", ""), 4: ("b n", ""), 5: ("a b", "")}).stages()
    numbers = {(stages.way(item.entry), stages.way(item.exit)): item for item in stages.movements}
    first, second = numbers[(1, 5)], numbers[(5, 2)]
    whole = replace(first, exit=second.exit, inner=((second.entry // 2, second.entry % 2 == 1),))
    paths = lay_out_paths([whole], stages.ends, np.full(len(stages.ends.length), 8.0), lambda *_: (inner, inner))
    side = np.array([-1.5])
    lanes = lane_paths(paths, stages.ends.plan_view, np.array([0]), side, side)
    row = np.array([0])
    return lanes, connect(*lanes.at_share(row, np.array([0.0])), *lanes.at_share(row, np.array([1.0])))


@pytest.mark.parametrize(("degrees", "followed"), [(20.0, True), (27.0, True), (33.0, False), (45.0, False)])
def test_a_street_with_corners_below_30_degrees_is_followed(degrees: float, followed: bool) -> None:
    lanes, direct = bent(degrees, 4.0)
    assert (follow_streets(direct, lanes) is not direct) == followed


@pytest.mark.parametrize(("aside", "followed"), [(2.9, False), (3.1, True)])
def test_a_curve_that_strays_more_than_a_lane_follows_the_street(aside: float, followed: bool) -> None:
    lanes, direct = bent(0.0, -1.5 + aside)
    assert (follow_streets(direct, lanes) is not direct) == followed
