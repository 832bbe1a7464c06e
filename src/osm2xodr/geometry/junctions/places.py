"""Where streets and their tagged nodes are in the road map, for furniture to be placed by."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from osm2xodr.curves import lengths, project, repeated
from osm2xodr.geometry.junctions.clusters import JunctionLayout
from osm2xodr.geometry.junctions.road_parts import RoadParts
from osm2xodr.model import FloatArray, IntArray, StreetNetwork, StreetPlaces


def street_places(
    network: StreetNetwork,
    layout: JunctionLayout,
    parts: RoadParts,
    road_id: Callable[[int], int],
    junction_ids: IntArray,
) -> StreetPlaces:
    """Find where streets and their tagged nodes are in the road map.

    `road_id` gives the id of the k-th road; `junction_ids` (junctions + 1,) are those of the layout's junctions, -1
    for those that are not written; the last is -1.
    """
    end_road = np.array([road_id(end // 2) if end >= 0 else -1 for end in parts.road_end.tolist()], np.int64)
    of_node = np.full(len(network.intersections) + 1, -1, np.int64)
    for junction, nodes in enumerate(layout.nodes):
        of_node[list(nodes)] = junction_ids[junction]
    ends = np.array([node for street in network.streets for node in (street.start, street.end)], np.int64)
    end_junction = np.where(np.repeat(layout.inner, 2), of_node[ends], junction_ids[layout.junction])
    node, street, x, y = _tagged(network)
    road, s, t = _on_roads(parts, street, x, y)
    within = _junctions(parts, layout, end_junction, street, road, s)
    return StreetPlaces(
        road_street=parts.street,
        end_road=end_road,
        end_junction=end_junction,
        inner=layout.inner,
        node=node,
        street=street,
        road=np.array([road_id(k) if k >= 0 else -1 for k in road.tolist()], np.int64),
        s=s,
        t=t,
        junction=within,
    )


def _tagged(network: StreetNetwork) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """Return node, street, x and y of every place of a tagged node on a street."""
    count = [len(street.node_ids) for street in network.streets]
    nodes = np.concatenate([street.node_ids for street in network.streets])
    points = np.concatenate([street.points for street in network.streets])
    owner = repeated(count)
    rows = np.flatnonzero(np.isin(nodes, np.array(list(network.node_tags), np.int64)))
    return nodes[rows], owner[rows], points[rows, 0], points[rows, 1]


def _on_roads(
    parts: RoadParts, street: IntArray, x: FloatArray, y: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the index of the street's nearest road (-1 for none), s on it (or beyond its ends) and t, all (n,)."""
    on_street, t, _ = project(parts.fitted.plan_view, street, x, y)
    first = np.full(len(parts.fitted.pieces), -1, np.int64)
    second = first.copy()
    for k, owner in enumerate(parts.street.tolist()):
        (second if first[owner] >= 0 else first)[owner] = k
    road, other = first[street], second[street]
    begin, end = np.append(parts.begin, 0.0), np.append(parts.end, 0.0)

    def off(k: IntArray) -> FloatArray:
        return np.maximum(np.maximum(begin[k] - on_street, on_street - end[k]), 0.0)

    road = np.where((other >= 0) & (off(other) < off(road)), other, road)
    s = np.where(road >= 0, on_street - begin[road], np.nan)
    return road, s, np.where(road >= 0, t, np.nan)


def _junctions(
    parts: RoadParts, layout: JunctionLayout, end_junction: IntArray, street: IntArray, road: IntArray, s: FloatArray
) -> IntArray:
    """Return the junction that each place lies in, -1 for none."""
    length = np.append(lengths(parts.plan_view), 0.0)[road]
    out: IntArray = np.full(len(street), -1, np.int64)
    before, beyond = s < 0.0, s > length
    out[before] = end_junction[2 * street[before]]
    out[beyond] = end_junction[2 * street[beyond] + 1]
    inner = layout.inner[street]
    out[inner] = end_junction[2 * street[inner]]
    return out
