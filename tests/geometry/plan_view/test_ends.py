"""Street ends: everything as seen outwards from the junction."""

from __future__ import annotations

import math

import numpy as np
import pytest
from street_cases import Case

from osm2xodr.curves import lengths, pose
from osm2xodr.geometry.defaults import ARM_REACH, ARM_REACH_MOTORWAY
from osm2xodr.geometry.plan_view.defaults import KERB_RADIUS, KERB_RADIUS_OTHER
from osm2xodr.geometry.plan_view.ends import outward_pose

# A T: a one-way street to the east, drawn towards the junction and away from it, and a service road to the north.
CASE = Case(
    {"w": (-60.0, 0.0), "o": (0.0, 0.0), "e": (50.0, 0.0), "n": (0.0, 40.0)},
    {1: ("w o", "oneway=yes lanes=2"), 2: ("o e", "oneway=yes lanes=2"), 3: ("o n", "highway=service")},
)
WEST, EAST, NORTH = 1, 2, 3


def test_ends_run_outwards_from_the_junction() -> None:
    stages = CASE.stages()
    ends, at = stages.ends, [stages.end(way, 1) for way in (WEST, EAST, NORTH)]
    assert np.cos(ends.hdg[at] - [math.pi, 0.0, math.pi / 2]) == pytest.approx(1.0)
    assert ends.length[at] == pytest.approx([60.0, 50.0, 40.0], abs=0.02)
    x, y, hdg = outward_pose(ends, np.array(at), np.full(3, 10.0))
    node = stages.network.intersections[int(ends.node[at[0]])]
    assert x - node.x == pytest.approx([-10.0, 10.0, 0.0], abs=0.02)
    assert y - node.y == pytest.approx([0.0, 0.0, 10.0], abs=0.02)
    assert np.cos(hdg - ends.hdg[at]) == pytest.approx(1.0)


def test_traffic_enters_and_leaves_as_the_street_allows() -> None:
    stages = CASE.stages()
    at = [stages.end(way, 1) for way in (WEST, EAST, NORTH)]
    assert stages.ends.enters[at].tolist() == [True, False, True]
    assert stages.ends.leaves[at].tolist() == [False, True, True]


def test_left_and_right_change_places_at_the_end_of_a_street() -> None:
    ends = CASE.stages().ends
    assert (ends.left > 0).all()
    assert (ends.right < 0).all()
    assert ends.left[0::2] == pytest.approx(-ends.right[1::2])
    assert ends.right[0::2] == pytest.approx(-ends.left[1::2])


def test_kerbs_and_reach_go_by_class() -> None:
    motorway = Case({"a": (0.0, 0.0), "b": (300.0, 0.0)}, {1: ("a b", "highway=motorway")}).stages().ends
    assert motorway.reach.tolist() == [ARM_REACH_MOTORWAY] * 2
    stages = CASE.stages()
    at = [stages.end(way, 1) for way in (WEST, NORTH)]
    assert stages.ends.kerb[at].tolist() == [KERB_RADIUS_OTHER, KERB_RADIUS["service"]]
    assert stages.ends.reach[at].tolist() == [ARM_REACH] * 2


def test_lines_are_those_of_osm_with_their_corners() -> None:
    nodes = {"a": (0.0, 0.0), "b": (30.0, 0.0), "c": (30.0, 40.0), "d": (100.0, 40.0), "e": (30.0, 110.0)}
    stages = Case(nodes, {1: ("a b c", ""), 2: ("c d", ""), 3: ("c e", "")}).stages()
    lines, points = stages.ends.lines, [street.points for street in stages.network.streets]
    assert lines.start.tolist() == [0, 2, 3, 4]
    assert lengths(lines) == pytest.approx([70.0, 70.0, 70.0], abs=0.03)
    # The corner, at which the fitted curve turns with a radius, is 30 m behind the start.
    corner = np.column_stack(pose(lines, np.zeros(1, np.int64), lines.s[1:2])[:2])[0]
    assert corner == pytest.approx(points[0][1], abs=1e-9)
    x, y, _ = pose(lines, np.arange(3), lengths(lines))
    assert np.column_stack([x, y]) == pytest.approx(np.array([item[-1] for item in points]), abs=1e-9)
