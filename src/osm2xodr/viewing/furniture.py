"""Signals, crossings and other things beside and on roads, and where junctions lie."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from osm2xodr.model import FloatArray
from osm2xodr.opendrive import Furniture, OpenDrive
from osm2xodr.road_space import surface_points
from osm2xodr.viewing.scene import Scene

_SIGNALS = frozenset({"signal", "signalReference"})
_STRUCTURES = frozenset({"bridge", "tunnel"})


@dataclass(frozen=True)
class PlacedSignal:
    """A sign or signal at x, y, z, m."""

    item: Furniture
    x: float
    y: float
    z: float
    is_light: bool


@dataclass(frozen=True)
class PlacedObject:
    """An object's outline, or its place alone: x and y, m."""

    item: Furniture
    corners: tuple[tuple[float, float], ...]


def placed_signals(file: OpenDrive) -> list[PlacedSignal]:
    """Return signs and signals with their places; those without one are left out."""
    items = [item for item in file.furniture if item.kind == "signal" and item.road >= 0]
    x, y, z = _places(file, items, [item.s for item in items], [item.t for item in items])
    return [
        PlacedSignal(item, float(x[k]), float(y[k]), float(z[k]), item.attributes.get("dynamic") == "yes")
        for k, item in enumerate(items)
        if math.isfinite(x[k]) and math.isfinite(y[k])
    ]


def placed_objects(file: OpenDrive) -> list[PlacedObject]:
    """Return objects with their outlines; those without a place are left out."""
    items = [
        item
        for item in file.furniture
        if item.kind not in _SIGNALS and item.kind not in _STRUCTURES and item.road >= 0
    ]
    owners: list[int] = []
    s: list[float] = []
    t: list[float] = []
    for k, item in enumerate(items):
        corners = _outline(item)
        owners += [k] * len(corners)
        s += [corner[0] for corner in corners]
        t += [corner[1] for corner in corners]
    x, y, _ = _places(file, [items[k] for k in owners], s, t)
    found: list[list[tuple[float, float]]] = [[] for _ in items]
    for row, k in enumerate(owners):
        if math.isfinite(x[row]) and math.isfinite(y[row]):
            found[k].append((float(x[row]), float(y[row])))
    return [PlacedObject(item, tuple(corners)) for item, corners in zip(items, found, strict=True) if corners]


def structures_of(file: OpenDrive) -> dict[int, list[tuple[str, float, float, str]]]:
    """Return the bridges and tunnels of each road: kind, from s to s (m) and name."""
    out: dict[int, list[tuple[str, float, float, str]]] = {}
    for item in file.furniture:
        if item.kind in _STRUCTURES and item.road >= 0 and math.isfinite(item.s) and math.isfinite(item.length):
            name = item.attributes.get("name", "")
            out.setdefault(item.road, []).append((item.kind, item.s, item.s + item.length, name))
    return out


def junction_places(file: OpenDrive, scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Return x and y of the middle of each junction's roads, (junctions,), m; NaN where it has none."""
    n = len(file.junctions.id)
    junction = file.roads.junction[scene.station_road]
    rows = np.flatnonzero((junction >= 0) & (junction < n))
    count = np.bincount(junction[rows], minlength=n)
    with np.errstate(invalid="ignore"):
        x = np.bincount(junction[rows], weights=scene.x[rows], minlength=n) / count
        y = np.bincount(junction[rows], weights=scene.y[rows], minlength=n) / count
    return x, y


def _outline(item: Furniture) -> list[tuple[float, float]]:
    """Return s and t of the corners of an object: of its outline, of its box, or its place alone."""
    turn = 0.0 if math.isnan(item.hdg) else item.hdg
    if item.outlines:
        corners = item.outlines[0]
        if not item.local_outlines[0]:
            return [(corner[0], corner[1]) for corner in corners]
        local = [(corner[0], corner[1]) for corner in corners]
    elif item.length > 0.0 and item.width > 0.0:
        u, v = 0.5 * item.length, 0.5 * item.width
        local = [(-u, -v), (u, -v), (u, v), (-u, v)]
    else:
        local = [(0.0, 0.0)]
    # On a bend this takes s and t for straight axes, which over the size of an object they nearly are.
    cos, sin = math.cos(turn), math.sin(turn)
    return [(item.s + cos * u - sin * v, item.t + sin * u + cos * v) for u, v in local]


def _places(
    file: OpenDrive, items: Sequence[Furniture], s: Sequence[float], t: Sequence[float]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y, z of road coordinates on the roads of items, m."""
    road = np.array([item.road for item in items], np.int64)
    return surface_points(file, road, np.asarray(s, np.float64), np.asarray(t, np.float64))
