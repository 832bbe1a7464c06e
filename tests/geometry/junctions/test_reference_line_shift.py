"""Where a road must end in a tight bend, its reference line runs along the outer lane and its lanes stay."""

from __future__ import annotations

import numpy as np
import pytest
from street_cases import Case, Stages

from osm2xodr.curves import advance, end_curvature, lengths, pose, project
from osm2xodr.geometry import defaults
from osm2xodr.geometry.junctions.clusters import JunctionLayout
from osm2xodr.geometry.junctions.reference_line_shift import in_short_spirals, offset_curves, shift_lines_out_of_bends
from osm2xodr.geometry.junctions.road_parts import RoadParts, cut_roads
from osm2xodr.geometry.plan_view.streets import FittedStreets, fit_streets
from osm2xodr.model import PlanView, Rule

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)


def loop(size: float) -> Case:
    """Make a street that comes back to where it starts, round a ring of eight corners."""
    angle = np.deg2rad(np.arange(-135.0, 136.0, 270.0 / 6))
    ring = {f"r{k}": (size * (1 + np.cos(a)), size * np.sin(a)) for k, a in enumerate(angle)}
    nodes = {"w": (-60.0, 0.0), "o": (0.0, 0.0), **ring}
    return Case(nodes, {1: ("w o", ""), 2: (f"o {' '.join(ring)} o", "")})


def made(case: Case, rule: Rule) -> tuple[Stages, FittedStreets, JunctionLayout, RoadParts]:
    case = case if rule is Rule.RIGHT_HAND else case.mirrored()
    stages = case.stages(rule)
    fitted = fit_streets(stages.network, stages.diagnostics)
    moved, layout = shift_lines_out_of_bends(
        fitted, stages.layout, cut_roads(stages.network, fitted, stages.layout), Rule.RIGHT_HAND
    )
    return stages, moved, layout, cut_roads(stages.network, moved, layout)


def test_curves_run_beside_their_lines_and_arcs() -> None:
    """A line of 10 m and a quarter of a circle of 20 m to the left; a second curve stays."""
    quarter = 20 * np.pi / 2
    plan = PlanView(
        np.array([0, 2, 3]),
        np.array([0.0, 10.0, 0.0]),
        np.array([0.0, 10.0, 5.0]),
        np.array([0.0, 0.0, 5.0]),
        np.array([0.0, 0.0, 1.0]),
        np.array([10.0, quarter, 7.0]),
        np.array([0.0, 0.05, -0.1]),
    )
    outside = offset_curves(plan, np.array([-5.0, 0.0]))
    assert lengths(outside) == pytest.approx([10 + 25 * np.pi / 2, 7.0])
    assert outside.curvature == pytest.approx([0.0, 0.04, -0.1])
    x, y, hdg = pose(outside, np.array([0, 0, 1]), np.array([0.0, 10 + 25 * np.pi / 2, 0.0]))
    assert x == pytest.approx([0.0, 35.0, 5.0])
    assert y == pytest.approx([-5.0, 20.0, 5.0])
    assert hdg == pytest.approx([0.0, np.pi / 2, 1.0])
    inside = offset_curves(plan, np.array([5.0, 0.0]))
    assert inside.curvature[1] == pytest.approx(1 / 15)


def test_curves_that_do_not_move_stay_as_they_are_to_the_last_bit() -> None:
    lengths_m = np.array([0.1, 0.2, 0.3, 1.1, 0.7])
    straight = PlanView(
        np.array([0, 2, 5]),
        np.array([0.0, 0.1, 0.0, 0.3, 0.3 + 1.1]),
        np.zeros(5),
        np.zeros(5),
        np.zeros(5),
        lengths_m,
        np.zeros(5),
    )
    moved = offset_curves(straight, np.array([2.0, 0.0]))
    assert moved.y.tolist() == [2.0, 2.0, 0.0, 0.0, 0.0]
    assert moved.s[2:].tolist() == straight.s[2:].tolist()


def test_curves_run_beside_spirals() -> None:
    """From a line of 20 m over 30 m to a circle of 25 m radius: 3 m to its right, and in one heading."""
    rate = np.array([0.0, 0.04 / 30.0])
    zero, length = np.zeros(2), np.array([20.0, 30.0])
    plan = PlanView(np.array([0, 2]), np.array([0.0, 20.0]), np.array([0.0, 20.0]), zero, zero, length, zero, rate)
    outside = offset_curves(plan, np.array([-3.0]))
    s = np.linspace(0.0, lengths(outside)[0], 200)
    x, y, hdg = pose(outside, np.zeros(200, np.int64), s)
    _, t, _ = project(plan, np.zeros(200, np.int64), x, y)
    assert t == pytest.approx(-3.0, abs=0.05)
    assert hdg[-1] == pytest.approx(0.6, abs=1e-9)
    assert lengths(outside)[0] == pytest.approx(50.0 + 3.0 * 0.6, abs=0.02)


@pytest.mark.parametrize("aside", [2.4, -2.4])
def test_lines_beside_sharp_spirals_have_their_curvature(aside: float) -> None:
    """Into a right bend of 4.5 m and out of it: beside curvature k runs k / (1 - k d), without a step in it."""
    length, rate = np.full(2, 7.0), np.array([-0.22 / 7.0, 0.22 / 7.0])
    begin = np.zeros(1)
    middle = advance(begin, begin, begin, begin, length[:1], rate[:1])
    x, y, hdg = (np.append(begin, item) for item in middle)
    plan = PlanView(
        np.array([0, 2, 3]),
        np.array([0.0, 7.0, 0.0]),
        np.append(x, 50.0),
        np.append(y, 0.0),
        np.append(hdg, 0.0),
        np.append(length, 7.0),
        np.array([0.0, -0.22, 0.0]),
        np.append(rate, 0.03),
    )
    parts = in_short_spirals(plan, np.array([aside, 0.0]))
    assert parts.start[2] - parts.start[1] == 1
    places = np.linspace(0.0, 14.0, 57), np.zeros(57, np.int64)
    for old, new in zip(pose(plan, places[1], places[0]), pose(parts, places[1], places[0]), strict=True):
        assert new == pytest.approx(old, abs=1e-9)
    moved = offset_curves(parts, np.array([aside, 0.0]))
    for old, new in ((parts.curvature, moved.curvature), (end_curvature(parts), end_curvature(moved))):
        d = np.where(np.arange(len(old)) < parts.start[1], aside, 0.0)
        assert new == pytest.approx(old / (1.0 - old * d), rel=0.01, abs=0.001)
    steps = end_curvature(moved)[: parts.start[1] - 1] - moved.curvature[1 : parts.start[1]]
    assert np.abs(steps).max() < 0.002


@EITHER
def test_the_line_of_a_tight_loop_runs_along_its_outer_lane(rule: Rule) -> None:
    stages, moved, layout, parts = made(loop(9.0), rule)
    street = next(item.id for item in stages.network.streets if item.start == item.end)
    aside = float(moved.aside[street])
    # Two lanes of 3 m; the loop turns left with right-hand traffic, so that its outer lane lies right, about its
    # middle at 1.6 m. Three quarters of the way there do.
    assert aside == pytest.approx(-1.2 if rule is Rule.RIGHT_HAND else 1.2, abs=0.01)
    assert np.count_nonzero(moved.aside) == 1
    section = moved.pieces[street][0][2]
    assert (section.left_edge + aside, section.right_edge + aside) == pytest.approx((3.0, -3.0))
    outer = (
        section.right_edge + defaults.HALF_NARROW_LANE if aside < 0 else section.left_edge - defaults.HALF_NARROW_LANE
    )
    for road in np.flatnonzero(parts.street == street).tolist():
        part = slice(int(parts.plan_view.start[road]), int(parts.plan_view.start[road + 1]))
        assert (1 - parts.plan_view.curvature[part] * outer).max() < 1 + defaults.TIGHT_BEND
    assert layout.trim.tolist() != stages.layout.trim.tolist()


@EITHER
def test_roads_end_where_they_did(rule: Rule) -> None:
    stages, moved, layout, _ = made(loop(9.0), rule)
    before = fit_streets(stages.network, stages.diagnostics)
    for street in range(len(stages.network.streets)):
        aside = float(moved.aside[street])
        for at_end in (False, True):
            x, y, hdg = _end(before, stages.layout, street, at_end)
            moved_x, moved_y, moved_hdg = _end(moved, layout, street, at_end)
            assert moved_hdg == pytest.approx(hdg, abs=1e-9)
            assert moved_x == pytest.approx(x - aside * np.sin(hdg), abs=1e-9)
            assert moved_y == pytest.approx(y + aside * np.cos(hdg), abs=1e-9)


def _end(fitted: FittedStreets, layout: JunctionLayout, street: int, at_end: bool) -> tuple[float, float, float]:
    trim = float(layout.trim[2 * street + at_end])
    s = float(lengths(fitted.plan_view)[street]) - trim if at_end else trim
    x, y, hdg = pose(fitted.plan_view, np.array([street]), np.array([s]))
    return float(x[0]), float(y[0]), float(hdg[0])


@EITHER
def test_a_wide_loop_keeps_its_line(rule: Rule) -> None:
    stages, moved, layout, _ = made(loop(40.0), rule)
    assert not moved.aside.any()
    assert layout is stages.layout


def test_roads_cut_again_are_those_cut_anew() -> None:
    """Of roads from before only those on lines that have stayed are taken: the street's, not the loop's."""
    stages = loop(9.0).stages(Rule.RIGHT_HAND)
    fitted = fit_streets(stages.network, stages.diagnostics)
    before = cut_roads(stages.network, fitted, stages.layout)
    moved, layout = shift_lines_out_of_bends(fitted, stages.layout, before, Rule.RIGHT_HAND)
    again = cut_roads(stages.network, moved, layout, before)
    assert again.stretches == cut_roads(stages.network, moved, layout).stretches
    kept = [one is other for one, other in zip(again.stretches, before.stretches, strict=True)]
    assert kept == [aside == 0.0 for aside in moved.aside[again.street].tolist()]
    assert True in kept
    assert False in kept


def test_roads_cut_twice_from_the_same_streets_are_the_same() -> None:
    stages = loop(9.0).stages(Rule.RIGHT_HAND)
    fitted = fit_streets(stages.network, stages.diagnostics)
    before = cut_roads(stages.network, fitted, stages.layout)
    again = cut_roads(stages.network, fitted, stages.layout, before)
    assert again.pieces is before.pieces
    assert again.stretches == before.stretches
    # Those of whole streets are not worked out again.
    whole = [k for k, street in enumerate(before.street.tolist()) if before.street.tolist().count(street) == 1]
    assert whole
    assert all(again.stretches[k] is before.stretches[k] for k in whole)
