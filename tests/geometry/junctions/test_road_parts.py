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
    cut_back_dead_ends,
    cut_roads,
    without_idle_junctions,
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
def test_nobody_turns_back_into_a_ramp(rule: Rule) -> None:
    """The road ends where the area does, so that only a turn on the spot would lead from it into the ramp."""
    case = parting(5.0, "highway=trunk", "highway=trunk_link oneway=yes")
    case = case if rule is Rule.RIGHT_HAND else case.mirrored()
    assert case.stages(rule).movements == []
    found = lengths(parting(5.0, "highway=trunk", "highway=trunk_link oneway=yes"), rule)
    assert found[1] == pytest.approx(300.0, abs=0.01)
    assert 220.0 < found[2] < 260.0


def test_slow_streets_do_turn_back() -> None:
    stages = parting(15.0, "highway=tertiary", "highway=residential oneway=yes").stages()
    assert [(stages.way(item.entry), stages.way(item.exit)) for item in stages.movements] == [(1, 2)]


@EITHER
def test_dead_ends_that_part_widely_keep_their_length(rule: Rule) -> None:
    found = lengths(parting(80.0), rule)
    assert (found[1], found[2]) == pytest.approx((300.0, 300.0), abs=0.01)


def test_what_is_cut_back_is_reported() -> None:
    stages = parting(10.0).stages()
    diagnostics = Diagnostics()
    layout = without_idle_junctions(stages.layout, stages.movements)
    assert not layout.trim.any()
    after = cut_back_dead_ends(stages.network, stages.ends, stages.layout, layout, diagnostics)
    assert (after.trim > 0).sum() == 1
    assert [(item.code, item.osm_id) for item in diagnostics] == [("lies-on-another", "way/2")]


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
@pytest.mark.parametrize(("degrees", "cut"), [(41.0, True), (50.0, False)])
def test_dead_ends_lie_on_each_other_within_45_degrees(degrees: float, cut: bool, rule: Rule) -> None:
    assert (lengths(parting(degrees), rule)[2] < 299.0) == cut


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
    return cut_roads(stages.network, FittedStreets(plan, (pieces,), np.zeros(1)), stages.layout)


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
    """Between the quarters, at 47.1 and 141.4 m, a quarter of the stretch away from a border there."""
    near = pytest.approx
    parts = cut_ring((0.0, "d< d>"), (60.0, "d< d> d>"), (150.0, "d< d>"))
    upper = 0.75 * _AROUND
    cut = (60.0 + 0.25 * (upper - 60.0) + upper) / 2
    assert spans(parts) == [
        [(0.0, 60.0, 2, (1,)), (60.0, near(cut, abs=0.02), 3, (2,))],
        [
            (0.0, near(150.0 - cut, abs=0.02), 3, (2,)),
            (near(150.0 - cut, abs=0.02), near(_AROUND - cut, abs=0.02), 2, (3,)),
        ],
    ]
    parts = cut_ring((0.0, "d< d>"), (40.0, "d< d> d>"), (120.0, "d< d>"))
    lower = 0.25 * _AROUND
    cut = (lower + 120.0 - 0.25 * (120.0 - lower)) / 2
    assert parts.end[0] == near(cut, abs=0.02)
    # The longest stretch may be the first or the last one.
    parts = cut_ring((0.0, "d< d>"), (110.0, "d< d> d>"), (170.0, "d< d>"))
    cut = (lower + 110.0 - 0.25 * (110.0 - lower)) / 2
    assert parts.end[0] == near(cut, abs=0.02)
    assert [len(found) for found in parts.stretches] == [1, 3]
    parts = cut_ring((0.0, "d< d>"), (20.0, "d< d> d>"), (80.0, "d< d>"))
    cut = (80.0 + 0.25 * (upper - 80.0) + upper) / 2
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
