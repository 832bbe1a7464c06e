"""Water whose outline is not whole in the file: its shores are closed along the side of the area."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from osm2xodr.exporting.scene.ground.defaults import BESIDE_SHORE, MOST_DROWNED
from osm2xodr.model import BoolArray, FloatArray, IntArray


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
    pairs = coo_array((np.ones(len(start)), (start, end)), shape=(2 * total, 2 * total))
    count, group = connected_components(pairs, directed=False)
    if total < 2 or count != 2:
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
    return sides[few[1]] if few[0] < MOST_DROWNED * many[0] else None
