"""Which part of which street becomes a road: dead ends that lie on each other, streets that come back."""

from __future__ import annotations

import math

import numpy as np
import pytest
from lane_cases import street
from road_measures import RoadMeasures, assert_sound
from street_cases import Case

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.junctions.road_parts import (
    RoadParts,
    _closes,
    cut_roads,
)
from osm2xodr.geometry.lanes import cross_section
from osm2xodr.geometry.plan_view import FittedStreets
from osm2xodr.geometry.plan_view.streets import fit_streets
from osm2xodr.model import PlanView, Rule

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
MAIN, RAMP = "highway=motorway oneway=yes lanes=2", "highway=motorway_link oneway=yes"


def parting(degrees: float, main: str = MAIN, ramp: str = RAMP) -> Case:
    """Make two roads that leave one node, 300 m long."""
    x, y = 300 * math.cos(math.radians(degrees)), 300 * math.sin(math.radians(degrees))
    return Case({"o": (0.0, 0.0), "e": (300.0, 0.0), "n": (x, y)}, {1: ("o e", main), 2: ("o n", ramp)})


def lengths(case: Case, rule: Rule) -> dict[int, float]:
    """Return the length of each way's road, m."""
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    assert_sound(roads)
    measures = RoadMeasures(roads)
    return {road.osm_way_ids[0]: measures.length(road) for road in roads.roads if road.junction is None}


@EITHER
@pytest.mark.parametrize("degrees", [-10.0, 8.0, 14.0])
def test_a_ramp_begins_beside_its_motorway(degrees: float, rule: Rule) -> None:
    found = lengths(parting(degrees), rule)
    assert found[1] == pytest.approx(300.0, abs=0.01)
    # Lanes of 3.5 m, two and one, and 0.3 m between: from where the ramp's inner edge is beside the motorway.
    half, angle = 3.5 + 0.3, math.radians(abs(degrees))
    apart = (half + 1.75 * math.cos(angle)) / math.sin(angle)
    assert 300.0 - found[2] == pytest.approx(apart, abs=3.0)


@EITHER
def test_dead_ends_that_go_on_beyond_each_other_keep_their_length(rule: Rule) -> None:
    found = lengths(parting(170.0), rule)
    assert (found[1], found[2]) == pytest.approx((300.0, 300.0), abs=0.01)


@EITHER
def test_halves_of_a_street_that_comes_back_have_the_same_lanes_where_they_meet(rule: Rule) -> None:
    """Way 3 is short and lies where the street would be cut in the middle."""
    nodes = {
        "w": (-90.0, 0.0),
        "o": (0.0, 0.0),
        "a": (40.0, 40.0),
        "b": (80.0, 40.0),
        "c": (86.0, 34.0),
        "d": (86.0, -34.0),
        "e": (40.0, -40.0),
    }
    wide, narrow = "highway=tertiary", "highway=unclassified"
    case = Case(nodes, {1: ("w o", wide), 2: ("o a b", wide), 3: ("b c", narrow), 4: ("c d e o", wide)})
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    assert_sound(roads)
    measures = RoadMeasures(roads)
    (one, other) = (road for road in roads.roads if road.junction is None and road.osm_way_ids != (1,))
    assert one.successor is not None
    assert (one.successor.id, one.successor.at_start) == (other.id, True)
    before, after = measures.at_end(one, False)[1], measures.at_end(other, True)[1]
    assert before.keys() == after.keys()
    assert all(before[lane] == pytest.approx(after[lane], abs=1e-9) for lane in before)
    # The short one is part of a longer stretch, and still known.
    assert {way for road in (one, other) for way in road.osm_way_ids} == {2, 3, 4}


@EITHER
@pytest.mark.parametrize(("degrees", "cut"), [(75.0, True), (155.0, True), (165.0, False)])
def test_dead_ends_lie_on_each_other_but_where_they_go_on(degrees: float, cut: bool, rule: Rule) -> None:
    assert [length < 299.0 for _, length in sorted(lengths(parting(degrees), rule).items())] == [False, cut]


# ---------------------------------------------------------------- rings

_RADIUS = 30.0
_AROUND = math.tau * _RADIUS


def cut_ring(*lanes_from: tuple[float, str]) -> RoadParts:
    """Cut a ring, a circle, whose ways 1, 2 … have lanes from some s on."""
    angles = [math.tau * k / 24 for k in range(24)]
    nodes = {f"r{k}": (_RADIUS * math.cos(a), _RADIUS * math.sin(a)) for k, a in enumerate(angles)}
    stages = Case(nodes, {1: (f"{' '.join(nodes)} r0", "")}).stages()
    items = [(s, street(text, osm_way_id=1 + k)) for k, (s, text) in enumerate(lanes_from)]
    pieces = tuple((s, item, cross_section(item, Rule.RIGHT_HAND)) for s, item in items)
    n = 24
    step = _AROUND / n
    plan = PlanView(
        np.array([0, n]),
        step * np.arange(n),
        _RADIUS * np.cos(np.array(angles)),
        _RADIUS * np.sin(np.array(angles)),
        np.array(angles) + math.pi / 2,
        np.full(n, step),
        np.full(n, 1 / _RADIUS),
    )
    return cut_roads(stages.network, FittedStreets(plan, (pieces,), np.zeros(1), np.zeros(1, bool)), stages.layout)


def spans(parts: RoadParts) -> list[list[tuple[object, ...]]]:
    """Return start, end, number of lanes and ways of all stretches of all roads."""
    return [
        [(item.start, item.end, len(item.attributes.lanes_ltr), item.ways) for item in found]
        for found in parts.stretches
    ]


def test_a_ring_becomes_two_halves_that_touch_at_both_ends() -> None:
    parts = cut_ring((0.0, "d< d>"))
    half = _AROUND / 2
    assert parts.street.tolist() == [0, 0]
    assert parts.begin.tolist() == pytest.approx([0.0, half], abs=0.02)
    assert parts.end.tolist() == pytest.approx([half, _AROUND], abs=0.02)
    assert parts.length.tolist() == pytest.approx([half, half], abs=0.02)
    assert parts.end_link.tolist() == [[3, 2], [1, 0]]
    assert parts.end_junction.tolist() == [[-1, -1], [-1, -1]]
    assert parts.road_end.tolist() == [0, 3]
    for found in spans(parts):
        assert found == [(0.0, pytest.approx(half, abs=0.02), 2, (1,))]


@pytest.mark.parametrize(("border", "lanes"), [(60.0, 3), (130.0, 2)])
def test_the_longest_stretch_takes_a_ring_whose_lanes_differ_where_it_is_closed(border: float, lanes: int) -> None:
    parts = cut_ring((0.0, "d< d>"), (border, "d< d> d>"))
    half = pytest.approx(_AROUND / 2, abs=0.02)
    assert spans(parts) == [[(0.0, half, lanes, (1, 2))], [(0.0, half, lanes, (1, 2))]]


def test_a_ring_is_cut_on_its_longest_stretch_off_its_borders() -> None:
    """Between the quarters, at 47.1 and 141.4 m, a quarter of the stretch away from where lanes open or end."""
    near = pytest.approx
    parts = cut_ring((0.0, "d< d>"), (60.0, "d< d> d>"), (150.0, "d< d>"))
    upper = 0.75 * _AROUND
    taper = 8.5 * 3.5 / 2  # On either side of a border
    cut = (60.0 + 150.0) / 2
    assert spans(parts) == [
        [(0.0, 60.0, 2, (1,)), (60.0, near(cut, abs=0.02), 3, (2,))],
        [
            (0.0, near(150.0 - cut, abs=0.02), 3, (2,)),
            (near(150.0 - cut, abs=0.02), near(_AROUND - cut, abs=0.02), 2, (3,)),
        ],
    ]
    parts = cut_ring((0.0, "d< d>"), (40.0, "d< d> d>"), (120.0, "d< d>"))
    lower = 0.25 * _AROUND
    cut = (40.0 + 120.0) / 2
    assert parts.end[0] == near(cut, abs=0.02)
    # The longest stretch may be the first or the last one.
    parts = cut_ring((0.0, "d< d>"), (110.0, "d< d> d>"), (170.0, "d< d>"))
    cut = (lower + 110.0 - taper - 0.25 * (110.0 - taper - lower)) / 2
    assert parts.end[0] == near(cut, abs=0.02)
    assert [len(found) for found in parts.stretches] == [1, 3]
    parts = cut_ring((0.0, "d< d>"), (20.0, "d< d> d>"), (80.0, "d< d>"))
    cut = (80.0 + taper + 0.25 * (upper - 80.0 - taper) + upper) / 2
    assert parts.end[0] == near(cut, abs=0.02)
    assert [len(found) for found in parts.stretches] == [3, 1]


def test_a_road_has_other_lanes_at_either_end_where_they_change() -> None:
    nodes = {"w": (-90.0, 0.0), "o": (0.0, 0.0), "e": (90.0, 0.0), "x": (0.0, 300.0), "y": (90.0, 300.0)}
    case = Case(nodes, {1: ("x y", "lanes=4"), 2: ("w o", "lanes=2"), 3: ("o e", "lanes=3")})
    stages = case.stages()
    parts = cut_roads(stages.network, fit_streets(stages.network, Diagnostics()), stages.layout)
    (road,) = (k for k, found in enumerate(parts.stretches) if len(found) == 2)
    assert [parts.at_end(end).ways for end in (2 * road, 2 * road + 1)] == [(2,), (3,)]
    assert [parts.at_end(end).ways for end in (2 - 2 * road, 3 - 2 * road)] == [(1,), (1,)]


def test_links_of_halves_are_those_of_their_own_street() -> None:
    """A straight street, one that leaves a junction and comes back to it, and two rings."""
    nodes = {"w": (-90.0, 0.0), "o": (0.0, 0.0), "a": (60.0, 40.0), "b": (60.0, -40.0)}
    nodes |= {f"r{k}": (300.0 + 30.0 * math.cos(k), 30.0 * math.sin(k)) for k in range(6)}
    nodes |= {f"t{k}": (500.0 + 30.0 * math.cos(k), 30.0 * math.sin(k)) for k in range(6)}
    rings = {k: (f"{' '.join(f'{name}{i}' for i in range(6))} {name}0", "") for k, name in ((3, "r"), (4, "t"))}
    stages = Case(nodes, {1: ("w o", ""), 2: ("o a b o", ""), **rings}).stages()
    parts = cut_roads(stages.network, fit_streets(stages.network, Diagnostics()), stages.layout)
    by_way: dict[int, list[int]] = {}
    for road, street_ in enumerate(parts.street.tolist()):
        by_way.setdefault(stages.way(2 * street_), []).append(road)
    assert {way: len(roads) for way, roads in by_way.items()} == {1: 1, 2: 2, 3: 2, 4: 2}
    (single,), (one, other) = by_way[1], by_way[2]
    assert parts.end_link[single].tolist() == [-1, -1]
    assert parts.end_junction[single].tolist() == [-1, 0]
    assert parts.end_link[[one, other]].tolist() == [[-1, 2 * other], [2 * one + 1, -1]]
    assert parts.end_junction[[one, other]].tolist() == [[0, -1], [-1, 0]]
    for way in (3, 4):
        one, other = by_way[way]
        assert parts.end_link[[one, other]].tolist() == [[2 * other + 1, 2 * other], [2 * one + 1, 2 * one]]
        assert parts.end_junction[[one, other]].tolist() == [[-1, -1], [-1, -1]]
    for end, road_end in enumerate(parts.road_end.tolist()):
        roads = by_way[stages.way(end)]
        assert road_end == (2 * roads[-1] + 1 if end % 2 else 2 * roads[0])


@pytest.mark.parametrize("first", ["o", "w"])
def test_a_street_that_comes_back_keeps_different_lanes_at_both_ends(first: str) -> None:
    """Only a ring has no end: its lanes are made the same where it is closed. Whichever node is the first."""
    places = {"w": (-90.0, 0.0), "o": (0.0, 0.0), "a": (60.0, 40.0), "b": (60.0, -40.0)}
    nodes = {first: places[first], **places}
    ways = {1: ("w o", ""), 2: ("o a", "lanes=2 width=6"), 3: ("a b o", "lanes=4 width=12")}
    case = Case(nodes, ways if first == "w" else dict(sorted(ways.items(), reverse=True)))
    stages = case.stages()
    parts = cut_roads(stages.network, fit_streets(stages.network, Diagnostics()), stages.layout)
    found = [k for k, street_ in enumerate(parts.street.tolist()) if len(stages.network.streets[street_].pieces) > 1]
    assert len(found) == 2
    lanes = [len(item.section.left) + len(item.section.right) for road in found for item in parts.stretches[road]]
    assert (lanes[0], lanes[-1]) in ((2, 4), (4, 2))


@pytest.mark.parametrize(("gap", "turn", "closed"), [(5e-4, 0.0, True), (5e-3, 0.0, False), (0.0, 5e-3, False)])
def test_a_ring_closes_within_a_millimetre_and_without_a_corner(gap: float, turn: float, closed: bool) -> None:
    """A circle that is short by a gap, or whose curvature is too much for its length; and a line of 90 m."""
    length = _AROUND - gap
    plan = PlanView(
        np.array([0, 1, 2]),
        np.zeros(2),
        np.zeros(2),
        np.zeros(2),
        np.zeros(2),
        np.array([90.0, length]),
        np.array([0.0, 1 / _RADIUS + turn / length]),
    )
    assert _closes(plan, np.array([1, 0]), np.array([90.0, length])).tolist() == [closed, False]


@pytest.mark.parametrize(("border", "moved"), [(30.0, True), (10.0, False)])
def test_lanes_change_clear_of_tight_bends(border: float, moved: bool) -> None:
    """A line of 20 m, a quarter of a circle of 10 m, and a line of 40 m; two streets before it run straight."""
    arc = 10.0 * math.pi / 2
    plan = PlanView(
        np.array([0, 1, 2, 5]),
        np.array([0.0, 0.0, 0.0, 20.0, 20.0 + arc]),
        np.array([0.0, 0.0, 0.0, 20.0, 30.0]),
        np.array([50.0, 90.0, 0.0, 0.0, 10.0]),
        np.array([0.0, 0.0, 0.0, 0.0, math.pi / 2]),
        np.array([90.0, 90.0, 20.0, arc, 40.0]),
        np.array([0.0, 0.0, 0.0, 0.1, 0.0]),
    )
    nodes = {f"{side}{k}": (90.0 * (side == "b"), 50.0 * k) for k in range(3) for side in "ab"}
    stages = Case(nodes, {1 + k: (f"a{k} b{k}", "") for k in range(3)}).stages()
    narrow, wide = (street(text, osm_way_id=k) for k, text in enumerate(("d< d>", "d< d> d>"), start=1))
    one, other = (cross_section(item, Rule.RIGHT_HAND) for item in (narrow, wide))
    plain = ((0.0, narrow, one), (45.0, wide, other))
    bent = ((0.0, narrow, one), (8.0, wide, other), (border, narrow, one), (55.0, wide, other))
    parts = cut_roads(
        stages.network, FittedStreets(plan, (plain, plain[:1], bent), np.zeros(3), np.zeros(3, bool)), stages.layout
    )
    assert parts.pieces[0] is plain
    assert parts.pieces[1] == plain[:1]
    found = parts.pieces[2]
    assert [item[1:] for item in found] == [item[1:] for item in bent]
    assert [found[k][0] for k in (0, 1, 3)] == [0.0, 8.0, 55.0]
    # At least three metres from the bend.
    assert (found[2][0] >= 20.0 + arc + 3.0 or found[2][0] <= 17.0) if moved else found[2][0] == border
    assert (parts.pieces[2] is bent) != moved
