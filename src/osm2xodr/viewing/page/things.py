"""What stands on and beside roads, for the page: objects, signals and their controllers, and the scene in 3D.

A page must stay small and quick: numbers are packed as whole ones that compress well, meshes have whole centimetres,
the ground its coarsest level of detail, and long networks are made of longer pieces.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Any, Final, TypeAlias

import numpy as np
import numpy.typing as npt

from osm2xodr.curves import unique_all
from osm2xodr.defaults import SAMPLE_STEP, SAMPLE_TOLERANCE
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.furniture_shapes import (
    DASH,
    DASH_GAP,
    DRAWN_MARK_WIDTH,
    FURNITURE_FROM,
    LARGEST_SYMBOL,
    MARKS_FROM,
    SMALLEST_SYMBOL,
    SYMBOL,
    Area,
    Disc,
    Symbol,
    face_of,
    forms_of,
    headings,
    in_layers,
    placed_objects,
    placed_signals,
    type_of,
)
from osm2xodr.model import FloatArray, IntArray, Surroundings
from osm2xodr.opendrive import Frame, OpenDrive
from osm2xodr.system import record
from osm2xodr.viewing.options import ReportOptions
from osm2xodr.viewing.scene import Scene

_CENTIMETRE = 0.01
_TENTH = 0.1
_FILLED, _DISC, _STROKE = range(3)

# Roads, m, connecting ones as well: up to the first length scenes are as fine as those that are exported, and made
# without being asked for; up to the second one pieces of curves are longer. Choices: a page of some 10 and 60 MB.
FINE_TO: Final = 250_000.0
MOST: Final = 2_500_000.0
# The rectangle around roads, m², likewise: cells of the ground take some 2 MB of memory per km².
_FINE_AREA: Final = 5e8
_MOST_AREA: Final = 2.5e9
# It extends this far beyond the roads, m, as ground does at both sides.
_AROUND: Final = 200.0
_COARSE_TOLERANCE: Final = 0.2
_COARSE_STEP: Final = 40.0
# Borders of tiles are corners of the ground, m: there are no tiles in a page.
_TILE: Final = 1e5
# Whole numbers of the page's meshes, m.
_MESH_STEP: Final = 0.01

Height = Callable[[FloatArray, FloatArray], FloatArray]

Packed: TypeAlias = npt.NDArray[np.int32]

# Stands for "unknown" among whole numbers of 32 bits.
UNKNOWN: Final = -(2**31)
_LARGEST: Final = 2**31 - 1


@record(eq=False)
class Objects:
    """Objects in drawing order, and the forms of each with their corners."""

    types: list[str]  # Of each object
    colours: list[str]  # Of forms
    arrays: dict[str, Packed]


def objects_of(file: OpenDrive, x0: float, y0: float) -> Objects:
    """Return the objects of a file; x0, y0 is the page's origin, m."""
    things = in_layers(placed_objects(file))
    colours: dict[str, int] = {}
    owner: list[int] = []
    kind: list[int] = []
    colour: list[int] = []
    size: list[float] = []
    least: list[float] = []
    start = [0]
    corners: list[tuple[float, float]] = []
    for k, thing in enumerate(things):
        for form in forms_of(thing):
            owner.append(k)
            colour.append(colours.setdefault(form.colour, len(colours)))
            if isinstance(form, Disc):
                corners.append((form.x, form.y))
                kind.append(_DISC)
                size.append(form.radius)
                least.append(form.least)
            else:
                corners += form.corners
                is_area = isinstance(form, Area)
                kind.append(_FILLED if is_area else _STROKE)
                size.append(0.0 if isinstance(form, Area) else form.width)
                least.append(0.0)
            start.append(len(corners))
    places = np.array(corners, np.float64).reshape(-1, 2)
    arrays = {
        "object_road": np.array([thing.item.road for thing in things], np.int32),
        "object_x": quantised(np.array([thing.x - x0 for thing in things]), _CENTIMETRE),
        "object_y": quantised(np.array([thing.y - y0 for thing in things]), _CENTIMETRE),
        "object_z": quantised(np.array([thing.z for thing in things]), _CENTIMETRE),
        "form_object": np.array(owner, np.int32),
        "form_kind": np.array(kind, np.int32),
        "form_colour": np.array(colour, np.int32),
        "form_size": quantised(np.array(size), _CENTIMETRE),
        "form_least": quantised(np.array(least), _TENTH),
        "form_start": np.array(start, np.int32),
        "form_x": quantised(places[:, 0] - x0, _CENTIMETRE),
        "form_y": quantised(places[:, 1] - y0, _CENTIMETRE),
    }
    return Objects([type_of(thing) for thing in things], list(colours), arrays)


def signal_info(file: OpenDrive, x0: float, y0: float) -> dict[str, Any]:
    """Return signals, their faces, and the controllers, of which each lists its signals and junctions.

    A signal is its road, x, y, z of the road there, heading of what it faces (rad), height of its foot above the
    road, height of its body, whether it is a traffic light, its face, its attributes and the roads that refer to it.
    """
    signals = placed_signals(file)
    faces: dict[str, int] = {}
    symbols: list[Symbol] = []
    facing = headings(file, signals)
    rows = []
    by_id: dict[str, list[int]] = {}
    referring: dict[str, list[int]] = {}
    for item in file.furniture:
        if item.kind == "signalReference" and item.road >= 0:
            referring.setdefault(item.attributes.get("id", ""), []).append(item.road)
    for k, (signal, heading) in enumerate(zip(signals, facing, strict=True)):
        item = signal.item
        symbol = face_of(signal)
        face = faces.setdefault(repr(symbol), len(faces))
        if face == len(symbols):
            symbols.append(symbol)
        number = item.attributes.get("id", "")
        by_id.setdefault(number, []).append(k)
        rows.append(
            [
                item.road,
                rounded(signal.x - x0),
                rounded(signal.y - y0),
                rounded(signal.z),
                rounded(heading, 3),
                rounded(item.z_offset),
                rounded(item.height),
                int(signal.is_light),
                face,
                [[key, value] for key, value in item.attributes.items()],
                referring.get(number, []),
            ]
        )
    junctions: dict[str, list[int]] = {}
    for junction, name in file.junctions.controllers:
        junctions.setdefault(name, []).append(junction)
    return {
        "signals": rows,
        "faces": [
            [[[rounded(value) for corner in corners for value in corner], colour] for corners, colour in symbol]
            for symbol in symbols
        ],
        "controllers": [
            [
                item.id,
                item.name,
                [k for number in dict.fromkeys(item.signal_ids) for k in by_id.get(number, [])],
                junctions.get(item.id, []),
            ]
            for item in file.controllers
        ],
    }


def drawing_rules() -> dict[str, float]:
    """Return how marks and symbols are drawn: pixels per metre from which on, and sizes, m and pixels."""
    return {
        "marks_from": MARKS_FROM,
        "furniture_from": FURNITURE_FROM,
        "mark_width": DRAWN_MARK_WIDTH,
        "dash": DASH,
        "gap": DASH_GAP,
        "symbol": SYMBOL,
        "smallest_symbol": SMALLEST_SYMBOL,
        "largest_symbol": LARGEST_SYMBOL,
    }


@record(eq=False)
class Bodies:
    """Meshes, each of one layer and one material."""

    # Rows of layer, material, colour (#rrggbb), roughness, number of vertices, and of triangles
    meshes: list[list[Any]] = field(default_factory=list)
    arrays: dict[str, Packed] = field(default_factory=dict)
    notes: tuple[str, ...] = ()  # Sentences about what the scene has not


def bodies_of(
    file: OpenDrive,
    options: ReportOptions,
    height: Height | None,
    frame: Frame | None,
    drawn: Scene,
    origin: tuple[float, float],
    diagnostics: Diagnostics,
) -> Bodies:
    """Return the scene of a file, without any mesh if there is none, and why.

    Parameters
    ----------
    file
        The road network.
    options
        Whether there is to be a scene, and the file with its buildings.
    height
        The ground's height at inertial x, y (n,), m; None without elevation model.
    frame
        Where the file lies on Earth; None if that is unknown: there are no buildings then.
    drawn
        What is drawn of the file on the map.
    origin
        What is subtracted from inertial x and y on the page, m.
    diagnostics
        Receives that no scene can be made of a damaged file.

    Raises
    ------
    InputError
        A scene is asked for that cannot be made, or the file with buildings cannot be read.
    """
    if options.scene is False:
        return Bodies()
    length = float(np.nansum(np.where(np.isfinite(file.roads.length), file.roads.length, 0.0)))
    if why := _obstacle(length, _area(drawn), asked=options.scene is True):
        if options.scene:
            raise InputError(f"{file.path}: {why}")
        return Bodies(notes=(f"The view in 3D has lanes alone: {why}",))
    surroundings = None
    if options.osm is not None and frame is not None:
        from osm2xodr.osmParsing import read_surroundings

        surroundings = read_surroundings(options.osm), frame
    try:
        return _built(file, length, height, surroundings, origin)
    except Exception as error:
        # A file may be damaged in ways that nobody foresaw, and the rest of the page needs no scene.
        why = str(error) if isinstance(error, InputError) else f"{type(error).__name__}: {error}"
        if options.scene:
            raise InputError(f"{file.path}: no scene can be made of it ({why})") from error
        diagnostics.note("no-scene", "", f"the view in 3D has lanes alone: no scene can be made of the file ({why})")
        return Bodies()


def _built(
    file: OpenDrive,
    length: float,
    height: Height | None,
    surroundings: tuple[Surroundings, Frame] | None,
    origin: tuple[float, float],
) -> Bodies:
    """Return the meshes of a file with roads of a length, m."""
    from osm2xodr.exporting import make_scene, material_of

    form = (SAMPLE_TOLERANCE, SAMPLE_STEP) if length <= FINE_TO else (_COARSE_TOLERANCE, _COARSE_STEP)
    scene = make_scene(file, *form, height, surroundings, _TILE, coarse_ground=True)
    found: dict[tuple[str, str], list[tuple[FloatArray, IntArray]]] = {}
    for part, layer in zip(scene.parts, scene.layers, strict=True):
        found.setdefault((layer, part.material), []).append((part.vertices, part.faces))
    meshes, places, corners = [], [], []
    for (layer, material), pieces in sorted(found.items()):
        vertices, faces = _joined(pieces)
        places.append(vertices)
        corners.append(faces)
        look = material_of(material)
        meshes.append([layer, material, look.colour, look.roughness, len(vertices), len(faces)])
    x, y, z = np.concatenate(places).T
    arrays = {
        "body_x": quantised(x - origin[0], _MESH_STEP),
        "body_y": quantised(y - origin[1], _MESH_STEP),
        "body_z": quantised(z, _MESH_STEP),
        "body_face": np.concatenate(corners).ravel().astype(np.int32),
    }
    return Bodies(meshes, arrays, tuple(f"View in 3D: {note}." for note in scene.notes))


def _area(drawn: Scene) -> float:
    """Return the area of the rectangle around all roads, m²; 0 without any."""
    if not len(drawn.x):
        return 0.0
    return (float(np.ptp(drawn.x)) + _AROUND) * (float(np.ptp(drawn.y)) + _AROUND)


def _obstacle(length: float, area: float, *, asked: bool) -> str:
    """Return why there is no scene of so many roads, m, in so large an area, m²; empty if there is."""
    if not (length > 0.0 and area > 0.0):
        return "there is no road that can be drawn."
    size = f"{length / 1000.0:,.0f} km of roads in an area of {area / 1e6:,.0f} km²"
    if length > MOST or area > _MOST_AREA:
        return f"{size} are too much for one page; crop the file first, or use osm2xodr export --scene."
    if (length > FINE_TO or area > _FINE_AREA) and not asked:
        return f"{size} take long; ask for them with --scene."
    return ""


def _joined(pieces: list[tuple[FloatArray, IntArray]]) -> tuple[FloatArray, IntArray]:
    """Return vertices and triangles of several meshes as those of one, vertices in the order of their first use."""
    first = np.cumsum([0, *(len(vertices) for vertices, _ in pieces)])
    faces = np.concatenate([rows + at for (_, rows), at in zip(pieces, first[:-1].tolist(), strict=True)])
    used, begin, number, _ = unique_all(faces)
    order = np.argsort(begin, kind="stable")
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    vertices = np.concatenate([vertices for vertices, _ in pieces])[used[order]]
    return vertices, rank[number].reshape(-1, 3)


def rounded(value: float | None, digits: int = 2) -> float | None:
    """Return a number rounded to some digits after the point; None where it is unknown."""
    return None if value is None or not math.isfinite(value) else round(float(value), digits)


def quantised(values: FloatArray, step: float) -> npt.NDArray[np.int32]:
    """Return values as whole numbers of steps: `UNKNOWN` where they are not finite, the largest where too large."""
    scaled = np.asarray(values, np.float64) / step
    known = np.isfinite(scaled)
    whole = np.rint(np.clip(np.where(known, scaled, 0.0), -_LARGEST, _LARGEST))
    return np.where(known, whole, float(UNKNOWN)).astype(np.int64).astype(np.int32)


def pack_arrays(arrays: Mapping[str, npt.NDArray[np.int32]]) -> tuple[list[list[Any]], bytes]:
    """Return a table of contents, rows of name and length, and all arrays as one string of bytes.

    Each array is written as differences modulo 2**32, and these as four planes of bytes, the lowest first.
    """
    contents: list[list[Any]] = []
    parts: list[bytes] = []
    for name, values in arrays.items():
        whole = np.ascontiguousarray(values, np.int32).view(np.uint32)
        steps = np.diff(whole, prepend=np.uint32(0)).astype("<u4")
        parts.append(np.ascontiguousarray(steps.view(np.uint8).reshape(-1, 4).T).tobytes())
        contents.append([name, len(whole)])
    return contents, b"".join(parts)
