"""Shoulders lead on through junctions from arm to arm, or end there."""

from __future__ import annotations

import pytest
from margin_cases import built
from road_measures import RoadMeasures, assert_sound, width_at
from street_cases import Case

from osm2xodr.model import Lane, LaneType, MarginSpec, Road, RoadMap, Rule

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
WIDE, NARROW = (MarginSpec(LaneType.SHOULDER, width) for width in (2.5, 1.0))
ONE_WAY = "highway=motorway oneway=yes maxspeed=100"
# A carriageway (1) from west to east goes on as the second way; the third one leaves it at its right side.
EXIT = Case(
    {"a": (-400.0, 0.0), "o": (0.0, 0.0), "b": (400.0, 0.0), "c": (400.0, -80.0)},
    {1: ("a o", f"{ONE_WAY} lanes=3"), 2: ("o b", f"{ONE_WAY} lanes=2"), 3: ("o c", f"{ONE_WAY} lanes=1")},
)


def beside(roads: RoadMap) -> list[tuple[tuple[int, int], Road, Lane]]:
    """Return the shoulders in junctions, with the ways that their road leads from and to, but not the floor's."""
    by_id = {road.id: road for road in roads.roads}
    found = []
    for road in roads.roads:
        if road.junction is not None and road.predecessor and road.successor:
            ways = by_id[road.predecessor.id].osm_way_ids[0], by_id[road.successor.id].osm_way_ids[0]
            lanes = [lane for lane in road.lane_sections[0].lanes if lane.type is LaneType.SHOULDER]
            found += [(ways, road, lane) for lane in lanes if lane.widths[0].a or len(lane.widths) > 1]
    return found


@EITHER
def test_they_lead_to_an_exit(rule: Rule) -> None:
    """From 2.5 to 1.0 m, beside the way of cars, linked at both ends."""
    roads = built(EXIT, {1: ((), (WIDE,)), 2: ((), (WIDE,)), 3: ((), (NARROW,))}, rule)
    assert_sound(roads)
    linked = [item for item in beside(roads) if item[2].successor is not None]
    ((ways, road, lane),) = linked
    # A connecting road leads where the ids of its lanes point.
    assert set(ways) == {1, 3}
    length = RoadMeasures(roads).length(road)
    ends = [width_at(lane.widths, s) for s in (0.0, length)]
    assert ends == pytest.approx([2.5, 1.0] if ways == (1, 3) else [1.0, 2.5])
    assert lane.height == 0.0
    (inner, outer) = RoadMeasures(roads).edges(road, 0, length / 2)[lane.id]
    assert abs(outer) - abs(inner) == pytest.approx(1.75)


@EITHER
def test_they_run_out_where_the_exit_has_none(rule: Rule) -> None:
    """In a smooth step over 12 m, from where the shoulder of the arm ends."""
    roads = built(EXIT, {1: ((), (WIDE,))}, rule)
    assert_sound(roads)
    ((ways, road, lane),) = [item for item in beside(roads) if width_at(item[2].widths, 0.0) == 2.5]
    assert ways == (1, 3)
    assert (lane.predecessor, lane.successor, lane.height) == (None, None, 0.0)
    assert [width_at(lane.widths, s) for s in (0.0, 6.0, 12.0)] == pytest.approx([2.5, 1.25, 0.0], abs=0.02)
    measures = RoadMeasures(roads)
    (arm,) = (item for item in roads.roads if item.osm_way_ids == (1,))
    (strip,) = (item for item in arm.lane_sections[-1].lanes if item.type is LaneType.SHOULDER)
    places = []
    for (pose, edges), number in (
        (measures.at_end(arm, at_start=False), strip.id),
        (measures.at_end(road, at_start=True), lane.id),
    ):
        places.append([(point.x, point.y) for point in map(pose.beside, edges[number])])
    assert places[0] == [pytest.approx(place, abs=1e-6) for place in places[1]]


def test_they_do_not_cross_what_comes_in() -> None:
    """Sidewalks run on past driveways, shoulders end before them and begin behind."""
    case = Case(
        {"w": (-80.0, 0.0), "o": (0.0, 0.0), "e": (80.0, 0.0), "s": (0.0, -80.0)},
        {1: ("w o", "lanes=2"), 2: ("o e", "lanes=2"), 3: ("s o", "highway=service")},
    )
    roads = built(case, dict.fromkeys((1, 2), ((NARROW,), (NARROW,))))
    assert_sound(roads)
    assert {ways for ways, _, lane in beside(roads) if lane.successor is not None} <= {(1, 2), (2, 1)}
    measures = RoadMeasures(roads)
    for _, road, lane in beside(roads):
        if lane.successor is not None:
            y = measures.at_end(road, at_start=True)[0].y
            assert y > 0.0
