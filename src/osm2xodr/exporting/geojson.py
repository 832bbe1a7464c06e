"""Road networks as GeoJSON (RFC 7946): WGS 84, heights as third coordinates, one feature per line of text."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from itertools import chain, islice
from typing import Any, Final

import numpy as np

from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import (
    ABSENT,
    Frame,
    Furniture,
    OpenDrive,
    Ribbons,
    Stations,
    frame_of,
    lane_ribbons,
    pose,
    sample_roads,
    surface_points,
)
from osm2xodr.system import ByteSink

# Lanes that are nowhere wider than this are left out of maps, m: it is less than any road mark.
NARROWEST_SHOWN: Final = 0.01

_NO_GEOMETRY: Final = "null"
# Attributes of signals and objects that are numbers (OpenDRIVE 1.8, 13.2 and 14.1).
_NUMBERS: Final = frozenset(
    {
        *("s", "t", "zOffset", "hOffset", "hdg", "pitch", "roll", "width", "height", "length", "radius"),
        *("validLength", "value", "x", "y", "z"),
    }
)
LAYERS: Final = ("roads", "lanes", "junctions", "signals", "objects")

# Longitude, latitude and height to 1 mm.
_COORDINATE: Final = "[%.8f,%.8f,%.3f]"
# Features that are written at a time.
_BLOCK: Final = 2000


def write_geojson(
    file: OpenDrive, stream: ByteSink, tolerance: float, step: float, layers: Sequence[str] = LAYERS
) -> None:
    """Write a road network as GeoJSON; `InputError` if the file does not say where it is on Earth.

    The property ``layer`` holds one of `LAYERS`: reference lines of ``roads`` as lines; ``lanes`` as polygons;
    ``junctions`` as the convex hulls of their connecting roads; ``signals`` as points; ``objects`` as points, or as
    polygons where they have an outline. The attributes of signals and objects are properties by their names in
    OpenDRIVE, those with lengths, angles and values as numbers. ``osm_way_ids`` are the ways of OpenStreetMap that
    roads and lanes are made of, where the file says them. For `tolerance` and `step`, m, see
    `osm2xodr.opendrive.sample_roads`.
    """
    frame, reason = frame_of(file.header)
    if frame is None:
        raise InputError(f"{file.path}: {reason}, and GeoJSON is always in WGS 84; export .obj or .glb instead")
    stations = sample_roads(file, tolerance, step)
    ribbons = lane_ribbons(file, stations)
    texts = _coordinates(frame, ribbons.x, ribbons.y, ribbons.z)
    signals = [item for item in file.furniture if item.kind.startswith("signal")]
    makers: dict[str, Callable[[], Iterator[str]]] = {
        "roads": lambda: _roads(file, frame, stations),
        "lanes": lambda: _lanes(file, ribbons, texts),
        "junctions": lambda: _junctions(file, ribbons, texts),
        "signals": lambda: _points(file, frame, "signals", signals),
        "objects": lambda: _objects(file, frame),
    }
    stream.write(b'{"type":"FeatureCollection","features":[')
    features = chain.from_iterable(makers[layer]() for layer in LAYERS if layer in layers)
    before = "\n"
    while block := list(islice(features, _BLOCK)):
        stream.write((before + ",\n".join(block)).encode())
        before = ",\n"
    stream.write(b"\n]}\n")


def _feature(layer: str, geometry: str, properties: dict[str, Any]) -> str:
    """Return a feature; `geometry` is the text of a geometry, or ``null``."""
    text = json.dumps({"layer": layer, **properties}, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return f'{{"type":"Feature","geometry":{geometry},"properties":{text}}}'


def _coordinates(frame: Frame, x: FloatArray, y: FloatArray, z: FloatArray) -> list[str]:
    """Return points as texts; empty where they are unknown."""
    lon, lat = frame.to_geographic(x, y)
    rows = np.column_stack([lon, lat, frame.height(z)])
    good = np.isfinite(rows).all(1)
    rows = np.where(good[:, None], rows, 0.0) + 0.0
    texts = ("\n".join([_COORDINATE] * len(rows)) % tuple(rows.ravel().tolist())).split("\n") if len(rows) else []
    return [text if known else "" for text, known in zip(texts, good.tolist(), strict=True)]


def _roads(file: OpenDrive, frame: Frame, stations: Stations) -> Iterator[str]:
    """Yield reference lines."""
    texts = _coordinates(frame, stations.x, stations.y, stations.z)
    roads, start = file.roads, stations.start.tolist()
    for k, name in enumerate(roads.id):
        points = list(filter(None, texts[start[k] : start[k + 1]]))
        geometry = f'{{"type":"LineString","coordinates":[{",".join(points)}]}}' if len(points) > 1 else _NO_GEOMETRY
        first, last = file.types.start[k], file.types.start[k + 1]
        properties = {
            "road": name,
            "name": roads.name[k],
            "length": _number(float(roads.length[k])),
            "junction": roads.junction_id[k],
            "rule": "LHT" if roads.left_hand[k] else "RHT",
            "type": file.types.type[first] if last > first else None,
            "speed": _number(float(file.types.speed[first])) if last > first else None,
            "osm_way_ids": file.osm_ways(k),
        }
        yield _feature("roads", geometry, properties)


def _lanes(file: OpenDrive, ribbons: Ribbons, texts: list[str]) -> Iterator[str]:
    """Yield lanes; `texts` are the points of their borders."""
    start = ribbons.start.tolist()
    lanes, sections = file.lanes, file.sections
    for k in np.flatnonzero(ribbons.left != ABSENT).tolist():
        left = slice(start[ribbons.left[k]], start[ribbons.left[k] + 1])
        right = slice(start[ribbons.right[k]], start[ribbons.right[k] + 1])
        width = np.abs(ribbons.t[left] - ribbons.t[right])
        # Counter-clockwise: along the right border, and back along the left one.
        geometry = _polygon([*texts[right], *reversed(texts[left])])
        if geometry == _NO_GEOMETRY or not np.nanmax(width, initial=0.0) > NARROWEST_SHOWN:
            continue
        section = int(lanes.section[k])
        road = int(sections.road[section])
        properties = {
            "road": file.roads.id[road],
            "name": file.roads.name[road],
            "junction": file.roads.junction_id[road],
            "section_s": _number(float(sections.s[section])),
            "lane": int(lanes.id[k]),
            "type": lanes.type[k],
            "width": _number(float(np.nanmean(width))),
            "speed": _number(float(lanes.speed[k])),
            "osm_way_ids": file.osm_ways(road),
        }
        yield _feature("lanes", geometry, properties)


def _junctions(file: OpenDrive, ribbons: Ribbons, texts: list[str]) -> Iterator[str]:
    """Yield junctions as the hulls of the lanes of their connecting roads."""
    owner = file.roads.junction[file.sections.road[ribbons.section]]
    of_point = np.repeat(owner, np.diff(ribbons.start))
    rows = np.flatnonzero((of_point >= 0) & np.isfinite(ribbons.x + ribbons.y + ribbons.z))
    rows = rows[np.argsort(of_point[rows], kind="stable")]
    bounds = np.searchsorted(of_point[rows], np.arange(len(file.junctions.id) + 1)).tolist()
    start = file.junctions.start.tolist()
    for k, name in enumerate(file.junctions.id):
        geometry = _hull(ribbons, texts, rows[bounds[k] : bounds[k + 1]])
        properties = {
            "junction": name,
            "name": file.junctions.name[k],
            "type": file.junctions.type[k],
            "connections": start[k + 1] - start[k],
        }
        yield _feature("junctions", geometry, properties)


def _hull(ribbons: Ribbons, texts: list[str], rows: IntArray) -> str:
    """Return the convex hull of points as the text of a geometry; ``null`` where they span no area."""
    if not len(rows):
        return _NO_GEOMETRY
    # Takes a tenth of a second to load, and reports need other parts of this package alone.
    from scipy.spatial import ConvexHull, QhullError

    try:
        corners = ConvexHull(np.column_stack([ribbons.x[rows], ribbons.y[rows]])).vertices
    except QhullError:
        # All points on one line: lanes without width.
        return _NO_GEOMETRY
    return _polygon([texts[row] for row in rows[corners].tolist()])


def _polygon(texts: Sequence[str]) -> str:
    """Return the text of a polygon; unknown corners are left out, and it is ``null`` with fewer than three."""
    ring = list(filter(None, texts))
    return f'{{"type":"Polygon","coordinates":[[{",".join([*ring, ring[0]])}]]}}' if len(ring) > 2 else _NO_GEOMETRY


def _objects(file: OpenDrive, frame: Frame) -> Iterator[str]:
    """Yield objects: those with an outline as polygons."""
    others = [item for item in file.furniture if item.kind == "object"]
    yield from _points(file, frame, "objects", [item for item in others if not item.outlines])
    for item in others:
        for corners, local in zip(item.outlines, item.local_outlines, strict=True):
            x, y, z = outline_points(file, item, np.array(corners), local)
            # Rings run counter-clockwise: their signed area is positive.
            turned = np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) < 0
            texts = _coordinates(frame, *(values[::-1] if turned else values for values in (x, y, z)))
            yield _feature("objects", _polygon(texts), _properties(file, item))


def _points(file: OpenDrive, frame: Frame, layer: str, items: list[Furniture]) -> Iterator[str]:
    """Yield furniture as points."""
    road = np.array([item.road for item in items], np.int64)
    s, t, h = (np.array([getattr(item, name) for item in items]) for name in ("s", "t", "z_offset"))
    texts = _coordinates(frame, *surface_points(file, road, s, t, np.nan_to_num(h)))
    for item, text in zip(items, texts, strict=True):
        geometry = f'{{"type":"Point","coordinates":{text}}}' if text else _NO_GEOMETRY
        yield _feature(layer, geometry, _properties(file, item))


def _properties(file: OpenDrive, item: Furniture) -> dict[str, Any]:
    """Return the properties of furniture; its own attributes do not hide the road and the kind."""
    own = {name: _value(text) if name in _NUMBERS else text for name, text in item.attributes.items()}
    return {**own, "kind": item.kind, "road": file.roads.id[item.road]}


def _value(text: str) -> float | None:
    """Return the number that a text stands for, or None where it is none."""
    try:
        return _number(float(text))
    except ValueError:
        return None


def _number(value: float) -> float | None:
    """Return a number to 0.1 mm, or None where it is unknown or unlimited."""
    return round(value, 4) if math.isfinite(value) else None


def outline_points(
    file: OpenDrive, item: Furniture, corners: FloatArray, local: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the corners of an outline in space, (n,) each; (u, v, z) turn with the object, (s, t, dz) do not."""
    road = np.full(len(corners), item.road)
    if not local:
        return surface_points(file, road, corners[:, 0], corners[:, 1], corners[:, 2])
    one, at = road[:1], np.array([item.s])
    x, y, z = surface_points(file, one, at, np.array([item.t]), 0.0 if math.isnan(item.z_offset) else item.z_offset)
    turn = pose(file, one, at)[2] + (0.0 if math.isnan(item.hdg) else item.hdg)
    u, v, up, _ = corners.T
    return x + np.cos(turn) * u - np.sin(turn) * v, y + np.sin(turn) * u + np.cos(turn) * v, z + up


def middle_lengths(file: OpenDrive, ribbons: Ribbons) -> FloatArray:
    """Return the lengths of the middles of lanes, level, (lanes,), m; NaN where a lane has no place."""
    out = np.full(len(file.lanes.id), np.nan)
    start = ribbons.start.tolist()
    for row in np.flatnonzero(ribbons.left != ABSENT).tolist():
        left, right = (slice(*start[k : k + 2]) for k in (int(ribbons.left[row]), int(ribbons.right[row])))
        x, y = (0.5 * (values[left] + values[right]) for values in (ribbons.x, ribbons.y))
        out[row] = np.hypot(np.diff(x), np.diff(y)).sum()
    return out
