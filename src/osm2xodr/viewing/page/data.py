"""The data of the page: a document of texts and small tables, and arrays of whole numbers, for its data.js.

The graph of lanes is there for the page's routes.
"""

from __future__ import annotations

from collections import Counter
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from osm2xodr import defaults
from osm2xodr.furniture_shapes import Structures, mark_pattern, structures_of
from osm2xodr.model import IntArray
from osm2xodr.opendrive import ABSENT, End, Frame, LinkKind, OpenDrive
from osm2xodr.system import record
from osm2xodr.viewing import colours
from osm2xodr.viewing.colours import Categories, Mode, lane_speeds, lane_types, strip_classes
from osm2xodr.viewing.page.accuracy import LEAST_MATCH, Terrain, WayCover, WayOnRoad
from osm2xodr.viewing.page.things import (
    UNKNOWN,
    Bodies,
    Objects,
    Packed,
    drawing_rules,
    objects_of,
    quantised,
    rounded,
    signal_info,
)
from osm2xodr.viewing.scene import Scene, border_marks, credits_of, junction_places, unmeasured

# Units of the arrays: m, rad, rise per metre, km/h.
_CENTIMETRE: Final = 0.01
_ANGLE_STEP: Final = 1e-5
_GRADE_STEP: Final = 1e-4
_SPEED_STEP: Final = 0.1
_TERRAIN_STEP: Final = 0.1
# Polynomials replace the projection on the page: their degree, points along each side of the square that they are
# fitted to, and its size as a multiple of the roads' extent, or of the last, m.
_ORDER: Final = 4
_FIT_POINTS: Final = 15
_FIT_REACH: Final = 1.1
_LEAST_FIT: Final = 1000.0


@record(eq=False)
class Subject:
    """A file and everything that is known about it."""

    file: OpenDrive
    scene: Scene  # What is drawn of the file
    frame: Frame | None  # Where the file lies on Earth; None if that is unknown
    terrain: Terrain | None  # None without an elevation model
    # OSM's ways, and which roads follow them; None without an OSM file
    covers: list[WayCover] | None
    on_roads: list[WayOnRoad] | None
    structures: Structures  # Bridges and tunnels of each road
    objects: Objects
    bodies: Bodies  # What is seen in 3D


def make_subject(
    file: OpenDrive,
    scene: Scene,
    frame: Frame | None,
    terrain: Terrain | None,
    cover: tuple[list[WayCover], list[WayOnRoad]] | None,
    bodies: Bodies,
) -> Subject:
    """Combine what is known; bridges and tunnels are those of the file, or else those of OSM."""
    structures = structures_of(file)
    covers, on_roads = (None, None) if cover is None else cover
    if not structures and covers is not None and on_roads is not None:
        for item in on_roads:
            way = covers[item.way]
            if way.structure:
                place = (way.structure, item.begin, item.end, f"way/{way.way}")
                structures.setdefault(item.road, []).append(place)
    _add_connecting(file, structures)
    objects = objects_of(file, *origin_of(scene))
    return Subject(file, scene, frame, terrain, covers, on_roads, structures, objects, bodies)


def _add_connecting(file: OpenDrive, structures: Structures) -> None:
    """Add connecting roads from a bridge to a bridge, or from a tunnel to a tunnel: no file names them."""
    roads = file.roads
    found: Structures = {}
    for road in np.flatnonzero((roads.junction != -1) & (roads.link_kind == LinkKind.ROAD).all(axis=1)).tolist():
        if road in structures:
            continue
        arms = zip(roads.link[road].tolist(), roads.contact[road].tolist(), strict=True)
        kinds = {_kind_at(file, structures, arm, contact) for arm, contact in arms}
        if len(kinds) == 1 and "" not in kinds:
            found[road] = [(kinds.pop(), 0.0, float(roads.length[road]), "")]
    structures.update(found)


def _kind_at(file: OpenDrive, structures: Structures, road: int, contact: int) -> str:
    """Return the kind of structure at an end of a road; empty without one."""
    for kind, begin, end, _ in structures.get(road, ()):
        s = float(file.roads.length[road]) if contact == End.END else 0.0
        if begin - LEAST_MATCH <= s <= end + LEAST_MATCH:
            return kind
    return ""


def origin_of(scene: Scene) -> tuple[float, float]:
    """Return what is subtracted from x and y on the page: whole metres, so that coordinates are small."""
    if not len(scene.x):
        return 0.0, 0.0
    return (
        float(np.rint((scene.x.min() + scene.x.max()) / 2.0)),
        float(np.rint((scene.y.min() + scene.y.max()) / 2.0)),
    )


def page_arrays(subject: Subject) -> dict[str, Packed]:
    """Return the arrays of the page."""
    file, scene = subject.file, subject.scene
    x0, y0 = origin_of(scene)
    lanes = file.lanes
    arrays: dict[str, Packed] = {
        "strip_road": _whole(scene.strip_road),
        "strip_class": _whole(strip_classes(file, scene)[1]),
        "station_start": _whole(scene.station_start),
        "lane_start": _whole(scene.lane_start),
        "s": quantised(scene.s, _CENTIMETRE),
        "x": quantised(scene.x - x0, _CENTIMETRE),
        "y": quantised(scene.y - y0, _CENTIMETRE),
        "z": quantised(scene.z, _CENTIMETRE),
        "heading": quantised(np.mod(scene.heading + np.pi, 2.0 * np.pi) - np.pi, _ANGLE_STEP),
        "roll": quantised(scene.roll, _ANGLE_STEP),
        "grade": quantised(scene.grade, _GRADE_STEP),
        "ground": quantised(scene.ground, _CENTIMETRE),
        "border": quantised(scene.border, _CENTIMETRE),
        "lane_id": _whole(lanes.id[scene.lane]),
        "lane_type": _whole(lane_types(file, scene)[1]),
        "lane_speed": quantised(lane_speeds(file, scene), _SPEED_STEP),
        "lane_predecessor": _whole(lanes.predecessor[scene.lane]),
        "lane_successor": _whole(lanes.successor[scene.lane]),
        "mark": _whole(border_marks(file, scene)[1]),
        "road_length": quantised(file.roads.length, _CENTIMETRE),
        "road_junction": _whole(file.roads.junction),
        "link_kind": _whole(file.roads.link_kind.ravel()),
        "link": _whole(file.roads.link.ravel()),
        "contact": _whole(file.roads.contact.ravel()),
    }
    arrays |= subject.objects.arrays
    arrays |= subject.bodies.arrays
    arrays |= lane_arrays(file, scene)
    if subject.terrain is not None:
        arrays["terrain"] = quantised(subject.terrain.z.ravel(), _TERRAIN_STEP)
    return arrays


def page_info(subject: Subject, modes: list[Mode]) -> dict[str, Any]:
    """Return the document without what other modules add: headline, accuracy, coverage, findings, log."""
    file, scene, grid = subject.file, subject.scene, subject.terrain
    x0, y0 = origin_of(scene)
    jx, jy = junction_places(file, scene)
    return {
        "origin": [x0, y0],
        "bounds": _bounds(scene, x0, y0),
        "geographic": _geographic(subject, x0, y0),
        "modes": [_mode(mode) for mode in modes],
        "unknown_colour": colours.UNKNOWN_COLOUR,
        "severities": dict(colours.SEVERITIES),
        "lane_types": list(lane_types(file, scene)[0]),
        "marks": [mark_pattern(*row) for row in border_marks(file, scene)[0]],
        "has_ground": bool(np.isfinite(scene.ground).any()),
        "road": {
            "id": list(file.roads.id),
            "name": list(file.roads.name),
            "classes": _road_classes(file),
            "left_hand": [int(value) for value in file.roads.left_hand],
        },
        "junctions": {
            "id": list(file.junctions.id),
            "name": list(file.junctions.name),
            "x": [rounded(value - x0) for value in jx],
            "y": [rounded(value - y0) for value in jy],
        },
        **signal_info(file, x0, y0),
        "object_types": subject.objects.types,
        "form_colours": subject.objects.colours,
        "drawing": drawing_rules(),
        "bodies": subject.bodies.meshes,
        "credits": credits_of(file),
        "structures": {
            road: [[kind, rounded(begin), rounded(end), name] for kind, begin, end, name in items]
            for road, items in sorted(subject.structures.items())
        },
        "unmeasured": _unmeasured(file),
        "user": _user_data(file),
        "ways": _ways(subject),
        "limits": _limits(subject),
        # The grid of the ground without its heights.
        "terrain": None
        if grid is None
        else {
            "x": rounded(grid.x - x0),
            "y": rounded(grid.y - y0),
            "dx": grid.dx,
            "dy": grid.dy,
            "nx": grid.z.shape[1],
            "ny": grid.z.shape[0],
        },
    }


def _whole(values: IntArray) -> Packed:
    """Return whole numbers of 32 bits; what is absent becomes `UNKNOWN`."""
    return np.where(np.asarray(values) == ABSENT, UNKNOWN, values).astype(np.int64).astype(np.int32)


def _bounds(scene: Scene, x0: float, y0: float) -> list[float]:
    """Return west, south, east, north."""
    if not len(scene.x):
        return [-100.0, -100.0, 100.0, 100.0]
    corners = (scene.x.min() - x0, scene.y.min() - y0, scene.x.max() - x0, scene.y.max() - y0)
    return [round(float(value), 2) for value in corners]


def _geographic(subject: Subject, x0: float, y0: float) -> dict[str, Any] | None:
    """Return polynomials from x, y on the page to longitude and latitude; None where these are unknown."""
    scene = subject.scene
    if subject.frame is None or not len(scene.x):
        return None
    half = max(float(np.ptp(scene.x)), float(np.ptp(scene.y)), _LEAST_FIT) / 2.0
    u, v = (item.ravel() for item in np.meshgrid(*[np.linspace(-_FIT_REACH, _FIT_REACH, _FIT_POINTS)] * 2))
    lon, lat = subject.frame.to_geographic(x0 + half * u, y0 + half * v)
    if not (np.isfinite(lon).all() and np.isfinite(lat).all()):
        return None
    terms = np.stack([u**i * v**j for i in range(_ORDER + 1) for j in range(_ORDER + 1 - i)], axis=1)
    fits = [np.linalg.lstsq(terms, values, rcond=None)[0] for values in (lon, lat)]
    return {
        "x": 0.0,
        "y": 0.0,
        "scale": half,
        "order": _ORDER,
        "lon": [round(float(value), 12) for value in fits[0]],
        "lat": [round(float(value), 12) for value in fits[1]],
    }


def _mode(mode: Mode) -> dict[str, Any]:
    """Return a colour mode as the page reads it."""
    out: dict[str, Any] = {"key": mode.key, "label": mode.label, "title": mode.title}
    scale = mode.scale
    if isinstance(scale, Categories):
        rows = zip(scale.names, scale.colours, scale.labels, scale.present, strict=True)
        return {**out, "kind": "category", "entries": [list(row) for row in rows]}
    ramp = {"stops": list(scale.stops), "low": scale.low, "high": scale.high, "digits": mode.digits}
    return {**out, "kind": "ramp", "unit": scale.unit, **ramp}


def _road_classes(file: OpenDrive) -> list[str]:
    """Return the types of each road in order, each once."""
    start, names = file.types.start.tolist(), file.types.type
    return [", ".join(dict.fromkeys(names[start[k] : start[k + 1]])) for k in range(len(file.roads.id))]


def _unmeasured(file: OpenDrive) -> dict[int, list[list[float]]]:
    """Return begin and end of the stretches of roads whose heights were not measured, m."""
    found = unmeasured(file)
    rows = np.stack([found.begin, found.end], axis=1).tolist()
    start = found.start.tolist()
    return {road: rows[start[road] : start[road + 1]] for road in np.flatnonzero(np.diff(found.start)).tolist()}


def _user_data(file: OpenDrive) -> dict[int, list[list[str]]]:
    """Return userData by road."""
    out: dict[int, list[list[str]]] = {}
    for (road, code), value in file.provenance.items():
        if road >= 0:
            out.setdefault(road, []).append([code, value])
    return out


def _ways(subject: Subject) -> dict[int, list[list[Any]]]:
    """Return the ways that each road follows."""
    out: dict[int, list[list[Any]]] = {}
    for item in subject.on_roads or ():
        way = (subject.covers or [])[item.way]
        row = [way.way, rounded(item.begin, 0), rounded(item.end, 0), way.highway, way.name]
        out.setdefault(item.road, []).append(row)
    return out


def _limits(subject: Subject) -> dict[int, float]:
    """Return the usual limit of the grade of roads whose class in OSM is known, rise per metre."""
    longest: dict[int, Counter[str]] = {}
    for item in subject.on_roads or ():
        highway = (subject.covers or [])[item.way].highway
        longest.setdefault(item.road, Counter())[highway] += int(100.0 * (item.end - item.begin)) + 1
    return {
        road: defaults.GRADE_LIMIT.get(counts.most_common(1)[0][0], defaults.GRADE_LIMIT_OTHER)
        for road, counts in sorted(longest.items())
    }


def on_structure(subject: Subject) -> npt.NDArray[np.bool_]:
    """Whether each station lies on a bridge or in a tunnel, as far as the file or OSM says, (stations,)."""
    scene = subject.scene
    out = np.zeros(len(scene.s), np.bool_)
    first = np.searchsorted(scene.station_road, np.arange(len(subject.file.roads.id) + 1))
    for road, items in subject.structures.items():
        rows = slice(int(first[road]), int(first[road + 1]))
        for _, begin, end, _ in items:
            out[rows] |= (scene.s[rows] >= begin) & (scene.s[rows] <= end)
    return out


def lane_arrays(file: OpenDrive, scene: Scene) -> dict[str, Packed]:
    """Return where cars drive on each lane of a scene (1 along s, 2 against it, 3 both), and the steps between them.

    Steps are pairs of nodes: twice a lane of the scene, plus 1 against s.
    """
    # Loads slowly, as the checks do.
    from osm2xodr.checking import driving_of

    graph = driving_of(file)
    drawn = np.full(len(file.lanes.id), -1, np.int64)
    drawn[scene.lane] = np.arange(len(scene.lane))
    start, end = (2 * drawn[nodes // 2] + nodes % 2 for nodes in (graph.start, graph.end))
    kept = (start >= 0) & (end >= 0)
    traffic = graph.along.astype(np.int32) + 2 * graph.against.astype(np.int32)
    return {
        "lane_traffic": traffic[scene.lane].astype(np.int32),
        "step_start": start[kept].astype(np.int32),
        "step_end": end[kept].astype(np.int32),
    }
