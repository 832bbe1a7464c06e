"""The functions ``export`` and ``export_scene``. They load what they need when they are called."""

from __future__ import annotations

import contextlib
import os
import re
import unicodedata
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Final

from osm2xodr import __version__
from osm2xodr.defaults import SAMPLE_STEP, SAMPLE_TOLERANCE
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError, OptionError, Osm2xodrError
from osm2xodr.python_api.files import AnyPath, check_sampling, choose, drive_of, names_of
from osm2xodr.python_api.options import paths
from osm2xodr.surface import expand
from osm2xodr.system import STANDARD_OUTPUT, stream_to

if TYPE_CHECKING:
    from osm2xodr.model import FloatArray, Surroundings
    from osm2xodr.opendrive import Frame, HasTables, OpenDrive
    from osm2xodr.surface import DemSurface, SurfaceOptions


EXPORT_FORMATS: Final = ("geojson", "geopackage", "obj", "glb", "lanelet2")
# `osm2xodr.exporting.LAYERS`, which is too slow to load for --help; a test holds them equal.
EXPORT_LAYERS: Final = ("roads", "lanes", "junctions", "signals", "objects")
_EXPORT_SUFFIXES: Final = {
    ".geojson": "geojson",
    ".json": "geojson",
    ".gpkg": "geopackage",
    ".obj": "obj",
    ".glb": "glb",
    ".osm": "lanelet2",
}
# `osm2xodr.exporting.PROJECTORS`, likewise.
EXPORT_PROJECTORS: Final = ("local", "mgrs")
# What Autoware looks for beside a map.
_PROJECTOR_INFO: Final = "map_projector_info.yaml"

SCENE_FORMATS: Final = ("glb", "obj")
# Width of tiles, m: 500 m as engines stream them, and 2 km, the largest and usual of CARLA's large maps
# (documentation of CARLA 0.9.16). The borders of tiles are corners of the ground, whose squares measure up to 20 m.
SCENE_TILE: Final = 500.0
CARLA_TILE: Final = 2000.0
_TILE_GRID: Final = 20.0


def export(
    file: AnyPath | HasTables,
    output: AnyPath,
    *,
    format: str | None = None,
    layers: str | Iterable[str] | None = None,
    up: str | None = None,
    projector: str | None = None,
    say: Callable[[str], None] | None = None,
    tolerance: float = SAMPLE_TOLERANCE,
    step: float = SAMPLE_STEP,
) -> tuple[Path, ...]:
    """Write the roads of an OpenDRIVE file for programs that show maps and scenes, or drive.

    Parameters
    ----------
    file
        The file, or a road network.
    output
        File to write; ``-`` is standard output. One that exists is replaced.
    format
        ``geojson``, ``geopackage``, ``obj``, ``glb`` or ``lanelet2`` (OSM XML); by default what the name of `output`
        ends in. GeoPackage has lanes, roads and signals as layers, in the projection of the file.
    layers
        What GeoJSON has: ``roads``, ``lanes``, ``junctions``, ``signals``, ``objects``. By default all of them.
    up
        Axis that points up in OBJ, ``z`` or ``y``; by default z.
    projector
        Coordinates that Autoware reads from Lanelet2, ``local`` (those of the file) or ``mgrs``, with the file beside
        the map that says so; by default ``local`` without that file.
    say
        Is called with each sentence about what the format cannot carry.
    tolerance
        How far straight pieces may lie from curves, m.
    step
        Longest straight piece, m.

    Returns
    -------
    tuple of Path
        The files: OBJ comes with one of materials, of the same name with the ending .mtl, Lanelet2 with
        ``map_projector_info.yaml`` if `projector` is given.

    Raises
    ------
    OptionError
        An option has a value that cannot be, or that the format has no use for.
    InputError
        The file cannot be read, or does not say where it is on Earth, or has no lane with a surface.
    Osm2xodrError
        GeoPackage needs a library that is not installed.
    OutputError
        A file cannot be written.
    """
    target = Path(output)
    form = export_format(target, format)
    chosen = _options(form, layers, up, projector)
    check_sampling(tolerance, step)
    from osm2xodr import exporting

    drive = drive_of(file)
    if form == "geojson":
        with stream_to(target) as stream:
            exporting.write_geojson(drive, stream, tolerance, step, chosen)
        return (target,)
    if form == "geopackage":
        with needs("geopandas"):
            from osm2xodr.exporting import write_geopackage
        with stream_to(target) as stream:
            write_geopackage(drive, stream, tolerance, step)
        return (target,)
    if form == "lanelet2":
        return _lanelet2(drive, target, (tolerance, step), projector, say)
    mesh = exporting.road_mesh(drive, tolerance, step)
    materials = materials_file(target, form)
    with stream_to(target) as stream:
        if form == "glb":
            exporting.write_glb(mesh, drive.header, stream, __version__)
        else:
            exporting.write_obj(mesh, stream, materials.name if materials else None, y_up=up == "y")
            if materials is not None:
                with stream_to(materials) as colours:
                    colours.write(exporting.material_library(mesh))
    return (target,) if materials is None else (target, materials)


@contextlib.contextmanager
def needs(library: str) -> Iterator[None]:
    """Say what to do where an optional library, which is loaded inside, is not installed."""
    try:
        yield
    except ModuleNotFoundError as error:
        if (error.name or "").startswith("osm2xodr"):
            raise
        raise Osm2xodrError(f"this needs {library}; install it: pip install 'osm2xodr[geo]'") from error


def _options(form: str, layers: str | Iterable[str] | None, up: str | None, projector: str | None) -> tuple[str, ...]:
    """Check the options that only some formats have, and return the layers in the order in which they are written."""
    for option, value, needed in (
        ("layers", layers, "geojson"),
        ("up", up, "obj"),
        ("projector", projector, "lanelet2"),
    ):
        if value is not None and form != needed:
            raise OptionError(f"{option} is for {needed} alone; leave it out", option)
    names = EXPORT_LAYERS if layers is None else names_of(layers)
    for name in names:
        if name not in EXPORT_LAYERS:
            raise OptionError(f"layers has no {name!r}; choose from {','.join(EXPORT_LAYERS)}", "layers")
    if up is not None:
        choose("up", up, ("z", "y"))
    if projector is not None:
        choose("projector", projector, EXPORT_PROJECTORS)
    return tuple(name for name in EXPORT_LAYERS if name in names)


def _lanelet2(
    drive: OpenDrive,
    target: Path,
    sampling: tuple[float, float],
    projector: str | None,
    say: Callable[[str], None] | None,
) -> tuple[Path, ...]:
    """Write a map of Lanelet2 and the file that says how it is projected; see `export`."""
    from osm2xodr import exporting

    info = projector_file(target, "lanelet2", projector)
    with stream_to(target) as stream:
        square, notes = exporting.write_lanelet2(drive, stream, *sampling, __version__, projector or "local")
        if info is not None and projector is not None:
            with stream_to(info) as text:
                text.write(exporting.projector_info(projector, square).encode())
    if say is not None:
        for note in notes:
            say(note)
    return (target,) if info is None else (target, info)


def export_format(output: Path, given: str | None) -> str:
    """Return the format of an export: the one that was given, or that its file is named after."""
    if given is not None:
        return choose("format", given, EXPORT_FORMATS)
    form = _EXPORT_SUFFIXES.get(output.suffix.lower())
    if form is None:
        raise OptionError(
            f"format: {output} does not tell it; end the name in .geojson, .gpkg, .obj, .glb or .osm, or give"
            " this option",
            "format",
        )
    return form


def materials_file(output: Path, form: str) -> Path | None:
    """Return the file of materials that comes with an export; None where there is none.

    `OptionError` says that OBJ, which ends names with the line, cannot name it.
    """
    if form != "obj" or output == STANDARD_OUTPUT:
        return None
    found = output.with_suffix(".mtl")
    if any(unicodedata.category(letter) == "Cc" for letter in found.name):
        raise OptionError(f"output {found.name!r} has a control character, which OBJ cannot name; choose another")
    return found


def projector_file(output: Path, form: str, projector: str | None) -> Path | None:
    """Return the file that tells Autoware the projection of an export; None where there is none."""
    if form != "lanelet2" or projector is None or output == STANDARD_OUTPUT:
        return None
    return output.with_name(_PROJECTOR_INFO)


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
