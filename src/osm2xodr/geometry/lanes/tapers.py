"""Where along a road its lanes change: the zones in which they open, end, widen and shift."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

from osm2xodr.geometry import defaults
from osm2xodr.geometry.lanes.cross_sections import car_directions
from osm2xodr.geometry.lanes.lane_changes import LaneChange, room_for_tapers
from osm2xodr.geometry.lanes.lane_connectivity import Connectivity
from osm2xodr.geometry.lanes.road_stretches import Stretch, change_between
from osm2xodr.model import Rule
from osm2xodr.system import record

# Zones before and behind one-way streets stay where they are rather than others, by this factor: no lane reaches into
# such a street against its traffic. A power of two, which rounds nothing.
_FIRM: Final = 2.0**20


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


def taper_zones(
    road: Sequence[Stretch],
    rule: Rule,
    known: Connectivity | None = None,
    room: float | None = None,
) -> tuple[TaperZone, ...]:
    """Return the zones of all changes along a road: about the borders of its stretches, as far as there is room.

    `room` is the length that they may take together, m; all but the road's ends unless given.
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
    directions = [car_directions(item.section) for item in road]
    firm = [before != after for before, after in pairwise(directions)]
    starts = _placed(middles, lengths, firm, begin, whole)
    ends = [start + length for start, length in zip(starts, lengths, strict=True)]
    shifts = _shifts(changes, starts, ends, begin, road[-1].end - begin)
    return tuple(TaperZone(*item) for item in zip(starts, ends, changes, *zip(*shifts, strict=True), strict=True))


def _shifts(
    changes: Sequence[LaneChange],
    starts: Sequence[float],
    ends: Sequence[float],
    begin: float,
    end: float,
) -> list[tuple[float, float, bool]]:
    """Return from where to where lanes that continue shift, about the zones in which others open or end, if gently.

    As far to one side as to the other; between two zones each has half of the room, on a road from `begin` to `end`.
    """
    borders = [begin, *((a + b) / 2 for a, b in zip(ends[:-1], starts[1:], strict=True)), end]
    out = []
    for k, change in enumerate(changes):
        first, last = starts[k], ends[k]
        room = min(first - borders[k], borders[k + 1] - last)
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


def _placed(
    middles: Sequence[float], lengths: Sequence[float], firm: Sequence[bool], begin: float, room: float
) -> list[float]:
    """Return where spans begin that do not overlap, each as near to its middle as all of them together can be.

    Others give way to those that are firm.
    """
    # Without the lengths before it, no span may begin before the one before it: pools of equal places do not.
    before = [sum(lengths[:k]) for k in range(len(lengths))]
    pools: list[list[tuple[float, float]]] = []

    def mean(pool: Sequence[tuple[float, float]]) -> float:
        return sum(place * weight for place, weight in pool) / sum(weight for _, weight in pool)

    for middle, length, offset, is_firm in zip(middles, lengths, before, firm, strict=True):
        pools.append([(middle - length / 2 - offset, _FIRM if is_firm else 1.0)])
        while len(pools) > 1 and mean(pools[-2]) > mean(pools[-1]):
            last = pools.pop()
            pools[-1] += last
    places = [mean(pool) for pool in pools for _ in pool]
    latest = begin + max(room - sum(lengths), 0.0)
    return [min(max(place, begin), latest) + offset for place, offset in zip(places, before, strict=True)]
