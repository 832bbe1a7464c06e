"""Strips beside carriageways become lanes; where they begin, change and end; what they must not change."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from junction_cases import CASES
from margin_cases import BOTH, PARKING, TRACK, VERGE, WALK, Strips, built, by_id, row, sections_of
from road_measures import assert_sound, lane_edges, width_at

from osm2xodr.curves.cubics import part_of_cubics
from osm2xodr.curves.plan_views import lengths
from osm2xodr.geometry.roadside import defaults
from osm2xodr.model import Cubic, LaneSection, LaneType, RoadMap, Rule

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
MARGINS = {LaneType.SIDEWALK, LaneType.BORDER, LaneType.PARKING, LaneType.SHOULDER}


@EITHER
def test_strips_lie_outside_the_carriageway_in_their_order(rule: Rule) -> None:
    roads = built(row("lanes=2 width=6"), {1: ((PARKING, WALK), (VERGE, TRACK, WALK))}, rule)
    assert_sound(roads)
    (section,) = sections_of(roads)
    side = 1 if rule is Rule.RIGHT_HAND else -1
    lanes = by_id(section)
    assert sorted(lanes) == sorted(side * k for k in (3, 2, 1, 0, -1, -2, -3, -4))
    kinds = [lanes[side * lane].type.value for lane in (3, 2, 1, -1, -2, -3, -4)]
    assert kinds == ["sidewalk", "parking", "driving", "driving", "border", "biking", "sidewalk"]
    assert [lanes[side * lane].height for lane in (2, 3, -1, -2, -3, -4)] == [0.0, 0.12, 0.0, 0.12, 0.06, 0.12]
    edges = lane_edges(section, 50.0, 0.0)
    assert edges[side * 3] == pytest.approx((side * 5.2, side * 7.2))
    assert edges[side * -3] == pytest.approx((side * -4.0, side * -5.6))
    assert edges[side * -4] == pytest.approx((side * -5.6, side * -7.6))


@EITHER
def test_a_one_way_street_has_strips_on_the_side_without_lanes(rule: Rule) -> None:
    roads = built(row("lanes=1 oneway=yes width=4"), {1: BOTH}, rule)
    assert_sound(roads)
    (section,) = sections_of(roads)
    side = 1 if rule is Rule.RIGHT_HAND else -1
    assert {lane.id: lane.type for lane in section.lanes if lane.id} == {
        side: LaneType.SIDEWALK,
        -side: LaneType.DRIVING,
        -2 * side: LaneType.SIDEWALK,
    }
    edges = lane_edges(section, 10.0, 2.0 * side)
    assert edges[side] == pytest.approx((side * 2.0, side * 4.0))


def test_a_kerb_is_marked_where_no_line_is() -> None:
    """The edge of a trunk road keeps its line, that of a residential street a kerb; so is a step between strips."""
    (lined,) = sections_of(built(row("lanes=2 highway=trunk"), {1: BOTH}))
    (bare,) = sections_of(built(row("lanes=2 highway=residential"), {1: ((PARKING, WALK), (WALK,))}))

    def marks(section: LaneSection) -> dict[int, str]:
        return {lane.id: lane.road_mark.type for lane in section.lanes if lane.id and lane.road_mark is not None}

    assert marks(bare) == {3: "none", 2: "curb", 1: "none", -1: "curb", -2: "none"}
    assert marks(lined) == {2: "none", 1: "solid", -1: "solid", -2: "none"}


@EITHER
def test_what_begins_and_ends_tapers(rule: Rule) -> None:
    roads = built(row("lanes=2", "lanes=2", "lanes=2"), {2: ((), (WALK,))}, rule)
    assert_sound(roads)
    (section,) = sections_of(roads)
    walk = by_id(section)[-2 if rule is Rule.RIGHT_HAND else 2]
    assert (walk.predecessor, walk.successor) == (None, None)
    taper = defaults.MARGIN_TAPER_LENGTH
    places = (100.0, 200.0, 200.0 + taper / 2, 200.0 + taper, 300.0, 400.0 - taper / 2, 400.0, 500.0)
    at = [width_at(walk.widths, s) for s in places]
    assert at == pytest.approx([0.0, 0.0, 1.0, 2.0, 2.0, 1.0, 0.0, 0.0], abs=0.01)


@EITHER
def test_strips_of_one_kind_are_one_lane(rule: Rule) -> None:
    """A parking lane comes between: the sidewalk goes on beyond it, from its own width to another."""
    wide = replace(WALK, width=3.0)
    roads = built(row("lanes=2", "lanes=2"), {1: ((), (WALK,)), 2: ((), (PARKING, wide))}, rule)
    assert_sound(roads)
    (section,) = sections_of(roads)
    side = -1 if rule is Rule.RIGHT_HAND else 1
    parking, walk = by_id(section)[2 * side], by_id(section)[3 * side]
    assert (parking.type, walk.type) == (LaneType.PARKING, LaneType.SIDEWALK)
    taper = defaults.MARGIN_TAPER_LENGTH
    places = (0.0, 200.0, 200.0 + taper / 2, 200.0 + taper)
    assert [width_at(walk.widths, s) for s in places] == pytest.approx([2.0, 2.0, 2.5, 3.0], abs=0.01)
    full = PARKING.width
    assert [width_at(parking.widths, s) for s in places] == pytest.approx([0.0, 0.0, full / 2, full], abs=0.01)


@EITHER
def test_what_lies_elsewhere_is_no_lane_of_a_section(rule: Rule) -> None:
    tags = ("lanes=2", "lanes=3 lanes:forward=2 lanes:backward=1", "lanes=2")
    roads = built(row(*tags), {2: ((), (WALK,)), 3: ((), (PARKING, WALK))}, rule)
    assert_sound(roads)
    one, two, three = (by_id(section) for section in sections_of(roads))
    side = -1 if rule is Rule.RIGHT_HAND else 1
    # The pocket opens before the border of the ways and ends after it: the section that it is in has all strips.
    assert [2 * side in one, 3 * side in two, 4 * side in two, 3 * side in three] == [False, True, True, True]
    assert (two[3 * side].predecessor, two[3 * side].successor) == (None, 2 * side)
    assert (two[4 * side].predecessor, two[4 * side].successor) == (None, 3 * side)
    assert (three[3 * side].predecessor, three[2 * side].predecessor) == (4 * side, 3 * side)


@EITHER
def test_strips_keep_their_links_where_the_carriageway_changes(rule: Rule) -> None:
    tags = ("lanes=2", "lanes=3 lanes:forward=2 lanes:backward=1", "lanes=2")
    roads = built(row(*tags), dict.fromkeys((1, 2, 3), BOTH), rule)
    assert_sound(roads)
    one, two, three = (by_id(section) for section in sections_of(roads))
    side = -1 if rule is Rule.RIGHT_HAND else 1
    assert (one[2 * side].successor, two[3 * side].successor) == (3 * side, 2 * side)
    assert (two[3 * side].predecessor, three[2 * side].predecessor) == (2 * side, 3 * side)
    assert two[-2 * side].predecessor == two[-2 * side].successor == -2 * side
    assert [width_at(two[3 * side].widths, s) for s in (0.0, 15.0, 200.0)] == pytest.approx([2.0, 2.0, 2.0])


def test_a_part_of_cubics_has_the_values_of_the_whole() -> None:
    cubics = (Cubic(0.0, 1.0, 0.0, 0.03, -0.002), Cubic(10.0, 2.0), Cubic(40.0, 2.0, -0.1))
    for begin, end in ((0.0, 50.0), (3.0, 7.0), (5.0, 45.0), (10.0, 40.0), (12.0, 20.0), (41.0, 50.0)):
        part = part_of_cubics(cubics, begin, end)
        assert part[0].s == 0.0
        for s in np.linspace(begin, end, 17)[:-1].tolist():
            assert width_at(part, s - begin) == pytest.approx(width_at(cubics, s), abs=1e-12)


# ------------------------------------------------------------------- what must not change

KINDS: tuple[Strips, ...] = ((), (WALK,), (PARKING, WALK), (VERGE, TRACK, WALK), (VERGE,))
STRIPS = st.sampled_from(KINDS)


def assert_same_carriageways(plain: RoadMap, full: RoadMap) -> None:
    """Check that roads for cars are in the same places with the same lanes and links."""
    roads = len(plain.roads)
    for table in ("plan_view", "elevation", "superelevation", "lane_offset"):
        one, other = getattr(plain, table), getattr(full, table)
        assert np.array_equal(one.start, other.start[: roads + 1])
        for name in one.__dataclass_fields__:
            if name != "start":
                assert np.array_equal(getattr(one, name), getattr(other, name)[: one.start[-1]]), (table, name)
    for road, length, same in zip(plain.roads, lengths(plain.plan_view).tolist(), full.roads, strict=False):
        assert (road.id, road.osm_way_ids, road.types) == (same.id, same.osm_way_ids, same.types)
        ends = [*[section.s for section in road.lane_sections[1:]], length]
        for section, end in zip(road.lane_sections, ends, strict=True):
            parts = [part for part in same.lane_sections if section.s - 1e-9 <= part.s < end - 1e-6]
            assert parts[0].s == section.s
            for lane in section.lanes:
                # What closes the floor of junctions depends on the sidewalks round their corners.
                if road.junction is not None and lane.type is LaneType.BORDER:
                    continue
                own = [by_id(part)[lane.id] for part in parts]
                assert {(item.type, item.speed, item.height) for item in own} == {(lane.type, lane.speed, 0.0)}
                assert (own[0].predecessor, own[-1].successor) == (lane.predecessor, lane.successor)
                assert all(one.successor == two.id for one, two in pairwise(own) if lane.id)
                for part, item in zip(parts, own, strict=True):
                    for share in (0.0, 0.3, 0.9):
                        s = part.s + share * (end - part.s) if part is parts[-1] else part.s
                        assert width_at(item.widths, s - part.s) == pytest.approx(
                            width_at(lane.widths, s - section.s), abs=1e-9
                        )


@EITHER
@pytest.mark.parametrize(
    "name", ["t", "x", "offset_t", "dual_cross", "roundabout", "y_merge", "lollipop", "isolated_ring"]
)
@given(data=st.data())
@settings(max_examples=4, deadline=None)
def test_carriageways_stay_as_they_are(name: str, rule: Rule, data: st.DataObject) -> None:
    case = CASES[name].case
    margins = {way: (data.draw(STRIPS), data.draw(STRIPS)) for way in case.ways}
    full = built(case, margins, rule)
    assert_sound(full)
    assert_same_carriageways(built(case, {}, rule), full)


@given(st.lists(st.tuples(STRIPS, STRIPS), min_size=4, max_size=4), st.floats(4.0, 120.0))
@settings(max_examples=12, deadline=None)
def test_carriageways_along_a_row_stay_as_they_are(chosen: list[tuple[Strips, Strips]], length: float) -> None:
    tags = (
        "lanes=2",
        "lanes=3 lanes:forward=2 lanes:backward=1",
        "lanes=3 lanes:forward=2 lanes:backward=1",
        "lanes=2",
    )
    case = row(*tags, length=length)
    full = built(case, dict(enumerate(chosen, start=1)))
    assert_sound(full)
    assert_same_carriageways(built(case, {}), full)
