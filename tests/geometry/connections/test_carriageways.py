"""Connecting roads keep to the carriageways of the streets inside their junction."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from street_cases import Case

from osm2xodr.curves import heading_change, lengths, pose, smallest_radius, stack_plan_views
from osm2xodr.geometry.connections.carriageways import (
    Carriageways,
    along_the_way,
    carriageways,
    keep_to_carriageways,
)
from osm2xodr.geometry.connections.defaults import OFF_CARRIAGEWAY
from osm2xodr.geometry.connections.pose_to_pose import connect, curves_apart, has_kinks
from osm2xodr.geometry.connections.street_paths import lane_paths, lay_out_paths
from osm2xodr.model import PlanView

# Four streets that meet at the origin.
CORNER = Case(
    {"w": (-60.0, 0.0), "e": (60.0, 0.0), "o": (0.0, 0.0), "s": (0.0, -60.0), "n": (0.0, 60.0)},
    {1: ("w o", ""), 2: ("o s", ""), 3: ("o n", ""), 4: ("o e", "")},
)


def corner(arm: float) -> tuple[PlanView, Carriageways]:
    """Draw the turn right from west to south, and the one back, between arms that end some way from their node, m."""
    stages = CORNER.stages()
    numbers = {(stages.way(item.entry), stages.way(item.exit)): item for item in stages.movements}
    pair = [numbers[1, 2], numbers[2, 1]]
    paths = lay_out_paths(pair, stages.ends, np.full(len(stages.ends.length), arm), lambda *_: (-1.5, -1.5))
    side = np.full(2, -1.5)
    lanes = lane_paths(paths, stages.ends.plan_view, np.arange(2), side, side)
    there = connect(*(np.array([v]) for v in (-arm, -1.5, 0.0, -1.5, -arm, -math.pi / 2)))
    back = connect(*(np.array([v]) for v in (1.5, -arm, math.pi / 2, -arm, 1.5, math.pi)))
    arms = [np.array([getattr(item, name) for item in pair], np.int64) for name in ("entry", "exit")]
    return stack_plan_views(there, back), carriageways(lanes, stages.ends, *arms)


@pytest.mark.parametrize("arm", [30.0, 40.0])
def test_wide_turns_that_leave_the_streets_turn_tighter(arm: float) -> None:
    plan, streets = corner(arm)
    rows = np.arange(2)
    # The middle of an arc between these arms lies 0.293 of its radius inside both streets.
    assert streets.beyond(plan, rows, rows)[0] == pytest.approx(1.5 + (arm - 1.5) * 0.2929 - 3.0, abs=0.3)
    drawn = keep_to_carriageways(plan, streets)
    assert streets.beyond(drawn, rows, rows).max() <= OFF_CARRIAGEWAY
    assert smallest_radius(drawn).min() >= 5.0
    assert not has_kinks(drawn).any()


@pytest.mark.parametrize("arm", [20.0, 30.0])
def test_ways_there_and_back_turn_about_one_centre(arm: float) -> None:
    """Their lanes lie 3 m apart, and keep that distance all along."""
    plan, streets = corner(arm)
    drawn = keep_to_carriageways(plan, streets)
    inner, outer = smallest_radius(drawn)
    assert outer - inner == pytest.approx(3.0, abs=1e-6)
    there, back = np.array([0]), np.array([1])
    assert curves_apart(drawn, there, drawn, back, 64)[0] == pytest.approx(3.0, abs=0.05)


def test_their_ends_stay() -> None:
    plan, streets = corner(30.0)
    drawn = keep_to_carriageways(plan, streets)
    rows = np.arange(2)
    assert lengths(drawn).min() > lengths(plan).min() + 1.0
    assert heading_change(drawn, rows) == pytest.approx(heading_change(plan, rows), abs=1e-9)
    for share in (0.0, 1.0):
        before, after = (np.array(pose(item, rows, share * lengths(item))) for item in (plan, drawn))
        assert after[:2] == pytest.approx(before[:2], abs=1e-6)


def test_turns_on_the_streets_stay_as_they_are() -> None:
    plan, streets = corner(10.0)
    drawn = keep_to_carriageways(plan, streets)
    assert lengths(drawn) == pytest.approx(lengths(plan), abs=1e-9)


@pytest.mark.parametrize("arm", [10.0, 14.0, 18.0, 22.0, 30.0])
def test_distances_are_exact_where_they_decide(arm: float) -> None:
    plan, streets = corner(arm)
    rows = np.arange(2)
    found = streets.beyond(plan, rows, rows)
    shares = np.linspace(0.02, 0.98, 25)
    x, y, _ = pose(plan, np.repeat(rows, 25), np.outer(lengths(plan), shares).ravel())
    # The arms lie along the negative halves of both axes; places on them are a metre apart.
    steps = np.arange(arm + 1)[:, None]
    apart = np.minimum(np.hypot(x + steps, y), np.hypot(x, y + steps)).min(axis=0)
    exact = apart.reshape(2, 25).max(axis=1) - streets.half
    decides = exact > OFF_CARRIAGEWAY - 0.5
    assert found[decides] == pytest.approx(exact[decides], abs=0.05)
    assert (found >= exact - 0.05).all()
    assert (found[~decides] <= OFF_CARRIAGEWAY - 0.5 + 0.05).all()


@pytest.mark.parametrize("most", [0.5, 1.0, 2.5])
def test_what_is_too_far_off_anyway_is_not_measured_to_the_end(most: float) -> None:
    plan, streets = corner(30.0)
    rows = np.arange(2)
    exact, found = streets.beyond(plan, rows, rows), streets.beyond(plan, rows, rows, most)
    kept = exact <= most
    assert (found[~kept] > most).all()
    assert found[kept].tolist() == exact[kept].tolist()


@pytest.mark.parametrize("share", [0.25, 0.6])
def test_curves_run_between_the_direct_one_and_the_way(share: float) -> None:
    """Their middle lies at that share from the one to the other, and they keep their ends."""
    plan, streets = corner(27.0)
    between, rounded = (along_the_way(plan, streets.lanes, (8.0, 18.0, item)) for item in (share, 1.0))
    middle = [np.array(pose(item, np.arange(2), lengths(item) / 2)[:2]) for item in (plan, between, rounded)]
    assert np.hypot(*(middle[2] - middle[0])).min() > 3.0
    assert middle[1] == pytest.approx(middle[0] + share * (middle[2] - middle[0]), abs=0.25)
    assert heading_change(between, np.arange(2)) == pytest.approx(heading_change(plan, np.arange(2)), abs=1e-6)
    assert not has_kinks(between).any()


def test_a_curve_that_keeps_to_the_carriageways_is_taken_however_little_the_other_one_leaves_them() -> None:
    """The direct turn of 10.3 m leaves them by 1.5 m; the largest one that leaves them by 1.25 m has about 9.4 m."""
    plan, streets = corner(11.8)
    rows = np.arange(2)
    off = streets.beyond(plan, rows, rows)[0]
    assert OFF_CARRIAGEWAY < off < OFF_CARRIAGEWAY + 0.5
    drawn = keep_to_carriageways(plan, streets)
    radius = smallest_radius(drawn)[0]
    assert 9.0 < radius < 9.6
    begin, end = (pose(plan, rows, s) for s in (np.zeros(2), lengths(plan)))
    wider = connect(*begin, *end, radius=1.05 * radius, longest=2.0)
    assert smallest_radius(wider)[0] == pytest.approx(1.05 * radius)
    assert streets.beyond(wider, rows, rows)[0] > OFF_CARRIAGEWAY
    assert OFF_CARRIAGEWAY - 0.25 < streets.beyond(drawn, rows, rows)[0] <= OFF_CARRIAGEWAY


@pytest.mark.parametrize("aside", [0.5, 1.0])
def test_carriageways_lie_along_the_lines_of_osm(aside: float) -> None:
    """The inside of the corner lies nearer to lines that are moved towards it, wherever the fitted curves lie."""
    plan, streets = corner(22.0)
    rows = np.arange(2)
    lines = replace(streets.lines, x=streets.lines.x - aside, y=streets.lines.y - aside)
    moved = replace(streets, lines=lines)
    nearer = streets.beyond(plan, rows, rows) - moved.beyond(plan, rows, rows)
    assert nearer == pytest.approx([aside, aside], abs=0.1)
