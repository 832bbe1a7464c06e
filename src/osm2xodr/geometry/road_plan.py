"""The plan view: where roads run, where junctions cut them, and the roads that connect them there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from osm2xodr import defaults
from osm2xodr.curves import smallest_radius
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.connections import (
    ConnectingRoads,
    build_connecting_roads,
    detours,
    find_lane_links,
    report_unheeded,
    turns_on_the_spot,
    widened_trims,
    with_wide_turns,
)
from osm2xodr.geometry.junctions import (
    JunctionLayout,
    Movement,
    RoadOptions,
    RoadParts,
    add_turnarounds,
    cut_roads,
    dead_ends_apart,
    find_movements,
    lay_out_junctions,
    lines_outside_bends,
    refuse_without_roads,
    report_lost,
    without_idle_junctions,
)
from osm2xodr.geometry.margins import Margins, find_margins, lay_out_corners, margins_with_room
from osm2xodr.geometry.plan_view import (
    FittedStreets,
    StreetEnds,
    fit_streets,
    narrow_parallel_streets,
    outer_lanes,
    street_ends,
    trims_clear_of_bends,
)
from osm2xodr.model import IntArray, StreetNetwork


@dataclass(frozen=True, slots=True, eq=False)
class RoadPlan:
    """Roads and junctions in plan."""

    # The streets' curves, and their ends
    fitted: FittedStreets
    ends: StreetEnds
    layout: JunctionLayout  # The junctions
    parts: RoadParts  # The roads between junctions
    connecting: ConnectingRoads  # The roads for cars within junctions
    margins: tuple[Margins, ...]  # What lies beside each road
    corners: ConnectingRoads  # The roads for people on foot within junctions


def plan_roads(network: StreetNetwork, options: RoadOptions, diagnostics: Diagnostics) -> RoadPlan:
    """Lay out the roads of a network.

    Parameters
    ----------
    network
        What is to be driven on.
    options
        What the user chose about roads.
    diagnostics
        Where repairs and compromises are told.
    """
    fitted = narrow_parallel_streets(network, fit_streets(network, diagnostics), diagnostics)
    ends = _ends(network, fitted)
    layout = lay_out_junctions(network, ends)
    refuse_without_roads(layout)
    movements = find_movements(network, ends, layout, diagnostics)
    layout = dead_ends_apart(network, ends, layout, without_idle_junctions(layout, movements), diagnostics)
    layout, loops = add_turnarounds(network, fitted, ends, layout, options, diagnostics)
    movements += loops
    parts = cut_roads(network, fitted, layout)
    first = parts
    # Measured from OSM's line, from which lines that are moved later say how far they are.
    inner_lanes = partial(outer_lanes, fitted, network.rule)
    links = find_lane_links(parts, movements, network.rule)
    connecting = build_connecting_roads(links, movements, ends, layout.trim, inner_lanes, network.rule)
    widened = widened_trims(ends, layout, parts, connecting)
    trim = trims_clear_of_bends(ends, layout.junction, widened, layout.trim)
    if (trim != layout.trim).any():
        layout = replace(layout, trim=trim)
        parts = cut_roads(network, fitted, layout, parts)
    moved, layout = lines_outside_bends(fitted, layout, parts)
    if moved is not fitted:
        fitted = moved
        ends = _ends(network, fitted)
        parts = cut_roads(network, fitted, layout, parts)
    if parts is not first:
        links = find_lane_links(parts, movements, network.rule, links)
        connecting = build_connecting_roads(links, movements, ends, layout.trim, inner_lanes, network.rule)
    connecting = with_wide_turns(connecting, parts)
    connecting = _without_detours(network, layout, connecting, diagnostics)
    _report(network, layout, connecting, diagnostics)
    report_lost(network, layout, connecting.junction, diagnostics)
    _report_connectivity(network, movements, parts, diagnostics)
    margins = margins_with_room(parts, find_margins(parts), diagnostics)
    margins, corners, left_out = lay_out_corners(parts, margins, connecting, network.rule)
    report_corners(network, layout, left_out, diagnostics)
    return RoadPlan(fitted, ends, layout, parts, connecting, margins, corners)


def _ends(network: StreetNetwork, fitted: FittedStreets) -> StreetEnds:
    sections = tuple((pieces[0][2], pieces[-1][2]) for pieces in fitted.pieces)
    return street_ends(network, fitted.plan_view, sections, fitted.aside)


def _without_detours(
    network: StreetNetwork, layout: JunctionLayout, connecting: ConnectingRoads, diagnostics: Diagnostics
) -> ConnectingRoads:
    """Leave out connecting roads that no car would drive because the arms that they join lie on each other."""
    # Loops that turn back are long by design.
    astray = detours(connecting.plan_view) | turns_on_the_spot(connecting.plan_view)
    astray &= connecting.entry != connecting.exit
    for junction in np.unique(connecting.junction[astray]).tolist():
        node = network.intersections[layout.nodes[junction][0]].osm_node_id
        diagnostics.dropped(
            "no-room-to-turn", f"node/{node}", "the arms lie on each other, a turn between is left out"
        )
    return connecting.chosen(~astray) if astray.any() else connecting


def _report(
    network: StreetNetwork, layout: JunctionLayout, connecting: ConnectingRoads, diagnostics: Diagnostics
) -> None:
    for street in np.flatnonzero(layout.squeezed).tolist():
        way = network.streets[street].pieces[0][1].osm_way_id
        diagnostics.repaired(
            "street-too-short", f"way/{way}", "too short for the junctions at its ends, which were cut back"
        )
    sharp = smallest_radius(connecting.plan_view) < defaults.CONNECTING_RADIUS
    tight = np.unique(connecting.junction[sharp])
    for junction in tight.tolist():
        node = network.intersections[layout.nodes[junction][0]].osm_node_id
        diagnostics.repaired("tight-turn", f"node/{node}", "a turn through the junction is sharper than a car drives")


def report_corners(
    network: StreetNetwork, layout: JunctionLayout, left_out: IntArray, diagnostics: Diagnostics
) -> None:
    """Tell in which junctions sidewalks are not connected around corners."""
    for junction in np.unique(left_out).tolist():
        node = network.intersections[layout.nodes[junction][0]].osm_node_id
        diagnostics.dropped(
            "sidewalk-corner", f"node/{node}", "the sidewalks of two arms cannot be connected round their corner"
        )


def _report_connectivity(
    network: StreetNetwork, movements: Sequence[Movement], parts: RoadParts, diagnostics: Diagnostics
) -> None:
    if not network.connectivities:
        return
    ends = [(item, int(parts.road_end[item.entry]), int(parts.road_end[item.exit])) for item in movements]
    sections = [(item, parts.at_end(one).section, parts.at_end(other).section) for item, one, other in ends]
    report_unheeded(network, sections, parts.stretches, diagnostics)
