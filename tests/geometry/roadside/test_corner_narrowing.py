"""Sidewalks of arms that part at an acute angle end in one wedge, whether cars turn there or not."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings, strategies as st
from margin_cases import BOTH, PARKING, WALK, Strips, built, is_led_on
from road_measures import RoadMeasures, assert_sound, width_at
from street_cases import Case

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import LaneType, Road, RoadMap, Rule

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
ONE_WAY = "highway=residential oneway=yes lanes=1 width=4"
_NO_WALK: tuple[Strips, Strips] = ((), ())


def _polar(distance: float, degrees: float) -> tuple[float, float]:
    return distance * math.cos(math.radians(degrees)), distance * math.sin(math.radians(degrees))


def acute_t(angle: float, tags: str = ONE_WAY) -> Case:
    """Ways 1 from the west and 3 from the south-west lead in, so that nobody turns at the acute corner between."""
    nodes = {"w": (-120.0, 0.0), "o": (0.0, 0.0), "e": (120.0, 0.0), "s": _polar(120.0, 180.0 + angle)}
    return Case(nodes, {1: ("w o", tags), 2: ("o e", tags), 3: ("s o", tags)})


def acute_x(angle: float) -> Case:
    """Ways 1 and 3 lead in, 2 and 4 out: nobody turns at either acute corner."""
    t = acute_t(angle)
    return Case({**t.nodes, "n": _polar(120.0, angle)}, {**t.ways, 4: ("o n", ONE_WAY)})


def joined(roads: RoadMap) -> set[frozenset[int]]:
    """Return the pairs of ways that sidewalks round corners join."""
    by_id = {road.id: road for road in roads.roads}
    return {
        frozenset(by_id[link.id].osm_way_ids[0] for link in (road.predecessor, road.successor) if link)
        for road in roads.roads
        if road.junction is not None and any(is_led_on(lane) for lane in road.lane_sections[0].lanes)
    }


def road_of(roads: RoadMap, way: int) -> Road:
    (road,) = (road for road in roads.roads if road.osm_way_ids == (way,))
    return road


def walk_beside(roads: RoadMap, road: Road, side: int, from_end: float) -> tuple[float, float]:
    """Return how far from the line of a road's street its kerb is, and how wide its sidewalk, before its end, m."""
    measures = RoadMeasures(roads)
    s = measures.length(road) - from_end
    section = road.lane_sections[-1]
    (lane,) = (lane for lane in section.lanes if lane.type is LaneType.SIDEWALK and lane.id * side > 0)
    edges = measures.edges(road, len(road.lane_sections) - 1, s)[lane.id]
    return min(map(abs, edges)), width_at(lane.widths, s - section.s)


def along_kerb(roads: RoadMap, way: int, other: int, kerb: float, angle: float, from_end: float = 0.0) -> float:
    """Return how far before the end of a way's road lies behind where its kerb meets that of another way, m."""
    measures = RoadMeasures(roads)
    one, two = (measures.pose(road, measures.length(road)) for road in (road_of(roads, way), road_of(roads, other)))
    # Both lead to the node, at which their lines meet.
    normal = -math.sin(two.hdg), math.cos(two.hdg)
    off = (two.x - one.x) * normal[0] + (two.y - one.y) * normal[1]
    to_node = off / (math.cos(one.hdg) * normal[0] + math.sin(one.hdg) * normal[1])
    return from_end + to_node - kerb / math.tan(math.radians(angle) / 2)


def gap(roads: RoadMap, way: int, other: int, side: int, from_end: float) -> float:
    """Return how far the back edge of a way's sidewalk is from that of another way, across the latter, m.

    Infinity beyond the end of the other road. Both are straight and lead to the junction; `side` is one of the first.
    """
    measures = RoadMeasures(roads)
    one, two = road_of(roads, way), road_of(roads, other)
    kerb, wide = walk_beside(roads, one, side, from_end)
    at = measures.pose(one, measures.length(one) - from_end).beside(side * (kerb + wide))
    end = measures.pose(two, measures.length(two))
    dx, dy = at.x - end.x, at.y - end.y
    before = -(dx * math.cos(end.hdg) + dy * math.sin(end.hdg))
    if before < 0.0:
        return math.inf
    kerb, wide = walk_beside(roads, two, -side, before)
    return -side * (dy * math.cos(end.hdg) - dx * math.sin(end.hdg)) - kerb - wide


def findings(diagnostics: Diagnostics) -> list[str]:
    return [item.osm_id for item in diagnostics if item.code == "sidewalk-corner"]


@EITHER
@pytest.mark.parametrize("angle", [30.0, 45.0, 60.0, 80.0])
def test_sidewalks_of_an_acute_t_end_in_one_wedge(rule: Rule, angle: float) -> None:
    """Kerbs 2 m beside the lines meet 2 m / tan(angle / 2) before the node; back edges meet in one line."""
    told = Diagnostics()
    case = acute_t(angle)
    roads = built(case, dict.fromkeys(case.ways, BOTH), rule, diagnostics=told)
    assert_sound(roads)
    assert joined(roads) == {frozenset(pair) for pair in ((1, 3), (1, 2), (2, 3))}
    assert findings(told) == []
    slope = math.tan(math.radians(angle) / 2)
    right = -1 if rule is Rule.RIGHT_HAND else 1
    room = {1: along_kerb(roads, 1, 3, 2.0, angle) * slope, 3: along_kerb(roads, 3, 1, 2.0, angle) * slope}
    narrow, broad = sorted(room, key=lambda way: room[way])
    side = {1: right, 3: -right}
    for way in (1, 3):
        road = road_of(roads, way)
        kerb, wide = walk_beside(roads, road, side[way], 0.0)
        assert kerb == pytest.approx(2.0, abs=0.01)
        assert wide <= min(room[way], 2.0)
        # The other side of the street is as wide as ever.
        assert walk_beside(roads, road, -side[way], 0.0)[1] == pytest.approx(2.0)
        assert walk_beside(roads, road, side[way], max(2.1 / slope, 4.0))[1] == pytest.approx(2.0)
    assert walk_beside(roads, road_of(roads, narrow), side[narrow], 0.0)[1] >= 0.85 * room[narrow] - 0.05
    met = 0
    if room[broad] > 2.0:
        # There the corner's bend alone narrows it, evenly.
        near, mid, far = (walk_beside(roads, road_of(roads, broad), side[broad], float(k))[1] for k in range(3))
        assert [mid - near, far - mid] == pytest.approx([0.25, 0.25], abs=0.01)
        return
    for before in (0.2, 0.5, 1.0, 1.5, 2.0, 3.0):
        off = gap(roads, broad, narrow, side[broad], before)
        if math.isfinite(off) and walk_beside(roads, road_of(roads, broad), side[broad], before)[1] < 1.99:
            assert off == pytest.approx(0.0, abs=0.03)
            met += 1
    assert met >= 2


def test_the_back_edges_of_bent_streets_meet() -> None:
    """Way 3 bends away from way 1: what is left between straight kerbs would be a slit."""
    case = acute_t(35.0)
    bent = {**case.nodes, "m": _polar(12.0, 215.0), "s": (-30.0, -90.0)}
    case = Case(bent, {**case.ways, 3: ("s m o", ONE_WAY)})
    told = Diagnostics()
    roads = built(case, dict.fromkeys(case.ways, BOTH), diagnostics=told)
    assert_sound(roads)
    assert findings(told) == []
    measures, one, other = RoadMeasures(roads), road_of(roads, 1), road_of(roads, 3)
    steps = [measures.length(other) * k / 400 for k in range(401)]
    # The back edge of way 3's sidewalk, 2 m beside way 1 at most.
    edge = []
    for s in steps:
        section = other.lane_sections[-1]
        (lane,) = (lane for lane in section.lanes if lane.type is LaneType.SIDEWALK and lane.id > 0)
        edge.append(
            measures.pose(other, s).beside(measures.edges(other, len(other.lane_sections) - 1, s)[lane.id][1])
        )
    found = 0
    for before in (0.5, 1.0, 1.5, 2.0, 2.5):
        kerb, wide = walk_beside(roads, one, -1, before)
        at = measures.pose(one, measures.length(one) - before).beside(-kerb - wide)
        if wide < 1.99:
            found += 1
            assert min(at.gap(place) for place in edge) < 0.2
    assert found >= 3


@EITHER
def test_a_wedge_at_each_acute_corner_of_an_x(rule: Rule) -> None:
    told = Diagnostics()
    case = acute_x(40.0)
    roads = built(case, dict.fromkeys(case.ways, BOTH), rule, diagnostics=told)
    assert_sound(roads)
    assert joined(roads) == {frozenset(pair) for pair in ((1, 3), (2, 4), (1, 4), (2, 3))}
    assert findings(told) == []


@EITHER
def test_sidewalks_stay_as_wide_where_the_other_street_has_none(rule: Rule) -> None:
    told = Diagnostics()
    case = acute_x(40.0)
    roads = built(case, {1: BOTH, 2: BOTH, 3: _NO_WALK, 4: BOTH}, rule, diagnostics=told)
    assert_sound(roads)
    assert joined(roads) == {frozenset(pair) for pair in ((2, 4), (1, 4))}
    assert findings(told) == []
    # But for the last metres of the one beside that street, where its lanes lie.
    for side in (1, -1):
        assert walk_beside(roads, road_of(roads, 1), side, 12.0)[1] == pytest.approx(2.0)


@settings(max_examples=15, deadline=None)
@given(angle=st.floats(25.0, 75.0), walk=st.floats(1.0, 2.4), width=st.floats(3.0, 7.0))
def test_no_sidewalk_lies_on_the_other_one(angle: float, walk: float, width: float) -> None:
    case = acute_t(angle, f"highway=residential oneway=yes lanes=1 width={width:.2f}")
    strip = replace(WALK, width=walk)
    roads = built(case, dict.fromkeys(case.ways, ((strip,), (strip,))))
    assert frozenset({1, 3}) in joined(roads)
    for before in (0.0, 0.5, 1.0, 2.0, 5.0, 8.0):
        for way, other, side in ((1, 3, -1), (3, 1, 1)):
            assert gap(roads, way, other, side, before) >= -0.03


def parked(roads: RoadMap, way: int, side: int, from_junction: float, kind: LaneType = LaneType.PARKING) -> float:
    """Return how wide what cars park on is at a side of a road that leads into the junction, m."""
    road = road_of(roads, way)
    s = RoadMeasures(roads).length(road) - from_junction
    section = [item for item in road.lane_sections if item.s <= s][-1]
    widths = [
        width_at(lane.widths, s - section.s) for lane in section.lanes if lane.type is kind and lane.id * side > 0
    ]
    return sum(widths)


def side_street(length: float = 120.0) -> Case:
    street = "highway=residential lanes=2 width=6"
    nodes = {"w": (-120.0, 0.0), "o": (0.0, 0.0), "e": (120.0, 0.0), "s": (0.0, -length)}
    return Case(nodes, {1: ("w o", street), 2: ("o e", street), 3: ("s o", street)})


@EITHER
@pytest.mark.parametrize("kind", [LaneType.PARKING, LaneType.RESTRICTED])
def test_parking_with_nothing_beyond_it_runs_out_before_the_junction(kind: LaneType, rule: Rule) -> None:
    strip = (replace(PARKING, type=kind),)
    roads = built(side_street(), {3: (strip, strip)}, rule)
    assert_sound(roads)
    for side in (1, -1):
        # In a smooth step over 12 m.
        found = [parked(roads, 3, side, at, kind) for at in (0.0, 6.0, 12.3)]
        assert found == pytest.approx([0.0, 1.1, 2.2], abs=0.011)


@EITHER
def test_parking_between_carriageway_and_sidewalk_reaches_the_corner(rule: Rule) -> None:
    both = (PARKING, WALK), (PARKING, WALK)
    roads = built(side_street(), {1: both, 2: both, 3: both}, rule)
    assert [parked(roads, 3, side, 0.0) for side in (1, -1)] == pytest.approx([2.2, 2.2], abs=1e-9)
