"""Corrections of junctions: which nodes users join to one, and which they keep apart."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import BoolArray, IntArray, StreetNetwork, applied, unused


@dataclass(slots=True)
class CorrectedNodes:
    """What is known of the nodes of junctions, by index of intersections."""

    joined: BoolArray  # (streets,) Streets between nodes that make one junction
    # Nodes whose junctions have no other node, or (with some) not these
    alone: set[int] = field(default_factory=set)
    apart: dict[int, set[int]] = field(default_factory=dict)
    kept_apart: set[int] = field(default_factory=set)  # Nodes of the last two that would be joined with such a node

    def forbid(self, one: list[int], other: list[int]) -> bool:
        """Say whether two groups of nodes must not become one, and remember because of which nodes."""
        if not self.alone and not self.apart:
            return False
        found = {
            node
            for mine, theirs in ((one, other), (other, one))
            for node in mine
            if node in self.alone or not self.apart.get(node, set()).isdisjoint(theirs)
        }
        self.kept_apart |= found
        return bool(found)


def read_node_corrections(network: StreetNetwork, ends: StreetEnds) -> CorrectedNodes:
    """Find the intersections and streets that corrections of junctions are about."""
    out = CorrectedNodes(np.zeros(len(network.streets), bool))
    known = network.corrections.nodes
    if not known:
        return out
    index = _indices(network)
    a, b = ends.node[0::2], ends.node[1::2]
    for number, item in known.items():
        node = index.get(number)
        if node is None:
            continue
        if item.join:
            together = np.array([node, *(index[other] for other in item.join if other in index)], np.int64)
            out.joined |= np.isin(a, together) & np.isin(b, together)
        if item.split_all:
            out.alone.add(node)
        elif item.split:
            out.apart[node] = {index[other] for other in item.split if other in index}
    return out


def report_node_corrections(
    network: StreetNetwork, corrected: CorrectedNodes, group: IntArray, diagnostics: Diagnostics
) -> None:
    """Report the corrections of junctions; `group` (nodes,) is the junction of each node, -1 for none."""
    index = _indices(network) if network.corrections.nodes else {}
    for number, item in sorted(network.corrections.nodes.items()):
        osm_id = f"node/{number}"
        if item.join:
            missing = _not_joined(number, item.join, index, group)
            if missing:
                unused(diagnostics, osm_id, "join", missing)
            else:
                applied(diagnostics, osm_id, "join", f"one junction with {_listed(item.join)}")
        if item.split or item.split_all:
            if index.get(number) in corrected.kept_apart:
                what = _listed(item.split) if item.split else "all others"
                applied(diagnostics, osm_id, "split", f"kept apart from {what}")
            else:
                why = "no junction is at it" if _group(number, index, group) < 0 else "nothing would join it"
                unused(diagnostics, osm_id, "split", why)


def _indices(network: StreetNetwork) -> dict[int, int]:
    """Return the index of each intersection by its OSM id."""
    return {item.osm_node_id: item.id for item in network.intersections}


def _group(number: int, index: dict[int, int], group: IntArray) -> int:
    return int(group[index[number]]) if number in index else -1


def _not_joined(number: int, others: tuple[int, ...], index: dict[int, int], group: IntArray) -> str:
    """Return why some nodes are not one junction; empty if they are."""
    for node in (number, *others):
        if _group(node, index, group) < 0:
            return f"no streets meet at node/{node}"
    for node in others:
        if group[index[node]] != group[index[number]]:
            return f"no street leads from the others to node/{node}"
    return ""


def _listed(nodes: tuple[int, ...]) -> str:
    return ", ".join(f"node/{node}" for node in nodes)
