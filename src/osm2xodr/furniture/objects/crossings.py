"""Crossings for people on foot: which there are, and where on which roads."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, hypot, sin
from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.furniture import defaults
from osm2xodr.furniture.world import Crossing, NodePlace, World
from osm2xodr.model import MappedCrossing

# Crossings end at least this far before a road does, m; a choice.
_FROM_END: Final = 0.05
# A crossing in a junction may go to arms within 30 degrees, by their sine, of the street that it crosses; a choice.
_ARM_SINE: Final = 0.5
# A crossing belongs to a junction if less is left between the two, m: with lights, which are mostly those of the
# junction, than the reach of its signs; without, than a car that waits between (RASt 06: 5 m). Choices.
_AT_JUNCTION_WITH_LIGHTS: Final = 20.0
_AT_JUNCTION: Final = 5.0
# Nothing crosses narrower carriageways, m; a choice.
_NARROWEST_CARRIAGEWAY: Final = 0.5


@dataclass(frozen=True, slots=True)
class _Placed:
    """A crossing on its road."""

    crossing: Crossing
    moved: float  # How far it was moved along the road, m
    width_tagged: bool  # Whether OSM gives a width


def find_crossings(world: World) -> tuple[Crossing, ...]:
    """Place the crossings of streets on roads, in the order of roads and s.

    Crossings in a junction go to the arm that they cross, if it is near.
    """
    crossings = world.network.node_facts.crossings
    found: dict[int, list[_Placed]] = defaultdict(list)
    on_streets = world.nodes.on_streets(mapped.node for mapped in crossings)
    for mapped in crossings:
        here = on_streets.get(mapped.node)
        if not here:
            continue
        placed = _placed(world, mapped, here)
        if isinstance(placed, str):
            words = f"the crossing is left out: {placed}"
            world.diagnostics.dropped("crossing-left-out", f"node/{mapped.node}", words)
        else:
            found[placed.crossing.road].append(placed)
    out = [item for road in sorted(found) for item in _merged(world, found[road])]
    _report(world, out)
    return tuple(item.crossing for item in out)


def _placed(world: World, mapped: MappedCrossing, here: Sequence[NodePlace]) -> _Placed | str:
    """Put a crossing on a road, or return why it is on none."""
    road, s = _nearest(world, mapped, here)
    if road < 0:
        return f"it lies in a junction, more than {defaults.CROSSING_REACH:g} m from every road that it could cross"
    length = world.lanes.length(road)
    # As tagged, else usual
    usual = defaults.CROSSING_WIDTH_SIGNALS if mapped.lights else defaults.CROSSING_WIDTH
    width = usual if mapped.width is None else max(mapped.width, defaults.CROSSING_WIDTH_MIN)
    width = min(width, length - 2 * _FROM_END)
    if width < defaults.CROSSING_WIDTH_MIN:
        return f"the road there, {length:.1f} m, is too short for it"
    room = 0.5 * width + _FROM_END
    at = min(max(s, room), length - room)
    left, right = world.lanes.carriageway(road, at)
    if left - right < _NARROWEST_CARRIAGEWAY:
        return "the road there has no carriageway"
    osm_id, marking = f"node/{mapped.node}", mapped.marking
    crossing = Crossing(road, at, width, left, right, osm_id, mapped.lights, marking=marking, island=mapped.island)
    return _Placed(_at_junction(world, crossing), abs(at - s), mapped.width_tagged)


def _nearest(world: World, mapped: MappedCrossing, here: Sequence[NodePlace]) -> tuple[int, float]:
    """Return road and s of the place to which a crossing goes; -1 where there is none within reach."""
    keys: list[tuple[float, float, int, float]] = []
    for place in here:
        # Where streets meet, the direction of the way that crosses shows which one it crosses.
        along = 0.0 if mapped.heading is None or len(here) == 1 else abs(cos(mapped.heading - place.hdg))
        for road, s in _candidates(world, place):
            keys.append((along, max(-s, s - world.lanes.length(road), 0.0), road, s))
    return min((key for key in keys if key[1] <= defaults.CROSSING_REACH), default=(0.0, 0.0, -1, 0.0))[2:]


def _candidates(world: World, place: NodePlace) -> list[tuple[int, float]]:
    """Return the roads to which a place may go, and s there, which may lie beyond the road's ends."""
    if place.road >= 0:
        return [(place.road, place.s)]
    arms = [item for item in world.nodes.arms.get(place.junction, ()) if abs(sin(item.hdg - place.hdg)) <= _ARM_SINE]
    off = [hypot(place.x - arm.x, place.y - arm.y) for arm in arms]
    length = world.lanes.length
    return [(arm.road, length(arm.road) + far if arm.at_end else -far) for arm, far in zip(arms, off, strict=True)]


def _at_junction(world: World, crossing: Crossing) -> Crossing:
    """Mark at which junction a crossing lies: the nearer, if no car fits between."""
    most = _AT_JUNCTION_WITH_LIGHTS if crossing.signals else _AT_JUNCTION
    road, to_end = world.lanes.road(crossing.road), world.lanes.length(crossing.road) - crossing.s
    ends = [
        (distance, at_end)
        for at_end, link, distance in ((False, road.predecessor, crossing.s), (True, road.successor, to_end))
        if link is not None and link.to_junction and distance - 0.5 * crossing.width <= most
    ]
    at_end = min(ends)[1] if ends else None
    return replace(crossing, at_start=at_end is False, at_end=at_end is True)


def _merged(world: World, found: list[_Placed]) -> list[_Placed]:
    """Return the crossings of one road in ascending s, overlapping ones merged."""
    out: list[_Placed] = []
    for item in sorted(found, key=lambda item: (item.crossing.s, item.crossing.osm_id)):
        last = out[-1] if out else None
        if last is None or item.crossing.s - last.crossing.s >= 0.5 * (item.crossing.width + last.crossing.width):
            out.append(item)
            continue
        # The one with lights is kept, else the one that was moved less.
        kept, gone = sorted((last, item), key=lambda item: (not item.crossing.signals, item.moved))
        words = f"the crossing overlaps that of {kept.crossing.osm_id}: both become one"
        world.diagnostics.note("crossing-merged", gone.crossing.osm_id, words)
        out[-1] = replace(kept, crossing=replace(kept.crossing, island=last.crossing.island or item.crossing.island))
    return out


def _report(world: World, placed: Sequence[_Placed]) -> None:
    """Report what was moved and what was guessed."""
    for item in placed:
        if item.moved > defaults.CROSSING_WIDTH:
            words = f"the crossing lies in a junction and was moved onto the road, by {item.moved:.1f} m"
            world.diagnostics.repaired("crossing-moved", item.crossing.osm_id, words)
    usual, with_lights = defaults.CROSSING_WIDTH, defaults.CROSSING_WIDTH_SIGNALS
    finding = f"without a width: {with_lights:g} m assumed with lights, {usual:g} m otherwise"
    guessed = [item.crossing.osm_id for item in placed if not item.width_tagged]
    world.diagnostics.count(Kind.GUESSED, "crossing-width", guessed, "crossing", finding)
