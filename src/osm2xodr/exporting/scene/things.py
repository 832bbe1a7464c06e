"""What is painted on roads and stands beside them, and the bodies of bridges and tunnels."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from types import MappingProxyType
from typing import Final

import numpy as np
import shapely

from osm2xodr.exporting.scene.meshes import Meshes, SurfaceHeights, half_edges, lone, walls_between
from osm2xodr.exporting.scene.model import CROSSWALK, MARKING, Level, Part, RoadSurface
from osm2xodr.furniture_shapes import (
    DASH,
    DASH_GAP,
    DRAWN_MARK_WIDTH,
    SYMBOL,
    WHITE,
    Disc,
    PlacedObject,
    PlacedSignal,
    Stroke,
    face_of,
    forms_of,
    headings,
    in_layers,
    is_painted,
    mark_pattern,
    placed_objects,
    placed_signals,
    type_of,
)
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import (
    ABSENT,
    OpenDrive,
    Ribbons,
    Stations,
    lane_borders,
    lane_ribbons,
    pose,
    sample_roads,
    section_at,
    surface_points,
)

# ---------------------------------------------------------------- marks of lanes

# Height of paint above the surface, m: enough for depth buffers from afar, too little to be seen from the side.
PAINT: Final = 0.015
# Surfaces farther away in height are not those that a mark is on, m.
_MARK_REACH: Final = 1.0

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


def mark_parts(file: OpenDrive, heights: SurfaceHeights, tolerance: float, step: float) -> list[Part]:
    """Return the road marks of all lanes; see `sample_roads` for `tolerance` and `step`, m."""
    stations = sample_roads(file, tolerance, step)
    ribbons = lane_ribbons(file, stations)
    strips: dict[str, list[FloatArray]] = {}
    for line, colour in _lines(file, stations, ribbons):
        strips.setdefault(colour, []).append(line)
    meshes = Meshes()
    for colour, lines in sorted(strips.items()):
        _add(meshes, f"marking_{colour}", lines, heights)
    return meshes.parts()


def _lines(file: OpenDrive, stations: Stations, ribbons: Ribbons) -> Iterator[tuple[FloatArray, str]]:
    """Yield left and right edge of each painted piece, (points, 2, 4) s, x, y, z, and its colour."""
    marks = file.lanes.marks
    section_s = file.sections.s
    points = np.column_stack([stations.s[ribbons.station], ribbons.x, ribbons.y, ribbons.z])
    for lane in np.flatnonzero(np.diff(marks.start) > 0).tolist():
        border, outward = _border_of(file, ribbons, lane)
        if border is None:
            continue
        line = points[ribbons.start[border] : ribbons.start[border + 1]]
        rows = range(int(marks.start[lane]), int(marks.start[lane + 1]))
        begins = [float(section_s[file.lanes.section[lane]] + marks.s[row]) for row in rows]
        for row, low, high in zip(rows, begins, [*begins[1:], np.inf], strict=True):
            name = marks.type[row]
            colour = "yellow" if file.lanes.mark_color[lane] == "yellow" else "white"
            for lateral, broken, _ in (
                mark_pattern(name, 2 if name == "broken" else 1, colour) if name != "curb" else ()
            ):
                moved = lateral - outward * 0.5 * DRAWN_MARK_WIDTH
                for piece in _pieces(line, low, high, broken=broken):
                    yield _strip(piece, moved), colour


def _border_of(file: OpenDrive, ribbons: Ribbons, lane: int) -> tuple[int | None, int]:
    """Return the border that a lane's marks are on, and which side of it has no lane: 1 the right, -1 the left."""
    number = int(file.lanes.id[lane])
    section = file.lanes.section[lane]
    if number == ABSENT:
        return None, 0
    if number:
        border = int((ribbons.left if number > 0 else ribbons.right)[lane])
        return (None, 0) if border == ABSENT else (border, _outward(file, lane, number))
    for row in range(int(file.lanes.start[section]), int(file.lanes.start[section + 1])):
        if file.lanes.id[row] in (1, -1):
            border = int((ribbons.right if file.lanes.id[row] > 0 else ribbons.left)[row])
            return (None, 0) if border == ABSENT else (border, 0)
    return None, 0


def _outward(file: OpenDrive, lane: int, number: int) -> int:
    """Return the side beyond an outermost border, 0 if there is a lane."""
    step = -1 if number > 0 else 1
    beyond = lane + step
    inside = 0 <= beyond < len(file.lanes.id) and file.lanes.section[beyond] == file.lanes.section[lane]
    return 0 if inside else step


def _pieces(line: FloatArray, low: float, high: float, *, broken: bool) -> Iterator[FloatArray]:
    """Yield the painted pieces of a line (points, 4) between two s."""
    low, high = max(low, float(line[0, 0])), min(high, float(line[-1, 0]))
    while high - low > 1e-3:
        end = min(low + DASH, high) if broken else high
        inner = line[(line[:, 0] > low + 1e-6) & (line[:, 0] < end - 1e-6), 0]
        at = np.concatenate([[low], inner, [end]])
        yield np.column_stack([at, *(np.interp(at, line[:, 0], line[:, k]) for k in (1, 2, 3))])
        low = end + DASH_GAP if broken else high


def _strip(line: FloatArray, lateral: float) -> FloatArray:
    """Return left and right edge, (points, 2, 4), of a line that is moved to the right."""
    along = np.gradient(line[:, 1:3], axis=0)
    along /= np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    right = np.column_stack([along[:, 1], -along[:, 0]])
    out = np.repeat(line[:, None], 2, axis=1)
    for k, side in enumerate((-0.5, 0.5)):
        out[:, k, 1:3] += (lateral + side * DRAWN_MARK_WIDTH) * right
    return out


def _add(meshes: Meshes, material: str, strips: list[FloatArray], heights: SurfaceHeights) -> None:
    """Add strips on the surface."""
    points = np.concatenate(strips).reshape(-1, 4)
    z = heights.at(points[:, 1], points[:, 2], points[:, 3], _MARK_REACH) + PAINT
    count = np.array([len(strip) for strip in strips])
    last = np.zeros(int(count.sum()), np.bool_)
    last[np.cumsum(count) - 1] = True
    k = 2 * np.flatnonzero(~last)
    faces = np.concatenate([np.column_stack([k, k + 1, k + 3]), np.column_stack([k, k + 3, k + 2])])
    side = np.tile([0.0, DRAWN_MARK_WIDTH], len(last))
    vertices = np.column_stack([points[:, 1:3], z])
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    flat = np.cross(b - a, c - a)[:, 2] > 1e-6
    meshes.add(MARKING, material, vertices, np.column_stack([points[:, 0], side]), faces[flat])


# ---------------------------------------------------------------- objects and signals

# Name and material of bodies by type, and the height of those whose file states none, m: those of the report's 3D
# view; all others.
_BODIES: Final = MappingProxyType(
    {
        "tree": ("Vegetation", "vegetation", 6.0),
        "vegetation": ("Vegetation", "vegetation", 1.2),
        "streetLamp": ("Pole", "metal", 7.0),
        "pole": ("Pole", "metal", 4.0),
        "railing": ("GuardRail", "metal", 1.0),
        "barrier": ("Wall", "concrete", 1.0),
        "soundBarrier": ("Wall", "concrete", 3.0),
        "trafficIsland": ("Road_Curb", "kerb", 0.15),
        "building": ("Building", "wall", 6.0),
        "gantry": ("Pole", "metal", 6.0),
        "patch": ("Static", "asphalt", 0.0),
        "roadSurface": ("Static", "asphalt", 0.0),
        "parkingSpace": ("Static", "asphalt", 0.0),
    }
)
_OTHER_BODY: Final = ("Static", "concrete", 0.0)
_TRACK: Final = ("Static", "metal")  # Rails of trams, which are a patch of the road in OpenDRIVE
# Least height of a body, m: lower ones lie on the road.
_FLAT: Final = 0.05
# Height of crosswalks' areas above the surface, m: below their bars. Height of disks that lie.
_AREA: Final = 0.5 * PAINT
_POST: Final = 0.05
_TRUNK: Final = 0.12
_REACH: Final = 1.5
# Where the lower edge of signs hangs if the file does not say, m.
_HANGING: Final = 2.2
_PLATE: Final = 0.02


def object_parts(file: OpenDrive, heights: SurfaceHeights) -> list[Part]:
    """Return objects: what stands beside roads, and paint on them other than lane marks."""
    meshes = Meshes()
    for thing in in_layers(placed_objects(file)):
        _add_object(meshes, thing, heights)
    return meshes.parts()


def signal_parts(file: OpenDrive) -> list[Part]:
    """Return signs and traffic lights."""
    meshes = Meshes()
    signals = placed_signals(file)
    for signal, heading in zip(signals, headings(file, signals), strict=True):
        _add_signal(meshes, signal, heading)
    return meshes.parts()


def _add_object(meshes: Meshes, thing: PlacedObject, heights: SurfaceHeights) -> None:
    """Add the body of an object, or its paint."""
    kind = type_of(thing)
    low = thing.z + (thing.item.z_offset if math.isfinite(thing.item.z_offset) else 0.0)
    if not math.isfinite(low):
        return
    name, material, usual = _BODIES.get(kind, _OTHER_BODY)
    if thing.item.attributes.get("subtype") == "tramTrack":
        name, material = _TRACK
    height = thing.item.height if thing.item.height > 0.0 else usual
    if kind == "crosswalk":
        _draped(meshes, CROSSWALK, "asphalt", thing.corners, thing.z, heights, _AREA)
    for form in forms_of(thing):
        if isinstance(form, Disc):
            _add_standing(meshes, kind, (form.x, form.y, low), height or 0.5, form.radius)
        elif isinstance(form, Stroke):
            edges = _stroke(form)
            _draped(meshes, MARKING, _paint(form.colour), edges, thing.z, heights, PAINT)
        elif is_painted(thing) or height <= _FLAT:
            painted = is_painted(thing) and kind in {"crosswalk", "roadMark"}
            _draped(
                meshes,
                MARKING if painted else name,
                _paint(form.colour) if painted else material,
                form.corners,
                thing.z,
                heights,
                PAINT,
            )
        else:
            meshes.prism(name, material, form.corners, low - (0.5 if low == thing.z else 0.0), low + height)


def _paint(colour: str) -> str:
    """Return the material of paint."""
    return "marking_white" if colour == WHITE else colour


def _add_standing(meshes: Meshes, kind: str, at: tuple[float, float, float], height: float, radius: float) -> None:
    """Add a tree, a lamp or a post."""
    x, y, low = at
    name, material, _ = _BODIES.get(kind, _OTHER_BODY)
    if kind == "tree":
        meshes.post(name, "soil", at, low + 0.35 * height, _TRUNK)
        meshes.post(name, material, (x, y, low + 0.25 * height), low + 0.65 * height, 0.55 * radius, radius)
        meshes.post(name, material, (x, y, low + 0.65 * height), low + height, radius, 0.0)
        return
    meshes.post(name, material, at, low + height, min(radius, 0.1), min(radius, 0.06))
    if kind == "streetLamp":
        meshes.post(name, material, (x, y, low + height - 0.2), low + height, 0.25)


def _stroke(form: Stroke) -> list[tuple[float, float]]:
    """Return the outline of a straight line with its width."""
    (ax, ay), (bx, by) = form.corners[0], form.corners[-1]
    length = math.hypot(bx - ax, by - ay) or 1.0
    u, v = 0.5 * form.width * (by - ay) / length, -0.5 * form.width * (bx - ax) / length
    return [(ax + u, ay + v), (bx + u, by + v), (bx - u, by - v), (ax - u, ay - v)]


def _draped(
    meshes: Meshes,
    name: str,
    material: str,
    corners: list[tuple[float, float]] | tuple[tuple[float, float], ...],
    near: float,
    heights: SurfaceHeights,
    lift: float,
) -> None:
    """Add an area that lies on the road."""
    if len(corners) < 3:
        return
    ring = shapely.Polygon(corners)
    if not ring.is_valid or ring.area < 1e-4:
        return
    flat = np.array(ring.exterior.coords)[:-1]
    z = heights.at(flat[:, 0], flat[:, 1], np.full(len(flat), near), _REACH) + lift
    meshes.face(name, material, np.column_stack([flat, z]), flat)


def _add_signal(meshes: Meshes, signal: PlacedSignal, heading: float) -> None:
    """Add the pole and the plate or box of a sign or light, whose face looks along `heading`."""
    if not math.isfinite(signal.z + heading):
        return
    item, symbol = signal.item, face_of(signal)
    half = max(abs(y) for corners, _ in symbol for _, y in corners)
    size = item.height / (2.0 * half) if 0.1 < item.height < 5.0 else SYMBOL / 2.0
    foot = item.z_offset if item.z_offset > 0.3 else _HANGING
    middle = signal.z + foot + size * half
    name = "TrafficLight" if signal.is_light else "TrafficSign"
    ahead, across = (math.cos(heading), math.sin(heading)), (-math.sin(heading), math.cos(heading))
    back = (signal.x - 0.06 * ahead[0], signal.y - 0.06 * ahead[1])
    meshes.post("Pole", "metal", (*back, signal.z - 0.5), middle + size * half, _POST)
    for layer, (corners, colour) in enumerate(symbol):
        out = _PLATE * (layer + 1)
        # Seen from the front, right is the face's own left.
        places = [
            (
                signal.x + size * u * across[0] + out * ahead[0],
                signal.y + size * u * across[1] + out * ahead[1],
                middle - size * v,
            )
            for u, v in corners
        ]
        plane = [(u, -v) for u, v in corners]
        meshes.face(name, colour, np.array(places), np.array(plane))
        if not layer:
            behind = np.array(places)[::-1] - out * np.array([*ahead, 0.0])
            meshes.face(name, "sign_back", behind, np.array(plane)[::-1] * [-1.0, 1.0])


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
