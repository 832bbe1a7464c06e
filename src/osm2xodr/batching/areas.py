"""Areas of one map: squares of a grid, or outlines from a file, and the file that all of them share.

``osm2xodr batch --shared-frame`` writes it, with the frame and the outlines of areas side by side, and ``osm2xodr
convert --frame`` reads it. Bounds of maps are kept, because reading a map takes minutes.
"""

from __future__ import annotations

import json
import math
import re
import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Final
from xml.etree import ElementTree

import numpy as np

from osm2xodr import __version__
from osm2xodr.batching.model import Area
from osm2xodr.errors import InputError
from osm2xodr.model import LocalFrame, Outline, Partition
from osm2xodr.projection import make_frame, to_geographic, to_local
from osm2xodr.system import parse_json, record, stream_to

RingDeg = tuple[tuple[float, float], ...]

# Side of the smallest tiles, m: most roads are cut several times by smaller ones. And the greatest number of tiles.
# Both are choices.
_TILE_SIDE_MIN: Final = 200.0
_TILES_MAX: Final = 100_000
# Origins of the frames of tiles are rounded to this, degrees, so that tiles keep their names and ids when the map's
# bounds move a little from one extract to the next; a choice.
_ORIGIN_STEP_DEG: Final = 0.1
# Number of the tile north-east of the frame's origin, so that names sort from west to east and from south to north.
_TILE_ZERO: Final = 500
# Tiles are laid out together in blocks up to this wide, m, and of up to so many tiles along a side. Surroundings take
# a third more work for tiles of 5 km, and a tenth more for blocks; the roads of the densest block take some 2 GB.
# Choices.
_BLOCK_SIDE: Final = 20_000.0
_BLOCK_TILES: Final = 8
_CELL_CORNERS: Final = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
# A transverse Mercator projection is of little use farther than half of this from its meridian, degrees.
_SPAN_MAX_DEG: Final = 60.0
# Points on each side of the map's bounds, whose sides are curves in the frame.
_SIDE_POINTS: Final = 33
# Names of the batch's own files, and the longest name, bytes: file systems take 255 with the endings.
_TAKEN_NAMES: Final = frozenset({"summary", "index", "frame"})
_NAME_MAX: Final = 120

# Version of the layout; goes up when a field is removed or changes its meaning.
_FRAME_FORMAT: Final = 1
# Ids of roads and junctions that each area may use; a choice.
_IDS_PER_AREA: Final = 100_000

_Bounds = tuple[float, float, float, float]


@record
class Block:
    """Areas side by side that are cut out of a map at once, and laid out at once."""

    name: str  # Unique in the batch, among areas as well
    outline: Outline  # Around all of them, local x, y, m


@record
class PlannedArea:
    """An area with its outline in a local frame."""

    area: Area
    # Of what is cut out; None for the whole map
    frame: LocalFrame | None = None
    outline: Outline | None = None
    number: int = 0  # From 0 on; it stays the same when other areas come or go
    block: Block | None = None  # The block that it is made with; None if it is made by itself


def check_name(name: str) -> str:
    """Return why a name cannot be the name of an area, and of its files; empty if it can."""
    if not name or len(name.encode("utf-8", "replace")) > _NAME_MAX:
        return f"a name has 1 to {_NAME_MAX} bytes"
    if name.lower() in _TAKEN_NAMES:
        return "the batch has a file of this name"
    if name[0] in ".-" or name != name.strip() or name[-1] == ".":
        return "a name begins with neither a dot nor a dash, and ends with no dot or space"
    wrong = [sign for sign in name if sign in '/\\:*?"<>|' or unicodedata.category(sign)[0] == "C"]
    return f"a name cannot hold {wrong[0]!r}" if wrong else ""


def check_names(names: Iterable[str], where: str) -> None:
    """Refuse names that cannot be, and names that differ in case alone; `where` they stand is said in the error."""
    seen: dict[str, str] = {}
    for name in names:
        if wrong := check_name(name):
            raise InputError(f"{where}: {name!r} cannot be the name of an area: {wrong}; choose another one")
        key = unicodedata.normalize("NFC", name).casefold()
        if key in seen:
            raise InputError(f"{where}: two areas are called {name!r}; give each a name of its own")
        seen[key] = name


def frame_around(rings: Sequence[RingDeg]) -> LocalFrame:
    """Return the local frame with its origin in the middle of some rings."""
    corners = np.array([corner for ring in rings for corner in ring])
    lon, lat = (corners.min(axis=0) + corners.max(axis=0)) / 2.0
    return make_frame(float(lat), float(lon))


def outlined(area: Area, frame: LocalFrame | None = None, number: int = 0) -> PlannedArea:
    """Return an area with its outline in a frame, by default one of its own."""
    if not area.outline_deg:
        return PlannedArea(area, number=number)
    frame = frame or frame_around(area.outline_deg)
    rings = tuple(np.column_stack(to_local(frame, *np.array(ring).T)) for ring in area.outline_deg)
    return PlannedArea(area, frame, Outline(rings), number)


def parse_length(text: str) -> float:
    """Return the side of tiles such as ``5km`` or ``800m`` in metres; ValueError says why a text is none."""
    match = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*(km|m)\s*", text, re.IGNORECASE)
    if match is None:
        raise ValueError(f"{text!r} is not a length; give one such as 5km or 800m")
    length = float(match[1]) * (1000.0 if match[2].lower() == "km" else 1.0)
    if length < _TILE_SIDE_MIN:
        raise ValueError(f"tiles of {text} are too small; give at least {_TILE_SIDE_MIN:g}m")
    return length


def make_tiles(
    bounds: tuple[float, float, float, float], side: float, area: Area, *, in_blocks: bool = False
) -> list[PlannedArea]:
    """Cover bounds (west, south, east, north, degrees, WGS 84) with squares of a side, m.

    In a frame with its origin at the rounded middle of the bounds they begin at multiples of `side`. `area` is what
    they share, apart from name and outline; `in_blocks` says that neighbouring ones are made together. Raises
    `InputError` if there would be too many.
    """
    west, south, east, north = bounds
    if east - west > _SPAN_MAX_DEG:
        raise InputError(f"{area.osm} reaches too far round the world for tiles; cut out a country first")
    step = _ORIGIN_STEP_DEG
    frame = make_frame(round((south + north) / 2.0 / step) * step, round((west + east) / 2.0 / step) * step)
    share = np.linspace(0.0, 1.0, _SIDE_POINTS)
    one = np.ones(_SIDE_POINTS)
    lon, lat = west + share * (east - west), south + share * (north - south)
    x, y = to_local(
        frame,
        np.concatenate([lon, lon, west * one, east * one]),
        np.concatenate([south * one, north * one, lat, lat]),
    )
    columns, rows = (range(math.floor(v.min() / side), math.floor(v.max() / side) + 1) for v in (x, y))
    count = len(columns) * len(rows)
    most = max(abs(k) for k in (columns[0], columns[-1], rows[0], rows[-1]))
    if count > _TILES_MAX or most >= _TILE_ZERO:
        raise InputError(
            f"{area.osm} is too large for tiles of {side:g} m: there would be {count:,}; give larger ones"
        )
    cells = np.array([(column, row) for column in columns for row in rows])
    rings = (cells[:, None, :] + _CELL_CORNERS) * side
    rings_deg = np.round(np.stack(to_geographic(frame, rings[..., 0], rings[..., 1]), axis=-1), 7).tolist()
    found = []
    for (column, row), ring, ring_deg in zip(cells.tolist(), rings, rings_deg, strict=True):
        name = f"x{_TILE_ZERO + column:03d}_y{_TILE_ZERO + row:03d}"
        named = replace(area, name=name, outline_deg=(tuple((lon, lat) for lon, lat in ring_deg),))
        found.append(PlannedArea(named, frame, Outline((ring,)), _number(column, row)))
    if not in_blocks:
        return found
    many = int(max(1, min(_BLOCK_TILES, _BLOCK_SIDE // side)))
    blocks = _blocks(columns, rows, side, many)
    return [
        replace(item, block=blocks[column // many, row // many])
        for item, (column, row) in zip(found, cells.tolist(), strict=True)
    ]


def _blocks(columns: range, rows: range, side: float, many: int) -> dict[tuple[int, int], Block]:
    """Return the blocks of `many` by `many` cells that a grid consists of, by their place."""
    found = {}
    for i in range(columns[0] // many, columns[-1] // many + 1):
        for k in range(rows[0] // many, rows[-1] // many + 1):
            low = np.array([max(i * many, columns[0]), max(k * many, rows[0])])
            high = np.array([min((i + 1) * many, columns[-1] + 1), min((k + 1) * many, rows[-1] + 1)])
            ring = (low + _CELL_CORNERS * (high - low)) * side
            name = f"block_x{_TILE_ZERO + i * many:03d}_y{_TILE_ZERO + k * many:03d}"
            found[i, k] = Block(name, Outline((ring,)))
    return found


def _number(column: int, row: int) -> int:
    """Return the number of a cell of an endless grid, counted from the middle outwards.

    Szudzik, An elegant pairing function, 2006, of column and row in the order 0, -1, 1, -2 ...
    """
    a, b = (2 * k if k >= 0 else -2 * k - 1 for k in (column, row))
    return b * b + a if a < b else a * a + a + b


def read_areas(path: Path, area: Area) -> list[PlannedArea]:
    """Read areas from polygons in GeoJSON, each named by its property ``name`` or its id.

    Raises `InputError` if the file cannot be read or has no such polygons.
    """
    found = [
        replace(area, name=name or f"area_{place}", outline_deg=rings, where=f"{path}, feature {place}")
        for place, (name, rings) in enumerate(read_polygons(path), start=1)
    ]
    check_names((item.name for item in found), str(path))
    frame = frame_around([ring for item in found for ring in item.outline_deg])
    return [outlined(item, frame, number) for number, item in enumerate(found)]


def read_file(path: Path) -> bytes:
    """Return the contents of a file that the user names."""
    try:
        return path.read_bytes()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(f"{path} cannot be read: {reason}; check the path") from error


def read_polygons(path: Path) -> list[tuple[str, tuple[RingDeg, ...]]]:
    """Return the name, which may be empty, and the rings of each polygon of a GeoJSON file."""
    try:
        document = parse_json(read_file(path))
    except ValueError as error:
        raise InputError(f"{path} is not GeoJSON ({error}); give polygons in GeoJSON") from error
    kind = document.get("type") if isinstance(document, dict) else None
    features = document.get("features") if kind == "FeatureCollection" else [document]
    if kind is None or not isinstance(features, list) or not features:
        raise InputError(f"{path} holds no GeoJSON features; give polygons in GeoJSON")
    return [_polygon(feature, f"{path}, feature {place}") for place, feature in enumerate(features, start=1)]


def _polygon(feature: Any, where: str) -> tuple[str, tuple[RingDeg, ...]]:
    feature = feature if isinstance(feature, dict) else {}
    geometry = feature.get("geometry") if feature.get("type") == "Feature" else feature
    geometry = geometry if isinstance(geometry, dict) else {}
    kind, coordinates = geometry.get("type"), geometry.get("coordinates")
    if kind not in ("Polygon", "MultiPolygon") or not isinstance(coordinates, list):
        raise InputError(f"{where}: it is not a Polygon or MultiPolygon, but {kind}; give areas as polygons")
    parts = [coordinates] if kind == "Polygon" else coordinates
    rings = tuple(check_ring(ring, where) for part in parts for ring in (part if isinstance(part, list) else [part]))
    if not rings:
        raise InputError(f"{where}: it has no corners; remove it, or give some")
    given = feature.get("properties")
    properties = given if isinstance(given, dict) else {}
    for value in (properties.get("name"), properties.get("id"), feature.get("id")):
        if isinstance(value, (str, int)) and not isinstance(value, bool) and str(value):
            return str(value), rings
    return "", rings


def check_ring(corners: Any, where: str) -> RingDeg:
    """Return corners [longitude, latitude], degrees, as a ring whose first corner is not repeated at its end."""
    ring: list[tuple[float, float]] = []
    for corner in corners if isinstance(corners, list) else []:
        numbers: list[Any] = corner if isinstance(corner, list) and len(corner) >= 2 else [None, None]
        if not all(isinstance(item, (int, float)) and not isinstance(item, bool) for item in numbers[:2]):
            raise InputError(f"{where}: {str(corner)[:60]} is not a corner; give [longitude, latitude] in degrees")
        lon, lat = float(numbers[0]), float(numbers[1])
        if not (abs(lon) <= 180.0 and abs(lat) < 90.0):
            raise InputError(f"{where}: {lon:g}, {lat:g} is not a place; give [longitude, latitude] in degrees")
        ring.append((lon, lat))
    if len(ring) > 1 and ring[0] == ring[-1]:
        ring.pop()
    if len(set(ring)) < 3:
        raise InputError(f"{where}: a ring needs three corners or more; give lists of [longitude, latitude]")
    if max(lon for lon, _ in ring) - min(lon for lon, _ in ring) > 180.0:
        raise InputError(f"{where}: it reaches round half of the world or more; split areas at the 180th meridian")
    return tuple(ring)


def shared_frame(planned: Sequence[PlannedArea]) -> dict[str, Any]:
    """Return the contents of the file; `InputError` says that there are more areas than ids for their roads."""
    frame = planned[0].frame
    assert frame is not None
    areas = []
    for item in sorted(planned, key=lambda item: item.area.name):
        assert item.outline is not None
        first = 1 + _IDS_PER_AREA * item.number
        # Several readers keep ids as numbers of 32 bits.
        if first + _IDS_PER_AREA > 2**31:
            raise InputError(
                "there are too many areas for --shared-frame to give ids; choose larger ones, or a smaller map"
            )
        rings = [ring.tolist() for ring in item.outline.rings]
        block = {} if item.block is None else {"block": item.block.name}
        areas.append({"name": item.area.name, "first_id": first, "rings": rings, **block})
    return {"format": _FRAME_FORMAT, "lat_0_deg": frame.lat_0_deg, "lon_0_deg": frame.lon_0_deg, "areas": areas}


def read_partition(path: Path, own: str, *, in_block: bool = False) -> Partition:
    """Read how areas lie side by side; `own` is the name of the area that is converted, `in_block` with its block.

    The file is JSON: ``format``, the frame's origin ``lat_0_deg`` and ``lon_0_deg``, and ``areas``, each with its
    ``name``, ``first_id``, ``rings`` of local x, y, m, and perhaps the name of its ``block``. Raises `InputError` if
    it cannot be read, is of another kind, or does not have the area or a block of it.
    """
    try:
        found = path.stat()
        partition, blocks = _read(path, found.st_size, found.st_mtime_ns)
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) and error.strerror else "it is not UTF-8"
        raise InputError(f"{path} cannot be read: {why.lower()}; give the file that the batch wrote") from error
    except (ValueError, KeyError, TypeError, IndexError, OverflowError) as error:
        raise InputError(
            f"{path} does not say how areas lie side by side; give the file that osm2xodr batch --shared-frame wrote"
        ) from error
    if own not in partition.names:
        raise InputError(
            f"{path} has no area {own!r}, after which the map is named; give the map of one of its areas"
        )
    index = partition.names.index(own)
    if not in_block:
        return replace(partition, own=index)
    if not blocks[index]:
        raise InputError(f"{path}: area {own!r} is in no block; give its own map, without --tile")
    block = tuple(k for k, name in enumerate(blocks) if name == blocks[index])
    return replace(partition, own=index, block=block)


# Kept, because a process converts many areas of a batch, and the file of a country takes a while to read.
@lru_cache(maxsize=1)
def _read(path: Path, size: int, mtime_ns: int) -> tuple[Partition, tuple[str, ...]]:
    """Read the areas, as the partition of the first one, and the name of the block of each, "" for none.

    What is wrong with the file raises one of the errors that `read_partition` catches.
    """
    table = parse_json(path.read_text(encoding="utf-8"))
    if table["format"] != _FRAME_FORMAT:
        raise InputError(
            f"{path} has format {table['format']}, and this version reads {_FRAME_FORMAT}; run the batch again"
        )
    areas = table["areas"]
    names = tuple(str(area["name"]) for area in areas)
    outlines = tuple(
        Outline(tuple(np.array(ring, np.float64).reshape(-1, 2) for ring in area["rings"])) for area in areas
    )
    rings = [ring for outline in outlines for ring in outline.rings]
    if not all(len(ring) > 2 and np.isfinite(ring).all() for ring in rings):
        raise ValueError
    if not all(outline.rings for outline in outlines):
        raise ValueError
    frame = make_frame(float(table["lat_0_deg"]), float(table["lon_0_deg"]))
    first_ids = tuple(int(area["first_id"]) for area in areas)
    blocks = tuple(str(area.get("block", "")) for area in areas)
    return Partition(frame, names, outlines, first_ids, 0), blocks


def recall_bounds(out_dir: Path, source: Path) -> _Bounds | None:
    """Return the bounds of a map, west, south, east, north, degrees; None if unknown or if the map has changed."""
    try:
        known = parse_json(_file(out_dir).read_bytes())
        if known["mark"] != _mark(source):
            return None
        west, south, east, north = (float(value) for value in known["bounds"])
    except (OSError, ValueError, LookupError, TypeError):
        return None
    return west, south, east, north


def keep_bounds(out_dir: Path, source: Path, bounds: _Bounds) -> None:
    """Keep the bounds of a map for the next run."""
    if recall_bounds(out_dir, source) == bounds:
        return
    with stream_to(_file(out_dir)) as stream:
        stream.write(json.dumps({"mark": _mark(source), "bounds": bounds}).encode("ascii") + b"\n")


def _file(out_dir: Path) -> Path:
    # Without an ending, as the states of areas have.
    return out_dir / ".state" / "bounds"


def _mark(source: Path) -> list[str | int]:
    found = source.stat()
    return [__version__, str(source), found.st_size, found.st_mtime_ns]


def road_bounds(xodr: Path) -> tuple[RingDeg, ...]:
    """Return the bounds in the header of a file that osm2xodr wrote, as corners in degrees; nothing if unknown."""
    try:
        # Opened here, because Python before 3.13 does not close it when reading stops early.
        with xodr.open("rb") as stream:
            for _, element in ElementTree.iterparse(stream, ("end",)):
                if element.tag == "header":
                    return (_ring(element),)
    except (OSError, ElementTree.ParseError, ValueError):
        pass
    return ()


def _ring(header: ElementTree.Element) -> RingDeg:
    proj = re.sub(r"\s*\+(?:geoidgrids|vunits)=\S+", "", header.findtext("geoReference", "")).strip()
    west, south, east, north = (float(header.get(side, "")) for side in ("west", "south", "east", "north"))
    x, y = np.array([west, east, east, west]), np.array([south, south, north, north])
    lon, lat = to_geographic(LocalFrame(proj, 0.0, 0.0), x, y)
    return tuple(zip(np.round(lon, 7).tolist(), np.round(lat, 7).tolist(), strict=True))
