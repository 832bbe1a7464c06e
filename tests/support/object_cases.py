"""Worlds of small networks built by hand, for what is placed on and beside their roads."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from street_cases import Case

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.furniture.objects import place_objects
from osm2xodr.furniture.options import FurnitureOptions
from osm2xodr.furniture.world.lane_table import LaneTable
from osm2xodr.furniture.world.world import World
from osm2xodr.model import Footway, RoadObject, RoadsideKind, RoadsideThing, Rule, StreetNetwork
from osm2xodr.osmParsing.tags import read_node_facts, read_thing_facts

# The frame's origin is the middle of the nodes.
STREET = {"w": (-100.0, 0.0), "a": (0.0, 0.0), "e": (100.0, 0.0)}
ROAD = Case(STREET, {1: ("w a e", "lanes=2 width=7")})


def world_of(
    case: Case,
    rule: Rule = Rule.RIGHT_HAND,
    *,
    network: Callable[[StreetNetwork], StreetNetwork] = lambda network: network,
    extra: frozenset[str] = frozenset(),
) -> World:
    """Build a case, drawn for right-hand traffic and mirrored for left-hand traffic.

    Parameters
    ----------
    case, rule
        The network.
    network
        Changes what was read; it is given the case as drawn for the rule.
    extra
        Which extra objects are wanted.
    """
    drawn = case if rule is Rule.RIGHT_HAND else case.mirrored()
    road_map = drawn.build(rule)
    assert road_map.places is not None
    read = network(drawn.stages(rule).network)
    return World(
        read, road_map, road_map.places, LaneTable(road_map), FurnitureOptions(extra_objects=extra), Diagnostics()
    )


def side(rule: Rule) -> float:
    """Return 1 where traffic drives on the right, -1 on the left."""
    return 1.0 if rule is Rule.RIGHT_HAND else -1.0


def thing(
    kind: RoadsideKind, points: list[tuple[float, float]], rule: Rule = Rule.RIGHT_HAND, **tags: str
) -> RoadsideThing:
    """Return a thing beside the road; it is drawn for right-hand traffic."""
    places = np.array(points) * [1.0, side(rule)]
    name = "node/77" if len(points) == 1 else "way/77"
    return RoadsideThing(kind, name, places, np.arange(900, 900 + len(points)), read_thing_facts(kind, tags, ""))


def footway(points: list[tuple[float, float]], nodes: list[int], rule: Rule, **tags: str) -> Footway:
    """Return a footway that crosses; it is drawn for right-hand traffic."""
    return Footway(78, True, np.array(points) * [1.0, side(rule)], np.array(nodes), tags)


def with_footways(network: StreetNetwork, *footways: Footway) -> StreetNetwork:
    """Return a network with footways, and the crossings that they make."""
    facts = read_node_facts(network.node_tags, footways, network.country)
    return replace(network, footways=footways, node_facts=facts)


def said(world: World) -> Mapping[str, list[str]]:
    """Return the messages of diagnostics by their code."""
    out: dict[str, list[str]] = {}
    for item in world.diagnostics:
        out.setdefault(item.code, []).append(item.message)
    return out


def road_of_way(world: World, way: int) -> int:
    """Return the id of the only road outside junctions of a way."""
    (road,) = (road.id for road in world.road_map.roads if road.junction is None and way in road.osm_way_ids)
    return road


def has_corners(item: RoadObject, expected: list[tuple[float, float]]) -> bool:
    """Return whether an object on a straight road has corners at s and t, to 2 cm: OSM's degrees are rounded."""
    found = np.array([(item.s + u, item.t + v) for u, v, _, _ in item.outline])
    return found.shape == (len(expected), 2) and bool(np.abs(found - np.array(expected)).max() < 0.02)


def node_at(world: World, node: int) -> complex:
    """Return where a node of a street is: x + iy, m."""
    return next(
        complex(*street.points[street.place_of(node)]) for street in world.network.streets if node in street.node_ids
    )


def with_things(*things: RoadsideThing) -> Callable[[StreetNetwork], StreetNetwork]:
    """Return what gives a network other things beside its streets."""
    return lambda network: replace(network, roadside=things)


def placed(world: World) -> tuple[RoadObject, ...]:
    """Place the objects that need neither approaches nor stops."""
    return place_objects(world, (), ())


def s_of(x: float) -> float:
    """Return s of the road at x, m."""
    return x + 100.0
