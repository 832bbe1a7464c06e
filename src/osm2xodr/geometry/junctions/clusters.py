"""Which nodes make one junction, and where its arms end.

Corrections say which nodes users join to one, and which they keep apart.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import repeated, running_lengths
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.defaults import (
    ARM_REACH_MOTORWAY,
    SHORTEST_ROAD,
    SHORTEST_STREET,
    SHORTEST_STREET_BETWEEN_JUNCTIONS,
    SNAPPED,
)
from osm2xodr.geometry.junctions import defaults
from osm2xodr.geometry.junctions.arm_trims import footprints
from osm2xodr.geometry.junctions.short_streets import between_carriageways, restricted, streets_without_room
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import BoolArray, FloatArray, IntArray, StreetNetwork, applied, unused
from osm2xodr.system import record

# How far along its arms a junction may reach where a street turns on the spot, m: there they lie on each other. A
# choice.
_ARM_REACH_TURN: Final = 12.0
# A ring without any junction that is shorter than this, m, is a point drawn as a line: the circle with the smallest
# radius of a turning lane (CONNECTING_RADIUS), rounded down.
_SHORTEST_RING: Final = 18.0
# Dead ends longer than this, m, are streets though little of them lies outside of their junction: half of a wide
# carriageway at a slant, and a car. Streets that part at a small angle lie on each other for longer. A choice.
_LONGEST_STUB: Final = 15.0
# Bridges and tunnels shorter than this, m, may lie within a junction: less than two carriageways pass beneath them.
_SHORTEST_BRIDGE: Final = 8.0
# Junctions are measured and joined at most this many times. A choice.
_MOST_ROUNDS: Final = 8
# Setbacks of arms leave at least this much of a street before a bridge or tunnel, m. A choice.
_RAMP: Final = 4.0
# A road gets at least this share of a street that is shorter than twice that.
_LEAST_ROAD_SHARE: Final = 0.5


@record(eq=False)
class JunctionLayout:
    """Junctions, and what they take of the streets between them."""

    arms: tuple[tuple[int, ...], ...]  # Street ends of each junction, in ascending order
    nodes: tuple[tuple[int, ...], ...]  # Intersections of each junction
    junction: IntArray  # (ends,) Junction that each street end belongs to, -1 for none (dead ends, inner streets)
    # (streets,) Whether a street lies wholly inside a junction, or is a dead end or ring too short to be a road
    inner: BoolArray
    trim: FloatArray  # (ends,) How much of its street each end gives to its junction, m
    most: FloatArray  # (ends,) How much it may give at most, so that both ends together leave a street, m
    squeezed: BoolArray  # (streets,) Whether a street is too short for what its junctions need
    least: FloatArray  # (streets,) How much of a street must be left, m


def lay_out_junctions(
    network: StreetNetwork, ends: StreetEnds, diagnostics: Diagnostics, jobs: int = 1
) -> JunctionLayout:
    """Find the junctions, by so many processes: nodes where streets meet, joined where streets have no room.

    Short dead ends of which junctions leave less than `SHORTEST_STREET` are left out.

    Each round measures how much of its arms every junction needs and joins two junctions where that leaves less than
    `SHORTEST_STREET` of a street between them, until nothing changes; less than `SHORTEST_STREET_BETWEEN_JUNCTIONS`
    where that does no harm. Of a street across a median, rounded corners count as needed, too. Streets shorter than
    any road always become part of a junction. Corrections join nodes, and keep them apart; `diagnostics` gets these.
    """
    xy = np.array([(node.x, node.y) for node in network.intersections]).reshape(-1, 2)
    degree = np.bincount(ends.node[ends.node >= 0], minlength=len(xy))
    is_junction = degree >= 2
    ends = _with_short_reach_at_turns(ends, degree)
    length = ends.length[0::2]
    a, b = ends.node[0::2], ends.node[1::2]
    between = (a >= 0) & (b >= 0)
    between[between] &= is_junction[a[between]] & is_junction[b[between]]
    # No node of a ring is a junction.
    at_junction = np.append(is_junction, False)
    dead_end = at_junction[a] != at_junction[b]
    tiny = length < np.where(a < 0, _SHORTEST_RING, SHORTEST_ROAD)
    via, median = restricted(network, ends), between_carriageways(network, ends)
    # Bridges and tunnels stay, unless they are very short, or all around is on one deck or in one tunnel.
    kept = ends.raised | (ends.layer != 0)
    mergeable = ~(kept[0::2] | kept[1::2]) | (length < _SHORTEST_BRIDGE) | _on_one_structure(ends)
    needed = np.where(_on_ring(ends), 0.0, SHORTEST_STREET)
    corrected = read_node_corrections(network, ends)
    stub = dead_end & (length < _LONGEST_STUB)
    clusters = _Clusters(xy, is_junction, tiny & ~between, corrected)
    bare, wished = np.zeros(len(ends.length)), np.zeros(len(ends.length))
    changed: set[int] | None = None
    for _ in range(_MOST_ROUNDS):
        arms = clusters.arms(ends)
        measured = list(arms.values()) if changed is None else [arms[g] for g in sorted(changed) if g in arms]
        touched = np.array([end for group_arms in measured for end in group_arms], np.int64)
        found = footprints(ends, measured, jobs)
        bare[touched], wished[touched] = found[0][touched], found[1][touched]
        taken = np.where(np.repeat(median, 2), wished, bare)
        left = length - taken[0::2] - taken[1::2]
        outer = between & ~clusters.inner
        tight = outer & ((mergeable & (left < needed)) | via | tiny | corrected.joined)
        short = mergeable & ~median & streets_without_room(network, ends, outer, left, wished, clusters.group)
        extent = np.where(tight, defaults.JUNCTION_EXTENT, defaults.JUNCTION_EXTENT_SHORT)
        order = np.flatnonzero(tight | short)
        order = order[np.argsort(np.where(corrected.joined, -np.inf, left)[order], kind="stable")]
        changed = clusters.join(order, a, b, np.where(tiny | corrected.joined, np.inf, extent))
        changed |= clusters.leave_out(np.flatnonzero(stub & ~clusters.inner & (left < SHORTEST_STREET)), a, b)
        if not changed:
            break
    report_node_corrections(network, corrected, clusters.group, diagnostics)
    return _settle(ends, clusters, bare, wished, _same_layer(network, ends), _furnished(network))


class _Clusters:
    """Nodes that make one junction: each group has the number of its first node."""

    def __init__(self, xy: FloatArray, is_junction: BoolArray, inner: BoolArray, corrected: CorrectedNodes) -> None:
        self.group = np.where(is_junction, np.arange(len(xy)), -1)  # (nodes,) -1 for nodes of no junction
        self.inner = inner  # (streets,) Streets that lie inside a junction
        self._members = {node: [node] for node in np.flatnonzero(is_junction).tolist()}
        self._low, self._high = xy.copy(), xy.copy()
        self._corrected = corrected

    def join(self, streets: IntArray, start: IntArray, end: IntArray, extent: FloatArray) -> set[int]:
        """Join the groups at both ends of streets, in this order, and return the groups that have changed.

        No group grows over a street beyond the street's `extent` (streets,), m, nor against a correction; streets of
        infinite extent join groups in any case.
        """
        group, low, high = self.group, self._low, self._high
        changed: set[int] = set()
        for street in streets.tolist():
            one, other = sorted((int(group[start[street]]), int(group[end[street]])))
            if one != other:
                lower, upper = np.minimum(low[one], low[other]), np.maximum(high[one], high[other])
                if (upper - lower).max() > extent[street]:
                    continue
                if extent[street] < np.inf and self._corrected.forbid(self._members[one], self._members[other]):
                    continue
                low[one], high[one] = lower, upper
                group[self._members[other]] = one
                self._members[one] += self._members.pop(other)
                changed.discard(other)
            self.inner[street] = True
            changed.add(one)
        return changed

    def leave_out(self, streets: IntArray, start: IntArray, end: IntArray) -> set[int]:
        """Leave out dead ends, and return the groups that have changed."""
        self.inner[streets] = True
        return set(np.maximum(self.group[start[streets]], self.group[end[streets]]).tolist())

    def arms(self, ends: StreetEnds) -> dict[int, list[int]]:
        """Return the street ends of each group, in ascending order."""
        arms: dict[int, list[int]] = {}
        outer = np.flatnonzero((ends.node >= 0) & ~np.repeat(self.inner, 2))
        for end, group in zip(outer.tolist(), self.group[ends.node[outer]].tolist(), strict=True):
            if group >= 0:
                arms.setdefault(group, []).append(end)
        return arms


def _with_short_reach_at_turns(ends: StreetEnds, degree: IntArray) -> StreetEnds:
    """Let arms reach less far where a street turns on the spot: there are two of them, and they lie on each other.

    Where nobody can turn, or nobody would at speed, they keep their reach, so that their roads end apart.
    """
    on_the_spot = (ends.node >= 0) & (np.append(degree, 0)[ends.node] == 2)
    on_the_spot &= ~_without_a_turn(ends) & (ends.reach < ARM_REACH_MOTORWAY)
    return replace(ends, reach=np.where(on_the_spot, _ARM_REACH_TURN, ends.reach))


def _on_one_structure(ends: StreetEnds) -> BoolArray:
    """Say which streets lie on a bridge or in a tunnel as all arms of the nodes at both ends do, (streets,).

    Not those of roundabouts: their arms come from different heights.
    """
    on = ends.raised
    at = np.flatnonzero(ends.node >= 0)
    # The last one stands for ends without a node.
    off = np.ones(int(ends.node.max(initial=-1)) + 2, bool)
    off[ends.node[at]] = False
    off[ends.node[at[~on[at]]]] = True
    # Levels above each other meet nowhere.
    layer = ends.layer.reshape(-1, 2)
    out: BoolArray = ~off[ends.node].reshape(-1, 2).any(1) & (layer[:, 0] == layer[:, 1]) & ~_on_ring(ends)
    return out


def _on_ring(ends: StreetEnds) -> BoolArray:
    """Say which streets are part of a roundabout, (streets,)."""
    return ends.roundabout[0::2] & ends.roundabout[1::2]


def _without_a_turn(ends: StreetEnds) -> BoolArray:
    """Say which ends lie at nodes that no street leads into, or none out of: nobody turns there, (ends,)."""
    at = np.flatnonzero(ends.node >= 0)
    node = ends.node[at]
    nodes = int(node.max(initial=-1)) + 1
    ways_in = np.bincount(node, ends.enters[at], nodes)
    ways_out = np.bincount(node, ends.leaves[at], nodes)
    out = np.zeros(len(ends.node), bool)
    out[at] = np.minimum(ways_in, ways_out)[node] == 0
    return out


def _settle(
    ends: StreetEnds,
    clusters: _Clusters,
    bare: FloatArray,
    wished: FloatArray,
    same_layer: FloatArray,
    furnished: BoolArray,
) -> JunctionLayout:
    """Give junctions numbers, and share out the streets that are too short for what is wished.

    What is given beyond that reaches no farther than `same_layer` (ends,), m.
    """
    arms = clusters.arms(ends)
    junction = np.full(len(ends.length), -1, np.int64)
    nodes: dict[int, list[int]] = {}
    for node, group in enumerate(clusters.group.tolist()):
        if group >= 0:
            nodes.setdefault(group, []).append(node)
    order = sorted(arms)
    for number, group in enumerate(order):
        junction[arms[group]] = number
    bare, wished = (np.where(junction >= 0, needed, 0.0) for needed in (bare, wished))
    between = (junction.reshape(-1, 2) >= 0).all(1)
    # Nobody drives through a dead end: without lights or a crossing it may be shorter.
    least = np.where(between | furnished, SHORTEST_STREET, SHORTEST_ROAD)
    # Corners must leave a road, and room for a car between junctions. Between the arms of a small roundabout there is
    # room for less.
    kept = np.where(between, SHORTEST_STREET_BETWEEN_JUNCTIONS, least) + SNAPPED
    length = ends.length[0::2]
    at_corners = np.where(_on_ring(ends), SHORTEST_STREET + SNAPPED, kept)
    trim, squeezed = _share_streets(length, bare.reshape(-1, 2), wished.reshape(-1, 2), at_corners)
    squeezed |= between & (length - trim.sum(1) < SHORTEST_STREET_BETWEEN_JUNCTIONS)
    share = np.where(between, 0.5, 1.0)
    most = trim + (share * np.maximum(length - trim.sum(1) - kept, 0.0))[:, None]
    return JunctionLayout(
        arms=tuple(tuple(arms[group]) for group in order),
        nodes=tuple(tuple(nodes[group]) for group in order),
        junction=junction,
        inner=clusters.inner,
        trim=trim.ravel(),
        most=np.maximum(trim.ravel(), np.minimum(most.ravel(), same_layer)),
        squeezed=squeezed & ~clusters.inner,
        least=least,
    )


def _furnished(network: StreetNetwork) -> BoolArray:
    """Say on which streets, ends included, are lights, signs or crossings for people, which need room, (streets,)."""
    facts = network.node_facts
    nodes = np.array(sorted({*facts.controls, *(crossing.node for crossing in facts.crossings)}), np.int64)
    every = [street.node_ids for street in network.streets]
    street = repeated([len(ids) for ids in every])
    out = np.zeros(len(every), bool)
    out[street[np.isin(np.concatenate([np.zeros(0, np.int64), *every]), nodes)]] = True
    return out


def _same_layer(network: StreetNetwork, ends: StreetEnds) -> FloatArray:
    """Return how far along each end a junction may reach, so that its street can still change its layer, (ends,), m.

    A junction that took the ramp of a bridge or tunnel would bring that to the height of what lies below or above.
    """
    out = np.full(len(ends.length), np.inf)
    for k, street in enumerate(network.streets):
        layers = [attributes.layer for _, attributes in street.pieces]
        changes = [
            first for (first, _), (one, two) in zip(street.pieces[1:], pairwise(layers), strict=True) if one != two
        ]
        if changes:
            chainage = running_lengths(street.points)
            room = np.array([chainage[changes[0]], chainage[-1] - chainage[changes[-1]]])
            out[2 * k : 2 * k + 2] = np.maximum(room - _RAMP, 0.0)
    return out


def _share_streets(
    length: FloatArray, bare: FloatArray, wished: FloatArray, least: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return what both ends of each street give, (streets, 2), m, and which streets give less than is needed.

    Of a street that is too short, kerbs are cut first, so that at least `least` of it is left, (streets,), m. Then
    what is needed is cut, so that at least `SHORTEST_STREET` is.
    """
    room = np.maximum(length - SHORTEST_STREET - SNAPPED, _LEAST_ROAD_SHARE * length)
    need, wish = bare.sum(1), wished.sum(1)
    extra = np.clip((length - least - need) / np.maximum(wish - need, 1e-9), 0.0, 1.0)
    scale = np.minimum(1.0, room / np.maximum(need, 1e-9))
    trim: FloatArray = bare * scale[:, None] + (wished - bare) * np.where(scale < 1, 0.0, extra)[:, None]
    return trim, need > room


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
