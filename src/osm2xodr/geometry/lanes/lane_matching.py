"""Which lane continues as which where the lanes of a street change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Final

from osm2xodr.geometry.lanes.cross_sections import CrossSection, EndLane, lanes_of
from osm2xodr.geometry.lanes.lane_connectivity import COUNTED_LANES, StatedLanes
from osm2xodr.model import Direction, LaneSpec, Rule

# Positions decide which lanes continue only where every other pairing shifts the lanes by this much more on average,
# m. A choice: ``placement`` moves lanes by half a lane or more, other widths by less than this.
_CLEARLY_IN_LINE: Final = 0.5

_LEFT: Final = frozenset({"left", "slight_left", "sharp_left"})
_RIGHT: Final = frozenset({"right", "slight_right", "sharp_right"})
# A driver turns back across the oncoming traffic, so away from the kerb.
_BACK: Final = frozenset({"reverse"})

# Pairs (lane upstream, lane downstream), counted from 0 at the left as their drivers see them.
_Pairs = list[tuple[int, int]]


def left_turns(left_hand: bool) -> frozenset[str]:
    """Return the values of ``turn:lanes`` that lead to the left, with traffic on the left or not."""
    return _LEFT if left_hand else _LEFT | _BACK


def right_turns(left_hand: bool) -> frozenset[str]:
    """Return the values of ``turn:lanes`` that lead to the right, with traffic on the left or not."""
    return _RIGHT | _BACK if left_hand else _RIGHT


def match_lanes(
    before: CrossSection, after: CrossSection, rule: Rule, stated: Mapping[Direction, StatedLanes] | None = None
) -> dict[int, int]:
    """Map lane ids before a place to those after it, for the lanes that continue.

    Lanes keep their direction, their kind (counted by relations or not) and their order. The side on which lanes open
    or end follows from the first of these that says anything: a connectivity relation; ``turn:lanes`` (new turn
    lanes, ``merge_to_left``); who may drive on them (cars do not continue on a lane for buses); the position of the
    lanes (``placement``); else it is the near side of traffic. A lane for both directions that ends where a turn lane
    opens in its place continues as that lane.
    """
    found: dict[int, int] = {}
    for direction, counted in product((Direction.FORWARD, Direction.BOTH, Direction.BACKWARD), (True, False)):
        along = direction is not Direction.BACKWARD
        upstream, downstream = (
            [lane for lane in lanes_of(section, direction, along) if (lane.spec.type in COUNTED_LANES) == counted]
            for section in ((before, after) if along else (after, before))
        )
        pairs = _stated_pairs(stated.get(direction), upstream, downstream, rule) if stated and counted else None
        if pairs is None:
            pairs = _pairs(upstream, downstream, rule, along)
        for up, down in pairs:
            one, other = upstream[up].id, downstream[down].id
            found.update({one: other} if along else {other: one})
    return found | _centre_to_pocket(before, after, found)


def _centre_to_pocket(before: CrossSection, after: CrossSection, found: Mapping[int, int]) -> dict[int, int]:
    """Return the link from an ending lane for both directions to the lane that opens in its place.

    Only along the street: two lanes on different sides of the centre cannot be linked, as their ids say.
    """
    ending = {lane.id for lane in lanes_of(before, Direction.BOTH, True) if lane.id not in found}
    opening = {lane.id for lane in lanes_of(after, Direction.FORWARD, True) if lane.id not in found.values()}
    return {lane: lane for lane in (1, -1) if lane in ending & opening}


def _stated_pairs(
    stated: StatedLanes | None, upstream: Sequence[EndLane], downstream: Sequence[EndLane], rule: Rule
) -> _Pairs | None:
    """Return the pairs of lanes that relations name, in order and each lane once; None where they do not fit.

    Links that are not optional go first; of a lane that leads to several, the one away from the near side of traffic
    continues, the others open beside it.
    """
    pairs = None if stated is None else stated.between(_specs(upstream), _specs(downstream))
    if stated is None or pairs is None:
        return None
    far_first = 1 if rule is Rule.RIGHT_HAND else -1
    ranked = sorted(
        zip(pairs, stated.pairs, strict=True), key=lambda item: (item[1][2], *(far_first * k for k in item[0]))
    )
    chosen: _Pairs = []
    for (up, down), _ in ranked:
        if all((up < a and down < b) or (up > a and down > b) for a, b in chosen):
            chosen.append((up, down))
    return sorted(chosen)


def _specs(lanes: Sequence[EndLane]) -> list[LaneSpec]:
    return [lane.spec for lane in lanes]


def _pairs(upstream: Sequence[EndLane], downstream: Sequence[EndLane], rule: Rule, along: bool) -> _Pairs:
    """Pair lanes, left to right as drivers see them, where their number may change."""
    gain = len(downstream) - len(upstream)
    fewer = min(len(upstream), len(downstream))
    if not gain or not fewer:
        return [(k, k) for k in range(fewer)]
    if gain > 0:
        left_hand, specs = rule is Rule.LEFT_HAND, _specs(downstream)
        marked = _turn_lanes(specs, left_turns(left_hand)), _turn_lanes(specs[::-1], right_turns(left_hand))
    else:
        specs = _specs(upstream)
        marked = _merging_lanes(specs, "merge_to_right"), _merging_lanes(specs[::-1], "merge_to_left")
    at_left = None
    if not any(marked):
        more, less = (downstream, upstream) if gain > 0 else (upstream, downstream)
        at_left = _of_one_type(_specs(more), _specs(less))
        if at_left is None:
            # t is left positive as drivers see it.
            sign = 1.0 if along else -1.0
            at_left = _in_line([sign * lane.t for lane in more], [sign * lane.t for lane in less])
    if at_left is None:
        at_left = _at_left(abs(gain), *marked, rule)
    return [(k, k + at_left) if gain > 0 else (k + at_left, k) for k in range(fewer)]


def _of_one_type(more: Sequence[LaneSpec], less: Sequence[LaneSpec]) -> int | None:
    """Return how many lanes open or end at the left if more of the others then keep their type than else, or None."""
    kept = [
        sum(one.type is more[k + at_left].type for k, one in enumerate(less))
        for at_left in range(len(more) - len(less) + 1)
    ]
    best = max(kept)
    return kept.index(best) if kept.count(best) == 1 else None


def _in_line(more: Sequence[float], less: Sequence[float]) -> int | None:
    """Return how many lanes open or end at the left if that clearly keeps the others in line, else None.

    ``placement`` is what moves lanes apart: it says where the OSM line runs, so which lanes continue straight. `more`
    and `less` are the places of the lanes on either side, m.
    """
    change, fewer = len(more) - len(less), len(less)
    shifts = [sum(abs(less[k] - more[k + at_left]) for k in range(fewer)) / fewer for at_left in range(change + 1)]
    best = min(range(change + 1), key=lambda at_left: shifts[at_left])
    others = [shift for at_left, shift in enumerate(shifts) if at_left != best]
    return best if min(others) - shifts[best] > _CLEARLY_IN_LINE else None


def _at_left(change: int, left: int, right: int, rule: Rule) -> int:
    """Return how many of `change` lanes open or end at the left edge, given how many are marked so at either edge.

    What is not marked opens or ends at the near side of traffic.
    """
    if rule is Rule.LEFT_HAND:
        return change - _at_left(change, right, left, Rule.RIGHT_HAND)
    if left + right <= change:
        return left
    return min(left, change) if not right else max(change - right, min(left, change) // 2)


def _turn_lanes(lanes: Sequence[LaneSpec], turns: frozenset[str]) -> int:
    """Count the first lanes that lead nowhere but to `turns`; 0 where all do, which says nothing about an edge."""
    count = next((k for k, lane in enumerate(lanes) if not lane.turns or not lane.turns <= turns), len(lanes))
    return 0 if count == len(lanes) else count


def _merging_lanes(lanes: Sequence[LaneSpec], value: str) -> int:
    """Count the first lanes whose ``turn:lanes`` say that they merge."""
    return next((k for k, lane in enumerate(lanes) if value not in lane.turns), len(lanes))
