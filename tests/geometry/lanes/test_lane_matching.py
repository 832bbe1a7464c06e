"""Which lanes go on where their number changes along a street."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import pytest
from hypothesis import given, strategies as st
from lane_cases import section as lane_section

from osm2xodr.geometry.lanes.cross_sections import CrossSection, cross_section, lanes_of
from osm2xodr.geometry.lanes.lane_connectivity import StatedLanes
from osm2xodr.geometry.lanes.lane_matching import _at_left, match_lanes
from osm2xodr.model import Direction, LaneSpec, LaneType, Rule, StreetAttributes, Structure

_DIRECTIONS = {"f": Direction.FORWARD, "b": Direction.BACKWARD, "m": Direction.BOTH}
_TURNS = {"l": "left", "t": "through", "r": "right", "u": "reverse", "ml": "merge_to_left", "mr": "merge_to_right"}


def section(text: str, rule: Rule = Rule.RIGHT_HAND) -> CrossSection:
    """Read lanes from left to right as seen along the street: ``b f:l fB``: one back, a left turn, one for buses."""
    lanes = []
    for word in text.split():
        direction, _, turns = word.partition(":")
        marks = frozenset(_TURNS[turn] for turn in turns.split(";") if turn)
        kind = LaneType.BUS if direction.endswith("B") else LaneType.DRIVING
        lanes.append(LaneSpec(kind, _DIRECTIONS[direction[0]], 3.0, marks))
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
        # Cars do not continue on a lane for buses, but every lane as one if nothing else is there.
        ("f fB", "f", {-1: -1}),
        ("fB f", "f", {-2: -1}),
        ("fB f f", "f f", {-2: -1, -3: -2}),
        ("f", "fB f", {-1: -2}),
        ("b bB f", "b f", {2: 1, -1: -1}),
        ("fB", "f f", {-1: -1}),
        ("f:mr fB", "f", {-2: -1}),
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


@pytest.mark.parametrize("change", range(1, 5))
def test_left_hand_traffic_is_the_mirror_image(change: int) -> None:
    for left, right in product(range(5), repeat=2):
        mirrored = change - _at_left(change, right, left, Rule.RIGHT_HAND)
        assert _at_left(change, left, right, Rule.LEFT_HAND) == mirrored
    # One of three new lanes is marked at either edge: the third opens at the near side.
    assert _at_left(3, 1, 1, Rule.RIGHT_HAND) == 1
    assert _at_left(3, 1, 1, Rule.LEFT_HAND) == 2


@pytest.mark.parametrize("more", [1, 2, 3])
def test_lanes_open_and_end_with_left_hand_traffic_as_in_the_mirror(more: int) -> None:
    """Two lanes that open, with one marked for the far side, open one at each side."""
    other = {"": "", "l": "r", "r": "l", "t": "t", "ml": "mr", "mr": "ml"}

    def text(turns: Sequence[str]) -> str:
        return " ".join(f"f:{turn}" for turn in turns)

    for before in product(["", "ml", "mr"], repeat=1):
        for after in product(["", "l", "r", "t"], repeat=1 + more):
            seen = [[other[turn] for turn in reversed(turns)] for turns in (before, after)]
            right, left = Rule.RIGHT_HAND, Rule.LEFT_HAND
            found = match_lanes(section(text(before), right), section(text(after), right), right)
            mirrored = match_lanes(section(text(seen[0]), left), section(text(seen[1]), left), left)
            assert mirrored == {-one: -to for one, to in found.items()}
    left = Rule.LEFT_HAND
    assert match_lanes(section("f", left), section("f f f:r", left), left) == {1: 2}
    assert match_lanes(section("f", left), section("f:l f f", left), left) == {1: 1}


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


@pytest.mark.parametrize(
    ("before", "after", "right_hand", "left_hand"),
    [
        # Turning back leads across the oncoming traffic: left on the right, right on the left.
        ("f", "f:u f:t", {-1: -2}, {1: 1}),
        ("f", "f:t f:u", {-1: -1}, {1: 2}),
        # Where all lanes turn, or one also leads on, their marks say nothing about an edge.
        ("f", "f:l f:l", {-1: -1}, {1: 1}),
        ("f", "f:l;t f:t", {-1: -1}, {1: 1}),
        ("f", "f:l f", {-1: -2}, {1: 1}),
        ("f", "f:r f:t", {-1: -1}, {1: 1}),
        # One lane opens, two claim to be it: the near side of traffic decides.
        ("f", "f:l f:r", {-1: -1}, {1: 1}),
        ("f f", "f:l f:l f:t", {-1: -2, -2: -3}, {2: 2, 1: 1}),
        ("f f", "f:t f:r f:r", {-1: -1, -2: -2}, {2: 3, 1: 2}),
        # Two lanes open, three claim to be them.
        ("f", "f:l f:l f:r", {-1: -2}, {1: 1}),
        ("f", "f:l f:r f:r", {-1: -1}, {1: 2}),
        ("f f", "f:l f:l f:r f:r", {-1: -2, -2: -3}, {2: 3, 1: 2}),
        # Fewer claims than lanes that open: the rest opens at the near side.
        ("f", "f:l f f", {-1: -2}, {1: 1}),
        # Lanes that merge end, at either side and whatever the side of traffic.
        ("f:mr f:mr f", "f", {-3: -1}, {1: 1}),
        ("f f:ml f:ml", "f", {-1: -1}, {3: 1}),
        ("f:mr f f:ml", "f", {-2: -1}, {2: 1}),
        ("f:ml f", "f", {-1: -1}, {1: 1}),
        ("f:t f:mr", "f", {-1: -1}, {1: 1}),
        ("f:mr f f f", "f f", {-2: -1, -3: -2}, {2: 2, 1: 1}),
    ],
)
def test_at_which_side_lanes_open_and_end(
    before: str, after: str, right_hand: dict[int, int], left_hand: dict[int, int]
) -> None:
    for rule, expected in ((Rule.RIGHT_HAND, right_hand), (Rule.LEFT_HAND, left_hand)):
        assert match_lanes(section(before, rule), section(after, rule), rule) == expected


@pytest.mark.parametrize(
    ("middle", "expected"),
    [
        # A second lane of 3 m opens; the other shifts by |middle + 1.5| or |middle - 1.5|: positions decide only
        # where the smaller shift is smaller by more than half a metre.
        (1.5, {-1: -2}),
        (0.26, {-1: -2}),
        (0.25, {-1: -1}),
        (0.0, {-1: -1}),
        (-0.25, {-1: -1}),
        (-1.5, {-1: -1}),
    ],
)
def test_lanes_continue_in_line_where_that_is_clear(middle: float, expected: dict[int, int]) -> None:
    one, two = lane_section("d>"), lane_section("d> d>", middle=middle)
    assert match_lanes(one, two, Rule.RIGHT_HAND) == expected
    assert match_lanes(two, one, Rule.RIGHT_HAND) == {to: lane for lane, to in expected.items()}
    # Of two lanes that continue the mean shift counts.
    two, three = lane_section("d> d>"), lane_section("d> d> d>", middle=middle)
    wanted = {-1: -2, -2: -3} if expected == {-1: -2} else {-1: -1, -2: -2}
    assert match_lanes(two, three, Rule.RIGHT_HAND) == wanted
    # Against the street left and right change places.
    found = match_lanes(lane_section("d<"), lane_section("d< d<", middle=-middle), Rule.RIGHT_HAND)
    assert found == dict.fromkeys([1], -expected[-1])


def test_turn_lanes_count_for_more_than_positions() -> None:
    one, two = lane_section("d>"), lane_section("d>/left d>/through", middle=-1.5)
    assert match_lanes(one, two, Rule.RIGHT_HAND) == {-1: -2}


def test_lanes_keep_to_their_kind() -> None:
    """Lanes for bicycles are no part of the count of those for cars, buses and taxis."""
    found = match_lanes(lane_section("d> c>"), lane_section("d> d> c>"), Rule.RIGHT_HAND)
    assert found == {-1: -1, -2: -3}
    found = match_lanes(lane_section("b> d> c>"), lane_section("d> t> c>"), Rule.RIGHT_HAND)
    assert found == {-1: -1, -2: -2, -3: -3}
    assert match_lanes(lane_section("c> d>"), lane_section("d> d>"), Rule.RIGHT_HAND) == {-2: -2}


def test_a_centre_lane_becomes_a_pocket_only_along_the_street() -> None:
    centre = lane_section("d< d= d>")
    assert match_lanes(centre, lane_section("d< d> d>"), Rule.RIGHT_HAND) == {1: 1, -1: -1, -2: -2}
    one, other = (lane_section(text, Rule.LEFT_HAND) for text in ("d> d= d<", "d> d> d<"))
    assert match_lanes(one, other, Rule.LEFT_HAND) == {2: 2, 1: 1, -1: -1}
    # The pocket of those who come against it lies beyond the centre line.
    assert match_lanes(centre, lane_section("d< d< d>"), Rule.RIGHT_HAND) == {1: 2, -2: -1}


@pytest.mark.parametrize(
    ("pairs", "expected"),
    [
        (((1, 1, False), (2, 2, False)), {-1: -1, -2: -2}),
        (((1, 2, False), (2, 3, False)), {-1: -2, -2: -3}),
        # Of two lanes that one leads to, the far one runs on with traffic on the right.
        (((1, 1, False), (1, 2, False), (2, 3, False)), {-1: -1, -2: -3}),
        # Unless that is optional.
        (((1, 1, True), (1, 2, False), (2, 3, False)), {-1: -2, -2: -3}),
        # Lanes do not cross.
        (((1, 2, False), (2, 1, False)), {-1: -2}),
        # A relation about lanes that are not there says nothing.
        (((1, 1, False), (2, 4, False)), {-1: -1, -2: -2}),
    ],
)
def test_relations_say_which_lanes_continue(
    pairs: tuple[tuple[int, int, bool], ...], expected: dict[int, int]
) -> None:
    stated = {Direction.FORWARD: StatedLanes(pairs, (1,))}
    assert match_lanes(section("f f"), section("f f f"), Rule.RIGHT_HAND, stated) == expected


def test_the_far_lane_runs_on_with_traffic_on_the_left() -> None:
    stated = {Direction.FORWARD: StatedLanes(((1, 1, False), (1, 2, False), (2, 3, False)), (1,))}
    one, other = section("f f", Rule.LEFT_HAND), section("f f f", Rule.LEFT_HAND)
    assert match_lanes(one, other, Rule.LEFT_HAND, stated) == {2: 2, 1: 1}


@pytest.mark.parametrize(
    ("pairs", "right_hand", "left_hand"),
    [
        # Of two lanes that lead into one, the far one runs on, unless that is optional.
        (((1, 1, False), (2, 1, False)), {-1: -1}, {1: 1}),
        (((1, 1, True), (2, 1, False)), {-2: -1}, {1: 1}),
        (((1, 1, False), (2, 1, True)), {-1: -1}, {2: 1}),
        # Of those that cross, the far one.
        (((1, 2, False), (2, 1, False)), None, None),
    ],
)
def test_of_two_lanes_into_one_the_far_one_continues(
    pairs: tuple[tuple[int, int, bool], ...], right_hand: dict[int, int] | None, left_hand: dict[int, int] | None
) -> None:
    """Where a relation speaks of a lane that is not there, both near lanes are those that stay."""
    for rule, expected in ((Rule.RIGHT_HAND, right_hand), (Rule.LEFT_HAND, left_hand)):
        stated = {Direction.FORWARD: StatedLanes(pairs, (1,))}
        found = match_lanes(section("f f", rule), section("f", rule), rule, stated)
        assert found == (
            match_lanes(section("f f", rule), section("f", rule), rule) if expected is None else expected
        )


def test_relations_about_lanes_of_cars_leave_those_of_bicycles_as_they_are() -> None:
    stated = {Direction.FORWARD: StatedLanes(((1, 2, False),), (1,)), Direction.BACKWARD: StatedLanes((), (2,))}
    found = match_lanes(lane_section("d< d> c>"), lane_section("d< d> d> c>"), Rule.RIGHT_HAND, stated)
    assert found == {-1: -2, -2: -3}


def test_a_centre_lane_goes_on_as_a_pocket_only_where_the_pocket_opens() -> None:
    """Where the lane in its place continues another one, or the centre lane goes on, they are not linked."""
    centre = lane_section("d< d= d>")
    assert match_lanes(centre, lane_section("d< d= d> d>"), Rule.RIGHT_HAND) == {1: 1, -1: -1, -2: -2}
    assert match_lanes(centre, lane_section("d< d>"), Rule.RIGHT_HAND) == {1: 1, -2: -1}
    # From the pocket back to a centre lane there is no link.
    assert match_lanes(lane_section("d< d> d>"), centre, Rule.RIGHT_HAND) == {1: 1, -2: -2}
