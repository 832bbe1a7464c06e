"""Bicycle lanes lead on through junctions that their like does not continue straight on.

Lanes are written from left to right as their drivers see them: ``c`` is a bicycle lane, ``d`` one for cars, ``b`` for
buses. Links are (movement, entry lane, exit lane).
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from street_cases import Case

from osm2xodr.curves import cubic_value, lengths, pose, value_of_cubics
from osm2xodr.geometry.connections.lane_assignment import ArmLanes, LaneLink, LaneMovement, assign_lanes
from osm2xodr.geometry.connections.lane_links import lead_bicycles_on
from osm2xodr.model import Direction, LaneSpec, LaneType, Rule

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
_KINDS = {"c": LaneType.BIKING, "d": LaneType.DRIVING, "b": LaneType.BUS}


def arm(text: str) -> ArmLanes:
    lanes = tuple(LaneSpec(_KINDS[letter], Direction.FORWARD, 3.0) for letter in text)
    return ArmLanes(lanes, tuple(3.0 * ((len(lanes) - 1) / 2 - k) for k in range(len(lanes))))


def added(
    entries: str, exits: str, turns: dict[tuple[int, int], float], rule: Rule = Rule.RIGHT_HAND
) -> set[LaneLink]:
    """Return what is added for entries and exits, from 0 and 100 on, and turns between them, degrees.

    With left-hand traffic everything is seen in a mirror, and the result is turned back.
    """
    left = rule is Rule.LEFT_HAND
    ins, outs = ([text[::-1] if left else text for text in texts.split()] for texts in (entries, exits))
    sign = -1.0 if left else 1.0
    lanes_in = {k: arm(text) for k, text in enumerate(ins)}
    lanes_out = {100 + k: arm(text) for k, text in enumerate(outs)}
    movements = [
        LaneMovement(one, 100 + other, sign * math.radians(turn), lanes_in[one].t)
        for (one, other), turn in turns.items()
    ]
    known = assign_lanes(movements, lanes_in, lanes_out, left)
    found = lead_bicycles_on(movements, lanes_in, lanes_out, known, left)
    assert len(set(found)) == len(found)
    assert not set(found) & set(known)
    out = set()
    for k, one, other in found:
        entry, exit_ = ins[movements[k].entry], outs[movements[k].exit - 100]
        out.add((k, len(entry) - 1 - one, len(exit_) - 1 - other) if left else (k, one, other))
    return out


@EITHER
@pytest.mark.parametrize(
    ("entries", "exits", "turns", "expected"),
    [
        # Straight on to its like: nothing lacks.
        ("dc", "dc d", {(0, 0): 0.0, (0, 1): 90.0}, set()),
        # The lane ends: on with the cars at its side, also from the left, and as far as two lanes become one.
        ("dc", "d", {(0, 0): 0.0}, {(0, 1, 0)}),
        ("ddc", "dd dc", {(0, 0): 5.0, (0, 1): -90.0}, {(0, 2, 1), (1, 2, 1)}),
        ("cdd", "dd", {(0, 0): 0.0}, {(0, 0, 0)}),
        ("dcc", "ddc", {(0, 0): 0.0}, {(0, 1, 1)}),
        # Nothing straight on: round the corners to bicycle lanes, else round that of the near side.
        ("dc", "dc dc", {(0, 0): 90.0, (0, 1): -90.0}, {(0, 1, 1), (1, 1, 1)}),
        ("dc", "dc d", {(0, 0): 90.0, (0, 1): -90.0}, {(0, 1, 1)}),
        ("dc", "d d", {(0, 0): 90.0, (0, 1): -90.0}, {(1, 1, 0)}),
        ("dc", "d", {(0, 0): 90.0}, {(0, 1, 0)}),
        # Nobody turns back.
        ("dc", "dc", {(0, 0): 170.0}, set()),
        # No lane for cars beyond.
        ("dc", "b", {(0, 0): 0.0}, set()),
        # A lane that begins round a corner is reached from one side, the near one if there is a choice.
        ("dc dc", "dc dc", {(0, 0): 0.0, (0, 1): -90.0, (1, 1): 90.0}, {(1, 1, 1), (2, 1, 1)}),
        ("dc d", "dc dc", {(0, 0): 0.0, (0, 1): 90.0, (1, 1): -90.0}, {(1, 1, 1)}),
        ("dc", "d dc", {(0, 0): 0.0, (0, 1): -90.0}, {(0, 1, 0), (1, 1, 1)}),
        # Where only cars come straight to it, too.
        ("dc d", "d dc", {(0, 0): 0.0, (0, 1): 90.0, (1, 1): 0.0}, {(0, 1, 0), (1, 1, 1)}),
        # Along the kerb of the near side, also where all lead straight on; not across lanes for cars, nor to the far
        # side.
        ("dc dc", "dc dc", {(0, 0): 0.0, (0, 1): -90.0, (1, 1): 0.0}, {(1, 1, 1)}),
        ("dc dc", "dc dc", {(0, 0): 0.0, (0, 1): 90.0, (1, 1): 0.0}, set()),
        ("dcd dc", "dc dc", {(0, 0): 0.0, (0, 1): -90.0, (1, 1): 0.0}, set()),
        ("dc dc", "dc dcd", {(0, 0): 0.0, (0, 1): -90.0, (1, 1): 0.0}, set()),
    ],
)
def test_bicycle_lanes_lead_on(
    entries: str, exits: str, turns: dict[tuple[int, int], float], expected: set[LaneLink], rule: Rule
) -> None:
    assert added(entries, exits, turns, rule) == expected


@EITHER
def test_where_a_bicycle_lane_ends_bicycles_join_the_cars_and_no_car_its_lane(rule: Rule) -> None:
    nodes = {"w": (-100.0, 0.0), "a": (0.0, 0.0), "e": (100.0, 0.0), "s": (0.0, -100.0)}
    ways = {1: ("w a", "oneway=yes cycleway=lane"), 2: ("a e", "oneway=yes"), 3: ("s a", "oneway=yes")}
    case = Case(nodes, ways) if rule is Rule.RIGHT_HAND else Case(nodes, ways).mirrored()
    roads = case.build(rule).roads
    through = [
        next((lane.type, abs(lane.predecessor or 0), abs(lane.successor or 0)) for lane in section.lanes if lane.id)
        for road in roads
        if road.junction is not None
        for section in road.lane_sections
    ]
    car = LaneType.DRIVING, 1, 1
    assert sorted(through) == sorted([car, car, (LaneType.BIKING, 2, 1)])


@EITHER
@pytest.mark.parametrize(("side", "lanes"), [("right", 1), ("right", 2), ("left", 2)])
@pytest.mark.parametrize("far", [False, True])
def test_bicycles_that_join_cars_keep_to_the_edge_of_their_lane(side: str, lanes: int, far: bool, rule: Rule) -> None:
    # With far arms the way through the junction is long enough to widen by 1 in 5, else by 1 in 1.
    nodes = {"w": (-100.0, 0.0), "a": (0.0, 0.0), "e": (100.0, 0.0), "s": (0.0, -100.0)}
    right = (side == "right") is (rule is Rule.RIGHT_HAND)
    side = "right" if right else "left"
    beside = f"cycleway:{side}=lane cycleway:{side}:width=1.5"
    ways = {
        1: ("w a", f"oneway=yes lanes={lanes} width=7.5 {beside} maxspeed=50"),
        2: ("a e", f"oneway=yes lanes={lanes} width={3 * lanes} maxspeed=50"),
        3: ("s a", "oneway=yes maxspeed=50 " + ("lanes=6 width=30" if far else "lanes=1 width=3")),
    }
    case = Case(nodes, ways) if rule is Rule.RIGHT_HAND else Case(nodes, ways).mirrored()
    road_map = case.build(rule)
    number, road, lane = next(
        (k, road, lane)
        for k, road in enumerate(road_map.roads)
        if road.junction is not None
        for lane in road.lane_sections[0].lanes
        if lane.type is LaneType.BIKING and lane.predecessor is not None
    )
    length = float(lengths(road_map.plan_view)[number])
    s = np.linspace(0.0, length, 1001)
    begins = [section.s for section in road.lane_sections]
    parts = [next(item for item in section.lanes if item.id == lane.id) for section in road.lane_sections]
    of = np.searchsorted(begins, s, "right") - 1
    width = np.array([value_of_cubics(parts[k].widths, float(at - begins[k])) for k, at in zip(of, s, strict=True)])
    offset = cubic_value(road_map.lane_offset, np.full(len(s), number), s)
    assert width[[0, -1]] == pytest.approx([1.5, 3.0], abs=1e-9)
    # A smooth step by 1.5 m that is steepest at 1 in 1 is 2.25 m long; one for cars 7.75 times 1.5 m.
    taper = 11.625 if far else 2.25
    assert taper + 1.0 < length < (np.inf if far else 11.0)
    assert width[s < length - taper] == pytest.approx(1.5, abs=1e-9)
    assert np.abs(np.diff(width) / np.diff(s)).max() == pytest.approx(2.25 / taper, abs=1e-3)
    if far:
        # It is a lane for cars there.
        assert begins == pytest.approx([0.0, length - taper], abs=1e-6)
        assert [item.type for item in parts] == [LaneType.BIKING, LaneType.DRIVING]
        assert [item.speed for item in parts] == [None, pytest.approx(50 / 3.6)]
        assert (parts[0].successor, parts[1].predecessor) == (lane.id, lane.id)
        assert parts[1].successor is not None
    else:
        assert begins == [0.0]
    # Its outer edge stays beside the middle of the narrow lane, and runs on into that of the carriageway.
    edges = offset, offset + math.copysign(1.0, lane.id) * width
    outer = np.minimum(*edges) if right else np.maximum(*edges)
    assert outer == pytest.approx(-0.75 if right else 0.75, abs=1e-9)
    arm = road_map.roads[number].successor
    assert arm is not None
    there = next(k for k, road in enumerate(road_map.roads) if road.id == arm.id)
    x, y, hdg = pose(road_map.plan_view, np.array([number, there]), np.array([length, 0.0]))
    assert np.cos(hdg) == pytest.approx([1.0, 1.0], abs=1e-9)
    assert x[0] == pytest.approx(x[1], abs=1e-4)
    # Lanes one way lie at one side of the centre line.
    centre = float(cubic_value(road_map.lane_offset, np.array([there]), np.zeros(1))[0])
    beyond = {(True, Rule.RIGHT_HAND): -3.0, (False, Rule.LEFT_HAND): 3.0}.get((right, rule), 0.0) * lanes
    assert y[0] + outer[-1] - y[1] == pytest.approx(centre + beyond, abs=1e-4)
