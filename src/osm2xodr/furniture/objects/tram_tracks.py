"""The rails of tram tracks in carriageways."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

from osm2xodr.furniture.objects.strips import (
    POINT_SPACING,
    SHORTEST_RUN,
    Run,
    Strip,
    object_along,
    simplified,
    strips_on,
)
from osm2xodr.furniture.world import CAR_LANES, LaneAt, RoadsideFinder, World, pieces_on_road
from osm2xodr.model import RoadObject, RoadsideKind

# Standard gauge, and width of the head of a grooved rail, m.
_GAUGE: Final = 1.435
_RAIL_WIDTH: Final = 0.07


def tram_objects(world: World, finder: RoadsideFinder) -> list[RoadObject]:
    """Make the rails of tram tracks on carriageways.

    Tracks that are mapped as ways of their own lie where they are mapped; those that only the street's tags name lie
    in the lanes for cars next to the centre.
    """
    tracks = [thing for thing in world.network.roadside if thing.kind is RoadsideKind.TRAM_TRACK]
    lines = [thing for thing in tracks if len(thing.points) > 1]
    half = 0.5 * (_GAUGE + _RAIL_WIDTH)
    mapped = strips_on(finder, [thing.points for thing in lines], half)
    out: list[RoadObject] = []
    for strip in mapped:
        out += _rails(world, strip, lines[strip.line].facts.gauge or _GAUGE, lines[strip.line].osm_id)
    with_tracks = {strip.road for strip in mapped}
    for k, street in enumerate(world.places.road_street.tolist()):
        if k in with_tracks or not any(piece.tram for _, piece in world.network.streets[street].pieces):
            continue
        road = world.road_map.roads[k].id
        for begin, end, attributes in pieces_on_road(world, world.network.streets[street], road):
            if attributes.tram:
                for strip in _in_lanes(world, k, begin, end):
                    out += _rails(world, strip, _GAUGE, f"way/{attributes.osm_way_id}")
    return out


def _in_lanes(world: World, curve: int, begin: float, end: float) -> list[Strip]:
    """Return the middle lines of tracks in the lanes for cars next to the centre, on both sides."""
    if end - begin < SHORTEST_RUN:
        return []
    road = world.road_map.roads[curve].id
    count = max(int(np.ceil((end - begin) / POINT_SPACING)), 1) + 1
    stations = np.linspace(begin, end, count)
    lanes = [world.lanes.at(road, s) for s in stations.tolist()]
    out: list[Strip] = []
    for left in (True, False):
        middles = np.array([_innermost(here, left) for here in lanes])
        there = np.flatnonzero(np.isfinite(middles))
        for rows in np.split(there, np.flatnonzero(np.diff(there) > 1) + 1):
            if len(rows) > 1:
                out += simplified(Run(0, curve, stations[rows], middles[rows]))
    return out


def _innermost(lanes: Iterable[LaneAt], left: bool) -> float:
    """Return t of the middle of the lane for cars next to the centre on one side, NaN where there is none."""
    found = [lane for lane in lanes if (lane.id > 0) == left and lane.type in CAR_LANES and lane.left > lane.right]
    return min(found, key=lambda lane: abs(lane.id)).middle if found else float("nan")


def _rails(world: World, strip: Strip, gauge: float, osm_id: str) -> list[RoadObject]:
    words, size = ("patch", "tramTrack", "tram track"), (_RAIL_WIDTH, 0.0)
    return [object_along(world, strip, words, size, osm_id, side * gauge) for side in (0.5, -0.5)]
