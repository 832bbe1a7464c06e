"""Sidewalks move to the kerb, or become narrower, before corners that they otherwise would not get round.

Behind wide strips, the sidewalks of two arms cross each other before they meet. At acute corners even sidewalks at
the kerb do: each of them gets what lies on its side of the middle between both kerbs, and so both end in one wedge.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import sorted_unique
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.roadside import defaults
from osm2xodr.geometry.roadside.corner_pairs import Place, places_of
from osm2xodr.geometry.roadside.corner_wedges import wedges
from osm2xodr.geometry.roadside.sidewalk_corners import sidewalk_corners
from osm2xodr.geometry.roadside.strips import Margins, with_wedge
from osm2xodr.model import IntArray, LaneType, Rule

# Shares of their room that sidewalks get in a wedge: the first that helps. Choices: corners may need more room than a
# circle round their tip.
_TRIES: Final = (1.0, 0.9)


def lay_out_corners(
    parts: RoadParts, margins: tuple[Margins, ...], cars: ConnectingRoads, rule: Rule
) -> tuple[tuple[Margins, ...], ConnectingRoads, IntArray]:
    """Connect the sidewalks of neighbouring arms; where necessary, leave out the strips inside them before corners.

    Returns the strips beside the roads afterwards, a connecting road for each corner, grouped by junction, and the
    junctions of corners that could not be drawn, one for each, (k,).
    """
    corners, failed = sidewalk_corners(parts, margins, cars, rule)
    for share in _TRIES:
        tried = _at_kerb(parts, margins, failed, share)
        if tried is margins:
            continue
        _, still_failed = sidewalk_corners(parts, tried, cars, rule, sorted_unique(failed.junction))
        lost = set(places_of(still_failed))
        hopeless = np.array([corner in lost for corner in places_of(failed)], bool)
        # Each side of an end faces one corner: it stays as it was where nothing is gained.
        changed = _at_kerb(parts, margins, failed.chosen(~hopeless), share)
        if changed is margins:
            continue
        # Lanes may get other ids at the far ends of these roads, too.
        roads = [k for k, (one, other) in enumerate(zip(margins, changed, strict=True)) if one is not other]
        junctions = sorted_unique(parts.end_junction[np.array(roads, np.int64)])
        margins = changed
        again, failed_again = sidewalk_corners(parts, margins, cars, rule, junctions[junctions >= 0])
        corners = corners.chosen(~np.isin(corners.junction, junctions)).joined(again)
        failed = failed.chosen(~np.isin(failed.junction, junctions)).joined(failed_again)
    return margins, corners, failed.junction


def _at_kerb(
    parts: RoadParts, margins: tuple[Margins, ...], rows: ConnectingRoads, share: float
) -> tuple[Margins, ...]:
    """Let sidewalks of some corners end at the kerb, without the strips inside them, and in wedges for want of room.

    These get a share of the room between both kerbs. Returns the very same margins where nothing changes.
    """
    places = sorted({place for corner in places_of(rows) for place in corner})
    out = _without_inner_strips(parts, margins, places)
    for end, wedge in wedges(parts, rows, share):
        out[end // 2] = with_wedge(out[end // 2], wedge)
    return margins if all(one is other for one, other in zip(margins, out, strict=True)) else tuple(out)


def _without_inner_strips(parts: RoadParts, margins: tuple[Margins, ...], places: Iterable[Place]) -> list[Margins]:
    """Return margins with sidewalks alone at some places; the very same strips beside roads where nothing changes."""
    out = list(margins)
    for end, side in places:
        borders = [stretch.start for stretch in parts.stretches[end // 2][1:]]
        out[end // 2] = _changed_end(out[end // 2], bool(end % 2), side, borders)
    return out


def _changed_end(beside: Margins, at_end: bool, side: int, borders: Sequence[float]) -> Margins:
    """Leave a sidewalk alone at one side over a road's last metres, or over its last stretch where that is short."""
    piece = beside[-1 if at_end else 0]
    strips = tuple(strip for strip in piece.strips(side) if strip.type is LaneType.SIDEWALK)[:1]
    if strips == piece.strips(side):
        return beside
    inner = replace(piece, left=strips) if side > 0 else replace(piece, right=strips)
    least = defaults.CORNER_KERBSIDE
    cut = piece.end - least if at_end else piece.start + least
    # No lane section may begin so near another.
    near = [border for border in borders if abs(border - cut) < least and piece.start < border < piece.end]
    cut = near[0] if near else cut
    first, last = (2.0, 0.5) if at_end else (0.5, 2.0)
    if not piece.start + first * least < cut < piece.end - last * least:
        return (*beside[:-1], inner) if at_end else (inner, *beside[1:])
    if at_end:
        return (*beside[:-1], replace(piece, end=cut), replace(inner, start=cut))
    return (replace(inner, end=cut), replace(piece, start=cut), *beside[1:])
