"""Lane sections that are cut in two stay the same lanes; nobody parks where people cross."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from junction_cases import CASES
from light_cases import with_tags
from object_cases import road_of_way, world_of
from road_measures import assert_sound
from street_cases import Case

from osm2xodr.curves import curvature_at
from osm2xodr.furniture import find_furniture, with_furniture
from osm2xodr.furniture.lane_sections import cut_sections
from osm2xodr.furniture.world.lane_table import LaneTable
from osm2xodr.model import Cubic, Lane, LaneType, RoadMap, Rule

EITHER = pytest.mark.parametrize("rule", list(Rule))


@pytest.fixture(name="roads")
def _roads() -> RoadMap:
    return CASES["two_lanes_turn_left"].case.build()


def test_lanes_stay_where_they_are(roads: RoadMap) -> None:
    before = LaneTable(roads)
    breaks = [(road.id, 0.37 * before.length(road.id)) for road in roads.roads if before.length(road.id) > 10.0]
    after = LaneTable(cut_sections(roads, breaks))
    for road, _ in breaks:
        for k in range(101):
            s = 0.01 * k * before.length(road)
            # Strips of the floor that are nowhere wide in a part are no lanes of it.
            one, other = ([item for item in table.at(road, s) if item.left > item.right] for table in (before, after))
            assert [item.id for item in one] == [item.id for item in other]
            assert [item.left for item in one] == pytest.approx([item.left for item in other], abs=1e-9)
            assert [item.right for item in one] == pytest.approx([item.right for item in other], abs=1e-9)


def test_links_lead_over_the_cut(roads: RoadMap) -> None:
    road = roads.roads[0]
    cut = cut_sections(roads, [(road.id, 30.0)]).roads[0]
    assert len(cut.lane_sections) == len(road.lane_sections) + 1
    k = next(k for k, section in enumerate(cut.lane_sections) if section.s == 30.0)
    first, second = cut.lane_sections[k - 1 : k + 1]
    assert {lane.id: lane.successor for lane in first.lanes if lane.id} == {
        lane.id: lane.id for lane in second.lanes if lane.id
    }
    assert all(lane.predecessor == lane.id for lane in second.lanes if lane.id)
    original = road.lane_sections[k - 1]
    assert [lane.predecessor for lane in first.lanes] == [lane.predecessor for lane in original.lanes]
    assert [lane.successor for lane in second.lanes] == [lane.successor for lane in original.lanes]


def test_no_section_becomes_too_short(roads: RoadMap) -> None:
    road = roads.roads[0]
    length = LaneTable(roads).length(road.id)
    assert cut_sections(roads, []) is roads
    assert cut_sections(roads, [(road.id, 0.3), (road.id, length - 0.3)]).roads == roads.roads
    # Nor does one begin beyond an end of its road.
    assert cut_sections(roads, [(road.id, length + 5.0)]).roads == roads.roads
    assert cut_sections(roads, [(road.id, -0.5)]).roads == roads.roads
    assert (
        len(cut_sections(roads, [(road.id, 30.0), (road.id, 30.2)]).roads[0].lane_sections)
        == len(road.lane_sections) + 1
    )


def test_what_lies_beside_one_half_only_is_no_lane_of_the_other(roads: RoadMap) -> None:
    """A sidewalk from 40 m on: cut at 20 m, only the second half has it; cut at 60 m, both do."""
    road = roads.roads[0]
    (section,) = road.lane_sections
    lowest = section.lanes[-1].id - 1
    widths = Cubic(0.0, 0.0), Cubic(40.0, 0.0, 0.2), Cubic(50.0, 2.0)
    walk = Lane(lowest, LaneType.SIDEWALK, widths)
    beside = replace(road, lane_sections=(replace(section, lanes=(*section.lanes, walk)),))
    whole = replace(roads, roads=(beside, *roads.roads[1:]))
    for s, first_has_it in ((20.0, False), (60.0, True)):
        first, second = cut_sections(whole, [(road.id, s)]).roads[0].lane_sections
        assert (first.lanes[-1].id == lowest) is first_has_it
        assert second.lanes[-1].id == lowest
        assert second.lanes[-1].predecessor == (lowest if first_has_it else None)
        assert all(lane.successor == lane.id for lane in first.lanes if lane.id)


def test_tight_bends_are_not_cut() -> None:
    """A street turns off at a right angle: cuts keep 2.5 m off the bend, those elsewhere are made."""
    nodes = {"w": (-60.0, 0.0), "o": (0.0, 0.0), "n": (0.0, 60.0)}
    roads = Case(nodes, {1: ("w o n", "lanes=2 width=6")}).build()
    plan = roads.plan_view
    s = np.linspace(0.0, LaneTable(roads).length(roads.roads[0].id), 2001)
    bent = s[np.abs(curvature_at(plan, np.zeros(len(s), np.int64), s)) > 0.05]
    begin, end = bent[[0, -1]].tolist()
    assert 20.0 < begin < end < 100.0
    for s, parts in ((begin - 4.0, 2), (begin - 1.0, 1), (0.5 * (begin + end), 1), (end + 1.0, 1), (end + 4.0, 2)):
        assert len(cut_sections(roads, [(roads.roads[0].id, s)]).roads[0].lane_sections) == parts


def parking(case: Case, rule: Rule) -> dict[int, list[tuple[float, float]]]:
    """Return where cars can park on the road of way 1, (begin, end) as s, m, by the side: left 1, right -1."""
    world = world_of(case, rule)
    placed = find_furniture(world.network, world.road_map, world.options, world.diagnostics)
    roads = with_furniture(world.road_map, placed)
    assert_sound(roads)
    road = next(item for item in roads.roads if item.id == road_of_way(world, 1))
    ends = [*(section.s for section in road.lane_sections[1:]), world.lanes.length(road.id)]
    found: dict[int, list[tuple[float, float]]] = {1: [], -1: []}
    for section, end in zip(road.lane_sections, ends, strict=True):
        for lane in section.lanes:
            assert (abs(lane.id) == 2) == (lane.type in (LaneType.PARKING, LaneType.RESTRICTED))
            if lane.type is LaneType.PARKING:
                there = found[1 if lane.id > 0 else -1]
                begin = there.pop()[0] if there and there[-1][1] == round(section.s, 1) else round(section.s, 1)
                there.append((begin, round(end, 1)))
    return found


CROSSING = "highway=crossing crossing=marked"
PARKED = Case(
    {"w": (0.0, 0.0), "a": (3.0, 0.0), "b": (50.0, 0.0), "c": (63.0, 0.0), "e": (100.0, 0.0)},
    {1: ("w a b c e", "lanes=2 parking:both=lane")},
)


@EITHER
def test_nobody_parks_on_crossings_and_5_m_before_them(rule: Rule) -> None:
    """The crossing is 3 m wide. Who drives along s has the kerb at its own side, and comes from lower s."""
    own = -1 if rule is Rule.RIGHT_HAND else 1
    assert parking(with_tags(PARKED, b=CROSSING), rule) == {
        own: [(0.0, 43.5), (51.5, 100.0)],
        -own: [(0.0, 48.5), (56.5, 100.0)],
    }


@EITHER
def test_on_one_way_streets_traffic_comes_from_one_side_for_both_kerbs(rule: Rule) -> None:
    case = Case(PARKED.nodes, {1: ("w a b c e", "lanes=2 oneway=yes parking:both=lane")})
    world = world_of(with_tags(case, b=CROSSING), rule)
    placed = find_furniture(world.network, world.road_map, world.options, world.diagnostics)
    assert placed is not None
    assert [(item.begin, item.end) for item in placed.no_parking] == [pytest.approx((43.5, 51.5), abs=0.01)] * 2


@EITHER
def test_nobody_parks_where_no_car_fits_between_crossings_or_before_an_end(rule: Rule) -> None:
    """Between the crossings 50 and 63 m from the start 5 m are left, and 1.5 m before the first one."""
    found = parking(with_tags(PARKED, a=CROSSING, b=CROSSING, c=CROSSING), rule)
    own = -1 if rule is Rule.RIGHT_HAND else 1
    assert found == {own: [(4.5, 43.5), (64.5, 100.0)], -own: [(9.5, 48.5), (69.5, 100.0)]}


def test_without_crossings_cars_park_everywhere() -> None:
    assert parking(PARKED, Rule.RIGHT_HAND) == {1: [(0.0, 100.0)], -1: [(0.0, 100.0)]}
