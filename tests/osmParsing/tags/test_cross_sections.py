"""Tags of ways become lanes. The notation, from left to right: ^ along the way, v against it, = both ways; before it
b for bus, t for taxi, c for bicycle, - for none, nothing for all cars; behind it the first letters of the arrows.
"""

from __future__ import annotations

import pytest
from hypothesis import given, settings, strategies as st
from lane_notation import (
    RIGHT,
    codes,
    lane_tags,
    notation,
    section_of,
)
from osm_builder import tags_of

from osm2xodr.conventions.countries import LANE_WIDTH, ONE_LANE_WIDTH
from osm2xodr.diagnostics import Kind
from osm2xodr.model import Direction, LaneType, Rule
from osm2xodr.osmParsing.defaults import (
    LANE_WIDEST,
    LANE_WIDTH_BICYCLE,
    LANE_WIDTH_MAX,
    LANE_WIDTH_MIN,
    MARGIN_WIDTH_MIN,
)
from osm2xodr.osmParsing.tags.cross_sections import Kerbs, StreetFacts, cross_section

LEFT = Rule.LEFT_HAND


# Tags, lanes with right-hand traffic, lanes with left-hand traffic. Real ways are named by their OSM id.
TABLE = [
    # -- two-way, counts alone
    ("", "v ^", "^ v"),
    ("lanes=2", "v ^", "^ v"),
    ("lanes=1", "v ^", "^ v"),
    ("lanes=1.5", "v ^", "^ v"),
    ("lanes=4", "v v ^ ^", "^ ^ v v"),
    ("lanes=3", "v ^ ^", "^ ^ v"),
    ("lanes=3 lanes:backward=2", "v v ^", "^ v v"),  # way/62293930
    ("lanes=3 lanes:forward=2", "v ^ ^", "^ ^ v"),
    ("lanes:forward=2 lanes:backward=1", "v ^ ^", "^ ^ v"),  # way/312835476
    ("lanes:backward=3", "v v v ^", "^ v v v"),
    ("lanes=2 lanes:forward=1", "v ^", "^ v"),
    ("lanes=many", "v ^", "^ v"),
    ("lanes=99", "v ^", "^ v"),
    # -- two-way with lanes for both directions
    ("lanes=3 lanes:forward=1 lanes:backward=1 lanes:both_ways=1", "v = ^", "^ = v"),
    ("lanes=5 lanes:both_ways=1 turn:lanes:both_ways=left", "v v =l ^ ^", "^ ^ =l v v"),
    ("lanes=3 turn:lanes:both_ways=left", "v =l ^", "^ =l v"),
    ("lanes=3 lanes:forward=1 lanes:backward=1", "v = ^", "^ = v"),  # way/388832784
    ("lanes=3 lanes:forward=1 lanes:backward=1 lanes:reversible=1", "v = ^", "^ = v"),  # way/253992098
    ("lanes=2 lanes:forward=1 lanes:backward=1 lanes:both_ways=1", "v ^", "^ v"),  # way/828376812
    # -- two-way with lists: each from left to right as its own drivers see it
    ("lanes=3 lanes:forward=2 lanes:backward=1 turn:lanes:forward=left|through;right", "v ^l ^rt", "^l ^rt v"),
    ("lanes=3 lanes:backward=2 lanes:forward=1 turn:lanes:backward=left;through|right", "vr vlt ^", "^ vr vlt"),
    ("lanes=4 turn:lanes:backward=left|left;through;right", "vlrt vl ^ ^", "^ ^ vlrt vl"),  # way/4084803
    ("lanes=3 turn:lanes:forward=none|merge_to_left", "v ^ ^m", "^ ^m v"),  # way/4276049
    ("lanes=3 turn:lanes:backward=none|merge_to_left", "vm v ^", "^ vm v"),  # way/325495172
    ("lanes=2 turn:lanes:backward=left", "vl ^", "^ vl"),  # way/24252898
    ("lanes=2 turn:lanes:forward=left|right", "v ^l ^r", "^l ^r v"),  # way/386099546
    ("lanes:forward=2 lanes:backward=1 turn:lanes:backward=left|through", "vt vl ^ ^", "^ ^ vt vl"),  # way/8061590
    # way/253992100
    (
        "lanes=3 lanes:forward=1 lanes:backward=2 access:lanes:backward=no|yes bus:lanes:backward=designated|yes",
        "v bv ^",
        "^ v bv",
    ),
    ("turn:lanes=left|through lanes=3", "v ^ ^", "^ ^ v"),  # no direction: ignored
    ("lanes=2 turn:forward=left", "v ^l", "^l v"),
    # -- one-way
    ("oneway=yes", "^", "^"),
    ("oneway=yes lanes=3", "^ ^ ^", "^ ^ ^"),
    ("oneway=yes lanes:forward=2", "^ ^", "^ ^"),
    ("oneway=-1 lanes=2", "v v", "v v"),
    ("oneway=yes turn:lanes=left|through|right", "^l ^t ^r", "^l ^t ^r"),
    # Arrows are as drivers see them: against the way, they stand the other way round.
    ("oneway=-1 lanes=4 turn:lanes=left|left|right|right", "vr vr vl vl", "vr vr vl vl"),  # way/253238771
    ("oneway=-1 turn:lanes:backward=left|through", "vt vl", "vt vl"),
    ("oneway=yes lanes=2 turn:lanes=left|through|through;right", "^l ^t ^rt", "^l ^t ^rt"),  # way/242679559
    ("oneway=yes lanes=3 turn:lanes=left|through", "^ ^ ^", "^ ^ ^"),
    ("oneway=yes lanes=1 turn=slight_right", "^s", "^s"),
    ("oneway=yes lanes=2 turn=right", "^r ^r", "^r ^r"),
    ("oneway=yes lanes=3 lanes:forward=2 lanes:backward=1", "^ ^", "^ ^"),
    ("oneway=yes lanes=2;3", "^ ^", "^ ^"),
    # -- one-way with lanes that are not for all: way/251106575, /69340957, /33097750, /182932159, /159234700
    (
        (
            "oneway=yes lanes=4 access:lanes=yes|yes|yes|no|yes bicycle:lanes=yes|yes|yes|designated|yes "
            "turn:lanes=left|through|through|none|right"
        ),
        "^l ^t ^t c^ ^r",
        "^l ^t ^t c^ ^r",
    ),
    ("oneway=yes lanes=2 motor_vehicle:lanes=yes|no bicycle:lanes=yes|designated", "^ c^", "^ c^"),
    ("oneway=yes lanes=3 access:lanes=yes|yes|no bus:lanes=yes|yes|designated", "^ ^ b^", "^ ^ b^"),
    ("oneway=-1 lanes=3 access:lanes=yes|yes|no bus:lanes=yes|yes|designated", "bv v v", "bv v v"),
    ("oneway=yes lanes=2 access:lanes=yes|no bus:lanes=yes|designated lanes:bus=1", "^ b^", "^ b^"),
    ("oneway=yes lanes=1 width:lanes=4|2", "^ c^", "^ c^"),
    ("oneway=yes lanes=2 access:lanes=no|no", "^ ^", "^ ^"),
    ("oneway=yes access:lanes=no|no", "^", "^"),
]


@pytest.mark.parametrize(("tags", "right", "left"), TABLE)
def test_lanes(tags: str, right: str, left: str) -> None:
    assert notation(section_of(tags, RIGHT).lanes_ltr) == right
    assert notation(section_of(tags, LEFT).lanes_ltr) == left


@pytest.mark.parametrize(
    ("highway", "lanes"), [("motorway", "^ ^"), ("trunk", "^ ^"), ("motorway_link", "^"), ("primary", "^")]
)
def test_one_way_roads_without_lanes(highway: str, lanes: str) -> None:
    assert notation(cross_section({"highway": highway}, 1, RIGHT).lanes_ltr) == lanes


@pytest.mark.parametrize(
    ("tags", "expected"),
    [
        ("lanes=2 width=6", []),
        ("lanes=4 width=12", []),
        ("lanes=2", [(Kind.GUESSED, "lane-width")]),
        ("width=6", [(Kind.GUESSED, "lane-count")]),
        ("lanes=1 width=5", [(Kind.GUESSED, "lane-count")]),
        ("lanes=3 width=9", [(Kind.GUESSED, "lane-count")]),
        ("lanes=3 lanes:forward=2 width=9", []),
        ("lanes=3 turn:lanes:forward=left|right width=9", []),
        ("lanes:forward=2 width=9", [(Kind.GUESSED, "lane-count")]),
        ("lanes=4 lanes:forward=2 lanes:backward=1 width=9", [(Kind.REPAIRED, "lane-count")]),
        ("lanes=2;3 width=7", [(Kind.GUESSED, "lane-count")]),
        ("lanes=many width=6", [(Kind.DROPPED, "lane-count"), (Kind.GUESSED, "lane-count")]),
        ("oneway=yes lanes=2 turn:lanes=left|through|right width=9", [(Kind.REPAIRED, "lane-count")]),
        ("oneway=yes lanes=3 turn:lanes=left|right width=9", [(Kind.DROPPED, "lane-lists")]),
        ("oneway=yes lanes=3 lanes:backward=1 width=6", [(Kind.DROPPED, "contraflow")]),
        ("lanes=2 width=3", [(Kind.REPAIRED, "lane-width")]),
        ("lanes=2 width=9", [(Kind.GUESSED, "margin-width")]),
        ("lanes=2 width=20", [(Kind.GUESSED, "margin-width"), (Kind.REPAIRED, "lane-width")]),
        ("lanes=2 width=0.5", [(Kind.DROPPED, "width"), (Kind.GUESSED, "lane-width")]),
        ("lanes=2 width=wide est_width=6", [(Kind.DROPPED, "width")]),
        ("oneway=yes lanes=2 width=6 placement=left_of:7", [(Kind.DROPPED, "placement")]),
        ("lanes=2 width=6 placement=right_of:1", [(Kind.DROPPED, "placement")]),
        ("lanes=2 width=6 placement=transition", [(Kind.NOTE, "placement")]),
    ],
)
def test_what_is_said(tags: str, expected: list[tuple[Kind, str]]) -> None:
    assert codes(section_of(tags)) == expected


# ---------------------------------------------------------------- widths


@pytest.mark.parametrize(
    ("tags", "widths"),
    [
        ("lanes=2 width=7", [3.5, 3.5]),
        ("lanes=2 width=23'", [3.5052, 3.5052]),
        ("lanes=2 est_width=6", [3.0, 3.0]),
        ("lanes=2 width=9 width:carriageway=6", [3.0, 3.0]),
        ("oneway=yes lanes=1 width=4.5", [4.5]),
        ("lanes=2 width=3", [LANE_WIDTH_MIN] * 2),
        ("lanes=2 width=15", [LANE_WIDEST + MARGIN_WIDTH_MIN] * 2),
        # One lane's width for both directions.
        ("lanes=1", [ONE_LANE_WIDTH["secondary"] / 2] * 2),
        ("lanes=1 width=5", [2.5, 2.5]),
        ("lanes=1 width=2.5", [LANE_WIDTH_MIN] * 2),
        ("oneway=yes lanes=3 width:lanes=3.5|3|2.75", [3.5, 3.0, 2.75]),
        ("oneway=-1 lanes=3 width:lanes=3.5|3|2.75", [2.75, 3.0, 3.5]),
        ("lanes=2 width:lanes:forward=3 width:lanes:backward=4", [4.0, 3.0]),
        # The rest of the carriageway is shared out to the lanes without a width of their own.
        ("oneway=yes lanes=2 width=7 width:lanes=4|", [4.0, 3.0]),
        (
            "oneway=yes lanes=2 width=7.5 access:lanes=yes|yes|no bicycle:lanes=yes|yes|designated",
            [3.0, 3.0, LANE_WIDTH_BICYCLE],
        ),
        # Widths of lanes are believed before that of the whole: way/164679021 (parking on both sides)
        ("lanes=2 width=15 width:lanes:forward=3.3 width:lanes:backward=3.3", [3.3, 3.3]),
        ("lanes=2", [LANE_WIDTH["secondary"]] * 2),
    ],
)
def test_widths(tags: str, widths: list[float]) -> None:
    assert [lane.width for lane in section_of(tags).lanes_ltr] == pytest.approx(widths)


@pytest.mark.parametrize(
    ("tags", "in_town", "lanes", "beside"),
    [
        ("lanes=2 width=7.4", True, [3.7, 3.7], []),
        ("lanes=2 width=9", True, [3.5, 3.5], [(LaneType.SHOULDER, 1.0)]),
        ("lanes=2 width=11", True, [3.5, 3.5], [(LaneType.PARKING, 2.0)]),
        ("lanes=2 width=11", False, [3.5, 3.5], [(LaneType.SHOULDER, 2.0)]),
        ("lanes=2 width=11 parking:both=no", True, [3.5, 3.5], [(LaneType.SHOULDER, 2.0)]),
        ("lanes=2 width=11 parking:both=lane", True, [3.5, 3.5], [(LaneType.PARKING, 2.0)]),
        ("lanes=2 width=12 parking:both=lane", True, [3.5, 3.5], [(LaneType.PARKING, 2.5)]),
        ("oneway=yes lanes=1 width=8.35", True, [4.75], [(LaneType.PARKING, 1.8)]),
    ],
)
def test_lanes_are_no_wider_than_built(
    tags: str, in_town: bool, lanes: list[float], beside: list[tuple[LaneType, float]]
) -> None:
    direction = 1 if "oneway" in tags else 0
    section = cross_section({"highway": "secondary", **tags_of(tags)}, direction, RIGHT, in_town=in_town)
    assert [lane.width for lane in section.lanes_ltr] == pytest.approx(lanes)
    assert [(strip.type, strip.width) for strip in section.margin_left] == beside
    assert section.margin_left == section.margin_right
    assert section.middle_offset == 0.0


def test_default_lane_width() -> None:
    def widths(tags: str) -> list[float]:
        return [lane.width for lane in cross_section(tags_of(tags), 0, RIGHT, 3.3).lanes_ltr]

    assert widths("highway=residential") == [3.3, 3.3]
    assert widths("highway=residential lanes=1") == [LANE_WIDTH_MIN, LANE_WIDTH_MIN]
    assert widths("highway=residential width=5") == [2.5, 2.5]
    # It is the user's choice, not a guess.
    assert codes(cross_section(tags_of("highway=primary lanes=2"), 0, RIGHT, 3.3)) == []


@pytest.mark.parametrize("highway", sorted(LANE_WIDTH))
def test_every_class_has_a_sensible_width(highway: str) -> None:
    (alone,) = cross_section({"highway": highway, "lanes": "1"}, 1, RIGHT).lanes_ltr
    assert alone.width == ONE_LANE_WIDTH.get(highway, LANE_WIDTH[highway])
    one, other = cross_section({"highway": highway, "lanes": "2"}, 0, RIGHT).lanes_ltr
    assert one.width == other.width == LANE_WIDTH[highway]
    assert LANE_WIDTH_MIN <= one.width <= alone.width <= LANE_WIDTH_MAX


@pytest.mark.parametrize(
    ("tags", "width"),
    [
        ("oneway=yes lanes=1", 4.75),
        ("oneway=yes lanes=1 cycleway:right=lane", 3.25),
        ("oneway=yes lanes=1 parking:right=lane", 4.75),
        ("oneway=yes lanes=1 parking:both=lane", 4.75),
        ("oneway=yes lanes=1 sidewalk=both cycleway:right=track", 4.75),
        ("oneway=yes lanes=2", 3.0),
        ("lanes=2", 3.25),
        ("lanes=4", 3.0),
        ("lanes=3 lanes:both_ways=1", 3.25),
    ],
)
def test_lanes_in_town_by_what_lies_beside_them(tags: str, width: float) -> None:
    direction = int("oneway" in tags)
    for rule in Rule:
        section = cross_section(tags_of(f"highway=secondary {tags}"), direction, rule, in_town=True)
        cars = {lane.width for lane in section.lanes_ltr if lane.type is LaneType.DRIVING}
        assert cars == {width}


def test_lanes_out_of_town_are_as_wide_beside_others() -> None:
    assert [lane.width for lane in section_of("oneway=yes lanes=2").lanes_ltr] == [3.25, 3.25]


# ---------------------------------------------------------------- placement

WIDE = "oneway=yes lanes=3 width:lanes=4|3|2"  # 9 m in all, edges at 0, 4, 7, 9


@pytest.mark.parametrize(
    ("tags", "offset"),
    [
        # The line's place from the left edge, less half of the width.
        (f"{WIDE} placement=left_of:1", 0.0 - 4.5),
        (f"{WIDE} placement=middle_of:1", 2.0 - 4.5),
        (f"{WIDE} placement=right_of:1", 4.0 - 4.5),
        (f"{WIDE} placement=left_of:2", 4.0 - 4.5),
        (f"{WIDE} placement=middle_of:2", 5.5 - 4.5),
        (f"{WIDE} placement=right_of:3", 9.0 - 4.5),
        (f"{WIDE} placement:forward=right_of:2", 7.0 - 4.5),
        (f"{WIDE} placement=transition", 0.0),
        # Beside a lane that is about to begin, or has just ended.
        (f"{WIDE} placement=left_of:4", 9.0 - 4.5),
        (f"{WIDE} placement=right_of:0", 0.0 - 4.5),
        (f"{WIDE} placement=left_of:-1", 0.0),  # way/234374817
        (f"{WIDE} placement=beside:1", 0.0),
        (f"{WIDE} placement:backward=left_of:1", 0.0),
        # Against the way the first lane is the one on the right of who looks along it.
        ("oneway=-1 lanes=3 width:lanes=4|3|2 placement=right_of:1", 5.0 - 4.5),
        ("oneway=-1 lanes=3 width:lanes=4|3|2 placement=left_of:1", 9.0 - 4.5),
        ("oneway=-1 lanes=3 width:lanes=4|3|2 placement:backward=middle_of:3", 1.0 - 4.5),
        # Bicycle lanes count: way/251106198
        (
            (
                "oneway=yes lanes=3 width:lanes=3.2|3.2|3.2|1.5 access:lanes=yes|yes|yes|no "
                "bicycle:lanes=yes|yes|yes|designated placement=right_of:2"
            ),
            6.4 - 5.55,
        ),
    ],
)
def test_placement_of_one_way_roads(tags: str, offset: float) -> None:
    assert section_of(tags).middle_offset == pytest.approx(offset)
    assert section_of(tags, LEFT).middle_offset == pytest.approx(offset)


TWO_WAY = "lanes=3 lanes:forward=2 lanes:backward=1 width:lanes:forward=3|4 width:lanes:backward=2"


@pytest.mark.parametrize(
    ("tags", "right", "left"),
    [
        # Right-hand: v(2) ^(3) ^(4), edges 0 2 5 9. Left-hand: ^(3) ^(4) v(2), edges 0 3 7 9.
        ("placement:forward=left_of:1", 2.0 - 4.5, 0.0 - 4.5),
        ("placement:forward=right_of:1", 5.0 - 4.5, 3.0 - 4.5),
        ("placement:forward=middle_of:2", 7.0 - 4.5, 5.0 - 4.5),
        ("placement:forward=right_of:2", 9.0 - 4.5, 7.0 - 4.5),
        ("placement:backward=left_of:1", 2.0 - 4.5, 9.0 - 4.5),
        ("placement:backward=right_of:1", 0.0 - 4.5, 7.0 - 4.5),
        ("placement:forward=left_of:1 placement:backward=left_of:1", 2.0 - 4.5, 0.0 - 4.5),
        ("placement:forward=transition", 0.0, 0.0),
        ("placement=right_of:1", 0.0, 0.0),
    ],
)
def test_placement_of_two_way_roads(tags: str, right: float, left: float) -> None:
    assert section_of(f"{TWO_WAY} {tags}", RIGHT).middle_offset == pytest.approx(right)
    assert section_of(f"{TWO_WAY} {tags}", LEFT).middle_offset == pytest.approx(left)


def test_placements_that_disagree() -> None:
    section = section_of(f"{TWO_WAY} placement:forward=left_of:2 placement:backward=left_of:1")
    assert section.middle_offset == pytest.approx(5.0 - 4.5)
    assert codes(section) == [(Kind.REPAIRED, "placement")]


# ---------------------------------------------------------------- whatever is tagged


MOTOR = {LaneType.DRIVING, LaneType.BUS, LaneType.TAXI}


@given(lane_tags(), st.sampled_from([-1, 0, 1]), st.sampled_from([-1, 0, 1]), st.sampled_from(Rule))
@settings(deadline=None)
def test_whatever_is_tagged_there_are_lanes_to_drive_on(
    tags: dict[str, str], direction: int, closed: int, rule: Rule
) -> None:
    closed = 0 if direction else closed
    section = cross_section(tags, direction, rule, None, closed)
    runs = [lane.direction for lane in section.lanes_ltr]
    drivable = {lane.direction for lane in section.lanes_ltr if lane.type in MOTOR}
    if direction or closed:
        along = Direction(direction or -closed)
        assert along in drivable
        against = {lane.type for lane in section.lanes_ltr if lane.direction == -along}
        assert LaneType.DRIVING not in against
    else:
        assert {Direction.FORWARD, Direction.BACKWARD} <= drivable
    # Directions stand together, in the order of the side that traffic keeps to.
    assert runs == sorted(runs, reverse=rule is Rule.LEFT_HAND)
    assert all(0.5 <= lane.width <= 10.0 for lane in section.lanes_ltr)
    assert abs(section.middle_offset) <= sum(lane.width for lane in section.lanes_ltr) / 2.0 + 1e-9
    assert section == cross_section(dict(reversed(tags.items())), direction, rule, None, closed)


def kerbs(
    left: float | None, right: float | None, tags: str, street_width: float | None = None
) -> tuple[list[float], float]:
    """Return the widths of the lanes of a residential street with kerbs, m, and t of their middle."""
    between = Kerbs(left, right) if left or right else None
    values = {"highway": "residential", **tags_of(tags)}
    section = cross_section(values, 0, RIGHT, facts=StreetFacts(between, street_width))
    return [round(lane.width, 3) for lane in section.lanes_ltr], round(section.middle_offset, 3)


PARALLEL = "parking:{0}=lane parking:{0}:orientation=parallel"
ANGLED = "parking:{0}=lane parking:{0}:orientation=perpendicular"


@pytest.mark.parametrize(
    ("left", "right", "tags", "widths", "middle"),
    [
        # A width that somebody measured from kerb to kerb is as good, others may leave parked cars out.
        (4.0, -4.0, "width:carriageway=7", [3.5, 3.5], 0.0),
        (4.0, -4.0, "width=6", [3.5, 3.5], 0.0),
        (4.0, -4.0, "est_width=6", [3.5, 3.5], 0.0),
        # Lanes with widths of their own stay, wherever they lie between the kerbs.
        (5.0, -4.0, "lanes=2 width:lanes:forward=3 width:lanes:backward=3", [3.0, 3.0], 0.0),
        (3.5, -2.5, "lanes=2 width:lanes:forward=3 width:lanes:backward=3", [3.0, 3.0], 0.5),
        (4.0, -2.0, "lanes=2 placement:forward=left_of:1", [3.0, 3.0], 0.0),
        # 10 m with two parallel rows of 2 m; 8 m with one on the left.
        (5.0, -5.0, PARALLEL.format("both"), [3.0, 3.0], 0.0),
        (4.5, -3.5, PARALLEL.format("left"), [3.0, 3.0], -0.5),
        # No room for 2 + 5 m: who parks at right angles does so beside the carriageway.
        (4.0, -4.0, f"{PARALLEL.format('left')} {ANGLED.format('right')}", [3.0, 3.0], -1.0),
        # And none for any.
        (2.6, -2.6, f"{PARALLEL.format('left')} {ANGLED.format('right')}", [2.6, 2.6], 0.0),
        # One kerb: the other edge stays where the tags have it, and where they have the width both move.
        (3.8, None, "", [3.4, 3.4], 0.4),
        (None, -2.4, "", [2.7, 2.7], 0.3),
        (None, -2.6, "width=7", [3.5, 3.5], 0.9),
        # More than 1 m farther out than by tags: the other edge is as far away; with a width something is wrong.
        (4.2, None, "", [3.5, 3.5], 0.0),
        (None, -5.0, "width=7", [3.5, 3.5], 0.0),
        # More than 3 m, or on the wrong side of the line: something lies between.
        (6.2, None, "", [3.0, 3.0], 0.0),
        (None, 1.5, "", [3.0, 3.0], 0.0),
        # 15 m are 2 lanes and what lies beside them, 16 m are something else.
        (7.5, -7.5, "", [3.8, 3.8], 0.0),
        (8.0, -8.0, "", [3.0, 3.0], 0.0),
        (8.0, -8.0, "lanes=4", [3.5, 3.5, 3.5, 3.5], 0.0),
        # 21 m are 4 lanes of 4.25 m and parked cars, 22 m are something else: lanes abreast are narrower than two.
        (10.5, -10.5, "lanes=4", [3.65, 3.65, 3.65, 3.65], 0.0),
        (11.0, -11.0, "lanes=4", [3.0, 3.0, 3.0, 3.0], 0.0),
    ],
)
def test_kerbs(left: float | None, right: float | None, tags: str, widths: list[float], middle: float) -> None:
    assert kerbs(left, right, tags) == (widths, middle)


def test_the_same_street_tells_the_width_where_nothing_else_does() -> None:
    assert kerbs(None, None, "", street_width=7.0) == ([3.5, 3.5], 0.0)
    assert kerbs(None, None, "width=6", street_width=7.0) == ([3.0, 3.0], 0.0)
    assert kerbs(4.0, -4.0, "", street_width=7.0) == ([3.5, 3.5], 0.0)
    # Not if it is no width of so few lanes.
    assert kerbs(None, None, "", street_width=30.0) == ([3.0, 3.0], 0.0)


def test_the_same_street_is_a_guess() -> None:
    section = cross_section({"highway": "residential", "lanes": "2"}, 0, RIGHT, facts=StreetFacts(width=7.0))
    assert section.findings == ((Kind.GUESSED, "width", "no width given, 7 m as on the same street"),)
