"""Streets that run side by side move apart, and their lanes become narrow enough, for both carriageways to fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from osm2xodr.curves import lengths, sorted_unique, starts
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.defaults import PARALLEL_SPACING
from osm2xodr.geometry.lanes import Piece, cross_section
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.geometry.plan_view.parallel_places import TightPlaces, places_abreast, tight_places
from osm2xodr.geometry.plan_view.streets import FittedStreets
from osm2xodr.model import VEHICLE_LANES, FloatArray, IntArray, LaneSpec, Rule, StreetAttributes, StreetNetwork

# Streets move aside by this or more, m; a choice.
_LEAST_ASIDE: Final = 0.15


def separate_parallel_streets(
    network: StreetNetwork, fitted: FittedStreets, diagnostics: Diagnostics
) -> FittedStreets:
    """Move streets aside, and narrow their lanes, where their carriageways would overlap those of a parallel street.

    OSM gives the middle of carriageways, seldom their width, and neither is exact. What they lack is shared by how
    uncertain both are (least squares). Then lanes become as narrow as is needed still.
    """
    abreast = places_abreast(network, fitted)
    tight = tight_places(abreast, fitted)
    tight = tight.chosen(np.flatnonzero(np.abs(tight.aside) > _LEAST_ASIDE))
    moved = _changed(fitted, tight, network.rule, partial(_moved, diagnostics))
    tight = tight_places(abreast, moved)
    tight = tight.chosen(np.flatnonzero(tight.share < 1.0))
    return _changed(moved, tight, network.rule, partial(_narrowed, diagnostics))


def _changed(
    fitted: FittedStreets,
    tight: TightPlaces,
    rule: Rule,
    change: Callable[[StreetAttributes, TightPlaces], StreetAttributes],
) -> FittedStreets:
    """Return streets of which the parts around tight places change."""
    first = starts([len(pieces) for pieces in fitted.pieces])
    length = lengths(fitted.plan_view)
    out = list(fitted.pieces)
    for k in sorted_unique(tight.street).tolist():
        ends = [*(s for s, _, _ in fitted.pieces[k][1:]), float(length[k])]
        own: list[Piece] = []
        for number, (piece, end) in enumerate(zip(fitted.pieces[k], ends, strict=True), start=int(first[k])):
            places = tight.chosen(slice(*np.searchsorted(tight.piece, (number, number + 1)).tolist()))
            for s, rows in _stretches(places.s, piece[0], end):
                new = change(piece[1], places.chosen(rows)) if len(rows) else piece[1]
                own.append((s, new, piece[2] if new is piece[1] else cross_section(new, rule)))
        out[k] = tuple(own)
    return replace(fitted, pieces=tuple(out))


def _stretches(s: FloatArray, begin: float, end: float) -> list[tuple[float, IntArray]]:
    """Return where stretches begin along a piece of a street, and which of its tight places lie on them."""
    if not len(s):
        return [(begin, np.arange(0))]
    # What lies between and beside them has to be worth a change.
    reach = 0.5 * PARALLEL_SPACING + defaults.SEPARATED_BEYOND
    apart = np.flatnonzero(np.diff(s) > 2.0 * reach + defaults.SHORTEST_BETWEEN) + 1
    out: list[tuple[float, IntArray]] = []
    for rows in np.split(np.arange(len(s)), apart):
        first, last = float(s[rows[0]]) - reach, float(s[rows[-1]]) + reach
        if not out and first - begin < defaults.SHORTEST_BETWEEN:
            first = begin
        elif not out:
            out.append((begin, np.arange(0)))
        out.append((first, rows))
        if end - last >= defaults.SHORTEST_BETWEEN:
            out.append((last, np.arange(0)))
    return out


def _moved(diagnostics: Diagnostics, attributes: StreetAttributes, tight: TightPlaces) -> StreetAttributes:
    """Return a part of a street that moves away from others beside it."""
    aside = round(float(max(tight.aside.max(), 0.0) + min(tight.aside.min(), 0.0)), 2)
    if not aside:
        # Streets on both sides want as much.
        return attributes
    text = f"it lies {abs(aside):.2f} m farther from a parallel road than OSM's lines, which leave no room for both"
    diagnostics.repaired("moved-aside", f"way/{attributes.osm_way_id}", text)
    return replace(attributes, moved_aside=aside)


def _narrowed(diagnostics: Diagnostics, attributes: StreetAttributes, tight: TightPlaces) -> StreetAttributes:
    """Return a part of a street with lanes as narrow as others beside it want."""
    share = float(tight.share.min())
    lanes = tuple(replace(lane, width=_width(lane, share)) for lane in attributes.lanes_ltr)
    text = f"its lanes are drawn at {100 * share:.0f} % of their width, a parallel road leaves no more room"
    both = zip(lanes, attributes.lanes_ltr, strict=True)
    if any(lane.width > round(old.width * share, 2) for lane, old in both):
        text += f"; lanes for cars do not get below {defaults.NARROWEST_LANE:g} m and may overlap it"
    diagnostics.repaired("lanes-narrowed", f"way/{attributes.osm_way_id}", text)
    return replace(attributes, lanes_ltr=lanes)


def _width(lane: LaneSpec, share: float) -> float:
    """Return the width of a lane that may keep a share of it, m."""
    width = round(lane.width * share, 2)
    return max(width, min(lane.width, defaults.NARROWEST_LANE)) if lane.type in VEHICLE_LANES else width
