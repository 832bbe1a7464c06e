"""Bus stops beside roads, and their bays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import cos, hypot, inf, sin
from typing import Final

import numpy as np

from osm2xodr.curves import PointTree
from osm2xodr.diagnostics import Kind
from osm2xodr.furniture import defaults
from osm2xodr.furniture.world import Arm, NodePlace, RoadsideFinder, World, outline
from osm2xodr.model import BusStop, Direction, RoadObject, RoadsideKind, Rule
from osm2xodr.system import record

# How far from a carriageway a stop still is that of its buses, m; a choice.
_REACH: Final = 15.0
# No edge of a carriageway is farther from its road's line, m.
_WIDEST: Final = 60.0
# Height of the sign's upper edge and width of its post, m; choices.
_HEIGHT: Final = 2.5
_WIDTH: Final = 0.1
# Distance of the post from the carriageway, m (VwV-StVO).
_LATERAL: Final = 0.5
# Bays are as deep as a bus with its mirrors, have room for an articulated one, and taper off, m; choices, those of
# short bays.
_BAY_DEPTH: Final = 3.0
_BAY_LENGTH: Final = 20.0
_BAY_TAPER: Final = 12.0


@record
class _Stop:
    """A bus stop on its road."""

    road: int  # Id of the road
    s: float  # m
    leftwards: bool  # Whether it stands to the left of the road
    facts: BusStop
    osm_id: str


def bus_stop_objects(world: World, finder: RoadsideFinder) -> list[RoadObject]:
    """Make the objects of bus stops: a post at the kerb, and a bay where OSM has one."""
    out: list[RoadObject] = []
    for stop in [*_on_streets(world), *_beside(world, finder)]:
        bay = _bay(world, stop) if stop.facts.bay else None
        if bay is not None:
            out.append(bay)
        elif stop.facts.bay:
            words = "the bay of the bus stop is left out: the road is too short for it"
            world.diagnostics.dropped("bus-bay", stop.osm_id, words)
        out.append(_post(world, stop))
    return out


def _on_streets(world: World) -> list[_Stop]:
    """Return the stops that OSM has as nodes of streets."""
    stops = world.network.node_facts.bus_stops
    places = world.nodes.on_streets(stops)
    out = []
    guessed: list[str] = []
    left_out: list[str] = []
    for node in sorted(places):
        here = [place for place in places[node] if place.road >= 0]
        ends = [max(-place.s, place.s - world.lanes.length(place.road), 0.0) for place in here]
        if not ends or min(ends) > defaults.CROSSING_REACH:
            left_out.append(f"node/{node}")
            continue
        place = here[int(np.argmin(ends))]
        along = _runs_along(world, place, stops[node])
        if along is None:
            guessed.append(f"node/{node}")
        leftwards = (along is not False) != (world.network.rule is Rule.RIGHT_HAND)
        s = min(max(place.s, 0.0), world.lanes.length(place.road))
        out.append(_Stop(place.road, s, leftwards, stops[node], f"node/{node}"))
    finding = "without a direction on a two-way street: traffic along the way is assumed to stop there"
    world.diagnostics.count(Kind.GUESSED, "bus-stop-side", guessed, "bus stop", finding)
    finding = "left out: inside a junction"
    world.diagnostics.count(Kind.DROPPED, "roadside-left-out", left_out, "bus stop", finding)
    return out


def _runs_along(world: World, place: NodePlace, stop: BusStop) -> bool | None:
    """Return whether the buses of a stop run along the street; None where nothing says it."""
    street = world.network.streets[place.street]
    attributes = street.attributes_at(street.place_of(place.node))
    if stop.along is not None:
        return stop.along != attributes.reversed
    one_way = {frozenset({Direction.FORWARD}): True, frozenset({Direction.BACKWARD}): False}
    return one_way.get(attributes.car_directions())


def _beside(world: World, finder: RoadsideFinder) -> list[_Stop]:
    """Return the stops beside streets; a platform and a stop of the same name near each other stay two."""
    things = [thing for thing in world.network.roadside if thing.kind is RoadsideKind.BUS_STOP]
    if not things:
        return []
    middle = np.array([0.5 * (thing.points.min(axis=0) + thing.points.max(axis=0)) for thing in things])
    places = finder.places(middle[:, 0], middle[:, 1], _REACH)
    arms = [arm for group in world.nodes.arms.values() for arm in group]
    ends = PointTree(np.array([(arm.x, arm.y) for arm in arms]).reshape(-1, 2))
    out = []
    left_out: list[str] = []
    for k, thing in enumerate(things):
        if places.road[k] >= 0:
            leftwards = bool(places.t[k] > 0.5 * (places.left[k] + places.right[k]))
            found = world.road_map.roads[int(places.road[k])].id, float(places.s[k]), leftwards
        else:
            near = ends.within(middle[None, k], defaults.CROSSING_REACH + _WIDEST)[1]
            at_arm = _beside_arm(world, [arms[arm] for arm in near.tolist()], *middle[k].tolist())
            if at_arm is None:
                left_out.append(thing.osm_id)
                continue
            found, moved = at_arm
            words = f"the bus stop lies at a junction and was moved towards the road, by {moved:.1f} m"
            world.diagnostics.repaired("bus-stop-moved", thing.osm_id, words)
        out.append(_Stop(*found, thing.facts.bus_stop or BusStop(), thing.osm_id))
    finding = f"left out: no road lies within {_REACH:g} m"
    world.diagnostics.count(Kind.DROPPED, "roadside-left-out", left_out, "bus stop", finding)
    return out


def _beside_arm(
    world: World, arms: Sequence[Arm], x: float, y: float
) -> tuple[tuple[int, float, bool], float] | None:
    """Return road, s, m, and side of that of some junctions' arms which is nearest to a point, and how far off, m.

    None where no arm ends within `CROSSING_REACH`.
    """
    found: list[tuple[float, tuple[int, float, bool]]] = []
    for arm in arms:
        s = world.lanes.length(arm.road) if arm.at_end else 0.0
        dx, dy = x - arm.x, y - arm.y
        t = dy * cos(arm.hdg) - dx * sin(arm.hdg)
        left, right = world.lanes.carriageway(arm.road, s)
        off = hypot(dx * cos(arm.hdg) + dy * sin(arm.hdg), max(t - left, right - t, 0.0))
        found.append((off, (arm.road, s, t > 0.5 * (left + right))))
    off, place = min(found, default=(inf, (-1, 0.0, False)))
    return (place, off) if off <= defaults.CROSSING_REACH else None


def _edge(world: World, stop: _Stop, s: float) -> float:
    left, right = world.lanes.carriageway(stop.road, s)
    return left if stop.leftwards else right


def _orientation(world: World, stop: _Stop) -> str:
    """Return the direction of the traffic that stops there."""
    return "+" if stop.leftwards != (world.network.rule is Rule.RIGHT_HAND) else "-"


def _post(world: World, stop: _Stop) -> RoadObject:
    words = ("pole", "busStop", f"bus stop {stop.facts.name}".strip())
    t = _edge(world, stop, stop.s) + (_LATERAL if stop.leftwards else -_LATERAL)
    post = world.object_at(stop.road, words, stop.s, t, stop.osm_id)
    return replace(post, height=_HEIGHT, radius=0.5 * _WIDTH, orientation=_orientation(world, stop))


def _bay(world: World, stop: _Stop) -> RoadObject | None:
    """Make a bay beside the carriageway; None where the road is too short."""
    length = world.lanes.length(stop.road)
    half = 0.5 * _BAY_LENGTH
    whole = half + _BAY_TAPER
    if length < 2 * whole:
        return None
    s = min(max(stop.s, whole), length - whole)
    depth = _BAY_DEPTH if stop.leftwards else -_BAY_DEPTH
    # From one end to the other, and back along the kerb, so that the bay follows the road in bends.
    kerb = np.linspace(s + whole, s - whole, 8).tolist()[1:-1]
    places = [(s - whole, 0.0), (s - half, depth), (s + half, depth), (s + whole, 0.0), *((at, 0.0) for at in kerb)]
    corners = [(at, _edge(world, stop, at) + lateral) for at, lateral in places]
    t = _edge(world, stop, s) + 0.5 * depth
    bay = world.object_at(stop.road, ("patch", "busBay", "bus bay"), s, t, stop.osm_id)
    bay = replace(bay, outline=outline(world, stop.road, s, t, corners))
    return replace(bay, length=2 * whole, width=_BAY_DEPTH, orientation=_orientation(world, stop))
