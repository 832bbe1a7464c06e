"""Sidewalks move to the kerb, or become narrower, before corners that they otherwise would not get round.

Behind wide strips, the sidewalks of two arms cross each other before they meet; parking ends some metres before a
junction anyway. Where no car turns from one arm into the other, even sidewalks at the kerb may have no room to bend.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.margins import defaults
from osm2xodr.geometry.margins.sidewalk_corners import sidewalk_corners
from osm2xodr.geometry.margins.strips import Margins, Strips
from osm2xodr.model import IntArray, LaneType, Rule

# Share of its width that a sidewalk keeps before a corner that it does not get round otherwise. A choice.
_NARROWED_SHARE: Final = 0.5

_Place = tuple[int, int]  # (road end, side of the road: left 1, right -1)
_Change = Callable[[Strips], Strips]


def lay_out_corners(
    parts: RoadParts, margins: tuple[Margins, ...], cars: ConnectingRoads, rule: Rule
) -> tuple[tuple[Margins, ...], ConnectingRoads, IntArray]:
    """Connect the sidewalks of neighbouring arms; where necessary, leave out the strips inside them before corners.

    Returns the strips beside the roads afterwards, a connecting road for each corner, grouped by junction, and the
    junctions of corners that could not be drawn, one for each, (k,).
    """
    corners, failed = sidewalk_corners(parts, margins, cars, rule)
    for change in (_sidewalk_alone, _narrow_sidewalk):
        places, junctions = _places(failed), np.unique(failed.junction)
        tried = _changed(parts, margins, places, change)
        if tried is margins:
            continue
        _, still_failed = sidewalk_corners(parts, tried, cars, rule, junctions)
        hopeless = set(_places(still_failed))
        # Each side of an end faces one corner: it stays as it was where nothing is gained.
        changed = _changed(parts, margins, [place for place in places if place not in hopeless], change)
        if changed is margins:
            continue
        # Lanes may get other ids at the far ends of these roads, too.
        roads = [k for k, (one, other) in enumerate(zip(margins, changed, strict=True)) if one is not other]
        junctions = np.union1d(junctions, parts.end_junction[np.array(roads, np.int64)])
        margins = changed
        again, failed = sidewalk_corners(parts, margins, cars, rule, junctions)
        corners = corners.chosen(~np.isin(corners.junction, junctions)).joined(again)
    return margins, corners, failed.junction


def _places(rows: ConnectingRoads) -> list[_Place]:
    """Return the places of the sidewalks that corners connect."""
    found = [
        *zip(rows.entry.tolist(), np.sign(rows.entry_lane).tolist(), strict=True),
        *zip(rows.exit.tolist(), np.sign(rows.exit_lane).tolist(), strict=True),
    ]
    return sorted(set(found))


def _sidewalk_alone(strips: Strips) -> Strips:
    return tuple(strip for strip in strips if strip.type is LaneType.SIDEWALK)[:1]


def _narrow_sidewalk(strips: Strips) -> Strips:
    return tuple(replace(strip, width=_NARROWED_SHARE * strip.width) for strip in _sidewalk_alone(strips))


def _changed(
    parts: RoadParts, margins: tuple[Margins, ...], places: Iterable[_Place], change: _Change
) -> tuple[Margins, ...]:
    """Return margins with changed strips at some places; the very same margins where nothing changes."""
    out = list(margins)
    changed = False
    for end, side in places:
        borders = [stretch.start for stretch in parts.stretches[end // 2][1:]]
        beside = _changed_end(out[end // 2], bool(end % 2), side, borders, change)
        changed |= beside is not out[end // 2]
        out[end // 2] = beside
    return tuple(out) if changed else margins


def _changed_end(beside: Margins, at_end: bool, side: int, borders: Sequence[float], change: _Change) -> Margins:
    """Change the strips at one side over a road's last metres, or over its last stretch where that is short."""
    piece = beside[-1 if at_end else 0]
    strips = change(piece.strips(side))
    if strips == piece.strips(side):
        return beside
    inner = replace(piece, left=strips) if side > 0 else replace(piece, right=strips)
    least = defaults.CORNER_KERBSIDE
    cut = piece.end - least if at_end else piece.start + least
    # No lane section may begin so near another.
    near = [border for border in borders if abs(border - cut) < least and piece.start < border < piece.end]
    cut = near[0] if near else cut
    if at_end:
        splits = piece.start + 2 * least < cut < piece.end - least / 2
        return (*beside[:-1], *((replace(piece, end=cut), replace(inner, start=cut)) if splits else (inner,)))
    splits = piece.start + least / 2 < cut < piece.end - 2 * least
    return (*((replace(inner, end=cut), replace(piece, start=cut)) if splits else (inner,)), *beside[1:])
