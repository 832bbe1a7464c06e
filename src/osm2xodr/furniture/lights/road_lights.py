"""Lights on roads apart from junctions: before crossings, on ramps, before tunnels."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Final

from osm2xodr.furniture import defaults
from osm2xodr.furniture.world import Crossing, World, before_crossings, car_lanes, crossings_on_course

# Half of the extent of a crossing of which only the node is known, m; a choice.
_HALF_CROSSING: Final = 2.0
# Least distance of lights from the road's ends, m; a choice.
_FROM_END: Final = 0.5
# Half of the distance between the stop lines of both directions at a node that names no direction, and least distance
# of lights from a cut of lane sections, m: readers that cut roads there can then tell them apart; a choice.
_HALF_GAP: Final = 1.0


@dataclass(frozen=True, slots=True)
class Candidate:
    """A node with lights on a road."""

    road: int  # Id of the road
    s: float  # m; may lie beyond the road's ends
    along: bool | None  # Whether for traffic along s (else against it); None for both
    osm_id: str  # The node
    crossing: bool  # Whether people cross there


@dataclass(frozen=True, slots=True)
class RoadLight:
    """Lights on a road that are switched together."""

    road: int  # Id of the road
    # (whether for traffic along s, s of the stop line's edge in front of what traffic stops for)
    stops: tuple[tuple[bool, float], ...]
    osm_ids: tuple[str, ...]  # What they come from, in ascending s
    crossings: tuple[Crossing, ...]  # Those that people have lights at

    def section_break(self) -> float:
        """Return where a lane section has to begin so that every light stands before the end of its section, s, m.

        Lights for people count as those of the first stop's direction.
        """
        at = [item for item in self.crossings if item.junction < 0]
        along, against = ([s for forward, s in self.stops if forward == way] for way in (True, False))
        if not along:
            return min((against[0] - _HALF_GAP, *(item.s - 0.5 * item.width for item in at)))
        behind = 0.5 * (max(along) + min(against)) if against else along[0] + _HALF_GAP
        return max((behind, *along, *(item.s for item in at)))


def place_on_roads(
    world: World, candidates: Sequence[Candidate], crossings: Sequence[Crossing], every: Sequence[Crossing]
) -> tuple[RoadLight, ...]:
    """Join nodes with lights that are near each other on a road, and crossings with lights, to installations.

    `crossings` are those with lights apart from junctions, `every` all of the map.
    """
    on_road: dict[int, list[Candidate]] = defaultdict(list)
    for item in candidates:
        on_road[item.road].append(item)
    at_road = crossings_on_course(crossings)
    all_at_road = crossings_on_course(every)
    out: list[RoadLight] = []
    for road, items in sorted(on_road.items()):
        named = {item.osm_id for item in items}
        for group in _groups(sorted(items, key=lambda item: (item.s, item.osm_id))):
            first, last = group[0].s - defaults.ONE_INSTALLATION, group[-1].s + defaults.ONE_INSTALLATION
            own = {item.osm_id for item in group}
            near = (
                item for item in at_road.get(road, ()) if item.osm_id in own or first <= item.on_course[1] <= last
            )
            there = tuple(item for item in near if item.osm_id in own or item.osm_id not in named)
            stops = _stops(world, road, group, there, all_at_road.get(road, ()))
            if stops:
                out.append(RoadLight(road, stops, tuple(dict.fromkeys(item.osm_id for item in group)), there))
    return tuple(out)


def _groups(candidates: Sequence[Candidate]) -> list[list[Candidate]]:
    """Split candidates, in ascending s, at wide gaps."""
    out: list[list[Candidate]] = []
    for item in candidates:
        if not out or item.s - out[-1][-1].s > defaults.ONE_INSTALLATION:
            out.append([])
        out[-1].append(item)
    return out


def _stops(
    world: World, road: int, group: Sequence[Candidate], crossings: Sequence[Crossing], every: Sequence[Crossing]
) -> tuple[tuple[bool, float], ...]:
    """Return where traffic stops, for each direction that the lights are for.

    They also stop before other crossings, of `every` on the road, where no car fits between those and the line.
    Traffic that comes out of a junction is not stopped inside it: a direction whose stop line would lie before the
    road's start or beyond its end has none. Where that leaves no direction, lights stand at the road's end.
    """
    length = world.lanes.length(road)
    margin = min(_FROM_END, 0.5 * length)
    known = {item.osm_id for item in crossings}
    wanted = []
    for along, sign in ((True, 1.0), (False, -1.0)):
        at = [sign * item.s - _before(item, known) for item in group if item.along in (None, along)]
        if not at:
            continue
        before = defaults.STOP_LINE_BEFORE_CROSSING
        at += [sign * item.on_course[1] - 0.5 * item.width - before for item in crossings]
        s = _clear_of_crossings(sign * min(at), length, every, along=along)
        inside = min(max(s, margin), length - margin)
        if car_lanes(world, road, inside, along):
            wanted.append((along, inside, sign * (inside - s) > 0.0))
    kept = [item for item in wanted if not item[2]] or wanted
    return tuple((along, s) for along, s, _ in kept)


def _clear_of_crossings(s: float, length: float, crossings: Sequence[Crossing], *, along: bool) -> float:
    """Return where traffic that would stop at s of a road stops for its crossings, m.

    Where there is no room before a crossing it stops so far behind it that a car fits between.
    """
    stop = length - s if along else s
    if not 0.0 <= stop <= length:
        return s
    behind = [item for item in crossings if (item.on_course[1] < s) == along]
    moved = before_crossings(stop, length, crossings, at_end=along)
    if moved == stop and behind:
        nearest = min(abs(item.on_course[1] - s) - 0.5 * item.width for item in behind)
        ahead = max(defaults.ROOM_FOR_CAR + defaults.STOP_LINE_EXTENT - nearest, 0.0)
        moved = max(stop - ahead, 0.0)
    return length - moved if along else moved


def _before(item: Candidate, known: Collection[str]) -> float:
    """Return how far before a node traffic stops, m; 0 where a placed crossing says so instead."""
    if item.osm_id in known:
        return 0.0
    if not item.crossing:
        return _HALF_GAP if item.along is None else 0.0
    return _HALF_CROSSING + defaults.STOP_LINE_BEFORE_CROSSING
