"""Where signals and objects stand, and which roads are bridges or tunnels."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final, TypeAlias

import numpy as np

from osm2xodr.curves import sine_cosine
from osm2xodr.model import FloatArray
from osm2xodr.opendrive import Furniture, OpenDrive, pose, surface_points
from osm2xodr.system import record

# Bridges and tunnels of each road: kind, from s to s (m) and name.
Structures: TypeAlias = dict[int, list[tuple[str, float, float, str]]]

_SIGNALS: Final = frozenset({"signal", "signalReference"})
_STRUCTURES: Final = frozenset({"bridge", "tunnel"})
# Distance of the corners of objects that extend along a road, m, and their width where the file states none, m.
_CORNER_STEP: Final = 2.0
_USUAL_WIDTH: Final = 0.2
# Copies of one object that are drawn at most: damaged files ask for any number.
_MOST_COPIES: Final = 10_000


@record
class PlacedSignal:
    """A sign or traffic light."""

    item: Furniture  # As read
    # m
    x: float
    y: float
    z: float
    is_light: bool


@record
class PlacedObject:
    """An object, or one of its copies."""

    item: Furniture  # As read
    corners: tuple[tuple[float, float], ...]  # x and y of its outline, or only of its place, m
    # Its place, m, and heading, rad
    x: float
    y: float
    z: float
    heading: float


def placed_signals(file: OpenDrive, roads: frozenset[int] | None = None) -> list[PlacedSignal]:
    """Return signs and traffic lights (of some roads) whose place is known."""
    items = [item for item in file.furniture if item.kind == "signal" and _is_on(item, roads)]
    x, y, z = _places(file, items, [item.s for item in items], [item.t for item in items])
    return [
        PlacedSignal(item, float(x[k]), float(y[k]), float(z[k]), item.attributes.get("dynamic") == "yes")
        for k, item in enumerate(items)
        if math.isfinite(x[k]) and math.isfinite(y[k])
    ]


def placed_objects(file: OpenDrive, roads: frozenset[int] | None = None) -> list[PlacedObject]:
    """Return objects (of some roads) whose place is known, and all copies of those that repeat."""
    spots = [
        spot
        for item in file.furniture
        if item.kind not in _SIGNALS and item.kind not in _STRUCTURES and _is_on(item, roads)
        for spot in _spots(item)
    ]
    items = [spot.item for spot in spots]
    x, y, z = _places(file, items, [spot.s for spot in spots], [spot.t for spot in spots])
    heading = pose(file, np.array([item.road for item in items], np.int64), np.array([spot.s for spot in spots]))[2]
    heading = heading + np.array([0.0 if math.isnan(item.hdg) else item.hdg for item in items])
    owners = [k for k, spot in enumerate(spots) for _ in spot.on_road]
    on_road = [corner for spot in spots for corner in spot.on_road]
    road_x, road_y, _ = _places(file, [items[k] for k in owners], [s for s, _ in on_road], [t for _, t in on_road])
    found: list[list[tuple[float, float]]] = [[] for _ in spots]
    for row, k in enumerate(owners):
        found[k].append((float(road_x[row]), float(road_y[row])))
    out = []
    places = zip(spots, found, x.tolist(), y.tolist(), z.tolist(), heading.tolist(), strict=True)
    for spot, corners, at_x, at_y, at_z, turn in places:
        sin, cos = sine_cosine(turn)
        corners += [(at_x + cos * u - sin * v, at_y + sin * u + cos * v) for u, v in spot.local]
        known = tuple(corner for corner in corners if math.isfinite(corner[0]) and math.isfinite(corner[1]))
        if known and math.isfinite(at_x + at_y + turn):
            out.append(PlacedObject(spot.item, known, at_x, at_y, at_z, turn))
    return out


def headings(file: OpenDrive, signals: Sequence[PlacedSignal]) -> list[float]:
    """Return the direction in which each signal's face looks, rad: against the traffic that it is for."""
    road = np.array([signal.item.road for signal in signals], np.int64)
    along = pose(file, road, np.array([signal.item.s for signal in signals], np.float64))[2]
    out = []
    for signal, heading in zip(signals, along.tolist(), strict=True):
        own = signal.item.hdg
        turn = 0.0 if signal.item.attributes.get("orientation") == "-" else math.pi
        out.append(math.remainder(heading + turn + (0.0 if math.isnan(own) else own), 2.0 * math.pi))
    return out


def _is_on(item: Furniture, roads: frozenset[int] | None) -> bool:
    """Whether an item stands on a road, or on one of some roads."""
    return item.road >= 0 if roads is None else item.road in roads


def structures_of(file: OpenDrive) -> Structures:
    """Return the bridges and tunnels of each road."""
    out: Structures = {}
    for item in file.furniture:
        if item.kind in _STRUCTURES and item.road >= 0 and math.isfinite(item.s) and math.isfinite(item.length):
            name = item.attributes.get("name", "")
            out.setdefault(item.road, []).append((item.kind, item.s, item.s + item.length, name))
    return out


@record
class _Spot:
    """An object or one of its copies at s, t (m); corners are s, t on its road, or u, v in its own frame, m."""

    item: Furniture
    s: float
    t: float
    on_road: tuple[tuple[float, float], ...] = ()
    local: tuple[tuple[float, float], ...] = ()


def _spots(item: Furniture) -> Iterator[_Spot]:
    """Yield the places of an object; those of its copies if it repeats."""
    if not item.repeats:
        if item.outlines and not item.local_outlines[0]:
            yield _Spot(item, item.s, item.t, on_road=tuple((s, t) for s, t, _, _ in item.outlines[0]))
        else:
            yield _Spot(item, item.s, item.t, local=_shape(item))
        return
    for s, length, distance, t_start, t_end, width in item.repeats:
        if not math.isfinite(s + length + distance + t_start + t_end):
            continue
        apart = distance if distance > 0.0 else _CORNER_STEP
        count = min(int(length / apart + 1e-6) if length > 0.0 else 0, _MOST_COPIES)
        share = [k * apart / length for k in range(count + 1)] if length > 0.0 else [0.0]
        if distance > 0.0:
            for part in share:
                yield _Spot(item, s + part * length, t_start + part * (t_end - t_start), local=_shape(item))
        elif length > 0.0:
            half = 0.5 * next((size for size in (width, item.width) if size > 0.0), _USUAL_WIDTH)
            line = [(s + part * length, t_start + part * (t_end - t_start)) for part in (*share, 1.0)]
            edge = [(at, t + half) for at, t in line] + [(at, t - half) for at, t in reversed(line)]
            yield _Spot(item, s, t_start, on_road=tuple(edge))


def _shape(item: Furniture) -> tuple[tuple[float, float], ...]:
    """Return the corners of an object in its own frame, m: of its outline or its box, or only its place."""
    if item.outlines and item.local_outlines[0]:
        return tuple((u, v) for u, v, _, _ in item.outlines[0])
    if item.length > 0.0 and item.width > 0.0:
        u, v = 0.5 * item.length, 0.5 * item.width
        return ((-u, -v), (u, -v), (u, v), (-u, v))
    return ((0.0, 0.0),)


def _places(
    file: OpenDrive, items: Sequence[Furniture], s: Sequence[float], t: Sequence[float]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y, z (m) of s, t on the roads of items, (n,)."""
    road = np.array([item.road for item in items], np.int64)
    return surface_points(file, road, np.asarray(s, np.float64), np.asarray(t, np.float64))
