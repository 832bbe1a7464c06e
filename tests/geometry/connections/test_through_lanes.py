"""Lanes lead straight on where others open beside them, and through junctions.

They narrow towards junctions where the roads through them are too short for the change.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from road_measures import RoadMeasures, assert_sound, profile_value
from street_cases import Case

from osm2xodr.geometry import defaults
from osm2xodr.geometry.connections.connecting_roads import (
    ConnectingRoads,
    build_connecting_roads,
    redraw_connecting_roads,
)
from osm2xodr.geometry.connections.lane_links import LaneLinks, LaneRow, find_lane_links
from osm2xodr.geometry.connections.through_lanes import _reachable
from osm2xodr.geometry.junctions.road_parts import cut_roads
from osm2xodr.geometry.plan_view.streets import fit_streets
from osm2xodr.model import LaneType, RoadMap, Rule


def a_right_turn_lane() -> Case:
    """One way from west to east: a lane for right turns opens 60 m before a junction, and is not there behind it."""
    return Case(
        {"a": (-600.0, 0.0), "b": (-60.0, 0.0), "c": (0.0, 0.0), "d": (600.0, 0.0), "s": (0.0, -80.0)},
        {
            1: ("a b", "highway=secondary oneway=yes lanes=2 width=6 maxspeed=50"),
            2: ("b c", "highway=secondary oneway=yes lanes=3 width=9 turn:lanes=through|through|right maxspeed=50"),
            3: ("c d", "highway=secondary oneway=yes lanes=2 width=6 maxspeed=50"),
            4: ("c s", "highway=secondary oneway=yes lanes=1 width=3"),
        },
    )


def left_edge(roads: RoadMap, way: int, s: float) -> float:
    """Return t of the left edge of a one-way road, at s from its start, or from its end if negative, m."""
    road = next(item for item in roads.roads if way in item.osm_way_ids and item.junction is None)
    measures = RoadMeasures(roads)
    s = s if s >= 0.0 else measures.length(road) + s
    section = max(k for k, item in enumerate(road.lane_sections) if item.s <= s)
    return max(t for edges in measures.edges(road, section, s).values() for t in edges)


def test_a_short_stretch_with_a_turn_lane_shifts_as_a_whole() -> None:
    """About the middle of OSM's line its lanes would lie 1.5 m left of those before and behind: 1 m is taken back."""
    roads = a_right_turn_lane().build()
    assert_sound(roads)
    assert left_edge(roads, 1, 0.0) == pytest.approx(3.0)
    assert left_edge(roads, 2, -5.0) == pytest.approx(4.5 - defaults.IN_LINE_MOST_TURNS)
    assert left_edge(roads, 3, 200.0) == pytest.approx(3.0)


def test_traffic_on_the_left_is_the_mirror_image() -> None:
    right, left = a_right_turn_lane().build(), a_right_turn_lane().mirrored().build(Rule.LEFT_HAND)
    for way, s in ((1, -70.0), (2, -5.0), (3, 0.0)):
        # Seen from the other side, the left edge is the right one.
        width = 9.0 if way == 2 else 6.0
        assert left_edge(left, way, s) == pytest.approx(width - left_edge(right, way, s), abs=1e-6)


@pytest.mark.parametrize(("beside", "kept"), [(12.0, 1.0), (8.2, 0.5), (7.75, 0.05)])
def test_the_opposite_carriageway_keeps_its_room(beside: float, kept: float) -> None:
    """A lane for left turns opens toward it: the lanes that go on would be in line if it lay farther left."""
    tags = "highway=secondary oneway=yes maxspeed=50"
    case = Case(
        {
            "a": (-600.0, 0.0), "b": (-60.0, 0.0), "c": (0.0, 0.0), "d": (600.0, 0.0), "n": (0.0, beside),
            "w": (-600.0, beside), "e": (600.0, beside), "s": (0.0, 100.0),
        },
        {
            1: ("a b", f"{tags} lanes=2 width=6"),
            2: ("b c", f"{tags} lanes=3 width=9 turn:lanes=left|through|through"),
            3: ("c d", f"{tags} lanes=2 width=6"),
            4: ("e n w", f"{tags} lanes=2 width=6"),
            5: ("c n s", "highway=secondary lanes=2 width=6"),
        },
    )  # fmt: skip
    roads = case.build()
    assert_sound(roads)
    shift = kept * defaults.IN_LINE_MOST_TURNS
    assert left_edge(roads, 2, -5.0) == pytest.approx(4.5 + shift, abs=0.02)


def test_lanes_that_are_in_line_stay() -> None:
    nodes = {"a": (-300.0, 0.0), "b": (0.0, 0.0), "c": (300.0, 0.0), "s": (0.0, -80.0)}
    ways = {k: (path, "highway=secondary") for k, path in enumerate(("a b", "b c", "b s"), start=1)}
    roads = Case(nodes, ways).build()
    main = [k for k, road in enumerate(roads.roads) if road.junction is None]
    assert all(profile_value(roads.lane_offset, k, s) == 0.0 for k in main for s in (0.0, 50.0, 250.0))


def test_ramps_are_in_line_with_ramps_alone() -> None:
    """A ramp that joins lies beside the lanes of the motorway, wherever its line begins."""
    nodes = {"a": (-900.0, 0.0), "b": (0.0, 0.0), "c": (900.0, 0.0), "r": (-150.0, -20.0)}
    ways = {
        1: ("a b", "highway=motorway oneway=yes lanes=2"),
        2: ("b c", "highway=motorway oneway=yes lanes=3"),
        3: ("r b", "highway=motorway_link oneway=yes lanes=1"),
    }
    roads = Case(nodes, ways).build()
    assert left_edge(roads, 3, -1.0) == pytest.approx(left_edge(roads, 3, 1.0))
    main = {way: left_edge(roads, way, s) for way, s in ((1, -1.0), (2, 0.0))}
    # Half of the lane that is added lies left of the line, and half of the shift on either side.
    assert main[1] - 3.75 == pytest.approx(3.75 * 1.5 - main[2], abs=0.05)
    assert main[1] - 3.75 > 0.3


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
