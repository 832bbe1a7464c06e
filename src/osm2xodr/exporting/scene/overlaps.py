"""Where roads lie on each other, and the plane areas that show of them there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
import shapely
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from osm2xodr.exporting.scene.lane_faces import LaneFaces
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.shapes import LEVEL_APART, rank_of

# Roads lie on each other where they share more than this, m²: less comes of rounding and of chords side by side.
_LEAST_OVERLAP: Final = 1e-4
# Coordinates of cut areas are whole multiples of this, m.
GRID: Final = 1e-3
# Sides of the squares into which cut areas are divided so that they follow the surface, m: the planes of junctions
# and their slopes turn slowly. A choice.
_CELL: Final = 4.0
# Strips narrower than twice this are no area of their own, m: half of the narrowest kerb (0.1 m), rounded up.
_SLIVER: Final = 0.06


@dataclass(frozen=True, eq=False)
class Cells:
    """Areas without overlap, each of one type of lanes, and small enough to be as good as plane."""

    shape: FloatArray  # (n,) Polygons of shapely
    kind: IntArray  # (n,) Index in the kinds that were given
    group: IntArray  # (n,) Group of intervals that they are cut of


def groups_of(faces: LaneFaces) -> IntArray:
    """Return a number for each interval that overlaps others at its level, the same for all that hang together.

    Intervals that lie alone have -1.
    """
    shapes = sound(shapely.polygons(faces.outline[:, :, :2]))
    one, other = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    kept = (one < other) & ~((faces.road[one] == faces.road[other]) & (other - one == 1))
    one, other = one[kept], other[kept]
    common = shapely.intersection(shapes[one], shapes[other])
    kept = shapely.area(common) > _LEAST_OVERLAP
    one, other = one[kept], other[kept]
    middle = shapely.get_coordinates(shapely.centroid(common[kept]))
    planes = _planes(faces.outline)
    apart = _height(planes[one], faces.outline[one], middle) - _height(planes[other], faces.outline[other], middle)
    kept = np.abs(apart) < LEVEL_APART
    one, other = one[kept], other[kept]
    n = len(faces.road)
    _, label = connected_components(coo_matrix((np.ones(len(one)), (one, other)), shape=(n, n)), directed=False)
    out = np.full(n, -1)
    rows = np.unique(np.concatenate([one, other]))
    out[rows] = np.unique(label[rows], return_inverse=True)[1]
    return out


def sound(shapes: FloatArray) -> FloatArray:
    """Return polygons without those that cross themselves, as faces inside of bends do: their hulls instead."""
    return np.where(shapely.is_valid(shapes), shapes, shapely.convex_hull(shapes))


def _planes(corners: FloatArray) -> FloatArray:
    """Return the slopes in x and y of the planes nearest to four corners about their middle, (n, 2)."""
    off = corners - corners.mean(1, keepdims=True)
    xy, z = off[:, :, :2], off[:, :, 2:]
    square = np.matmul(xy.transpose(0, 2, 1), xy) + 1e-9 * np.eye(2)
    out: FloatArray = np.linalg.solve(square, np.matmul(xy.transpose(0, 2, 1), z))[:, :, 0]
    return out


def _height(plane: FloatArray, corners: FloatArray, at: FloatArray) -> FloatArray:
    """Return the heights of planes about the middle of four corners at x, y."""
    middle = corners.mean(1)
    out: FloatArray = middle[:, 2] + (plane * (at - middle[:, :2])).sum(1)
    return out


def cells_of(faces: LaneFaces, kind: IntArray, kinds: Sequence[str], group: IntArray) -> Cells:
    """Return the areas that show of the faces of all groups; `kind` (faces,) is an index in `kinds`."""
    of_face = group[faces.interval]
    rows = np.flatnonzero(of_face >= 0)
    rows = rows[np.argsort(of_face[rows], kind="stable")]
    shapes = sound(shapely.polygons(faces.corners[rows][:, :, :2]))
    bounds = np.flatnonzero(np.diff(of_face[rows], prepend=-1, append=-2) != 0)
    order = sorted(range(len(kinds)), key=lambda k: (rank_of(kinds[k]), k))
    found = []
    for low, high in pairwise(bounds.tolist()):
        for area, of in _areas(shapes[low:high], kind[rows[low:high]], order):
            found.append((area, of, int(of_face[rows[low]])))
    if not found:
        return Cells(np.zeros(0, object), np.zeros(0, np.int64), np.zeros(0, np.int64))
    parts = [part for part, _, _ in found]
    count = np.array([len(part) for part in parts], np.int64)
    return Cells(
        np.concatenate(parts),
        np.repeat(np.array([of for _, of, _ in found], np.int64), count),
        np.repeat(np.array([at for _, _, at in found], np.int64), count),
    )


def _areas(shapes: FloatArray, kind: IntArray, order: Sequence[int]) -> Iterator[tuple[FloatArray, int]]:
    """Yield the cells of each kind of one group of faces."""
    here = [k for k in order if (kind == k).any()]
    whole = {k: _areas_only(shapely.set_precision(shapely.union_all(shapes[kind == k]), GRID)) for k in here}
    shown = _shown([whole[k] for k in here])
    lines = [shapely.boundary(area) for area in shown]
    total = shapely.union_all(shown, grid_size=GRID)
    if shapely.is_empty(total):
        # Slivers thinner than the grid.
        return
    lines.append(_squares(total))
    noded = shapely.union_all(lines, grid_size=GRID)
    cells = shapely.get_parts(shapely.polygonize(shapely.get_parts(noded)))
    inside = shapely.get_coordinates(shapely.point_on_surface(cells))
    for k, area in zip(here, shown, strict=True):
        shapely.prepare(area)
        own = cells[shapely.contains_xy(area, inside[:, 0], inside[:, 1])]
        if len(own):
            yield own, k


def _shown(whole: Sequence[shapely.Geometry]) -> list[shapely.Geometry]:
    """Return what is not covered by those before, without slivers: they and narrow gaps belong to the first."""
    shown: list[shapely.Geometry] = []
    covered, crumbs = whole[0], []
    for area in whole[1:]:
        rest = _areas_only(shapely.difference(area, covered, grid_size=GRID))
        wide = shapely.buffer(shapely.buffer(rest, -_SLIVER, join_style="mitre"), _SLIVER * 1.01, join_style="mitre")
        kept = _areas_only(shapely.intersection(rest, wide, grid_size=GRID))
        crumbs.append(_areas_only(shapely.difference(rest, kept, grid_size=GRID)))
        shown.append(kept)
        covered = shapely.union_all([covered, area], grid_size=GRID)
    rings = [ring for part in shapely.get_parts(covered) for ring in part.interiors]
    holes = shapely.polygons(rings) if rings else np.zeros(0, object)
    # What vanishes when shrunk has no more area than its rim takes with it.
    holes = holes[shapely.area(holes) <= _SLIVER * shapely.length(holes)]
    gaps = holes[shapely.is_empty(shapely.buffer(holes, -_SLIVER))]
    first = shapely.union_all([whole[0], *crumbs, *gaps], grid_size=GRID)
    return [_areas_only(first), *shown]


def _areas_only(shape: shapely.Geometry) -> shapely.Geometry:
    """Return the polygons of a geometry."""
    parts = shapely.get_parts(shape)
    return shapely.multipolygons(parts[shapely.get_type_id(parts) == int(shapely.GeometryType.POLYGON)])


def _squares(area: shapely.Geometry) -> shapely.Geometry:
    """Return the lines of a grid of squares inside an area."""
    west, south, east, north = shapely.bounds(area)
    columns = np.arange(np.floor(west / _CELL), np.ceil(east / _CELL) + 1) * _CELL
    rows = np.arange(np.floor(south / _CELL), np.ceil(north / _CELL) + 1) * _CELL
    upright = np.stack([np.column_stack([columns, columns]), np.full((len(columns), 2), [south, north])], axis=2)
    level = np.stack([np.full((len(rows), 2), [west, east]), np.column_stack([rows, rows])], axis=2)
    lines = shapely.linestrings(np.concatenate([upright, level]))
    return shapely.intersection(shapely.multilinestrings(lines), area, grid_size=GRID)
