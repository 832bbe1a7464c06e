"""Sidewalks that lead nowhere at a junction end along the kerb of its corner."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from junction_cases import CASES
from margin_cases import BOTH, TRACK, VERGE, WALK, built, is_led_on
from road_measures import RoadMeasures, assert_sound, width_at
from street_cases import Case

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import Lane, LaneType, Road, RoadMap, Rule

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
def test_what_would_fold_inside_a_turn_stays_blunt(rule: Rule) -> None:
    """Sidewalks as wide as the turns' radius have no room inside of these."""
    broad = replace(WALK, width=14.0)
    told = Diagnostics()
    assert ending(built(T, {3: ((broad,), (broad,))}, rule, diagnostics=told)) == []
    ((osm_id, said),) = reported(told)
    assert osm_id == "node/1002"
    assert said.endswith("(2 sidewalks)")


@EITHER
def test_two_end_beside_one_edge_where_their_corner_has_no_room(rule: Rule) -> None:
    """Streets that part at 8 degrees: cars that turn back swing out over both outer corners, near one arm."""
    nodes = {**T.nodes, "w": (-120.0, 0.0), "e": (120.0, 0.0), "s": (-118.8, -16.7)}
    roads = built(Case(nodes, T.ways), dict.fromkeys(T.ways, BOTH), rule)
    assert_sound(roads)
    by_arms: dict[frozenset[int], list[tuple[Road, Lane]]] = {}
    for road, lane in ending(roads):
        by_arms.setdefault(frozenset(arms(roads, road)), []).append((road, lane))
    assert set(by_arms) == {frozenset({1, 2}), frozenset({2, 3})}
    for ways, ((road, one), (same, two)) in by_arms.items():
        assert road is same
        tapers = [sorted(widths(roads, road, lane, from_way=way) for lane in (one, two)) for way in ways]
        assert [item[0] for item in tapers] == [pytest.approx([0.0] * 4, abs=1e-9)] * 2
        # Over 6 m, and over 12 m.
        assert sorted(item[1] for item in tapers) == [
            pytest.approx([2.0, 1.0, 0.0, 0.0], abs=1e-9),
            pytest.approx(smooth_step(2.0), abs=1e-9),
        ]


@pytest.mark.parametrize("degrees", [9, 10, 11, 12, 15])
def test_sidewalks_lead_past_acute_forks_or_end_on_either_hand(degrees: int) -> None:
    """Cars that turn from one arm into the other stay on the carriageway, or swing out of it on the main street."""
    angle = math.radians(degrees)
    south = -120.0 * math.cos(angle), -120.0 * math.sin(angle)
    case = Case({**T.nodes, "w": (-120.0, 0.0), "e": (120.0, 0.0), "s": south}, T.ways)
    for rule in Rule:
        roads = built(case, dict.fromkeys(T.ways, BOTH), rule)
        found = sorted(tuple(sorted(arms(roads, road))) for road, _ in ending(roads))
        assert len(found) in (0, 2)
        assert len(set(found)) <= 1


@EITHER
def test_beside_corners_that_nobody_turns_round_they_stay_blunt(rule: Rule) -> None:
    """Traffic comes from the west and from the south alone, and goes on to the east: none turns from 1 to 3."""
    one_way = f"{STREET} oneway=yes"
    case = Case(T.nodes, {1: ("w o", one_way), 2: ("o e", one_way), 3: ("s o", one_way)})
    told = Diagnostics()
    roads = built(case, {1: ((), (WALK,))}, rule, diagnostics=told)
    assert ending(roads) == []
    assert [osm_id for osm_id, _ in reported(told)] == ["node/1002"]
    # A quarter of a circle with the radius of its width, 2 m: between places 15 degrees apart, lines.
    side = -1 if rule is Rule.RIGHT_HAND else 1
    assert walk_width(roads, 1, side, 0.0) == pytest.approx(0.001, abs=1e-9)
    for degrees in (15, 30, 45, 60, 75, 90):
        turn = math.radians(degrees)
        wide = walk_width(roads, 1, side, 2.0 * (1.0 - math.cos(turn)))
        assert wide == pytest.approx(2.0 * math.sin(turn), abs=1e-6)
    assert walk_width(roads, 1, side, 3.0) == pytest.approx(2.0, abs=1e-9)


@EITHER
def test_cycle_tracks_that_nothing_continues_have_round_ends(rule: Rule) -> None:
    """Of the street from west to east only the western part has any, and that on one side behind its sidewalk."""
    near, far = (1, -1) if rule is Rule.RIGHT_HAND else (-1, 1)
    roads = built(CASES["x"].case, {1: ((VERGE, TRACK), (TRACK, WALK))}, rule)
    assert_sound(roads)
    width = [walk_width(roads, 1, near, at, LaneType.BIKING) for at in (0.0, 0.8, 1.6)]
    assert width == pytest.approx([0.001, 1.6 * math.sin(math.radians(60.0)), 1.6], abs=1e-6)
    assert walk_width(roads, 1, far, 0.0, LaneType.BIKING) == pytest.approx(1.6, abs=1e-9)


@EITHER
def test_round_ends_take_no_more_than_a_part_of_a_short_road(rule: Rule) -> None:
    one_way = f"{STREET} oneway=yes"
    nodes = {**T.nodes, "w": (-16.0, 0.0)}
    case = Case(nodes, {1: ("w o", one_way), 2: ("o e", one_way), 3: ("s o", one_way)})
    broad = replace(WALK, width=6.0)
    roads = built(case, {1: ((), (broad,))}, rule)
    (road,) = (road for road in roads.roads if road.osm_way_ids == (1,))
    length = RoadMeasures(roads).length(road)
    assert length < 20.0
    side = -1 if rule is Rule.RIGHT_HAND else 1
    assert walk_width(roads, 1, side, 0.3 * length) == pytest.approx(6.0, abs=1e-6)
    assert walk_width(roads, 1, side, 0.15 * length) == pytest.approx(6.0 * 0.75**0.5, abs=1e-6)


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
