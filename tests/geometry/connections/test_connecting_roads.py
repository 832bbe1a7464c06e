"""Junctions made by hand: every lane link that OSM allows, no other, exactly where the lanes are, on either side."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from floor_cases import connecting
from junction_cases import CASES, Expected
from road_measures import RoadMeasures, assert_sound, smallest_radius_of
from street_cases import Case, built_links, mirrored_links

from osm2xodr.defaults import CONNECTING_RADIUS
from osm2xodr.geometry.connections import ConnectingRoads, change_in_parts, connecting_roads
from osm2xodr.model import Rule

# Where a two-way street forks into one-way ones, the way back round the gore has no more room than this, m.
TIGHTEST = {"fork": 2.5}
EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
EVERY = pytest.mark.parametrize("expected", CASES.values(), ids=CASES)


@EITHER
@EVERY
def test_lanes_lead_where_they_must(expected: Expected, rule: Rule) -> None:
    right = rule is Rule.RIGHT_HAND
    roads = (expected.case if right else expected.case.mirrored()).build(rule)
    wanted = expected.links if right else mirrored_links(expected.links)
    assert built_links(roads) == sorted(wanted)
    assert len(roads.junctions) == expected.junctions


@EITHER
@EVERY
def test_lanes_lie_where_they_lead(expected: Expected, rule: Rule) -> None:
    case = expected.case if rule is Rule.RIGHT_HAND else expected.case.mirrored()
    assert_sound(case.build(rule))


@EITHER
@pytest.mark.parametrize("name", CASES)
def test_turns_have_room(name: str, rule: Rule) -> None:
    expected = CASES[name]
    roads = (expected.case if rule is Rule.RIGHT_HAND else expected.case.mirrored()).build(rule)
    measures = RoadMeasures(roads)
    for k, road in enumerate(roads.roads):
        assert measures.length(road) >= (1.0 if road.junction is None else 0.5) - 1e-6
        if road.junction is not None:
            radius = smallest_radius_of(roads.plan_view, k)
            assert radius >= TIGHTEST.get(name, CONNECTING_RADIUS) - 1e-6
            # No fold: the inner edge still has a radius.
            widest = max(abs(a - b) for a, b in measures.edges(road, 0, 0.0).values())
            assert radius > widest / 2
            assert measures.length(road) < 150.0


@EITHER
def test_ids_are_unique_and_links_mutual(rule: Rule) -> None:
    for expected in CASES.values():
        roads = (expected.case if rule is Rule.RIGHT_HAND else expected.case.mirrored()).build(rule)
        ids = [road.id for road in roads.roads] + [junction.id for junction in roads.junctions]
        assert len(set(ids)) == len(ids)
        assert min(ids) > 0
        for junction in roads.junctions:
            assert [item.id for item in junction.connections] == list(range(len(junction.connections)))


def test_a_right_turn_at_a_square_crossing_has_the_radius_of_its_kerb_and_lane() -> None:
    """Arms end 3.8 m (3 m of the other street, 0.8 m clear) and a kerb of 6 m from the middle of the crossing."""
    roads = CASES["x"].case.build()
    trim = 3.0 + 0.8 + 6.0
    lane = 1.5
    radii = {}
    for k, road in enumerate(roads.roads):
        if road.junction is not None and road.predecessor is not None and road.successor is not None:
            radii[(road.predecessor.id, road.successor.id)] = smallest_radius_of(roads.plan_view, k)
    assert sorted(radii.values())[:4] == pytest.approx([trim - lane] * 4, abs=0.15)
    assert sorted(radii.values())[4:8] == pytest.approx([trim + lane] * 4, abs=0.05)
    assert sorted(radii.values())[8] > 1000.0


def test_a_ring_without_streets_is_two_roads_in_a_circle() -> None:
    roads = CASES["isolated_ring"].case.build()
    measures = RoadMeasures(roads)
    first, second = (road for road in roads.roads if road.osm_way_ids == (1,))
    for one, other in ((first, second), (second, first)):
        assert one.successor is not None
        assert one.predecessor is not None
        assert (one.successor.id, one.successor.at_start) == (other.id, True)
        assert (one.predecessor.id, one.predecessor.at_start) == (other.id, False)
        end, begin = measures.pose(one, measures.length(one)), measures.pose(other, 0.0)
        assert end.gap(begin) < 1e-6
        assert end.turn(begin) < 1e-6
        assert [(lane.id, lane.predecessor, lane.successor) for lane in one.lane_sections[0].lanes if lane.id] == [
            (1, 1, 1),
            (-1, -1, -1),
        ]
    assert measures.length(first) + measures.length(second) == pytest.approx(2 * math.pi * 30.0, rel=0.02)


def test_a_file_of_nothing_but_a_ring() -> None:
    roads = Case({"a": (0.0, 0.0), "b": (50.0, 0.0), "c": (20.0, 40.0)}, {1: ("a b c a", "")}).build()
    assert_sound(roads)
    assert [road.osm_way_ids for road in roads.roads] == [(1,), (1,)]


def test_a_bridge_crosses_without_a_junction() -> None:
    roads = CASES["bridge"].case.build()
    assert [(road.predecessor, road.successor) for road in roads.roads] == [(None, None)] * 2
    measures = RoadMeasures(roads)
    assert [measures.length(road) for road in roads.roads] == pytest.approx([160.0, 160.0], abs=0.05)


@pytest.mark.parametrize(("name", "radius"), [("roundabout", 18.0), ("roundabout_two_lanes", 22.0)])
def test_the_ring_of_a_roundabout_is_round(name: str, radius: float) -> None:
    roads = CASES[name].case.build()
    measures = RoadMeasures(roads)
    ring = [road for road in roads.roads if road.osm_way_ids and road.osm_way_ids[0] >= 11]
    assert len(ring) == 4
    for road in ring:
        for share in (0.0, 0.25, 0.5, 0.75, 1.0):
            pose = measures.pose(road, share * measures.length(road))
            assert math.hypot(pose.x, pose.y) == pytest.approx(radius, abs=0.6)


@EITHER
def test_the_lanes_of_a_ring_stay_round_through_junctions(rule: Rule) -> None:
    """Three lanes around a small island, with wide arms: junctions are most of the ring."""
    corners = ("e", "n", "w", "s")
    nodes = {
        f"r{k}": (15.0 * math.cos(math.radians(15 * k)), 15.0 * math.sin(math.radians(15 * k))) for k in range(24)
    }
    nodes |= {
        name: (100.0 * math.cos(k * math.pi / 2), 100.0 * math.sin(k * math.pi / 2)) for k, name in enumerate(corners)
    }
    ways = {k + 1: (f"{name} r{6 * k}", "highway=primary lanes=4 width=14") for k, name in enumerate(corners)}
    ring = " ".join(f"r{k % 24}" for k in range(25))
    ways[11] = (ring, "highway=primary junction=roundabout oneway=yes lanes=3 width=10.5")
    case = Case(nodes, ways)
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    measures, by_id = RoadMeasures(roads), {road.id: road for road in roads.roads}
    around = 0
    for road in roads.roads:
        if road.junction is None or road.predecessor is None or road.successor is None:
            continue
        if any(by_id[link.id].osm_way_ids != (11,) for link in (road.predecessor, road.successor)):
            continue
        places = [measures.pose(road, share * measures.length(road)) for share in (0.0, 0.25, 0.5, 0.75, 1.0)]
        radii = [math.hypot(pose.x, pose.y) for pose in places]
        assert max(radii) - min(radii) < 0.1
        around += 1
    # The outermost lane leaves at each arm.
    assert around == 8


@pytest.mark.parametrize(
    ("at_once", "shared_from", "parts"),
    [(12, 12, [12]), (12, 11, [6, 6]), (6, 6, [6, 6]), (5, 5, [3, 3, 3, 3]), (2, 2, [3, 3, 3, 2, 1])],
    ids=["one", "two of what is worth sharing", "two", "four", "as many as junctions"],
)
def test_whole_junctions_are_worked_on_in_an_even_number_of_parts(
    at_once: int, shared_from: int, parts: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Junctions with 3, 3, 3, 2 and 1 roads."""
    junction = np.repeat([0, 2, 3, 7, 8], [3, 3, 3, 2, 1])
    monkeypatch.setattr(connecting_roads, "_AT_ONCE", at_once)
    monkeypatch.setattr(connecting_roads, "_SHARED_FROM", shared_from)
    lines = [(0.0, 10.0 * k, 20.0 + k, 10.0 * k) for k in range(len(junction))]
    roads = connecting(lines, junction.tolist())
    seen: list[list[int]] = []

    def shorter(some: ConnectingRoads) -> ConnectingRoads:
        seen.append(some.junction.tolist())
        plan = replace(some.plan_view, length=some.plan_view.length - 5.0)
        return replace(some, plan_view=plan, length=some.length - 5.0)

    changed = change_in_parts(shorter, roads, 1)
    assert [len(part) for part in seen] == parts
    assert [number for part in seen for number in part] == junction.tolist()
    assert changed.length == pytest.approx(15.0 + np.arange(12))
    assert changed.plan_view.length == pytest.approx(changed.length)
    assert changed.junction.tolist() == junction.tolist()
    once = len(seen)
    assert change_in_parts(shorter, roads, 2).length.tolist() == changed.length.tolist()
    assert len(seen) < 2 * once or once == 1
