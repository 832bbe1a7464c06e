"""Barriers, walls, fences, hedges and kerbs along roads."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from osm2xodr.furniture import defaults
from osm2xodr.furniture.objects.repeats import along_road
from osm2xodr.furniture.objects.roadside_runs import Strip, strips_outside
from osm2xodr.furniture.world import RoadsideFinder, World
from osm2xodr.model import RoadObject, RoadsideKind, RoadsideThing

# OpenDRIVE's type and a name by what OSM has.
_TYPES: Final[Mapping[RoadsideKind, tuple[str, str]]] = {
    RoadsideKind.GUARD_RAIL: ("barrier", "guard rail"),
    RoadsideKind.WALL: ("barrier", "wall"),
    RoadsideKind.FENCE: ("railing", "fence"),
    RoadsideKind.HEDGE: ("vegetation", "hedge"),
    RoadsideKind.BOLLARD: ("pole", "bollard"),
    RoadsideKind.KERB: ("none", "kerb"),
}
_SUBTYPES: Final[Mapping[RoadsideKind, str]] = {
    RoadsideKind.GUARD_RAIL: "guardRail",
    RoadsideKind.WALL: "wall",
    RoadsideKind.FENCE: "fence",
    RoadsideKind.HEDGE: "hedge",
    RoadsideKind.BOLLARD: "bollard",
    RoadsideKind.KERB: "kerb",
}


def barrier_objects(world: World, finder: RoadsideFinder, things: Iterable[RoadsideThing]) -> list[RoadObject]:
    """Make the objects of what runs along roads, road by road as far as it does.

    Parameters
    ----------
    world, finder
        The roads.
    things
        Those of `StreetNetwork.roadside` that may be of use.
    """
    lines = [thing for thing in things if thing.kind in _TYPES and len(thing.points) > 1]
    if not lines:
        return []
    sizes = [size_of(thing) for thing in lines]
    strips = strips_outside(finder, [thing.points for thing in lines], [0.5 * width for width, _ in sizes])
    used = Counter(strip.line for strip in strips)
    _tell_unused(world, [thing for k, thing in enumerate(lines) if k not in used])
    return [_object(world, lines[strip.line], strip, *sizes[strip.line]) for strip in strips]


def size_of(thing: RoadsideThing) -> tuple[float, float]:
    """Return width and height of a thing beside a road, m: as tagged, else usual."""
    width, height = defaults.OBJECT_SIZE[thing.kind.value]
    facts = thing.facts
    return width if facts.width is None else facts.width, height if facts.height is None else facts.height


def _object(world: World, thing: RoadsideThing, strip: Strip, width: float, height: float) -> RoadObject:
    kind, name = _TYPES[thing.kind]
    bollards = thing.kind is RoadsideKind.BOLLARD
    return along_road(
        world,
        strip,
        (kind, _SUBTYPES[thing.kind], name),
        (strip.t_start, strip.t_end),
        (width, height),
        defaults.BOLLARD_SPACING if bollards else 0.0,
        thing.osm_id,
    )


def _tell_unused(world: World, things: Sequence[RoadsideThing]) -> None:
    for kind, count in sorted(Counter(thing.kind.value for thing in things).items()):
        world.diagnostics.dropped(
            "roadside-left-out",
            "",
            f"{count} ways with a {kind.replace('_', ' ')} are left out: no part runs beside a carriageway within "
            f"{defaults.OBJECT_REACH:g} m",
        )
