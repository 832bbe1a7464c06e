"""Bicycle and bus lanes that tags of the whole way name. The notation of lanes is that of test_cross_sections.

Every row is drawn for right-hand traffic; left-hand traffic must have its mirror image.
"""

from __future__ import annotations

import re

import pytest
from lane_notation import codes, notation, section_of

from osm2xodr.conventions.countries import LANE_WIDTH
from osm2xodr.diagnostics import Kind
from osm2xodr.model import Rule
from osm2xodr.osmParsing.defaults import LANE_WIDTH_BICYCLE
from osm2xodr.osmParsing.tags.cross_sections import cross_section

SWAPPED = {"left": "right", "right": "left"}


def mirrored(tags: str) -> str:
    """Turn the sides of the way and the order of lanes round, not the turns."""
    out = []
    for item in tags.split():
        key, value = item.split("=", 1)
        key = re.sub(r"\b(left|right)\b", lambda side: SWAPPED[side[1]], key)
        if ":lanes" in key:
            value = "|".join(reversed(value.split("|")))
        out.append(f"{key}={value}")
    return " ".join(out)


TABLE = [
    # -- bicycle lanes of two-way roads, the way of writing without sides and with them
    ("cycleway=lane", "cv v ^ c^"),
    ("cycleway:both=lane", "cv v ^ c^"),
    ("cycleway:left=lane cycleway:right=lane", "cv v ^ c^"),
    ("cycleway:right=lane", "v ^ c^"),
    ("cycleway:left=lane", "cv v ^"),
    ("cycleway:right=lane cycleway:left=track", "v ^ c^"),
    ("cycleway=lane cycleway:left=no", "v ^"),
    ("cycleway:both=lane cycleway:left=no", "v ^ c^"),
    ("lanes=3 lanes:forward=2 cycleway:both=lane", "cv v ^ ^ c^"),
    ("cycleway:left:lane=exclusive", "cv v ^"),
    ("cycleway:right=buffered_lane", "v ^ c^"),
    ("cycleway:left=lane cycleway:left:oneway=-1", "cv v ^"),
    ("cycleway:left=lane cycleway:left:oneway=yes", "cv v ^"),
    ("cycleway:left=lane cycleway:left:oneway=no", "cv v ^"),
    # Against the traffic beside it: written as running with it.
    ("cycleway:right=lane cycleway:right:oneway=-1", "v ^ c^"),
    # -- not on the carriageway, or no lane of their own
    *(
        (f"cycleway{side}={value}", "v ^")
        for side in ("", ":both", ":left", ":right")
        for value in ("track", "separate", "no", "shared_lane", "share_busway", "opposite", "sidepath", "shoulder")
    ),
    ("cycleway=opposite_track oneway=yes", "^"),
    # -- one-way roads: on the near side unless a side is named
    ("oneway=yes cycleway=lane", "^ c^"),
    ("oneway=-1 cycleway=lane", "cv v"),
    ("oneway=yes cycleway:right=lane", "^ c^"),
    ("oneway=yes cycleway:left=lane", "c^ ^"),
    ("oneway=yes cycleway:both=lane", "c^ ^ c^"),
    ("oneway=-1 cycleway:right=lane", "v cv"),
    # -- against the one-way
    ("oneway=yes cycleway=opposite_lane", "cv ^"),
    ("oneway=-1 cycleway=opposite_lane", "v c^"),
    ("oneway=yes cycleway:left=opposite_lane", "cv ^"),
    ("oneway=yes oneway:bicycle=no cycleway:left=lane", "cv ^"),
    ("oneway=yes cycleway:left=lane cycleway:left:oneway=-1", "cv ^"),
    ("oneway=yes oneway:bicycle=no cycleway:both=lane cycleway:left:oneway=-1", "cv ^ c^"),
    ("oneway=yes oneway:bicycle=no cycleway:right=lane", "^ c^"),
    ("oneway=yes oneway:bicycle=no cycleway=lane", "^ c^"),
    ("oneway=yes oneway:bicycle=no", "^"),
    # -- what lists of lanes name already is not named twice
    ("oneway=yes lanes=1 access:lanes=yes|no bicycle:lanes=yes|designated cycleway:right=lane", "^ c^"),
    ("oneway=yes lanes=2 cycleway:lanes=no|lane|no cycleway:right=lane", "^ c^ ^"),
    ("oneway=yes lanes=2 cycleway:lanes=no|no|advisory", "^ ^ c^"),
    ("oneway=yes lanes=2 cycleway:lanes=none|none", "^ ^"),
    ("oneway=yes lanes=1 width:lanes=3|1.5 cycleway:right=lane", "^ c^"),
    ("lanes=2 cycleway:lanes:forward=no|lane cycleway:both=lane", "cv v ^ c^"),
    ("oneway=yes lanes=2 turn:lanes=through|right| cycleway:right=lane", "^t ^r c^"),
    # -- bus lanes are among the lanes that are counted
    ("lanes=4 busway=lane", "bv v ^ b^"),
    ("lanes=4 busway:both=lane", "bv v ^ b^"),
    ("lanes=3 lanes:forward=2 busway:right=lane", "v ^ b^"),
    ("oneway=yes lanes=3 busway=lane", "^ ^ b^"),
    ("oneway=yes lanes=3 busway:left=lane", "b^ ^ ^"),
    ("oneway=yes lanes=3 lanes:psv=1", "^ ^ b^"),
    ("oneway=yes lanes=3 lanes:bus=2", "^ b^ b^"),
    ("lanes=4 lanes:psv=2", "bv v ^ b^"),
    ("lanes=4 lanes:psv=1", "v v ^ b^"),
    ("lanes=4 lanes:psv:backward=1", "bv v ^ ^"),
    ("oneway=-1 lanes=2 lanes:psv=1", "bv v"),
    # Unless there is no room for cars beside them.
    ("oneway=yes busway=lane", "^ b^"),
    ("lanes=2 busway=lane", "bv v ^ b^"),
    ("oneway=yes lanes=1 lanes:psv=1", "^"),
    ("oneway=yes lanes=2 busway=lane cycleway=lane", "^ b^ c^"),
    ("oneway=yes lanes=3 bus:lanes=|designated| busway:right=lane", "^ b^ ^"),
    ("busway=no", "v ^"),
    # -- bus lanes against a one-way
    ("oneway=yes busway=opposite_lane lanes=3", "bv ^ ^"),
    ("oneway=yes busway:left=opposite_lane", "bv ^"),
    ("oneway=-1 busway=opposite_lane", "v b^"),
    ("oneway=yes lanes=3 lanes:backward=1 oneway:psv=no", "bv ^ ^"),
    ("oneway=yes lanes=3 lanes:psv:backward=1", "bv ^ ^"),
    ("oneway=yes lanes=3 lanes:forward=2 lanes:backward=1 bus:lanes:backward=designated", "bv ^ ^"),
    ("oneway=yes busway=opposite_lane cycleway=lane lanes=2", "bv ^ c^"),
    ("oneway=yes lanes=3 lanes:backward=1", "^ ^"),
    ("oneway=yes oneway:bus=no", "^"),
]


@pytest.mark.parametrize(("tags", "lanes"), TABLE)
def test_lanes(tags: str, lanes: str) -> None:
    assert notation(section_of(tags).lanes_ltr) == lanes
    on_the_left = notation(section_of(mirrored(tags), Rule.LEFT_HAND).lanes_ltr)
    if "oneway=" in tags or "lanes=4 lanes:psv=1" not in tags:
        assert on_the_left.split() == lanes.split()[::-1]


def _closed(tags: str, closed: int, rule: Rule = Rule.RIGHT_HAND) -> str:
    values = {"highway": "residential", **dict(item.split("=", 1) for item in tags.split())}
    return notation(cross_section(values, 0, rule, None, closed).lanes_ltr)


@pytest.mark.parametrize(
    ("tags", "closed", "lanes"),
    [
        ("", -1, "^"),
        ("", 1, "v"),
        ("lanes=1", -1, "^"),
        ("lanes=2", -1, "cv ^"),
        ("lanes=2", 1, "v c^"),
        ("lanes=2 bicycle:backward=no", -1, "-v ^"),
        ("lanes=2 bus:backward=yes", -1, "bv ^"),
        ("lanes=3 lanes:forward=2 lanes:backward=1 psv:backward=designated", -1, "bv ^ ^"),
        ("cycleway:both=lane", -1, "c^ ^ c^"),
        ("oneway:bicycle=no cycleway:both=lane", -1, "cv ^ c^"),
    ],
)
def test_one_direction_closed_to_cars(tags: str, closed: int, lanes: str) -> None:
    assert _closed(tags, closed) == lanes
    assert _closed(tags, closed, Rule.LEFT_HAND).split() == lanes.split()[::-1]


@pytest.mark.parametrize(
    ("tags", "widths"),
    [
        ("lanes=2 cycleway=lane", [LANE_WIDTH_BICYCLE, 3.25, 3.25, LANE_WIDTH_BICYCLE]),
        ("lanes=2 cycleway=lane cycleway:width=1.8", [1.8, 3.25, 3.25, 1.8]),
        ("lanes=2 cycleway:both=lane cycleway:both:width=1.3", [1.3, 3.25, 3.25, 1.3]),
        ("lanes=2 cycleway:both=lane cycleway:left:width=2 cycleway:both:width=1.3", [2.0, 3.25, 3.25, 1.3]),
        ("lanes=2 cycleway:right=lane cycleway:right:est_width=1.6", [3.25, 3.25, 1.6]),
        # The carriageway's width is shared with them.
        ("lanes=2 width=10 cycleway=lane cycleway:width=1.5", [1.5, 3.5, 3.5, 1.5]),
        # way/4684089: what is neither lane nor bicycle lane is for parking
        (
            (
                "lanes=2 width=11 width:lanes:backward=3.2 width:lanes:forward=3.2 "
                "cycleway:both=lane cycleway:both:width=2"
            ),
            [2.0, 3.2, 3.2, 2.0],
        ),
    ],
)
def test_widths(tags: str, widths: list[float]) -> None:
    assert LANE_WIDTH["secondary"] == 3.25
    assert [lane.width for lane in section_of(tags).lanes_ltr] == pytest.approx(widths)


@pytest.mark.parametrize(
    ("tags", "expected"),
    [
        ("cycleway=lane", []),
        ("cycleway:right=lane cycleway:right:width=wide", [(Kind.DROPPED, "cycle-lane")]),
        ("cycleway:right=lane cycleway:right:oneway=no", [(Kind.REPAIRED, "cycle-lane")]),
        ("cycleway:right=lane cycleway:right:oneway=-1", [(Kind.REPAIRED, "cycle-lane")]),
        ("oneway=yes busway=lane", [(Kind.GUESSED, "bus-lane")]),
        ("oneway=yes lanes=1 lanes:psv=1", [(Kind.DROPPED, "bus-lane")]),
        ("oneway=yes lanes:psv=99999999999999999999", [(Kind.DROPPED, "bus-lane")]),
        ("oneway=yes lanes:psv=26", [(Kind.DROPPED, "bus-lane")]),
        ("oneway=yes lanes=2 busway=opposite_lane", [(Kind.NOTE, "contraflow")]),
        ("oneway=yes lanes=2 lanes:backward=1", [(Kind.DROPPED, "contraflow")]),
    ],
)
def test_what_is_said(tags: str, expected: list[tuple[Kind, str]]) -> None:
    assert codes(section_of(tags), "lane-width", "lane-count") == expected


def test_placement_counts_the_lanes_for_cars_only() -> None:
    """The line is right of the first lane for cars, 3.25 m from the carriageway's left edge, or 4.75 m."""
    right = section_of("oneway=yes lanes=2 placement=right_of:1 cycleway:right=lane")
    assert right.middle_offset == pytest.approx(3.25 - 8.0 / 2)
    left = section_of("oneway=yes lanes=2 placement=right_of:1 cycleway:left=lane")
    assert left.middle_offset == pytest.approx(4.75 - 8.0 / 2)


def test_the_line_is_the_middle_of_all_lanes_else() -> None:
    assert section_of("oneway=yes lanes=2 cycleway:right=lane").middle_offset == 0.0
