"""Sidewalks move to the kerb, or become narrower, before corners that they otherwise would not get round.

Behind wide strips, the sidewalks of two arms cross each other before they meet; parking ends some metres before a
junction anyway. At acute corners even sidewalks at the kerb do: each of them gets what lies on its side of the middle
between both kerbs, and so both end in one wedge.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junctions import RoadParts, end_poses
from osm2xodr.geometry.margins import defaults
from osm2xodr.geometry.margins.sidewalk_corners import sidewalk_corners
from osm2xodr.geometry.margins.strips import Margins, Strips, Wedge
from osm2xodr.model import FloatArray, IntArray, LaneType, Rule

# Shares of their room that sidewalks get in a wedge, the first that helps. Choices.
_SHARES_OF_ROOM: Final = (1.0, 0.6)
# Least width of a sidewalk where it ends in a wedge, m: about a kerbstone's. A choice.
_LEAST_WIDTH: Final = 0.1
# Where both kerbs end farther apart than this, m, is no tip: sidewalks are at least so wide, m, or none is led on
# there. Choices.
_LARGEST_TIP: Final = 4.0
_LEAST_PATH: Final = 0.5
# Wedges have such lengths, m, up to this share of their road, and no steeper edges. Choices.
_WEDGE_LENGTH: Final = (1.0, 12.0)
_SHARE_OF_ROAD: Final = 0.45
_STEEPEST: Final = 1.0
# Arms that part at more than this, rad (150 degrees), leave room for any sidewalk between them. Arms side by side may
# come closer by this angle, rad, away from the junction.
_LARGEST_ANGLE: Final = 2.6
_MOST_CLOSING: Final = 0.5
# Edges of wedges between such arms go by this slope: as long as wedges may be.
_LEAST_SLOPE: Final = 1e-3

_Place = tuple[int, int]  # (road end, side of the road: left 1, right -1)
_Change = Callable[[RoadParts, tuple[Margins, ...], ConnectingRoads], tuple[Margins, ...]]


def lay_out_corners(
    parts: RoadParts, margins: tuple[Margins, ...], cars: ConnectingRoads, rule: Rule
) -> tuple[tuple[Margins, ...], ConnectingRoads, IntArray]:
    """Connect the sidewalks of neighbouring arms; where necessary, leave out the strips inside them before corners.

    Returns the strips beside the roads afterwards, a connecting road for each corner, grouped by junction, and the
    junctions of corners that could not be drawn, one for each, (k,).
    """
    corners, failed = sidewalk_corners(parts, margins, cars, rule)
    changes: list[_Change] = [_kerbside, *(partial(_wedged, share=share) for share in _SHARES_OF_ROOM)]
    for change in changes:
        tried = change(parts, margins, failed)
        if tried is margins:
            continue
        _, still_failed = sidewalk_corners(parts, tried, cars, rule, np.unique(failed.junction))
        lost = set(_corner_of(still_failed))
        hopeless = np.array([corner in lost for corner in _corner_of(failed)], bool)
        # Each side of an end faces one corner: it stays as it was where nothing is gained.
        changed = change(parts, margins, failed.chosen(~hopeless))
        if changed is margins:
            continue
        # Lanes may get other ids at the far ends of these roads, too.
        roads = [k for k, (one, other) in enumerate(zip(margins, changed, strict=True)) if one is not other]
        junctions = np.unique(parts.end_junction[np.array(roads, np.int64)])
        margins = changed
        again, failed_again = sidewalk_corners(parts, margins, cars, rule, junctions[junctions >= 0])
        corners = corners.chosen(~np.isin(corners.junction, junctions)).joined(again)
        failed = failed.chosen(~np.isin(failed.junction, junctions)).joined(failed_again)
    return margins, corners, failed.junction


def _corner_of(rows: ConnectingRoads) -> list[tuple[_Place, _Place]]:
    """Return the two places that each corner connects."""
    entry = zip(rows.entry.tolist(), np.sign(rows.entry_lane).tolist(), strict=True)
    exit_ = zip(rows.exit.tolist(), np.sign(rows.exit_lane).tolist(), strict=True)
    return list(zip(entry, exit_, strict=True))


def _kerbside(parts: RoadParts, margins: tuple[Margins, ...], rows: ConnectingRoads) -> tuple[Margins, ...]:
    """Leave out the strips inside the sidewalks of some corners over their last metres."""
    places = sorted({place for corner in _corner_of(rows) for place in corner})
    return _changed(parts, margins, places, _sidewalk_alone)


def _wedged(
    parts: RoadParts, margins: tuple[Margins, ...], rows: ConnectingRoads, share: float
) -> tuple[Margins, ...]:
    """Let sidewalks of some corners end at the kerb, in wedges with a share of the room between both kerbs.

    Both get the same width, that of the end with less room: they go round one tip.
    """
    room, slope, apart = _room(parts, rows)
    wide = np.column_stack([rows.entry_width, rows.exit_width])
    width = np.maximum(share * np.minimum(room[:, None] - 1.1 * defaults.CORNER_TIP_RADIUS, wide), _LEAST_WIDTH)
    width = np.floor(100.0 * width) / 100.0
    length = np.clip((wide - share * room[:, None]) / slope[:, None], *_WEDGE_LENGTH)
    found: list[tuple[int, Wedge]] = []
    enough = (apart <= _LARGEST_TIP) | (width.min(axis=1) >= _LEAST_PATH)
    rows = rows.chosen(enough)
    columns = (array[enough].tolist() for array in (wide, width, length))
    for corner, *sizes in zip(_corner_of(rows), *columns, strict=True):
        for (end, side), before, to, over in zip(corner, *sizes, strict=True):
            if to < before - defaults.SAME_PLACE:
                over = min(over, _SHARE_OF_ROAD * float(parts.length[end // 2]))
                found.append((end, Wedge(side, end % 2 == 1, to, over)))
    if not found:
        return margins
    out = list(_kerbside(parts, margins, rows))
    for end, wedge in found:
        beside = out[end // 2]
        kept = (item for item in beside[-(end % 2)].wedges if not item.lies_at(end, wedge.side))
        last = replace(beside[-(end % 2)], wedges=(*kept, wedge))
        out[end // 2] = (*beside[:-1], last) if end % 2 else (last, *beside[1:])
    return tuple(out)


def _room(parts: RoadParts, rows: ConnectingRoads) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return how far the middle between both kerbs is from the nearer one where that ends, m, and its slope, (rows,).

    The third array has how far the ends of both kerbs are from each other, m. Kerbs count as straight; where they do
    not face each other, there is room for anything.
    """
    kerbs = []
    for end, lane in ((rows.entry, rows.entry_lane), (rows.exit, rows.exit_lane)):
        x, y, hdg = end_poses(parts, end)
        sections = [parts.at_end(item).section for item in end.tolist()]
        t = np.where(lane > 0, [item.left_edge for item in sections], [item.right_edge for item in sections])
        normal = np.sign(lane)[:, None] * np.column_stack([-np.sin(hdg), np.cos(hdg)])
        outwards = np.where(end % 2 == 1, -1.0, 1.0)[:, None] * np.column_stack([np.cos(hdg), np.sin(hdg)])
        kerbs.append((np.column_stack([x - t * np.sin(hdg), y + t * np.cos(hdg)]), normal, outwards))
    (one, normal, outwards), (other, facing, away) = kerbs
    cos = (outwards * away).sum(1)
    # Arms that run side by side may come closer a little, too.
    angle = np.arctan2((normal * away).sum(1), cos)
    acute = (angle < _LARGEST_ANGLE) & (angle > -_MOST_CLOSING)
    apart = np.minimum((facing * (one - other)).sum(1), (normal * (other - one)).sum(1))
    room = np.where(acute, apart / np.where(acute, 1.0 + cos, 1.0), np.inf)
    slope = np.clip(np.where(acute, np.tan(angle / 2), _STEEPEST), _LEAST_SLOPE, _STEEPEST)
    return room, slope, np.hypot(*(other - one).T)


def _sidewalk_alone(strips: Strips) -> Strips:
    return tuple(strip for strip in strips if strip.type is LaneType.SIDEWALK)[:1]


def _changed(
    parts: RoadParts, margins: tuple[Margins, ...], places: Iterable[_Place], change: Callable[[Strips], Strips]
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


def _changed_end(
    beside: Margins, at_end: bool, side: int, borders: Sequence[float], change: Callable[[Strips], Strips]
) -> Margins:
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
