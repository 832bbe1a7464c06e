"""The ground around roads: from the elevation model, met by every edge of a road without a gap.

All lines at roads and shores are noded once, and each face between them is land or water. Edges of roads and sides of
squares do not touch, so that triangles have the very corners of the roads. Where a place has several heights, as at
portals and at shores of level water, walls stand between triangles.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import numpy as np
import shapely

from osm2xodr.curves import PointTree, runs
from osm2xodr.exporting.scene.cells import Cells, along_edges, cells_around, leaf_sizes, leaf_triangles
from osm2xodr.exporting.scene.levels import Height
from osm2xodr.exporting.scene.meshes import (
    Planes,
    first_of,
    half_edges,
    has_area,
    lone,
    part_of,
    places_of,
    steps,
    triangles_of,
    walls_between,
)
from osm2xodr.exporting.scene.model import (
    APRON,
    GRID,
    GROUND_CELL,
    REACH,
    TUNNEL_COVER,
    TUNNEL_OPENING,
    WATER_REACH,
    Level,
    Part,
    Rim,
    RoadSurface,
)
from osm2xodr.exporting.scene.slopes import Limits, continued, interpolated, node_heights, with_strips
from osm2xodr.exporting.scene.water import WaterShapes, levelled
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.system import record

# Levels of detail; each one's squares away from roads are twice as long as the finer one's. A choice.
_DETAILS: Final = 3
# Ground steeper than this, rise per metre, and higher than that, m, is a wall. Choices.
_GROUND_WALL_SLOPE: Final = 2.0
_GROUND_WALL_HEIGHT: Final = 0.5
# From the road of a bridge down to the ground below at least, m: its deck of 1 m, and a little.
_BRIDGE_DEPTH: Final = 1.2
# Triangles with less area are none, m²: a millimetre times two. A choice.
_LEAST_AREA: Final = 1e-6

# ---------------------------------------------------------------- roads and shores

# Places closer together than this are the same, m: what is left of rounding.
_SAME: Final = 1e-6
# Corners of squares per line across the band.
_PER_SPOKE: Final = 3


@record(eq=False)
class Band:
    """Triangles of places: those of the roads, then corners of squares, then more."""

    triangles: IntArray  # (n, 3) counter-clockwise
    area: IntArray  # (n,) The area of water that each is in; -1 for land
    more: FloatArray  # (k, 2) Places where shores cross other lines, and along them, m


def band_of(cells: Cells, xy: FloatArray, rim: IntArray, roads: Planes, water: WaterShapes) -> Band:
    """Return the ground between the edges of roads, shores and whole squares.

    `xy`, (points, 2), m, are different places, and `rim`, (m, 2), edges between them.
    """
    known = np.concatenate([xy, cells.node_xy()])
    around = cells.sides(cells.roads & cells.ground)
    around = len(xy) + around[lone(*around.T)]
    edges = np.concatenate([rim, around, len(xy) + cells.sides(cells.shores), _spokes(known, rim, around)])
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    lines = _lines(known, edges)
    # Nothing crosses but shores. They are not moved onto a grid, as edges of roads have to stay as they are.
    crossed = np.unique(shapely.STRtree(lines).query(water.shores, predicate="intersects")[1])
    noded = shapely.union_all(np.concatenate([lines[crossed], water.shores]))
    lines = np.concatenate([np.delete(lines, crossed), shapely.get_parts(noded)])
    faces = shapely.get_parts(shapely.polygonize(lines))
    inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    kept = cells.has((cells.roads | cells.shores) & cells.ground, inside) & ~roads.cover(inside)
    corners, of = triangles_of(faces[kept])
    used, corners = np.unique(edges), corners.reshape(-1, 2)
    place, first = places_of(np.concatenate([known[used], corners]), _SAME)
    new = first >= len(used)
    number = np.empty(len(first), np.int64)
    number[~new] = used[first[~new]]
    number[new] = len(known) + np.arange(np.count_nonzero(new))
    return Band(
        number[place[len(used) :]].reshape(-1, 3),
        water.found_at(*inside[kept].T)[of],
        corners[first[new] - len(used)],
    )


def _lines(places: FloatArray, edges: IntArray) -> Any:
    """Return edges between places as lines."""
    return shapely.linestrings(places[edges])


def _spokes(places: FloatArray, rim: IntArray, around: IntArray) -> IntArray:
    """Return lines across the band, from corners of squares to the nearest place on a road, that cross no edge.

    They divide it into small pieces, which are triangulated many times as fast as a large one.
    """
    corners, ends = np.unique(around)[::_PER_SPOKE], np.unique(rim)
    if not len(ends):
        return np.zeros((0, 2), np.int64)
    spokes = np.column_stack([corners, ends[PointTree(places[ends]).nearest(places[corners])[1]]])
    edges = np.concatenate([rim, around])
    spoke, edge = shapely.STRtree(_lines(places, edges)).query(_lines(places, spokes), predicate="intersects")
    meets = (spokes[spoke][:, :, None] == edges[edge][:, None]).any((1, 2))
    return np.delete(spokes, np.unique(spoke[~meets]), 0)


def raised(triangles: IntArray, xyz: FloatArray, place: IntArray, rim: IntArray) -> IntArray:
    """Return triangles (n, 3) of points instead of places.

    `place`, (points,), is that of each point of `xyz`, (points, 3), m. `rim`, (m, 2), are edges of points that have
    the road on their left: those that the ground has to meet. Places without an edge have one point.
    """
    point = np.zeros(int(place.max()) + 1, np.int64)
    point[place] = np.arange(len(place))
    # Each place has the points of its edges: of several the lowest one.
    ends, edge = rim.ravel(), np.repeat(np.arange(len(rim)), 2)
    order = np.lexsort((xyz[ends, 2], place[ends]))
    ends, edge = ends[order], edge[order]
    first = np.flatnonzero(np.diff(place[ends], prepend=-1) != 0)
    count = np.diff(np.append(first, len(ends)))
    point[place[ends[first]]] = ends[first]
    out = point[triangles]
    # Triangles on the right of the line of a higher edge go with it, as above a portal and straight on beside it.
    many = np.maximum.reduceat(ends, first) > np.minimum.reduceat(ends, first) if len(first) else first > 0
    rank = np.full(len(point), -1)
    rank[place[ends[first[many]]]] = np.flatnonzero(many)
    row, corner = np.nonzero(rank[triangles] >= 0)
    own = rank[triangles[row, corner]]
    owner, at = np.repeat(np.arange(len(row)), count[own]), runs(first[own], count[own])
    begin, along = xyz[rim[edge[at], 0], :2], np.diff(xyz[rim[edge[at]], :2], axis=1)[:, 0]
    off = xyz[out[row[owner]], :2].mean(1) - begin
    right = along[:, 0] * off[:, 1] < along[:, 1] * off[:, 0]
    z = xyz[ends[at], 2]
    best = first_of(owner, np.where(right, -z, z), ~right)
    out[row, corner] = ends[at[best]]
    # Sides at an edge have its points.
    total = len(point)
    key = place[rim[:, 1]] * total + place[rim[:, 0]]
    order = np.argsort(key, kind="stable")
    start, end = half_edges(triangles)
    found = np.minimum(np.searchsorted(key[order], start * total + end), max(len(key) - 1, 0))
    side = np.flatnonzero(key[order][found] == start * total + end) if len(key) else np.zeros(0, np.int64)
    row, corner, met = side // 3, side % 3, rim[order[found[side]]]
    out[row, corner], out[row, (corner + 1) % 3] = met[:, 1], met[:, 0]
    return out


def on_edges(xy: FloatArray, z: FloatArray, xyz: FloatArray, edges: IntArray) -> tuple[FloatArray, IntArray]:
    """Return heights of places (n, 2), m, and edges (m, 2) of points (k, 3) that end at the places on them as well.

    Places on edges are as high as these, the others `z`, (n,), m. They are the points behind those that are given.
    """
    tree = shapely.STRtree(_lines(xyz[:, :2], edges))
    at, edge = tree.query(shapely.points(xy), predicate="dwithin", distance=2.0 * GRID)
    begin, along = xyz[edges[edge, 0]], xyz[edges[edge, 1]] - xyz[edges[edge, 0]]
    share = ((xy[at] - begin[:, :2]) * along[:, :2]).sum(1) / np.maximum((along[:, :2] ** 2).sum(1), GRID**2)
    kept = (share > 0.0) & (share < 1.0)
    height = (begin[:, 2] + share * along[:, 2])[kept]
    at, edge, share = at[kept], edge[kept], share[kept]
    lowest = first_of(at, height)
    out = z.copy()
    out[at[lowest]] = height[lowest]
    # All points along each edge.
    count = len(edges)
    edge = np.concatenate([np.tile(np.arange(count), 2), edge])
    order = np.lexsort((np.concatenate([np.zeros(count), np.ones(count), share]), edge))
    point = np.concatenate([edges.T.ravel(), len(xyz) + at])[order]
    goes_on = np.diff(edge[order]) == 0
    return out, np.column_stack([point[:-1][goes_on], point[1:][goes_on]])


def level_water(
    vertices: FloatArray, place: IntArray, faces: IntArray, area: IntArray, level: FloatArray, fixed: int
) -> tuple[FloatArray, IntArray, IntArray, IntArray]:
    """Return vertices, the vertex that each comes from, its place, and triangles, of which those in water are level.

    Triangles (n, 3) of vertices (m, 2 or more), m, whose places are given, are in areas of water, -1 for none, of a
    level, (n,), m, or NaN. Land at its shore is no lower, but for the first `fixed` vertices: those of roads.
    """
    wet = np.flatnonzero(np.isfinite(level))
    high = np.full(int(place.max(initial=-1)) + 1, -np.inf)
    np.maximum.at(high, place[faces[wet]], level[wet, None])
    dry = np.zeros(len(vertices), np.bool_)
    dry[faces[~np.isfinite(level)]] = True
    dry[:fixed] = False
    vertices = vertices.copy()
    vertices[dry, 2] = np.maximum(vertices[dry, 2], high[place[dry]])
    # One corner of each area at a vertex.
    key = np.repeat(area[wet], 3) * len(vertices) + faces[wet].ravel()
    key, first, corner = np.unique(key, return_index=True, return_inverse=True)
    own = key % len(vertices)
    flat = np.column_stack([vertices[own, :2], np.repeat(level[wet], 3)[first]])
    out = faces.copy()
    out[wet] = len(vertices) + corner.reshape(-1, 3)
    origin = np.concatenate([np.arange(len(vertices)), own])
    return np.concatenate([vertices, flat]), origin, place[origin], out


# ---------------------------------------------------------------- all of it

# Corners and crossings of a cut triangle in order: pairs of corners, those of corners with themselves.
_AROUND: Final = np.array([[0, 0], [0, 1], [1, 1], [1, 2], [2, 2], [2, 0]])
_HALVES: Final = np.array([[0, 1, 2], [0, 2, 3]])


@record(eq=False)
class Ground:
    """The ground around roads."""

    # ``Terrain`` and ``Water``, one for each level of detail, and ``Retaining_Wall``
    parts: tuple[Part, ...]
    cells: Cells
    # Heights of the corners of squares, (rows + 1, columns + 1), m, below level water as well; NaN where unknown
    z: FloatArray
    water: WaterShapes
    # Areas around roads that no elevation model knows, m²: without ground, and with heights between those around
    unknown: float
    interpolated: float

    def heights(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return the height of the ground at x, y (n,), m; NaN beyond it.

        It is that between the corners of the smallest squares; on roads that of their edges, on level water its own.
        """
        inside = self.cells.between(self.cells.inside, x, y) >= 0.0
        level = self.water.level_at(x, y)
        return np.where(inside, np.where(np.isnan(level), self.cells.between(self.z, x, y), level), np.nan)


def build_ground(
    surface: RoadSurface,
    rim: Rim,
    height: Height | None,
    tile: float,
    water: WaterShapes | None = None,
    *,
    coarsest_alone: bool = False,
) -> Ground:
    """Return the ground that meets the edges of roads.

    `height` gives the elevation model's heights at inertial x, y (n,), m, NaN where it has none; without it the
    ground is a strip beside the roads at their height. Levels of detail have the same corners at the borders of
    tiles, whose width is `tile`, m, a multiple of 20. Where there is `water` it is level. Other levels of detail than
    the coarsest one are left out with `coarsest_alone`. `InputError` if the roads span too much for the memory.
    """
    known = _nothing if height is None else height
    beside = surface.vertices[np.unique(rim.edges[rim.beyond == Level.GROUND])]
    water = levelled(water or WaterShapes(), known, beside)
    points, edges = _edge_points(surface, rim, known)
    xy, place = np.unique(points[:, :2], axis=0, return_inverse=True)
    flat = place[edges]
    flat = flat[flat[:, 0] != flat[:, 1]]
    roads = Planes(surface.vertices[surface.faces[surface.level == Level.GROUND]])
    above, below = (_points_of(surface, level) for level in (Level.BRIDGE, Level.TUNNEL))
    reach = APRON if height is None else REACH
    far = WATER_REACH if water.areas and height is not None else reach
    others = np.concatenate([above, below])[:, :2]
    cells = cells_around(along_edges(xy[flat])[0], others, roads.cover, reach, water, far)
    limits = _limits(points[edges], rim.beyond, above, below)
    there, closed = _base(known(*cells.node_xy().T).reshape(cells.nodes), water.level_of(cells.water))
    base, inside = with_strips(cells, closed, limits.xyz[limits.normal.any(1)])
    z = continued(node_heights(cells, base, limits, _known_or(known, cells, base, limits.xyz)))
    lost, guessed = (cells.inside > 0.0) & (inside < 0.0), (inside > 0.0) & np.isnan(there) & ~np.isnan(closed)
    unknown, between = (GROUND_CELL**2 * int(some.sum()) for some in (lost, guessed))
    cells = replace(cells, inside=inside)
    band = band_of(cells, xy, flat, roads, water)
    details = range(_DETAILS - 1 if coarsest_alone else 0, _DETAILS)
    leaves = {detail: leaf_triangles(cells, leaf_sizes(cells, detail, tile), z) for detail in details}
    portals = np.flatnonzero(rim.beyond == Level.TUNNEL)
    below = surface.vertices[rim.edges[portals]]
    parts = _parts((points, edges, place), cells, z, band, leaves, water, (portals, below))
    return Ground(tuple(part for part in parts if len(part.faces)), cells, z, water, unknown, between)


def _parts(
    rim: tuple[FloatArray, IntArray, IntArray],
    cells: Cells,
    z: FloatArray,
    band: Band,
    leaves: dict[int, IntArray],
    water: WaterShapes,
    portals: tuple[IntArray, FloatArray],
) -> list[Part]:
    """Return the band, the leaves of each level of detail, and walls.

    `rim` are points (n, 3), m, edges of roads between them, and which points lie above each other; `z` the heights of
    corners of squares, (rows, columns), m; `portals` edges above portals, and those of the roads there, (k, 2, 3), m.
    """
    points, edges, place = rim
    nodes = cells.node_xy()
    vertices = np.concatenate([points, np.column_stack([nodes, z.ravel()])])
    heights, split = on_edges(band.more, cells.between(z, *band.more.T), vertices, edges)
    vertices = np.concatenate([vertices, np.column_stack([band.more, heights])])
    first = int(place.max(initial=-1)) + 1
    places = np.concatenate([place, first + np.arange(len(nodes) + len(band.more))])
    triangles = raised(band.triangles, vertices, places, edges)
    faces = np.concatenate([triangles, *(len(points) + rows for rows in leaves.values())])
    area = np.concatenate([band.area, *(cells.water.ravel()[rows[:, 0]] for rows in leaves.values())])
    detail = np.repeat([-1, *leaves], [len(triangles), *map(len, leaves.values())])
    vertices, origin, places, faces = level_water(vertices, places, faces, area, water.level_of(area), len(points))
    kept = np.ones(len(faces), np.bool_)
    kept[: len(triangles)] = has_area(vertices, faces[: len(triangles)], _LEAST_AREA)
    faces, area, detail = faces[kept], area[kept], detail[kept]
    # Walls stand where triangles of the band and roads that meet differ in height.
    sides = np.concatenate([np.column_stack(half_edges(faces[detail < 0])), split])
    walls, _, _ = steps(sides[:, 0], sides[:, 1], places, vertices, np.inf)
    walls = walls[has_area(vertices, walls, _LEAST_AREA)]
    fields = cells.inside, cells.inside_water
    more = np.column_stack([cells.between(field, *band.more.T) for field in fields])
    corners = np.column_stack([field.ravel() for field in fields])
    within = np.concatenate([np.full((len(points), 2), REACH), corners, more])[origin]
    land = area < 0
    steep = land & (detail < 0)
    steep[steep] = _steep(vertices[faces[steep]])
    parts = []
    for own in leaves:
        for k, (name, material, rows) in enumerate((("Terrain", "grass", land & ~steep), ("Water", "water", ~land))):
            here = faces[rows & ((detail == own) | (detail < 0))]
            parts.append(part_of(name, material, *cut_at_outline(vertices, here, within[:, k]), own))
    upright, walls = cut_at_outline(vertices, np.concatenate([faces[steep], walls]), within[:, 0])
    met = ~lone(*np.concatenate([edges[portals[0]], sides]).T)[: len(portals[0])]
    # Between the opening of tunnels and the ground above.
    over, opening = points[edges[portals[0][met]]], _raised(portals[1][met], TUNNEL_OPENING)
    lintels, _, more_walls = walls_between(opening[:, ::-1], over[:, ::-1])
    walls = np.concatenate([walls, len(upright) + more_walls])
    return [*parts, part_of("Retaining_Wall", "concrete", np.concatenate([upright, lintels]), walls, None)]


def _base(known: FloatArray, level: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return heights of corners, (rows, columns), m: those `known` or of `level` water, and the same without gaps.

    Below level water that the elevation model does not know the ground is as high as the land beside it, lest shores
    that lie between corners rise and fall.
    """
    there = np.where(np.isnan(known), level, known)
    closed = interpolated(there)
    below = np.isnan(known) & np.isfinite(level)
    if below.any() and not below.all():
        closed = np.where(below, np.maximum(continued(np.where(below, np.nan, closed)), level), closed)
    return there, closed


def _known_or(known: Height, cells: Cells, base: FloatArray, points: FloatArray) -> FloatArray:
    """Return the heights of the elevation model at points (n, 2 or 3), m, else those between corners of squares."""
    z = known(points[:, 0], points[:, 1])
    none = np.isnan(z)
    z[none] = cells.between(base, points[none, 0], points[none, 1])
    return z


def _nothing(x: FloatArray, _: FloatArray) -> FloatArray:
    """Return that no height is known."""
    return np.full(len(x), np.nan)


def _edge_points(surface: RoadSurface, rim: Rim, known: Height) -> tuple[FloatArray, IntArray]:
    """Return the points that the ground has to meet, (n, 3), m, and the edges between them.

    They are those of the roads, except at portals of tunnels, over which the ground goes on.
    """
    used, edges = np.unique(rim.edges, return_inverse=True)
    edges, points = edges.reshape(-1, 2), surface.vertices[used]
    portal = rim.beyond == Level.TUNNEL
    ends, raised = np.unique(edges[portal], return_inverse=True)
    over = points[ends].copy()
    over[:, 2] = np.fmax(known(over[:, 0], over[:, 1]), over[:, 2] + TUNNEL_COVER)
    edges[portal] = len(points) + raised.reshape(-1, 2)
    return np.concatenate([points, over]), edges


def _points_of(surface: RoadSurface, level: Level) -> FloatArray:
    """Return points all over the roads of a level, (n, 3), m: along their edges, and at corners of squares."""
    corners = surface.vertices[surface.faces[surface.level == level]]
    sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    edges, _ = along_edges(sides, GROUND_CELL / 2)
    planes, nodes = Planes(corners), GROUND_CELL * np.unique(np.rint(edges[:, :2] / GROUND_CELL), axis=0)
    node, face = planes.at(nodes)
    return np.concatenate([edges, np.column_stack([nodes[node], planes.values(face, nodes[node])])])


def _limits(edges: FloatArray, beyond: IntArray, above: FloatArray, below: FloatArray) -> Limits:
    """Return what bounds the height of the ground: edges (n, 2, 3), and points of bridges and in tunnels."""
    rim, edge = along_edges(edges)
    along = edges[:, 1, :2] - edges[:, 0, :2]
    normal = np.column_stack([along[:, 1], -along[:, 0]])[edge]
    count = [len(rim), len(below), len(above)]
    return Limits(
        np.concatenate([rim, _raised(below, TUNNEL_COVER), _raised(above, -_BRIDGE_DEPTH)]),
        np.concatenate([normal, np.zeros((count[1] + count[2], 2))]),
        np.repeat([True, True, False], count),
        # The ground above a portal may be higher.
        np.concatenate([beyond[edge] != Level.TUNNEL, np.repeat([False, True], count[1:])]),
    )


def _steep(corners: FloatArray) -> BoolArray:
    """Return which triangles (n, 3, 3) are walls."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    rise = np.hypot(normal[:, 0], normal[:, 1])
    out: BoolArray = (rise > _GROUND_WALL_SLOPE * np.abs(normal[:, 2])) & (
        np.ptp(corners[..., 2], axis=1) > _GROUND_WALL_HEIGHT
    )
    return out


def _raised(points: FloatArray, by: float) -> FloatArray:
    """Return points higher by some metres."""
    out: FloatArray = points + np.array([0.0, 0.0, by])
    return out


def cut_at_outline(vertices: FloatArray, faces: IntArray, inside: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return vertices (n, 3), m, those that were there first, and triangles up to where `inside` (n,) is 0.

    Triangles that share a side share the corner on it: the ground stays without a gap.
    """
    value = inside[faces]
    whole, cut = (value >= 0.0).all(1), (value < 0.0).any(1) & (value > 0.0).any(1)
    corners, values = faces[cut], value[cut]
    a, b = corners[:, _AROUND[:, 0]], corners[:, _AROUND[:, 1]]
    crossed: BoolArray = values[:, _AROUND[:, 0]] * values[:, _AROUND[:, 1]] < 0.0
    kept = np.where(a == b, values[:, _AROUND[:, 0]] >= 0.0, crossed)
    count = len(vertices)
    key, new = np.unique(np.minimum(a, b)[crossed] * count + np.maximum(a, b)[crossed], return_inverse=True)
    number = a.copy()
    number[crossed] = count + new
    one, other = np.divmod(key, count)
    share = (inside[one] / (inside[one] - inside[other]))[:, None]
    more = vertices[one] + share * (vertices[other] - vertices[one])
    # Three or four corners, first.
    order = np.argsort(~kept, axis=1, kind="stable")
    pieces = np.take_along_axis(number, order, axis=1)[:, _HALVES]
    real = np.column_stack([np.ones(len(corners), np.bool_), kept.sum(1) == 4])
    return np.concatenate([vertices, more]), np.concatenate([faces[whole], pieces[real]])
