"""The function ``export_scene``. It loads what it needs when it is called."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Final

from osm2xodr import __version__
from osm2xodr.defaults import SAMPLE_STEP, SAMPLE_TOLERANCE
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError, OptionError
from osm2xodr.python_api.files import AnyPath, check_sampling, choose, drive_of
from osm2xodr.python_api.options import paths
from osm2xodr.surface import expand

if TYPE_CHECKING:
    from osm2xodr.model import FloatArray, Surroundings
    from osm2xodr.opendrive import Frame, HasTables, OpenDrive
    from osm2xodr.surface import DemSurface, SurfaceOptions

SCENE_FORMATS: Final = ("glb", "obj")
# Width of tiles, m: 500 m as engines stream them, and 2 km, the largest and usual of CARLA's large maps
# (documentation of CARLA 0.9.16). The borders of tiles are corners of the ground, whose squares measure up to 20 m.
SCENE_TILE: Final = 500.0
CARLA_TILE: Final = 2000.0
_TILE_GRID: Final = 20.0


def export_scene(
    file: AnyPath | HasTables,
    folder: AnyPath,
    *,
    dem: AnyPath | Iterable[AnyPath] = (),
    dem_crs: str | None = None,
    dem_unit: str | None = None,
    dem_encoding: str | None = None,
    osm: AnyPath | None = None,
    format: str = SCENE_FORMATS[0],
    up: str | None = None,
    tile: float | None = None,
    carla: str = "",
    say: Callable[[str], None] | None = None,
    tolerance: float = SAMPLE_TOLERANCE,
    step: float = SAMPLE_STEP,
) -> tuple[Path, ...]:
    """Write an OpenDRIVE file as a scene of meshes: roads, marks, signs, bridges, tunnels and the ground.

    Parameters
    ----------
    file
        The file, or a road network.
    folder
        Folder to write: one tile per file, and ``scene.json``. Of a scene that is there the files that its
        ``scene.json`` lists are replaced; all others stay.
    dem
        Elevation model, or several of them, for the ground; patterns and folders as in `convert`. Without any the
        ground is a strip beside the roads.
    dem_crs, dem_unit
        CRS and unit of heights of those that do not say theirs, such as ``EPSG:25832`` and ``ft``.
    dem_encoding
        How those that are pictures code heights as colours: ``terrarium`` or ``mapbox``.
    osm
        OpenStreetMap file whose buildings and water the scene has.
    format
        ``glb`` or ``obj``.
    up
        Axis that points up in OBJ, ``z`` or ``y``; by default z.
    tile
        Width of tiles, m, a multiple of 20; by default 500, and 2000 for CARLA.
    carla
        Name of the map in CARLA: tiles have the names of its large maps and its importer's JSON.
    say
        Is called with each sentence about what the scene has not.
    tolerance
        How far straight pieces may lie from curves, m.
    step
        Longest straight piece, m.

    Returns
    -------
    tuple of Path
        The files.

    Raises
    ------
    OptionError
        An option has a value that cannot be.
    InputError
        The file or an elevation model cannot be read, or no lane has a surface.
    CoverageError
        No elevation model has heights at the roads.
    OutputError
        The folder cannot be written.
    """
    form, size = _checked(format, up, tile, carla)
    check_sampling(tolerance, step)
    from osm2xodr.exporting import MANIFEST, SceneFormat, make_scene, write_scene
    from osm2xodr.surface import SurfaceOptions
    from osm2xodr.system import atomic_folder, check_folder

    target = Path(folder)
    models = expand(paths(dem))
    inputs = [
        Path(file) if isinstance(file, (str, os.PathLike)) else file.tables.path,
        *models,
        *([] if osm is None else [Path(osm)]),
    ]
    check_folder(target, MANIFEST, inputs)
    drive = drive_of(file)
    diagnostics = Diagnostics()
    known = SurfaceOptions(dem_crs=dem_crs, dem_unit=dem_unit, dem_encoding=dem_encoding)
    ground = _ground(drive, models, known, diagnostics)
    scene = make_scene(drive, tolerance, step, None if ground is None else ground[0], _surroundings(drive, osm), size)
    attributions = [
        value for (road, code), value in drive.provenance.items() if road == -1 and "attribution" in code.lower()
    ]
    attributions += [] if ground is None else [item.attribution for item in ground[1].dems]
    credits = list(dict.fromkeys(value.strip() for value in attributions if value.strip()))
    with atomic_folder(target, MANIFEST, inputs) as place:
        layout = SceneFormat(form, size, up == "y", carla)
        names = write_scene(scene, drive, place, layout, f"osm2xodr {__version__}", credits)
    if say is not None:
        for note in scene.notes:
            say(note)
    return tuple(target / name for name in names)


def _checked(format: str, up: str | None, tile: float | None, carla: str) -> tuple[str, float]:
    """Return format and width of tiles, m; `OptionError` if an option has a value that cannot be."""
    choose("format", format, SCENE_FORMATS)
    if up is not None:
        choose("up", up, ("z", "y"))
        if format != "obj":
            raise OptionError("up is for obj alone; leave it out", "up")
    if carla and not re.fullmatch(r"\w+", carla, re.ASCII):
        raise OptionError(f"carla: {carla!r} is no name; use letters, digits and underscores", "carla")
    size = tile if tile is not None else CARLA_TILE if carla else SCENE_TILE
    if not (_TILE_GRID <= size < 1e6 and size % _TILE_GRID == 0.0):
        raise OptionError(f"tile: {size:g} m is not a multiple of {_TILE_GRID:g} m", "tile")
    return format, size


def _ground(
    file: OpenDrive, models: tuple[Path, ...], options: SurfaceOptions, diagnostics: Diagnostics
) -> tuple[Callable[[FloatArray, FloatArray], FloatArray], DemSurface] | None:
    """Return what gives the height of the ground at inertial places, and the elevation models; None without any."""
    if not models:
        return None
    import numpy as np

    from osm2xodr.exporting import places_around, read_heights
    from osm2xodr.opendrive import sample_roads

    frame = _frame(file, "leave the elevation models out")
    stations = sample_roads(file)
    if not (np.isfinite(stations.x) & np.isfinite(stations.y)).any():
        raise InputError(f"{file.path} has no road with a place; osm2xodr check lists what is wrong with it")
    return read_heights(models, frame, *places_around(stations.x, stations.y), options, diagnostics)


def _surroundings(file: OpenDrive, osm: AnyPath | None) -> tuple[Surroundings, Frame] | None:
    """Return what an OpenStreetMap file has beside roads and the frame of the roads; None without a file."""
    if osm is None:
        return None
    from osm2xodr.osmParsing import read_surroundings

    frame = _frame(file, "leave the OpenStreetMap file out")
    return read_surroundings(Path(osm)), frame


def _frame(file: OpenDrive, remedy: str) -> Frame:
    """Return where a file lies on Earth; `InputError` with what to do if it does not say."""
    from osm2xodr.opendrive import frame_of

    frame, why = frame_of(file.header)
    if frame is None:
        raise InputError(f"{file.path}: {why}; {remedy}")
    return frame
