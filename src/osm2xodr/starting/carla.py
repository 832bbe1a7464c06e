"""CARLA: a script that drives on the road network, places for cars to appear at, and a scene to import as a map."""

from __future__ import annotations

import json
from importlib import resources
from typing import Final

import numpy as np

from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray
from osm2xodr.opendrive import elevation, grade, read_xodr
from osm2xodr.python_api import CARLA_TILE, export_scene
from osm2xodr.starting.motion import LaneNetwork, lane_network
from osm2xodr.starting.request import FOLDER, Made, Request
from osm2xodr.xodrWriter import plan_view_bounds

_SCRIPT: Final = "drive.py"
_SPAWN_POINTS: Final = "spawn_points.json"
_IMPORT: Final = "import"
_SCENE: Final = "scene.json"
# Distance of the places along a lane, from its ends, and above the road, m: cars have room, and drop onto the road.
_APART: Final = 25.0
_FROM_ENDS: Final = 6.0
_ABOVE: Final = 0.5
# Areas whose roads reach no farther than this either way become one tile, m.
_ONE_TILE: Final = 2_500.0
# The width of that tile, m: with the ground beside the roads, and the water that reaches 500 m farther.
_WHOLE: Final = 4_000.0

_IMPORTING: Final = """\
The server makes plain meshes of the roads alone. For a map with ground, water and buildings, marks, signs and bridges
import the scene in `{folder}`. CARLA's importer reads FBX alone, which Blender writes:

    cd {folder} && blender --background --python-expr "import bpy, glob
    for path in glob.glob('*.glb'):
        bpy.ops.wm.read_factory_settings(use_empty=True); bpy.ops.import_scene.gltf(filepath=path)
        bpy.ops.export_scene.fbx(filepath=path[:-3] + 'fbx')"

Then copy the folder into `Import` of a CARLA built from source, and run `make import`: `{name}.json` has what
it needs. After that `python3 drive.py --map {name}` drives on it. docs/scene.md of osm2xodr says more."""
_WALKERS: Final = """\
`drive.py` has no walkers, as navigation for them takes longest to make: set `enable_pedestrian_navigation` in it, and
spawn them at `world.get_random_location_from_navigation()`. """
_WALKERS_ONE: Final = """\
On the imported map they go on `Road_Sidewalk` and cross on `Road_Crosswalk` of the scene, once their navigation is
[generated](https://carla.readthedocs.io/en/latest/tuto_M_generate_pedestrian_navigation/)."""
_WALKERS_LOST: Final = (
    "The scene has {tiles} tiles, and CARLA makes no navigation of large maps: walkers are lost there."
)


def make(request: Request) -> Made:
    """Write the script, the places and the scene."""
    request.on_stage("making places to start from")
    points = spawn_points(lane_network(read_xodr(request.xodr)))
    if not points:
        raise InputError(f"there is no lane in {request.name} that a car could appear on; choose a larger area")
    document = {
        "about": "places for cars on lanes of map.xodr, m and degrees of CARLA: y to the south, yaw clockwise",
        "spawn_points": points,
    }
    (request.folder / _SPAWN_POINTS).write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    script = resources.files("osm2xodr.starting").joinpath(f"{_SCRIPT}.txt").read_text(encoding="utf-8")
    (request.folder / _SCRIPT).write_text(script, encoding="utf-8")
    request.on_stage("making the scene")
    names, left_out = _export(request)
    tiles = [name for name in names if name.endswith(".glb")]
    walkers = _WALKERS + (_WALKERS_ONE if len(tiles) == 1 else _WALKERS_LOST.format(tiles=len(tiles)))
    files = {
        _SCRIPT: "drives: an ego, traffic, weather; `--help` lists its options",
        _SPAWN_POINTS: f"{len(points):,} places for cars to appear at",
        **{f"{_IMPORT}/{name}": _about(name) for name in names},
        _SCENE: "what is in the scene",
    }
    notes = [f"{len(points):,} places for cars; a scene of {_counted(len(tiles))} to import is in {_IMPORT}"]
    if len(tiles) > 1:
        notes.append(f"{len(tiles)} tiles are a large map for CARLA, which makes no walkers' navigation of these")
    sections = {
        "A map to import": _IMPORTING.format(folder=_IMPORT, name=request.name),
        "Walkers": walkers,
        **({"The scene": "\n".join(f"* {note[:1].upper()}{note[1:]}." for note in left_out)} if left_out else {}),
    }
    return Made(
        "Start a [CARLA](https://carla.org) server, 0.9.13 or later, and `pip install carla` of the same version.",
        f"python3 {FOLDER}/{_SCRIPT}",
        files,
        tuple(notes),
        sections,
    )


def _counted(tiles: int) -> str:
    return "one tile" if tiles == 1 else f"{tiles} tiles"


def _about(name: str) -> str:
    words = {".glb": "meshes", ".json": "description of the package", ".xodr": "the road network, for the importer"}
    return words.get(name[name.rfind(".") :], "where CARLA's first tile lies")


def _export(request: Request) -> tuple[list[str], list[str]]:
    """Write the scene as a package for CARLA's importer; return its files, and what is not in it."""
    west, south, east, north = plan_view_bounds(request.conversion.road_map.plan_view)
    fits = max(east - west, north - south) <= _ONE_TILE
    tile = request.tile if request.tile is not None else _WHOLE if fits else CARLA_TILE
    notes: list[str] = []
    target = request.folder / _IMPORT
    export_scene(
        request.xodr,
        target,
        dem=request.dems,
        dem_crs=request.dem_options["dem_crs"],
        dem_unit=request.dem_options["dem_unit"],
        dem_encoding=request.dem_options["dem_encoding"],
        osm=request.area,
        tile=tile,
        carla=request.name,
        say=notes.append,
    )
    # The importer takes every JSON file for a package.
    (target / _SCENE).rename(request.folder / _SCENE)
    return sorted(path.name for path in target.iterdir()), notes


def spawn_points(network: LaneNetwork) -> list[dict[str, float | int | str]]:
    """Return places on lanes outside of junctions, from the middle of all outwards, as CARLA has them.

    CARLA lays lanes at the height of the reference line, whatever the superelevation.
    """
    rows: list[dict[str, float | int | str]] = []
    places: list[FloatArray] = []
    for node in network.nodes[~network.in_junction[network.nodes]].tolist():
        low, high = network.section(node)
        if high - low < 2.0 * _FROM_ENDS:
            continue
        s = np.arange(low + _FROM_ENDS, high - _FROM_ENDS + 1e-6, _APART)
        where, hdg = network.middle(node, s)
        index = np.full(len(s), network.road[node])
        slope = np.degrees(np.arctan(grade(network.file, index, s))) * (-1.0 if node % 2 else 1.0)
        height = elevation(network.file, index, s) + _ABOVE
        road, lane = network.lane(node)
        for k in range(len(s)):
            rows.append(
                {
                    "x": round(float(where[k, 0]), 3),
                    "y": round(-float(where[k, 1]), 3),
                    "z": round(float(height[k]), 3),
                    "pitch": round(float(slope[k]), 2),
                    "yaw": round(-float(np.degrees(hdg[k])), 2),
                    "road": road,
                    "lane": lane,
                    "s": round(float(s[k]), 3),
                }
            )
            places.append(where[k, :2])
    if not rows:
        return []
    middle = np.median(places, axis=0)
    order = np.argsort(np.hypot(*(np.array(places) - middle).T), kind="stable")
    return [rows[k] for k in order.tolist()]
