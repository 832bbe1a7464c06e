"""Bridges that roads lead over, and tunnels that they lead through."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from itertools import groupby
from typing import Final, TypeAlias

from osm2xodr.diagnostics import Kind
from osm2xodr.furniture.world import World, pieces_on_road
from osm2xodr.model import Road, RoadLink, RoadStructure, StructureTags
from osm2xodr.system import record

# Material of bridges where OSM gives none: that of most road bridges of the last 70 years.
_BRIDGE_MATERIAL: Final = "concrete"
# Share of daylight that reaches the road in galleries, which are open at one side, 0 to 1; a choice.
_GALLERY_DAYLIGHT: Final = 0.5
# Tunnels are lit from this length on where OSM says nothing, m: RABT 2006 counts covers of over 80 m as tunnels, with
# lights.
_LIT_LENGTH: Final = 80.0
# Parts that begin or end this near to a road's end reach it, m; a choice.
_END_TOLERANCE: Final = 0.1


@record
class _Part:
    """Part of a road on a bridge or in a tunnel."""

    begin: float  # Where on the road, m
    end: float
    tags: tuple[StructureTags, ...]
    ways: tuple[int, ...]  # OSM ways that have these tags


_Parts: TypeAlias = dict[int, list[_Part]]
# (id of the road, number of the part there)
_Key: TypeAlias = tuple[int, int]


def place_structures(world: World) -> tuple[RoadStructure, ...]:
    """Return the bridges and tunnels of all roads, in ascending road and s.

    A connecting road is on a bridge or in a tunnel if both roads that it joins are where they end.
    """
    parts: _Parts = {
        world.road_map.roads[k].id: list(_parts(world, k, street))
        for k, street in enumerate(world.places.road_street.tolist())
        if any(piece.structure_tags is not None for _, piece in world.network.streets[street].pieces)
    }
    through = {
        item.connecting_road
        for junction in world.road_map.junctions
        for item in junction.connections
        if item.incoming_road in parts
    }
    for road in sorted(through):
        between = _between(world, world.lanes.road(road), parts)
        if between is not None:
            parts[road] = [between]
    extent = _extents(world, parts)
    found = tuple(
        _structure(world, road, part, extent[road, number])
        for road in sorted(parts)
        for number, part in enumerate(parts[road])
    )
    _report(world, [part for of_road in parts.values() for part in of_road])
    return found


def _parts(world: World, curve: int, street: int) -> Iterator[_Part]:
    """Yield the parts of a road; consecutive ways on the same structure make one."""
    pieces = pieces_on_road(world, world.network.streets[street], world.road_map.roads[curve].id)
    for kind, group in groupby(pieces, key=lambda piece: _kind(piece[2].structure_tags)):
        if kind is None:
            continue
        row = list(group)
        tags = tuple(piece.structure_tags for _, _, piece in row if piece.structure_tags is not None)
        yield _Part(row[0][0], row[-1][1], tags, tuple(sorted({piece.osm_way_id for _, _, piece in row})))


def _kind(tags: StructureTags | None) -> tuple[str, str, bool] | None:
    """Return what ways on one structure have in common; None on the ground."""
    return None if tags is None else (tags.kind, tags.material, tags.open_sides)


def _between(world: World, road: Road, parts: _Parts) -> _Part | None:
    """Return the part of a connecting road; None if one of the roads that it joins ends on the ground."""
    ends = [_beyond(world, link, parts) for link in (road.predecessor, road.successor)]
    before, after = (None if key is None else parts[key[0]][key[1]] for key in ends)
    if before is None or after is None or _kind(before.tags[0]) != _kind(after.tags[0]):
        return None
    ways = tuple(sorted({*before.ways, *after.ways}))
    return _Part(0.0, world.lanes.length(road.id), (*before.tags, *after.tags), ways)


def _beyond(world: World, link: RoadLink | None, parts: _Parts) -> _Key | None:
    """Return the part at the end of a road to which a link leads."""
    if link is None or link.to_junction or not parts.get(link.id):
        return None
    return _at_end(world, link.id, parts, at_start=bool(link.at_start))


def _at_end(world: World, road: int, parts: _Parts, *, at_start: bool) -> _Key | None:
    """Return the part at the start or end of a road."""
    first, last = parts[road][0], parts[road][-1]
    if at_start:
        return (road, 0) if first.begin < _END_TOLERANCE else None
    return (road, len(parts[road]) - 1) if last.end > world.lanes.length(road) - _END_TOLERANCE else None


def _extents(world: World, parts: _Parts) -> dict[_Key, float]:
    """Return the length of the structure of each part, over all its roads, m; connecting roads do not count."""
    links: defaultdict[_Key, set[_Key]] = defaultdict(set)
    roads = [world.lanes.road(road) for road in parts]
    connecting = {road.id for road in roads if road.junction is not None}
    for road in roads:
        if not parts[road.id]:
            continue
        for link, at_start in ((road.predecessor, True), (road.successor, False)):
            here, there = _at_end(world, road.id, parts, at_start=at_start), _beyond(world, link, parts)
            if here is not None and there is not None:
                links[here].add(there)
                links[there].add(here)
    out: dict[_Key, float] = {}
    for first in ((road, number) for road, of_road in parts.items() for number in range(len(of_road))):
        if first in out:
            continue
        whole, todo = {first}, [first]
        while todo:
            new = links[todo.pop()] - whole
            whole |= new
            todo += new
        own = [parts[road][number] for road, number in sorted(whole) if road not in connecting]
        out.update(dict.fromkeys(whole, math.fsum(part.end - part.begin for part in own)))
    return out


def _structure(world: World, road: int, part: _Part, extent: float) -> RoadStructure:
    """Make a part of a structure of some length, m."""
    first = part.tags[0]
    form, lighting, daylight = first.material or _BRIDGE_MATERIAL, 0.0, 0.0
    if first.kind == "tunnel":
        lit = next((tags.lit for tags in part.tags if tags.lit is not None), extent >= _LIT_LENGTH)
        form, lighting = "underpass" if first.open_sides else "standard", float(lit)
        daylight = _GALLERY_DAYLIGHT if first.open_sides else 0.0
    id_, begin, length = world.ids.thing(), part.begin, part.end - part.begin
    name = next((tags.name for tags in part.tags if tags.name), "")
    return RoadStructure(id_, road, begin, length, first.kind, form, name, lighting, daylight, part.ways)


def _report(world: World, parts: list[_Part]) -> None:
    """Report what was guessed."""
    plain = [part for part in parts if part.tags[0].kind == "bridge" and not part.tags[0].material]
    tunnels = [part for part in parts if part.tags[0].kind == "tunnel"]
    dark = [part for part in tunnels if all(tags.lit is None for tags in part.tags)]
    material = f"on bridges without a material: {_BRIDGE_MATERIAL} assumed"
    lighting = f"in tunnels without lit=*: assumed lit from a length of {_LIT_LENGTH:g} m"
    for code, found, finding in (("bridge-material", plain, material), ("tunnel-lighting", dark, lighting)):
        ids = [f"way/{way}" for way in sorted({way for part in found for way in part.ways})]
        world.diagnostics.count(Kind.GUESSED, code, ids, "way", finding)
