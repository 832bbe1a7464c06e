"""The surface of all roads as one mesh without overlap, and the rim at which it meets the ground.

The edges of lanes are noded once in plan, whatever their height. Where roads lie on each other at one level (in
junctions above all) what is driven on covers what lies beside it: the outlines of what shows stand for the lanes
there. Each face between the lines is there once for each level of the lanes that cover it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Final

import numpy as np
import shapely

from osm2xodr.curves import connected_groups, runs
from osm2xodr.errors import InputError
from osm2xodr.exporting.mesh import KERB
from osm2xodr.exporting.scene.meshes import (
    Planes,
    Soup,
    clusters,
    first_of,
    half_edges,
    on_planes,
    places_of,
    polygons_of,
    segments_of,
    steps,
    triangles_of,
    welded,
)
from osm2xodr.exporting.scene.model import GRID, Level, Rim, RoadSurface
from osm2xodr.furniture_shapes import LEVEL_APART, rank_of
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, OpenDrive, lane_ribbons, sample_roads
from osm2xodr.system import record

# ---------------------------------------------------------------- lanes as they are

# Faces of damaged files may lie anywhere, m.
_FARTHEST = 1e7


@record(eq=False)
class LaneFaces:
    """Faces of lanes between two stations, and the intervals of roads that they make up.

    Corners are the lane's right and left border at the first station, then left and right at the second, in the
    order right begin, right end, left end, left begin: counter-clockwise from above.
    """

    corners: FloatArray  # (n, 4, 3) inertial x, y, z of the road's surface, without lane heights, m
    lift: FloatArray  # (n, 4) Height of the lane above it, m
    uv: FloatArray  # (n, 4, 2) s and t, m
    lane: IntArray  # (n,) Row of the table of lanes
    interval: IntArray  # (n,) The interval it is part of
    # (intervals,)
    road: IntArray
    level: IntArray  # `Level`
    outline: FloatArray  # (intervals, 4, 3) Outermost corners, as those of faces


def lane_faces(file: OpenDrive, tolerance: float, step: float) -> LaneFaces:
    """Return the faces of all lanes; see `sample_roads` for `tolerance` and `step`, m.

    Intervals stand road by road in ascending s. Lanes without width at both ends have no face.
    """
    spans = _spans(file)
    more = (
        np.array([road for road, _, _, _ in spans for _ in range(2)], np.int64),
        np.array([s for _, _, low, high in spans for s in (low, high)], np.float64),
    )
    stations = sample_roads(file, tolerance, step, more)
    ribbons = lane_ribbons(file, stations)
    lanes = np.flatnonzero(ribbons.left != ABSENT)
    left, right = ribbons.start[ribbons.left[lanes]], ribbons.start[ribbons.right[lanes]]
    count = np.maximum(ribbons.start[ribbons.left[lanes] + 1] - left - 1, 0)
    lane, l0, r0 = np.repeat(lanes, count), runs(left, count), runs(right, count)
    points = np.column_stack([r0, r0 + 1, l0 + 1, l0])
    xyz = np.column_stack([ribbons.x, ribbons.y, ribbons.z])
    corners = xyz[points]
    width = np.hypot(*np.moveaxis(corners[:, [3, 2], :2] - corners[:, [0, 1], :2], 2, 0))
    kept = (np.abs(corners) < _FARTHEST).all((1, 2)) & (width > 1e-4).any(1)
    lane, points, corners = lane[kept], points[kept], corners[kept]
    inner, outer = np.nan_to_num(file.lanes.height[lane]).T
    is_left = file.lanes.id[lane] > 0
    at_left, at_right = np.where(is_left, outer, inner), np.where(is_left, inner, outer)
    lift = np.column_stack([at_right, at_right, at_left, at_left])
    uv = np.stack([stations.s[ribbons.station[points]], ribbons.t[points]], axis=2)
    first, interval = np.unique(ribbons.station[points[:, 0]], return_inverse=True)
    middle = np.empty(len(first))
    middle[interval] = 0.5 * (uv[:, 0, 0] + uv[:, 1, 0])
    road = stations.road[first]
    outline = _outlines(corners, uv, interval, len(first))
    return LaneFaces(corners, lift, uv, lane, interval, road, _levels(spans, road, middle), outline)


def _spans(file: OpenDrive) -> list[tuple[int, Level, float, float]]:
    """Return road, level, begin and end (s, m) of each bridge and tunnel; those after others win."""
    kinds = {"bridge": Level.BRIDGE, "tunnel": Level.TUNNEL}
    return [
        (item.road, kinds[item.kind], item.s, item.s + item.length)
        for item in file.furniture
        if item.kind in kinds and item.road >= 0 and math.isfinite(item.s + item.length)
    ]


def _levels(spans: list[tuple[int, Level, float, float]], road: IntArray, middle: FloatArray) -> IntArray:
    """Return the level of each interval by its road and the s of its middle."""
    level = np.full(len(road), int(Level.GROUND))
    first = np.searchsorted(road, np.arange(int(road[-1]) + 2 if len(road) else 1))
    for at, kind, low, high in spans:
        if at + 1 < len(first):
            rows = slice(first[at], first[at + 1])
            level[rows][(low <= middle[rows]) & (middle[rows] <= high)] = int(kind)
    return level


def _outlines(corners: FloatArray, uv: FloatArray, interval: IntArray, count: int) -> FloatArray:
    """Return the outermost corners of each interval."""
    out = np.empty((count, 4, 3))
    for side, sign in (((0, 1), 1.0), ((3, 2), -1.0)):
        t = sign * uv[:, side, 1].sum(1)
        order = np.lexsort((t, interval))
        row = order[np.searchsorted(interval[order], np.arange(count))]
        out[:, side] = corners[row][:, side]
    return out


# Roads lie on each other where they share more than this, m²: less comes of rounding and of chords side by side.
_LEAST_OVERLAP: Final = 1e-4
# Sides of the squares into which common areas are divided so that they follow the surface, m: the planes of
# junctions and their slopes turn slowly. A choice.
_CELL: Final = 4.0
# Strips narrower than twice this are no area of their own, m: half of the narrowest kerb (0.1 m), rounded up.
_SLIVER: Final = 0.06
# Triangles of lanes with less area in plan say nothing of slopes, m².
_LEAST_AREA: Final = 1e-3
# How far off a lane's triangle its height still counts at a corner: what rounding to `GRID` moves two corners apart,
# m; and in gaps between lanes that are filled, which are narrower.
_AT_CORNER: Final = 2.5 * GRID
_GAP: Final = 0.3
_HALVES: Final = np.array([[0, 1, 2], [0, 2, 3]])


def road_surface(file: OpenDrive, tolerance: float, step: float) -> RoadSurface:
    """Return the surface of all lanes; for `tolerance` and `step`, m, see `osm2xodr.opendrive.sample_roads`.

    Levels of common areas have the mean height of all roads there. `InputError` if no lane has a surface.
    """
    faces = lane_faces(file, tolerance, step)
    if not len(faces.lane):
        raise InputError(f"{file.path} has no lane with a surface; osm2xodr check lists what is wrong with it")
    kinds = tuple(sorted({kind or "none" for kind in file.lanes.type}))
    kind = np.array([kinds.index(kind or "none") for kind in file.lanes.type], np.int64)[faces.lane]
    group, common = _groups(faces)
    areas, area_kind, area_group = _areas(faces, kind, kinds, group, common)
    lines = np.concatenate([shapely.boundary(areas), [_squares(area) for area in areas[common[area_group]]]])
    noded = shapely.union_all(segments_of(lines, GRID), grid_size=GRID)
    cells = shapely.get_parts(shapely.polygonize(shapely.get_parts(noded)))
    soup, tag, uv = _layers(_Lanes(faces, kind, kinds, group, common), cells, (areas, area_kind, area_group))
    return _surface(soup, tag, uv, kinds)


# ---------------------------------------------------------------- what shows


def _groups(faces: LaneFaces) -> tuple[IntArray, BoolArray]:
    """Return the group of each interval, and which groups (n,) are of several roads.

    Intervals that overlap others at their level are of one group with all that hang together, and those that lie
    alone with the ones before and behind on their road.
    """
    shapes = _sound(shapely.polygons(faces.outline[:, :, :2]))
    one, other = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    follows = (faces.road[one] == faces.road[other]) & (other - one == 1)
    kept = (one < other) & ~follows
    next_, behind = one[follows], other[follows]
    one, other = one[kept], other[kept]
    shared = shapely.intersection(shapes[one], shapes[other])
    kept = shapely.area(shared) > _LEAST_OVERLAP
    one, other, at = one[kept], other[kept], shapely.get_coordinates(shapely.centroid(shared[kept]))
    # The plane of four corners goes through their middle, along both diagonals.
    middle, corners = faces.outline.mean(1), np.moveaxis(faces.outline, 1, 0)
    planes = np.stack([middle, middle + corners[2] - corners[0], middle + corners[3] - corners[1]], axis=1)
    kept = np.abs(on_planes(planes[one], at) - on_planes(planes[other], at))[:, 0] < LEVEL_APART
    one, other, n = one[kept], other[kept], len(shapes)
    common = np.zeros(n, np.bool_)
    common[one] = common[other] = True
    lone = ~common[next_] & ~common[behind]
    one, other = np.concatenate([one, next_[lone]]), np.concatenate([other, behind[lone]])
    label = connected_groups(n, one, other)
    several = np.zeros(int(label.max(initial=-1)) + 1, np.bool_)
    several[label] = common
    return label, several


def _sound(shapes: FloatArray) -> FloatArray:
    """Return polygons without those that cross themselves, as faces inside of bends do: their hulls instead."""
    return np.where(shapely.is_valid(shapes), shapes, shapely.convex_hull(shapes))


def _areas(
    faces: LaneFaces, kind: IntArray, kinds: Sequence[str], group: IntArray, common: BoolArray
) -> tuple[FloatArray, IntArray, IntArray]:
    """Return the polygons that show of all faces, and the kind and group of each; `kind` (faces,) is one of `kinds`.

    Those of groups that are not `common` are the faces themselves.
    """
    of = group[faces.interval]
    shapes = _sound(shapely.polygons(faces.corners[:, :, :2]))
    lone = np.flatnonzero(~common[of])
    found = [(shapes[lone], kind[lone], of[lone])]
    rows = np.flatnonzero(common[of])
    rows = rows[np.argsort(of[rows], kind="stable")]
    order = sorted(range(len(kinds)), key=lambda k: (rank_of(kinds[k]), k))
    for low, high in pairwise(np.flatnonzero(np.diff(of[rows], prepend=-1, append=-2) != 0).tolist()):
        here = rows[low:high]
        whole = {k: shapes[here[kind[here] == k]] for k in order}
        own = [k for k in order if len(whole[k])]
        for k, area in zip(own, _shown([_union(whole[k]) for k in own]), strict=True):
            parts = polygons_of(area)
            found.append((parts, np.full(len(parts), k), np.full(len(parts), of[here[0]])))
    shape, of_kind, of_group = (np.concatenate(item) for item in zip(*found, strict=True))
    return shape, of_kind, of_group


def _union(shapes: FloatArray) -> shapely.Geometry:
    """Return the area of polygons, on the grid."""
    return _areas_only(shapely.set_precision(shapely.union_all(shapes), GRID))


def _areas_only(shape: shapely.Geometry) -> shapely.Geometry:
    """Return the polygons of a geometry."""
    return shapely.multipolygons(polygons_of(shape))


def _shown(whole: Sequence[shapely.Geometry]) -> Iterator[shapely.Geometry]:
    """Yield what is not covered by those before, without slivers, which belong to the first."""
    shown, crumbs, covered = list[shapely.Geometry](), [whole[0]], whole[0]
    for area in whole[1:]:
        rest = _areas_only(shapely.difference(area, covered, grid_size=GRID))
        wide = shapely.buffer(shapely.buffer(rest, -_SLIVER, join_style="mitre"), _SLIVER * 1.01, join_style="mitre")
        shown.append(_areas_only(shapely.intersection(rest, wide, grid_size=GRID)))
        crumbs.append(_areas_only(shapely.difference(rest, shown[-1], grid_size=GRID)))
        covered = shapely.union_all([covered, area], grid_size=GRID)
    yield shapely.union_all(crumbs, grid_size=GRID)
    yield from shown


def _squares(area: shapely.Geometry) -> shapely.Geometry:
    """Return the lines of a grid of squares inside an area."""
    west, south, east, north = shapely.bounds(area)
    columns, rows = (
        np.arange(np.ceil(low / _CELL), high / _CELL) * _CELL for low, high in ((west, east), (south, north))
    )
    upright = np.stack([np.column_stack([columns, columns]), np.full((len(columns), 2), [south, north])], axis=2)
    level = np.stack([np.full((len(rows), 2), [west, east]), np.column_stack([rows, rows])], axis=2)
    lines = shapely.linestrings(np.concatenate([upright, level]))
    return shapely.intersection(shapely.multilinestrings(lines), area)


# ---------------------------------------------------------------- heights


class _Lanes(Planes):
    """Finds the lanes' triangles that cover places, and their heights there."""

    def __init__(
        self, faces: LaneFaces, kind: IntArray, kinds: Sequence[str], group: IntArray, common: BoolArray
    ) -> None:
        corners = faces.corners[:, _HALVES].reshape(-1, 3, 3)
        # Height above the road, s and t; of common areas the mean height, x and y.
        values = np.concatenate([faces.lift[..., None], faces.uv], axis=2)[:, _HALVES].reshape(-1, 3, 3)
        flat = np.concatenate([np.repeat(values[..., :1].mean(1, keepdims=True), 3, 1), corners[..., :2]], 2)
        in_common = np.repeat(common[group[faces.interval]], 2)
        values = np.where(in_common[:, None, None], flat, values)
        super().__init__(np.concatenate([corners, values], axis=2), _LEAST_AREA)
        row = self.rows // 2
        self.kind, self.group, self.level = kind[row], group[faces.interval[row]], faces.level[faces.interval[row]]
        self.kinds, self.rank = len(kinds), np.array([rank_of(name) for name in kinds], np.int64)

    def heights(self, xy: FloatArray, group: IntArray, reach: float) -> tuple[IntArray, IntArray, FloatArray]:
        """Return pairs of places and triangles of their group (-1: any), and the height of the plane there, m."""
        place, face = self.at(xy, reach)
        kept = (self.group[face] == group[place]) | (group[place] < 0)
        place, face = place[kept], face[kept]
        return place, face, self.values(face, xy[place])[:, 0]


def _layers(
    lanes: _Lanes, cells: FloatArray, areas: tuple[FloatArray, IntArray, IntArray]
) -> tuple[Soup, IntArray, FloatArray]:
    """Return the triangles of cells, once for each level of the roads there, their kind and level as one, and uv."""
    inside = shapely.get_coordinates(shapely.point_on_surface(cells))
    cell, area = shapely.STRtree(areas[0]).query(shapely.points(inside), predicate="intersects")
    shown, group = areas[1][area], areas[2][area]
    # Gaps between lanes are not wider than slivers.
    bare = np.setdiff1d(np.arange(len(cells)), cell)
    bare = bare[shapely.area(cells[bare]) <= _SLIVER * shapely.length(cells[bare])]
    bare = bare[shapely.is_empty(shapely.buffer(cells[bare], -_SLIVER))]
    cell, shown = np.concatenate([cell, bare]), np.concatenate([shown, np.full(len(bare), -1)])
    group = np.concatenate([group, np.full(len(bare), -1)])
    item, face, z = lanes.heights(inside[cell], group, _AT_CORNER)
    rest = np.setdiff1d(np.arange(len(cell)), item)
    more = lanes.heights(inside[cell[rest]], group[rest], _GAP)
    item, face, z = (np.concatenate(pair) for pair in zip((item, face, z), (rest[more[0]], *more[1:]), strict=True))
    # Levels of each cell: heights that lie close to each other.
    layer = clusters(cell[item], z, LEVEL_APART)
    # What shows is the kind of the cell where a road of that level has it, else what covers the rest there.
    other = lanes.kind[face] != shown[item]
    best = first_of(layer, face, lanes.rank[lanes.kind[face]], other)
    middle = np.bincount(layer, weights=z) / np.bincount(layer)
    of_cell, top, wanted = cell[item[best]], face[best], shown[item[best]]
    only = (np.bincount(of_cell, minlength=len(cells))[of_cell] == 1) & (wanted >= 0)
    kind = np.where(only, wanted, lanes.kind[top])
    xy, of = triangles_of(cells[of_cell])
    place, first = places_of(xy.reshape(-1, 2), GRID)
    places = xy.reshape(-1, 2)[first]
    own, flat = np.repeat(top[of], 3), xy.reshape(-1, 2)
    base = _base(lanes, places, place, lanes.group[own], np.repeat(middle[of], 3))
    more_of = lanes.values(own, flat)
    lift = np.where(np.repeat((kind == lanes.kind[top])[of], 3), more_of[:, 1], 0.0)
    soup = Soup(place.reshape(-1, 3), places, (base + lift).reshape(-1, 3))
    return soup, (lanes.level[top] * lanes.kinds + kind)[of], more_of[:, 2:]


def _base(lanes: _Lanes, places: FloatArray, place: IntArray, group: IntArray, middle: FloatArray) -> FloatArray:
    """Return the mean height of the roads of groups at places, at the level nearest to that of their cell, m."""
    key, corner = np.unique(group * len(places) + place, return_inverse=True)
    of_group, at = np.divmod(key, len(places))
    row, _, z = lanes.heights(places[at], of_group, _AT_CORNER)
    layer = clusters(row, z, LEVEL_APART)
    first, mean = np.unique(layer, return_index=True)[1], np.bincount(layer, weights=z) / np.bincount(layer)
    # All pairs of corners of triangles and levels of their place.
    start = np.searchsorted(row[first], np.arange(len(key) + 1))
    count = np.diff(start)[corner]
    owner = np.repeat(np.arange(len(corner)), count)
    level = runs(start[:-1][corner], count)
    best = first_of(owner, np.abs(mean[level] - middle[owner]))
    out = middle.copy()
    out[owner[best]] = mean[level[best]]
    return out


def _surface(soup: Soup, tag: IntArray, uv: FloatArray, kinds: tuple[str, ...]) -> RoadSurface:
    """Return the surface of triangles, with steps where neighbours differ in height."""
    faces, place, xyz = welded(soup)
    kind, level = tag % len(kinds), tag // len(kinds)
    kerbs, pair, left = steps(*half_edges(faces), place, xyz)
    closing, sides = _closing(left, faces, place, xyz)
    names = (*kinds, KERB) if KERB not in kinds else kinds
    more = len(kerbs) + len(closing)
    return RoadSurface(
        xyz,
        uv[np.unique(faces.ravel(), return_index=True)[1]],
        np.concatenate([faces, kerbs, closing]),
        np.concatenate([kind, np.full(more, names.index(KERB))]),
        names,
        np.concatenate([level, level[pair // 3].min(1), level[sides // 3]]),
    )


def _closing(left: IntArray, faces: IntArray, place: IntArray, xyz: FloatArray) -> tuple[IntArray, IntArray]:
    """Return vertical triangles that bring the ends of rims down to the lowest height of their place and level."""
    start, end = (item[left] for item in half_edges(faces))
    level = clusters(place, xyz[:, 2], LEVEL_APART)
    unique = np.unique(np.concatenate([start, end]))
    lowest = np.zeros(len(xyz), np.int64)
    lowest[level[unique][first_of(level[unique], xyz[unique, 2])]] = unique[first_of(level[unique], xyz[unique, 2])]
    a, b = lowest[level[start]], lowest[level[end]]
    both = np.stack([np.column_stack([end, start, a]), np.column_stack([end, a, b])], axis=1).reshape(-1, 3)
    kept = (both != np.roll(both, 1, axis=1)).all(1)
    return both[kept], np.repeat(left, 2)[kept]


def rim_of(surface: RoadSurface) -> Rim:
    """Return the edges at which the surface on the ground ends."""
    start, end = half_edges(surface.faces)
    n = len(surface.vertices)
    level = np.repeat(surface.level, 3)
    key, back = start * n + end, end * n + start
    order = np.argsort(back, kind="stable")
    at = np.minimum(np.searchsorted(back[order], key), len(key) - 1)
    matched = back[order[at]] == key
    beyond = np.where(matched, level[order[at]], int(Level.GROUND))
    # Sides of steps within the surface are no rim, but those at its ends join edges of different heights.
    upright = (surface.vertices[start, :2] == surface.vertices[end, :2]).all(1)
    rows = np.flatnonzero((level == Level.GROUND) & ((~matched & ~upright) | (matched & (beyond != Level.GROUND))))
    return Rim(np.column_stack([start[rows], end[rows]]), beyond[rows])
