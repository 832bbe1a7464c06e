"""Marks by country, class and tags."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from lane_cases import street

from osm2xodr.conventions.countries import GENERIC, Country, find_country
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import build_roads
from osm2xodr.geometry.lanes.cross_sections import cross_section
from osm2xodr.geometry.lanes.road_marks import NO_MARK, mark_kind, road_marks, same_marks
from osm2xodr.model import (
    Direction,
    LaneType,
    MarginSpec,
    Road,
    RoadMark,
    Rule,
    StreetAttributes,
)
from osm2xodr.osmParsing import ParseOptions, parse_osm
from osm2xodr.surface import FlatSurface

F, B, BOTH = Direction.FORWARD, Direction.BACKWARD, Direction.BOTH
RIGHT, LEFT = Rule.RIGHT_HAND, Rule.LEFT_HAND


def marks_of(attributes: StreetAttributes, rule: Rule = RIGHT, country: Country = GENERIC) -> dict[int, RoadMark]:
    return road_marks(cross_section(attributes, rule), attributes, rule, country)


def kinds_of(attributes: StreetAttributes, rule: Rule = RIGHT, country: Country = GENERIC) -> list[tuple[str, str]]:
    """Return type and lane change from left to right."""
    marks = marks_of(attributes, rule, country)
    return [(marks[lane].type, marks[lane].lane_change) for lane in sorted(marks, reverse=True)]


SOLID, BROKEN, NONE, OPEN = ("solid", "none"), ("broken", "both"), ("none", "none"), ("none", "both")


@pytest.mark.parametrize(
    ("highway", "text", "expected"),
    [
        ("primary", "d< d>", [SOLID, BROKEN, SOLID]),
        ("primary", "d< d> d>", [SOLID, SOLID, BROKEN, SOLID]),
        ("primary", "d> d>", [SOLID, BROKEN, SOLID]),
        ("primary", "d< d<", [SOLID, BROKEN, SOLID]),
        ("motorway", "d> d> d>", [SOLID, BROKEN, BROKEN, SOLID]),
        ("primary", "d=", [SOLID, SOLID]),
        ("unclassified", "d< d>", [NONE, BROKEN, NONE]),
        ("residential", "d< d>", [NONE, OPEN, NONE]),
        ("residential", "d< d> d>", [NONE, OPEN, BROKEN, NONE]),
        ("service", "d>", [NONE, NONE]),
        # Beside lanes for buses and bicycles the line is solid; cars cross a bicycle lane that is between theirs.
        ("primary", "d> b>", [SOLID, SOLID, SOLID]),
        ("primary", "b> b>", [SOLID, BROKEN, SOLID]),
        ("primary", "c< d< d> c>", [SOLID, SOLID, BROKEN, SOLID, SOLID]),
        ("primary", "d> c> d>", [SOLID, BROKEN, BROKEN, SOLID]),
        ("primary", "c< d>", [SOLID, SOLID, SOLID]),
        ("residential", "c< d>", [NONE, SOLID, NONE]),
        # The middle lane is entered over its broken lines.
        ("primary", "d< d= d>", [SOLID, ("solid broken", "both"), ("broken solid", "both"), SOLID]),
    ],
)
def test_lines_by_class_and_lanes(highway: str, text: str, expected: list[tuple[str, str]]) -> None:
    assert kinds_of(street(text, highway)) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        # Lanes right of the centre: the mark's words go from left to right, lane ids fall to the right.
        ("d>:yes d>:yes", BROKEN),
        ("d>:no d>:no", SOLID),
        ("d>:not_right d>", ("solid broken", "increase")),
        ("d>:only_left d>", ("solid broken", "increase")),
        ("d> d>:not_left", ("broken solid", "decrease")),
        ("d> d>:only_right", ("broken solid", "decrease")),
        ("d>:not_left d>:not_right", BROKEN),
        ("d>:not_right d>:not_left", SOLID),
        # Lanes left of the centre: words go from right to left; their drivers look the other way.
        ("d<:not_left d<", ("broken solid", "increase")),
        ("d< d<:not_right", ("solid broken", "decrease")),
        ("d<:only_left d<:only_right", BROKEN),
        # A bus lane that cars may enter, but not leave.
        ("d>:yes b>:no", ("broken solid", "decrease")),
        ("d>:nonsense d>", BROKEN),
    ],
)
def test_changing_lanes(text: str, expected: tuple[str, str]) -> None:
    assert kinds_of(street(text))[1] == expected


@pytest.mark.parametrize(
    ("forbidden", "expected"),
    [
        ((), ("broken", "both")),
        ((F, B), ("solid", "none")),
        # Who must not overtake has the solid line on his side; right-hand traffic runs forward right of the centre.
        ((F,), ("broken solid", "decrease")),
        ((B,), ("solid broken", "increase")),
    ],
)
@pytest.mark.parametrize("highway", ["primary", "residential"])
def test_no_overtaking(forbidden: tuple[Direction, ...], expected: tuple[str, str], highway: str) -> None:
    found = kinds_of(street("d< d>", highway, no_overtaking=frozenset(forbidden)))[1]
    assert found == (expected if forbidden or highway == "primary" else OPEN)


@pytest.mark.parametrize(
    ("marked", "highway", "width", "expected"),
    [
        (None, "primary", 3.0, [SOLID, BROKEN, SOLID]),
        (None, "primary", 2.5, [SOLID, OPEN, SOLID]),
        (True, "primary", 2.5, [SOLID, BROKEN, SOLID]),
        (True, "residential", 2.5, [SOLID, BROKEN, SOLID]),
        (True, "unclassified", 3.0, [SOLID, BROKEN, SOLID]),
        (False, "primary", 3.5, [NONE, OPEN, NONE]),
    ],
)
def test_lane_markings(marked: bool | None, highway: str, width: float, expected: list[tuple[str, str]]) -> None:
    assert kinds_of(street("d< d>", highway, width, marked=marked)) == expected


@pytest.mark.parametrize(("width", "expected"), [(2.75, BROKEN), (2.749, OPEN)])
def test_a_centre_line_needs_a_carriageway_of_5_5_m(width: float, expected: tuple[str, str]) -> None:
    assert kinds_of(street("d< d>", width=width))[1] == expected
    # Lanes for bicycles do not count.
    assert kinds_of(street("c< d< d> c>", width=width))[2] == expected
    assert kinds_of(street("d< d> d>", width=2 * width / 3))[1] == (SOLID if expected == BROKEN else OPEN)


@pytest.mark.parametrize("highway", ["residential", "living_street", "service", "track", "pedestrian"])
def test_streets_without_lines(highway: str) -> None:
    assert kinds_of(street("d< d>", highway)) == [NONE, OPEN, NONE]
    assert kinds_of(street("d< d>", highway, marked=True)) == [SOLID, BROKEN, SOLID]


@pytest.mark.parametrize("highway", ["unclassified", "road", "busway"])
def test_streets_without_edge_lines(highway: str) -> None:
    assert kinds_of(street("d< d>", highway)) == [NONE, BROKEN, NONE]
    assert kinds_of(street("d< d>", highway, marked=True)) == [SOLID, BROKEN, SOLID]


@pytest.mark.parametrize("highway", ["primary", "secondary", "tertiary", "trunk", "motorway", "trunk_link"])
def test_streets_with_all_lines(highway: str) -> None:
    assert kinds_of(street("d< d>", highway)) == [SOLID, BROKEN, SOLID]


def test_lanes_for_bicycles_are_marked_where_those_for_cars_are_not() -> None:
    assert kinds_of(street("c< d< d> c>", marked=False)) == [NONE, SOLID, OPEN, SOLID, NONE]


@pytest.mark.parametrize(
    ("divider", "expected"),
    [
        ("dashed_line", ("broken", "both")),
        ("solid_line", ("solid", "none")),
        ("double_solid_line", ("solid solid", "none")),
        ("median", ("solid", "none")),
        ("no", ("none", "both")),
        ("mystery", ("solid", "none")),
    ],
)
def test_divider(divider: str, expected: tuple[str, str]) -> None:
    assert kinds_of(street("d< d< d> d>", divider=divider))[2] == expected


@pytest.mark.parametrize(
    ("code", "text", "forbidden", "kind", "color"),
    [
        ("DE", "d< d>", (), "broken", "standard"),
        ("DE", "d< d>", (F, B), "solid", "standard"),
        ("DE", "d< d< d>", (), "solid", "standard"),
        ("DE", "d< d< d> d>", (), "solid solid", "standard"),
        ("US", "d< d>", (), "broken", "yellow"),
        ("US", "d< d>", (F, B), "solid solid", "yellow"),
        ("US", "d< d>", (F,), "broken solid", "yellow"),
        ("US", "d< d< d> d>", (), "solid solid", "yellow"),
        ("US", "d< d= d>", (), "solid broken", "yellow"),
        ("JP", "d< d>", (), "broken", "standard"),
        ("JP", "d< d>", (F, B), "solid", "yellow"),
        ("JP", "d< d< d> d>", (), "solid", "standard"),
        ("NZ", "d< d>", (F, B), "solid solid", "yellow"),
        ("GB", "d< d>", (F, B), "solid solid", "standard"),
        ("NO", "d< d>", (), "broken", "yellow"),
        ("XX", "d< d< d> d>", (), "solid", "standard"),
    ],
)
def test_centre_lines_by_country(
    code: str, text: str, forbidden: tuple[Direction, ...], kind: str, color: str
) -> None:
    attributes = street(text, no_overtaking=frozenset(forbidden))
    on_left = sum(lane.direction is B for lane in attributes.lanes_ltr)
    mark = marks_of(attributes, RIGHT, find_country(code))[0]
    assert (mark.type, mark.color) == (kind, color)
    assert on_left in (1, 2)


@pytest.mark.parametrize(
    ("code", "rule", "text", "left", "right"),
    [
        ("DE", RIGHT, "d> d>", "standard", "standard"),
        ("US", RIGHT, "d> d>", "yellow", "standard"),
        ("US", RIGHT, "d< d<", "standard", "yellow"),
        ("US", RIGHT, "d< d>", "standard", "standard"),
        ("VI", LEFT, "d> d>", "standard", "yellow"),
        ("NO", RIGHT, "d> d>", "yellow", "standard"),
        ("ZA", LEFT, "d> d>", "yellow", "standard"),
        ("ZA", LEFT, "d> d<", "yellow", "yellow"),
    ],
)
def test_edge_lines_by_country(code: str, rule: Rule, text: str, left: str, right: str) -> None:
    marks = marks_of(street(text, "trunk"), rule, find_country(code))
    assert [marks[max(marks)].color, marks[min(marks)].color] == [left, right]
    assert {marks[max(marks)].type, marks[min(marks)].type} == {"solid"}


def test_solid_lines_between_lanes_of_japan_are_yellow() -> None:
    marks = marks_of(street("d>:no d>:no b>"), LEFT, find_country("JP"))
    assert [(marks[lane].type, marks[lane].color) for lane in (1, 2)] == [("solid", "standard"), ("solid", "yellow")]


@pytest.mark.parametrize(
    ("code", "highway", "line", "edge", "special"),
    [
        ("DE", "primary", 0.12, 0.12, 0.25),
        ("DE", "motorway", 0.15, 0.15, 0.30),
        ("US", "primary", 0.10, 0.10, 0.20),
        ("US", "motorway", 0.15, 0.15, 0.30),
        ("FR", "primary", 0.12, 0.18, 0.25),
        ("FR", "motorway", 0.15, 0.225, 0.30),
    ],
)
def test_widths(code: str, highway: str, line: float, edge: float, special: float) -> None:
    marks = marks_of(street("d> d> b>", highway), RIGHT, find_country(code))
    assert [marks[lane].width for lane in (0, -1, -2, -3)] == [edge, line, special, edge]


@pytest.mark.parametrize(
    ("text", "forbidden", "divider", "color", "kind"),
    [
        ("d< d>", (), "", "yellow", "broken"),
        ("d< d>", (), "dashed_line", "yellow", "broken"),
        ("d< d>", (F, B), "", "yellow", "solid solid"),
        ("d< d>", (F,), "", "yellow", "broken solid"),
        ("d< d>", (), "solid_line", "yellow", "solid solid"),
        ("d< d> d>", (), "", "yellow", "solid"),
        ("d< d= d>", (), "", "yellow", "broken solid"),
        # Beside lanes for bicycles against the street the line is as wide as beside those along it.
        ("c< d>", (), "", "yellow", "solid"),
    ],
)
@pytest.mark.parametrize(("highway", "width", "special"), [("primary", 0.10, 0.20), ("motorway", 0.15, 0.30)])
def test_colour_and_width_of_what_is_between_directions(
    text: str,
    forbidden: tuple[Direction, ...],
    divider: str,
    color: str,
    kind: str,
    highway: str,
    width: float,
    special: float,
) -> None:
    attributes = street(text, highway, no_overtaking=frozenset(forbidden), divider=divider)
    mark = marks_of(attributes, RIGHT, find_country("US"))[-1 if "=" in text else 0]
    assert (mark.type, mark.color, mark.width) == (kind, color, special if "c" in text else width)


@pytest.mark.parametrize(
    ("kind", "highway", "expected"),
    [
        (LaneType.SIDEWALK, "primary", "none"),
        (LaneType.PARKING, "primary", "none"),
        (LaneType.BORDER, "secondary", "none"),
        (LaneType.SHOULDER, "primary", "solid"),
        (LaneType.BORDER, "motorway", "solid"),
        (LaneType.SHOULDER, "motorway", "solid"),
    ],
)
def test_edges_beside_other_strips(kind: LaneType, highway: str, expected: str) -> None:
    attributes = street("d< d>", highway, margin_right=(MarginSpec(kind, 2.0),))
    marks = marks_of(attributes)
    assert [marks[1].type, marks[-1].type] == ["solid", expected]
    if expected == "none":
        assert marks[-1] == NO_MARK


SECTIONS = [
    "d< d>",
    "d> d>",
    "d< d<",
    "d< d= d>",
    "c< d< d> d> c>",
    "d<:not_left d< d> d>:not_left b>",
    "c< d>",
    "d=",
]
SWAPPED = {"increase": "decrease", "decrease": "increase"}


@pytest.mark.parametrize(
    ("text", "code", "forbidden", "highway"),
    list(
        product(
            SECTIONS, ["", "US", "DE", "ZA", "JP"], [(), (F,), (B,), (F, B)], ["primary", "motorway", "residential"]
        )
    ),
)
def test_left_hand_traffic_is_the_mirror_image(
    text: str, code: str, forbidden: tuple[Direction, ...], highway: str
) -> None:
    """Mirrored at its line a street has its lanes from right to left; they run the same ways."""
    one = street(text, highway, no_overtaking=frozenset(forbidden), margin_left=(MarginSpec(LaneType.SHOULDER, 1.0),))
    turned = {"not_left": "not_right", "not_right": "not_left"}
    mirrored = tuple(replace(lane, change=turned.get(lane.change, lane.change)) for lane in reversed(one.lanes_ltr))
    other = replace(one, lanes_ltr=mirrored, margin_left=(), margin_right=one.margin_left)
    right_hand, left_hand = marks_of(one, RIGHT, find_country(code)), marks_of(other, LEFT, find_country(code))
    assert sorted(right_hand) == sorted(-lane for lane in left_hand)
    for lane, mark in right_hand.items():
        expected = replace(mark, lane_change=SWAPPED.get(mark.lane_change, mark.lane_change))
        if lane == 0:
            # From left to right on the centre line, outwards elsewhere.
            expected = replace(expected, type=" ".join(reversed(mark.type.split())))
        assert left_hand[-lane] == expected


@pytest.mark.parametrize("text", SECTIONS)
@pytest.mark.parametrize("forbidden", [(), (F,)])
def test_turned_round_the_street_has_the_same_lines(text: str, forbidden: tuple[Direction, ...]) -> None:
    one = street(text, no_overtaking=frozenset(forbidden))
    turned = tuple(replace(lane, direction=Direction(-lane.direction)) for lane in reversed(one.lanes_ltr))
    other = replace(one, lanes_ltr=turned, no_overtaking=frozenset(Direction(-runs) for runs in forbidden))
    painted, again = (_painted(item, find_country("US")) for item in (one, other))
    assert painted == [
        (tuple(reversed(lines)), color, SWAPPED.get(change, change)) for lines, color, change in reversed(again)
    ]


def _painted(attributes: StreetAttributes, country: Country) -> list[tuple[tuple[str, ...], str, str]]:
    """Return lines from left to right: those that each mark has, its colour and lane change."""
    marks = marks_of(attributes, RIGHT, country)
    out = []
    for lane in sorted(marks, reverse=True):
        words = tuple(marks[lane].type.split())
        out.append((words[::-1] if lane > 0 else words, marks[lane].color, marks[lane].lane_change))
    return out


def test_what_marks_depend_on() -> None:
    one = street("d< d>")
    assert same_marks(one, replace(one, osm_way_id=2, surface="asphalt"))
    assert mark_kind(one) == mark_kind(replace(one, osm_way_id=2, surface="asphalt"))
    for other in (
        replace(one, no_overtaking=frozenset({F})),
        replace(one, marked=True),
        replace(one, divider="solid_line"),
    ):
        assert not same_marks(one, other)
        assert mark_kind(one) != mark_kind(other)
    assert mark_kind(one) != mark_kind(replace(one, margin_left=(MarginSpec(LaneType.SIDEWALK, 2.0),)))


# ---------------------------------------------------------------- as part of roads


def roads_of(ways: dict[int, tuple[tuple[int, int], str]], country: str) -> list[Road]:
    """Return the roads of ways between nodes on a line, 100 m from one to the next."""
    nodes = {node for refs, _ in ways.values() for node in refs}
    tags = {way: dict(item.split("=", 1) for item in text.split()) for way, (_, text) in ways.items()}
    lines = [f'<node id="{node}" lat="51.0" lon="{10 + 0.00142 * node:.6f}"/>' for node in sorted(nodes)]
    for way, (refs, _) in ways.items():
        points = "".join(f'<nd ref="{node}"/>' for node in refs)
        said = "".join(f'<tag k="{key}" v="{value}"/>' for key, value in tags[way].items())
        lines.append(f'<way id="{way}">{points}{said}</way>')
    with TemporaryDirectory() as folder:
        path = Path(folder) / "area.osm"
        path.write_text(f'<osm version="0.6">{"".join(lines)}</osm>', encoding="utf-8")
        network = parse_osm(path, ParseOptions(guessed_sidewalks=False, guessed_shoulders=False), Diagnostics())
    return list(build_roads(replace(network, country=country), FlatSurface(), Diagnostics()).roads)


@pytest.mark.parametrize(("country", "color"), [("US", "yellow"), ("DE", "standard"), ("", "standard")])
def test_roads_are_painted_as_in_their_country(country: str, color: str) -> None:
    (road,) = roads_of({10: ((1, 2), "highway=primary lanes=2 width=7 maxspeed=50")}, country)
    (section,) = road.lane_sections
    assert [(lane.id, lane.road_mark and lane.road_mark.type) for lane in section.lanes] == [
        (1, "solid"),
        (0, "broken"),
        (-1, "solid"),
    ]
    assert [lane.road_mark and lane.road_mark.color for lane in section.lanes] == ["standard", color, "standard"]


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        # Where lines change, lanes go on in a section of their own.
        ("change:lanes=yes|yes", "change:lanes=no|no", ["broken", "solid"]),
        ("", "lane_markings=no", ["broken", "none"]),
        ("change:lanes=no|no", "change:lanes=no|no surface=asphalt", ["solid"]),
        ("", "name=Street", ["broken"]),
        ("", "change:lanes=yes|yes", ["broken"]),
        ("change:lanes=not_left|yes", "change:lanes=only_right|yes", ["broken"]),
    ],
)
def test_lines_change_with_the_tags(one: str, other: str, expected: list[str]) -> None:
    tags = "highway=primary oneway=yes lanes=2 width=7 maxspeed=50"
    (road,) = roads_of({10: ((1, 2), f"{tags} {one}"), 11: ((2, 3), f"{tags} {other}")}, "DE")
    marks = [lane.road_mark for section in road.lane_sections for lane in section.lanes if lane.id == -1]
    assert [mark and mark.type for mark in marks] == expected
