"""Where along a road its lanes change: the zones in which they open, end, widen and shift."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from osm2xodr.curves import end_curvature, owners
from osm2xodr.geometry import defaults
from osm2xodr.geometry.lanes.cross_sections import car_directions
from osm2xodr.geometry.lanes.lane_changes import LaneChange, room_for_tapers
from osm2xodr.geometry.lanes.lane_connectivity import Connectivity
from osm2xodr.geometry.lanes.road_stretches import Stretch, change_between
from osm2xodr.model import PlanView, Rule
from osm2xodr.system import record


@record
class TaperZone:
    """Part of a road in which its lanes change from one stretch to the next, s, m."""

    start: float
    end: float
    change: LaneChange
    # The longer part in which lanes that continue shift to the side, which those that open or end do not hinder, m
    shift_start: float
    shift_end: float
    is_gentle: bool  # Whether they do so with curvature that changes evenly; else both are the same, and they do not

    @property
    def length(self) -> float:
        """Length, m."""
        return self.end - self.start

    def part(self, rank: int, count: int) -> tuple[float, float]:
        """Return from where to where one of `count` lanes opens (or ends) that do so one after another."""
        if count < 2:
            return self.start, self.end
        # Each begins when the one before it is half open, where there is room for that.
        least = self.change.steepest * self.change.width
        together = least + defaults.LANES_OPEN_APART * (count - 1)
        one = max(2 * self.length / (count + 1), least * min(1.0, self.length / together))
        begin = self.start + rank * (self.length - one) / (count - 1)
        return begin, begin + one

    @property
    def round_end(self) -> float | None:
        """Share of its length that each round end of a line takes in which lanes taper; None for smooth steps.

        They are lines where a smooth step would be too steep, with short ends where the line would be, too.
        """
        start, end = self.part(0, self.change.at_once)
        length = end - start
        if length >= defaults.SMOOTH_TAPER * max(self.change.width, 2 * self.change.least_shift):
            return None
        spare = 1.0 - self.change.width / (defaults.STEEPEST_WIDTH * length)
        return min(max(spare, defaults.SHORTEST_ROUND_END), defaults.ROUND_END)


def sharp_joints(plan: PlanView) -> dict[int, list[float]]:
    """Return where curves, by number, begin or end a tight bend at once, s, m: lanes that shift there have kinks."""
    step = np.abs(plan.curvature[1:] - end_curvature(plan)[:-1])
    owner = owners(plan.start)
    out: dict[int, list[float]] = {}
    for k in (np.flatnonzero((step > 1.0 / defaults.SHARP_JOINT_RADIUS) & (owner[1:] == owner[:-1])) + 1).tolist():
        out.setdefault(int(owner[k]), []).append(float(plan.s[k]))
    return out


def taper_zones(
    road: Sequence[Stretch],
    rule: Rule,
    known: Connectivity | None = None,
    room: float | None = None,
    joints: Sequence[float] = (),
) -> tuple[TaperZone, ...]:
    """Return the zones of all changes along a road: about the borders of its stretches, as far as there is room.

    `room` is the length that they may take together, m; all but the road's ends unless given. They keep off `joints`,
    s, m, in ascending order, where they can.
    """
    if len(road) < 2:
        return ()
    changes = [
        change_between(one, other, rule, known.at_border(one.ways[-1], other.ways[0]) if known else None)
        for one, other in pairwise(road)
    ]
    whole = room_for_tapers(road[-1].end)
    lengths = _fitting(
        [change.wanted for change in changes], [change.least for change in changes], whole if room is None else room
    )
    middles = [
        one.end + _behind_border(one, other, change, length)
        for (one, other), change, length in zip(pairwise(road), changes, lengths, strict=True)
    ]
    begin = (road[-1].end - whole) / 2
    starts = _off_one_way(road, _placed(middles, lengths, begin, whole), lengths, begin, whole)
    ends = [start + length for start, length in zip(starts, lengths, strict=True)]
    if joints:
        _keep_off(joints, road, changes, starts, ends)
    shifts = _shifts(changes, starts, ends, begin, road[-1].end - begin, joints)
    return tuple(TaperZone(*item) for item in zip(starts, ends, changes, *zip(*shifts, strict=True), strict=True))


def _off_one_way(
    road: Sequence[Stretch], starts: Sequence[float], lengths: Sequence[float], begin: float, room: float
) -> list[float]:
    """Return where zones begin, moved by as little as possible to where lanes end before one-way stretches.

    Lanes against these open behind them, too, as far as all zones have room.
    """
    out = list(starts)
    before, after = ([car_directions(item.section) for item in items] for items in (road[:-1], road[1:]))
    least = [one.end if mine < more else begin for one, mine, more in zip(road, before, after, strict=False)]
    most = [one.end if more < mine else np.inf for one, mine, more in zip(road, before, after, strict=False)]
    for k in reversed(range(len(out))):
        ahead = out[k + 1] if k + 1 < len(out) else np.inf
        out[k] = min(out[k], min(most[k], ahead) - lengths[k])
    for k in range(len(out)):
        out[k] = max(out[k], least[k], out[k - 1] + lengths[k - 1] if k else begin)
    latest = begin + room
    for k in reversed(range(len(out))):
        latest = out[k] = min(out[k], latest - lengths[k])
    return out


def _keep_off(
    joints: Sequence[float],
    road: Sequence[Stretch],
    changes: Sequence[LaneChange],
    starts: list[float],
    ends: list[float],
) -> None:
    """Move zones, from `starts` to `ends`, m, that lie about joints to where none is within them, if that is near.

    They stay as long as they are, or else become shorter, as far as they may be.
    """
    steady = (road[-1].end - room_for_tapers(road[-1].end)) / 2
    for k, change in enumerate(changes):
        length, middle = ends[k] - starts[k], (starts[k] + ends[k]) / 2
        if not any(starts[k] < s < ends[k] for s in joints):
            continue
        before, after = car_directions(road[k].section), car_directions(road[k + 1].section)
        lower = max(ends[k - 1] if k else steady, road[k].end if before < after else 0.0)
        upper = min(starts[k + 1] if k + 1 < len(changes) else road[-1].end - steady, road[-1].end)
        if after < before:
            upper = min(upper, road[k].end)
        apart = defaults.JOINT_CLEARANCE
        inside = [s for s in joints if lower < s < upper]
        gaps = list(zip([lower, *(s + apart for s in inside)], [*(s - apart for s in inside), upper], strict=True))
        for least in (length, min(change.least, length)):
            middles = [min(max(middle, lo + least / 2), hi - least / 2) for lo, hi in gaps if hi - lo >= least]
            nearest = min(middles, key=lambda place: abs(place - middle), default=np.inf)
            if abs(nearest - middle) <= length:
                lo, hi = next((lo, hi) for lo, hi in gaps if lo < nearest < hi)
                size = min(length, hi - lo)
                starts[k] = min(max(nearest - size / 2, lo), hi - size)
                ends[k] = starts[k] + size
                break


def _shifts(
    changes: Sequence[LaneChange],
    starts: Sequence[float],
    ends: Sequence[float],
    begin: float,
    end: float,
    joints: Sequence[float] = (),
) -> list[tuple[float, float, bool]]:
    """Return from where to where lanes that continue shift, about the zones in which others open or end, if gently.

    As far to one side as to the other; between two zones each has half of the room, on a road from `begin` to `end`;
    none reaches beyond a joint.
    """
    borders = [begin, *((a + b) / 2 for a, b in zip(ends[:-1], starts[1:], strict=True)), end]
    out = []
    for k, change in enumerate(changes):
        first, last = starts[k], ends[k]
        lower = max((s for s in joints if s <= first), default=begin)
        upper = min((s for s in joints if s >= last), default=end)
        room = min(first - max(borders[k], lower), min(borders[k + 1], upper) - last)
        more = max(min(room, (change.gentle - last + first) / 2), 0.0)
        roomy = last - first + 2 * more >= defaults.GENTLEST_SHIFT * change.shift
        gentle = change.gentle > 0.0 and roomy and (more > 0.0 or not change.at_once)
        out.append((first - more, last + more, True) if gentle else (first, last, False))
    return out


def _behind_border(one: Stretch, other: Stretch, change: LaneChange, length: float) -> float:
    """Return how far behind the border of two stretches the middle of a zone should lie that has some length, m.

    Lanes against a one-way stretch stay out of it. Where limits are low the zone lies on the side with more lanes, as
    far as these keep their width on a part of it.
    """
    before, after = car_directions(one.section), car_directions(other.section)
    if before != after:
        return length / 2 if before < after else -length / 2 if after < before else 0.0
    if not change.more or not change.is_slow:
        return 0.0
    wide = other.length if change.more > 0 else one.length
    off = min(length / 2, max((1 - defaults.FULL_WIDTH_SHARE) * wide - length / 2, 0.0))
    return off if change.more > 0 else -off


def _fitting(wanted: Sequence[float], least: Sequence[float], room: float) -> list[float]:
    """Return lengths that together fit into a room: as wanted, or nearer to the least ones, or shorter still."""
    if sum(wanted) <= room:
        return list(wanted)
    if sum(least) >= room:
        return [item * room / sum(least) for item in least]
    share = (room - sum(least)) / (sum(wanted) - sum(least))
    return [low + share * (high - low) for low, high in zip(least, wanted, strict=True)]


def _placed(middles: Sequence[float], lengths: Sequence[float], begin: float, room: float) -> list[float]:
    """Return where spans begin that do not overlap, each as near to its middle as all of them together can be."""
    # Without the lengths before it, no span may begin before the one before it: pools of equal places do not.
    before = [sum(lengths[:k]) for k in range(len(lengths))]
    pools: list[list[float]] = []
    for middle, length, offset in zip(middles, lengths, before, strict=True):
        pools.append([middle - length / 2 - offset])
        while len(pools) > 1 and sum(pools[-2]) / len(pools[-2]) > sum(pools[-1]) / len(pools[-1]):
            last = pools.pop()
            pools[-1] += last
    places = [sum(pool) / len(pool) for pool in pools for _ in pool]
    latest = begin + max(room - sum(lengths), 0.0)
    return [min(max(place, begin), latest) + offset for place, offset in zip(places, before, strict=True)]
