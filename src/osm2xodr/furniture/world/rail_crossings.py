"""Where roads cross railways, and what stands there."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import Final

from osm2xodr.furniture import defaults
from osm2xodr.furniture.world.approaches import car_lanes
from osm2xodr.furniture.world.world import World
from osm2xodr.model import RailCrossing

# How far before the middle of the first track signs stand, m: MUTCD 2009, 8B.03, wants crossbucks 12 ft from the
# nearest rail, and the rail is half of the gauge from the middle.
_BEFORE_TRACK: Final = 4.4


@dataclass(frozen=True, slots=True)
class RailStop:
    """What stands before the tracks for one direction of a road."""

    road: int  # Id of the road
    s: float  # m
    along: bool  # Whether for traffic along s, else for that against it
    crossing: RailCrossing  # What OSM says of it
    osm_id: str  # The node


def find_rail_stops(world: World) -> list[RailStop]:
    """Return where traffic meets railways, by road; tracks near each other are one crossing.

    Crossings in a junction are for the road that leads to them.
    """
    known = world.network.node_facts.rail_crossings
    by_road: dict[int, list[tuple[float, int]]] = defaultdict(list)
    for node, places in sorted(world.nodes.on_streets(known).items()):
        on_road = [place for place in places if place.road >= 0]
        for place in on_road:
            by_road[place.road].append((place.s, node))
        if not on_road:
            words = "railway=level_crossing is not carried: it lies in a junction, on a way that no road leads over"
            world.diagnostics.dropped("street-node", f"node/{node}", words)
    return [stop for road, tracks in sorted(by_road.items()) for stop in _stops(world, road, sorted(tracks))]


def _stops(world: World, road: int, tracks: list[tuple[float, int]]) -> list[RailStop]:
    length = world.lanes.length(road)
    groups: list[list[tuple[float, int]]] = []
    for track in tracks:
        if not groups or track[0] - groups[-1][-1][0] > defaults.ONE_INSTALLATION:
            groups.append([])
        groups[-1].append(track)
    out: list[RailStop] = []
    for group in groups:
        for (at, node), along in ((group[0], True), (group[-1], False)):
            s = at - _BEFORE_TRACK if along else at + _BEFORE_TRACK
            # Beyond the road's end, in a junction, it is met by those who leave the road there.
            met = s >= 0.0 if along else s <= length
            inside = min(max(s, 0.0), length)
            if met and car_lanes(world, road, inside, along):
                crossing = world.network.node_facts.rail_crossings[node]
                out.append(RailStop(road, inside, along, crossing, f"node/{node}"))
    return out
