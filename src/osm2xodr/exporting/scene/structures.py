"""The bodies of bridges and tunnels."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import numpy as np
import shapely

from osm2xodr.exporting.scene.meshes import Meshes, SurfaceHeights, half_edges, lone, walls_between
from osm2xodr.exporting.scene.model import Level, Part, RoadSurface
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import OpenDrive, lane_borders, pose, section_at, surface_points

# Height of the deck of a bridge, m: a twentieth of a usual span of 20 m, as slabs and girders have. A choice.
DECK_HEIGHT: Final = 1.0
# Clear height of a tunnel, m: 4.5 m for traffic (RABT 2006) and the room of signs and lamps above, rounded.
TUNNEL_HEIGHT: Final = 5.0
# Distance of piers, m, their thickness along the road, m, and their width as a share of the deck's. Choices.
_SPAN: Final = 25.0
_PIER: Final = 1.0
_PIER_WIDTH: Final = 0.6
# Lowest pier, m, and how far it reaches into ground and deck, m. Choices.
_LEAST_PIER: Final = 2.5
_FOOTING: Final = 0.5
_INTO_DECK: Final = 0.1

Height = Callable[[FloatArray, FloatArray], FloatArray]


def structure_parts(
    file: OpenDrive, surface: RoadSurface, heights: SurfaceHeights, ground: Height | None
) -> list[Part]:
    """Return the decks below roads on bridges, tubes around those in tunnels, and piers where ground is known."""
    meshes = Meshes()
    bridge, tunnel = surface.level == int(Level.BRIDGE), surface.level == int(Level.TUNNEL)
    edges = _free_edges(surface, bridge)
    _shell(meshes, ("Bridge_Deck", "concrete"), surface, bridge, edges, -DECK_HEIGHT)
    edges = _free_edges(surface, tunnel, alone=True)
    _shell(meshes, ("Tunnel", "concrete"), surface, tunnel, edges, TUNNEL_HEIGHT)
    if ground is not None:
        _piers(meshes, file, heights, ground)
    return meshes.parts()


def _free_edges(surface: RoadSurface, rows: BoolArray, *, alone: bool = False) -> IntArray:
    """Return the edges of some triangles that no other of them has, (n, 2); `alone`: and no other at all."""
    start, end = half_edges(surface.faces)
    own = np.repeat(rows, 3)
    free = np.flatnonzero(own & lone(start, end)) if alone else np.flatnonzero(own)[lone(start[own], end[own])]
    edges = np.column_stack([start[free], end[free]])
    upright = (surface.vertices[edges[:, 0], :2] == surface.vertices[edges[:, 1], :2]).all(1)
    out: IntArray = edges[~upright]
    return out


def _shell(
    meshes: Meshes, part: tuple[str, str], surface: RoadSurface, rows: BoolArray, edges: IntArray, up: float
) -> None:
    """Add a copy of some triangles `up` m above them, that shows its back, and walls between at some edges."""
    used, faces = np.unique(surface.faces[rows][:, ::-1], return_inverse=True)
    meshes.add(*part, surface.vertices[used] + [0.0, 0.0, up], surface.uv[used], faces.reshape(-1, 3))
    ends = surface.vertices[edges]
    name, material = part
    meshes.add(name, material, *walls_between(ends + np.array([0.0, 0.0, up]), ends))


def _piers(meshes: Meshes, file: OpenDrive, heights: SurfaceHeights, ground: Height) -> None:
    """Add piers below bridges, but not on roads."""
    for item in file.furniture:
        if item.kind != "bridge" or item.road < 0 or not math.isfinite(item.s + item.length):
            continue
        # Connecting roads lie on the decks of others.
        if file.roads.junction[item.road] >= 0 or item.length < 1.5 * _SPAN:
            continue
        count = round(item.length / _SPAN)
        s = item.s + item.length * np.arange(1, count) / count
        road = np.full(len(s), item.road)
        right, left = _edges(file, road, s)
        middle, half = 0.5 * (left + right), 0.5 * _PIER_WIDTH * np.abs(left - right)
        x, y, z = surface_points(file, road, s, middle)
        below = ground(x, y)
        turn = pose(file, road, s)[2]
        for k in np.flatnonzero(z - DECK_HEIGHT - below > _LEAST_PIER).tolist():
            cos, sin = math.cos(turn[k]), math.sin(turn[k])
            size = 0.5 * _PIER, float(half[k])
            around = ((-size[0], -size[1]), (size[0], -size[1]), size, (-size[0], size[1]))
            corners = [(float(x[k]) + cos * u - sin * v, float(y[k]) + sin * u + cos * v) for u, v in around]
            if not heights.covered(shapely.Polygon(corners), Level.GROUND):
                meshes.prism("Bridge_Pier", "concrete", corners, below[k] - _FOOTING, z[k] - DECK_HEIGHT + _INTO_DECK)


def _edges(file: OpenDrive, road: IntArray, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return t of the right and left edge of all lanes at places of roads, m."""
    section = section_at(file, road, s)
    low, high = np.zeros(len(s)), np.zeros(len(s))
    for k, row in enumerate(section.tolist()):
        if row < 0:
            continue
        lanes = np.arange(file.lanes.start[row], file.lanes.start[row + 1])
        lanes = lanes[file.lanes.id[lanes] != 0]
        if len(lanes):
            borders = np.concatenate(lane_borders(file, lanes, np.full(len(lanes), s[k])))
            low[k], high[k] = float(np.min(borders)), float(np.max(borders))
    return low, high
