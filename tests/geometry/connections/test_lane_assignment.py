"""Which lane leads where through a junction: turn:lanes, unmarked lanes, forks and merges.

Lanes are written from left to right as their drivers see them: ``l|t;r`` is a lane for left turns and one for
straight on and right turns. Links are (movement, entry lane, exit lane).
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given, settings, strategies as st

from osm2xodr.geometry.connections.lane_assignment import (
    ArmLanes,
    LaneLink,
    LaneMovement,
    _meant,
    assign_lanes,
    lanes_per_movement,
)
from osm2xodr.model import Direction, LaneSpec, LaneType

_WORDS = {
    "l": "left",
    "t": "through",
    "r": "right",
    "sl": "slight_left",
    "sr": "slight_right",
    "u": "reverse",
    "hl": "sharp_left",
    "hr": "sharp_right",
    "ml": "merge_to_left",
    "mr": "merge_to_right",
}
WIDTH = 3.0


def specs(text: str) -> tuple[LaneSpec, ...]:
    """Read lanes; ``b`` is a bus lane, ``c`` a cycle lane, ``-`` one without a mark."""
    found = []
    for lane in text.split("|"):
        kind = {"b": LaneType.BUS, "c": LaneType.BIKING}.get(lane, LaneType.DRIVING)
        turns = frozenset(_WORDS[word] for word in lane.split(";") if word in _WORDS)
        found.append(LaneSpec(kind, Direction.FORWARD, WIDTH, turns))
    return tuple(found)


def arm(text: str) -> ArmLanes:
    """Return lanes around the reference line."""
    lanes = specs(text)
    return ArmLanes(lanes, tuple(WIDTH * ((len(lanes) - 1) / 2 - k) for k in range(len(lanes))))


def crossing(entry: str, exits: dict[float, str], *, left_hand: bool = False) -> list[LaneLink]:
    """Assign the lanes of one entry to exits by their turn in degrees, all centred on their streets."""
    lanes = arm(entry)
    movements = [LaneMovement(0, k, math.radians(turn), lanes.t) for k, turn in enumerate(exits)]
    return assign_lanes(movements, {0: lanes}, {k: arm(text) for k, text in enumerate(exits.values())}, left_hand)


def links(text: str) -> list[LaneLink]:
    """Read ``movement:lane>lane`` words."""
    found = []
    for word in text.split():
        movement, rest = word.split(":")
        source, target = rest.split(">")
        found.append((int(movement), int(source), int(target)))
    return sorted(found)


@pytest.mark.parametrize(
    ("entry", "turns", "lanes"),
    [
        ("-", (90, 0, -90), [[0], [0], [0]]),
        ("-|-", (90, 0, -90), [[0], [0, 1], [1]]),
        ("-|-|-", (90, 0, -90), [[0], [0, 1, 2], [2]]),
        ("-|-", (90, -90), [[0], [1]]),
        ("-|-|-", (90, -90), [[0, 1], [1, 2]]),
        ("-|-", (0, -90), [[0, 1], [1]]),
        ("-|-", (90, 0), [[0], [0, 1]]),
        ("-|-|-", (5,), [[0, 1, 2]]),
        ("l|t|r", (90, 0, -90), [[0], [1], [2]]),
        ("l|t|t;r", (90, 0, -90), [[0], [1, 2], [2]]),
        ("l|l|t", (90, 0), [[0, 1], [2]]),
        ("l|t", (90, 0, -90), [[0], [1], [1]]),
        ("t|r", (90, 0, -90), [[0], [0], [1]]),
        ("l;t|-", (90, 0, -90), [[0], [0, 1], [1]]),
        ("l;t;r", (90, 0, -90), [[0], [0], [0]]),
        ("sl|t", (30, 0), [[0], [1]]),
        ("t|sr", (0, -20), [[0], [1]]),
        ("l|sl|t", (90, 40, 0), [[0], [1], [2]]),
        ("t|sr|r", (0, -40, -100), [[0], [1], [2]]),
        ("u|l|t", (175, 90, 0), [[0], [1], [2]]),
        ("u;l|t", (90, 0), [[0], [1]]),
        ("t|t|b", (0, -90), [[0, 1], [1]]),
        ("l|b|r", (90, -90), [[0], [2]]),
        ("c|l|r", (90, -90), [[1], [2]]),
        ("b|b", (90, -90), [[0], [1]]),
    ],
)
def test_lanes_per_movement(entry: str, turns: tuple[float, ...], lanes: list[list[int]]) -> None:
    found = lanes_per_movement(specs(entry), [math.radians(turn) for turn in turns], [1] * len(turns))
    assert found == lanes


@pytest.mark.parametrize(
    ("entry", "exits", "expected"),
    [
        ("-", {90.0: "-", 0.0: "-", -90.0: "-"}, "0:0>0 1:0>0 2:0>0"),
        ("-|-", {90.0: "-|-", 0.0: "-|-", -90.0: "-|-"}, "0:0>0 0:0>1 1:0>0 1:1>1 2:1>1 2:1>0"),
        ("l|l|t", {90.0: "-|-", 0.0: "-"}, "0:0>0 0:1>1 1:2>0"),
        ("l|l|t", {90.0: "-|-|-", 0.0: "-"}, "0:0>0 0:1>1 0:1>2 1:2>0"),
        ("t|r|r", {0.0: "-", -90.0: "-|-|-"}, "0:0>0 1:1>1 1:2>2 1:1>0"),
        ("t|t|r", {0.0: "-|-", -90.0: "-"}, "0:0>0 0:1>1 1:2>0"),
        ("-|-", {90.0: "-|-|-"}, "0:0>0 0:1>1 0:1>2"),
        ("-|-", {-90.0: "-|-|-"}, "0:0>1 0:1>2 0:0>0"),
        ("-|-|-", {90.0: "-|-"}, "0:0>0 0:1>1 0:2>1"),
    ],
)
def test_links_of_one_entry(entry: str, exits: dict[float, str], expected: str) -> None:
    assert crossing(entry, exits) == links(expected)


@pytest.mark.parametrize(("left_hand", "expected"), [(False, "0:0>0 0:1>1 0:1>2"), (True, "0:0>0 0:0>1 0:1>2")])
def test_a_lane_comes_at_the_near_side_where_nothing_else_is_known(left_hand: bool, expected: str) -> None:
    """Both lanes lie half a lane off either way, so the side of the road that one drives on decides."""
    assert crossing("-|-", {0.0: "-|-|-"}, left_hand=left_hand) == links(expected)


def test_a_lane_leads_to_the_one_ahead_of_it() -> None:
    lanes = arm("-")
    for t, expected in ((4.0, 0), (0.4, 1), (-3.5, 2)):
        movement = LaneMovement(0, 1, 0.0, (t,))
        found = assign_lanes([movement], {0: lanes}, {1: arm("-|-|-")}, False)
        assert (0, 0, expected) in found
        assert {to for _, _, to in found} == {0, 1, 2}


def test_two_arms_that_merge_get_lanes_of_their_own() -> None:
    movements = [LaneMovement(0, 9, 0.0, (6.0, 3.0)), LaneMovement(1, 9, math.radians(10.0), (-3.0,))]
    entries = {0: arm("-|-"), 1: arm("-")}
    assert assign_lanes(movements, entries, {9: arm("-|-|-")}, False) == links("0:0>0 0:1>1 1:0>2")
    assert assign_lanes(movements, entries, {9: arm("-|-")}, False) == links("0:0>0 0:1>1 1:0>1")


def test_a_street_that_splits_keeps_its_lanes_side_by_side() -> None:
    assert crossing("-|-|-", {8.0: "-|-", -12.0: "-"}) == links("0:0>0 0:1>1 1:2>0")
    assert crossing("-|-", {8.0: "-|-", -12.0: "-"}) == links("0:0>0 0:1>1 1:1>0")
    assert crossing("-|-|-|-", {8.0: "-|-", -12.0: "-|-"}) == links("0:0>0 0:1>1 1:2>0 1:3>1")


def test_a_street_that_splits_shares_one_lane_at_most() -> None:
    assert crossing("-|-|-", {-4.0: "-|-|-", -14.0: "-|-"}) == links("0:0>0 0:1>1 0:2>2 1:2>0 1:2>1")
    assert crossing("-|-|-", {14.0: "-|-", 4.0: "-|-|-"}) == links("0:0>0 0:0>1 1:0>0 1:1>1 1:2>2")
    assert crossing("-|-|-", {40.0: "-", 5.0: "-", -30.0: "-"}) == links("0:0>0 1:1>0 2:2>0")
    assert crossing("-|-", {40.0: "-", 5.0: "-|-", -30.0: "-"}) == links("0:0>0 1:0>0 1:1>1 2:1>0")


@pytest.mark.parametrize(
    ("entry", "exit_", "expected"),
    [
        ("l|t|r", "l|t|r", "0:0>0 0:1>1 0:2>2"),
        ("l|t", "l|t|r", "0:0>0 0:1>1 0:1>2"),
        ("t|t", "l|t|t", "0:0>1 0:1>2 0:0>0"),
        ("t|t", "t|t|r", "0:0>0 0:1>1 0:1>2"),
        ("t|r", "l|t|r", "0:0>1 0:1>2 0:0>0"),
        ("-|-", "l|-|-|r", "0:0>1 0:1>2 0:0>0 0:1>3"),
    ],
)
def test_lanes_lead_into_pockets_of_their_own_side_alone(entry: str, exit_: str, expected: str) -> None:
    assert crossing(entry, {0.0: exit_}) == links(expected)


def test_links_that_a_relation_names_are_all_there_are() -> None:
    lanes = arm("-|-|-")
    ahead = LaneMovement(0, 1, 0.0, lanes.t, ((0, 0), (1, 1), (1, 2)))
    turn = LaneMovement(0, 2, math.radians(-90.0), lanes.t)
    exits = {1: arm("-|-|-|-"), 2: arm("-")}
    assert assign_lanes([ahead, turn], {0: lanes}, exits, False) == links("0:0>0 0:1>1 0:1>2 1:2>0")
    assert assign_lanes([replace(ahead, stated=())], {0: lanes}, exits, False) == []


@pytest.mark.parametrize(
    ("entry", "exit_", "expected"),
    [
        ("-|c", "-|c", "0:0>0 0:1>1"),
        ("-|c", "-", "0:0>0"),
        ("-|b", "-|b", "0:0>0 0:1>1"),
        ("-|b", "-", "0:0>0 0:1>0"),
        ("-|-|b", "-|-", "0:0>0 0:1>1 0:2>1"),
        ("b|-|b", "-|b", "0:0>0 0:1>0 0:2>1"),
    ],
)
def test_lanes_set_apart_lead_straight_on_to_their_like(entry: str, exit_: str, expected: str) -> None:
    assert crossing(entry, {0.0: exit_, 90.0: "-"})[:-1] == links(expected)


@pytest.mark.parametrize(
    ("entry", "exits", "expected"),
    [
        # At the end of a street the lane for buses leads round the corner of its side, to its like or the lane there.
        ("-|b", {90.0: "-", -90.0: "-"}, "0:0>0 1:0>0 1:1>0"),
        ("-|b", {90.0: "-", -90.0: "-|b"}, "0:0>0 1:0>0 1:1>1"),
        ("b|-", {90.0: "-|-", -90.0: "-"}, "0:0>0 0:1>0 0:1>1 1:1>0"),
        # Round the only corner that there is, but not back where there is another one.
        ("-|b", {-115.0: "-"}, "0:0>0 0:1>0"),
        ("-|b|b", {97.0: "-|-"}, "0:0>0 0:0>1 0:1>0 0:2>1"),
        ("-|b", {90.0: "-", -170.0: "-"}, "0:0>0 0:1>0 1:0>0"),
        ("-|b", {-170.0: "-"}, "0:0>0 0:1>0"),
    ],
)
def test_lanes_for_buses_lead_round_corners_where_none_is_straight_on(
    entry: str, exits: dict[float, str], expected: str
) -> None:
    assert crossing(entry, exits) == links(expected)


def test_relations_say_where_buses_turn() -> None:
    lanes = arm("-|b")
    turn = LaneMovement(0, 1, math.radians(-90.0), lanes.t, ((0, 0),))
    assert assign_lanes([turn], {0: lanes}, {1: arm("-")}, False) == links("0:0>0")


_MARKS = ("-", "l", "t", "r", "l;t", "t;r", "sl", "sr", "l;r", "u", "b", "c", "ml", "mr")


@settings(max_examples=300, deadline=None)
@given(
    st.lists(st.sampled_from(_MARKS), min_size=1, max_size=5),
    st.lists(st.floats(-170.0, 170.0), min_size=1, max_size=5, unique_by=round),
    st.data(),
)
def test_every_movement_is_served_and_every_exit_lane_fed(
    entry: list[str], turns: list[float], data: st.DataObject
) -> None:
    exits = {turn: "|".join(["-"] * data.draw(st.integers(1, 4))) for turn in turns}
    found = crossing("|".join(entry), exits, left_hand=data.draw(st.booleans()))
    assert len(found) == len(set(found))
    assert {movement for movement, _, _ in found} == set(range(len(turns)))
    for movement, text in enumerate(exits.values()):
        assert {to for k, _, to in found if k == movement} == set(range(text.count("|") + 1))
    drivable = {k for k, lane in enumerate(entry) if lane not in ("b", "c")} or set(range(len(entry)))
    drivable |= {k for k, lane in enumerate(entry) if lane == "b"}
    assert {lane for _, lane, _ in found} == drivable


@settings(max_examples=300, deadline=None)
@given(
    st.lists(st.sampled_from(_MARKS[:8]), min_size=1, max_size=5),
    st.lists(st.floats(-170.0, 170.0), min_size=1, max_size=5, unique_by=round),
    st.data(),
)
def test_lanes_of_one_movement_never_cross(entry: list[str], turns: list[float], data: st.DataObject) -> None:
    exits = {turn: "|".join(["-"] * data.draw(st.integers(1, 4))) for turn in turns}
    found = crossing("|".join(entry), exits, left_hand=data.draw(st.booleans()))
    for one in found:
        for other in found:
            if one[0] == other[0] and one[1] < other[1]:
                assert one[2] <= other[2]


@settings(max_examples=200, deadline=None)
@given(st.integers(1, 5), st.lists(st.floats(-170.0, 170.0), min_size=1, max_size=5, unique_by=round))
def test_movements_from_unmarked_lanes_keep_their_order(lanes: int, turns: list[float]) -> None:
    """No lane turns to a place left of where a lane left of it may go, save where both may go there."""
    turns = sorted(turns, reverse=True)
    found = lanes_per_movement(
        specs("|".join(["-"] * lanes)), [math.radians(turn) for turn in turns], [1] * len(turns)
    )
    for left, right in pairwise(found):
        assert min(left) <= min(right)
        assert max(left) <= max(right)


_SIDES = {"left": "right", "right": "left"}


def _turned_over(lanes: ArmLanes) -> ArmLanes:
    def other(value: str) -> str:
        return "_".join(_SIDES.get(word, word) for word in value.split("_"))

    mirrored = tuple(replace(lane, turns=frozenset(map(other, lane.turns))) for lane in lanes.specs[::-1])
    return ArmLanes(mirrored, tuple(-t for t in lanes.t[::-1]))


@settings(max_examples=400, deadline=None)
@given(
    st.lists(st.lists(st.sampled_from(_MARKS), min_size=1, max_size=5), min_size=1, max_size=3),
    st.lists(st.lists(st.sampled_from(_MARKS[:5]), min_size=1, max_size=4), min_size=1, max_size=3),
    st.booleans(),
    st.data(),
)
def test_left_hand_traffic_is_the_mirror_image(
    ins: list[list[str]], outs: list[list[str]], left_hand: bool, data: st.DataObject
) -> None:
    entries = {k: arm("|".join(lanes)) for k, lanes in enumerate(ins)}
    exits = {10 + k: arm("|".join(lanes)) for k, lanes in enumerate(outs)}
    pairs = [(one, other) for one in entries for other in exits]
    # No two arms of one kind lie on each other: nothing could tell them apart.
    turns = data.draw(st.permutations([0, 8, -8, 20, -20, 34, 45, -45, 60, -60, 90, -90, 120, -120, 170, -170]))
    shifts = data.draw(st.permutations([0.0, 1.13, 1.71, -1.37, 3.07, -6.19, 7.23, -8.41, 9.07]))
    movements = [
        LaneMovement(one, other, math.radians(turn), tuple(t + shift for t in entries[one].t))
        for (one, other), turn, shift in zip(pairs, turns, shifts, strict=False)
    ]
    found = assign_lanes(movements, entries, exits, left_hand)
    turned = [replace(item, turn=-item.turn, lateral=tuple(-t for t in item.lateral[::-1])) for item in movements]
    turned_in, turned_out = ({k: _turned_over(lanes) for k, lanes in arms.items()} for arms in (entries, exits))
    mirrored = assign_lanes(turned, turned_in, turned_out, not left_hand)
    assert mirrored == sorted(
        (k, len(entries[movements[k].entry].specs) - 1 - one, len(exits[movements[k].exit].specs) - 1 - other)
        for k, one, other in found
    )


@pytest.mark.parametrize(("turn", "merges"), [(20.0, True), (33.0, True), (38.0, False)])
def test_arms_that_turn_little_into_one_exit_merge_side_by_side(turn: float, merges: bool) -> None:
    """A ramp from the right joins a road of two lanes that goes on with three."""
    main, ramp, exit_ = arm("-|-"), arm("-"), arm("-|-|-")
    movements = [
        LaneMovement(0, 9, 0.0, tuple(t + WIDTH / 2 for t in main.t)),
        LaneMovement(1, 9, math.radians(turn), (-WIDTH,)),
    ]
    found = assign_lanes(movements, {0: main, 1: ramp}, {9: exit_}, near_side_left=False)
    # Alone, the ramp leads to the lane ahead of it, which lies in the middle where it comes from there.
    assert (1, 0, 2) in found
    beside = [replace(movements[1], lateral=(0.0,))]
    shifted = assign_lanes([movements[0], *beside], {0: main, 1: ramp}, {9: exit_}, near_side_left=False)
    assert ((1, 0, 2) in shifted) == merges


@pytest.mark.parametrize(("turn", "straight"), [(46.0, True), (54.0, False)])
def test_turns_below_50_degrees_lead_straight_on(turn: float, straight: bool) -> None:
    found = lanes_per_movement(specs("-|-"), [math.radians(turn), math.radians(-90.0)], [1, 1])
    assert found == ([[0, 1], [1]] if straight else [[0], [1]])


@pytest.mark.parametrize(("turn", "meant"), [(7.0, 0), (13.0, 1)])
def test_a_turn_to_a_side_is_one_of_more_than_10_degrees(turn: float, meant: int) -> None:
    """A mark for slight turns to the left; streets at 90 degrees, nearly straight on, and straight on."""
    turns = [math.radians(value) for value in (90.0, turn, 0.0)]
    assert _meant("slight_left", turns, 2, near_side_left=False) == meant
