"""The function ``export``. It loads what it needs when it is called."""

from __future__ import annotations

import contextlib
import unicodedata
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Final

from osm2xodr import __version__
from osm2xodr.defaults import SAMPLE_STEP, SAMPLE_TOLERANCE
from osm2xodr.errors import OptionError, Osm2xodrError
from osm2xodr.python_api.files import AnyPath, check_sampling, choose, drive_of, names_of
from osm2xodr.system import STANDARD_OUTPUT, stream_to

if TYPE_CHECKING:
    from osm2xodr.opendrive import HasTables, OpenDrive

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
