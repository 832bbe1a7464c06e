"""Who has the right of way at a junction: pairs of connecting roads that cross or merge.

What decides between two arms, in this order: signs (leaving a property counts as one), being on a roundabout,
``priority_road``, the class of the road. Where none does, priority to the right (or the rule of the country) needs no
record; at signals there is none either. At roundabouts inside a junction who goes round goes first. OpenDRIVE 1.6 and
1.7 want ``high`` and ``low`` of ``<priority>`` to be connecting roads, 1.8 roads of the junction, which these are.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby, permutations
from typing import Final

import numpy as np

from osm2xodr import defaults
from osm2xodr.conventions import Signs, ranks_at_junction, read_signs
from osm2xodr.curves import curves_cross, sine_cosine
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads
from osm2xodr.geometry.junctions import JunctionLayout, RoadParts
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import IntArray, Rule, Sign, StreetAttributes, StreetNetwork
from osm2xodr.system import record

# Carriageways of one road run side by side if their headings differ by less than this, as a sine (23 degrees).
_ABREAST: Final = 0.39

_COUNTS: Final = ("junctions_with_signals", "all_way_stops", "junctions_with_priorities", "roundabout_entries")


@record
class Arm:
    """What decides about the right of way of a street end that enters a junction."""

    ring: bool  # Whether it is part of a roundabout
    sign: Sign | None  # The sign that its traffic meets
    priority_road: bool  # Whether it is tagged as one
    rank: int  # Of its class, see `PRIORITY_RANK`

    @property
    def yields(self) -> bool:
        """Say whether a sign makes its traffic yield."""
        return self.sign in (Sign.STOP, Sign.GIVE_WAY)


@record(eq=False)
class Priorities:
    """Right of way."""

    # (n,) Connecting roads of pairs that cross or merge: the one that goes first, the one that yields
    high: IntArray
    low: IntArray
    # (n,) How many streets, but accesses of properties, meet those connecting roads that run on before all others, -1
    # for those that do not
    passed: IntArray
    statistics: Mapping[str, float]  # What was counted


def find_priorities(
    network: StreetNetwork,
    ends: StreetEnds,
    layout: JunctionLayout,
    parts: RoadParts,
    connecting: ConnectingRoads,
) -> Priorities:
    """Find who has the right of way over whom at all junctions."""
    signs = _with_inner_signs(network, ends, layout, read_signs(network))
    inside, rings = _signalled_inside(network, layout, signs), _rings_inside(network, layout)
    high: list[int] = []
    low: list[int] = []
    counts = dict.fromkeys(_COUNTS, 0)
    used: set[int] = set()
    passed = np.full(len(connecting.length), -1, np.int64)
    exits = parts.street_end()[connecting.exit]
    for junction, rows in _rows_by_entry(parts, connecting):
        nodes = [network.intersections[node].osm_node_id for node in layout.nodes[junction]]
        ranks = ranks_at_junction(_attributes(network, end).highway for end in layout.arms[junction])
        every = {
            end: Arm(
                bool(ends.roundabout[end]), signs.before_end.get(end), _attributes(network, end).priority_road, rank
            )
            for end, rank in zip(layout.arms[junction], ranks, strict=True)
        }
        arms = {end: every[end] for end in rows}
        if junction in inside or signs.signalled(nodes, list(arms)):
            counts["junctions_with_signals"] += 1
            continue
        if signs.all_way & arms.keys() or not signs.all_way_nodes.isdisjoint(nodes):
            counts["all_way_stops"] += 1
            continue
        absorbed = junction in rings and not any(ends.roundabout[end] for end in layout.arms[junction])
        if absorbed or not network.node_facts.mini_roundabouts.isdisjoint(nodes):
            pairs = _round_the_middle(rows, connecting, parts, ends, network.rule)
            high += [one for one, _ in pairs]
            low += [other for _, other in pairs]
            counts["junctions_with_priorities"] += bool(pairs)
            continue
        before = {(a, b) for a, b in permutations(every, 2) if goes_first(every[a], every[b], ranks)}
        decided = [pair for pair in permutations(arms, 2) if pair in before]
        for a, b in decided:
            high += [i for i in rows[a] for _ in rows[b]]
            low += rows[b] * len(rows[a])
        used.update(end for _, end in decided if arms[end].yields)
        _count_passed(passed, rows, exits, every, before, ends)
        counts["junctions_with_priorities"] += bool(decided)
        counts["roundabout_entries"] += len({b for a, b in decided if arms[a].ring and not arms[b].ring})
    first, second = np.array(high, np.int64), np.array(low, np.int64)
    exit_, lane = connecting.exit, connecting.exit_lane
    merging = (exit_[first] == exit_[second]) & (lane[first] == lane[second])
    keep = merging | curves_cross(connecting.plan_view, first, second)
    statistics = {**counts, "signs_followed": len(used), "priorities": int(keep.sum())}
    return Priorities(first[keep], second[keep], passed, {name: float(count) for name, count in statistics.items()})


def _count_passed(
    passed: IntArray,
    rows: Mapping[int, Sequence[int]],
    exits: IntArray,
    arms: Mapping[int, Arm],
    before: Collection[tuple[int, int]],
    ends: StreetEnds,
) -> None:
    """Set how many streets meet the ways of a junction that go before all others.

    `exits` (n,) are their exits, `before` the pairs of arms of which one goes before the other.
    """
    for entry, group in rows.items():
        leaving = exits[group]
        for exit_ in dict.fromkeys(leaving.tolist()):
            # The carriageway of the other direction is no side street.
            sides = [end for end in arms if end not in (entry, exit_) and not _run_abreast(entry, end, ends)]
            if not arms[entry].ring and all((k, end) in before for k in (entry, exit_) for end in sides):
                minor = defaults.PRIORITY_RANK_MINOR
                passed[np.array(group)[leaving == exit_]] = sum(arms[end].rank > minor for end in sides)


def _run_abreast(one: int, other: int, ends: StreetEnds) -> bool:
    """Say whether two street ends are carriageways of one direction each that run side by side."""
    one_way = ends.enters[one] != ends.leaves[one] and ends.enters[other] != ends.leaves[other]
    return bool(one_way) and abs(sine_cosine(ends.hdg[other] - ends.hdg[one])[0]) < _ABREAST


def _rows_by_entry(parts: RoadParts, connecting: ConnectingRoads) -> Iterator[tuple[int, dict[int, list[int]]]]:
    """Yield each junction with its connecting roads by the street end that they enter from."""
    street_end = {road: end for end, road in enumerate(parts.road_end.tolist()) if road >= 0}
    entries = connecting.entry.tolist()
    for junction, group in groupby(range(len(entries)), key=connecting.junction.tolist().__getitem__):
        rows: dict[int, list[int]] = {}
        for k in group:
            rows.setdefault(street_end[entries[k]], []).append(k)
        yield junction, rows


def _round_the_middle(
    rows: Mapping[int, Sequence[int]], connecting: ConnectingRoads, parts: RoadParts, ends: StreetEnds, rule: Rule
) -> list[tuple[int, int]]:
    """Return pairs of ways through a roundabout that lies inside a junction: who passes before an entry goes first.

    Traffic goes round the middle, counter-clockwise where it keeps to the right. Of two that pass before each other's
    entries none goes first.
    """
    turn, street_end = 1.0 if rule is Rule.RIGHT_HAND else -1.0, parts.street_end()

    def round_to(end: int, start: int) -> float:
        # The way from an arm to itself leads all round.
        return float(turn * (ends.hdg[end] - ends.hdg[start]) % (2 * np.pi)) or 2 * np.pi

    def passes(row: int, start: int, entry: int) -> bool:
        return entry != start and round_to(entry, start) < round_to(int(street_end[connecting.exit[row]]), start)

    return [
        (one, other)
        for a, b in permutations(rows, 2)
        for one in rows[a]
        for other in rows[b]
        if passes(one, a, b) and not passes(other, b, a)
    ]


def _with_inner_signs(network: StreetNetwork, ends: StreetEnds, layout: JunctionLayout, signs: Signs) -> Signs:
    """Give signs on streets inside a junction to the arms from which one can only drive there."""
    before = dict(signs.before_end)
    for end, sign in signs.before_end.items():
        if not layout.inner[end // 2] or sign is Sign.SIGNALS:
            continue
        meeting = [2 * street + (not start) for street, start in network.intersections[int(ends.node[end ^ 1])].arms]
        for arm in meeting:
            onwards = [other for other in meeting if other != arm and ends.leaves[other]]
            if ends.enters[arm] and not layout.inner[arm // 2] and onwards == [end ^ 1]:
                before.setdefault(arm, sign)
    return replace(signs, before_end=before)


def _signalled_inside(network: StreetNetwork, layout: JunctionLayout, signs: Signs) -> set[int]:
    """Return the junctions with signals on a street inside them, as between the carriageways of a wide road."""
    ends = [end for end, sign in signs.before_end.items() if sign is Sign.SIGNALS and layout.inner[end // 2]]
    if not ends:
        return set()
    junction_of = {node: junction for junction, nodes in enumerate(layout.nodes) for node in nodes}
    streets = [network.streets[end // 2] for end in ends]
    return {junction_of[node] for street in streets for node in (street.start, street.end) if node in junction_of}


def _rings_inside(network: StreetNetwork, layout: JunctionLayout) -> set[int]:
    """Return the junctions with streets of roundabouts inside them."""
    junction_of = {node: junction for junction, nodes in enumerate(layout.nodes) for node in nodes}
    streets = (network.streets[street] for street in np.flatnonzero(layout.inner).tolist())
    return {
        junction_of[street.start]
        for street in streets
        if street.start in junction_of and street.attributes_at_end(0).roundabout
    }


def _attributes(network: StreetNetwork, end: int) -> StreetAttributes:
    return network.streets[end // 2].attributes_at_end(end)


def goes_first(one: Arm, other: Arm, ranks: Sequence[int]) -> bool:
    """Say whether traffic of one arm goes before that of another; `ranks` are those of all arms of the junction."""
    # Who leaves a property yields, whether that is signed or not, and to those who yield to others as well.
    leaves, other_leaves = _leaves_property(one, other), _leaves_property(other, one)
    yields, other_yields = one.yields or leaves, other.yields or other_leaves
    if yields != other_yields:
        return other_yields
    if leaves != other_leaves:
        return other_leaves
    if one.ring != other.ring:
        return one.ring
    if one.priority_road != other.priority_road:
        return one.priority_road
    return not one.yields and _outranks(one.rank, other.rank, ranks)


def _leaves_property(arm: Arm, other: Arm) -> bool:
    minor = arm.rank <= defaults.PRIORITY_RANK_MINOR and arm.rank < other.rank
    return minor and arm.sign is None and not arm.ring


def _outranks(one: int, other: int, ranks: Sequence[int]) -> bool:
    """Say whether a road of one rank goes before one of another: a higher one does where roads above that run on."""
    return one > other and (other <= defaults.PRIORITY_RANK_MINOR or sum(rank > other for rank in ranks) >= 2)
