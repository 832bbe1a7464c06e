"""Crossings for people on foot: which there are, and where on which roads."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import cos, hypot, sin

from osm2xodr.diagnostics import Kind
from osm2xodr.furniture import defaults
from osm2xodr.furniture.objects.crosswalks import crossing_objects
from osm2xodr.furniture.world import Crossing, NodePlace, NodePlaces, World
from osm2xodr.model import MappedCrossing

__all__ = ["crossing_objects", "find_crossings"]

# Carriageways that are narrower are none, m.
_NARROWEST = 0.5


@dataclass(frozen=True, slots=True)
class _Found:
    """A crossing on its road, and how far it has been moved along it, m."""

    crossing: Crossing
    moved: float


def find_crossings(world: World) -> tuple[Crossing, ...]:
    """Find where people cross roads, in the order of roads and s.

    Each node of a street that is tagged as a crossing, and each that a way for crossing shares with a street, becomes
    a crossing of the road there. Nodes in a junction go to the arm that they cross, if that is near.
    """
    wishes = world.network.node_facts.crossings
    places = world.nodes
    found: dict[int, list[_Found]] = defaultdict(list)
    on_streets = places.on_streets(wish.node for wish in wishes)
    for wish in wishes:
        here = on_streets.get(wish.node)
        if not here:
            continue
        placed = _placed(world, places, wish, here)
        if isinstance(placed, str):
            world.diagnostics.dropped("crossing-left-out", f"node/{wish.node}", f"the crossing is left out: {placed}")
        else:
            found[placed.crossing.road].append(placed)
    out = [item for road in sorted(found) for item in _merged(world, found[road])]
    _tell(world, out, {wish.node: wish for wish in wishes})
    return tuple(item.crossing for item in out)


def _width(wish: MappedCrossing) -> float:
    """Return the extent of a crossing along the road, m: as tagged, else usual."""
    if wish.width is not None:
        return max(wish.width, defaults.CROSSING_WIDTH_MIN)
    return defaults.CROSSING_WIDTH_SIGNALS if wish.lights else defaults.CROSSING_WIDTH


def _placed(world: World, places: NodePlaces, wish: MappedCrossing, here: Sequence[NodePlace]) -> _Found | str:
    """Put a crossing on a road, or say why it is on none."""
    road, s = _nearest(world, places, wish, here)
    if road < 0:
        return s if isinstance(s, str) else "no road is left of its street"
    assert not isinstance(s, str)
    length = world.lanes.length(road)
    width = min(_width(wish), length - 2 * defaults.CROSSING_END)
    if width < defaults.CROSSING_WIDTH_MIN:
        return f"the road there, {length:.1f} m, is too short for it"
    room = 0.5 * width + defaults.CROSSING_END
    at = min(max(s, room), length - room)
    left, right = world.lanes.carriageway(road, at)
    if left - right < _NARROWEST:
        return "the road there has no carriageway"
    crossing = Crossing(
        road,
        at,
        width,
        left,
        right,
        f"node/{wish.node}",
        wish.lights,
        marking=wish.marking,
        island=wish.island,
    )
    return _Found(_at_junction(world, crossing), abs(at - s))


def _nearest(
    world: World, places: NodePlaces, wish: MappedCrossing, here: Sequence[NodePlace]
) -> tuple[int, float | str]:
    """Return road and s of the place that a crossing goes to; -1 and why where there is none within reach."""
    best: tuple[float, float, int, float] | None = None
    for place in here:
        for road, s in _candidates(world, places, place):
            length = world.lanes.length(road)
            off = max(-s, s - length, 0.0)
            # Where streets meet, the way that crosses tells which it crosses.
            along = 0.0 if wish.heading is None else abs(cos(wish.heading - place.hdg))
            key = (along if len(here) > 1 else 0.0, off, road, s)
            if off <= defaults.CROSSING_REACH and (best is None or key < best):
                best = key
    if best is None:
        return (
            -1,
            f"it lies in a junction, more than {defaults.CROSSING_REACH:g} m from every road that it could cross",
        )
    return best[2], best[3]


def _candidates(world: World, places: NodePlaces, place: NodePlace) -> list[tuple[int, float]]:
    """Return the roads that a place may go to, and s there, beyond the road's ends too."""
    if place.road >= 0:
        return [(place.road, place.s)]
    out = []
    for arm in places.arms.get(place.junction, ()):
        if abs(sin(arm.hdg - place.hdg)) > defaults.CROSSING_SINE:
            continue
        off = hypot(place.x - arm.x, place.y - arm.y)
        out.append((arm.road, world.lanes.length(arm.road) + off if arm.at_end else -off))
    return out


def _at_junction(world: World, crossing: Crossing) -> Crossing:
    """Say at which junction a crossing lies: the nearer, if no car fits between."""
    length = world.lanes.length(crossing.road)
    most = defaults.CROSSING_AT_JUNCTION_SIGNALS if crossing.signals else defaults.CROSSING_AT_JUNCTION
    road = world.lanes.road(crossing.road)
    ends = []
    for at_end, link, distance in (
        (False, road.predecessor, crossing.s),
        (True, road.successor, length - crossing.s),
    ):
        if link is not None and link.to_junction and distance - 0.5 * crossing.width <= most:
            ends.append((distance, at_end))
    if not ends:
        return crossing
    at_end = min(ends)[1]
    return replace(crossing, at_start=not at_end, at_end=at_end)


def _merged(world: World, found: list[_Found]) -> list[_Found]:
    """Return the crossings of one road in ascending s; those that lie on each other become one."""
    out: list[_Found] = []
    for item in sorted(found, key=lambda item: (item.crossing.s, item.crossing.osm_id)):
        last = out[-1] if out else None
        if last is None or item.crossing.s - last.crossing.s >= 0.5 * (item.crossing.width + last.crossing.width):
            out.append(item)
            continue
        # The one with lights, or else the one that lies where OSM has it.
        kept, gone = sorted((last, item), key=lambda item: (not item.crossing.signals, item.moved))
        world.diagnostics.note(
            "crossing-merged",
            gone.crossing.osm_id,
            f"the crossing lies on that of {kept.crossing.osm_id}; both are one",
        )
        out[-1] = replace(kept, crossing=replace(kept.crossing, island=last.crossing.island or item.crossing.island))
    return out


def _tell(world: World, found: Sequence[_Found], wishes: Mapping[int, MappedCrossing]) -> None:
    """Report what was moved and what was guessed."""
    guessed = []
    for item in found:
        if not wishes[int(item.crossing.osm_id.removeprefix("node/"))].width_tagged:
            guessed.append(item.crossing.osm_id)
        if item.moved > defaults.CROSSING_WIDTH:
            world.diagnostics.repaired(
                "crossing-moved",
                item.crossing.osm_id,
                f"the crossing lies in a junction and was moved onto the road, by {item.moved:.1f} m",
            )
    finding = (
        f"without a width: {defaults.CROSSING_WIDTH_SIGNALS:g} m assumed with lights, "
        f"{defaults.CROSSING_WIDTH:g} m otherwise"
    )
    world.diagnostics.count(Kind.GUESSED, "crossing-width", guessed, "crossing", finding)
