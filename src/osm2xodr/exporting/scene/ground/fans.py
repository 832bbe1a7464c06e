"""Corners of the ground where it stands at two heights: steps at the edges of roads and portals of tunnels.

Around such a place the triangles of the ground form fans, each from one edge of a road to the next. If these differ
in height the fan is split along one of its spokes, and a vertical triangle stands between its parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from osm2xodr.model import FloatArray, IntArray


@dataclass(frozen=True)
class _Spokes:
    """A fan of triangles around a place."""

    around: tuple[int, ...]  # The other ends of its spokes, counter-clockwise, one more than triangles
    triangles: tuple[int, ...]  # Rows
    heights: tuple[int, int]  # The points that the place is where the fan begins and where it ends


def raised_triangles(
    triangles: IntArray, xyz: FloatArray, place: IntArray, rim: IntArray
) -> tuple[IntArray, IntArray]:
    """Return triangles (n, 3) of points instead of places, and the walls between split fans (k, 3) likewise.

    Triangles consist of places; `place`, (points,), is that of each point of `xyz`, (points, 3), m. `rim`, (m, 2),
    are edges of points that have the road on their left: those that the ground has to meet. Places without an edge
    have one point.
    """
    point = np.zeros(int(place.max()) + 1, np.int64)
    # The last one stays; of a place that ground stands at in two heights it is replaced below.
    point[place] = np.arange(len(place))
    point[place[rim[:, 0]]] = rim[:, 0]
    out = point[triangles]
    ends = np.concatenate([place[rim.ravel()][:, None], rim.reshape(-1, 1)], 1)
    several = np.unique(ends, axis=0)[:, 0]
    several = several[1:][several[1:] == several[:-1]]
    if not len(several):
        return out, np.zeros((0, 3), np.int64)
    walls: list[tuple[int, int, int, int]] = []
    # Triangles around the places in question, with the place first.
    row, corner = np.nonzero(np.isin(triangles, several))
    owner = triangles[row, corner]
    others = np.column_stack([triangles[row, (corner + 1) % 3], triangles[row, (corner + 2) % 3]])
    before, behind = _edges_at(rim, place, np.unique(several))
    order = np.argsort(owner, kind="stable")
    starts = np.searchsorted(owner[order], np.unique(several), "left")
    stops = np.searchsorted(owner[order], np.unique(several), "right")
    for here, start, stop in zip(np.unique(several).tolist(), starts.tolist(), stops.tolist(), strict=True):
        rows = order[start:stop]
        for fan in _fans(row[rows].tolist(), others[rows].tolist(), before[here], behind[here]):
            split = _split(fan, xyz, point, here)
            for k, triangle in enumerate(fan.triangles):
                out[triangle, triangles[triangle] == here] = fan.heights[k >= split]
            if fan.heights[0] != fan.heights[1]:
                beside = fan.triangles[max(split - 1, 0)]
                walls.append((*fan.heights, beside, fan.around[split]))
    return out, np.array([_wall(out, triangles, *wall) for wall in walls], np.int64).reshape(-1, 3)


def _edges_at(
    rim: IntArray, place: IntArray, places: IntArray
) -> tuple[dict[int, dict[int, int]], dict[int, dict[int, int]]]:
    """Return by place the edges that come to it and that leave it: the place they join it to, and its point."""
    before: dict[int, dict[int, int]] = {int(item): {} for item in places}
    behind: dict[int, dict[int, int]] = {int(item): {} for item in places}
    for a, b in rim[np.isin(place[rim], places).any(1)].tolist():
        one, other = int(place[a]), int(place[b])
        if one == other:
            continue
        if other in before:
            before[other][one] = b
        if one in behind:
            behind[one][other] = a
    return before, behind


def _fans(
    rows: Sequence[int], others: Sequence[Sequence[int]], before: dict[int, int], behind: dict[int, int]
) -> list[_Spokes]:
    """Return the fans around a place: they begin at an edge that comes to it and end at one that leaves it."""
    follows = {first: (row, second) for row, (first, second) in zip(rows, others, strict=True)}
    out = []
    for first in sorted(before):
        around, triangles = [first], list[int]()
        while around[-1] in follows and (len(around) == 1 or around[-1] not in behind):
            row, last = follows[around[-1]]
            triangles.append(row)
            around.append(last)
        if triangles and around[-1] in behind:
            out.append(_Spokes(tuple(around), tuple(triangles), (before[first], behind[around[-1]])))
    return out


def _split(fan: _Spokes, xyz: FloatArray, point: IntArray, here: int) -> int:
    """Return the spoke at which a fan is split: that which goes on straight from the higher edge's line."""
    low, high = xyz[list(fan.heights), 2]
    ends = xyz[point[list(fan.around)], :2] - xyz[point[here], :2]
    ends /= np.maximum(np.hypot(*ends.T), 1e-9)[:, None]
    return int(np.argmin(ends @ ends[-1 if high > low else 0]))


def _wall(out: IntArray, triangles: IntArray, first: int, last: int, beside: int, end: int) -> tuple[int, int, int]:
    """Return the triangle between the parts of a fan, whose spoke ends at a place."""
    return first, int(out[beside][triangles[beside] == end][0]), last
