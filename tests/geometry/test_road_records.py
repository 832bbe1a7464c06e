"""Roads name all ways that they were made of, and what was guessed about them, even where stretches were merged."""

from __future__ import annotations

import pytest
from street_cases import Case

from osm2xodr.model import Access, LaneType, RoadMap, Rule

NODES = {"w": (-150.0, 0.0), "a": (-40.0, 0.0), "b": (-37.0, 0.0), "c": (40.0, 0.0), "e": (150.0, 0.0)}
TAGGED = "highway=secondary lanes=2 width=6 maxspeed=50 surface=asphalt"


def street(*tags: str) -> Case:
    """Return a street of four ways, the second of which is 3 m long."""
    places = ("w a", "a b", "b c", "c e")
    return Case(NODES, {7 - k: pair for k, pair in enumerate(zip(places, tags, strict=True))})


def the_road(case: Case, rule: Rule) -> RoadMap:
    road_map = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    assert len(road_map.roads) == 1
    return road_map


@pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
@pytest.mark.parametrize(
    ("tags", "sections"),
    [
        # Alike but for what no lane shows.
        ((TAGGED, f"{TAGGED} ref=B1", f"{TAGGED} name=Main", TAGGED), 1),
        # A stretch too short for a lane section of its own: the one before it takes it over. Widths begin none.
        ((TAGGED, "highway=secondary lanes=3 width=9", TAGGED, TAGGED), 1),
        # Where lanes open and end about the borders of ways that differ in more, there are sections between.
        ((TAGGED, TAGGED, "highway=secondary lanes=4 width=12", TAGGED), 5),
    ],
)
def test_all_ways_are_named_in_order(tags: tuple[str, ...], sections: int, rule: Rule) -> None:
    (road,) = the_road(street(*tags), rule).roads
    assert road.osm_way_ids == (7, 6, 5, 4)
    assert len(road.lane_sections) == sections


@pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
def test_lanes_for_cars_with_several_people_are_driven_on_and_lead_on_through_junctions(rule: Rule) -> None:
    nodes = {"w": (-100.0, 0.0), "a": (0.0, 0.0), "e": (100.0, 0.0), "s": (0.0, -100.0)}
    tags = "highway=primary oneway=yes lanes=3 turn:lanes=through|through|through;right hov:lanes=designated|yes|yes"
    ways = {1: ("w a", f"{tags} motor_vehicle:lanes=no|yes|yes"), 2: ("a e", tags), 3: ("a s", "oneway=yes")}
    case = Case(nodes, ways) if rule is Rule.RIGHT_HAND else Case(nodes, ways).mirrored()
    roads = case.build(rule).roads
    hov = {road.id: [a.id for a in road.lane_sections[0].lanes if a.access is Access.HOV] for road in roads}
    usual = 1 if rule is Rule.LEFT_HAND else -1
    through = [road for road in roads if road.junction is not None]
    assert sorted((road.osm_way_ids, hov[road.id]) for road in roads if road.junction is None) == [
        ((1,), [usual]),
        ((2,), [usual]),
        ((3,), []),
    ]
    kept = [next(a for a in road.lane_sections[0].lanes if a.id) for road in through if hov[road.id]]
    assert [(a.type, a.predecessor, a.successor) for a in kept] == [(LaneType.DRIVING, usual, usual)]
    assert len(through) == 4


def test_guesses_about_stretches_that_were_merged_are_kept() -> None:
    (sure,) = the_road(street(TAGGED, TAGGED, TAGGED, TAGGED), Rule.RIGHT_HAND).roads
    (guessed,) = the_road(street(TAGGED, "highway=secondary", TAGGED, TAGGED), Rule.RIGHT_HAND).roads
    assert guessed.osm_way_ids == (7, 6, 5, 4)
    assert set(guessed.guesses) > set(sure.guesses)
    assert guessed.guesses == tuple(sorted(guessed.guesses))


@pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
def test_sidewalks_without_width_where_a_closed_street_is_cut_lead_to_none(rule: Rule) -> None:
    # The street is cut in its middle, x = 0. It has no sidewalk from 40 m before that to 1 m beyond, too short for a
    # section of the second road's own.
    places = [("s", 0.0, -100.0), ("j", 0.0, 0.0), ("a", 60.0, 0.0), ("b", 60.0, 100.0), ("c", 40.0, 100.0)]
    places += [("d", -1.0, 100.0), ("e", -60.0, 100.0), ("f", -60.0, 0.0)]
    both, none = f"{TAGGED} name=Ring sidewalk=both", f"{TAGGED} name=Ring sidewalk=no"
    ways = {1: ("s j", "highway=secondary"), 2: ("j a b c", both), 3: ("c d", none), 4: ("d e f j", both)}
    case = Case({name: (x, y) for name, x, y in places}, ways)
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule).roads
    first, second = sorted((road for road in roads if road.name == "Ring"), key=lambda road: road.id)
    assert first.successor is not None
    assert second.predecessor is not None
    assert (first.successor.id, second.predecessor.id) == (second.id, first.id)
    before, after = first.lane_sections[-1], second.lane_sections[0]
    walks = [lane for lane in (*before.lanes, *after.lanes) if lane.type is LaneType.SIDEWALK]
    assert walks
    assert all(lane.predecessor is None for lane in after.lanes if lane.type is LaneType.SIDEWALK)
    assert all(lane.successor is None for lane in before.lanes if lane.type is LaneType.SIDEWALK)
    assert [lane.successor for lane in before.lanes if lane.type is LaneType.DRIVING] == [1, -1]
