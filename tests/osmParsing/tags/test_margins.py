"""Tags of ways become the strips beside the carriageway.

The notation, from the edge outwards: P parking, H shoulder, B border, S sidewalk, and for bicycles ^ along
the way, v against it, = both ways; behind it the width in m, and after @ the height in cm where it is not 0.
"""

from __future__ import annotations

import re

import pytest
from hypothesis import assume, given, settings, strategies as st
from lane_notation import turned_key
from osm_builder import tags_of

from osm2xodr.defaults import KERB_HEIGHT
from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import Direction, LaneType, MarginSpec, Rule
from osm2xodr.osmParsing.defaults import (
    CYCLE_TRACK_GAP,
    CYCLE_TRACK_GAP_PARKING,
    CYCLE_TRACK_WIDTH,
    CYCLE_TRACK_WIDTH_BOTH,
    PARKING_WIDTH,
    SHOULDER_WIDTH,
    SHOULDER_WIDTH_OTHER,
    SIDEWALK_WIDTH,
    VERGE_WIDTH,
)
from osm2xodr.osmParsing.file.access import RawWay
from osm2xodr.osmParsing.tags.cross_sections import SECTION_TAGS, CrossSection, cross_section
from osm2xodr.osmParsing.tags.margins import MARGIN_TAGS, seen_backwards
from osm2xodr.osmParsing.tags.ways import turned_round, way_attributes

LETTERS = {LaneType.PARKING: "P", LaneType.SHOULDER: "H", LaneType.BORDER: "B", LaneType.SIDEWALK: "S"}
WAYS = {Direction.FORWARD: "^", Direction.BACKWARD: "v", Direction.BOTH: "="}
VALUES = {"left": "right", "right": "left"}


def notation(strips: tuple[MarginSpec, ...]) -> str:
    return " ".join(
        (WAYS[strip.direction] if strip.type is LaneType.BIKING else LETTERS[strip.type])
        + f"{strip.width:g}"
        + (f"@{100 * strip.height:g}" if strip.height else "")
        for strip in strips
    )


def section_of(tags: str, rule: Rule = Rule.RIGHT_HAND, highway: str = "residential") -> CrossSection:
    values = {"highway": highway, **tags_of(tags)}
    return cross_section(values, {"yes": 1, "-1": -1}.get(values.get("oneway", ""), 0), rule)


def both_sides(section: CrossSection) -> tuple[str, str]:
    return notation(section.margin_left), notation(section.margin_right)


def said(section: CrossSection) -> list[tuple[Kind, str]]:
    return [(kind, code) for kind, code, _ in section.findings if code not in ("lane-width", "lane-count")]


def in_the_mirror(tags: str) -> str:
    """Exchange left and right in keys and values."""
    words = re.compile(r"\b(left|right)\b")
    return " ".join(words.sub(lambda side: VALUES[side[1]], item) for item in tags.split())


def turned_tags(tags: dict[str, str]) -> dict[str, str]:
    """Turn the tags of a way whose nodes are put in the opposite order; what cyclists see stays as it is."""
    out = {}
    for key, value in tags.items():
        about, *rest = re.split(r"(?=:separation|:buffer)", key, maxsplit=1)
        out["".join((turned_key(about), *rest))] = ";".join(VALUES.get(part, part) for part in value.split(";"))
    if "oneway" in out:
        out["oneway"] = {"yes": "-1", "-1": "yes"}[out["oneway"]]
    return out


def seen_from_the_other_side(text: str) -> str:
    return text.translate(str.maketrans("^v", "v^"))


def test_the_defaults_that_the_tables_are_written_with() -> None:
    assert (SIDEWALK_WIDTH, VERGE_WIDTH, SHOULDER_WIDTH_OTHER, SHOULDER_WIDTH["motorway"]) == (2.0, 1.5, 1.5, 2.5)
    assert (CYCLE_TRACK_WIDTH, CYCLE_TRACK_WIDTH_BOTH) == (2.0, 2.5)
    assert (CYCLE_TRACK_GAP, CYCLE_TRACK_GAP_PARKING) == (0.5, 0.75)
    assert dict(PARKING_WIDTH) == {"parallel": 2.0, "diagonal": 4.85, "perpendicular": 5.0}
    assert (KERB_HEIGHT["raised"], KERB_HEIGHT["lowered"], KERB_HEIGHT["flush"]) == (0.12, 0.03, 0.0)


WALK = "S2@12"
TABLE = [
    ("", "", ""),
    # -- sidewalks
    ("sidewalk=both", WALK, WALK),
    ("sidewalk=left", WALK, ""),
    ("sidewalk=right", "", WALK),
    ("sidewalk=yes", WALK, WALK),
    ("sidewalk=left;right", WALK, WALK),
    ("sidewalk=right;left", WALK, WALK),
    ("sidewalk=Both", WALK, WALK),
    *(
        (f"sidewalk={value}", "", "")
        for value in ("no", "none", "separate", "crossing", "both:surface=x", "no;left", "")
    ),
    ("sidewalk:both=yes", WALK, WALK),
    ("sidewalk:left=yes", WALK, ""),
    ("sidewalk:right=yes sidewalk:left=no", "", WALK),
    ("sidewalk:right=yes sidewalk:left=separate", "", WALK),
    ("sidewalk:right=right", "", WALK),
    ("sidewalk:both=separate", "", ""),
    ("sidewalk:both=both", WALK, WALK),
    ("sidewalk=left;separate", WALK, ""),
    ("sidewalk=both sidewalk:left=separate", "", WALK),
    ("sidewalk=both sidewalk:left=no", "", WALK),
    ("sidewalk=no sidewalk:left=yes", WALK, ""),
    ("sidewalk:both=no sidewalk:left=yes", WALK, ""),
    ("sidewalk:left=perhaps sidewalk=left", WALK, ""),
    ("sidewalk=both sidewalk:bicycle=designated sidewalk:left:surface=asphalt", WALK, WALK),
    ("sidewalk=both sidewalk:both:width=1.5", "S1.5@12", "S1.5@12"),
    ("sidewalk=both sidewalk:width=1.5 sidewalk:left:width=3", "S3@12", "S1.5@12"),
    ("sidewalk=left sidewalk:left:width=2.95", "S2.95@12", ""),
    ("sidewalk=left sidewalk:left:width=8'", "S2.4384@12", ""),
    ("sidewalk=left sidewalk:left:est_width=3", "S3@12", ""),
    ("sidewalk=left sidewalk:left:width=0 sidewalk:both:width=wide", WALK, ""),
    ("sidewalk=left sidewalk:left:width=150", WALK, ""),
    ("sidewalk:left:width=2", "", ""),
    ("footway=both", WALK, WALK),
    ("footway=left footway:left:width=1.05", "S1.05@12", ""),
    ("footway=left footway:left.width=0.8", "S0.8@12", ""),
    ("footway=right", "", WALK),
    ("footway=none", "", ""),
    ("footway=sidewalk", "", ""),
    ("footway=both sidewalk=no", "", ""),
    ("footway=left sidewalk:right=yes", WALK, WALK),
    # -- kerbs
    ("sidewalk=both kerb=lowered", "S2@3", "S2@3"),
    ("sidewalk=both kerb:left=flush kerb:right=raised", "S2", WALK),
    ("sidewalk=both kerb:both=no", "S2", "S2"),
    ("sidewalk=both kerb=flush sidewalk:left:kerb=lowered", "S2@3", "S2"),
    ("sidewalk=both kerb:height=0.15", "S2@15", "S2@15"),
    ("sidewalk=both kerb:left:height=8cm", "S2@8", WALK),
    ("sidewalk=both kerb:height=12", WALK, WALK),
    ("sidewalk=both kerb=high", WALK, WALK),
    ("kerb=raised", "", ""),
    # -- verges
    ("verge=both", "B1.5", "B1.5"),
    ("verge=left sidewalk=both", f"B1.5@12 {WALK}", WALK),
    ("verge:right=yes verge:right:width=3 sidewalk=right", "", f"B3@12 {WALK}"),
    ("verge=no", "", ""),
    ("verge=separate", "", ""),
    # -- shoulders
    ("shoulder=both", "H1.5", "H1.5"),
    ("shoulder=left", "H1.5", ""),
    ("shoulder=yes", "H1.5", "H1.5"),
    ("shoulder=no", "", ""),
    ("shoulder:right=yes shoulder:right:width=2.5m", "", "H2.5"),
    ("shoulder=both shoulder:width=1 shoulder:left:width=2", "H2", "H1"),
    ("shoulder=paved", "", ""),
    ("shoulder=right sidewalk=right", "", f"H1.5 {WALK}"),
    # -- parking, new way of writing
    ("parking:both=lane parking:both:orientation=parallel", "P2", "P2"),
    ("parking:left=lane parking:left:orientation=diagonal", "P4.85", ""),
    ("parking:right=lane parking:right:orientation=perpendicular", "", "P5"),
    ("parking:right=lane parking:both:orientation=perpendicular", "", "P5"),
    ("parking:right=lane parking:right:width=2.3", "", "P2.3"),
    ("parking:right=lane parking:both:width=2.3", "", "P2.3"),
    ("parking:right=lane", "", "P2"),
    ("parking:right=yes", "", "P2"),
    ("parking:both=lane parking:left=no", "", "P2"),
    ("parking:both=no parking:left=street_side", "P2", ""),
    ("parking:right=street_side parking:right:orientation=perpendicular sidewalk=right", "", f"P5 {WALK}"),
    ("parking:right=on_kerb sidewalk=right", "", f"P2@12 {WALK}"),
    ("parking:right=on_kerb kerb:right=lowered", "", "P2@3"),
    ("parking:right=half_on_kerb sidewalk=right", "", f"P2 {WALK}"),
    ("parking:right=shoulder", "", "H1.5"),
    ("parking:right=shoulder shoulder=both shoulder:width=3", "H3", "H3"),
    *((f"parking:both={value}", "", "") for value in ("no", "none", "separate", "of_course")),
    ("parking:both=lane;street_side", "P2", "P2"),
    ("parking:right=lane parking:right:orientation=upright", "", "P2"),
    ("parking:right=lane shoulder=right", "", "P2 H1.5"),
    ("parking:right=street_side shoulder=right", "", "H1.5 P2"),
    # -- parking, old way of writing
    ("parking:lane:both=parallel", "P2", "P2"),
    ("parking:lane:left=diagonal", "P4.85", ""),
    ("parking:lane:right=perpendicular", "", "P5"),
    ("parking:lane:both=inline parking:lane:right=orthogonal", "P2", "P5"),
    ("parking:lane:right=marked", "", "P2"),
    *(
        (f"parking:lane:both={value}", "", "")
        for value in ("no_parking", "no_stopping", "no_standing", "fire_lane", "no", "separate", "private")
    ),
    ("parking:lane:both=parallel;diagonal", "P2", "P2"),
    ("parking:lane:both=parallel parking:lane:left=no_stopping", "", "P2"),
    ("parking:lane:right=parallel parking:lane:right:parallel=on_kerb", "", "P2@12"),
    ("parking:lane:both=parallel parking:lane:both:parallel=on_kerb", "P2@12", "P2@12"),
    ("parking:lane:both=parallel parking:lane:left:parallel=half_on_kerb", "P2", "P2"),
    ("parking:lane:right=parallel parking:lane:right:parallel=lay_by shoulder=right", "", "H1.5 P2"),
    ("parking:lane:right=diagonal parking:lane:right:parallel=on_kerb", "", "P4.85"),
    ("parking:lane:right=parallel parking:lane:right:width=1.8", "", "P1.8"),
    # Both ways of writing: the new one counts, the old one knows the orientation.
    ("parking:right=no parking:lane:right=parallel", "", ""),
    ("parking:right=street_side parking:lane:right=perpendicular", "", "P5"),
    # -- bicycle tracks
    ("cycleway=track", "B0.5@12 v2@12", "B0.5@12 ^2@12"),
    ("cycleway:both=track", "B0.5@12 v2@12", "B0.5@12 ^2@12"),
    ("cycleway:right=track", "", "B0.5@12 ^2@12"),
    ("cycleway:left=track", "B0.5@12 v2@12", ""),
    ("cycleway:left=track cycleway:right=lane", "B0.5@12 v2@12", ""),
    ("cycleway:right=track cycleway:right:oneway=no", "", "B0.5@12 =2.5@12"),
    ("cycleway:right=track cycleway:right:oneway=-1", "", "B0.5@12 v2@12"),
    ("cycleway:right=track cycleway:right:width=1.6", "", "B0.5@12 ^1.6@12"),
    ("cycleway:right=track cycleway:right:oneway=no cycleway:both:width=3", "", "B0.5@12 =3@12"),
    ("cycleway:right=track sidewalk=right", "", f"B0.5@12 ^2@12 {WALK}"),
    ("cycleway:right=track kerb=flush sidewalk=right", "", "B0.5 ^2 S2"),
    ("cycleway:right=track verge=right verge:width=3 sidewalk=right", "", f"B3@12 ^2@12 {WALK}"),
    ("cycleway:right=track parking:right=street_side", "", "P2 B0.75@12 ^2@12"),
    ("cycleway:right=track cycleway:right:separation:left=bollard sidewalk=right", "", f"B0.5 ^2 {WALK}"),
    ("cycleway:right=track cycleway:right:separation=flex_post;kerb", "", "B0.5@12 ^2@12"),
    ("cycleway:left=track cycleway:left:separation:left=bollard", "B0.5 v2", ""),
    ("cycleway:left=track cycleway:left:separation:right=bollard", "B0.5@12 v2@12", ""),
    ("cycleway:right=track cycleway:right:buffer=1.2", "", "B1.2@12 ^2@12"),
    ("cycleway:right=track cycleway:right:buffer=no", "", "^2@12"),
    ("cycleway:right=track cycleway:right:buffer:left=1 sidewalk=right", "", f"B1@12 ^2@12 {WALK}"),
    (
        "cycleway:right=track cycleway:right:buffer:both=1 sidewalk=right",
        "",
        f"B1@12 ^2@12 B1@12 {WALK}",
    ),
    ("cycleway:right=track cycleway:right:buffer:right=0.5", "", "B0.5@12 ^2@12"),
    ("cycleway:right=track cycleway:right:buffer=huge", "", "B0.5@12 ^2@12"),
    ("cycleway=opposite_track", "", ""),
    *((f"cycleway={value}", "", "") for value in ("lane", "separate", "no", "share_sidewalk", "left", "shared_lane")),
    # -- and on one-way roads
    ("oneway=yes cycleway=track", "", "B0.5@12 ^2@12"),
    ("oneway=-1 cycleway=track", "B0.5@12 v2@12", ""),
    ("oneway=yes cycleway:left=track", "B0.5@12 ^2@12", ""),
    ("oneway=yes cycleway:both=track", "B0.5@12 ^2@12", "B0.5@12 ^2@12"),
    ("oneway=yes oneway:bicycle=no cycleway:left=track", "B0.5@12 v2@12", ""),
    ("oneway=yes oneway:bicycle=no cycleway:both=track", "B0.5@12 v2@12", "B0.5@12 ^2@12"),
    ("oneway=yes cycleway=opposite_track", "B0.5@12 v2@12", ""),
    ("oneway=-1 cycleway=opposite_track", "", "B0.5@12 ^2@12"),
    ("oneway=yes cycleway:left=opposite_track", "B0.5@12 v2@12", ""),
    ("oneway=yes cycleway:left=track cycleway:left:oneway=no", "B0.5@12 =2.5@12", ""),
    ("oneway=yes cycleway:left=track cycleway:left:oneway=-1", "B0.5@12 v2@12", ""),
    ("oneway=yes shoulder=yes", "", "H1.5"),
    ("oneway=-1 shoulder=yes", "H1.5", ""),
    ("oneway=yes sidewalk=both parking:left=lane", f"P2 {WALK}", WALK),
    # -- all at once
    (
        "shoulder=right parking:right=lane cycleway:right=track cycleway:right:buffer:both=0.4 sidewalk=right",
        "",
        f"P2 H1.5 B0.4@12 ^2@12 B0.4@12 {WALK}",
    ),
]


@pytest.mark.parametrize(("tags", "left", "right"), TABLE)
def test_margins(tags: str, left: str, right: str) -> None:
    assert both_sides(section_of(tags)) == (left, right)
    # In the mirror traffic keeps to the left.
    mirrored = both_sides(section_of(in_the_mirror(tags), Rule.LEFT_HAND))
    assert mirrored == (right, left)


@pytest.mark.parametrize(("tags", "left", "right"), [row for row in TABLE if ":oneway=-1" not in row[0]])
def test_margins_of_ways_drawn_the_other_way_round(tags: str, left: str, right: str) -> None:
    values = turned_tags(tags_of(tags))
    direction = {"yes": 1, "-1": -1}.get(values.get("oneway", ""), 0)
    section = cross_section({"highway": "residential", **values}, direction, Rule.RIGHT_HAND)
    assert both_sides(section) == (seen_from_the_other_side(right), seen_from_the_other_side(left))


@pytest.mark.parametrize(
    ("width", "expected"),
    [("2.5 m", "H2.5"), ("2,5", "H2.5"), ("250 cm", "H2.5"), ("5 ft", "H1.524"), ("~2", "H1.5"), ("1;2", "H1.5")],
)
def test_ways_of_writing_a_width(width: str, expected: str) -> None:
    tags = {"highway": "residential", "shoulder": "right", "shoulder:width": width}
    assert both_sides(cross_section(tags, 0, Rule.RIGHT_HAND)) == ("", expected)


def test_motorways_have_shoulders_only_where_they_are_tagged() -> None:
    assert both_sides(section_of("oneway=yes lanes=3", highway="motorway")) == ("", "")
    assert both_sides(section_of("oneway=yes shoulder=right", highway="motorway")) == ("", "H2.5")
    assert both_sides(section_of("oneway=yes shoulder=both shoulder:left:width=0.5", highway="motorway")) == (
        "H0.5",
        "H2.5",
    )


@pytest.mark.parametrize(
    ("tags", "expected"),
    [
        ("sidewalk=separate", []),
        ("sidewalk=no", []),
        ("sidewalk=left sidewalk:width=2", []),
        ("sidewalk=left sidewalk:left:width=2 sidewalk:right=separate", []),
        ("sidewalk=both", [(Kind.GUESSED, "margin-width")]),
        ("sidewalk=yes sidewalk:width=2", [(Kind.GUESSED, "sidewalk")]),
        ("sidewalk=crossing", [(Kind.DROPPED, "sidewalk")]),
        ("sidewalk=no;left", [(Kind.DROPPED, "sidewalk")]),
        ("sidewalk=no sidewalk:left=yes sidewalk:width=2", [(Kind.REPAIRED, "sidewalk")]),
        ("sidewalk=left sidewalk:right=yes sidewalk:width=2", [(Kind.REPAIRED, "sidewalk")]),
        ("sidewalk=both sidewalk:both:width=0.1", [(Kind.DROPPED, "sidewalk"), (Kind.GUESSED, "margin-width")]),
        ("footway=crossing", [(Kind.DROPPED, "sidewalk")]),
        ("sidewalk=both sidewalk:width=2 kerb=high", [(Kind.DROPPED, "kerb")]),
        ("sidewalk=both sidewalk:width=2 kerb:height=12", [(Kind.DROPPED, "kerb")]),
        ("verge=perhaps", [(Kind.DROPPED, "verge")]),
        ("shoulder=paved", [(Kind.DROPPED, "shoulder")]),
        ("shoulder=yes shoulder:width=1", [(Kind.GUESSED, "shoulder")]),
        ("shoulder=both shoulder:width=1000", [(Kind.DROPPED, "shoulder"), (Kind.GUESSED, "margin-width")]),
        ("parking:both=no", []),
        ("parking:both=of_course", [(Kind.DROPPED, "parking")]),
        ("parking:both=lane parking:both:width=2", [(Kind.GUESSED, "parking")]),
        ("parking:both=lane parking:both:width=2 parking:both:orientation=parallel", []),
        ("parking:lane:both=parallel;diagonal parking:lane:both:width=2", [(Kind.GUESSED, "parking")]),
        (
            "parking:right=no parking:lane:right=parallel",
            [(Kind.REPAIRED, "parking")],
        ),
        ("cycleway:right=track", [(Kind.GUESSED, "margin-width")]),
        ("cycleway:right=track cycleway:right:width=2 cycleway:right:buffer=0.5", []),
        ("cycleway=left", [(Kind.DROPPED, "cycle-track")]),
        ("cycleway=opposite_track", [(Kind.DROPPED, "cycle-track")]),
        ("cycleway=separate", []),
    ],
)
def test_what_is_said(tags: str, expected: list[tuple[Kind, str]]) -> None:
    assert said(section_of(tags)) == expected


def test_what_is_guessed_is_said_in_one_sentence() -> None:
    section = section_of("lanes=2 width=6 sidewalk=both cycleway:right=track")
    assert [words for _, code, words in section.findings if code == "margin-width"] == [
        "no width given, 0.5 m before cycle tracks, cycle tracks of 2 m, sidewalks of 2 m assumed"
    ]


# ---------------------------------------------------------------- parking on the carriageway


@pytest.mark.parametrize(
    ("tags", "lanes", "offset"),
    [
        # The line is the middle of the lanes or of the carriageway: halfway between.
        ("lanes=2 parking:right=lane", [3.0, 3.0], 0.5),
        ("lanes=2 parking:both=lane", [3.0, 3.0], 0.0),
        # 8 m: 6 for the lanes, 2 for parking on the right.
        ("lanes=2 width=8 parking:right=lane", [3.0, 3.0], 0.5),
        ("lanes=2 width=8 parking:left=lane", [3.0, 3.0], -0.5),
        ("lanes=2 est_width=8 parking:left=lane", [3.0, 3.0], -0.5),
        ("lanes=2 width=10 parking:both=lane", [3.0, 3.0], 0.0),
        (
            "lanes=2 width=13 parking:left=lane parking:right=lane parking:right:orientation=perpendicular",
            [3.0, 3.0],
            0.75,
        ),
        ("lanes=2 width=8 parking:right=lane parking:right:width=2.4", [2.8, 2.8], 0.6),
        # Half of it.
        ("lanes=2 width=7 parking:right=half_on_kerb", [3.0, 3.0], 0.25),
        ("lanes=2 width=7 parking:lane:right=parallel parking:lane:right:parallel=half_on_kerb", [3.0, 3.0], 0.25),
        # None of it.
        ("lanes=2 width=6 parking:right=on_kerb", [3.0, 3.0], 0.0),
        ("lanes=2 width=6 parking:right=street_side", [3.0, 3.0], 0.0),
        ("lanes=2 width=6 parking:right=no sidewalk=both shoulder=right cycleway:left=track", [3.0, 3.0], 0.0),
        # With a bicycle lane between.
        ("lanes=2 width=9.5 parking:right=lane cycleway:right=lane", [3.0, 3.0, 1.5], 0.5),
        ("oneway=yes lanes=1 width=5 parking:left=lane", [3.0], -0.5),
        ("oneway=-1 lanes=1 width=5 parking:left=lane", [3.0], -0.5),
        # Lanes with widths of their own.
        ("oneway=yes lanes=1 width=5 width:lanes=3.5 parking:left=lane", [3.5], -0.5),
        ("oneway=yes lanes=1 width:lanes=3.5 parking:left=lane", [3.5], -0.5),
        # Lanes of less than 2 m are none.
        ("lanes=2 width=5 parking:right=lane", [2.0, 2.0], 0.5),
        # No room for a single lane: cars park beside that width, way/362290763.
        ("lanes=2 width=5.5 parking:both=lane", [2.75, 2.75], 0.0),
        ("lanes=2 width=5 parking:right=lane parking:right:orientation=perpendicular", [2.5, 2.5], 0.0),
        # ``placement`` says where among the lanes the line is.
        ("oneway=yes lanes=2 width=8 parking:right=lane placement=right_of:1", [3.0, 3.0], 0.0),
        ("oneway=yes lanes=2 width=8 parking:right=lane placement=left_of:1", [3.0, 3.0], -3.0),
        ("oneway=yes lanes=2 width=8 parking:right=lane placement=right_of:7", [3.0, 3.0], 0.5),
    ],
)
def test_cars_that_park_on_the_carriageway(tags: str, lanes: list[float], offset: float) -> None:
    section = section_of(tags)
    assert [lane.width for lane in section.lanes_ltr] == pytest.approx(lanes)
    assert section.middle_offset == pytest.approx(offset)
    # The mirror image.
    if "placement" not in tags and "width:lanes" not in tags:
        section = section_of(in_the_mirror(tags), Rule.LEFT_HAND)
        assert [lane.width for lane in section.lanes_ltr] == pytest.approx(lanes[::-1])
        assert section.middle_offset == pytest.approx(-offset)


def test_the_carriageway_is_as_wide_as_the_width_says_and_lies_beside_the_line() -> None:
    """8 m with parking on the left: the line is between the middles of all of it and of the lanes, 1 m apart."""
    section = section_of("lanes=2 width=8 parking:left=lane parking:left:orientation=parallel")
    lanes = sum(lane.width for lane in section.lanes_ltr)
    assert section.middle_offset + lanes / 2 + section.margin_left[0].width == pytest.approx(4.5)
    assert section.middle_offset - lanes / 2 == pytest.approx(-3.5)


def test_lanes_that_parking_leaves_no_room_for_are_reported() -> None:
    section = section_of("lanes=2 width=5 parking:right=lane parking:right:orientation=parallel")
    assert (
        Kind.REPAIRED,
        "lane-width",
        "5 m of width less 2 m beside its lanes would make lanes of 1.50 m, 2 m taken",
    ) in (section.findings)


def test_a_width_that_parked_cars_have_no_room_on_is_reported() -> None:
    section = section_of("lanes=2 width=5.5 parking:both=lane parking:both:orientation=parallel")
    words = "5.5 m of width have no room for 4 m of parking, taken to be that of the lanes alone"
    assert (Kind.GUESSED, "width", words) in section.findings
    assert both_sides(section) == ("P2", "P2")


# ---------------------------------------------------------------- streets that run against their way


def test_margins_change_sides_with_the_direction() -> None:
    tags = tags_of("highway=residential cycleway:right=track sidewalk=left parking:lane:left=parallel")
    ((attributes,), _) = way_attributes([RawWay(1, [1, 2], tags)], Rule.RIGHT_HAND, None, Diagnostics())
    assert notation(attributes.margin_left) == f"P2 {WALK}"
    assert notation(attributes.margin_right) == "B0.5@12 ^2@12"
    turned = turned_round(attributes)
    assert notation(turned.margin_left) == "B0.5@12 v2@12"
    assert notation(turned.margin_right) == f"P2 {WALK}"
    assert turned_round(turned) == attributes


def test_equal_margins_are_one_object() -> None:
    ways = [
        RawWay(number, [number, number + 1], tags_of(f"highway={highway} sidewalk=both lanes={number}"))
        for number, highway in ((1, "residential"), (2, "tertiary"))
    ]
    (one, other), _ = way_attributes(ways, Rule.RIGHT_HAND, None, Diagnostics())
    assert one.margin_left is other.margin_left is one.margin_right
    assert seen_backwards(one.margin_left) is seen_backwards(other.margin_right)


# ---------------------------------------------------------------- whatever is tagged

WORDS = st.sampled_from(
    [
        *(
            "both",
            "left",
            "right",
            "yes",
            "no",
            "none",
            "separate",
            "track",
            "opposite_track",
            "lane",
            "parallel",
            "2",
        ),
        *(
            "diagonal",
            "on_kerb",
            "half_on_kerb",
            "street_side",
            "raised",
            "flush",
            "0",
            "-3",
            "1e9",
            "x",
            "",
            "1.5 m",
        ),
        *("left;right", "no;yes", "parallel;diagonal", "bollard", "perpendicular", "no_parking", "shoulder", "-1"),
    ]
)
RARE = sorted(set(MARGIN_TAGS))


@st.composite
def margin_tags(draw: st.DrawFn) -> dict[str, str]:
    makers = [key for key in RARE if key.split(":")[0] in ("sidewalk", "shoulder", "verge", "cycleway", "parking")]
    keys = draw(st.lists(st.sampled_from(RARE) | st.sampled_from(makers), unique=True, max_size=8))
    tags = {key: draw(WORDS) for key in keys} | {"highway": draw(st.sampled_from(["motorway", "service"]))}
    if draw(st.booleans()):
        tags["width"] = draw(st.sampled_from(["7", "12", "3"]))
    return tags


@given(margin_tags(), st.sampled_from([-1, 0, 1]), st.sampled_from(Rule))
@settings(deadline=None)
def test_margins_are_mirrored(tags: dict[str, str], direction: int, rule: Rule) -> None:
    # ``-1`` is along the way, not as the traffic beside it runs.
    assume(not any(key.endswith(":oneway") and value == "-1" for key, value in tags.items()))
    one = cross_section(tags, direction, rule)
    other = cross_section(turned_tags(tags), -direction, rule)
    assert other.margin_left == seen_backwards(one.margin_right)
    assert other.margin_right == seen_backwards(one.margin_left)
    assert other.middle_offset == pytest.approx(-one.middle_offset)
    assert sorted((kind, code) for kind, code, _ in other.findings) == sorted((k, c) for k, c, _ in one.findings)


@given(margin_tags(), st.sampled_from([-1, 0, 1]), st.sampled_from(Rule))
@settings(deadline=None)
def test_whatever_is_tagged_strips_are_of_some_width(tags: dict[str, str], direction: int, rule: Rule) -> None:
    section = cross_section(tags, direction, rule)
    for strips in (section.margin_left, section.margin_right):
        assert all(0.0 < strip.width <= 15.0 and 0.0 <= strip.height <= 0.5 for strip in strips)
        assert all(strip.direction is Direction.BOTH or strip.type is LaneType.BIKING for strip in strips)
        order = [strip.type for strip in strips if strip.type is not LaneType.BORDER]
        assert len(order) == len(set(order))
        assert LaneType.SIDEWALK not in order[:-1]
    again = cross_section(dict(reversed(tags.items())), direction, rule)
    assert again == section
    assert all(words and "\n" not in words for _, _, words in section.findings)


def test_all_tags_are_read() -> None:
    assert set(MARGIN_TAGS) < set(SECTION_TAGS)
    assert len(set(MARGIN_TAGS)) == len(MARGIN_TAGS)
