"""Which lane goes on as which where the number of lanes changes along a street."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Final

from osm2xodr.geometry.lanes.cross_sections import CrossSection
from osm2xodr.geometry.lanes.lane_connectivity import FOR_CARS, StatedLanes
from osm2xodr.geometry.lanes.turn_marks import to_left, to_right
from osm2xodr.model import Direction, LaneSpec, Rule

# Lanes run on in line where another pairing of them would shift each by this much more, m.
_IN_LINE: Final = 0.5


def match_lanes(
    before: CrossSection, after: CrossSection, rule: Rule, stated: Mapping[Direction, StatedLanes] | None = None
) -> dict[int, int]:
    """Map lane ids before a place to those after it, for the lanes that go on.

    Lanes keep their direction, their kind (for cars or not) and their order. Which side a lane opens or ends on is
    read from a connectivity relation, else from ``turn:lanes`` (new turn lanes, ``merge_to_left``), else from where
    the others run on straight (``placement``), else it is the near side of traffic. A lane for both directions that
    ends where a lane for turns opens in its place goes on as that lane.

    Parameters
    ----------
    before, after
        The lanes on either side of the place.
    rule
        Side of the road that one drives on.
    stated
        What relations say of either direction.
    """
    found: dict[int, int] = {}
    for direction, for_cars in product((Direction.FORWARD, Direction.BOTH, Direction.BACKWARD), (True, False)):
        first = [item for item in lanes_of(before, direction) if (item[1].type in FOR_CARS) == for_cars]
        second = [item for item in lanes_of(after, direction) if (item[1].type in FOR_CARS) == for_cars]
        upstream, downstream = (second, first) if direction is Direction.BACKWARD else (first, second)
        sections = (after, before) if direction is Direction.BACKWARD else (before, after)
        sign = -1.0 if direction is Direction.BACKWARD else 1.0
        places = [
            [sign * lane_middle(section, lane) for lane, _ in lanes]
            for section, lanes in zip(sections, (upstream, downstream), strict=True)
        ]
        up_specs, down_specs = [spec for _, spec in upstream], [spec for _, spec in downstream]
        pairs = _stated(stated.get(direction), up_specs, down_specs, rule) if stated and for_cars else None
        if pairs is None:
            pairs = _pairs(up_specs, down_specs, places[0], places[1], rule)
        for up, down in pairs:
            if direction is Direction.BACKWARD:
                found[first[down][0]] = second[up][0]
            else:
                found[first[up][0]] = second[down][0]
    return found | _centre_to_pocket(before, after, found)


def _centre_to_pocket(before: CrossSection, after: CrossSection, found: Mapping[int, int]) -> dict[int, int]:
    """Return the link from an ending lane for both directions to the lane that opens in its place.

    Only along the street: the ids of two lanes on either side of the centre cannot be linked.
    """
    ending = [lane for lane, _ in lanes_of(before, Direction.BOTH) if lane not in found]
    opening = [lane for lane, _ in lanes_of(after, Direction.FORWARD) if lane not in found.values()]
    between = [(one, other) for one in ending for other in opening if abs(one) == 1 and one == other]
    return dict(between)


def _stated(
    stated: StatedLanes | None, upstream: Sequence[LaneSpec], downstream: Sequence[LaneSpec], rule: Rule
) -> list[tuple[int, int]] | None:
    """Return the pairs of lanes that relations name, in order and each lane once; None where they do not fit.

    Links that are not optional go first; of a lane that leads to several, the one away from the near side of traffic
    runs on, the others open beside it.
    """
    pairs = None if stated is None else stated.between(upstream, downstream)
    if stated is None or pairs is None:
        return None
    far_first = 1 if rule is Rule.RIGHT_HAND else -1
    ranked = sorted(
        zip(pairs, stated.pairs, strict=True), key=lambda item: (item[1][2], *(far_first * k for k in item[0]))
    )
    chosen: list[tuple[int, int]] = []
    for (up, down), _ in ranked:
        if all((up < a and down < b) or (up > a and down > b) for a, b in chosen):
            chosen.append((up, down))
    return sorted(chosen)


def lanes_of(section: CrossSection, direction: Direction) -> list[tuple[int, LaneSpec]]:
    """Return (lane id, lane) of one direction, left to right as its drivers see them."""
    lanes = [
        *((number, lane) for number, lane in enumerate(section.left, start=1)),
        *((-number, lane) for number, lane in enumerate(section.right, start=1)),
    ]
    chosen = [item for item in lanes if item[1].direction is direction]
    # Ids grow to the left of the street, which is the drivers' right against it.
    return sorted(chosen, key=lambda item: item[0] if direction is Direction.BACKWARD else -item[0])


def lane_middle(section: CrossSection, lane: int) -> float:
    """Return t of the middle of a lane, m."""
    lanes, side = (section.left, 1.0) if lane > 0 else (section.right, -1.0)
    inner = sum(spec.width for spec in lanes[: abs(lane) - 1])
    return section.centre + side * (inner + lanes[abs(lane) - 1].width / 2)


def _pairs(
    upstream: Sequence[LaneSpec],
    downstream: Sequence[LaneSpec],
    t_upstream: Sequence[float],
    t_downstream: Sequence[float],
    rule: Rule,
) -> list[tuple[int, int]]:
    """Pair lanes, left to right as drivers see them, where the count may change; t is left positive to them."""
    gain = len(downstream) - len(upstream)
    fewer = min(len(upstream), len(downstream))
    if not gain or not fewer:
        return [(k, k) for k in range(fewer)]
    if gain > 0:
        left_hand = rule is Rule.LEFT_HAND
        marks = _marked(downstream, to_left(left_hand)), _marked(downstream, to_right(left_hand), right=True)
    else:
        marks = _leading(upstream, "merge_to_right"), _leading(upstream[::-1], "merge_to_left")
    in_line = None if any(marks) else _in_line(abs(gain), fewer, t_upstream, t_downstream, gain > 0)
    left = _at_left(abs(gain), *marks, rule) if in_line is None else in_line
    return [(k, k + left) if gain > 0 else (k + left, k) for k in range(fewer)]


def _in_line(
    change: int, fewer: int, t_upstream: Sequence[float], t_downstream: Sequence[float], gains: bool
) -> int | None:
    """Return how many lanes come or go at the left if that keeps the others in line, None where nothing tells.

    ``placement`` tells: it says where the OSM line runs, and with it which lanes run on straight.
    """
    shifts = []
    for left in range(change + 1):
        pairs = ((k, k + left) if gains else (k + left, k) for k in range(fewer))
        shifts.append(sum(abs(t_upstream[up] - t_downstream[down]) for up, down in pairs) / fewer)
    best = min(range(change + 1), key=lambda left: shifts[left])
    others = [shift for left, shift in enumerate(shifts) if left != best]
    return best if min(others) - shifts[best] > _IN_LINE else None


def _at_left(change: int, left: int, right: int, rule: Rule) -> int:
    """Return how many of `change` lanes come or go at the left edge, given the lanes marked so at either edge."""
    if left + right == 0:
        return change if rule is Rule.LEFT_HAND else 0
    if left + right <= change:
        return left if right or rule is Rule.RIGHT_HAND else change
    return min(left, change) if not right else max(change - right, min(left, change) // 2)


def _marked(lanes: Sequence[LaneSpec], turns: frozenset[str], right: bool = False) -> int:
    """Count the lanes at the left (or right) edge that lead nowhere but to `turns`; 0 where all do."""
    count = 0
    for lane in lanes[::-1] if right else lanes:
        if not lane.turns or not lane.turns <= turns:
            break
        count += 1
    return 0 if count == len(lanes) else count


def _leading(lanes: Sequence[LaneSpec], value: str) -> int:
    count = 0
    for lane in lanes:
        if value not in lane.turns:
            break
        count += 1
    return count
