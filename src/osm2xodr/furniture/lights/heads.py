"""The heads of traffic lights: one for each group of lanes of an approach, two at each crossing.

Lights stand at junctions, and on roads apart from them: before crossings, on ramps, before tunnels.

All heads for cars have OpenDRIVE's type 1000001, whatever arrows they show: CARLA, esmini and SUMO read it as a
traffic light, whereas each of them knows other codes of arrows. Heads for people have type 1000002.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from itertools import groupby, pairwise
from typing import Final

from osm2xodr.furniture import defaults
from osm2xodr.furniture.world import (
    Approach,
    Crossing,
    Movement,
    World,
    before_crossings,
    car_lanes,
    crossings_on_course,
    lane_ranges,
)
from osm2xodr.model import VEHICLE_LANES, LaneType, Rule, Signal, SignalReference
from osm2xodr.system import record

_FOR_CARS: Final = "1000001"
FOR_PEOPLE: Final = "1000002"
_LEFT, THROUGH, _RIGHT = "left", "through", "right"
# Movements that turn by less go straight on, rad (34 degrees); a choice.
_THROUGH_TURN: Final = 0.6
# Least distance of heads from the start of their lane section, m; a choice.
_IN_SECTION: Final = 0.1

# Half of the extent of a crossing of which only the node is known, m; a choice.
_HALF_CROSSING: Final = 2.0
# Least distance of lights from the road's ends, m; a choice.
_FROM_END: Final = 0.5
# Half of the distance between the stop lines of both directions at a node that names no direction, and least distance
# of lights from a cut of lane sections, m: readers that cut roads there can then tell them apart; a choice.
_HALF_GAP: Final = 1.0


@record
class Head:
    """A head for cars at a junction."""

    signal: Signal  # What is written
    approach: int  # Index of its approach
    movements: tuple[Movement, ...]  # The ways through the junction that it governs


def turn_of(movement: Movement) -> str:
    """Return which way a movement turns: ``left``, ``through`` or ``right``."""
    if abs(movement.turn) <= _THROUGH_TURN:
        return THROUGH
    return _LEFT if movement.turn > 0 else _RIGHT


def lanes_at_stop(world: World, approach: Approach) -> dict[int, int]:
    """Return the ids of an approach's lanes where traffic stops, by those at the junction, where they go so far."""
    sections = world.lanes.road(approach.road).lane_sections
    between = [section for section, behind in pairwise(sections) if behind.s <= approach.stop_s]
    if approach.at_end:
        between = [section for section in reversed(sections) if section.s > approach.stop_s]
    named = {lane: lane for lane in approach.lanes}
    for section in between:
        links = {lane.id: lane.predecessor if approach.at_end else lane.successor for lane in section.lanes}
        named = {lane: link for lane, here in named.items() if (link := links.get(here)) is not None}
    return named


def approach_heads(
    world: World, index: int, approach: Approach, osm_id: str
) -> tuple[list[Head], list[SignalReference]]:
    """Make the heads of an approach, from the left to the right of its drivers, and the references to them.

    Neighbouring lanes that lead to the same sides share a head. The head of the lanes next to the kerb stands beside
    the carriageway, others hang above their lanes. All stand at the stop line, but in the lane section that touches
    the junction: readers give a light to the end of its lane section.
    """
    turns: dict[int, set[str]] = defaultdict(set)
    for movement in approach.movements:
        turns[movement.entry_lane].add(turn_of(movement))
    # From left to right
    sides = [tuple(word for word in (_LEFT, THROUGH, _RIGHT) if word in turns[lane]) for lane in approach.lanes]
    groups = [
        (words, [lane for lane, _ in group])
        for words, group in groupby(zip(approach.lanes, sides, strict=True), key=lambda item: item[1])
    ]
    road, s = approach.road, _head_s(world, approach)
    heads: list[Head] = []
    references: list[SignalReference] = []
    for k, (words, lanes) in enumerate(groups):
        signal = _light(world, road, s, _beside(world, road, s, approach.at_end), approach.at_end, lanes, osm_id)
        signal = replace(signal, name=f"traffic light, {' and '.join(words)}")
        if k != (len(groups) - 1 if world.road_map.rule is Rule.RIGHT_HAND else 0):
            edges = [t for lane in world.lanes.at(road, s) if lane.id in lanes for t in (lane.left, lane.right)]
            signal = replace(signal, t=0.5 * (min(edges) + max(edges)), z_offset=defaults.LIGHT_Z_ABOVE)
        movements = tuple(item for item in approach.movements if item.entry_lane in lanes)
        heads.append(Head(signal, index, movements))
        if world.options.target.light_references:
            references += _references(world, signal.id, movements)
    return heads, references


def _head_s(world: World, approach: Approach) -> float:
    """Return where the heads of an approach stand, s, m: in the lane section that touches the junction."""
    sections = world.lanes.road(approach.road).lane_sections
    if approach.at_end:
        first = sections[-1].s
        half = 0.5 * (first + world.lanes.length(approach.road))
        return max(approach.stop_s, min(first + _IN_SECTION, half) if len(sections) > 1 else first)
    if len(sections) == 1:
        return approach.stop_s
    return min(approach.stop_s, max(sections[1].s - _IN_SECTION, 0.5 * sections[1].s))


def _light(world: World, road: int, s: float, t: float, along: bool, lanes: Iterable[int], osm_id: str) -> Signal:
    """Make a head for cars beside the carriageway, for lanes with their ids at s of a road, m."""
    return Signal(
        *(world.ids.thing(), road, s, t, "traffic light", _FOR_CARS, "-1", "OpenDRIVE"),
        dynamic=True,
        orientation="+" if along else "-",
        z_offset=defaults.LIGHT_Z_BESIDE,
        height=defaults.LIGHT_HEIGHT,
        width=defaults.LIGHT_WIDTH,
        validity=lane_ranges(lanes),
        osm_id=osm_id,
    )


def _beside(world: World, road: int, s: float, along: bool) -> float:
    """Return t of a head beside the carriageway, on the side on which traffic of a direction drives, m."""
    left, right = world.lanes.carriageway(road, s)
    on_right = along == (world.road_map.rule is Rule.RIGHT_HAND)
    return right - defaults.LIGHT_BESIDE if on_right else left + defaults.LIGHT_BESIDE


def _references(world: World, signal: int, movements: Sequence[Movement]) -> list[SignalReference]:
    """Make the references from the connecting roads that a head governs; these run away from the approach.

    CARLA finds the lights of a junction by them. SUMO's netconvert (as of 1.28) compares the ids of their lanes with
    those of the approach and mistakes the way out for the way in where the signs differ; if the way out is a one-way
    road, its other end gets lights. Without ids both readers do worse.
    """
    lanes: dict[int, set[int]] = defaultdict(set)
    for movement in movements:
        lanes[movement.connecting_road].add(movement.entry_lane)
    out = []
    for road, entries in sorted(lanes.items()):
        first = world.lanes.road(road).lane_sections[0]
        own = [lane.id for lane in first.lanes if lane.predecessor in entries and lane.type in VEHICLE_LANES]
        out.append(SignalReference(signal, road, 0.0, _beside(world, road, 0.0, along=True), "+", lane_ranges(own)))
    return out


def road_heads(world: World, light: RoadLight) -> list[tuple[Signal, tuple[int, ...]]]:
    """Make the heads for cars of lights apart from junctions, each with the lanes that stop there."""
    out = []
    for along, s in light.stops:
        lanes, t = car_lanes(world, light.road, s, along), _beside(world, light.road, s, along)
        out.append((_light(world, light.road, s, t, along, lanes, light.osm_ids[0]), lanes))
    return out


def people_heads(world: World, crossing: Crossing, along: bool) -> list[Signal]:
    """Make the two heads that people on a crossing see on its far sides.

    `along` is the direction of the traffic that the crossing's other lights stop: SUMO gives the heads for people to
    the same end of the road. Connecting roads have one direction.
    """
    road, s, along = crossing.road, crossing.s, along or crossing.junction >= 0
    # Sidewalks that begin elsewhere are lanes of width 0 here.
    wide = [lane for lane in world.lanes.at(road, s) if lane.left > lane.right]
    out = []
    for t, side in ((crossing.left + defaults.LIGHT_BESIDE, 1), (crossing.right - defaults.LIGHT_BESIDE, -1)):
        # Lane 0, no lane, where there is no sidewalk: no reader may stop cars for it.
        own = [lane.id for lane in wide if lane.type is LaneType.SIDEWALK and lane.id * side > 0] or [0]
        head = _light(world, road, s, t, along, own, crossing.osm_id)
        # The head at the left end faces people who walk to the left.
        turned = replace(head, h_offset=0.5 * math.pi * side * (1.0 if along else -1.0))
        height = defaults.LIGHT_HEIGHT_PEOPLE
        out.append(replace(turned, name="pedestrian light", type=FOR_PEOPLE, height=height))
    return out


@record
class Candidate:
    """A node with lights on a road."""

    road: int  # Id of the road
    s: float  # m; may lie beyond the road's ends
    along: bool | None  # Whether for traffic along s (else against it); None for both
    osm_id: str  # The node
    crossing: bool  # Whether people cross there


@record
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
