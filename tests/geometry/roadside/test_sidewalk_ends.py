"""Sidewalks that lead nowhere at a junction end along the kerb of its corner."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from junction_cases import CASES
from margin_cases import BOTH, TRACK, VERGE, WALK, built, is_led_on
from road_measures import RoadMeasures, assert_sound, width_at
from street_cases import Case

from osm2xodr.curves import value_of_cubics
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import RoadOptions
from osm2xodr.geometry.road_plan import lay_out_sides, plan_roads
from osm2xodr.geometry.roadside import ends_instead
from osm2xodr.model import Lane, LaneType, Road, RoadMap, Rule
from osm2xodr.osmParsing import ParseOptions, parse_osm

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
STREET = "lanes=2 width=6"
# A street from west to east, and one from the south (3) that joins it.
T = Case(
    {"w": (-80.0, 0.0), "o": (0.0, 0.0), "e": (80.0, 0.0), "s": (0.0, -80.0)},
    {1: ("w o", STREET), 2: ("o e", STREET), 3: ("s o", STREET)},
)


def ending(roads: RoadMap) -> list[tuple[Road, Lane]]:
    """Return the sidewalks that lead from an arm to none, with their connecting roads."""
    return [
        (road, lane)
        for road in roads.roads
        if road.junction is not None
        for lane in road.lane_sections[0].lanes
        if lane.type is LaneType.SIDEWALK and not is_led_on(lane)
    ]


def walk_width(roads: RoadMap, way: int, side: int, from_end: float, kind: LaneType = LaneType.SIDEWALK) -> float:
    """Return how wide the sidewalk (or another lane) at a side of a way's road is before the road's end, m."""
    (road,) = (road for road in roads.roads if road.osm_way_ids == (way,))
    section = road.lane_sections[-1]
    (lane,) = (lane for lane in section.lanes if lane.type is kind and lane.id * side > 0)
    return width_at(lane.widths, RoadMeasures(roads).length(road) - from_end - section.s)


def reported(told: Diagnostics) -> list[tuple[str, str]]:
    """Return where sidewalks are said to end bluntly, and the text."""
    return [(item.osm_id, item.message) for item in told if item.code == "sidewalk-end"]


def arms(roads: RoadMap, road: Road) -> tuple[int, int]:
    """Return the ways that a connecting road leads from and to."""
    by_id = {item.id: item for item in roads.roads}
    before, behind = (by_id[link.id].osm_way_ids[0] for link in (road.predecessor, road.successor) if link)
    return before, behind


def widths(roads: RoadMap, road: Road, lane: Lane, *, from_way: int) -> list[float]:
    """Return how wide a lane is at the arm of a way, and 3, 6 and 12 m from it, m."""
    length = RoadMeasures(roads).length(road)
    places = (0.0, 3.0, 6.0, 12.0)
    return [width_at(lane.widths, s if arms(roads, road)[0] == from_way else length - s) for s in places]


def smooth_step(width: float) -> list[float]:
    """Return what becomes of a width over 12 m at the same places: 1 - 3 u² + 2 u³ of it, with u = s / 12 m."""
    return [width, width * (1 - 3 / 16 + 2 / 64), width / 2, 0.0]


@EITHER
def test_they_become_narrower_round_the_corner(rule: Rule) -> None:
    """In a smooth step over 12 m, a little less than the turn."""
    roads = built(T, {3: BOTH}, rule)
    assert_sound(roads)
    found = ending(roads)
    assert {frozenset(arms(roads, road)) for road, _ in found} == {frozenset({1, 3}), frozenset({2, 3})}
    assert len(found) == 2
    for road, lane in found:
        assert widths(roads, road, lane, from_way=3) == pytest.approx(smooth_step(2.0), abs=1e-9)
        assert (lane.height, lane.predecessor, lane.successor) == (0.12, None, None)
        # Right beside the lane for cars, at the kerb.
        (inner, outer) = RoadMeasures(roads).edges(road, 0, 0.0)[lane.id]
        assert abs(inner) == pytest.approx(1.5)
        assert abs(outer) == pytest.approx(3.5 if arms(roads, road)[0] == 3 else 1.5)


@EITHER
def test_they_continue_those_of_the_arm(rule: Rule) -> None:
    """Both edges are where those of the arm's sidewalk end."""
    roads = built(T, {3: ((WALK,), (VERGE, WALK))}, rule)
    measures = RoadMeasures(roads)
    (arm,) = (road for road in roads.roads if road.osm_way_ids == (3,))
    place, edges = measures.at_end(arm, at_start=False)
    kerbs = [edges[lane.id] for lane in arm.lane_sections[-1].lanes if lane.type is LaneType.SIDEWALK]
    expected = sorted((place.beside(t).x, place.beside(t).y) for pair in kerbs for t in pair)
    found = []
    for road, lane in ending(roads):
        pose, beside = measures.at_end(road, at_start=arms(roads, road)[0] == 3)
        found += [(pose.beside(t).x, pose.beside(t).y) for t in beside[lane.id]]
    assert sorted(found) == [pytest.approx(item, abs=1e-6) for item in expected]


@EITHER
def test_a_border_lies_between_as_a_verge_did(rule: Rule) -> None:
    roads = built(T, {3: ((VERGE, WALK), (VERGE, WALK))}, rule)
    assert_sound(roads)
    found = ending(roads)
    assert len(found) == 2
    for road, walk in found:
        side = 1 if walk.id > 0 else -1
        (between,) = (lane for lane in road.lane_sections[0].lanes if lane.id == walk.id - side)
        assert (between.type, between.height) == (LaneType.BORDER, 0.12)
        assert widths(roads, road, between, from_way=3) == pytest.approx(smooth_step(1.0), abs=1e-9)


@EITHER
def test_straight_on_they_end_as_soon(rule: Rule) -> None:
    """The street goes on behind a wide one, more than 15 m away, without its sidewalk."""
    one_way = f"{STREET} oneway=yes"
    case = Case(T.nodes, {1: ("w o", one_way), 2: ("o e", one_way), 3: ("s o", "lanes=4 width=20")})
    roads = built(case, {1: ((WALK,), ())}, rule)
    assert_sound(roads)
    ((road, lane),) = ending(roads)
    assert arms(roads, road) == (1, 2)
    assert RoadMeasures(roads).length(road) > 15.0
    assert widths(roads, road, lane, from_way=1) == pytest.approx(smooth_step(2.0), abs=1e-9)


def test_none_ends_where_corners_lead_on() -> None:
    for name in ("t", "x", "roundabout", "dual_cross"):
        case = CASES[name].case
        assert ending(built(case, dict.fromkeys(case.ways, BOTH if name != "dual_cross" else ((), (WALK,))))) == []


@EITHER
def test_inside_a_turn_they_reach_up_to_its_centre_at_most(rule: Rule) -> None:
    """The sidewalk of the arm, twice as wide as that, becomes as narrow before it gets there."""
    roads = built(T, {3: ((replace(WALK, width=14.0),),) * 2}, rule)
    found = ending(roads)
    assert len(found) == 2
    for road, lane in found:
        start, *_, end = widths(roads, road, lane, from_way=3)
        # Less by 0.1 m.
        assert start == pytest.approx(6.7, abs=0.01)
        assert end == pytest.approx(0.0, abs=0.002)
        side = lane.id if arms(roads, road)[0] == 3 else -lane.id
        assert walk_width(roads, 3, side, 0.0) == pytest.approx(start, abs=0.01)
        assert walk_width(roads, 3, side, 12.0) == pytest.approx(14.0, abs=0.01)


@EITHER
@pytest.mark.parametrize("verge", [1.0, 4.0, 6.0])
def test_neither_they_nor_what_lies_inside_of_them_folds(rule: Rule, verge: float) -> None:
    """Along each edge of a lane one moves on as the road does, also where its bend begins."""
    roads = built(T, {3: ((replace(VERGE, width=verge), replace(WALK, width=4.0)),) * 2}, rule)
    measures = RoadMeasures(roads)
    for road in roads.roads:
        if road.junction is not None:
            s = np.linspace(0.0, measures.length(road), 200)
            edges = [measures.edges(road, 0, at) for at in s.tolist()]
            poses = [measures.pose(road, at) for at in s.tolist()]
            for number in edges[0]:
                points = [pose.beside(pair[number][1]) for pose, pair in zip(poses, edges, strict=True)]
                for pose, a, b in zip(poses, points, points[1:], strict=False):
                    assert (b.x - a.x) * math.cos(pose.hdg) + (b.y - a.y) * math.sin(pose.hdg) > 0.0


@EITHER
@pytest.mark.parametrize("degrees", [5, 10, 15])
def test_at_acute_forks_both_go_on_beside_their_kerbs(rule: Rule, degrees: int) -> None:
    """Where cars that turn back swing out over an outer corner, each sidewalk goes on beside the ways of its arm."""
    angle = math.radians(degrees)
    south = -120.0 * math.cos(angle), -120.0 * math.sin(angle)
    case = Case({**T.nodes, "w": (-120.0, 0.0), "e": (120.0, 0.0), "s": south}, T.ways)
    roads = built(case, dict.fromkeys(T.ways, BOTH), rule)
    assert_sound(roads)
    found = ending(roads)
    assert len(found) in (2, 4)
    for road, lane in found:
        both = [width_at(lane.widths, s) for s in (0.0, RoadMeasures(roads).length(road))]
        assert sorted(both) == pytest.approx([0.0, 2.0], abs=0.01)


@EITHER
def test_beside_corners_that_nobody_turns_round_they_end_at_the_next_street(rule: Rule) -> None:
    """Traffic comes from the west and from the south alone, and goes on to the east: none turns from 1 to 3."""
    one_way = f"{STREET} oneway=yes"
    case = Case(T.nodes, {1: ("w o", one_way), 2: ("o e", one_way), 3: ("s o", one_way)})
    told = Diagnostics()
    roads = built(case, {1: ((), (WALK,))}, rule, diagnostics=told)
    assert_sound(roads)
    ((road, lane),) = ending(roads)
    assert arms(roads, road) == (1, 2)
    assert widths(roads, road, lane, from_way=1) == pytest.approx([2.0, 0.0, 0.0, 0.0], abs=1e-3)
    assert width_at(lane.widths, 1.0) == pytest.approx(2.0, abs=0.1)
    assert reported(told) == []


@EITHER
def test_without_room_they_become_narrower_before_the_junction(rule: Rule) -> None:
    """Verges wider than the radius of the turns leave no room inside of these."""
    told = Diagnostics()
    roads = built(T, {3: ((replace(VERGE, width=9.0), WALK),) * 2}, rule, diagnostics=told)
    assert_sound(roads)
    assert ending(roads) == []
    for side in (1, -1):
        wide = [walk_width(roads, 3, side, at) for at in (0.0, 3.0, 6.0, 12.0)]
        assert wide == pytest.approx([2.0 - less for less in smooth_step(2.0)], abs=0.02)
    ((osm_id, said),) = reported(told)
    assert osm_id == "node/1002"
    assert said.endswith("(2 sidewalks)")


@EITHER
def test_cycle_tracks_that_nothing_continues_become_narrower_before_the_junction(rule: Rule) -> None:
    """Of the street from west to east only the western part has any, and that on one side behind its sidewalk."""
    near, far = (1, -1) if rule is Rule.RIGHT_HAND else (-1, 1)
    roads = built(CASES["x"].case, {1: ((VERGE, TRACK), (TRACK, WALK))}, rule)
    assert_sound(roads)
    width = [walk_width(roads, 1, near, at, LaneType.BIKING) for at in (0.0, 3.0, 6.0, 12.0)]
    assert width == pytest.approx([0.001, 0.25, 0.8, 1.6], abs=0.01)
    assert walk_width(roads, 1, far, 0.0, LaneType.BIKING) == pytest.approx(1.6, abs=1e-9)


@EITHER
def test_those_that_run_out_keep_their_width_up_to_the_junction(rule: Rule) -> None:
    roads = built(T, {3: BOTH}, rule)
    assert [walk_width(roads, 3, side, 0.0) for side in (1, -1)] == pytest.approx([2.0, 2.0], abs=1e-9)


@EITHER
def test_those_that_run_out_or_lead_on_are_not_reported(rule: Rule) -> None:
    for margins in ({3: BOTH}, {1: BOTH, 2: BOTH, 3: BOTH}):
        told = Diagnostics()
        built(T, margins, rule, diagnostics=told)
        assert reported(told) == []


def test_sidewalks_of_corners_that_are_left_out_go_on_beside_lanes() -> None:
    """As wide as on their arm, and to an end, but for those of corners that nobody turns round."""
    sample = Path(__file__).parents[3] / "data" / "samples" / "andorra_ordino" / "area.osm"
    network = parse_osm(sample, ParseOptions(), Diagnostics())
    plan = plan_roads(network, RoadOptions(), Diagnostics())
    sides = lay_out_sides(network, plan)
    walks = np.array([kind is LaneType.SIDEWALK for kind in sides.corners.lane_type], bool)
    corners = sides.corners.chosen(walks)
    ends = ends_instead(plan.parts, sides.margins, plan.connecting, corners)
    arms = np.concatenate([corners.entry_width, corners.exit_width])
    assert len(corners.length) < len(ends.row) <= len(arms)
    for k in range(len(ends.row)):
        (kind, widths, height), *_ = reversed(list(ends.lanes(k, float(ends.length[k]))))
        assert (kind, height) == (LaneType.SIDEWALK, 0.12)
        begin, end = widths[0].a, value_of_cubics(widths, float(ends.length[k]))
        assert 0.1 <= max(begin, end) <= arms.max() + 1e-9
        assert min(begin, end) >= -1e-9
