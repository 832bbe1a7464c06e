"""Sidewalks come up to the kerb before corners that they would otherwise not get round.

Parking lanes end some metres before a junction anyway, and where wide strips lie between the carriageway and the
sidewalks of two arms, these lie across each other before they meet.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from osm2xodr import defaults
from osm2xodr.geometry.connecting_roads import ConnectingRoads
from osm2xodr.geometry.margins import Margins
from osm2xodr.geometry.road_parts import RoadParts
from osm2xodr.geometry.sidewalk_corners import sidewalk_corners
from osm2xodr.model import IntArray, LaneType, Rule

_Place = tuple[int, int]
"""(road end, side of the road: left 1, right -1)."""


def lay_out_corners(
    parts: RoadParts, margins: tuple[Margins, ...], cars: ConnectingRoads, rule: Rule
) -> tuple[tuple[Margins, ...], ConnectingRoads, IntArray]:
    """Connect the sidewalks of neighbouring arms, with what lies inside of them left out before corners if need be.

    Parameters
    ----------
    parts, margins
        The roads, and what lies beside them.
    cars
        The connecting roads for cars.
    rule
        Side of the road that one drives on.

    Returns
    -------
    tuple
        What lies beside the roads then.
    ConnectingRoads
        One for each corner, grouped by junction.
    (k,)
        The junctions of corners that could not be drawn, once for each.
    """
    corners, failed = sidewalk_corners(parts, margins, cars, rule)
    places = _places(failed)
    nearer = _with_sidewalks_at_kerbs(parts, margins, places)
    if nearer is margins:
        return margins, corners, failed.junction
    _, still = sidewalk_corners(parts, nearer, cars, rule)
    hopeless = set(_places(still))
    # Each side of an end faces one corner: it stays as it was where nothing is gained.
    nearer = _with_sidewalks_at_kerbs(parts, margins, [place for place in places if place not in hopeless])
    corners, failed = sidewalk_corners(parts, nearer, cars, rule)
    return nearer, corners, failed.junction


def _places(rows: ConnectingRoads) -> list[_Place]:
    """Return where the sidewalks of corners lie."""
    found = [
        *zip(rows.entry.tolist(), np.sign(rows.entry_lane).tolist(), strict=True),
        *zip(rows.exit.tolist(), np.sign(rows.exit_lane).tolist(), strict=True),
    ]
    return sorted(set(found))


def _with_sidewalks_at_kerbs(
    parts: RoadParts, margins: tuple[Margins, ...], places: Iterable[_Place]
) -> tuple[Margins, ...]:
    """Return margins with nothing but the sidewalk at some places; the same ones where nothing else was there."""
    out = list(margins)
    changed = False
    for end, side in places:
        borders = [stretch.start for stretch in parts.stretches[end // 2][1:]]
        beside = _kerbside(out[end // 2], bool(end % 2), side, borders)
        changed |= beside is not out[end // 2]
        out[end // 2] = beside
    return tuple(out) if changed else margins


def _kerbside(beside: Margins, at_end: bool, side: int, borders: Sequence[float]) -> Margins:
    piece = beside[-1 if at_end else 0]
    strips = tuple(strip for strip in piece.strips(side) if strip.type is LaneType.SIDEWALK)[:1]
    if strips == piece.strips(side):
        return beside
    inner = replace(piece, left=strips) if side > 0 else replace(piece, right=strips)
    least = defaults.CORNER_KERBSIDE
    cut = piece.end - least if at_end else piece.start + least
    # No lane section is to begin so near another.
    near = [border for border in borders if abs(border - cut) < least and piece.start < border < piece.end]
    cut = near[0] if near else cut
    if not piece.start + 2 * least < cut < piece.end - least / 2 and at_end:
        return (*beside[:-1], inner)
    if not piece.start + least / 2 < cut < piece.end - 2 * least and not at_end:
        return (inner, *beside[1:])
    if at_end:
        return (*beside[:-1], replace(piece, end=cut), replace(inner, start=cut))
    return (replace(inner, end=cut), replace(piece, start=cut), *beside[1:])
