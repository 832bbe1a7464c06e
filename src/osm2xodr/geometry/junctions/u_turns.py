"""Which U-turns are kept: from one carriageway of a road to the opposite one.

OSM allows every U-turn that it does not forbid. Those are kept that a car can drive in one turn, and that the law of
the country, or the user, does not leave out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from operator import attrgetter

import numpy as np

from osm2xodr.conventions import find_country, read_signs
from osm2xodr.curves import cosine, sine, wrapped
from osm2xodr.defaults import LEAST_TURN_BACK
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.junctions import defaults
from osm2xodr.geometry.junctions.clusters import JunctionLayout
from osm2xodr.geometry.junctions.movements import Movement
from osm2xodr.geometry.lanes import EndLane, end_lanes
from osm2xodr.geometry.plan_view import FittedStreets, StreetEnds, outward_pose
from osm2xodr.model import (
    BoolArray,
    IntArray,
    LaneType,
    Rule,
    StreetAttributes,
    StreetNetwork,
    applied,
    unused,
)


def choose_u_turns(
    network: StreetNetwork,
    fitted: FittedStreets,
    ends: StreetEnds,
    layout: JunctionLayout,
    movements: list[Movement],
    kept: str,
    diagnostics: Diagnostics,
) -> list[Movement]:
    """Mark the movements that are U-turns between carriageways, and leave out some of them.

    `kept` is one of `conventions.U_TURNS`; corrections leave out more. U-turns stay where nothing else leads on.
    `diagnostics` gets the others, and the corrections.
    """
    found = _between_carriageways(network, ends, layout, movements)
    known = _Corrected(network)
    if not len(found):
        known.report(diagnostics)
        return movements
    ways_out: dict[int, int] = {}
    for item in movements:
        ways_out[item.entry] = ways_out.get(item.entry, 0) + 1
    u_turns = [movements[k] for k in found.tolist()]
    apart = _lanes_apart(fitted, ends, layout, u_turns, network.rule)
    arms_used = {
        junction: {end for item in group for end in (item.entry, item.exit)}
        for junction, group in groupby(movements, key=attrgetter("junction"))
    }
    mapped = _mapped(network, fitted, ends, arms_used, u_turns)
    unsaid = _unsaid(network, ends, layout, arms_used, u_turns, mapped, kept)
    out = list(movements)
    dropped: set[int] = set()
    for k, distance, is_left_out in zip(found.tolist(), apart, unsaid, strict=True):
        item = movements[k]
        out[k] = replace(item, u_turn=True)
        if ways_out[item.entry] == 1:
            continue
        if distance >= defaults.U_TURN_ACROSS_MIN and not is_left_out:
            nodes = [network.intersections[node].osm_node_id for node in layout.nodes[item.junction]]
            if known.forbid(_attributes(network, item.entry).osm_way_id, nodes):
                dropped.add(k)
            continue
        dropped.add(k)
        node = network.intersections[int(ends.node[item.entry])].osm_node_id
        text = "the law or --u-turns forbids it" if is_left_out else f"its lanes are only {distance:.1f} m apart"
        diagnostics.dropped("u-turn", f"node/{node}", f"a U-turn is left out: {text}")
    known.report(diagnostics)
    return [item for k, item in enumerate(out) if k not in dropped]


class _Corrected:
    """Ways and nodes from and at which users say that nobody turns back."""

    def __init__(self, network: StreetNetwork) -> None:
        known = network.corrections
        # Whether each of them left a U-turn out, by its OSM id.
        self._used = {f"way/{way}": False for way, item in sorted(known.ways.items()) if item.no_u_turn}
        self._used |= {f"node/{node}": False for node, item in sorted(known.nodes.items()) if item.no_u_turn}

    def forbid(self, way: int, nodes: Sequence[int]) -> bool:
        """Say whether a U-turn from a way at the junction of some nodes is left out."""
        found = {f"way/{way}", *(f"node/{node}" for node in nodes)} & self._used.keys()
        self._used.update(dict.fromkeys(found, True))
        return bool(found)

    def report(self, diagnostics: Diagnostics) -> None:
        """Report which corrections had an effect."""
        for osm_id, was_used in self._used.items():
            if was_used:
                applied(diagnostics, osm_id, "no-u-turn", "U-turns into the opposite carriageway are left out")
            else:
                unused(diagnostics, osm_id, "no-u-turn", "no U-turn is kept there that could be left out")


def _between_carriageways(
    network: StreetNetwork, ends: StreetEnds, layout: JunctionLayout, movements: list[Movement]
) -> IntArray:
    """Return which movements lead from one carriageway to the opposite one, on the side of oncoming traffic."""
    entry = np.array([item.entry for item in movements], np.int64)
    exit_ = np.array([item.exit for item in movements], np.int64)
    one_way = (ends.enters != ends.leaves) & ~ends.roundabout
    x0, y0, h0 = outward_pose(ends, entry, layout.trim[entry])
    x1, y1, h1 = outward_pose(ends, exit_, layout.trim[exit_])
    back = np.abs(wrapped(h1 - h0 - np.pi)) >= LEAST_TURN_BACK
    # Left of the outward direction is right of traffic that comes in.
    left = (x1 - x0) * sine(h0) - (y1 - y0) * cosine(h0)
    oncoming = left < 0 if network.rule is Rule.LEFT_HAND else left > 0
    some = np.flatnonzero(one_way[entry] & one_way[exit_] & back & oncoming & (entry != exit_))
    return np.asarray(some[np.array([_one_road(network, ends, movements[k]) for k in some.tolist()], bool)])


def _one_road(network: StreetNetwork, ends: StreetEnds, item: Movement) -> bool:
    """Say whether a movement leads from a road to the same one; roads without a name may just fork at a node."""
    one, two = _attributes(network, item.entry), _attributes(network, item.exit)
    return one.road == two.road and (bool(one.name or one.ref) or not _at_one_node(ends, item))


def _at_one_node(ends: StreetEnds, item: Movement) -> bool:
    """Say whether a movement turns back at one node, and not over a way between the carriageways."""
    # A street that is driven along is entered at its start.
    arrive = [ends.hdg[item.entry], *(ends.hdg[2 * street + along] for street, along in item.inner)]
    leave = [*(ends.hdg[2 * street + (not along)] for street, along in item.inner), ends.hdg[item.exit]]
    turn = np.abs(wrapped(np.array(leave) - np.array(arrive) - np.pi))
    return bool(turn.max() >= LEAST_TURN_BACK)


def _attributes(network: StreetNetwork, end: int) -> StreetAttributes:
    return network.streets[end // 2].attributes_at_end(end)


def _lanes(fitted: FittedStreets, end: int, into: bool, rule: Rule) -> tuple[EndLane, ...]:
    """Return the lanes of a street end into its junction, or out of it, from left to right."""
    section = fitted.pieces[end // 2][-1 if end % 2 else 0][2]
    return end_lanes(section, rule, into == (end % 2 == 1))


def _lanes_apart(
    fitted: FittedStreets, ends: StreetEnds, layout: JunctionLayout, u_turns: Sequence[Movement], rule: Rule
) -> list[float]:
    """Return how far the innermost lane of each U-turn's entry is from the farthest lane of its exit, m."""
    entry = np.array([item.entry for item in u_turns], np.int64)
    exit_ = np.array([item.exit for item in u_turns], np.int64)
    x0, y0, h0 = outward_pose(ends, entry, layout.trim[entry])
    x1, y1, h1 = outward_pose(ends, exit_, layout.trim[exit_])
    axis = h0 + wrapped(h1 - h0) / 2
    # Left of the outward direction. Oncoming traffic is on the right of it where traffic keeps to the right.
    lines = (y1 - y0) * cosine(axis) - (x1 - x0) * sine(axis)
    side, inner = (1.0, -1) if rule is Rule.LEFT_HAND else (-1.0, 0)
    out = []
    for item, between in zip(u_turns, lines.tolist(), strict=True):
        into = _lanes(fitted, item.entry, True, rule)
        away = _lanes(fitted, item.exit, False, rule)
        near = [_outward_t(lane, item.entry) for lane in into if _for_cars(lane, into)]
        far = [_outward_t(lane, item.exit) for lane in away if _for_cars(lane, away)]
        out.append(max((side * (between + t - near[inner]) for t in far), default=0.0) if near else 0.0)
    return out


def _outward_t(lane: EndLane, end: int) -> float:
    """Return how far left of the outward direction of a street end a lane lies, m."""
    return -lane.t if end % 2 else lane.t


def _for_cars(lane: EndLane, lanes: Sequence[EndLane]) -> bool:
    """Say whether a lane is for cars, as far as any is."""
    return lane.spec.type is LaneType.DRIVING or all(item.spec.type is not LaneType.DRIVING for item in lanes)


def _mapped(
    network: StreetNetwork,
    fitted: FittedStreets,
    ends: StreetEnds,
    arms_used: Mapping[int, set[int]],
    u_turns: Sequence[Movement],
) -> BoolArray:
    """Say which U-turns OSM has: turn lanes say so, or no other road leads to a crossing of the median, (found,)."""
    out = []
    for item in u_turns:
        road = _attributes(network, item.entry).road
        lanes = _lanes(fitted, item.entry, True, network.rule)
        only = all(
            ends.enters[end] != ends.leaves[end] and _attributes(network, end).road == road
            for end in arms_used[item.junction]
        )
        out.append(any("reverse" in lane.spec.turns for lane in lanes) or (only and bool(item.inner)))
    return np.array(out, bool)


def _unsaid(
    network: StreetNetwork,
    ends: StreetEnds,
    layout: JunctionLayout,
    arms_used: Mapping[int, set[int]],
    u_turns: Sequence[Movement],
    mapped: BoolArray,
    kept: str,
) -> BoolArray:
    """Say which U-turns the law or the user leaves out, (found,); `mapped` are those that OSM has."""
    if kept == "none":
        return np.ones(len(u_turns), bool)
    if kept == "mapped":
        return ~mapped
    if kept == "all" or find_country(network.country).u_turns_at_signals:
        return np.zeros(len(u_turns), bool)
    signs, out = read_signs(network), []
    for item in u_turns:
        nodes = [network.intersections[node].osm_node_id for node in layout.nodes[item.junction]]
        entries = [end for end in arms_used[item.junction] if ends.enters[end]]
        out.append(signs.signalled(nodes, sorted(entries)))
    return np.array(out, bool) & ~mapped
