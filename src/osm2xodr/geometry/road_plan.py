"""The plan view: where roads run, where junctions cut them, and the roads that connect them there."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from osm2xodr.conventions import SPIRALS
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.connections import (
    ConnectingRoads,
    LaneLinks,
    beyond_streets,
    build_connecting_roads,
    change_in_parts,
    clear_arms,
    detours,
    direct_roads,
    draw_in_parts,
    draw_turns_back,
    even_widths,
    find_lane_links,
    keep_lanes_in_line,
    redraw_connecting_roads,
    runs_backwards,
    set_back_arms,
    set_back_stems,
    swing_out,
    turns_without_need,
)
from osm2xodr.geometry.junctions import (
    JunctionLayout,
    Movement,
    RoadParts,
    add_turnarounds,
    choose_u_turns,
    cut_back_ends_on_streets,
    cut_roads,
    ends_on_streets,
    find_movements,
    lay_out_junctions,
    shift_lines_out_of_bends,
    with_movements_against_cars,
    without_idle_junctions,
)
from osm2xodr.geometry.options import RoadOptions
from osm2xodr.geometry.plan_report import (
    IMPOSSIBLE,
    NEEDLESS,
    refuse_without_roads,
    report_absorbed_streets,
    report_corners,
    report_lane_changes,
    report_meeting_paths,
    report_missing_corners,
    report_sharp_turns,
    report_squeezed_streets,
    report_turns_left_out,
    report_unused_connectivity,
)
from osm2xodr.geometry.plan_view import (
    FittedStreets,
    StreetEnds,
    fit_streets,
    outer_lanes,
    separate_parallel_streets,
    smooth_streets,
    street_ends,
    trims_clear_of_bends,
)
from osm2xodr.geometry.roadside import (
    Margins,
    SidewalkEnds,
    ends_of_strips,
    find_margins,
    find_sidewalk_ends,
    lay_out_corners,
    margins_with_room,
    run_out,
    with_cycle_tracks,
)
from osm2xodr.model import FloatArray, IntArray, StreetNetwork
from osm2xodr.system import Task, record

# Connecting roads become no shorter than this share where lanes shift to be in line. A choice.
_SHORTER: Final = 0.95


@record(eq=False)
class CutStreets:
    """Streets, the junctions that cut them, and the roads that are left."""

    fitted: FittedStreets  # The streets' curves
    ends: StreetEnds
    layout: JunctionLayout
    parts: RoadParts


@record(eq=False)
class RoadPlan(CutStreets):
    """Roads and junctions in plan."""

    connecting: ConnectingRoads  # The roads for cars within junctions


@record(eq=False)
class RoadSides:
    """What lies beside roads, which heights do not depend on."""

    margins: tuple[Margins, ...]  # Of each road
    corners: ConnectingRoads  # The sidewalks within junctions
    ends: SidewalkEnds  # Those that end there
    blunt: IntArray  # (k,) Junctions of sidewalks that end before them, one for each
    diagnostics: Diagnostics  # What was found meanwhile


def plan_roads(
    network: StreetNetwork, options: RoadOptions, diagnostics: Diagnostics, side_by_side: bool = False, jobs: int = 1
) -> RoadPlan:
    """Lay out the roads of a network in plan, by so many processes.

    `side_by_side`: only what lies near a street shapes it, so that areas side by side agree.
    """
    fitted = fit_streets(network, diagnostics, spirals=options.plan == SPIRALS)
    if options.plan == SPIRALS:
        fitted = smooth_streets(network, fitted, chained=not side_by_side, jobs=jobs)
        report_corners(fitted, diagnostics)
    fitted = separate_parallel_streets(network, fitted, diagnostics)
    ends = _street_ends(network, fitted)
    layout, movements = _lay_out_junctions(network, fitted, ends, options, diagnostics, jobs)
    cut = CutStreets(fitted, ends, layout, cut_roads(network, fitted, layout))
    cut, connecting = _connect(network, cut, movements, diagnostics, jobs, in_line=not side_by_side)
    connecting = change_in_parts(partial(_turned, cut), connecting, jobs)
    connecting = _without_impossible_turns(network, cut, connecting, diagnostics)
    report_squeezed_streets(network, cut.layout, diagnostics)
    report_sharp_turns(network, cut.layout, connecting, diagnostics)
    report_meeting_paths(network, cut.layout, connecting, diagnostics)
    report_absorbed_streets(network, cut.layout, connecting, diagnostics)
    report_unused_connectivity(network, movements, cut.parts, diagnostics)
    report_lane_changes(network, cut.parts, diagnostics)
    return RoadPlan(cut.fitted, cut.ends, cut.layout, cut.parts, connecting)


def lay_out_sides(network: StreetNetwork, plan: RoadPlan) -> RoadSides:
    """Lay out what lies beside the roads of a plan."""
    found = Diagnostics()
    margins = margins_with_room(plan.parts, find_margins(plan.parts), found)
    margins, corners, left_out = lay_out_corners(plan.parts, margins, plan.connecting, network.rule)
    report_missing_corners(network, plan.layout, left_out, found)
    margins, ends, blunt = find_sidewalk_ends(plan.parts, margins, plan.connecting, corners, network.rule)
    corners = with_cycle_tracks(corners, plan.parts, margins, plan.connecting, network.rule)
    ending = ends_of_strips(plan.parts, margins, plan.connecting, corners)
    margins = run_out(plan.parts, margins, tuple(ending))
    return RoadSides(margins, corners, ends, blunt, found)


def _street_ends(network: StreetNetwork, fitted: FittedStreets) -> StreetEnds:
    sections = tuple((pieces[0][2], pieces[-1][2]) for pieces in fitted.pieces)
    return street_ends(network, fitted.plan_view, sections, fitted.aside)


def _lay_out_junctions(
    network: StreetNetwork,
    fitted: FittedStreets,
    ends: StreetEnds,
    options: RoadOptions,
    diagnostics: Diagnostics,
    jobs: int,
) -> tuple[JunctionLayout, list[Movement]]:
    """Find the junctions and the ways through them, loops at dead ends included."""
    with Task(partial(ends_on_streets, fitted, ends), apart=jobs > 1) as on_streets:
        layout = lay_out_junctions(network, ends, diagnostics, jobs)
        refuse_without_roads(layout)
        movements = find_movements(network, ends, layout, diagnostics)
        movements = choose_u_turns(network, fitted, ends, layout, movements, options.u_turns, diagnostics)
        movements = with_movements_against_cars(network, ends, layout, movements)
        layout = without_idle_junctions(ends, layout, movements)
        layout = cut_back_ends_on_streets(network, ends, layout, on_streets.result(), diagnostics)
    layout, loops = add_turnarounds(network, fitted, ends, layout, options, diagnostics)
    return layout, movements + loops


def _connect(
    network: StreetNetwork,
    cut: CutStreets,
    movements: list[Movement],
    diagnostics: Diagnostics,
    jobs: int,
    *,
    in_line: bool,
) -> tuple[CutStreets, ConnectingRoads]:
    """Cut streets so that the ways through junctions have room, and draw the roads there.

    How much room turns need is decided by ways that lead there directly. Arms that the drawn ones run over are cut
    back, lanes narrow before junctions where the ways are too short for that, and shift to be `in_line`; what these
    change is drawn again.
    """
    # Measured from OSM's lines: `StreetEnds.aside` says how far from these the lines are that move later.
    lanes = partial(outer_lanes, cut.fitted, network.rule)

    def drawn(cut: CutStreets, links: LaneLinks) -> ConnectingRoads:
        draw = partial(
            build_connecting_roads,
            movements=movements,
            ends=cut.ends,
            trim=cut.layout.trim,
            outer_lanes=lanes,
            rule=network.rule,
        )
        return draw_in_parts(draw, links, jobs)

    first = find_lane_links(cut.parts, movements, network.rule)
    u_turns = np.array([movements[row.movement].u_turn for row in first.rows], bool)
    direct = direct_roads(first, movements, cut.ends)
    # U-turns go round the nose of a median wherever it is.
    cut = _out_of_bends(network, _with_room_to_turn(network, cut, direct.chosen(~u_turns)))
    before = find_lane_links(cut.parts, movements, network.rule, first)
    connecting = drawn(cut, before)
    cut = _with_arms_cleared(network, cut, connecting, jobs)
    links = find_lane_links(cut.parts, movements, network.rule, before)
    direct = redraw_connecting_roads(direct, first, links, partial(direct_roads, movements=movements, ends=cut.ends))
    even = keep_lanes_in_line(cut.parts, direct, network.rule) if in_line else cut.parts
    even = even_widths(even, _shorter(direct, cut.parts, even), network.rule, diagnostics)
    cut = replace(cut, parts=even)
    links = find_lane_links(even, movements, network.rule, links)
    return cut, redraw_connecting_roads(connecting, before, links, partial(drawn, cut))


def _shorter(connecting: ConnectingRoads, before: RoadParts, after: RoadParts) -> ConnectingRoads:
    """Return the connecting roads with the lengths that they have at least where lanes of their arms have moved."""
    moved = np.array([one is not other for one, other in zip(before.stretches, after.stretches, strict=True)], bool)
    either = moved[connecting.entry // 2] | moved[connecting.exit // 2]
    return replace(connecting, length=np.where(either, _SHORTER, 1.0) * connecting.length)


def _with_room_to_turn(network: StreetNetwork, cut: CutStreets, turns: ConnectingRoads) -> CutStreets:
    """Set back arms whose turns are too sharp, and those that end in tight bends."""
    trim = set_back_arms(cut.ends, cut.layout, cut.parts, turns)
    trim = set_back_stems(cut.ends, cut.layout, cut.parts, turns, trim)
    trim = trims_clear_of_bends(cut.ends, cut.layout.junction, trim, cut.layout.trim, cut.layout.most)
    trim = _within_streets(cut, trim)
    if (trim == cut.layout.trim).all():
        return cut
    layout = replace(cut.layout, trim=trim)
    return replace(cut, layout=layout, parts=cut_roads(network, cut.fitted, layout, cut.parts))


def _within_streets(cut: CutStreets, trim: FloatArray) -> FloatArray:
    """Return trims, (ends,), m, that leave a road of every street: both ends share what it can spare."""
    more = np.maximum(trim - cut.layout.trim, 0.0).reshape(-1, 2).sum(1)
    spare = cut.ends.length[0::2] - cut.layout.trim.reshape(-1, 2).sum(1) - cut.layout.least
    share = np.clip(spare / np.maximum(more, 1e-9), 0.0, 1.0)
    return np.where(trim > cut.layout.trim, cut.layout.trim + np.repeat(share, 2) * (trim - cut.layout.trim), trim)


def _with_arms_cleared(network: StreetNetwork, cut: CutStreets, connecting: ConnectingRoads, jobs: int) -> CutStreets:
    """Cut back the arms that ways run over."""
    layout = cut.layout
    trim = clear_arms(cut.ends, layout, cut.parts, connecting, jobs)
    moved = trim > layout.trim
    if not moved.any():
        return cut
    most = np.maximum(trim, layout.most)
    trim = trims_clear_of_bends(cut.ends, np.where(moved, layout.junction, -1), trim, trim, most)
    layout = replace(layout, trim=trim)
    return replace(cut, layout=layout, parts=cut_roads(network, cut.fitted, layout, cut.parts))


def _out_of_bends(network: StreetNetwork, cut: CutStreets) -> CutStreets:
    """Move reference lines to the outside of the tight bends that no junction has taken."""
    fitted, layout = shift_lines_out_of_bends(cut.fitted, cut.layout, cut.parts, network.rule)
    if fitted is cut.fitted:
        return cut
    return CutStreets(fitted, _street_ends(network, fitted), layout, cut_roads(network, fitted, layout, cut.parts))


def _turned(cut: CutStreets, connecting: ConnectingRoads) -> ConnectingRoads:
    """Draw turns again that are too sharp, and those that turn back."""
    connecting = swing_out(connecting, partial(beyond_streets, cut.ends, cut.layout, cut.parts))
    return draw_turns_back(connecting, cut.ends, cut.layout)


def _without_impossible_turns(
    network: StreetNetwork, cut: CutStreets, connecting: ConnectingRoads, diagnostics: Diagnostics
) -> ConnectingRoads:
    """Leave out connecting roads that no car would drive: their arms lie on each other, or there is a better way."""
    # Loops that turn back on their arm are long by design.
    impossible = detours(connecting.plan_view) | runs_backwards(connecting, cut.parts)
    impossible &= connecting.entry != connecting.exit
    report_turns_left_out(network, cut.layout, connecting.junction[impossible], IMPOSSIBLE, diagnostics)
    connecting = connecting.chosen(~impossible) if impossible.any() else connecting
    needless = turns_without_need(connecting, cut.parts, cut.ends, cut.layout)
    report_turns_left_out(network, cut.layout, connecting.junction[needless], NEEDLESS, diagnostics)
    return connecting.chosen(~needless) if needless.any() else connecting
