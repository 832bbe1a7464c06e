"""Where nodes with lights are on roads."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from osm2xodr.furniture.world import World


@dataclass(frozen=True, slots=True)
class LightRow:
    """A place of a node with lights."""

    # The road, -1 for none, and where on it, m; beyond its ends in a junction
    road: int
    s: float
    junction: int  # Id of the junction that it lies in, -1 for none
    along: bool | None  # Whether it is for traffic along s (else against it); None where it may be for both


def light_rows(world: World, nodes: Collection[int]) -> Mapping[int, list[LightRow]]:
    """Return all places of some tagged nodes, those nearest to their roads first."""
    places = world.places
    rows = np.flatnonzero(np.isin(places.node, np.array(sorted(nodes), np.int64)))
    found: dict[int, list[tuple[float, int, LightRow]]] = defaultdict(list)
    for row in rows.tolist():
        node, road, s = int(places.node[row]), int(places.road[row]), float(places.s[row])
        off = max(-s, s - world.lanes.length(road), 0.0) if road >= 0 else np.inf
        along = _along(world, node, int(places.street[row]))
        found[node].append((off, row, LightRow(road, s, int(places.junction[row]), along)))
    return {node: [item[2] for item in sorted(items, key=lambda item: item[:2])] for node, items in found.items()}


def _along(world: World, node: int, street: int) -> bool | None:
    """Return whether a node's lights are for traffic along their street; roads run as their streets do."""
    meant = world.network.node_facts.controls[node].facing.along
    if meant is None:
        return None
    found = world.network.streets[street]
    place = int(np.flatnonzero(found.node_ids == node)[0])
    attributes = found.attributes_at(place)
    return meant != attributes.reversed
