"""Which nodes make one junction, and where its arms end."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from osm2xodr.geometry.defaults import ARM_REACH_MOTORWAY, SHORTEST_ROAD, SHORTEST_STREET_BETWEEN_JUNCTIONS
from osm2xodr.geometry.junctions import defaults
from osm2xodr.geometry.junctions.arm_trims import footprints
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import BoolArray, FloatArray, IntArray, StreetNetwork

# How far along its arms a junction may reach where a street turns on the spot, m; there they lie on each other.
_ARM_REACH_TURN: Final = 12.0
# A ring without any junction that is shorter than this, m, is a point that somebody drew as a line: the circle whose
# radius a turning lane has at least (CONNECTING_RADIUS), rounded down.
_SHORTEST_RING: Final = 18.0
# Streets shorter than this that a turn restriction runs over (via way) become part of a junction.
_RESTRICTED_STREET: Final = 30.0
# Streets across a median, from one carriageway to the other of the same road, are at most so long, m; within the
# angle of this cosine (37 degrees) the carriageways run opposite ways, and square to the street.
_MEDIAN_CROSSING: Final = 40.0
_CARRIAGEWAYS_COSINE: Final = 0.8
# Bridges and tunnels shorter than this, m, may lie within a junction: less than two carriageways pass beneath them.
_SHORTEST_BRIDGE: Final = 8.0

_ROUNDS = 8
# What both ends of a road may lose where they are moved onto borders of its lines and arcs, m.
_SNAPPED = 0.02


@dataclass(frozen=True, slots=True, eq=False)
class JunctionLayout:
    """Junctions and what is left of the streets between them."""

    arms: tuple[tuple[int, ...], ...]  # Street ends of each junction, in ascending order
    nodes: tuple[tuple[int, ...], ...]  # Intersections of each junction
    junction: IntArray  # (ends,) Junction that each street end belongs to, -1 for none (dead ends, inner streets)
    # (streets,) Streets that lie wholly inside a junction, and dead ends and rings too short to be roads
    inner: BoolArray
    trim: FloatArray  # (ends,) How much of its street each end gives to its junction, m
    squeezed: BoolArray  # (streets,) Streets too short for what their junctions need


def lay_out_junctions(network: StreetNetwork, ends: StreetEnds) -> JunctionLayout:
    """Find the junctions: nodes where streets meet, joined where the streets between them have no room.

    Each round measures how much of its arms every junction needs and joins two junctions where that leaves less
    than `SHORTEST_STREET_BETWEEN_JUNCTIONS` of a street between them, until nothing changes. Of a street across a
    median rounded corners count as needed, too. What is shorter than a road may be never remains one.
    """
    xy = np.array([(node.x, node.y) for node in network.intersections]).reshape(-1, 2)
    degree = np.bincount(ends.node[ends.node >= 0], minlength=len(xy))
    # Two arms alone are an intersection only where the street could not simply run on (a turn on the spot).
    is_junction = degree >= 2
    on_the_spot = (ends.node >= 0) & (np.append(degree, 0)[ends.node] == 2)
    # Where it cannot turn, or will not at speed, its ends are to lie apart.
    on_the_spot &= ~_without_a_turn(ends) & (ends.reach < ARM_REACH_MOTORWAY)
    ends = replace(ends, reach=np.where(on_the_spot, _ARM_REACH_TURN, ends.reach))
    group = np.where(is_junction, np.arange(len(xy)), -1)
    mergeable = _mergeable(ends)
    a, b = ends.node[0::2], ends.node[1::2]
    between = (a >= 0) & (b >= 0)
    between[between] &= is_junction[a[between]] & is_junction[b[between]]
    tiny = ends.length[0::2] < np.where(a < 0, _SHORTEST_RING, SHORTEST_ROAD)
    inner = tiny & ~between
    ring = ends.roundabout[0::2] & ends.roundabout[1::2]
    via = _restricted(network, ends)
    median = _between_carriageways(network, ends)
    needed = np.where(ring, 0.0, SHORTEST_STREET_BETWEEN_JUNCTIONS)
    bare = wished = np.zeros(len(ends.length))
    members = {node: [node] for node in np.flatnonzero(is_junction).tolist()}
    low, high = xy.copy(), xy.copy()
    stale: set[int] | None = None
    for _ in range(_ROUNDS):
        arms = _arms(ends, group, inner)
        chosen = arms if stale is None else {g: arms[g] for g in sorted(stale) if g in arms}
        new_bare, new_wished = footprints(ends, list(chosen.values()))
        touched = np.array([end for group_arms in chosen.values() for end in group_arms], np.int64)
        bare, wished = bare.copy(), wished.copy()
        bare[touched], wished[touched] = new_bare[touched], new_wished[touched]
        left_over = ends.length[0::2] - bare[0::2] - bare[1::2]
        left_with_corners = ends.length[0::2] - wished[0::2] - wished[1::2]
        left_over = np.where(median, left_with_corners, left_over)
        tight = between & ~inner & ((mergeable & (left_over < needed)) | via | tiny)
        stale = set()
        for street in np.flatnonzero(tight)[np.argsort(left_over[tight], kind="stable")].tolist():
            one, other = int(group[a[street]]), int(group[b[street]])
            if one != other:
                one, other = min(one, other), max(one, other)
                lower, upper = np.minimum(low[one], low[other]), np.maximum(high[one], high[other])
                if (upper - lower).max() > defaults.JUNCTION_EXTENT and not tiny[street]:
                    continue
                low[one], high[one] = lower, upper
                group[members[other]] = one
                members[one] += members.pop(other)
                stale -= {other}
            inner[street] = True
            stale.add(int(group[a[street]]))
        if not stale:
            break
    return _settle(ends, group, inner, bare, wished)


def _without_a_turn(ends: StreetEnds) -> BoolArray:
    """Say which ends lie at nodes into which, or out of which, none leads: nobody turns there, (ends,)."""
    at = np.flatnonzero(ends.node >= 0)
    node = ends.node[at]
    nodes = int(node.max(initial=-1)) + 1
    ways_in = np.bincount(node, ends.enters[at], nodes)
    ways_out = np.bincount(node, ends.leaves[at], nodes)
    out = np.zeros(len(ends.node), bool)
    out[at] = np.minimum(ways_in, ways_out)[node] == 0
    return out


def _mergeable(ends: StreetEnds) -> BoolArray:
    """Say which streets may become part of a junction: not bridges and tunnels."""
    kept = ends.raised | (ends.layer != 0)
    very_short = ends.length[0::2] < _SHORTEST_BRIDGE
    out: BoolArray = ~(kept[0::2] | kept[1::2]) | very_short
    return out


def _between_carriageways(network: StreetNetwork, ends: StreetEnds) -> BoolArray:
    """Say which streets lead across a median: from a one-way carriageway to that of the other direction."""
    out = np.zeros(len(network.streets), bool)
    at: dict[int, list[tuple[float, str]]] = {}
    one_way = ends.enters != ends.leaves
    flow = np.where(ends.leaves, ends.hdg, ends.hdg + np.pi)
    for end in np.flatnonzero(one_way & (ends.node >= 0) & ~ends.roundabout).tolist():
        attributes = network.streets[end // 2].pieces[-(end % 2)][1]
        at.setdefault(int(ends.node[end]), []).append(
            (float(flow[end]), attributes.name or attributes.ref or attributes.highway)
        )
    short = (ends.length[0::2] < _MEDIAN_CROSSING) & (ends.node[0::2] >= 0) & (ends.node[1::2] >= 0)
    # The two halves of a roundabout's arm are no carriageways that the ring crosses.
    short &= ~(ends.roundabout[0::2] & ends.roundabout[1::2])
    for street in np.flatnonzero(short).tolist():
        across = float(ends.hdg[2 * street])
        out[street] = any(
            name == other
            and np.cos(one - two) < -_CARRIAGEWAYS_COSINE
            and abs(np.sin(one - across)) > _CARRIAGEWAYS_COSINE
            for one, name in at.get(int(ends.node[2 * street]), ())
            for two, other in at.get(int(ends.node[2 * street + 1]), ())
        )
    return out


def _restricted(network: StreetNetwork, ends: StreetEnds) -> BoolArray:
    """Say which streets a turn restriction runs over: only inside a junction can lane links state it."""
    via = {way for item in network.restrictions for way in item.via_ways}
    out = np.zeros(len(network.streets), bool)
    if via:
        for street in network.streets:
            out[street.id] = all(attributes.osm_way_id in via for _, attributes in street.pieces)
    out &= ends.length[0::2] < _RESTRICTED_STREET
    return out


def _arms(ends: StreetEnds, group: IntArray, inner: BoolArray) -> dict[int, list[int]]:
    arms: dict[int, list[int]] = {}
    outer = np.flatnonzero((ends.node >= 0) & ~np.repeat(inner, 2))
    for end, g in zip(outer.tolist(), group[ends.node[outer]].tolist(), strict=True):
        if g >= 0:
            arms.setdefault(g, []).append(end)
    return arms


def _settle(
    ends: StreetEnds, group: IntArray, inner: BoolArray, bare: FloatArray, wished: FloatArray
) -> JunctionLayout:
    """Give junctions numbers, and share out the streets that are too short for what is wished."""
    arms = _arms(ends, group, inner)
    junction = np.full(len(ends.length), -1, np.int64)
    nodes: dict[int, list[int]] = {}
    for node, g in enumerate(group.tolist()):
        if g >= 0:
            nodes.setdefault(g, []).append(node)
    order = sorted(arms)
    for number, g in enumerate(order):
        junction[arms[g]] = number
    bare = np.where(junction >= 0, bare, 0.0)
    wished = np.where(junction >= 0, wished, 0.0)
    # Corners must not take so much that a road is left which readers with steps of metres pass over. Between the arms
    # of a small roundabout there is no more room than that.
    ring = ends.roundabout[0::2] & ends.roundabout[1::2]
    least = np.where(ring, SHORTEST_ROAD + _SNAPPED, 2 * SHORTEST_ROAD)
    trim, squeezed = _share_streets(ends.length[0::2], bare.reshape(-1, 2), wished.reshape(-1, 2), least)
    return JunctionLayout(
        arms=tuple(tuple(arms[g]) for g in order),
        nodes=tuple(tuple(nodes[g]) for g in order),
        junction=junction,
        inner=inner,
        trim=trim.ravel(),
        squeezed=squeezed & ~inner,
    )


def _share_streets(
    length: FloatArray, bare: FloatArray, wished: FloatArray, least: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return what both ends of each street give, (streets, 2), m: kerbs go first, then what is bare.

    Kerbs leave at least `least` of a street, (streets,), m.
    """
    room = np.maximum(length - SHORTEST_ROAD - _SNAPPED, 0.5 * length)
    need, wish = bare.sum(1), wished.sum(1)
    spare = length - least - need
    extra = np.clip(spare / np.maximum(wish - need, 1e-9), 0.0, 1.0)
    scale = np.minimum(1.0, room / np.maximum(need, 1e-9))
    trim: FloatArray = bare * scale[:, None] + (wished - bare) * np.where(scale < 1, 0.0, extra)[:, None]
    return trim, need > room
