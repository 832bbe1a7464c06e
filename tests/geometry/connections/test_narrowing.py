"""Lanes narrow towards junctions where the roads through them are too short for the change."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from street_cases import Case

from osm2xodr.geometry.connections.connecting_roads import (
    ConnectingRoads,
    build_connecting_roads,
    redraw_connecting_roads,
)
from osm2xodr.geometry.connections.lane_links import LaneLinks, LaneRow, find_lane_links
from osm2xodr.geometry.connections.through_lanes import _reachable
from osm2xodr.geometry.junctions.road_parts import cut_roads
from osm2xodr.geometry.plan_view.streets import fit_streets
from osm2xodr.model import LaneType, Rule


def test_widths_shrink_until_tapers_lead_from_each_to_all_others() -> None:
    width = np.array([5.5, 2.5, 3.0, 4.0])
    one, other = np.array([0, 2, 3]), np.array([1, 0, 2])
    most = np.array([1.0, 0.25, 5.0])
    assert _reachable(width, one, other, most).tolist() == [3.25, 2.5, 3.0, 4.0]
    # A lane that has become narrow passes it on, along a chain.
    chain = _reachable(np.array([2.0, 5.0, 5.0]), np.array([0, 1]), np.array([1, 2]), np.array([1.0, 1.0]))
    assert chain.tolist() == [2.0, 3.0, 4.0]


@pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
def test_a_wide_lane_narrows_before_a_junction_to_narrow_ones(rule: Rule) -> None:
    """One lane of 5.5 m leads over a junction of a few metres to two of 2.5 m."""
    case = Case(
        {"a": (-80.0, 0.0), "b": (0.0, 0.0), "c": (80.0, 0.0), "d": (0.0, 60.0)},
        {
            1: ("a b", "highway=tertiary oneway=yes lanes=1 width:lanes=5.5"),
            2: ("b c", "highway=tertiary oneway=yes lanes=2 width=5"),
            3: ("b d", "highway=service oneway=yes"),
        },
    )
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    through = [road for road in roads.roads if road.junction is not None]
    for road in through:
        for lane in road.lane_sections[0].lanes:
            for cubic in lane.widths:
                # The slope of a smooth step is greatest in its middle: c^2 / (-3 d).
                assert cubic.d == 0.0 or cubic.c**2 / abs(3 * cubic.d) < 0.2
    wide = next(road for road in roads.roads if road.osm_way_ids == (1,))
    widths = [lane.widths for lane in wide.lane_sections[0].lanes if lane.id]
    assert widths[0][0].a == pytest.approx(5.5)
    # A metre before the junction the lane is as narrow as some 8 m to a lane of 2.5 m ask for, which may become 6 %
    # shorter, less a centimetre that rounding may take: 2.5 + 0.94 * 7.8 / 7.75 - 0.01 = 3.44.
    (end,) = (road.lane_sections[-1] for road in roads.roads if road is wide)
    assert [round(item.widths[-1].a, 1) for item in end.lanes if item.id] == [3.4]


@pytest.mark.parametrize("angle", [60.0, 90.0, 120.0])
def test_turns_that_become_shorter_as_lanes_narrow_do_so_by_1_in_5_at_most(angle: float) -> None:
    """Lanes of 5.5 m lead round a corner to lanes of 2 m; the way round it is shorter once they are narrower."""
    south = 80.0 * math.cos(math.radians(angle)), -80.0 * math.sin(math.radians(angle))
    wide = "highway=tertiary lanes=2 width=11"
    ways = {1: ("w o", wide), 2: ("o e", wide), 3: ("o s", "highway=service lanes=2 width=4")}
    roads = Case({"w": (-100.0, 0.0), "o": (0.0, 0.0), "e": (100.0, 0.0), "s": south}, ways).build(Rule.RIGHT_HAND)
    through = [road for road in roads.roads if road.junction is not None]
    lanes = [lane for road in through for lane in road.lane_sections[0].lanes if lane.type is LaneType.DRIVING]
    steepest = [item.c**2 / abs(3 * item.d) for lane in lanes for item in lane.widths if item.d != 0.0]
    assert len(steepest) >= 4
    assert max(steepest) < 0.2


def test_only_junctions_with_other_lane_links_are_drawn_again() -> None:
    nodes = {"w": (-80.0, 0.0), "a": (0.0, 0.0), "b": (60.0, 0.0), "e": (140.0, 0.0), "s": (0.0, -80.0)}
    nodes["n"] = (60.0, 80.0)
    ways = {1: ("w a", ""), 2: ("a b", ""), 3: ("b e", ""), 4: ("s a", ""), 5: ("b n", "")}
    stages = Case(nodes, ways).stages()
    parts = cut_roads(stages.network, fit_streets(stages.network, stages.diagnostics), stages.layout)
    before = find_lane_links(parts, stages.movements, Rule.RIGHT_HAND)
    calls: list[tuple[LaneRow, ...]] = []

    def draw(links: LaneLinks) -> ConnectingRoads:
        calls.append(links.rows)
        trim, sides = stages.layout.trim, (-1.5, 1.5)
        return build_connecting_roads(links, stages.movements, stages.ends, trim, lambda *_: sides, Rule.RIGHT_HAND)

    drawn = draw(before)
    changed = before.rows[-1].junction
    rows = [replace(row) if row.junction == changed else row for row in before.rows]
    # One link fewer, and in another junction the same ones.
    links = replace(before, rows=tuple(rows[:-1]))
    again, whole = redraw_connecting_roads(drawn, before, links, draw), draw(links)
    assert {row.junction for row in calls[1]} == {changed}
    assert len(calls[1]) == 5
    for name in ("entry", "exit", "entry_lane", "exit_lane", "length", "lane_type"):
        assert np.array_equal(getattr(again, name), getattr(whole, name))
    for name in ("start", "s", "x", "y", "hdg", "length", "curvature"):
        assert getattr(again.plan_view, name) == pytest.approx(getattr(whole.plan_view, name), abs=1e-12)
    assert len(calls) == 3
    redraw_connecting_roads(drawn, before, before, draw)
    assert len(calls) == 3
