"""The surface of all roads as one mesh without overlap, and the rim at which it meets the ground."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
import shapely

from osm2xodr.errors import InputError
from osm2xodr.exporting.mesh import KERB
from osm2xodr.exporting.scene.lane_faces import LaneFaces, lane_faces
from osm2xodr.exporting.scene.model import Level, Rim, RoadSurface
from osm2xodr.exporting.scene.overlaps import Cells, cells_of, groups_of
from osm2xodr.exporting.scene.triangles import (
    ONE_PLACE,
    Soup,
    edges_of,
    merged_places,
    split_where_they_meet,
    steps_between,
    welded,
)
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import OpenDrive
from osm2xodr.shapes import LEVEL_APART, rank_of

# Triangles of lanes with less area in plan say nothing of slopes, m².
_LEAST_AREA: Final = 1e-3
# How far off a lane its height is still taken, m: gaps between lanes that are filled are narrower.
_GAP: Final = 0.3


def road_surface(file: OpenDrive, tolerance: float, step: float) -> RoadSurface:
    """Return the surface of all lanes; for `tolerance` and `step`, m, see `osm2xodr.opendrive.sample_roads`.

    Where roads lie on each other (in junctions above all) what is driven on covers what lies beside it; their
    common area is divided anew, at the mean height of all roads there. `InputError` if no lane has a surface.
    """
    faces = lane_faces(file, tolerance, step)
    if not len(faces.lane):
        raise InputError(f"{file.path} has no lane with a surface; osm2xodr check lists what is wrong with it")
    kinds = tuple(sorted({kind or "none" for kind in file.lanes.type}))
    kind = np.array([kinds.index(kind or "none") for kind in file.lanes.type], np.int64)[faces.lane]
    group = groups_of(faces)
    alone = np.flatnonzero(group[faces.interval] < 0)
    soup = _joined(
        _faces_alone(faces, kind, alone, len(kinds)),
        _common(faces, kind, kinds, group, cells_of(faces, kind, kinds, group)),
    )
    return _surface(split_where_they_meet(soup), kinds)


def _tag(kind: IntArray, level: IntArray, kinds: int) -> IntArray:
    """Return one number for kind and level."""
    out: IntArray = level * kinds + kind
    return out


_HALVES: Final = np.array([[0, 1, 2], [0, 2, 3]])


def _faces_alone(faces: LaneFaces, kind: IntArray, rows: IntArray, kinds: int) -> Soup:
    """Return the triangles of faces as they are; their places are not merged yet."""
    xyz = faces.corners[rows][:, _HALVES].reshape(-1, 3, 3)
    z = xyz[:, :, 2] + faces.lift[rows][:, _HALVES].reshape(-1, 3)
    uv = faces.uv[rows][:, _HALVES].reshape(-1, 3, 2)
    tag = np.repeat(_tag(kind[rows], faces.level[faces.interval[rows]], kinds), 2)
    return Soup(np.arange(3 * len(z)).reshape(-1, 3), xyz[:, :, :2].reshape(-1, 2), z, uv, tag)


def _joined(one: Soup, other: Soup) -> Soup:
    """Return the triangles of both, with places that they share; those of the first stay exactly where they are."""
    place, xy = merged_places(np.concatenate([one.xy, other.xy]))
    index = np.concatenate([one.place, other.place + len(one.xy)])
    return Soup(
        place[index],
        xy,
        np.concatenate([one.z, other.z]),
        np.concatenate([one.uv, other.uv]),
        np.concatenate([one.tag, other.tag]),
    )


class _Heights:
    """Finds the faces that cover places, and their heights there."""

    def __init__(self, faces: LaneFaces, kind: IntArray, kinds: Sequence[str], group: IntArray) -> None:
        rows = np.flatnonzero(group[faces.interval] >= 0)
        corners = faces.corners[rows][:, _HALVES].reshape(-1, 3, 3)
        a, b, c = np.moveaxis(corners, 1, 0)
        normal = np.cross(b - a, c - a)
        kept = np.flatnonzero(normal[:, 2] > 2.0 * _LEAST_AREA)
        self._corners, self._normal = corners[kept], normal[kept]
        row = np.repeat(rows, 2)[kept]
        self.kind, self.group = kind[row], group[faces.interval[row]]
        self.level = faces.level[faces.interval[row]]
        self.rank = np.array([rank_of(name) for name in kinds], np.int64)[self.kind]
        # Lanes have one height across in sound files; a face's mean stands for it.
        self.lift = faces.lift[row].mean(1)
        self._tree = shapely.STRtree(shapely.polygons(self._corners[:, :, :2]))

    def at(self, xy: FloatArray, group: IntArray, reach: float) -> tuple[IntArray, IntArray, FloatArray]:
        """Return pairs of places and faces of their group, and the height of the face's plane there, m."""
        place, face = self._tree.query(shapely.points(xy), predicate="dwithin", distance=reach)
        kept = self.group[face] == group[place]
        place, face = place[kept], face[kept]
        order = np.lexsort((face, place))
        place, face = place[order], face[order]
        off, normal = xy[place] - self._corners[face, 0, :2], self._normal[face]
        z = self._corners[face, 0, 2] - (normal[:, :2] * off).sum(1) / normal[:, 2]
        return place, face, z


def _common(faces: LaneFaces, kind: IntArray, kinds: Sequence[str], group: IntArray, cells: Cells) -> Soup:
    """Return the triangles of cells, once for each level of the roads there."""
    heights = _Heights(faces, kind, kinds, group)
    inside = shapely.get_coordinates(shapely.point_on_surface(cells.shape)).reshape(-1, 2)
    place, face, z = heights.at(inside, cells.group, ONE_PLACE)
    bare = np.setdiff1d(np.arange(len(inside)), place)
    more = heights.at(inside[bare], cells.group[bare], _GAP)
    place, face = np.concatenate([place, bare[more[0]]]), np.concatenate([face, more[1]])
    z = np.concatenate([z, more[2]])
    # Levels of each cell: heights that lie close to each other.
    order = np.lexsort((face, z, place))
    place, face, z = place[order], face[order], z[order]
    new = np.ones(len(place), np.bool_)
    new[1:] = (np.diff(place) != 0) | (np.diff(z) > LEVEL_APART)
    layer = np.cumsum(new) - 1
    cell, middle = place[new], np.bincount(layer, weights=z) / np.bincount(layer)
    # What shows is the kind of the cell where a road of that level has it, else what covers the rest there.
    wanted = heights.kind[face] == cells.kind[cell[layer]]
    best = np.lexsort((face, heights.rank[face], ~wanted, layer))
    best = best[np.diff(layer[best], prepend=-1) != 0]
    only = np.bincount(cell, minlength=len(inside))[cell] == 1
    own = np.where(only, cells.kind[cell], heights.kind[face[best]])
    level, lift = heights.level[face[best]], np.where(own == heights.kind[face[best]], heights.lift[face[best]], 0.0)
    parts, of = shapely.get_parts(shapely.constrained_delaunay_triangles(cells.shape[cell]), return_index=True)
    parts = shapely.orient_polygons(parts)
    xy = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    tag = _tag(own[of], level[of], len(kinds))
    base = _base(heights, xy, cells.group[cell[of]], middle[of])
    flat = xy.reshape(-1, 2)
    return Soup(np.arange(len(flat)).reshape(-1, 3), flat, base + lift[of][:, None], xy, tag)


def _base(heights: _Heights, xy: FloatArray, group: IntArray, middle: FloatArray) -> FloatArray:
    """Return the mean height of the roads at the corners of triangles, (n, 3), at the level of their cell."""
    unique, corner = np.unique(np.column_stack([xy.reshape(-1, 2), np.repeat(group, 3)]), axis=0, return_inverse=True)
    corner = corner.ravel()
    place, _, z = heights.at(unique[:, :2], unique[:, 2].astype(np.int64), ONE_PLACE)
    # All pairs of corners of triangles and faces.
    first = np.searchsorted(place, np.arange(len(unique) + 1))
    count = np.diff(first)[corner]
    row = np.repeat(np.arange(len(corner)), count)
    at = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count) + first[corner][row]
    # Heights of one level at a place: those without a gap between them.
    order = np.lexsort((z, place))
    new = np.ones(len(order), np.bool_)
    new[1:] = (np.diff(place[order]) != 0) | (np.diff(z[order]) > LEVEL_APART)
    layer = np.empty(len(order), np.int64)
    layer[order] = np.cumsum(new) - 1
    mean = np.bincount(layer, weights=z) / np.bincount(layer)
    # The level nearest to the cell's own height.
    away = np.abs(mean[layer[at]] - np.repeat(middle, 3)[row])
    order = np.lexsort((away, row))
    best = order[np.diff(row[order], prepend=-1) != 0]
    out = np.repeat(middle, 3)
    out[row[best]] = mean[layer[at[best]]]
    return out.reshape(-1, 3)


def _surface(soup: Soup, kinds: tuple[str, ...]) -> RoadSurface:
    """Return the surface of triangles, with steps where neighbours differ in height."""
    faces, xyz, uv = welded(soup)
    place = np.zeros(len(xyz), np.int64)
    place[faces.ravel()] = soup.place.ravel()
    edges = edges_of(faces, place, xyz)
    steps, pair = steps_between(faces, edges.pairs)
    kind, level = soup.tag % len(kinds), soup.tag // len(kinds)
    names = (*kinds, KERB) if KERB not in kinds else kinds
    at = edges.pairs[pair] // 3
    step_level = np.minimum(level[at[:, 0]], level[at[:, 1]])
    closing, closing_level = _closing(edges.alone, faces, place, xyz, level)
    return RoadSurface(
        xyz,
        uv,
        np.concatenate([faces, steps, closing]),
        np.concatenate([kind, np.full(len(steps) + len(closing), names.index(KERB))]),
        names,
        np.concatenate([level, step_level, closing_level]),
    )


def _closing(
    alone: IntArray, faces: IntArray, place: IntArray, xyz: FloatArray, level: IntArray
) -> tuple[IntArray, IntArray]:
    """Return vertical triangles that bring the ends of rims down to the lowest height of their place."""
    start, end = faces.ravel()[alone], np.roll(faces, -1, axis=1).ravel()[alone]
    of_level = level[alone // 3]
    ends = np.concatenate([start, end])
    lowest = _lowest(ends, place, xyz)
    a, b = lowest[: len(start)], lowest[len(start) :]
    both = np.stack([np.column_stack([end, start, a]), np.column_stack([end, a, b])], axis=1).reshape(-1, 3)
    kept = (both[:, 0] != both[:, 1]) & (both[:, 1] != both[:, 2]) & (both[:, 2] != both[:, 0])
    return both[kept], np.repeat(of_level, 2)[kept]


def _lowest(ends: IntArray, place: IntArray, xyz: FloatArray) -> IntArray:
    """Return the lowest vertex at the place of each, among those of the same level of height."""
    unique = np.unique(ends)
    order = unique[np.lexsort((xyz[unique, 2], place[unique]))]
    new = np.ones(len(order), np.bool_)
    new[1:] = (np.diff(place[order]) != 0) | (np.diff(xyz[order, 2]) > LEVEL_APART)
    lead = np.zeros(len(xyz), np.int64)
    lead[order] = order[new][np.cumsum(new) - 1]
    return lead[ends]


def rim_of(surface: RoadSurface) -> Rim:
    """Return the edges at which the surface on the ground ends."""
    start, end = surface.faces.ravel(), np.roll(surface.faces, -1, axis=1).ravel()
    n = len(surface.vertices)
    level = np.repeat(surface.level, 3)
    key, back = start * n + end, end * n + start
    order = np.argsort(back, kind="stable")
    at = np.minimum(np.searchsorted(back[order], key), len(key) - 1)
    matched = back[order[at]] == key
    beyond = np.where(matched, level[order[at]], int(Level.GROUND))
    ground = level == int(Level.GROUND)
    # Sides of steps within the surface are no rim, but those at its ends join edges of different heights.
    upright = (surface.vertices[start, :2] == surface.vertices[end, :2]).all(1)
    rows = np.flatnonzero(ground & ((~matched & ~upright) | (matched & (beyond != int(Level.GROUND)))))
    return Rim(np.column_stack([start[rows], end[rows]]), beyond[rows])
