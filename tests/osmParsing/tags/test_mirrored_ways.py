"""A way drawn the other way round, with its tags turned, is the same street."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import assume, example, given, settings, strategies as st
from lane_notation import lane_tags, turned_key
from osm_builder import Area

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import Direction, LaneSpec, Rule, Structure
from osm2xodr.osmParsing.file.access import RawWay
from osm2xodr.osmParsing.tags.access import oneway
from osm2xodr.osmParsing.tags.cross_sections import cross_section
from osm2xodr.osmParsing.tags.ways import turned_round, way_attributes


def turned_tags(tags: dict[str, str]) -> dict[str, str]:
    """Turn the tags of a way whose nodes are put in the opposite order."""
    return {turned_key(key): value for key, value in tags.items()}


def mirrored(lanes: tuple[LaneSpec, ...]) -> tuple[LaneSpec, ...]:
    return tuple(replace(lane, direction=Direction(-lane.direction)) for lane in lanes[::-1])


@given(lane_tags(), st.sampled_from([-1, 0, 1]), st.sampled_from(Rule))
@example({"highway": "busway", "lanes": "1", "hov:lanes:both_ways": "designated"}, 0, Rule.RIGHT_HAND)
@settings(deadline=None)
def test_lanes_are_mirrored(tags: dict[str, str], direction: int, rule: Rule) -> None:
    one = cross_section(tags, direction, rule)
    # What only an arbitrary choice can decide differs: which way an odd lane runs, which of two placements is right,
    # and the order of several lanes for both directions.
    words = " ".join(text for _, _, text in one.findings)
    assume("odd one" not in words)
    assume("directions differs" not in words)
    assume(sum(lane.direction is Direction.BOTH for lane in one.lanes_ltr) <= 1)
    # ``cycleway:left:oneway=yes`` is read as "one way as usual", not as "along the way".
    assume(not any(key.endswith(":oneway") and value == "-1" for key, value in tags.items()))
    other = cross_section(turned_tags(tags), -direction, rule)
    assert other.lanes_ltr == mirrored(one.lanes_ltr)
    assert other.middle_offset == pytest.approx(-one.middle_offset)
    assert sorted((kind, code) for kind, code, _ in other.findings) == sorted((k, c) for k, c, _ in one.findings)


@given(lane_tags(), st.sampled_from(["yes", "no", "-1"]), st.sampled_from(Rule))
@settings(deadline=None)
def test_turning_twice_changes_nothing(tags: dict[str, str], value: str, rule: Rule) -> None:
    tags = {**tags, "oneway": value, "maxspeed:forward": "50", "maxspeed": "30", "incline": "-7%"}
    ((attributes,), (direction,)) = way_attributes([RawWay(1, [1, 2], tags)], rule, None, Diagnostics())
    assert direction == oneway(tags)[0]
    turned = turned_round(attributes)
    assert turned.reversed
    assert turned.lanes_ltr == mirrored(attributes.lanes_ltr)
    assert turned.speed_forward == attributes.speed_backward == pytest.approx(30 / 3.6)
    assert turned.grade == pytest.approx(0.07)
    assert turned.structure is Structure.GROUND
    assert turned_round(turned) == attributes


def test_a_street_is_the_same_whichever_way_it_is_drawn(tmp_path: Path) -> None:
    nodes = {1: (0.0, 0.0), 2: (80.0, 10.0), 3: (160.0, 0.0)}
    tags = "highway=primary oneway={} lanes=2 width:lanes=3|4 turn:lanes=left|right placement=left_of:1"
    along, _ = Area(nodes, {20: ([1, 2, 3], tags.format("yes"))}).parse(tmp_path)
    against, _ = Area(nodes, {20: ([3, 2, 1], tags.format("-1"))}).parse(tmp_path)
    one, other = along.streets[0], against.streets[0]
    assert one.points.tolist() == other.points.tolist()
    assert one.pieces[0][1].lanes_ltr == other.pieces[0][1].lanes_ltr
    assert one.pieces[0][1].middle_offset == other.pieces[0][1].middle_offset
    assert (one.pieces[0][1].reversed, other.pieces[0][1].reversed) == (False, True)
