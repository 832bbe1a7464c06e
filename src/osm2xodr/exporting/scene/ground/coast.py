"""The sea: what lies on the right of coastlines, of which some end in the file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import shapely

from osm2xodr.exporting.scene.ground.open_water import beside_shores
from osm2xodr.model import FloatArray

# How far ends of coasts lie within the rectangle to whose sides they go, m.
_MARGIN: Final = 50.0
# Ends of coasts go on to the nearest side unless another way drowns fewer roads by this share of them. So many are
# looked at: other ways go into so many directions. Choices: some lie on quays and bridges without tags.
_FEWER_DROWNED: Final = 0.001
_ROADS: Final = 20_000
_DIRECTIONS: Final = 8
# Of rings at most this share may lack. A choice.
_GAP: Final = 0.5
# How far from its end a line that goes on is looked at for whether it crosses a coast, m.
_OFF: Final = 0.01


def sea_of(lines: Sequence[FloatArray], box: Any, on_land: FloatArray) -> list[Any]:
    """Return the areas in and around a rectangle that lie on the right of coastlines (n, 2), m.

    Where a coast ends and another one begins, as where a file lacks a piece, they are joined if they are closer to
    each other than to the side of a rectangle around all of them. Other ends go straight on to that side, the nearest
    one, or so that fewer places of roads `on_land` (n, 2), m, lie in the sea.
    """
    if not lines:
        return []
    merged = shapely.get_parts(shapely.line_merge(shapely.MultiLineString(lines), directed=True))
    around = shapely.box(*shapely.total_bounds(np.array([box, *merged], object))).buffer(_MARGIN, join_style="mitre")
    side = shapely.get_exterior_ring(around)
    coast, ends = _joined(merged, side)
    roads = shapely.points(on_land[:: len(on_land) // _ROADS + 1])
    nearest = list(shapely.shortest_line(ends, side))
    out = _on_the_right(coast, [*nearest, side])
    drowned = _drowned(out, roads)
    for row, end in enumerate(ends):
        if drowned <= _FEWER_DROWNED * len(roads):
            break
        for other in _rays(end, coast, side):
            areas = _on_the_right(coast, [*nearest[:row], other, *nearest[row + 1 :], side])
            count = _drowned(areas, roads)
            if count < drowned - _FEWER_DROWNED * len(roads):
                out, drowned, nearest[row] = areas, count, other
    return out


def _joined(merged: Any, side: Any) -> tuple[Any, Any]:
    """Return coasts with the gaps between them closed, and the ends that are left."""
    lone = merged[~shapely.is_closed(merged)]
    first, last = shapely.get_point(lone, 0), shapely.get_point(lone, -1)
    apart = shapely.distance(last[:, None], first[None])
    far = np.minimum(shapely.distance(last, side)[:, None], shapely.distance(first, side)[None])
    # A coast goes on to its own begin if it is a ring but for a piece.
    np.fill_diagonal(far, np.minimum(far.diagonal(), _GAP * shapely.length(lone)))
    apart = np.where(apart < far, apart, np.inf)
    gaps, free = [], np.ones((2, len(lone)), np.bool_)
    while apart.size and np.isfinite(apart.min()):
        row, column = np.unravel_index(np.argmin(apart), apart.shape)
        gaps.append(shapely.LineString([last[row], first[column]]))
        free[0, column] = free[1, row] = False
        apart[row] = apart[:, column] = np.inf
    return np.concatenate([merged, np.array(gaps, object)]), np.concatenate([first[free[0]], last[free[1]]])


def _rays(end: Any, coast: Any, side: Any) -> list[Any]:
    """Return lines from an end to the side that cross no coast."""
    x, y = shapely.get_coordinates(end)[0]
    far, out = shapely.length(side), []
    for angle in 2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS:
        ahead = np.array([np.cos(angle), np.sin(angle)])
        ray = shapely.LineString([(x, y) + _OFF * ahead, (x, y) + far * ahead])
        if not shapely.intersects(coast, ray).any():
            out.append(shapely.LineString([end, shapely.intersection(ray, side)]))
    return out


def _on_the_right(coast: Any, more: Sequence[Any]) -> list[Any]:
    """Return the areas between coasts and other lines that lie on the right of coasts."""
    areas = shapely.get_parts(shapely.polygonize([shapely.union_all([*coast, *more])]))
    left, right, length = beside_shores(coast)
    tree, share = shapely.STRtree(areas), np.zeros(len(areas))
    for places, way in ((right, 1.0), (left, -1.0)):
        at, area = tree.query(shapely.points(places), predicate="intersects")
        share += way * np.bincount(area, weights=length[at], minlength=len(areas))
    return list(areas[share > 0.0])


def _drowned(areas: Sequence[Any], roads: Any) -> int:
    """Return how many places of roads lie in areas."""
    return len(np.unique(shapely.STRtree(roads).query(np.array(areas, object), predicate="contains")[1]))
