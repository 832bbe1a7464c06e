"""Barriers, walls, fences, hedges, kerbs, bollards, lamps and trees beside roads, and tram tracks in them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import running_lengths
from osm2xodr.diagnostics import Kind
from osm2xodr.furniture import defaults
from osm2xodr.furniture.objects.strips import (
    POINT_SPACING,
    SHORTEST_RUN,
    Run,
    Strip,
    object_along,
    simplified,
    strips_on,
    strips_outside,
)
from osm2xodr.furniture.world import LaneAt, RoadsideFinder, World, pieces_on_road
from osm2xodr.model import VEHICLE_LANES, RoadObject, RoadsideKind, RoadsideThing

# OpenDRIVE's type and subtype, and a name.
_WORDS: Final = {
    RoadsideKind.GUARD_RAIL: ("barrier", "guardRail", "guard rail"),
    RoadsideKind.WALL: ("barrier", "wall", "wall"),
    RoadsideKind.FENCE: ("railing", "fence", "fence"),
    RoadsideKind.HEDGE: ("vegetation", "hedge", "hedge"),
    RoadsideKind.BOLLARD: ("pole", "bollard", "bollard"),
    RoadsideKind.KERB: ("none", "kerb", "kerb"),
    RoadsideKind.STREET_LAMP: ("streetLamp", "", "street lamp"),
    RoadsideKind.TREE: ("tree", "", "tree"),
}
# Width and height where tags give none, m: guard rails of steel (0.75 m) and kerbs (0.12 m) as in most of Germany
# (RPS 2009, RASt 06); garden walls, fences and hedges, street lamps, young trees: choices.
_SIZES: Final = {
    RoadsideKind.GUARD_RAIL: (0.3, 0.75),
    RoadsideKind.WALL: (0.3, 1.5),
    RoadsideKind.FENCE: (0.1, 1.2),
    RoadsideKind.HEDGE: (0.6, 1.2),
    RoadsideKind.BOLLARD: (0.2, 0.9),
    RoadsideKind.KERB: (0.15, 0.12),
    RoadsideKind.STREET_LAMP: (0.2, 6.0),
    RoadsideKind.TREE: (0.6, 8.0),
}
# Kinds that are placed on request only, and their names in the options.
_ON_REQUEST: Final = {RoadsideKind.STREET_LAMP: "lamps", RoadsideKind.TREE: "trees"}
_SINGLE: Final = (RoadsideKind.BOLLARD, RoadsideKind.GUARD_RAIL)
# Spacing in rows that are mapped as a line, m: bollards, so that no car passes between them, and trees. Choices.
_BOLLARD_SPACING: Final = 1.5
_TREE_SPACING: Final = 10.0


def line_objects(world: World, finder: RoadsideFinder) -> list[RoadObject]:
    """Make the objects of lines along roads, road by road as far as they run along it."""
    kinds = _WORDS.keys() - _ON_REQUEST.keys()
    lines = [thing for thing in world.network.roadside if thing.kind in kinds and len(thing.points) > 1]
    if not lines:
        return []
    sizes = [_size(thing) for thing in lines]
    strips = strips_outside(finder, [thing.points for thing in lines], [0.5 * width for width, _ in sizes])
    left_out: defaultdict[str, list[str]] = defaultdict(list)
    for k in sorted(set(range(len(lines))) - {strip.line for strip in strips}):
        left_out[lines[k].kind.value.replace("_", " ")].append(lines[k].osm_id)
    for name, ids in sorted(left_out.items()):
        finding = f"with a {name} left out: no part runs beside a carriageway within {defaults.OBJECT_REACH:g} m"
        world.diagnostics.count(Kind.DROPPED, "roadside-left-out", ids, "way", finding)
    out = []
    for strip in strips:
        thing = lines[strip.line]
        spacing = _BOLLARD_SPACING if thing.kind is RoadsideKind.BOLLARD else 0.0
        size = sizes[strip.line]
        out.append(object_along(world, strip, _WORDS[thing.kind], size, thing.osm_id, distance=spacing))
    return out


def point_objects(world: World, finder: RoadsideFinder) -> list[RoadObject]:
    """Make the objects of single things beside roads."""
    chosen = [thing for thing in world.network.roadside if _is_wanted(world, thing)]
    if not chosen:
        return []
    rows = [(thing, x, y) for thing in chosen for x, y in _points(thing)]
    places = finder.places(np.array([x for _, x, _ in rows]), np.array([y for _, _, y in rows]))
    leftwards = places.t - places.left > places.right - places.t
    out: list[RoadObject] = []
    left_out: defaultdict[tuple[str, str], list[str]] = defaultdict(list)
    for k, (thing, _, _) in enumerate(rows):
        if places.road[k] < 0 or places.beyond[k] < -defaults.OBJECT_INSIDE:
            far = places.road[k] < 0
            why = f"no road lies within {defaults.OBJECT_REACH:g} m" if far else "on the carriageway"
            left_out[thing.kind.value, why].append(thing.osm_id)
            continue
        width, height = _size(thing)
        off = 0.5 * width + defaults.OBJECT_GAP
        t = max(places.t[k], places.left[k] + off) if leftwards[k] else min(places.t[k], places.right[k] - off)
        road = world.road_map.roads[int(places.road[k])].id
        found = world.object_at(road, _WORDS[thing.kind], float(places.s[k]), float(t), thing.osm_id)
        out.append(replace(found, height=height, radius=0.5 * width))
    for (kind, why), names in sorted(left_out.items()):
        noun = kind.replace("_", " ")
        world.diagnostics.count(Kind.DROPPED, "roadside-left-out", names, noun, f"left out: {why}")
    return out


def _size(thing: RoadsideThing) -> tuple[float, float]:
    """Return width and height, m: as tagged, else usual."""
    width, height = _SIZES[thing.kind]
    facts = thing.facts
    return width if facts.width is None else facts.width, height if facts.height is None else facts.height


def _is_wanted(world: World, thing: RoadsideThing) -> bool:
    if thing.kind in _ON_REQUEST:
        return _ON_REQUEST[thing.kind] in world.options.extra_objects
    return thing.kind in _SINGLE and len(thing.points) == 1


def _points(thing: RoadsideThing) -> list[list[float]]:
    """Return where a thing stands, m, or each one of a row."""
    points = thing.points
    if len(points) > 1:
        along = running_lengths(points)
        at = np.linspace(0.0, along[-1], max(round(along[-1] / _TREE_SPACING), 1) + 1)
        points = np.column_stack([np.interp(at, along, column) for column in points.T])
    out: list[list[float]] = points.tolist()
    return out


# Standard gauge, and width of the head of a grooved rail, m.
_GAUGE: Final = 1.435
_RAIL_WIDTH: Final = 0.07


def tram_objects(world: World, finder: RoadsideFinder) -> list[RoadObject]:
    """Make the rails of tram tracks on carriageways.

    Tracks that are mapped as ways of their own lie where they are mapped, also through junctions; those that only the
    street's tags name lie in the lanes for cars next to the centre.
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
    found = [
        lane for lane in lanes if (lane.id > 0) == left and lane.type in VEHICLE_LANES and lane.left > lane.right
    ]
    return min(found, key=lambda lane: abs(lane.id)).middle if found else float("nan")


def _rails(world: World, strip: Strip, gauge: float, osm_id: str) -> list[RoadObject]:
    words, size = ("patch", "tramTrack", "tram track"), (_RAIL_WIDTH, 0.0)
    return [object_along(world, strip, words, size, osm_id, side * gauge) for side in (0.5, -0.5)]
