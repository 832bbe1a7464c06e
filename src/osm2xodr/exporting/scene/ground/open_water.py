"""The sea, and water whose outline is not whole in the file: shores are closed along the side of the area."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import shapely

from osm2xodr.curves import connected_groups
from osm2xodr.exporting.scene.ground.defaults import BESIDE_SHORE, MOST_FLOODED
from osm2xodr.model import BoolArray, FloatArray, IntArray

# How far ends of coasts lie within the rectangle to whose sides they go, m.
_MARGIN: Final = 50.0
# Ends of coasts go on to the nearest side unless another way drowns fewer roads by this share of them. So many are
# looked at: other ways go into so many directions. Choices: some lie on quays and bridges without tags.
_FEWER_FLOODED: Final = 0.001
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
    flooded = _flooded(out, roads)
    for row, end in enumerate(ends):
        if flooded <= _FEWER_FLOODED * len(roads):
            break
        for other in _rays(end, coast, side):
            areas = _on_the_right(coast, [*nearest[:row], other, *nearest[row + 1 :], side])
            count = _flooded(areas, roads)
            if count < flooded - _FEWER_FLOODED * len(roads):
                out, flooded, nearest[row] = areas, count, other
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


def _flooded(areas: Sequence[Any], roads: Any) -> int:
    """Return how many places of roads lie in areas."""
    return len(np.unique(shapely.STRtree(roads).query(np.array(areas, object), predicate="contains")[1]))


# ---------------------------------------------------------------- areas that are not whole


def closed_water(shores: Sequence[FloatArray], area: Any, on_land: FloatArray) -> Any | None:
    """Return the water in an area of which only some shores are known.

    The shores part the area into faces that are water and land in turn: water are those with fewer roads, if hardly
    any are there. Shores that end within the area go straight on to its side.

    Parameters
    ----------
    shores
        Inertial x, y (n, 2), m, of pieces of the outline.
    area
        Polygon in which water is wanted and the file knows of it.
    on_land
        Inertial x, y, m, of places all over the roads that stand on the ground, (n, 2).

    Returns
    -------
    polygons or None
        Empty where no shore lies in the area; None if shores do not part the area, or it is not clear on which side
        there is water.
    """
    known = shapely.union_all([shapely.LineString(shore) for shore in shores])
    inside = shapely.intersection(known, area)
    if shapely.length(inside) == 0.0:
        return shapely.MultiPolygon()
    side = shapely.get_exterior_ring(area)
    more = _continued(known, area, side)
    if shapely.length(more) > shapely.length(inside):
        return None
    lines = shapely.union(known, more)
    faces = shapely.get_parts(shapely.polygonize([shapely.union(lines, side)]))
    faces = faces[shapely.contains_properly(area, shapely.point_on_surface(faces))]
    of_one = _parted(faces, shapely.intersection(lines, area))
    return None if of_one is None else _wet(faces, of_one, on_land)


def _continued(shores: Any, area: Any, side: Any) -> Any:
    """Return straight lines to the side of an area from where shores end in it."""
    merged = shapely.get_parts(shapely.line_merge(shores))
    merged = merged[~shapely.is_closed(merged)]
    ends = np.concatenate([shapely.get_point(merged, 0), shapely.get_point(merged, -1)])
    ends = ends[shapely.contains_properly(area, ends)]
    at, count = np.unique(shapely.get_coordinates(ends), axis=0, return_counts=True)
    # Where three lines or more meet none of them ends.
    lone = shapely.points(at[count == 1])
    return shapely.union_all(shapely.shortest_line(lone, side))


def _parted(faces: Any, lines: Any) -> BoolArray | None:
    """Return the faces on one side of lines, (n,); None if these do not part them in two."""
    *sides, length = beside_shores(shapely.get_parts(lines))
    left, right = (_face_at(faces, xy[length > BESIDE_SHORE]) for xy in sides)
    found = (left >= 0) & (right >= 0) & (left != right)
    left, right, total = left[found], right[found], len(faces)
    # Each face is twice there, as water and as land: what is joined holds together.
    start, end = np.concatenate([left, left + total]), np.concatenate([right + total, right])
    group = connected_groups(2 * total, start, end)
    if total < 2 or group.max() != 1:
        return None
    out: BoolArray = group[:total] == 0
    return out


def beside_shores(lines: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return places on the left and on the right of the pieces of lines, (n, 2), and the pieces' lengths, (n,), m."""
    at, row = shapely.get_coordinates(lines, return_index=True)
    a, b = at[:-1][row[1:] == row[:-1]], at[1:][row[1:] == row[:-1]]
    length = np.hypot(*(b - a).T)
    a, b, length = a[length > 0.0], b[length > 0.0], length[length > 0.0]
    right = np.column_stack([(b - a)[:, 1], (a - b)[:, 0]]) * (BESIDE_SHORE / length)[:, None]
    return 0.5 * (a + b) - right, 0.5 * (a + b) + right, length


def _face_at(faces: Any, xy: FloatArray) -> IntArray:
    """Return the face at each place, (n,), -1 for none."""
    out = np.full(len(xy), -1)
    at, face = shapely.STRtree(faces).query(shapely.points(xy), predicate="intersects")
    out[at] = face
    return out


def _wet(faces: Any, of_one: BoolArray, on_land: FloatArray) -> Any | None:
    """Return the side of faces that is water; None if it is not clear."""
    sides = [shapely.union_all(faces[of]) for of in (of_one, ~of_one)]
    for side in sides:
        shapely.prepare(side)
    few, many = sorted((np.count_nonzero(shapely.contains_xy(side, *on_land.T)), k) for k, side in enumerate(sides))
    return sides[few[1]] if few[0] < MOST_FLOODED * many[0] else None
