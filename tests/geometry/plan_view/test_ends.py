"""Street ends: everything as seen outwards from the junction.

Where roads end at tight bends: before them or beyond them, never within.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from street_cases import Case, Stages

from osm2xodr.curves import lengths, pose
from osm2xodr.geometry.defaults import ARM_REACH, ARM_REACH_MOTORWAY, HALF_NARROW_LANE
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.geometry.plan_view.defaults import KERB_RADIUS, KERB_RADIUS_OTHER
from osm2xodr.geometry.plan_view.ends import outward_pose, places_clear_of_bends, trims_clear_of_bends
from osm2xodr.model import PlanView

# A T: a one-way street to the east, drawn towards the junction and away from it, and a service road to the north.
CASE = Case(
    {"w": (-60.0, 0.0), "o": (0.0, 0.0), "e": (50.0, 0.0), "n": (0.0, 40.0)},
    {1: ("w o", "oneway=yes lanes=2"), 2: ("o e", "oneway=yes lanes=2"), 3: ("o n", "highway=service")},
)
WEST, EAST, NORTH = 1, 2, 3

# A T whose stem turns off squarely 20 m from the node.
BENT = Case(
    {"w": (-80.0, 0.0), "o": (0.0, 0.0), "e": (80.0, 0.0), "c": (0.0, -20.0), "d": (60.0, -20.0)},
    {1: ("w o", ""), 2: ("o e", ""), 3: ("o c d", "highway=service width=5")},
)


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


def bend(stages: Stages, end: int) -> tuple[float, float]:
    """Return where the arc of the end's street begins and ends, m from the node."""
    plan = stages.ends.plan_view
    records = range(int(plan.start[end // 2]), int(plan.start[end // 2 + 1]))
    (arc,) = (k for k in records if plan.curvature[k] != 0)
    return float(plan.s[arc]), float(plan.s[arc] + plan.length[arc])


def ended(trim: float, least: float, can_give: float = 80.0) -> tuple[float, float, float]:
    """Return where the road ends, and where the bend begins and ends, for a trim of the stem."""
    stages = BENT.stages()
    ends = stages.ends
    end = stages.end(3, 1)
    trims = np.zeros(len(ends.length))
    trims[end] = trim
    at_least = np.zeros(len(trims))
    at_least[end] = least
    most = np.full(len(trims), can_give)
    junction = np.where(np.arange(len(trims)) == end, 0, -1)
    found = trims_clear_of_bends(replace(ends), junction, trims, at_least, most)
    return float(found[end]), *bend(stages, end)


def test_an_end_in_a_bend_moves_beyond_it() -> None:
    begin, over = ended(0.0, 0.0)[1:]
    assert ended((begin + over) / 2, (begin + over) / 2)[0] == pytest.approx(over)


def test_an_end_stays_in_a_bend_where_its_street_cannot_give_that_much() -> None:
    begin, over = ended(0.0, 0.0)[1:]
    middle = (begin + over) / 2
    assert ended(middle, middle, over - 0.01)[0] == middle
    assert ended(middle, middle, over + 0.01)[0] == pytest.approx(over)


def test_an_end_moves_back_before_a_bend_where_its_junction_needs_no_more() -> None:
    begin = ended(0.0, 0.0)[1]
    widened = begin - 2.0
    assert begin - 3.0 - 0.1 < ended(widened, 5.0)[0] <= begin - 3.0
    # Not where that is more than turns need, nor where the junction does.
    assert ended(begin + 1.0, 5.0)[0] > begin + 1.0
    assert ended(widened, widened)[0] > widened


def test_an_end_far_from_bends_stays() -> None:
    begin = ended(0.0, 0.0)[1]
    assert defaults.BEND_IN_JUNCTION > 3.0
    assert ended(begin - 3.5, 2.0)[0] == begin - 3.5


@pytest.mark.parametrize("off", [-1e-12, 0.0, 1e-12])
def test_an_end_where_a_bend_is_over_stays(off: float) -> None:
    """Whichever side of the bend's end rounding puts it on, even though there would be room before the bend."""
    over = ended(0.0, 0.0)[2]
    assert ended(over + off, 0.0)[0] == pytest.approx(over, abs=1e-9)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_end_in_a_spiral_moves_to_where_it_is_gentle_enough(side: float) -> None:
    """From a circle of 25 m radius 30 m lead to a line: lanes 3 m off want 37.5 m, 20 m before its end."""
    stages = BENT.stages()
    end = stages.end(3, 1)
    rate = np.array([0.0, -side * 0.04 / 30.0, 0.0])
    bend, length = np.array([side * 0.04, side * 0.04, 0.0]), np.array([10.0, 30.0, 60.0])
    zero, s = np.zeros(3), np.array([0.0, 10.0, 40.0])
    streets = len(stages.ends.length) // 2
    start = np.where(np.arange(streets + 1) > end // 2, 3, 0)
    plan = PlanView(start, s, zero, zero, zero, length, bend, rate)
    edge = np.full(2 * streets, 3.0 + HALF_NARROW_LANE)
    ends = replace(stages.ends, plan_view=plan, left=edge, right=-edge, length=np.full(2 * streets, 100.0))
    junction = np.where(np.arange(2 * streets) == end, 0, -1)
    trim = np.where(junction == 0, 13.0, 0.0)
    found = trims_clear_of_bends(ends, junction, trim, trim, np.full(2 * streets, 80.0))
    assert found[end] == pytest.approx(20.0)


def bent(*length: float) -> PlanView:
    """Return a line, a bend of 6 m to the left and another line, of some length, m, as one curve."""
    plain, at = np.zeros(3), np.array(length)
    return PlanView(np.array([0, 3]), np.cumsum(at) - at, plain, plain, plain, at, np.array([0.0, 1 / 6, 0.0]))


@pytest.mark.parametrize(("side", "expected"), [(None, 36.0), (0, 36.0), (-1, 36.0), (1, 50.0)])
def test_a_place_moves_off_a_bend_to_the_side_that_it_should(side: int | None, expected: float) -> None:
    """A bend lies from s = 40 to 46: places are clear 3 m before it and 3 m behind it, in steps of 2 m from 42."""
    zero, edge = np.zeros(1, np.int64), np.array([3.0])
    sides = None if side is None else np.array([side])
    place, end = np.array([42.0]), np.array([100.0])
    found = places_clear_of_bends(bent(40.0, 6.0, 54.0), zero, place, -edge, edge, end, sides)
    assert found == pytest.approx([expected])


def test_a_place_moves_to_the_other_side_where_no_other_leads_off_a_bend() -> None:
    zero, edge = np.zeros(1, np.int64), np.array([3.0])
    place, end, side = np.array([42.0]), np.array([100.0]), np.array([1])
    found = places_clear_of_bends(bent(40.0, 40.0, 20.0), zero, place, -edge, edge, end, side)
    assert found == pytest.approx([36.0])
