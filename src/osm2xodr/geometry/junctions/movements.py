"""From which arm of a junction one may drive to which: one-ways, restrictions, and lanes against one-way streets."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from typing import Final

import numpy as np

from osm2xodr.curves import wrapped
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.defaults import STRAIGHT_ON
from osm2xodr.geometry.junctions.clusters import JunctionLayout
from osm2xodr.geometry.lanes import Connectivity, StatedLanes
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import BoolArray, Direction, LaneType, Street, StreetNetwork, TurnRestriction
from osm2xodr.system import record

# A way through a junction over more inner streets than this is a detour. A choice.
_MOST_INNER_STREETS: Final = 8
# Streets inside a junction, with True where driven along their direction.
_Path = tuple[tuple[int, bool], ...]

# Types of lanes that lead on to each other: buses and taxis as their like, bicycles on their own.
_KINDS: Final = (frozenset({LaneType.BUS, LaneType.TAXI}), frozenset({LaneType.BIKING}))


@record
class Loop:
    """A loop at the end of a street, where cars turn round."""

    aside: float  # By how much its radius exceeds half of the distance between its lanes, m
    ease: float  # Radius of the curves between the outermost lane and the loop, m


@record
class Movement:
    """One way through a junction."""

    junction: int  # Its index
    # Street ends: traffic enters the junction from one and leaves it on the other
    entry: int
    exit: int
    inner: _Path  # What OSM's way through the junction follows
    stated: StatedLanes | None = None  # What connectivity relations say about its lanes
    # The types of lanes that alone lead there, against a one-way street; none where cars may go
    apart: frozenset[LaneType] = frozenset()
    u_turn: bool = False  # Whether it leads from one carriageway of a road to the opposite one
    loop: Loop | None = None  # The loop that it goes round where it comes back on the arm that it enters from


@dataclass(slots=True)
class _Rules:
    """Turn restrictions by from way and via node, or by from way where they lead over ways."""

    banned: dict[tuple[int, int], set[int]] = field(default_factory=dict)
    mandatory: dict[tuple[int, int], set[int]] = field(default_factory=dict)
    over_ways: dict[int, list[TurnRestriction]] = field(default_factory=dict)

    def allows(self, from_way: int, node: int, to_way: int) -> bool:
        """Say whether one may go on from one way to another at a node."""
        key = (from_way, node)
        if to_way in self.banned.get(key, ()):
            return False
        only = self.mandatory.get(key)
        return only is None or to_way in only

    def allows_path(self, ways: list[int]) -> bool:
        """Say whether restrictions via ways allow a sequence of ways."""
        for k, way in enumerate(ways):
            for rule in self.over_ways.get(way, ()):
                via = list(rule.via_ways)
                if ways[k + 1 : k + 1 + len(via)] != via or len(ways) <= k + 1 + len(via):
                    continue
                if (ways[k + 1 + len(via)] in rule.to_ways) != rule.only:
                    return False
        return True


def find_movements(
    network: StreetNetwork, ends: StreetEnds, layout: JunctionLayout, diagnostics: Diagnostics
) -> list[Movement]:
    """List all movements through all junctions, by junction, entry and exit.

    U-turns onto the street that one comes from are left out. `diagnostics` gets restrictions that lane links cannot
    state, and entries from which no way leads on.
    """
    rules = _rules(network, layout, diagnostics)
    osm_node = [node.osm_node_id for node in network.intersections]
    inner_at = inner_streets(network, ends, layout)
    found: list[Movement] = []
    for junction, arms in enumerate(layout.arms):
        exits_at: dict[int, list[int]] = {}
        for end in arms:
            if ends.leaves[end]:
                exits_at.setdefault(int(ends.node[end]), []).append(end)
        for entry in arms:
            if ends.enters[entry]:
                ways_out = _ways_out(entry, network.streets, ends, osm_node, inner_at, exits_at, rules)
                if not ways_out and any(exit_ != entry for there in exits_at.values() for exit_ in there):
                    node = osm_node[ends.node[entry]]
                    text = f"restrictions or one-way streets leave no way on from it at node/{node}"
                    diagnostics.note("no-way-on", f"way/{_way_at(network.streets, entry)}", text)
                found += [Movement(junction, entry, exit_, path) for exit_, path in sorted(ways_out.items())]
    known = Connectivity.of(network.connectivities)
    return [replace(item, stated=_stated(item, network, osm_node, known)) for item in found] if known else found


def inner_streets(
    network: StreetNetwork, ends: StreetEnds, layout: JunctionLayout, *, against_one_way: bool = False
) -> dict[int, list[tuple[int, bool]]]:
    """Return the inner streets that one may drive from each node, with True where along their direction.

    With `against_one_way` these are all.
    """
    out: dict[int, list[tuple[int, bool]]] = {}
    for street in np.flatnonzero(layout.inner).tolist():
        for node, end in ((network.streets[street].start, 2 * street), (network.streets[street].end, 2 * street + 1)):
            if against_one_way or ends.leaves[end]:
                out.setdefault(node, []).append((street, end % 2 == 0))
    return out


def _stated(item: Movement, network: StreetNetwork, osm_node: list[int], known: Connectivity) -> StatedLanes | None:
    """Return what relations say about the lanes of a movement."""
    streets = network.streets
    ways = [_way_at(streets, item.entry)]
    nodes: list[int] = []
    first = streets[item.entry // 2]
    node = osm_node[first.end if item.entry % 2 else first.start]
    passed: list[tuple[int, int]] = []
    for number, along in item.inner:
        street = streets[number]
        borders = [int(street.node_ids[index]) for index, _ in street.pieces[1:]]
        at = [node, *(borders if along else borders[::-1])]
        passed += zip(at, _ways_of(street, along), strict=True)
        node = osm_node[street.end if along else street.start]
    for at_node, way in [*passed, (node, _way_at(streets, item.exit))]:
        if way != ways[-1]:
            ways.append(way)
            nodes.append(at_node)
    return known.along(ways, nodes)


def unrestricted_path(
    network: StreetNetwork, ends: StreetEnds, inner_at: dict[int, list[tuple[int, bool]]], entry: int, exit_: int
) -> _Path | None:
    """Return the shortest path over `inner_at` from one arm to another, restrictions aside; None if there is none."""
    # Without rules it does not matter which nodes these are.
    nodes = range(len(network.intersections))
    exits_at = {int(ends.node[exit_]): [exit_]}
    return _ways_out(entry, network.streets, ends, nodes, inner_at, exits_at, _Rules()).get(exit_)


def _ways_out(
    entry: int,
    streets: tuple[Street, ...],
    ends: StreetEnds,
    osm_node: Sequence[int],
    inner_at: dict[int, list[tuple[int, bool]]],
    exits_at: dict[int, list[int]],
    rules: _Rules,
) -> dict[int, _Path]:
    """Return the shortest inner path from an entry to each exit that it may reach; first of equal ones by number."""
    best: dict[int, tuple[float, _Path]] = {}
    first_way = _way_at(streets, entry)
    stack: list[tuple[int, list[int], _Path, float]] = [(int(ends.node[entry]), [first_way], (), 0.0)]
    while stack:
        node, ways, path, run = stack.pop()
        here = osm_node[node]
        for exit_ in exits_at.get(node, ()):
            way = _way_at(streets, exit_)
            if exit_ != entry and (exit_ not in best or (run, path) < best[exit_]):
                whole = [number for number, _ in groupby([*ways, way])]
                if rules.allows(ways[-1], here, way) and rules.allows_path(whole):
                    best[exit_] = (run, path)
        if len(path) >= _MOST_INNER_STREETS:
            continue
        for street, along in inner_at.get(node, ()):
            near = 2 * street + (0 if along else 1)
            seen = any(street == passed for passed, _ in path)
            if not seen and rules.allows(ways[-1], here, _way_at(streets, near)):
                passed_ways = [*ways, *_ways_of(streets[street], along)]
                length = run + float(ends.length[near])
                stack.append((int(ends.node[near ^ 1]), passed_ways, (*path, (street, along)), length))
    return {exit_: path for exit_, (_, path) in best.items()}


def _way_at(streets: tuple[Street, ...], end: int) -> int:
    """Return the OSM way that a street end belongs to."""
    return streets[end // 2].attributes_at_end(end).osm_way_id


def _ways_of(street: Street, along: bool) -> Iterator[int]:
    pieces = street.pieces if along else street.pieces[::-1]
    return (attributes.osm_way_id for _, attributes in pieces)


def _rules(network: StreetNetwork, layout: JunctionLayout, diagnostics: Diagnostics) -> _Rules:
    """Return the turn restrictions, and report those that cannot be kept."""
    rules = _Rules()
    inner = (network.streets[street] for street in np.flatnonzero(layout.inner).tolist())
    inside = {attributes.osm_way_id for street in inner for _, attributes in street.pieces}
    for item in network.restrictions:
        for from_way in item.from_ways:
            if item.via_node is not None:
                table = rules.mandatory if item.only else rules.banned
                table.setdefault((from_way, item.via_node), set()).update(item.to_ways)
            else:
                rules.over_ways.setdefault(from_way, []).append(item)
        if item.via_ways and not inside.issuperset(item.via_ways):
            text = f"{item.value} runs over a way that is a road of its own here; lane links cannot state it"
            diagnostics.note("restriction-over-roads", f"relation/{item.osm_relation_id}", text)
    return rules


def with_movements_against_cars(
    network: StreetNetwork, ends: StreetEnds, layout: JunctionLayout, movements: list[Movement]
) -> list[Movement]:
    """Return the movements and those straight on from or to lanes set apart against one-way streets, by junction.

    From such a lane buses, taxis and bicycles go on to their like, else to lanes for cars; to such a lane they come
    from their like alone, so that no car gets there.
    """
    found: list[Movement] = []
    inner_at = inner_streets(network, ends, layout, against_one_way=True)
    for kind in _KINDS:
        into, out = _lanes_of_kind(network, kind)
        against_in, against_out = into & ~ends.enters, out & ~ends.leaves
        some = {int(layout.junction[end]) for end in np.flatnonzero(against_in | against_out).tolist()} - {-1}
        for junction in sorted(some):
            arms = np.array(layout.arms[junction])
            for entry in arms[into[arms]].tolist():
                turn = np.abs(wrapped(ends.hdg[arms] - ends.hdg[entry] - np.pi))
                open_ = (turn < STRAIGHT_ON) & (arms != entry)
                open_ &= (out | ends.leaves)[arms] if against_in[entry] else against_out[arms]
                if open_.any():
                    exit_ = int(arms[np.lexsort((turn, ~out[arms], ~open_))[0]])
                    path = unrestricted_path(network, ends, inner_at, entry, exit_)
                    if path is not None:
                        found.append(Movement(junction, entry, exit_, path, apart=kind))
    return sorted([*movements, *found], key=lambda item: item.junction) if found else movements


def _lanes_of_kind(network: StreetNetwork, kind: frozenset[LaneType]) -> tuple[BoolArray, BoolArray]:
    """Say at which street ends lanes of some types lead into the junction, and out of it, (ends,)."""
    into, out = np.zeros((2, 2 * len(network.streets)), bool)
    for street in network.streets:
        for end in (2 * street.id, 2 * street.id + 1):
            found = {lane.direction for lane in street.attributes_at_end(end).lanes_ltr if lane.type in kind}
            along, back = Direction.FORWARD in found, Direction.BACKWARD in found
            into[end], out[end] = (along, back) if end % 2 else (back, along)
    return into, out
