"""Streets get their curves and cross-sections, which the rest of the geometry works on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from osm2xodr.curves import replace_curves, starts
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.defaults import CORNER_RADIUS, CORNER_RADIUS_OTHER
from osm2xodr.geometry.lanes import CrossSection, Piece, cross_section, end_lanes
from osm2xodr.geometry.plan_view.polyline_fit import fit_polylines
from osm2xodr.geometry.plan_view.roundabouts import FittedRings, fit_rings, move_ends
from osm2xodr.geometry.plan_view.wide_bends import widen_bends
from osm2xodr.model import BoolArray, FloatArray, LaneSpec, PlanView, Rule, Street, StreetAttributes, StreetNetwork

# Attributes, each with the index of the point from which on they hold.
_AttributesFrom = tuple[tuple[int, StreetAttributes], ...]


@dataclass(frozen=True, slots=True, eq=False)
class FittedStreets:
    """The streets' curves."""

    plan_view: PlanView  # One curve per street
    pieces: tuple[tuple[Piece, ...], ...]  # Of each street, in ascending s
    aside: FloatArray  # (streets,) How far left of the line of OSM each curve lies, m; 0 as fitted
    on_ring: BoolArray  # (streets,) Whether it is part of a ring that is one curve


def fit_streets(network: StreetNetwork, diagnostics: Diagnostics, *, spirals: bool = True) -> FittedStreets:
    """Fit a curve to every street and say where on it its attributes change.

    All curves are lines and arcs, but rings that are no circles if they may have `spirals`.
    """
    rings = fit_rings(network, diagnostics, spirals=spirals)
    on_ring = {street: number for number, street in enumerate(rings.streets)}
    lines = [_line(street, rings, street.id in on_ring) for street in network.streets]
    start = starts([len(points) for points, _ in lines])
    # Of several classes the least, in whatever order.
    radius = np.array(
        [min(CORNER_RADIUS.get(item.highway, CORNER_RADIUS_OTHER) for _, item in pieces) for _, pieces in lines]
    )
    closed = np.array([street.start < 0 for street in network.streets], bool)
    fitted = fit_polylines(np.concatenate([points for points, _ in lines]), start, radius, closed)
    for index in fitted.spikes.tolist():
        street = network.streets[int(np.searchsorted(start, index, side="right")) - 1]
        if street.id not in on_ring:
            text = "the line turns straight back on itself at a node, which was left out"
            diagnostics.repaired("spike", f"way/{street.pieces[0][1].osm_way_id}", text)
    station = fitted.station.copy()
    for street_id, number in on_ring.items():
        station[start[street_id] : start[street_id + 1]] = rings.stations[number]
    sections: dict[tuple[tuple[LaneSpec, ...], float], CrossSection] = {}
    pieces = tuple(
        tuple(
            (float(station[start[k] + index]), attributes, _section(attributes, network.rule, sections))
            for index, attributes in line_pieces
        )
        for k, (_, line_pieces) in enumerate(lines)
    )
    plan = fitted.plan_view
    if rings.streets:
        plan = replace_curves(plan, np.array(rings.streets), rings.plan_view, np.arange(len(rings.streets)))
    round_about = np.zeros(len(pieces), bool)
    round_about[list(rings.streets)] = True
    plan, pieces, narrow = widen_bends(plan, pieces, round_about)
    for k in narrow.tolist():
        way = pieces[k][0][1].osm_way_id
        diagnostics.note("tight-bend", f"way/{way}", "a bend is tighter than its carriageway is wide")
    return FittedStreets(plan, pieces, np.zeros(len(pieces)), round_about)


def _line(street: Street, rings: FittedRings, on_ring: bool) -> tuple[FloatArray, _AttributesFrom]:
    """Return the points that a street's curve is fitted to, and the attributes that hold from which of them on."""
    if on_ring:
        return street.points, street.pieces
    if street.start < 0:
        return _opened(street)
    return move_ends(street.points, rings.moved.get(street.start), rings.moved.get(street.end)), street.pieces


def _section(
    attributes: StreetAttributes, rule: Rule, known: dict[tuple[tuple[LaneSpec, ...], float], CrossSection]
) -> CrossSection:
    """Return the cross-section; streets whose lanes are alike share it."""
    key = attributes.lanes_ltr, attributes.middle_offset
    if key not in known:
        known[key] = cross_section(attributes, rule)
    return known[key]


def _opened(street: Street) -> tuple[FloatArray, _AttributesFrom]:
    """Cut a closed ring in the middle of its longest segment, so that its curve starts and ends on a straight."""
    points = street.points
    longest = int(np.hypot(*np.diff(points, axis=0).T).argmax())
    middle = (points[longest] + points[longest + 1]) / 2
    opened = np.concatenate([[middle], points[longest + 1 : -1], points[: longest + 1], [middle]])
    holding = [attributes for index, attributes in street.pieces if index <= longest][-1]
    shift = len(points) - 1 - longest
    later = [(index - longest, attributes) for index, attributes in street.pieces if index > longest]
    earlier = [(index + shift, attributes) for index, attributes in street.pieces if index <= longest]
    return opened, ((0, holding), *later, *earlier)


def outer_lanes(fitted: FittedStreets, rule: Rule, street: int, along: bool) -> tuple[float, float]:
    """Return t of the middles of a street's outermost lanes of one direction, right and left as drivers see it, m."""
    lanes = end_lanes(fitted.pieces[street][0 if along else -1][2], rule, along)
    if not lanes:
        return -np.inf, np.inf
    sign = 1.0 if along else -1.0
    return sign * lanes[-1].t, sign * lanes[0].t
