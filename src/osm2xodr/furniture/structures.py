"""Bridges that roads lead over, and tunnels that they lead through."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import groupby

from osm2xodr import defaults
from osm2xodr.diagnostics import Kind
from osm2xodr.furniture.street_pieces import pieces_on_road
from osm2xodr.furniture.world import World
from osm2xodr.model import Road, RoadLink, RoadStructure, StructureTags

# What begins or ends this near to a road's end reaches it, m.
_AT_END = 0.1


@dataclass(frozen=True, slots=True)
class _Part:
    """Where on a road a bridge or tunnel is, m, its tags, and the OSM ways that have them."""

    begin: float
    end: float
    tags: tuple[StructureTags, ...]
    ways: tuple[int, ...]


def place_structures(world: World) -> tuple[RoadStructure, ...]:
    """Return the bridges and tunnels of all roads, in ascending road and s.

    Those of connecting roads are the ones that both of the roads that they join end on.
    """
    parts = {
        world.road_map.roads[k].id: list(_parts(world, k, street))
        for k, street in enumerate(world.places.road_street.tolist())
        if any(piece.structure_tags is not None for _, piece in world.network.streets[street].pieces)
    }
    for road in world.road_map.roads if parts else ():
        if road.junction is not None:
            between = _between(world, road, parts)
            if between is not None:
                parts[road.id] = [between]
    found = tuple(_structure(world, road, part) for road in sorted(parts) for part in parts[road])
    _report(world, [part for of_road in parts.values() for part in of_road])
    return found


def _parts(world: World, curve: int, street: int) -> Iterator[_Part]:
    """Yield where the bridges and tunnels of a road are; ways in a row that have the same make one."""
    pieces = pieces_on_road(world, world.network.streets[street], world.road_map.roads[curve].id)
    for kind, group in groupby(pieces, key=lambda piece: _kind(piece[2].structure_tags)):
        if kind is None:
            continue
        row = list(group)
        tags = tuple(piece.structure_tags for _, _, piece in row if piece.structure_tags is not None)
        yield _Part(row[0][0], row[-1][1], tags, tuple(sorted({piece.osm_way_id for _, _, piece in row})))


def _kind(tags: StructureTags | None) -> tuple[str, str, bool] | None:
    """Return what two ways have in common if they are on one structure."""
    return None if tags is None else (tags.kind, tags.material, tags.open_sides)


def _between(world: World, road: Road, parts: dict[int, list[_Part]]) -> _Part | None:
    """Return the part of a connecting road; None if one of the roads that it joins ends on the ground."""
    before, after = (_at_end(world, link, parts) for link in (road.predecessor, road.successor))
    if before is None or after is None or _kind(before.tags[0]) != _kind(after.tags[0]):
        return None
    ways = tuple(sorted({*before.ways, *after.ways}))
    return _Part(0.0, world.lanes.length(road.id), (*before.tags, *after.tags), ways)


def _at_end(world: World, link: RoadLink | None, parts: dict[int, list[_Part]]) -> _Part | None:
    """Return what the end of a road that a link leads to lies on."""
    if link is None or link.to_junction or not parts.get(link.id):
        return None
    first, last = parts[link.id][0], parts[link.id][-1]
    if link.at_start:
        return first if first.begin < _AT_END else None
    return last if last.end > world.lanes.length(link.id) - _AT_END else None


def _structure(world: World, road: int, part: _Part) -> RoadStructure:
    first = part.tags[0]
    name = next((tags.name for tags in part.tags if tags.name), "")
    length = part.end - part.begin
    structure = RoadStructure(
        world.ids.thing(), road, part.begin, length, first.kind, "", name, osm_way_ids=part.ways
    )
    if first.kind == "bridge":
        return replace(structure, type=first.material or defaults.BRIDGE_MATERIAL)
    lit = next((tags.lit for tags in part.tags if tags.lit is not None), length >= defaults.TUNNEL_LIT_LENGTH)
    daylight = defaults.GALLERY_DAYLIGHT if first.open_sides else 0.0
    return replace(
        structure, type="underpass" if first.open_sides else "standard", lighting=float(lit), daylight=daylight
    )


def _report(world: World, parts: list[_Part]) -> None:
    """Report what was guessed."""
    plain, dark = set[int](), set[int]()
    for part in parts:
        if part.tags[0].kind == "bridge" and not part.tags[0].material:
            plain.update(part.ways)
        if part.tags[0].kind == "tunnel" and all(tags.lit is None for tags in part.tags):
            dark.update(part.ways)
    words = f"ways on bridges have no material, {defaults.BRIDGE_MATERIAL} is taken"
    world.diagnostics.count(Kind.GUESSED, "bridge-material", [f"way/{way}" for way in sorted(plain)], words)
    words = f"ways in tunnels do not say whether they are lit, taken as lit from {defaults.TUNNEL_LIT_LENGTH:g} m on"
    world.diagnostics.count(Kind.GUESSED, "tunnel-lighting", [f"way/{way}" for way in sorted(dark)], words)
