"""Lane sections along a road: where they begin, how lanes open and end, what links them."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest
from lane_cases import cut, layout, street
from road_measures import assert_sound, lane_edges, profile_value, width_at
from street_cases import Case

from osm2xodr.conventions import find_country
from osm2xodr.curves.cubics import smooth_cubic
from osm2xodr.geometry import defaults
from osm2xodr.geometry.lanes import without_repeats
from osm2xodr.geometry.lanes.lane_connectivity import Connectivity
from osm2xodr.geometry.lanes.lane_sections import lay_out_all
from osm2xodr.geometry.lanes.tapers import taper_zones
from osm2xodr.geometry.roadside.strip_columns import tapered
from osm2xodr.model import Cubic, Direction, LaneConnectivity, RoadMap, Rule, StreetAttributes


def row(*tags: str, length: float = 200.0) -> Case:
    """Make ways 1, 2 … from west to east in a row, one for each set of tags."""
    nodes = {f"p{k}": (k * length, 0.0) for k in range(len(tags) + 1)}
    return Case(nodes, {k + 1: (f"p{k} p{k + 1}", text) for k, text in enumerate(tags)})


def of_one_width(text: str, width: float) -> StreetAttributes:
    """Return a street with lanes that are all of one width, m, those for bicycles, too."""
    plain = street(text)
    return replace(plain, lanes_ltr=tuple(replace(lane, width=width) for lane in plain.lanes_ltr))


def links_in(roads: RoadMap) -> list[dict[int, int | None]]:
    """Return the successors of the lanes of each section but the last of the only road."""
    (road,) = roads.roads
    return [{lane.id: lane.successor for lane in item.lanes if lane.id} for item in road.lane_sections[:-1]]


def built(case: Case, rule: Rule) -> RoadMap:
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    assert_sound(roads)
    return roads


EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
ROWS = [
    ("oneway=yes lanes=3", "oneway=yes lanes=2", {-1: -1, -2: -2, -3: None}),
    ("oneway=yes lanes=3 turn:lanes=merge_to_right|none|none", "oneway=yes lanes=2", {-1: None, -2: -1, -3: -2}),
    ("oneway=yes lanes=3 turn:lanes=none|none|merge_to_left", "oneway=yes lanes=2", {-1: -1, -2: -2, -3: None}),
    ("oneway=yes lanes=1", "oneway=yes lanes=2", {-1: -1}),
    ("oneway=yes lanes=1", "oneway=yes lanes=2 turn:lanes=left|through", {-1: -2}),
    ("oneway=yes lanes=1", "oneway=yes lanes=2 turn:lanes=through|right", {-1: -1}),
    ("oneway=yes lanes=1", "oneway=yes lanes=2 placement=middle_of:1", {-1: -1}),
    ("lanes=2", "lanes=3 lanes:forward=2 lanes:backward=1", {1: 1, -1: -1}),
    ("lanes=2", "lanes=3 lanes:forward=1 lanes:backward=2", {1: 1, -1: -1}),
    ("lanes=2", "lanes=3 lanes:forward=1 lanes:backward=1 lanes:both_ways=1", {1: 1, -1: -2}),
    ("lanes=2 highway=primary", "lanes=2 highway=residential", {1: 1, -1: -1}),
]


@EITHER
@pytest.mark.parametrize(("one", "other", "expected"), ROWS)
def test_lanes_go_on_where_a_way_follows_another(
    one: str, other: str, expected: dict[int, int | None], rule: Rule
) -> None:
    roads = built(row(one, other), rule)
    wanted = expected
    if rule is Rule.LEFT_HAND:
        wanted = {-lane: None if to is None else -to for lane, to in expected.items()}
    assert links_in(roads) == [wanted]


@EITHER
def test_a_lane_that_comes_in_the_middle_and_goes_again(rule: Rule) -> None:
    roads = built(row("lanes=2", "lanes=3 lanes:forward=2 lanes:backward=1", "lanes=2"), rule)
    (road,) = roads.roads
    assert len(road.lane_sections) == 3
    new = -2 if rule is Rule.RIGHT_HAND else 2
    (lane,) = (item for item in road.lane_sections[1].lanes if item.id == new)
    assert (lane.predecessor, lane.successor) == (None, None)
    # It opens over 15 times its width outside of towns, and has half of it at the border of the ways; so it ends.
    taper = defaults.TAPER_RATIO_FAST * 3.0
    begin, end = (section.s for section in road.lane_sections[1:])
    assert (begin, end) == pytest.approx((200.0 - taper / 2, 400.0 + taper / 2), abs=1e-3)
    assert width_at(lane.widths, 0.0) == 0.0
    assert width_at(lane.widths, 200.0 - begin) == pytest.approx(1.5, abs=1e-3)
    assert width_at(lane.widths, taper) == pytest.approx(3.0, abs=1e-6)
    assert width_at(lane.widths, 300.0 - begin) == pytest.approx(3.0)
    assert width_at(lane.widths, 400.0 - begin) == pytest.approx(1.5, abs=1e-3)
    assert width_at(lane.widths, end - begin) == pytest.approx(0.0, abs=1e-6)


@EITHER
@pytest.mark.parametrize("lengths", [4.0, 8.0, 31.0])
def test_short_sections_have_tapers_that_fit(lengths: float, rule: Rule) -> None:
    tags = ("lanes=2", "lanes=4", "lanes=2", "lanes=3 lanes:forward=1 lanes:backward=2", "oneway=yes lanes=1")
    roads = built(row(*tags, length=lengths), rule)
    assert len(roads.roads) == 1


def test_pieces_shorter_than_a_section_join_their_neighbours() -> None:
    case = Case(
        {"a": (0.0, 0.0), "b": (100.0, 0.0), "c": (102.0, 0.0), "d": (150.0, 0.0)},
        {1: ("a b", "lanes=2"), 2: ("b c", "lanes=4"), 3: ("c d", "lanes=2")},
    )
    roads = case.build()
    assert_sound(roads)
    (road,) = roads.roads
    assert all(sum(1 for lane in item.lanes if lane.id) == 2 for item in road.lane_sections)


def test_placement_holds_the_lane_that_it_names_in_place() -> None:
    """The line of the way stays in the middle of its first lane when a second one comes at its right."""
    roads = built(row("oneway=yes lanes=1", "oneway=yes lanes=2 placement=middle_of:1"), Rule.RIGHT_HAND)
    (road,) = roads.roads
    for s in (10.0, 205.0, 215.0, 260.0, 395.0):
        k = 0 if s < road.lane_sections[1].s else 1
        item = road.lane_sections[k]
        inner, outer = lane_edges(item, s - item.s, profile_value(roads.lane_offset, 0, s))[-1]
        assert (inner, outer) == pytest.approx((1.5, -1.5), abs=1e-6)


def test_lanes_that_go_on_stay_where_placement_holds_them() -> None:
    """A pocket on the left opens and ends; the middle of the carriageway moves, the other lanes do not."""
    through = "oneway=yes lanes=2 placement=right_of:1"
    pocket = "oneway=yes lanes=3 placement=right_of:2 turn:lanes=left|through|through"
    roads = built(row(through, pocket, through), Rule.RIGHT_HAND)
    (road,) = roads.roads
    assert [len(section.lanes) for section in road.lane_sections] == [3, 4, 3]
    ends = [*(section.s for section in road.lane_sections[1:]), 600.0]
    for section, end in zip(road.lane_sections, ends, strict=True):
        for k in range(41):
            s = section.s + k * (end - section.s) / 40
            edges = lane_edges(section, s - section.s, profile_value(roads.lane_offset, 0, s))
            inner, outer = edges[min(edges)]
            assert (inner, outer) == pytest.approx((0.0, -3.0), abs=1e-6)


def test_a_smooth_step_has_no_slope_at_its_ends() -> None:
    cubic = smooth_cubic(5.0, 20.0, 1.0, 4.0)

    def value(ds: float) -> float:
        return cubic.a + ds * (cubic.b + ds * (cubic.c + ds * cubic.d))

    def slope(ds: float) -> float:
        return cubic.b + ds * (2 * cubic.c + 3 * ds * cubic.d)

    assert (cubic.s, value(0.0)) == (5.0, 1.0)
    assert [value(10.0), value(20.0)] == pytest.approx([2.5, 4.0], abs=1e-12)
    assert [slope(0.0), slope(20.0)] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert slope(10.0) == pytest.approx(1.5 * 3.0 / 20.0, abs=1e-12)


def test_tapers_only_where_something_changes() -> None:
    assert [cubic.s for cubic in tapered(100.0, 30.0, 3.0, 3.0, 3.0)] == [0.0]
    assert [cubic.s for cubic in tapered(100.0, 30.0, 0.0, 3.0, 3.0)] == [0.0, 30.0]
    assert [cubic.s for cubic in tapered(100.0, 30.0, 3.0, 3.0, 0.0)] == [0.0, 70.0]
    assert [cubic.s for cubic in tapered(100.0, 30.0, 0.0, 3.0, 0.0)] == [0.0, 30.0, 70.0]
    assert width_at(tapered(100.0, 30.0, 0.0, 3.0, 1.0), 100.0) == pytest.approx(1.0, abs=1e-12)
    # Rounding is no change, a tenth of a millimetre is one.
    assert [cubic.s for cubic in tapered(100.0, 30.0, 3.0 + 1e-12, 3.0, 3.0 - 1e-12)] == [0.0]
    assert [cubic.s for cubic in tapered(100.0, 30.0, 3.0001, 3.0, 2.9999)] == [0.0, 30.0, 70.0]


def test_constants_are_written_once() -> None:
    rise = Cubic(4.0, 1.0, 0.5)
    found = without_repeats([Cubic(0.0, 1.0), Cubic(2.0, 1.0 + 1e-12), rise, Cubic(6.0, 2.0), Cubic(8.0, 2.1)])
    assert found == (Cubic(0.0, 1.0), rise, Cubic(6.0, 2.0), Cubic(8.0, 2.1))
    # What is no constant is not left out for its value at the start.
    again = Cubic(5.0, 1.0, 0.5)
    assert without_repeats([rise, again, Cubic(6.0, 1.0)]) == (rise, again, Cubic(6.0, 1.0))
    # Of two records at one place the later holds.
    assert without_repeats([Cubic(0.0, 1.0), Cubic(4.0, 1.5), rise]) == (Cubic(0.0, 1.0), rise)


def test_a_cubic_that_goes_on_is_written_once() -> None:
    """Round ends of two tapers in a row may be one cubic, with its inflection where they meet."""
    end = Cubic(10.0, 2.8, 0.002, -3e-5, 1e-6)
    begin = end.begun_later(10.0, 20.0)
    assert begin.b == pytest.approx(0.0017)
    assert begin.c == pytest.approx(0.0)
    after = Cubic(35.0, begin.at(15.0), 0.0, 0.0, 0.0)
    assert without_repeats([end, begin, after]) == (end, after)
    for other in (replace(begin, a=begin.a + 1e-6), replace(begin, d=1.001e-6), replace(begin, c=1e-9)):
        assert without_repeats([end, other, after]) == (end, other, after)


@pytest.mark.parametrize(
    ("speed_kmh", "length", "middle", "taper"),
    [
        # 8.5 times the width of 3 m in town, also where nothing is known; 15 times from 80 km/h.
        # Where limits are low 7.6 times, behind the border.
        (None, 200.0, 100.0, 25.5),
        (30.0, 200.0, 100.0, 22.8),
        (45.0, 200.0, 100.0, 22.8),
        # A quarter of the stretch has the whole width, three quarters of its 24 m may open.
        (30.0, 100.0, 76.0, 22.8),
        (50.0, 200.0, 100.0, 25.5),
        (65.0, 200.0, 100.0, 3.0 * 11.75),
        (80.0, 200.0, 100.0, 45.0),
        (130.0, 200.0, 100.0, 45.0),
        # Where there is less room than that, shorter, down to 8.5 times; beside the ends of the road.
        (130.0, 40.0, 20.0, 38.0),
        (50.0, 28.0, 14.0, 25.5),
    ],
)
def test_length_of_tapers(speed_kmh: float | None, length: float, middle: float, taper: float) -> None:
    speed = None if speed_kmh is None else speed_kmh / 3.6
    one, two = (street(text, width=3.0, speed_forward=speed) for text in ("d>", "d> d>"))
    found = layout((0.0, one), (middle, two), end=length)
    border = middle
    slow = speed_kmh is not None and speed_kmh <= 45.0
    behind = min(taper, max(0.75 * (length - middle), taper / 2)) if slow else taper / 2
    middle += behind - taper / 2
    assert [section.s for section in found.sections] == pytest.approx([0.0, middle - taper / 2])
    opens = found.sections[1].lanes[-1]
    assert [cubic.s for cubic in opens.widths] == pytest.approx([0.0, taper])
    found = layout((0.0, two), (length - border, one), end=length)
    assert [section.s for section in found.sections] == pytest.approx([0.0, length - middle + taper / 2])
    ends = found.sections[0].lanes[-1]
    assert [cubic.s for cubic in ends.widths] == pytest.approx([0.0, length - middle - taper / 2])
    assert width_at(ends.widths, length - middle + taper / 2) == pytest.approx(0.0, abs=1e-9)


def test_a_taper_without_room_for_a_smooth_step_is_a_line_with_round_ends() -> None:
    """A lane of 3 m opens over 18 m where another one begins, and the others move aside as steadily: 1 in 5.1."""
    bicycles = of_one_width("c< d>", 3.0)
    found = layout((0.0, street("d>", width=3.0)), (10.0, bicycles), end=20.0)
    (opens,) = (lane for lane in found.sections[1].lanes if lane.id == 1)
    assert [cubic.s for cubic in opens.widths] == pytest.approx([0.0, 2.7, 15.3, 18.0])
    slope = 3.0 / (0.85 * 18.0)
    assert [cubic.b for cubic in opens.widths] == pytest.approx([0.0, slope, slope, 0.0])
    assert width_at(opens.widths, 9.0) == pytest.approx(1.5)
    assert [width_at(opens.widths, s - 1e-9) for s in (2.7, 15.3, 18.0)] == pytest.approx(
        [1.35 * slope, 3.0 - 1.35 * slope, 3.0], abs=1e-6
    )
    # The middle of the carriageway stays.
    for s in (1.0, 3.0, 10.0, 17.0, 19.0):
        section = found.sections[int(s >= found.sections[1].s)]
        across = [
            width_at(lane.widths, s - section.s) * (1 if lane.id > 0 else -1) for lane in section.lanes if lane.id
        ]
        assert width_at(found.offset, s) + sum(across) / 2 == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("taper", "share"), [(16.5, 1 - 3.0 / (0.2 * 16.5)), (12.0, 0.05)])
def test_a_taper_with_still_less_room_has_shorter_round_ends(taper: float, share: float) -> None:
    """A lane of 3 m opens over 16.5 m at 1 in 5, and over 12 m as gently as short ends allow."""
    bicycles = of_one_width("c< d>", 3.0)
    found = layout((0.0, street("d>", width=3.0)), (5.0, bicycles), end=taper + 2.0)
    (opens,) = (lane for lane in found.sections[1].lanes if lane.id == 1)
    assert max(cubic.b for cubic in opens.widths) == pytest.approx(3.0 / ((1 - share) * taper))
    assert [cubic.s for cubic in opens.widths] == pytest.approx([0.0, share * taper, (1 - share) * taper, taper])


def test_a_taper_that_lacks_room_takes_it_from_the_longer_side() -> None:
    one, two = street("d>", width=3.0), street("d> d>/right", width=3.0)
    found = layout((0.0, one), (190.0, two), end=200.0)
    # A metre before the road's end the lane has its width.
    assert [section.s for section in found.sections] == pytest.approx([0.0, 199.0 - 25.5])
    assert [cubic.s for cubic in found.sections[1].lanes[-1].widths] == pytest.approx([0.0, 25.5])
    # Two borders near each other share what is there.
    three = street("d> d> d>", width=3.0)
    found = layout((0.0, one), (90.0, two), (110.0, three), end=200.0)
    assert [section.s for section in found.sections] == pytest.approx([0.0, 74.5, 100.0])


def test_lanes_open_one_after_another() -> None:
    """Two new lanes at the right of one: the outer one opens 12.75 m after the inner one, and ends before it."""
    one, three = street("d>", width=3.0), street("d> d> d>", width=3.0)
    found = layout((0.0, one), (100.0, three), end=200.0)
    taper = 1.5 * 25.5
    starts = [100.0 - taper / 2, 100.0 + taper / 2 - 25.5]
    assert [section.s for section in found.sections] == pytest.approx([0.0, *starts])
    assert [len(section.lanes) - 1 for section in found.sections] == [1, 2, 3]
    assert [lane.predecessor for lane in found.sections[2].lanes[1:]] == [-1, -2, None]
    found = layout((0.0, three), (100.0, one), end=200.0)
    assert [section.s for section in found.sections] == pytest.approx([0.0, *(200.0 - s for s in reversed(starts))])
    assert [lane.successor for lane in found.sections[0].lanes[1:]] == [-1, -2, None]


@pytest.mark.parametrize(("after", "lane"), [("d> d>/right d>/right", -1), ("d>/left d>/left d>", -3)])
def test_a_lane_that_placement_holds_runs_straight_beside_lanes_that_open_one_after_another(
    after: str, lane: int
) -> None:
    one = street("d>", width=3.0)
    three = street(after, width=3.0, middle_offset=-3.0 if lane == -1 else 3.0)
    found = layout((0.0, one), (100.0, three), end=200.0)
    for s in range(0, 201, 5):
        section = max((item for item in found.sections if item.s <= s), key=lambda item: item.s)
        lanes = [item for item in section.lanes if item.id]
        at = 0 if lane == -1 else -1
        inner = sum(width_at(item.widths, s - section.s) for item in (lanes[:at] if at else []))
        edge = width_at(found.offset, float(s)) - inner
        assert edge == pytest.approx(1.5, abs=1e-6)
        assert width_at(lanes[at].widths, s - section.s) == pytest.approx(3.0)


def test_lanes_that_stay_the_same_shift_gently() -> None:
    """By 1 m to the side at 50 km/h, with 0.5 m/s3 at most: over 13.89 (32 * 1 / 0.5)^(1/3) = 55.56 m."""
    found = layout((0.0, street("d> d>")), (100.0, street("d> d>", middle_offset=1.0)), end=200.0)
    length = defaults.TOWN_SPEED * (32.0 / defaults.SHIFT_JERK) ** (1 / 3)
    assert length == pytest.approx(55.556, abs=1e-3)
    assert [section.s for section in found.sections] == [0.0]
    places = [100.0 + share * length for share in (-0.5, -0.25, 0.25, 0.5)]
    assert [item.s for item in found.offset] == pytest.approx([0.0, *places])
    assert [6 * item.d * defaults.TOWN_SPEED**3 for item in found.offset] == pytest.approx([0, 0.5, -0.5, 0.5, 0])
    for one, other in pairwise(found.offset):
        ds = other.s - one.s
        slope, bend = one.b + 2 * one.c * ds + 3 * one.d * ds**2, 2 * one.c + 6 * one.d * ds
        assert (width_at([one], other.s), slope, bend) == pytest.approx((other.a, other.b, 2 * other.c))


def test_lanes_shift_gently_beside_one_that_opens_fast() -> None:
    """A lane of 3.5 m opens over 29.75 m; those beside it take 66.95 m to move by 1.75 m, in which it lies."""
    found = layout((0.0, street("d> d>")), (150.0, street("d> d> d>/right")), end=300.0)
    assert [section.s for section in found.sections] == pytest.approx([0.0, 150.0 - 14.875])
    first, last = found.offset[1].s, found.offset[-1].s
    assert (first + last) / 2 == pytest.approx(150.0)
    assert last - first == pytest.approx(defaults.TOWN_SPEED * (32 * 1.75 / 0.5) ** (1 / 3))
    assert [width_at(found.offset, s) for s in (0.0, 150.0, 300.0)] == pytest.approx([3.5, 4.375, 5.25])


def test_lanes_apart_move_with_the_one_that_opens_between_them() -> None:
    """Else one of them would move to and fro."""
    found = layout((0.0, street("d< d>")), (150.0, street("d< d>/left d>")), end=300.0)
    first, last = found.offset[1].s, found.offset[-1].s
    assert last - first == pytest.approx(defaults.TAPER_RATIO * 3.5)


def test_lanes_that_only_change_their_width_need_no_section() -> None:
    """Readers make an edge of each section."""
    found = layout((0.0, street("d> d>", width=3.5)), (100.0, street("d> d>", width=3.0)), end=200.0)
    (section,) = found.sections
    for lane in section.lanes[1:]:
        assert [width_at(lane.widths, s) for s in (0.0, 100.0, 200.0)] == pytest.approx([3.5, 3.25, 3.0])


@pytest.mark.parametrize("change", [{"speed_forward": 8.0}, {"no_overtaking": frozenset({Direction.FORWARD})}])
def test_lanes_with_other_rules_begin_a_section(change: dict[str, Any]) -> None:
    other = replace(street("d< d>", width=3.0), **change)
    found = layout((0.0, street("d< d>", width=3.5)), (100.0, other), end=200.0)
    assert [section.s for section in found.sections] == [0.0, 100.0]


def test_a_bicycle_lane_ends_where_it_would_cross_a_lane_for_cars() -> None:
    """OpenDRIVE's lanes keep their order along a road: it opens again on the other side."""
    before, after = street("d> d> c>/through", width=3.0), street("d> c>/through d>/right", width=3.0)
    found = layout((0.0, before), (100.0, after), end=200.0)
    assert [[lane.type.value for lane in item.lanes[1:]] for item in found.sections] == [
        ["driving", "driving", "biking"],
        ["driving", "biking", "driving", "biking"],
        ["driving", "biking", "driving"],
    ]
    assert [lane.successor for lane in found.sections[0].lanes[1:]] == [-1, -3, -4]
    assert [lane.successor for lane in found.sections[1].lanes[1:]] == [-1, -2, -3, None]


def offsets(*texts: str, **more: float) -> list[tuple[float, float]]:
    """Return (s, lane offset) at the borders of pieces of 100 m, and at the road's ends."""
    middles = [more.get(f"m{k}", 0.0) for k in range(len(texts))]
    pieces = [(100.0 * k, street(text, width=3.0, middle_offset=middles[k])) for k, text in enumerate(texts)]
    found = layout(*pieces, end=100.0 * len(texts)).offset
    return [(s, width_at(found, s)) for s in (100.0 * k for k in range(len(texts) + 1))]


def test_the_centre_moves_with_lanes_that_open_and_end() -> None:
    """Lanes stay about the OSM line: its middle is t = 0 in both cross-sections."""
    # One lane, then two: the centre is at the left edge, which moves from 1.5 to 3 m, by half of that at the border.
    assert offsets("d>", "d> d>") == [(0.0, 1.5), (100.0, pytest.approx(2.25)), (200.0, 3.0)]
    assert offsets("d> d>", "d>") == [(0.0, 3.0), (100.0, pytest.approx(2.25)), (200.0, 1.5)]
    # The others come to where placement says that they continue.
    assert offsets("d> d>", "d>", m1=1.0) == [(0.0, 3.0), (100.0, pytest.approx(2.75)), (200.0, 2.5)]
    # One lane ends while another opens.
    assert offsets("d< d< d>", "d< d> d>") == [(0.0, -1.5), (100.0, pytest.approx(0.0, abs=1e-9)), (200.0, 1.5)]


def test_lanes_for_vehicles_have_the_limit_of_their_direction() -> None:
    (only,) = layout((0.0, street("d< d= d> b> c>", speed_forward=20.0, speed_backward=10.0))).sections
    kinds = [(lane.id, lane.type.value, lane.speed) for lane in only.lanes]
    assert kinds == [
        (1, "driving", 10.0),
        (0, "none", None),
        (-1, "bidirectional", 20.0),
        (-2, "driving", 20.0),
        (-3, "bus", 20.0),
        (-4, "biking", None),
    ]
    found = layout((0.0, street("d< d>", speed_backward=10.0)))
    assert [lane.speed for lane in found.sections[0].lanes] == [10.0, None, None]
    assert [item.speed for item in found.types] == [10.0]


def test_a_guessed_limit_holds_where_none_is_known() -> None:
    found = layout((0.0, street("d< d>", "trunk", default_speed=30.0)))
    assert [lane.speed for lane in found.sections[0].lanes] == [30.0, None, 30.0]
    assert [(item.type, item.speed) for item in found.types] == [("rural", 30.0)]
    found = layout((0.0, street("d< d>", speed_backward=10.0, default_speed=30.0)))
    assert [lane.speed for lane in found.sections[0].lanes] == [10.0, None, 30.0]


def test_a_section_begins_where_another_limit_is_guessed() -> None:
    one, other = street("d< d>", default_speed=10.0), street("d< d>", default_speed=20.0)
    found = layout((0.0, one), (50.0, other))
    assert [section.s for section in found.sections] == [0.0, 50.0]
    assert [(item.s, item.speed) for item in found.types] == [(0.0, 10.0), (50.0, 20.0)]


def test_lanes_for_both_directions_are_bidirectional() -> None:
    (only,) = layout((0.0, street("d< d= d>"))).sections
    assert [(lane.id, lane.type.value) for lane in only.lanes] == [
        (1, "driving"),
        (0, "none"),
        (-1, "bidirectional"),
        (-2, "driving"),
    ]


def test_roads_that_are_alike_share_their_lanes() -> None:
    items = [street("d< d>"), street("d< d>", osm_way_id=7), street("d< d>", "residential"), street("d> d>")]
    items.append(street("d< d>", speed_forward=10.0))
    first, same, *others = lay_out_all([cut((0.0, item)) for item in items], Rule.RIGHT_HAND)
    assert first is same
    assert all(first is not item for item in others)


def limited(speed: float | None, highway: str = "secondary") -> StreetAttributes:
    return street("d< d>", highway, speed_forward=speed, speed_backward=speed)


def test_equal_lanes_with_another_speed_have_a_type_of_their_own() -> None:
    found = layout((0.0, limited(10.0)), (50.0, limited(20.0)), (80.0, limited(20.0)))
    assert [(item.s, item.type, item.speed) for item in found.types] == [(0.0, "town", 10.0), (50.0, "rural", 20.0)]
    assert [item.s for item in found.offset] == [0.0]


@pytest.mark.parametrize(
    ("highway", "speed", "expected"),
    [
        ("motorway", math.inf, "motorway"),
        ("motorway_link", None, "motorway"),
        ("living_street", 2.0, "lowSpeed"),
        ("trunk", None, "rural"),
        ("trunk", 50 / 3.6, "townExpressway"),
        ("trunk_link", 61 / 3.6, "rural"),
        ("trunk_link", 60 / 3.6, "townExpressway"),
        ("trunk_link", None, "rural"),
        ("motorway", 50 / 3.6, "motorway"),
        # Rural is what goes beyond the limits of towns, 60 km/h.
        ("secondary", 60 / 3.6, "town"),
        ("secondary", 61 / 3.6, "rural"),
        ("primary", 100 / 3.6, "rural"),
        ("primary", 50 / 3.6, "town"),
        ("residential", None, "town"),
        ("track", None, "rural"),
    ],
)
def test_road_types(highway: str, speed: float | None, expected: str) -> None:
    found = layout((0.0, limited(speed, highway)))
    assert [(item.s, item.type, item.speed) for item in found.types] == [(0.0, expected, speed)]


def test_marks_between_lanes_and_at_the_edges() -> None:
    (item,) = layout((0.0, street("d< d> d>"))).sections
    marks = {lane.id: lane.road_mark.type for lane in item.lanes if lane.road_mark is not None}
    assert marks == {1: "solid", 0: "solid", -1: "broken", -2: "solid"}
    (item,) = layout((0.0, street("d< d>", "residential"))).sections
    assert {lane.road_mark.type for lane in item.lanes if lane.road_mark is not None} == {"none"}


def test_roads_whose_lanes_change_are_painted_as_in_their_country() -> None:
    road = cut((0.0, street("d< d>")), (50.0, street("d< d> d>")))
    (found,) = lay_out_all([road], Rule.RIGHT_HAND, None, find_country("US"))
    centres = [lane.road_mark for section in found.sections for lane in section.lanes if lane.id == 0]
    assert [(mark.type, mark.color) for mark in centres if mark] == [("broken", "yellow"), ("solid", "yellow")]


def test_relations_count_at_the_border_of_their_ways() -> None:
    """Ways 1 and 5, 2 and 6 have the same lanes: the border is that of ways 5 and 2."""

    def items(after: str) -> list[tuple[float, StreetAttributes]]:
        pairs = [(1, "d> d>"), (5, "d> d>"), (2, after), (6, after)]
        return [(50.0 * k, street(text, osm_way_id=way)) for k, (way, text) in enumerate(pairs)]

    def links(one: int, other: int) -> dict[int, int | None]:
        known = Connectivity.of([LaneConnectivity(9, one, 7, (), other, ((1, 2, False), (2, 3, False)))])
        (found,) = lay_out_all([cut(*items("d> d> d>"), end=200.0)], Rule.RIGHT_HAND, known)
        return {lane.id: lane.successor for lane in found.sections[0].lanes if lane.id}

    assert links(5, 2) == {-1: -2, -2: -3}
    assert links(1, 2) == links(5, 6) == links(1, 6) == {-1: -1, -2: -2}


@pytest.mark.parametrize(("first", "then"), [("d>", "d< d>"), ("d< d>", "d>")])
def test_no_lane_runs_against_a_one_way_stretch(first: str, then: str) -> None:
    road = cut((0.0, street(first)), (50.0, street(then)))
    (zone,) = taper_zones(road, Rule.RIGHT_HAND)
    # The zone begins where the second direction does, or ends where it ends.
    assert (zone.start if first == "d>" else zone.end) == pytest.approx(50.0)


def test_other_changes_push_no_lane_into_a_one_way_stretch() -> None:
    """Lanes that change 15 m before a one-way stretch do so earlier: these tapers take 29.75 m each."""
    one, two, last = street("d< d> d>"), street("d< d>"), street("d>")
    road = cut((0.0, one), (85.0, two), (100.0, last), end=200.0)
    zones = taper_zones(road, Rule.RIGHT_HAND)
    assert [(zone.start, zone.end) for zone in zones] == [pytest.approx((40.5, 70.25)), pytest.approx((70.25, 100.0))]
    road = cut((0.0, last), (100.0, two), (115.0, one), end=200.0)
    zones = taper_zones(road, Rule.RIGHT_HAND)
    assert [(zone.start, zone.end) for zone in zones] == [
        pytest.approx((100.0, 129.75)),
        pytest.approx((129.75, 159.5)),
    ]


def test_a_stretch_with_a_lane_for_bicycles_against_it_is_one_way() -> None:
    road = cut((0.0, street("d< d>")), (50.0, street("c< d>")))
    (zone,) = taper_zones(road, Rule.RIGHT_HAND)
    assert (zone.start, zone.end) == pytest.approx((20.25, 50.0))


def test_lanes_that_hardly_change_do_so_over_a_cars_length() -> None:
    # 8.5 times the 2 mm by which lanes widen are 2 cm.
    pieces = (0.0, street("d> d>", width=3.5)), (50.0, street("d> d>", width=3.502))
    (zone,) = taper_zones(cut(*pieces, end=100.0), Rule.RIGHT_HAND)
    assert (zone.start, zone.end) == pytest.approx((48.0, 52.0))
