"""Lanes of a carriageway as they run along a whole road: where each begins and ends, and how wide it is."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

from osm2xodr.curves import part_of_cubics, smooth_cubic
from osm2xodr.geometry.lanes.cross_sections import CrossSection
from osm2xodr.geometry.lanes.road_stretches import Stretch
from osm2xodr.geometry.lanes.tapers import TaperZone
from osm2xodr.model import Cubic, Direction, LaneSpec
from osm2xodr.system import record

# Values that differ by less are the same: widths, offsets and places along the road, m.
SAME_VALUE: Final = 1e-9
# Cubics are the same if their coefficients differ by less, in metres of s: by nanometres over a hundred metres.
_SAME_CUBIC: Final = (SAME_VALUE, 1e-11, 1e-13, 1e-15)


@dataclass(slots=True)
class RoadLane:
    """A lane along a road, with all that continue it."""

    begin: float  # s on the road, m
    end: float
    numbers: dict[int, int]  # Its id in each stretch of the road that has it
    specs: dict[int, LaneSpec]  # What it is there
    widths: list[Cubic] = field(default_factory=list)  # Over the road's s

    def spec(self, stretch: int) -> LaneSpec:
        """Return what it is in a stretch, or in the one next to it that has it."""
        return self.specs[min(self.specs, key=lambda k: abs(k - stretch))]

    def changes(self, start: float, end: float, width: float, round_end: float | None) -> None:
        """Let it change its width from one place to another, in a line with round ends or in a smooth step."""
        before = self.widths[-1].a
        if abs(width - before) > SAME_VALUE:
            self.follows(_step(start, end - start, before, width, round_end), end, width)

    def follows(self, step: Sequence[Cubic], end: float, width: float) -> None:
        """Let its width follow some cubics up to a place, from where on it is the same, m."""
        self.widths = list(without_repeats([*self.widths, *step, Cubic(end, width)]))


@record
class Carriageway:
    """All lanes along a road."""

    # Left and right of the centre, from the centre outwards
    left: tuple[RoadLane, ...]
    right: tuple[RoadLane, ...]
    offset: tuple[Cubic, ...]  # t of the centre over the road's s

    def between(self, start: float, end: float) -> tuple[tuple[RoadLane, ...], tuple[RoadLane, ...]]:
        """Return the lanes left and right of the centre that are there from one place to another."""
        left, right = (
            tuple(lane for lane in lanes if lane.begin <= start + SAME_VALUE and lane.end >= end - SAME_VALUE)
            for lanes in (self.left, self.right)
        )
        return left, right


def lay_out_carriageway(road: Sequence[Stretch], zones: Sequence[TaperZone]) -> Carriageway:
    """Lead the lanes of a road through its stretches; in the zones between these they open, end, widen and shift."""
    length = road[-1].end
    sides: dict[int, list[RoadLane]] = {1: [], -1: []}
    here: dict[int, RoadLane] = {}
    for number, spec in _specs(road[0].section).items():
        here[number] = RoadLane(0.0, length, {0: number}, {0: spec}, [Cubic(0.0, spec.width)])
    for number in sorted(here, key=abs):
        sides[1 if number > 0 else -1].append(here[number])
    offset = [Cubic(0.0, road[0].section.centre)]
    for k, zone in enumerate(zones, start=1):
        here = _led_through(zone, k, road, here, sides)
        offset += _centre(zone, k, road, sides)
    return Carriageway(tuple(sides[1]), tuple(sides[-1]), without_repeats(offset))


def _specs(section: CrossSection) -> dict[int, LaneSpec]:
    """Return lanes by id."""
    left = dict(enumerate(section.left, start=1))
    return left | {-number: lane for number, lane in enumerate(section.right, start=1)}


def _led_through(
    zone: TaperZone, k: int, road: Sequence[Stretch], before: Mapping[int, RoadLane], sides: dict[int, list[RoadLane]]
) -> dict[int, RoadLane]:
    """Return the lanes of the k-th stretch by id; those that open are added to the sides of the centre."""
    pairs, after = zone.change.pairs, _specs(road[k].section)
    out: dict[int, RoadLane] = {}
    for one, other in pairs.items():
        lane = out[other] = before[one]
        lane.numbers[k], lane.specs[k] = other, after[other]
        width = lane.widths[-1].a, after[other].width
        if abs(width[1] - width[0]) > SAME_VALUE:
            lane.follows(_shifted(zone, *width), zone.shift_end, width[1])
    ending = _in_order([one for one in before if one not in pairs], _specs(road[k - 1].section), pairs)
    for number, (rank, count) in ending.items():
        # The outermost ends first.
        start, end = zone.part(count - 1 - rank, count)
        before[number].changes(start, end, 0.0, zone.round_end)
        before[number].end = end
    opening = _in_order([other for other in after if other not in out], after, pairs.values())
    for number, (rank, count) in opening.items():
        start, end = zone.part(rank, count)
        nothing = [Cubic(zone.shift_start, 0.0)]
        lane = out[number] = RoadLane(start, road[-1].end, {k: number}, {k: after[number]}, nothing)
        lane.changes(start, end, after[number].width, zone.round_end)
    for number in sorted(opening, key=abs):
        side = 1 if number > 0 else -1
        inner = out.get(number - side)
        sides[side].insert(0 if inner is None else _index(sides[side], inner) + 1, out[number])
    return out


def _index(lanes: Sequence[RoadLane], lane: RoadLane) -> int:
    return next(k for k, item in enumerate(lanes) if item is lane)


def _in_order(
    changing: Sequence[int], specs: Mapping[int, LaneSpec], staying: Collection[int]
) -> dict[int, tuple[int, int]]:
    """Return which of how many lanes of its direction each is, those nearest to lanes that continue first."""
    out: dict[int, tuple[int, int]] = {}
    for direction in Direction:
        beside = [lane for lane in staying if specs[lane].direction is direction] or [0]
        own = [lane for lane in changing if specs[lane].direction is direction]
        own.sort(key=lambda lane: (min(abs(lane - other) for other in beside), abs(lane)))
        out.update({lane: (rank, len(own)) for rank, lane in enumerate(own)})
    return out


# ---------------------------------------------------------------- the lane offset


def _centre(zone: TaperZone, k: int, road: Sequence[Stretch], sides: Mapping[int, Sequence[RoadLane]]) -> list[Cubic]:
    """Return how the centre moves in the zone before the k-th stretch.

    Where lanes open or end one after another, or faster than others shift, an edge moves evenly from one
    cross-section to the next: of the edges of lanes that continue, that which moves least.
    """
    before, after = road[k - 1].section, road[k].section
    if not zone.is_gentle and (zone.change.at_once < 2 or not zone.change.pairs):
        return _moved(zone, before.centre, after.centre)

    def edges(pair: tuple[int, int]) -> tuple[float, float]:
        return _inner_edge(before, pair[0]), _inner_edge(after, pair[1])

    pair = min(zone.change.pairs.items(), key=lambda pair: (abs(edges(pair)[0] - edges(pair)[1]), abs(pair[0])))
    side = 1 if pair[0] > 0 else -1
    start, end = zone.shift_start, zone.shift_end
    passing = [lane for lane in sides[side] if lane.begin < end and lane.end > start]
    inner = passing[: next(rank for rank, lane in enumerate(passing) if lane.numbers.get(k) == pair[1])]
    moved = [Cubic(start, edges(pair)[0]), *_moved(zone, *edges(pair))]
    records = [moved, *(lane.widths for lane in inner)]
    places = sorted({start, end, *(c.s for item in records for c in item if start < c.s < end)})
    out = [_sum(records, side, *part) for part in pairwise(places)]
    return [*out, Cubic(end, after.centre)]


def _moved(zone: TaperZone, start: float, end: float) -> list[Cubic]:
    """Return how a value changes evenly in a zone."""
    if abs(end - start) <= SAME_VALUE:
        return []
    return [*_shifted(zone, start, end), Cubic(zone.shift_end, end)]


def _shifted(zone: TaperZone, start: float, end: float) -> list[Cubic]:
    """Return the cubics of a value that lanes which continue change in a zone."""
    if zone.is_gentle:
        return gentle_step(zone.shift_start, zone.shift_end - zone.shift_start, start, end)
    return _step(zone.start, zone.length, start, end, zone.round_end)


def _inner_edge(section: CrossSection, lane: int) -> float:
    """Return t of the edge of a lane towards the centre, m."""
    widths = [item.width for item in (section.left if lane > 0 else section.right)[: abs(lane) - 1]]
    return section.centre + (sum(widths) if lane > 0 else -sum(widths))


def _sum(records: Sequence[Sequence[Cubic]], side: int, begin: float, end: float) -> Cubic:
    """Return the first of some piecewise cubics less all others towards a side, where none has a border between."""
    first, *others = (part_of_cubics(item, begin, end)[0] for item in records)
    a, b, c, d = (
        getattr(first, name) - side * sum(getattr(item, name) for item in others) for name in ("a", "b", "c", "d")
    )
    return Cubic(begin, a, b, c, d)


# ---------------------------------------------------------------- cubics


def gentle_step(s: float, length: float, start: float, end: float) -> list[Cubic]:
    """Return the cubics from one value to another, of continuous second derivative, whose third is smallest.

    It is 32 times the change by the cube of the length, to and fro over a quarter, a half and a quarter of it.
    """
    rise = end - start
    slope = rise / length
    bend = 4 * slope / length
    third = 4 / 3 * bend / length
    return [
        Cubic(s, start, 0.0, 0.0, third),
        Cubic(s + length / 4, start + rise / 12, slope, bend, -third),
        Cubic(s + 3 * length / 4, end - rise / 12, slope, -bend, third),
    ]


def _step(s: float, length: float, start: float, end: float, round_end: float | None) -> list[Cubic]:
    """Return the cubics from one value to another over a length: a smooth step, or a line with such round ends."""
    if round_end is None:
        return [smooth_cubic(s, length, start, end)]
    rounded = round_end * length
    slope = (end - start) / (length - rounded)
    bend, rise = slope / (2 * rounded), slope * rounded / 2
    return [
        Cubic(s, start, 0.0, bend),
        Cubic(s + rounded, start + rise, slope),
        Cubic(s + length - rounded, end - rise, slope, -bend),
    ]


def without_repeats(cubics: Sequence[Cubic]) -> tuple[Cubic, ...]:
    """Leave out records that say what the one before says: its cubic goes on."""
    out: list[Cubic] = []
    for item in cubics:
        # Of two records at one place the later one holds.
        if out and item.s - out[-1].s < SAME_VALUE:
            out.pop()
        if not (out and _goes_on(out[-1], item)):
            out.append(item)
    return tuple(out)


def _goes_on(before: Cubic, item: Cubic) -> bool:
    """Say whether a record is the cubic of the one before: of two tapers in a row one may end as the next begins."""
    if before.is_flat or item.is_flat:
        return before.is_flat and item.is_flat and abs(before.a - item.a) < SAME_VALUE
    same = before.begun_later(item.s - before.s, item.s)
    differences = abs(same.a - item.a), abs(same.b - item.b), abs(same.c - item.c), abs(same.d - item.d)
    return all(value < least for value, least in zip(differences, _SAME_CUBIC, strict=True))
