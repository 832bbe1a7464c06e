"""Lanes in a short notation, from left to right, and random tags of lanes.

A lane is ^ along the way, v against it, = in both directions; before it b for buses, t for taxis, c for bicycles, -
for nobody, nothing for all cars; after it the letters of its arrows.
"""

from __future__ import annotations

import re

from hypothesis import strategies as st
from osm_builder import tags_of

from osm2xodr.conventions.countries import LANE_WIDTH
from osm2xodr.diagnostics import Kind
from osm2xodr.model import Direction, LaneSpec, LaneType, Rule
from osm2xodr.osmParsing.tags.beside_lanes import BESIDE_TAGS
from osm2xodr.osmParsing.tags.cross_sections import LANE_TAGS, CrossSection, cross_section
from osm2xodr.osmParsing.tags.lane_counts import USER_TAGS

RIGHT = Rule.RIGHT_HAND

TYPES = {LaneType.DRIVING: "", LaneType.BUS: "b", LaneType.TAXI: "t", LaneType.BIKING: "c", LaneType.NONE: "-"}

WAYS = {Direction.FORWARD: "^", Direction.BACKWARD: "v", Direction.BOTH: "="}

ARROWS = {
    "left": "l",
    "through": "t",
    "right": "r",
    "slight_right": "s",
    "reverse": "u",
    "merge_to_left": "m",
    "merge_to_right": "n",
}


def section_of(tags: str, rule: Rule = RIGHT, direction: int | None = None) -> CrossSection:
    values = tags_of(f"highway=secondary {tags}")
    if direction is None:
        direction = {"yes": 1, "-1": -1}.get(values.get("oneway", ""), 0)
    return cross_section(values, direction, rule)


def notation(lanes: tuple[LaneSpec, ...]) -> str:
    return " ".join(
        TYPES[lane.type] + WAYS[lane.direction] + "".join(sorted(ARROWS[turn] for turn in lane.turns))
        for lane in lanes
    )


def codes(section: CrossSection, *besides: str) -> list[tuple[Kind, str]]:
    return [(kind, code) for kind, code, _ in section.findings if code not in besides]


COUNTS = st.sampled_from(["1", "2", "3", "4", "5", "2;3", "0", "-1", "1.5", "x", "300"])

LISTS = st.lists(
    st.sampled_from(["", "yes", "no", "left", "through", "designated", "3.5", "2", "bus", "none"]), max_size=5
).map("|".join)

PLACES = st.builds(
    "{}:{}".format, st.sampled_from(["left_of", "right_of", "middle_of"]), st.integers(-1, 6)
) | st.just("transition")

BESIDE = st.sampled_from(["lane", "opposite_lane", "no", "yes", "-1", "exclusive", "track", "2.5", "0.1"])


@st.composite
def lane_tags(draw: st.DrawFn) -> dict[str, str]:
    keys = draw(st.lists(st.sampled_from(LANE_TAGS), unique=True, max_size=8))
    tags = {"highway": draw(st.sampled_from(sorted(LANE_WIDTH)))}
    for key in keys:
        if ":lanes" in key or key.startswith("turn"):
            tags[key] = draw(LISTS)
        elif key.startswith("lanes"):
            tags[key] = draw(COUNTS)
        elif key.startswith("placement"):
            tags[key] = draw(PLACES)
        elif key in BESIDE_TAGS or key in USER_TAGS:
            tags[key] = draw(BESIDE)
        else:
            tags[key] = draw(st.sampled_from(["3", "6.5", "0", "100", "wide", "20'"]))
    return tags


SWAPPED = {"forward": "backward", "backward": "forward", "left": "right", "right": "left"}


def turned_key(key: str) -> str:
    return re.sub(r"\b[a-z]+\b", lambda word: SWAPPED.get(word[0], word[0]), key)
