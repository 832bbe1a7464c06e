"""Which lanes go on where their number changes along a street."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from osm2xodr.geometry.lanes.cross_sections import CrossSection, cross_section, lanes_of
from osm2xodr.geometry.lanes.lane_matching import match_lanes
from osm2xodr.model import Direction, LaneSpec, LaneType, Rule, StreetAttributes, Structure

_DIRECTIONS = {"f": Direction.FORWARD, "b": Direction.BACKWARD, "m": Direction.BOTH}
_TURNS = {"l": "left", "t": "through", "r": "right", "ml": "merge_to_left", "mr": "merge_to_right"}


def section(text: str, rule: Rule = Rule.RIGHT_HAND) -> CrossSection:
    """Read lanes from left to right as seen along the street: ``b f:l f`` is one back, a left turn lane, one more."""
    lanes = []
    for word in text.split():
        direction, _, turns = word.partition(":")
        marks = frozenset(_TURNS[turn] for turn in turns.split(";") if turn)
        lanes.append(LaneSpec(LaneType.DRIVING, _DIRECTIONS[direction], 3.0, marks))
    attributes = StreetAttributes(
        1, False, "primary", "", "", tuple(lanes), 0.0, None, None, Structure.GROUND, 0, None, False
    )
    return cross_section(attributes, rule)


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        ("b f", "b f", {1: 1, -1: -1}),
        ("f f", "f f", {-1: -1, -2: -2}),
        ("f f f", "f f", {-1: -1, -2: -2}),
        ("f:mr f f", "f f", {-2: -1, -3: -2}),
        ("f f f:ml", "f f", {-1: -1, -2: -2}),
        ("f:mr f f f:ml", "f f", {-2: -1, -3: -2}),
        ("f", "f f", {-1: -1}),
        ("f", "f:l f:t", {-1: -2}),
        ("f", "f:t f:r", {-1: -1}),
        ("f", "f:l f:t f:r", {-1: -2}),
        ("f f", "f:l f:t f:t f:r", {-1: -2, -2: -3}),
        ("f", "f:l f:l f:t", {-1: -3}),
        ("b f", "b b f", {1: 1, -1: -1}),
        ("b:t b:l f", "b f", {2: 1, -1: -1}),
        ("b:r b:t f", "b f", {1: 1, -1: -1}),
        ("b f", "b m f", {1: 1, -1: -2}),
        ("b m f", "b f", {1: 1, -2: -1}),
        ("b f", "f f", {-1: -2}),
        ("f", "b", {}),
    ],
)
def test_which_lanes_go_on(before: str, after: str, expected: dict[int, int]) -> None:
    assert match_lanes(section(before), section(after), Rule.RIGHT_HAND) == expected


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        ("f b", "f b", {1: 1, -1: -1}),
        ("f f f", "f f", {2: 2, 1: 1}),
        ("f", "f f", {1: 1}),
        ("f", "f:t f:r", {1: 2}),
        ("f f f:ml", "f f", {3: 2, 2: 1}),
        ("f b", "f m b", {1: 2, -1: -1}),
    ],
)
def test_which_lanes_go_on_with_left_hand_traffic(before: str, after: str, expected: dict[int, int]) -> None:
    rule = Rule.LEFT_HAND
    assert match_lanes(section(before, rule), section(after, rule), rule) == expected


def test_lanes_are_listed_as_their_drivers_see_them() -> None:
    right = section("b b m f f")
    assert [lane.id for lane in lanes_of(right, Direction.FORWARD, True)] == [-2, -3]
    assert [lane.id for lane in lanes_of(right, Direction.BACKWARD, False)] == [1, 2]
    assert [lane.id for lane in lanes_of(right, Direction.BOTH, True)] == [-1]
    left = section("f f m b b", Rule.LEFT_HAND)
    assert [lane.id for lane in lanes_of(left, Direction.FORWARD, True)] == [3, 2]
    assert [lane.id for lane in lanes_of(left, Direction.BACKWARD, False)] == [-2, -1]


_LANES = st.lists(st.sampled_from(["", "l", "t", "r", "ml", "mr", "l;t"]), max_size=5)


@given(_LANES, _LANES, _LANES, _LANES, st.sampled_from(list(Rule)))
def test_lanes_keep_their_order_and_as_many_go_on_as_can(
    back: list[str], along: list[str], back_after: list[str], along_after: list[str], rule: Rule
) -> None:
    def read(backward: list[str], forward: list[str]) -> CrossSection:
        left = [f"b:{turns}" for turns in backward]
        right = [f"f:{turns}" for turns in forward]
        return section(" ".join(left + right if rule is Rule.RIGHT_HAND else right + left), rule)

    found = match_lanes(read(back, along), read(back_after, along_after), rule)
    assert len(found) == min(len(back), len(back_after)) + min(len(along), len(along_after))
    assert len(set(found.values())) == len(found)
    pairs = sorted(found.items())
    assert [to for _, to in pairs] == sorted(to for _, to in pairs)
    assert all((lane > 0) == (to > 0) for lane, to in pairs)
