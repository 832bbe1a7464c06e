"""What is said about a plan: what had no room, what was left out, which relations could not be kept."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import end_curvature, owners, smallest_radius, sorted_unique, unique_counts
from osm2xodr.defaults import CONNECTING_RADIUS
from osm2xodr.diagnostics import Diagnostics, counted
from osm2xodr.errors import InputError
from osm2xodr.geometry.connections import ConnectingRoads, curves_apart
from osm2xodr.geometry.defaults import CAR_WIDTH, MEETING_SHARE, SHORTEST_ROAD
from osm2xodr.geometry.junctions import JunctionLayout, Movement, RoadParts
from osm2xodr.geometry.lanes import Connectivity, CrossSection, end_lanes, taper_zones
from osm2xodr.geometry.plan_view import FittedStreets
from osm2xodr.model import Direction, IntArray, LaneSpec, Rule, StreetNetwork

# Ways there and back are compared at this many places each.
_PLACES: Final = 16
# Steps of curvature from which they count, 1/m, and within how much of a street they belong to one bend, m.
_STEP_OF_CURVATURE: Final = 1e-6
_ONE_BEND: Final = 20.0


def refuse_without_roads(layout: JunctionLayout) -> None:
    """Raise an InputError if all streets lie within junctions."""
    if layout.inner.all():
        raise InputError(
            "the streets lie within a few metres of each other, which leaves no road between their junctions; "
            "choose a larger area"
        )


def report_squeezed_streets(network: StreetNetwork, layout: JunctionLayout, diagnostics: Diagnostics) -> None:
    """Report streets that are too short for their junctions."""
    for street in np.flatnonzero(layout.squeezed).tolist():
        way = network.streets[street].pieces[0][1].osm_way_id
        text = "too short for the junctions at its ends, which were cut back"
        diagnostics.repaired("street-too-short", f"way/{way}", text)


def report_corners(fitted: FittedStreets, diagnostics: Diagnostics) -> None:
    """Report ways with bends whose curvature still steps, and how many: they are too sharp for spirals.

    Roundabouts have such steps where curves of their own meet.
    """
    plan, owner = fitted.plan_view, owners(fitted.plan_view.start)
    step = np.abs(plan.curvature[1:] - end_curvature(plan)[:-1]) > _STEP_OF_CURVATURE
    row = np.flatnonzero(step & (owner[1:] == owner[:-1])) + 1
    # Steps near each other are those of one bend.
    new = (np.diff(owner[row], prepend=-1) > 0) | (np.diff(plan.s[row], prepend=-np.inf) > _ONE_BEND)
    found: dict[int, int] = {}
    for street, s in zip(owner[row[new]].tolist(), plan.s[row[new]].tolist(), strict=True):
        attributes = [item for begin, item, _ in fitted.pieces[street] if begin <= s][-1]
        if not attributes.roundabout:
            found[attributes.osm_way_id] = found.get(attributes.osm_way_id, 0) + 1
    for way, count in found.items():
        text = f"{counted(count, 'bend')} of it stayed lines and arcs, as corners of streets do"
        diagnostics.note("corner", f"way/{way}", text)


# Why turns are left out.
IMPOSSIBLE: Final = "the arms lie on each other, a turn between is left out"
NEEDLESS: Final = "a turn that hardly any car drives is left out: another way leads there"


def report_turns_left_out(
    network: StreetNetwork, layout: JunctionLayout, junctions: IntArray, why: str, diagnostics: Diagnostics
) -> None:
    """Report junctions with turns that were left out, (turns,), for a reason of these."""
    for osm_id in _nodes(network, layout, junctions):
        diagnostics.dropped("no-room-to-turn", osm_id, why)


def report_sharp_turns(
    network: StreetNetwork, layout: JunctionLayout, connecting: ConnectingRoads, diagnostics: Diagnostics
) -> None:
    """Report junctions with turns that stayed sharper than a car drives."""
    sharp = (smallest_radius(connecting.plan_view) < CONNECTING_RADIUS) & connecting.for_vehicles()
    for osm_id in _nodes(network, layout, connecting.junction[sharp]):
        diagnostics.repaired("tight-turn", osm_id, "a turn through the junction is sharper than a car drives")


def report_meeting_paths(
    network: StreetNetwork, layout: JunctionLayout, connecting: ConnectingRoads, diagnostics: Diagnostics
) -> None:
    """Report junctions where cars that drive from one arm to another meet those that come back."""
    there, back = connecting.there_and_back()
    width = 0.5 * (connecting.entry_width + connecting.exit_width)
    least = np.minimum(CAR_WIDTH, MEETING_SHARE * 0.5 * (width[there] + width[back]))
    meets = curves_apart(connecting.plan_view, there, connecting.plan_view, back, _PLACES) < least
    for osm_id, count in _counted(network, layout, connecting.junction[there[meets]]):
        text = "cars from one arm to another meet those that come back: the arms leave no room for both"
        diagnostics.note("paths-meet", osm_id, text if count == 1 else f"{text} ({count} pairs of ways)")


def report_missing_corners(
    network: StreetNetwork, layout: JunctionLayout, junctions: IntArray, diagnostics: Diagnostics
) -> None:
    """Report junctions where sidewalks are not connected round a corner, (corners,)."""
    for osm_id in _nodes(network, layout, junctions):
        text = "the sidewalks of two arms cannot be connected round their corner"
        diagnostics.dropped("sidewalk-corner", osm_id, text)


def report_blunt_sidewalks(
    network: StreetNetwork, layout: JunctionLayout, junctions: IntArray, diagnostics: Diagnostics
) -> None:
    """Report junctions before which sidewalks end, (sidewalks,)."""
    for osm_id, count in _counted(network, layout, junctions):
        text = "the sidewalk of an arm ends before it: no lane leads round its corner, or leaves it room to run out"
        diagnostics.note("sidewalk-end", osm_id, text if count == 1 else f"{text} ({count} sidewalks)")


def _counted(network: StreetNetwork, layout: JunctionLayout, junctions: IntArray) -> list[tuple[str, int]]:
    """Return the OSM ids of the first nodes of junctions, each junction once, and how often it is named."""
    count = unique_counts(junctions)[1]
    return list(zip(_nodes(network, layout, junctions), count.tolist(), strict=True))


def _nodes(network: StreetNetwork, layout: JunctionLayout, junctions: IntArray) -> list[str]:
    """Return the OSM ids of the first nodes of junctions, each junction once."""
    first = [network.intersections[layout.nodes[junction][0]] for junction in sorted_unique(junctions).tolist()]
    return [f"node/{node.osm_node_id}" for node in first]


def report_absorbed_streets(
    network: StreetNetwork, layout: JunctionLayout, connecting: ConnectingRoads, diagnostics: Diagnostics
) -> None:
    """Report streets of which nothing is left: stubs, and those within a junction that nobody drives through."""
    # Rings, which start at no intersection, have -1 there.
    junction_of = np.full(len(network.intersections) + 1, -1, np.int64)
    for junction in sorted_unique(connecting.junction).tolist():
        junction_of[list(layout.nodes[junction])] = junction
    for street in np.flatnonzero(layout.inner).tolist():
        ends = [network.streets[street].start, network.streets[street].end]
        # One end of a stub is no junction.
        if junction_of[ends].min() >= 0:
            continue
        for way in dict.fromkeys(attributes.osm_way_id for _, attributes in network.streets[street].pieces):
            text = "too little of it lies outside of its junction, or nobody drives through that: it is left out"
            diagnostics.dropped("within-junction", f"way/{way}", text)


def report_lane_changes(network: StreetNetwork, parts: RoadParts, diagnostics: Diagnostics) -> None:
    """Report where roads are too short for lanes to open and end as they should, or at all."""
    for road, found in enumerate(parts.stretches):
        for zone, item in zip(taper_zones(found, network.rule), found[1:], strict=True):
            if zone.length < zone.change.least - SHORTEST_ROAD:
                text = f"its lanes change within {zone.length:.0f} m, {zone.change.least:.0f} m would be needed"
                diagnostics.note("short-taper", f"way/{item.ways[0]}", text)
        for way in _taken_over(parts, road):
            text = "there is no room for its lanes to open and end: it has those of the road before or after it"
            diagnostics.repaired("lanes-taken-over", f"way/{way}", text)


def _taken_over(parts: RoadParts, road: int) -> list[int]:
    """Return the ways whose number of lanes a road does not have anywhere along them, if they are no bits of it."""
    pieces = parts.pieces[parts.street[road]]
    out: list[int] = []
    if len(pieces) == 1:
        return out
    begin, end = float(parts.begin[road]), float(parts.end[road])
    for k, (s, attributes, section) in enumerate(pieces):
        lower = max(s if k else begin, begin)
        upper = min(pieces[k + 1][0] if k + 1 < len(pieces) else end, end)
        there = [item for item in parts.stretches[road] if item.start < upper - begin and item.end > lower - begin]
        counts = [(len(item.section.left), len(item.section.right)) for item in there]
        if upper - lower >= SHORTEST_ROAD and (len(section.left), len(section.right)) not in counts:
            out.append(attributes.osm_way_id)
    return out


def report_unused_connectivity(
    network: StreetNetwork, movements: Iterable[Movement], parts: RoadParts, diagnostics: Diagnostics
) -> None:
    """Report connectivity relations that decided nothing, in junctions and where a road changes its lanes."""
    if not network.connectivities:
        return
    used: set[int] = set()
    for item in movements:
        if item.stated is not None:
            entry, exit_ = int(parts.road_end[item.entry]), int(parts.road_end[item.exit])
            lanes_in = _lanes(parts.at_end(entry).section, network.rule, item.entry % 2 == 1)
            lanes_out = _lanes(parts.at_end(exit_).section, network.rule, item.exit % 2 == 0)
            if item.stated.between(lanes_in, lanes_out) is not None:
                used.update(item.stated.relations)
    known = Connectivity.of(network.connectivities)
    for road in parts.stretches:
        for one, other in pairwise(road):
            for direction, stated in known.at_border(one.ways[-1], other.ways[0]).items():
                along = direction is Direction.FORWARD
                pair = (one.section, other.section) if along else (other.section, one.section)
                if stated.between(*(_lanes(section, network.rule, along) for section in pair)) is not None:
                    used.update(stated.relations)
    for relation in network.connectivities:
        if relation.osm_relation_id not in used:
            text = "it names lanes or a way that are missing or that nobody may drive to; lanes are linked by habit"
            diagnostics.dropped("connectivity", f"relation/{relation.osm_relation_id}", text)


def _lanes(section: CrossSection, rule: Rule, along: bool) -> tuple[LaneSpec, ...]:
    return tuple(lane.spec for lane in end_lanes(section, rule, along))
