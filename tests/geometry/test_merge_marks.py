"""Road marks within splits and merges."""

from __future__ import annotations

import pytest
from street_cases import Case

from osm2xodr.model import Road, RoadMap, Rule

_FAST = "highway=motorway oneway=yes lanes=2 maxspeed=100"
_NODES = {"w": (-400.0, 0.0), "o": (0.0, 0.0), "e": (400.0, 0.0), "a": (35.0, -7.0), "b": (150.0, -14.0)}


def split(ramp: str = "", stem: str = _FAST, *, merge: bool = False) -> Case:
    """Return a carriageway from west to east, and a ramp of one lane that leaves it to the south; or the reverse."""
    ways = {1: ("w o", stem), 2: ("o e", _FAST), 3: ("o a b", f"highway=motorway_link oneway=yes lanes=1 {ramp}")}
    if merge:
        ways = {way: (" ".join(reversed(refs.split())), tags) for way, (refs, tags) in ways.items()}
    return Case(_NODES, ways)


def marks(case: Case, rule: Rule = Rule.RIGHT_HAND, country: str = "") -> dict[tuple[int, int], tuple[str, str]]:
    """Return the types of marks at the inner and the outer edge, by the way that leads on, or comes, and its lane."""
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule, country=country)
    ways = {road.id: road.osm_way_ids for road in roads.roads}
    out = {}
    for road in through(roads):
        assert road.successor is not None
        assert road.predecessor is not None
        by_id = {lane.id: lane for lane in road.lane_sections[0].lanes}
        own = by_id[-1 if rule is Rule.RIGHT_HAND else 1]
        inner, outer = by_id[0].road_mark, own.road_mark
        assert inner is not None
        assert outer is not None
        (branch,) = {*ways[road.successor.id], *ways[road.predecessor.id]} - {1}
        lane = own.predecessor if ways[road.predecessor.id] == (1,) else own.successor
        assert lane is not None
        out[branch, abs(lane)] = inner.type, outer.type
    return out


def through(roads: RoadMap) -> list[Road]:
    return [road for road in roads.roads if road.junction is not None]


@pytest.mark.parametrize("rule", list(Rule))
@pytest.mark.parametrize(
    ("merge", "expected"),
    [
        # The ramp leaves lane 2: neither has a line where they lie on each other.
        (False, {(2, 1): ("solid", "broken"), (2, 2): ("none", "none"), (3, 2): ("none", "solid")}),
        # It joins lane 1, from the other side.
        (True, {(2, 1): ("none", "broken"), (2, 2): ("none", "solid"), (3, 1): ("solid", "none")}),
    ],
)
def test_lines_run_on_between_and_beside_lanes_that_no_other_lane_crosses(
    merge: bool, expected: dict[tuple[int, int], tuple[str, str]], rule: Rule
) -> None:
    assert marks(split(merge=merge), rule) == expected


def test_a_lane_that_leaves_has_the_line_beside_it_up_to_there() -> None:
    """The third lane of the stem is that of the ramp alone."""
    stem = _FAST.replace("lanes=2", "lanes=3 turn:lanes=through|through|slight_right")
    found = marks(split(stem=stem))
    assert found[2, 1] == ("solid", "broken")
    assert found[2, 2][0] == "none"
    assert found[3, 3][1] == "solid"


def test_crossings_have_no_lines() -> None:
    nodes = {**_NODES, "n": (0.0, 60.0)}
    ways = {**split().ways, 4: ("o n", "highway=residential oneway=yes")}
    roads = Case(nodes, ways).build()
    kinds = {lane.road_mark.type for road in through(roads) for lane in road.lane_sections[0].lanes if lane.road_mark}
    assert kinds == {"none"}


def test_lines_have_the_colours_of_the_roads() -> None:
    (road,) = (
        road
        for road in through(split().build(country="US"))
        if road.lane_sections[0].lanes[-2].road_mark and road.lane_sections[0].lanes[-2].road_mark.type == "solid"
    )
    mark = road.lane_sections[0].lanes[-2].road_mark
    assert mark is not None
    assert mark.color == "yellow"
