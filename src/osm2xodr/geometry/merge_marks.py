"""Road marks within splits and merges: lines run on where lanes do.

Crossings have no marks inside. Where carriageways part or join, lanes go on side by side for a hundred metres, and so
do the lines between and beside them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import starmap
from typing import Final

import numpy as np

from osm2xodr.curves import lengths, pose, ranks
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.lanes import NO_MARK, LaneLayout
from osm2xodr.geometry.merge_setbacks import merge_stems
from osm2xodr.model import FloatArray, IntArray, RoadMark, Rule

# Edges of lanes are looked at every so many metres, but not at their ends.
_SPACING: Final = 2.0
_ENDS: Final = 3.0
# An edge lies in another lane if it is so deep inside, and on its edge if it is so near to that, m. Choices.
_INSIDE: Final = 0.4
# It has the line between two lanes if it is the edge of both for this share of its length. A choice.
_SHARED: Final = 0.6

Marks = tuple[RoadMark, RoadMark]
"""The marks on the inner and the outer edge of a connecting road's lane; the inner one is nearer to lane 0."""


def merge_marks(
    parts: RoadParts, connecting: ConnectingRoads, lanes: Sequence[LaneLayout], rule: Rule
) -> dict[int, Marks]:
    """Return the marks of the connecting roads of splits and merges, by their indices.

    An edge that no other lane crosses has a mark: that between lanes where it is the edge of another lane, too (of
    both lanes the one that lies nearer to lane 0 has it), else that of the carriageway's edge.
    """
    out: dict[int, Marks] = {}
    merge = np.flatnonzero(merge_stems(parts, connecting) >= 0)
    for rows in np.split(merge, np.flatnonzero(np.diff(connecting.junction[merge])) + 1) if len(merge) else []:
        own = _places(connecting, rows)
        for k, row in enumerate(rows.tolist()):
            edges = (_edge(own, k, side) for side in ((1, -1) if rule is Rule.RIGHT_HAND else (-1, 1)))
            kinds = _kinds(parts, connecting, lanes, row)
            inner, outer = starmap(_mark, zip(edges, kinds, strict=True))
            # The line between two lanes is painted once.
            out[row] = NO_MARK if inner.type.startswith("broken") else inner, outer
    return {row: marks for row, marks in out.items() if marks != (NO_MARK, NO_MARK)}


def _places(connecting: ConnectingRoads, rows: IntArray) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
    """Return places along the middles of lanes: which of the rows, x and y, heading, half of the width; all (m,)."""
    length = lengths(connecting.plan_view, rows)
    count = np.maximum((length / _SPACING).astype(np.int64), 2) + 1
    of = np.repeat(np.arange(len(rows)), count)
    share = ranks(count) / (count - 1)[of]
    x, y, hdg = pose(connecting.plan_view, rows[of], share * length[of])
    width = connecting.entry_width[rows][of] * (1 - share) + connecting.exit_width[rows][of] * share
    return of, np.column_stack([x, y]), hdg, 0.5 * width


def _edge(places: tuple[IntArray, FloatArray, FloatArray, FloatArray], row: int, side: int) -> str:
    """Return what the left (1) or right edge of one of the lanes is: ``inside`` another, ``shared``, ``free``."""
    of, xy, hdg, half = places
    own = np.flatnonzero(of == row)
    edge = xy[own] + side * half[own, None] * np.column_stack([-np.sin(hdg[own]), np.cos(hdg[own])])
    far = (np.hypot(*(edge - edge[0]).T) > _ENDS) & (np.hypot(*(edge - edge[-1]).T) > _ENDS)
    edge = edge[far]
    if not len(edge):
        return "inside"
    other = np.flatnonzero(of != row)
    step = edge[:, None, :] - xy[other]
    along = step[..., 0] * np.cos(hdg[other]) + step[..., 1] * np.sin(hdg[other])
    across = np.abs(step[..., 1] * np.cos(hdg[other]) - step[..., 0] * np.sin(hdg[other])) - half[other]
    across = np.where(np.abs(along) <= _SPACING, across, np.inf).min(axis=1, initial=np.inf)
    if (across < -_INSIDE).any():
        return "inside"
    return "shared" if np.mean(across < _INSIDE) >= _SHARED else "free"


def _kinds(
    parts: RoadParts, connecting: ConnectingRoads, lanes: Sequence[LaneLayout], row: int
) -> tuple[tuple[RoadMark, ...], tuple[RoadMark, ...]]:
    """Return the marks at the inner and the outer edges of the lanes that a connecting road joins."""
    found: list[tuple[RoadMark, RoadMark]] = []
    for end, lane in (
        (int(connecting.entry[row]), int(connecting.entry_lane[row])),
        (int(connecting.exit[row]), int(connecting.exit_lane[row])),
    ):
        section = lanes[end // 2].sections[-1 if end % 2 else 0]
        marks = {item.id: item.road_mark or NO_MARK for item in section.lanes}
        found.append((marks[lane - int(np.sign(lane))], marks[lane]))
    inner, outer = zip(*found, strict=True)
    return inner, outer


def _mark(edge: str, kinds: tuple[RoadMark, ...]) -> RoadMark:
    """Return the mark on an edge of a lane, of those on this edge of its lane before and behind the junction."""
    wanted = {"shared": "broken", "free": "solid"}.get(edge)
    found = next((mark for mark in kinds if mark.type == wanted), NO_MARK)
    return replace(found, lane_change="none")
