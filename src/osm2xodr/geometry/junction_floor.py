"""The floor of all junctions, which heights do not depend on but for sidewalks that turn out too steep."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial

import numpy as np

from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junctions import JunctionLayout
from osm2xodr.geometry.pavement import Faces, Floor, Hole, is_island, lay_floor
from osm2xodr.geometry.road_plan import RoadPlan, RoadSides
from osm2xodr.geometry.road_records import RoadIds
from osm2xodr.model import BoolArray, FloatArray, Island, StreetNetwork


def lay_out_floor(network: StreetNetwork, plan: RoadPlan, through: ConnectingRoads) -> Floor:
    """Lay the floor of junctions; `through` are all roads through these, those of sidewalks behind those of cars."""
    enclosed = partial(_is_enclosed, _streets_at(network), plan.layout, through)
    round_islands = _round_islands(network, plan.layout)
    return lay_floor(through, network.rule, Faces.of(plan.parts, through, network.rule), round_islands, enclosed)


def floor_without(
    network: StreetNetwork, plan: RoadPlan, through: ConnectingRoads, floor: Floor, left_out: BoolArray
) -> Floor:
    """Return the floor of the roads through junctions, (n,), without those that are left out.

    Only the floor of their junctions is laid again.
    """
    if not left_out.any():
        return floor
    number = np.cumsum(~left_out) - 1
    anew = np.isin(through.junction, through.junction[left_out])
    rows = np.flatnonzero(anew & ~left_out)
    again = lay_out_floor(network, plan, through.chosen(rows))
    kept = floor.renumbered(np.where(anew, -1, number))
    return kept.joined(again.renumbered(number[rows]), through.junction[~left_out])


def ends_at_floor(sides: RoadSides, floor: Floor) -> BoolArray:
    """Say which sidewalks, of those that run out, have a strip of the floor in their place, (n,)."""
    strips = {1: floor.left, -1: floor.right}
    rows = zip(sides.ends.row.tolist(), sides.ends.side.tolist(), strict=True)
    return np.array([row in strips[side] for row, side in rows], bool)


def islands_of(plan: RoadPlan, through: ConnectingRoads, floor: Floor) -> Iterator[Island]:
    """Return the islands that junctions have."""
    ids = RoadIds(len(plan.parts.length), len(through.length))
    for hole in floor.islands:
        junction = int(through.junction[hole.road])
        yield Island(ids.junction(junction), len(plan.parts.length) + hole.road, hole.corners)


def _round_islands(network: StreetNetwork, layout: JunctionLayout) -> frozenset[int]:
    """Return the junctions whose loops go round an island (OSM wiki, Tag:highway=turning_loop)."""
    loops = {node for node, tags in network.node_tags.items() if tags.get("highway") == "turning_loop"}
    if not loops:
        return frozenset()
    ids = [item.osm_node_id for item in network.intersections]
    return frozenset(k for k, nodes in enumerate(layout.nodes) if any(ids[node] in loops for node in nodes))


def _streets_at(network: StreetNetwork) -> dict[int, list[FloatArray]]:
    """Return the lines of the streets that begin or end at each intersection, (n, 2), m."""
    out: dict[int, list[FloatArray]] = {}
    for street in network.streets:
        for node in {street.start, street.end}:
            out.setdefault(node, []).append(street.points)
    return out


def _is_enclosed(
    streets: Mapping[int, Sequence[FloatArray]], layout: JunctionLayout, through: ConnectingRoads, hole: Hole
) -> bool:
    """Say whether the streets of its junction go round a hole, those at each intersection given."""
    lines = [line for node in layout.nodes[int(through.junction[hole.road])] for line in streets.get(node, ())]
    return is_island(
        hole, np.concatenate([line[:-1] for line in lines]), np.concatenate([line[1:] for line in lines])
    )
