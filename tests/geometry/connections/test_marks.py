"""Road marks within junctions."""

from __future__ import annotations

import math

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


_LINED = "highway=secondary maxspeed=70"
_CROSS = {"w": (-150.0, 0.0), "o": (0.0, 0.0), "e": (150.0, 0.0), "n": (0.0, 150.0), "s": (0.0, -150.0)}


def edges(case: Case, rule: Rule = Rule.RIGHT_HAND) -> dict[tuple[int, int], set[tuple[str, str]]]:
    """Return the types of marks at the inner and the outer edge of lanes, by the ways that they lead from and to."""
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    ways = {road.id: road.osm_way_ids for road in roads.roads}
    out: dict[tuple[int, int], set[tuple[str, str]]] = {}
    for road in through(roads):
        assert road.predecessor is not None
        assert road.successor is not None
        marks = {lane.id: lane.road_mark for lane in road.lane_sections[0].lanes}
        inner, outer = marks[0], marks[-1 if rule is Rule.RIGHT_HAND else 1]
        assert inner is not None
        assert outer is not None
        (before,), (behind,) = ways[road.predecessor.id], ways[road.successor.id]
        out.setdefault((before, behind), set()).add((inner.type, outer.type))
    return out


@pytest.mark.parametrize("rule", list(Rule))
def test_the_line_at_the_edge_runs_on_opposite_a_side_road_and_round_its_corners(rule: Rule) -> None:
    """West (1) to east (2), with a side road to the south (3): to the right of those who come from the west."""
    case = Case(_CROSS, {1: ("w o", _LINED), 2: ("o e", _LINED), 3: ("o s", _LINED)})
    none, outer = {("none", "none")}, {("none", "solid")}
    # Of left-hand traffic the mirror image.
    assert edges(case, rule) == {
        (1, 2): none,
        (2, 1): outer,
        (1, 3): outer,
        (3, 2): outer,
        (3, 1): none,
        (2, 3): none,
    }


def test_the_line_at_the_edge_ends_where_the_next_road_has_none() -> None:
    """Nor does it lead round the corners of a road without lines, or across its mouth."""
    unlined = f"{_LINED} lane_markings=no"
    case = Case(_CROSS, {1: ("w o", _LINED), 2: ("o e", unlined), 3: ("o s", "highway=residential")})
    assert set.union(*edges(case).values()) == {("none", "none")}


def test_lines_at_edges_do_not_cross_a_crossing() -> None:
    case = Case(_CROSS, {1: ("w o", _LINED), 2: ("o e", _LINED), 3: ("o s", _LINED), 4: ("o n", _LINED)})
    found = edges(case)
    assert all(found[way] == {("none", "none")} for way in ((1, 2), (2, 1), (3, 4), (4, 3)))


def test_the_line_along_the_inside_of_a_roundabout_is_closed() -> None:
    """It runs on where arms leave and reach the ring; the outer line does not."""
    angles = [k * math.pi / 8 for k in range(16)]
    ring = {f"r{k}": (20.0 * math.cos(angle), 20.0 * math.sin(angle)) for k, angle in enumerate(angles)}
    nodes = {**ring, "e": (150.0, 0.0), "w": (-150.0, 0.0)}
    around = " ".join([*ring, "r0"])
    case = Case(nodes, {1: (around, f"{_LINED} junction=roundabout"), 2: ("r0 e", _LINED), 3: ("r8 w", _LINED)})
    assert edges(case)[1, 1] == {("solid", "none")}


def test_lines_have_the_colours_of_the_roads() -> None:
    (road,) = (
        road
        for road in through(split().build(country="US"))
        if road.lane_sections[0].lanes[-2].road_mark and road.lane_sections[0].lanes[-2].road_mark.type == "solid"
    )
    mark = road.lane_sections[0].lanes[-2].road_mark
    assert mark is not None
    assert mark.color == "yellow"


def past(*sides: str, main: str = "highway=primary", country: str = "DE") -> set[str]:
    """Return the types of lines between both directions of a road that goes first, past side streets of these tags.

    The first one is in the south, the second one in the north.
    """
    nodes = {"w": (-90.0, 0.0), "o": (0.0, 0.0), "e": (90.0, 0.0), "s": (0.0, -60.0), "n": (0.0, 60.0)}
    ways = {1: ("w o", main), 2: ("o e", main)}
    ways |= {
        3 + k: (refs, f"highway={tags}") for k, (refs, tags) in enumerate(zip(("s o", "n o"), sides, strict=False))
    }
    roads = Case(nodes, ways).build(Rule.RIGHT_HAND, country=country)
    of_way = {road.id: set(road.osm_way_ids) for road in roads.roads}
    found = []
    for road in through(roads):
        assert road.predecessor is not None
        assert road.successor is not None
        if of_way[road.predecessor.id] | of_way[road.successor.id] == {1, 2}:
            found += [lane.road_mark for lane in road.lane_sections[0].lanes if lane.id == 0]
    assert len(found) == 2
    return {mark.type for mark in found if mark is not None}


@pytest.mark.parametrize(
    ("sides", "main", "country", "painted"),
    [
        (("residential",), "highway=primary", "DE", True),
        # In North America lines end at streets, but not at accesses of properties.
        (("residential",), "highway=primary", "US", False),
        (("service",), "highway=primary", "US", True),
        (("service", "service"), "highway=primary", "DE", True),
        # Crossings are bare, and those of equals.
        (("residential", "residential"), "highway=primary", "DE", False),
        (("primary",), "highway=primary", "DE", False),
        (("residential",), "highway=primary lane_markings=no", "DE", False),
    ],
)
def test_the_centre_line_of_a_road_that_goes_first_runs_on_past_side_streets(
    sides: tuple[str, ...], main: str, country: str, painted: bool
) -> None:
    """It is painted once, and broken: cars turn over it."""
    assert past(*sides, main=main, country=country) == ({"broken", "none"} if painted else {"none"})
