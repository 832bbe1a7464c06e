"""The ground as parts of a scene: steps in order."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely

from osm2xodr.exporting.scene.ground.band import Covered, band_triangles, raised_triangles
from osm2xodr.exporting.scene.ground.cells import Cells, along_edges, cells_around, nodes_within
from osm2xodr.exporting.scene.ground.covers import Height
from osm2xodr.exporting.scene.ground.defaults import (
    APRON,
    BRIDGE_DEPTH,
    DETAILS,
    GROUND_CELL,
    GROUND_WALL_HEIGHT,
    GROUND_WALL_SLOPE,
    LEAST_AREA,
    REACH,
    TUNNEL_COVER,
    TUNNEL_OPENING,
)
from osm2xodr.exporting.scene.ground.leaves import leaf_sizes, leaf_triangles
from osm2xodr.exporting.scene.ground.slopes import Limits, node_heights
from osm2xodr.exporting.scene.ground.unknown import continued, cut_at_outline, interpolated, with_strips
from osm2xodr.exporting.scene.ground.water import WaterShapes, levelled, split_by_water
from osm2xodr.exporting.scene.model import Level, Part, Rim, RoadSurface
from osm2xodr.exporting.scene.tiles import has_area
from osm2xodr.model import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Ground:
    """The ground around roads."""

    # ``Terrain`` and ``Water``, one for each level of detail, and ``Retaining_Wall``
    parts: tuple[Part, ...]
    cells: Cells
    # Heights of the corners of squares, (rows + 1, columns + 1), m, below level water as well; NaN where unknown
    z: FloatArray
    water: WaterShapes | None
    # Areas around roads that no elevation model knows, m²: without ground, and with heights between those around
    unknown: float
    interpolated: float

    def heights(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return the height of the ground at x, y (n,), m; NaN beyond it.

        It is that between the corners of the smallest squares; on roads that of their edges, on level water its own.
        """
        inside = self.cells.between(self.cells.inside, x, y) >= 0.0
        level = np.full(len(x), np.nan) if self.water is None else self.water.level_at(x, y)
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
    if water is not None:
        beside = surface.vertices[np.unique(rim.edges[rim.beyond == Level.GROUND])]
        water = levelled(water, known, beside)
    points, edges = _edge_points(surface, rim, known)
    beyond = rim.beyond
    xy, place = np.unique(points[:, :2], axis=0, return_inverse=True)
    flat = place[edges]
    flat = flat[flat[:, 0] != flat[:, 1]]
    covered = _on_roads(surface)
    above, below = (_points_of(surface, level) for level in (Level.BRIDGE, Level.TUNNEL))
    others = np.concatenate([above, below])[:, :2]
    found = None if water is None or height is None or not water.areas else water.found_at
    cells = cells_around(xy[flat[:, 0]], xy[flat[:, 1]], others, covered, APRON if height is None else REACH, found)
    x, y = (axis.ravel() for axis in cells.node_xy())
    limits = _limits(points[edges], beyond, above, below)
    level = np.full(cells.nodes, np.nan) if water is None else water.level_of(cells.water)
    there, closed = _base(known(x, y).reshape(cells.nodes), level)
    base, inside = with_strips(cells, closed, limits.xyz[limits.normal.any(1)])
    z = node_heights(cells, base, limits, _known_or(known, cells, base, limits.xyz))
    lost, guessed = (cells.inside > 0.0) & (inside < 0.0), (inside > 0.0) & np.isnan(there) & ~np.isnan(closed)
    cells, z = replace(cells, inside=inside), continued(z)
    vertices = np.concatenate([points, np.column_stack([x, y, z.ravel()])])
    places = np.concatenate([place, len(xy) + np.arange(len(x))])
    band, walls = raised_triangles(band_triangles(cells, xy, flat, covered), vertices, places, edges)
    band, walls = (faces[has_area(vertices, faces, LEAST_AREA)] for faces in (band, walls))
    steep = _steep(vertices[band])
    parts = []
    within = np.concatenate(
        [np.full((len(points), 2), REACH), np.column_stack([inside.ravel(), cells.inside_water.ravel()])]
    )
    for detail in range(DETAILS - 1 if coarsest_alone else 0, DETAILS):
        leaves = len(points) + leaf_triangles(cells, leaf_sizes(cells, detail, tile), z)
        faces = np.concatenate([band[~steep], leaves])
        parts += _land_and_water(vertices, faces, within, water, detail)
    portal = np.flatnonzero((beyond == Level.TUNNEL) & _met(edges, band))
    lintels, corners = _lintels(points[edges[portal]], surface.vertices[rim.edges[portal]])
    faces = np.concatenate([band[steep], walls, len(vertices) + corners])
    parts.append(_part("Retaining_Wall", "concrete", np.concatenate([vertices, lintels]), faces, None))
    kept = tuple(part for part in parts if len(part.faces))
    return Ground(kept, cells, z, water, *(GROUND_CELL**2 * int(some.sum()) for some in (lost, guessed)))


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


def _land_and_water(
    vertices: FloatArray, faces: IntArray, within: FloatArray, water: WaterShapes | None, detail: int
) -> list[Part]:
    """Return the ground of a level of detail; `within`, (n, 2), m, are the outlines of land and of water."""
    if water is None or not water.areas:
        vertices, faces = cut_at_outline(vertices, faces, within[:, 0])
        return [_part("Terrain", "grass", vertices, faces, np.full(len(faces), detail))]
    split = split_by_water(np.column_stack([vertices, within]), faces, water)
    parts = []
    for name, material, rows, outline in (
        ("Terrain", "grass", split.land, 3),
        ("Water", "water", split.water, 4),
        ("Retaining_Wall", "concrete", split.walls, 3),
    ):
        vertices, faces = cut_at_outline(split.vertices[:, :3], rows, split.vertices[:, outline])
        parts.append(_part(name, material, vertices, faces, np.full(len(faces), detail)))
    return parts


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


def _on_roads(surface: RoadSurface) -> Covered:
    """Return what says whether places in plan (n, 2), m, lie on a road on the ground."""
    shapes = shapely.polygons(surface.vertices[surface.faces[surface.level == Level.GROUND]][:, :, :2])
    tree = shapely.STRtree(shapes[shapely.area(shapes) > 0.0])

    def covered(xy: FloatArray) -> BoolArray:
        out = np.zeros(len(xy), np.bool_)
        out[tree.query(shapely.points(xy), predicate="intersects")[0]] = True
        return out

    return covered


def _points_of(surface: RoadSurface, level: Level) -> FloatArray:
    """Return points all over the roads of a level, (n, 3), m: along their edges, and at corners of squares."""
    corners = surface.vertices[surface.faces[surface.level == level]]
    ends = np.roll(corners, -1, axis=1)
    edges, _ = along_edges(corners.reshape(-1, 3), ends.reshape(-1, 3), GROUND_CELL / 2)
    return np.concatenate([edges, nodes_within(corners)])


def _limits(edges: FloatArray, beyond: IntArray, above: FloatArray, below: FloatArray) -> Limits:
    """Return what bounds the height of the ground: edges (n, 2, 3), and points of bridges and in tunnels."""
    rim, edge = along_edges(edges[:, 0], edges[:, 1])
    along = edges[:, 1, :2] - edges[:, 0, :2]
    normal = np.column_stack([along[:, 1], -along[:, 0]])[edge]
    count = [len(rim), len(below), len(above)]
    return Limits(
        np.concatenate([rim, _raised(below, TUNNEL_COVER), _raised(above, -BRIDGE_DEPTH)]),
        np.concatenate([normal, np.zeros((count[1] + count[2], 2))]),
        np.repeat([True, True, False], count),
        # The ground above a portal may be higher.
        np.concatenate([beyond[edge] != Level.TUNNEL, np.repeat([False, True], count[1:])]),
    )


def _met(edges: IntArray, triangles: IntArray) -> BoolArray:
    """Return which edges, the road on their left, have a triangle of the ground on their right."""
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    total = int(max(edges.max(initial=0), triangles.max(initial=0))) + 1
    return np.isin(edges[:, 1] * total + edges[:, 0], start * total + end)


def _steep(corners: FloatArray) -> BoolArray:
    """Return which triangles (n, 3, 3) are walls."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    rise = np.hypot(normal[:, 0], normal[:, 1])
    out: BoolArray = (rise > GROUND_WALL_SLOPE * np.abs(normal[:, 2])) & (
        np.ptp(corners[..., 2], axis=1) > GROUND_WALL_HEIGHT
    )
    return out


def _lintels(over: FloatArray, road: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return corners and triangles of the walls between the openings of tunnels and the ground above.

    `over` and `road`, (n, 2, 3), are edges of the ground and of the road below, which is on their left.
    """
    low = _raised(road, TUNNEL_OPENING)
    quads = np.stack([over[:, 0], over[:, 1], low[:, 1], low[:, 0]], 1)
    first = 4 * np.arange(len(quads))[:, None]
    return quads.reshape(-1, 3), (first + np.array([0, 1, 2, 0, 2, 3])).reshape(-1, 3)


def _raised(points: FloatArray, by: float) -> FloatArray:
    """Return points higher by some metres."""
    out: FloatArray = points + np.array([0.0, 0.0, by])
    return out


def _part(name: str, material: str, vertices: FloatArray, faces: IntArray, detail: IntArray | None) -> Part:
    """Return triangles with just the vertices that they need."""
    used, number = np.unique(faces, return_inverse=True)
    corners = vertices[used]
    return Part(name, material, corners, corners[:, :2].copy(), number.reshape(-1, 3), detail)
