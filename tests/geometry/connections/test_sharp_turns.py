"""Turns that are sharper than a car drives swing out where there is room for it."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from road_measures import RoadMeasures, assert_sound, smallest_radius_of
from street_cases import Case

from osm2xodr.defaults import CONNECTING_RADIUS, MOST_SWING_BACK
from osm2xodr.geometry import defaults
from osm2xodr.model import RoadMap, Rule

# Two carriageways, 4.6 m apart, and a street that crosses them, where one may turn back.
DUAL = Case(
    {
        "w1": (-80.0, 2.3), "w2": (-80.0, -2.3), "e1": (80.0, 2.3), "e2": (80.0, -2.3),
        "o1": (0.0, 2.3), "o2": (0.0, -2.3), "n": (0.0, 60.0), "s": (0.0, -60.0),
    },
    {
        1: ("o1 w1", "oneway=yes"), 2: ("w2 o2", "oneway=yes"),
        3: ("e1 o1", "oneway=yes"), 4: ("o2 e2", "oneway=yes"),
        5: ("s o2", ""), 6: ("o2 o1", ""), 7: ("o1 n", ""),
    },
)  # fmt: skip


def turn_back(roads: RoadMap) -> int:
    """Return the index of the connecting road between the carriageways."""
    ways = {road.id: road.osm_way_ids for road in roads.roads}
    (found,) = (
        k
        for k, road in enumerate(roads.roads)
        if road.junction
        and road.predecessor is not None
        and road.successor is not None
        and (ways[road.predecessor.id], ways[road.successor.id]) == ((2,), (1,))
    )
    return found


@pytest.mark.parametrize("rule", list(Rule))
def test_a_turn_back_has_the_radius_that_cars_drive(rule: Rule) -> None:
    case = DUAL if rule is Rule.RIGHT_HAND else DUAL.mirrored()
    roads = case.build(rule)
    assert_sound(roads)
    k = turn_back(roads)
    assert smallest_radius_of(roads.plan_view, k) == pytest.approx(CONNECTING_RADIUS)
    turned = RoadMeasures(roads).length(roads.roads[k]) / CONNECTING_RADIUS
    assert math.pi < turned < math.pi + MOST_SWING_BACK


@pytest.mark.parametrize("rule", list(Rule))
@pytest.mark.parametrize("apart", [2.2, 2.8, 3.4, 4.0])
def test_no_turn_back_folds_its_lane(apart: float, rule: Rule) -> None:
    """Even where there is no room to swing out, the inner edge keeps a radius."""
    nodes = {name: (x, math.copysign(apart / 2, y) if abs(y) < 10 else y) for name, (x, y) in DUAL.nodes.items()}
    case = replace(DUAL, nodes=nodes)
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    assert_sound(roads)
    widths = {road.id: lane.widths[0].a for road in roads.roads for lane in road.lane_sections[0].lanes if lane.id}
    inner = [
        smallest_radius_of(roads.plan_view, k) - widths[road.id] / 2
        for k, road in enumerate(roads.roads)
        if road.junction is not None
    ]
    assert min(inner) > 0.1 * defaults.INNER_EDGE_RADIUS - 1e-9


@pytest.mark.parametrize(
    ("width", "set_back"),
    [
        # Eight steps of 0.75 m are not enough.
        (2.5, 6.0),
        # With seven of them, a tangent of 14.7 m gives a radius of 3.1 m.
        (3.5, 5.25),
    ],
)
@pytest.mark.parametrize("rule", list(Rule))
def test_arms_of_a_sharp_turn_are_set_back(width: float, set_back: float, rule: Rule) -> None:
    """Three one-way streets of one lane; the turn back from the west is one of 156 degrees."""
    angle = math.radians(24.0)
    nodes = {"w": (-90.0, 0.0), "o": (0.0, 0.0), "e": (90.0, 0.0), "x": (-90 * math.cos(angle), 90 * math.sin(angle))}
    tags = f"oneway=yes lanes=1 width={width}"
    case = Case(nodes, {1: ("w o", tags), 2: ("o e", tags), 3: ("o x", tags)})
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    measures = RoadMeasures(roads)
    left = {road.osm_way_ids[0]: measures.length(road) for road in roads.roads if road.junction is None}
    bare = (width / 2 * (1 + math.cos(angle)) + 0.3) / math.sin(angle) + 0.5
    assert 90.0 - left[1] == pytest.approx(bare + set_back, abs=0.15)
    assert 90.0 - left[3] == pytest.approx(bare + set_back, abs=0.15)


def test_arms_are_set_back_while_their_streets_have_room() -> None:
    """Of 12 m, 7.1 m are needed; two steps leave 3.4 m, and 3 m must stay."""
    angle = math.radians(24.0)
    x, y = -12 * math.cos(angle), 12 * math.sin(angle)
    nodes = {"w": (-90.0, 0.0), "o": (0.0, 0.0), "e": (90.0, 0.0), "x": (x, y)}
    tags = "oneway=yes lanes=1 width=2.5"
    roads = Case(nodes, {1: ("w o", tags), 2: ("o e", tags), 3: ("o x", tags)}).build()
    (short,) = (road for road in roads.roads if road.osm_way_ids == (3,))
    assert RoadMeasures(roads).length(short) == pytest.approx(12.0 - 7.12 - 1.5, abs=0.05)
