"""The stretches of a road: where along it the lanes stay the same, none too short for the tapers that it needs."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

from osm2xodr.geometry import defaults
from osm2xodr.geometry.lanes.cross_sections import CrossSection, Piece, car_directions
from osm2xodr.geometry.lanes.defaults import SHORTEST_LIMIT
from osm2xodr.geometry.lanes.lane_changes import LaneChange, lane_change, room_for_tapers
from osm2xodr.geometry.lanes.lane_connectivity import COUNTED_LANES, StatedLanes
from osm2xodr.geometry.lanes.road_marks import change_kind, same_marks
from osm2xodr.model import Direction, LaneSpec, Rule, StreetAttributes
from osm2xodr.system import record


@record
class Stretch:
    """Part of a road on which the cross-section stays the same."""

    # s on the road, m
    start: float
    end: float
    # What holds there
    attributes: StreetAttributes
    section: CrossSection
    ways: tuple[int, ...]  # The OSM ways that it consists of, in their order

    @property
    def length(self) -> float:
        """Length, m."""
        return self.end - self.start


# What changes a stretch, if anything does.
_Change = Callable[[Stretch], Stretch] | None


def stretches(
    pieces: Sequence[Piece], begin: float, end: float, rule: Rule, room: float | None = None
) -> list[Stretch]:
    """Cut the pieces of a street, in ascending s, to the part from begin to end, s, m, which becomes a road.

    Pieces whose lanes and limits are the same become one stretch; a stretch that is too short for the tapers of its
    lanes joins the longer of its neighbours, and so do those whose changes of lanes have no
    room: all of the road but its ends, unless `room` is given, m. One-way stretches take over short ones of both
    directions, where lanes against them would have no room to open or end.
    """
    found: list[Stretch] = []
    for k, (s, attributes, section) in enumerate(pieces):
        lower = max(s, begin) if k else begin
        upper = min(pieces[k + 1][0], end) if k + 1 < len(pieces) else end
        if upper <= lower:
            continue
        last = found[-1] if found else None
        if last is not None and _same_lanes(last.section, section) and same_rules(last.attributes, attributes):
            # The lanes are the same; of the attributes, the later ones hold the turns, which count at the end.
            ways = (*last.ways, attributes.osm_way_id)
            found[-1] = Stretch(last.start, upper - begin, attributes, section, ways)
        else:
            found.append(Stretch(lower - begin, upper - begin, attributes, section, (attributes.osm_way_id,)))
    if not found:
        _, attributes, section = max((p for p in pieces if p[0] <= begin), default=pieces[0], key=lambda p: p[0])
        return [Stretch(0.0, end - begin, attributes, section, (attributes.osm_way_id,))]
    if len(found) == 1:
        return found
    return _with_room(
        _without_stubs(_without_short(_grown_at_ends(found)), rule),
        rule,
        room_for_tapers(end - begin) if room is None else room,
    )


def with_narrow_ends(
    found: Sequence[Stretch], start: Mapping[int, float] | None, end: Mapping[int, float] | None, rule: Rule
) -> tuple[Stretch, ...]:
    """Return the stretches of a road whose lanes, by id, have other widths at its start and its end, m.

    They change along the road; what lies between gives way where there is no room for that.
    """
    first, last = (None if end is None else partial(_with_widths, widths=end) for end in (start, end))
    return _with_other_ends(found, first, last, rule)


def with_shifted_ends(
    found: Sequence[Stretch], start: float | None, end: float | None, rule: Rule
) -> tuple[Stretch, ...]:
    """Return the stretches of a road whose lanes lie so far left of where they were at its start and its end, m."""
    first, last = (None if end is None else partial(shifted_stretch, aside=end) for end in (start, end))
    return _with_other_ends(found, first, last, rule)


def _with_other_ends(found: Sequence[Stretch], start: _Change, end: _Change, rule: Rule) -> tuple[Stretch, ...]:
    """Return the stretches of a road with short ones at its ends, which are what stood there, changed."""
    length = found[-1].end
    steady = min(defaults.STEADY_END, length / 4)
    first = [] if start is None else [start(replace(found[0], start=0.0, end=steady))]
    last = [] if end is None else [end(replace(found[-1], start=length - steady, end=length))]
    lower, upper = steady if first else 0.0, length - steady if last else length
    between = [item for item in found if item.end > lower and item.start < upper]
    inner = [replace(item, start=max(item.start, lower), end=min(item.end, upper)) for item in between]
    return tuple(_with_room([*first, *inner, *last], rule, room_for_tapers(length), (bool(first), bool(last))))


def shifted_stretch(item: Stretch, aside: float) -> Stretch:
    """Return a stretch whose lanes lie farther left, m."""
    old = item.section
    places = (old.centre + aside, old.left_edge + aside, old.right_edge + aside)
    return replace(item, section=CrossSection(old.left, old.right, *places))


def _with_widths(item: Stretch, widths: Mapping[int, float]) -> Stretch:
    """Return a stretch whose lanes have other widths; the carriageway's middle stays."""
    old = item.section
    left = [replace(lane, width=widths.get(k, lane.width)) for k, lane in enumerate(old.left, start=1)]
    right = [replace(lane, width=widths.get(-k, lane.width)) for k, lane in enumerate(old.right, start=1)]
    at_left, at_right = (sum(lane.width for lane in lanes) for lanes in (left, right))
    edge = (old.left_edge + old.right_edge + at_left + at_right) / 2
    section = CrossSection(tuple(left), tuple(right), edge - at_left, edge, edge - at_left - at_right)
    return replace(item, section=section, attributes=replace(item.attributes, lanes_ltr=(*reversed(left), *right)))


def _with_room(
    found: list[Stretch], rule: Rule, room: float, fixed: tuple[bool, bool] = (False, False)
) -> list[Stretch]:
    """Let neighbours take over stretches until there is room on the road for the changes of lanes that are left.

    The shortest go first, those with turn lanes at the road's ends last. What nobody can take over stays, and so do
    those at the road's start and end if they are `fixed`.
    """
    while (needed := _needed(found, rule)) > room:
        costs: list[tuple[float, float, int, list[Stretch]]] = []
        for k in range(int(fixed[0]), len(found) - int(fixed[1])):
            without = _without(found, k)
            if without is not None and (left := _needed(without, rule)) < needed:
                costs.append((found[k].length + (room if _turns_at_end(found, k) else 0.0), left, k, without))
        if not costs:
            break
        found = min(costs, key=lambda item: item[:3])[3]
    return found


def _needed(found: Sequence[Stretch], rule: Rule) -> float:
    """Return the least length in which all changes of lanes along a road fit, m."""
    return sum(change_between(one, other, rule).least for one, other in pairwise(found))


def change_between(
    one: Stretch, other: Stretch, rule: Rule, stated: Mapping[Direction, StatedLanes] | None = None
) -> LaneChange:
    """Return what changes from one stretch to the next, at the speed of the faster of them."""
    speeds = [item.attributes.speed_along(direction) for item in (one, other) for direction in directions(item)]
    fastest = max((speed for speed in speeds if speed is not None), default=None)
    return lane_change(one.section, other.section, rule, fastest, stated)


def _turns_at_end(found: Sequence[Stretch], k: int) -> bool:
    """Say whether a stretch has turn lanes that lead out of the road."""
    directions = {Direction.BACKWARD} if k == 0 else {Direction.FORWARD} if k == len(found) - 1 else set()
    lanes = (*found[k].section.left, *found[k].section.right)
    return any(lane.turns for lane in lanes if lane.direction in directions)


def _without(found: list[Stretch], k: int) -> list[Stretch] | None:
    """Return the stretches with the k-th taken over by its neighbours; None if traffic runs differently there."""
    takers = [
        i
        for i in (k - 1, k + 1)
        if 0 <= i < len(found) and (_is_tiny(found[k]) or directions(found[i]) == directions(found[k]))
    ]
    if not takers:
        return None
    out = list(found)
    before, after = (out[i] if i in takers else None for i in (k - 1, k + 1))
    if before is not None and after is not None:
        middle = (found[k].start + found[k].end) / 2
        out[k - 1], out[k + 1] = _grown(before, end=middle, ways=found[k].ways), replace(after, start=middle)
        if _same_lanes(before.section, after.section) and same_rules(before.attributes, after.attributes):
            out[k - 1 : k + 2] = [_grown(before, end=after.end, ways=(*found[k].ways, *after.ways))]
            return out
    elif before is not None:
        out[k - 1] = _grown(before, end=found[k].end, ways=found[k].ways)
    elif after is not None:
        out[k + 1] = replace(after, start=found[k].start, ways=(*found[k].ways, *after.ways))
    del out[k]
    return out


def _grown(item: Stretch, end: float, ways: tuple[int, ...]) -> Stretch:
    """Return a stretch that reaches farther along the road, over more ways."""
    return replace(item, end=end, ways=(*item.ways, *ways))


def _without_short(found: list[Stretch]) -> list[Stretch]:
    """Let a neighbour take over each stretch that is too short for tapers, unless traffic runs differently there.

    Where the lanes stay and only the limit changes, there are no tapers: what counts is how long the lanes stay.
    """
    kept: set[float] = set()
    while len(found) > 1:
        open_ = [k for k in range(len(found)) if found[k].start not in kept]
        k = min(open_, key=lambda k: found[k].length, default=-1)
        if k < 0 or found[k].length >= defaults.SHORTEST_LANE_SECTION:
            break
        neighbours = [
            i
            for i in (k - 1, k + 1)
            if 0 <= i < len(found) and (_is_tiny(found[k]) or directions(found[i]) == directions(found[k]))
        ]
        if not neighbours or _has_own_limit(found, k):
            kept.add(found[k].start)
            continue
        taker = max(neighbours, key=lambda i: found[i].length)
        first, last = found[min(k, taker)], found[max(k, taker)]
        merged = replace(found[taker], start=first.start, end=last.end, ways=(*first.ways, *last.ways))
        found[min(k, taker) : max(k, taker) + 1] = [merged]
    return found


def _without_stubs(found: list[Stretch], rule: Rule) -> list[Stretch]:
    """Let one-way stretches take over what lies beside them, or between two of them, and is too short for tapers.

    Lanes against a one-way stretch open and end outside of it. Nobody comes from there on them, or may go on there.
    What has more lanes along the one-way street than this stays.
    """
    stub = _stub(found, rule)
    while stub is not None:
        found = _taken_over(found, *stub)
        stub = _stub(found, rule)
    return found


def _stub(found: Sequence[Stretch], rule: Rule) -> tuple[int, int, list[int]] | None:
    """Return the first and the last of the stretches that one-way ones take over, and these, or None."""
    ways = [car_directions(item.section) for item in found]
    starts = [k for k in range(len(found)) if not k or ways[k] != ways[k - 1]]
    for first, last in zip(starts, [*(k - 1 for k in starts[1:]), len(found) - 1], strict=True):
        beside = [i for i in (first - 1, last + 1) if 0 <= i < len(found)]
        takers = [i for i in beside if ways[i] and ways[i] < ways[first] and ways[i] == ways[beside[0]]]
        kept = (_has_more_lanes(item, found[i], ways[i]) for item in found[first : last + 1] for i in beside)
        if beside and takers == beside and not any(kept):
            ends = (first == 0) + (last == len(found) - 1)
            room = found[last].end - found[first].start - ends * defaults.STEADY_END
            changes = [change_between(found[min(i, last)], found[max(i, first)], rule) for i in beside]
            if room < sum(change.to_open for change in changes):
                return first, last, beside
    return None


def _has_more_lanes(one: Stretch, other: Stretch, ways: set[Direction]) -> bool:
    """Say whether a stretch has more lanes for cars in some directions than another one: turn lanes, say."""
    count = [
        sum(
            lane.type in COUNTED_LANES and lane.direction in ways
            for lane in (*item.section.left, *item.section.right)
        )
        for item in (one, other)
    ]
    return count[0] > count[1]


def _taken_over(found: Sequence[Stretch], first: int, last: int, takers: Sequence[int]) -> list[Stretch]:
    """Return the stretches without some of them, which the takers beside them share."""
    start, end = found[first].start, found[last].end
    ways = tuple(way for item in found[first : last + 1] for way in item.ways)
    middle = (start + end) / 2 if len(takers) == 2 else start if takers[0] > last else end
    out = [*found[:first], *found[last + 1 :]]
    if takers[0] < first:
        out[first - 1] = _grown(out[first - 1], end=middle, ways=ways)
    if takers[-1] > last:
        after = out[first]
        out[first] = replace(after, start=middle, ways=(*ways, *after.ways) if len(takers) == 1 else after.ways)
    if len(takers) == 2 and _same_lanes(out[first - 1].section, out[first].section):
        before, after = out[first - 1 : first + 1]
        if same_rules(before.attributes, after.attributes):
            out[first - 1 : first + 1] = [_grown(before, end=after.end, ways=after.ways)]
    return out


def _has_own_limit(found: Sequence[Stretch], k: int) -> bool:
    """Say whether the k-th stretch is long enough for a limit, and its lanes stay long enough for tapers."""
    first = last = k
    while first and _same_lanes(found[first - 1].section, found[k].section):
        first -= 1
    while last + 1 < len(found) and _same_lanes(found[last + 1].section, found[k].section):
        last += 1
    if found[last].end - found[first].start < defaults.SHORTEST_LANE_SECTION or found[k].length < SHORTEST_LIMIT:
        return False
    beside = found[max(first, k - 1) : min(last, k + 1) + 1]
    return any(_limits(item.attributes) != _limits(found[k].attributes) for item in beside)


def _grown_at_ends(found: list[Stretch]) -> list[Stretch]:
    """Lengthen short stretches at a road's ends, where turn lanes are, by what their neighbours can spare.

    The result does not depend on the direction in which the road is drawn.
    """
    if len(found) < 2:
        return found
    out, lacking = list(found), [defaults.SHORTEST_LANE_SECTION - item.length for item in found]
    for k, beside in sorted(((0, 1), (-1, -2)), key=lambda pair: lacking[pair[0]]):
        missing, room = lacking[k], out[beside].length
        # Of two stretches neither grows at the cost of the other, which is at an end as well.
        spare = room / 2 if len(out) > 2 else room - defaults.SHORTEST_LANE_SECTION
        # A junction may have left next to nothing of a stretch: only turn lanes depend on that. Nor do lanes of a
        # one-way road go on behind a junction only to end within a few metres. Limits begin where they do.
        turns = any(lane.turns for lane in (*out[k].section.left, *out[k].section.right))
        leaves = (Direction.FORWARD if k else Direction.BACKWARD) in directions(out[k])
        ends = out[k], out[beside]
        limit_alone = _same_lanes(*(item.section for item in ends)) and len({_limits(i.attributes) for i in ends}) > 1
        if 0 < missing < spare and leaves and (turns or not (_is_tiny(out[k]) or limit_alone)):
            border = out[k].start - missing if k else out[k].end + missing
            one, other = min(k, beside), max(k, beside)
            out[one], out[other] = replace(out[one], end=border), replace(out[other], start=border)
    return out


def _is_tiny(item: Stretch) -> bool:
    return item.length < defaults.SHORTEST_ROAD


def directions(item: Stretch) -> set[Direction]:
    """Return the directions of traffic; lanes for both between those of either say nothing more."""
    return {lane.direction for lane in (*item.section.left, *item.section.right)} - {Direction.BOTH}


def _use(item: LaneSpec) -> tuple[Hashable, ...]:
    return item.type, item.access, item.direction, item.speed


def _same_lanes(one: CrossSection, other: CrossSection) -> bool:
    def shape(lanes: tuple[LaneSpec, ...]) -> list[tuple[Hashable, ...]]:
        several = len(lanes) > 1
        return [(*_use(item), item.width, several and change_kind(item)) for item in lanes]

    return (
        one.centre == other.centre and shape(one.left) == shape(other.left) and shape(one.right) == shape(other.right)
    )


def same_rules(one: StreetAttributes, other: StreetAttributes) -> bool:
    """Say whether limits and marks are the same in two stretches with the same lanes."""
    return _limits(one) == _limits(other) and same_marks(one, other)


def _limits(item: StreetAttributes) -> tuple[float | None, ...]:
    return item.speed_forward, item.speed_backward, item.default_speed
