"""The command ``export``: writes road networks for programs that show maps and scenes."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from osm2xodr.cli.options import (
    PATH,
    DemCommand,
    check_targets,
    declared_options,
    dem_option,
    file_argument,
    limit_options,
    overwrite_option,
    quiet_option,
)
from osm2xodr.defaults import SAMPLE_STEP, SAMPLE_TOLERANCE
from osm2xodr.python_api import (
    EXPORT_FORMATS,
    EXPORT_LAYERS,
    EXPORT_PROJECTORS,
    SCENE_FORMATS,
    export_format,
    materials_file,
    projector_file,
)
from osm2xodr.surface import expand
from osm2xodr.system import label

if TYPE_CHECKING:
    from osm2xodr.opendrive import OpenDrive

# Options of scenes, and those of single files: each is refused with the other.
_OF_SCENES: Final = ("dem", "dem_crs", "dem_unit", "dem_encoding", "osm", "tile", "carla")
_OF_FILES: Final = ("layers", "projector")


@click.command(
    cls=DemCommand,
    short_help="Write a road network as GeoJSON, GeoPackage, OBJ, glTF, Lanelet2 or a scene.",
    epilog="""\b
Examples:
  osm2xodr export area.xodr -o area.geojson
  osm2xodr export area.xodr -o area.gpkg
  osm2xodr export area.xodr -o lanes.geojson --layers lanes
  osm2xodr export area.xodr -o area.glb
  osm2xodr export area.xodr --bbox 7.415,43.730,7.425,43.738 -o part.geojson
  osm2xodr export area.xodr -o area.obj --up y
  osm2xodr export area.xodr --to lanelet2 -o map/lanelet2_map.osm --projector mgrs
  osm2xodr export area.xodr --scene scene --dem dem.tif --osm area.osm

GeoJSON is in WGS 84 with heights, for QGIS and web maps. GeoPackage has lanes, roads and signals in metres, with
units in the names of columns; it needs the extra "geo" (pip install 'osm2xodr[geo]'). OBJ and glTF hold the surface
of the lanes in metres, with one material per type of lane; z is up in OBJ unless --up says otherwise, y is always up
in glTF. OBJ comes with a file of materials of the same name and .mtl. Lanelet2 (.osm) is OSM XML with heights, as
Lanelet2's own library, Autoware and CommonRoad read it; --projector adds map_projector_info.yaml beside it for
Autoware.

--scene writes all there is to see into a folder, for Unreal, Blender and CARLA: roads without overlap, marks, kerbs,
crosswalks, signs and lights, bridges, tunnels and the ground, in tiles; docs/scene.md says more.

Exit status: 0 written, 1 cannot export, 2 wrong usage, 130 interrupted.""",
)
@file_argument
@click.option("-o", "--output", type=PATH, metavar="FILE", help="File to write; - for standard output.")
@click.option("--scene", type=PATH, metavar="DIR", help="Write a scene into this folder instead.")
@click.option(
    "--format",
    "--to",
    "format",
    type=click.Choice(EXPORT_FORMATS),
    help="What to write.  [default: by the file's name]",
)
@click.option("--bbox", metavar="W,S,E,N", help="Write only this part, as crop cuts it: degrees, WGS 84.")
@click.option("--layers", metavar="LIST", help=f"What GeoJSON has, of {','.join(EXPORT_LAYERS)}.  [default: all]")
@click.option("--up", type=click.Choice(("z", "y")), help="Axis that points up in OBJ.  [default: z]")
@click.option(
    "--projector",
    type=click.Choice(EXPORT_PROJECTORS),
    help="Coordinates of Lanelet2 that Autoware reads: those of FILE, or MGRS.  [default: local, without its file]",
)
@dem_option("Elevation models for the ground of a scene")
@declared_options(("dem_crs", "dem_unit", "dem_encoding"))
@click.option("--osm", type=PATH, metavar="AREA", help="OpenStreetMap file whose buildings and water a scene has.")
@click.option("--tile", type=float, metavar="M", help="Width of a scene's tiles.  [default: 500; 2000 for CARLA]")
@click.option("--carla", metavar="NAME", help="Name tiles as CARLA's importer wants those of the large map NAME.")
@click.option(
    "--tolerance",
    type=click.FloatRange(min=0.001),
    default=SAMPLE_TOLERANCE,
    show_default=True,
    metavar="M",
    help="How far straight pieces may lie from curves.",
)
@click.option(
    "--step",
    type=click.FloatRange(min=0.1),
    default=SAMPLE_STEP,
    show_default=True,
    metavar="M",
    help="Longest straight piece.",
)
@overwrite_option
@quiet_option
@limit_options
def export(file: Path, output: Path | None, scene: Path | None, overwrite: bool, quiet: bool, **how: Any) -> None:
    """Write the roads of the OpenDRIVE FILE for programs that show maps (GeoJSON), scenes (OBJ, glTF), or drive.

    Give -o or --scene.
    """
    if (output is None) == (scene is None):
        raise click.UsageError("give one of -o and --scene")
    unused = _OF_FILES if output is None else _OF_SCENES
    for name in unused:
        if how.pop(name):
            where = "files" if output is None else "scenes"
            raise click.UsageError(f"--{name.replace('_', '-')} is for {where} alone; leave it out")
    bbox = how.pop("bbox")
    if output is not None:
        notes = _file(file, bbox, output, overwrite, how)
    else:
        assert scene is not None
        notes = _scene(file, bbox, scene, overwrite, how)
    if not quiet:
        for line in notes:
            click.echo(f"osm2xodr: {line}", err=True)


@contextlib.contextmanager
def _part(file: Path, bbox: str | None, notes: list[str]) -> Iterator[OpenDrive]:
    """Read a file, or a part of it; what was cut off is said."""
    from osm2xodr.opendrive import caveats, read_xodr
    from osm2xodr.python_api import crop

    if bbox is None:
        network = read_xodr(file)
        notes += caveats(network)
        yield network
        return
    with tempfile.TemporaryDirectory(prefix="osm2xodr-") as folder:
        yield read_xodr(crop(file, Path(folder) / file.name, bbox=bbox, say=notes.append))


def _file(file: Path, bbox: str | None, output: Path, overwrite: bool, how: dict[str, Any]) -> list[str]:
    """Write one file and what comes with it, and return what to say."""
    form = export_format(output, how["format"])
    library, info = materials_file(output, form), projector_file(output, form, how["projector"])
    targets = [("-o", output), *([("the file of materials", library)] if library else [])]
    targets += [("the file of the projector", info)] if info else []
    check_targets(targets, [file], overwrite=overwrite)
    from osm2xodr.python_api import export as run

    notes: list[str] = []
    with _part(file, bbox, notes) as network:
        files = run(network, output, say=notes.append, **how)
    return [*notes, f"wrote {' and '.join(map(label, files))}"]


def _scene(file: Path, bbox: str | None, scene: Path, overwrite: bool, how: dict[str, Any]) -> list[str]:
    """Write a scene, and return what to say."""
    form = how.pop("format") or SCENE_FORMATS[0]
    if form not in SCENE_FORMATS:
        raise click.UsageError(f"--format {form} is for files alone; scenes are {' or '.join(SCENE_FORMATS)}")
    if scene.is_dir() and any(scene.iterdir()) and not overwrite:
        raise click.UsageError(f"{scene} exists; give another folder, or --overwrite to replace it")
    how["dem"] = expand(how["dem"])
    from osm2xodr.python_api import export_scene

    notes: list[str] = []
    how["carla"] = how["carla"] or ""
    with _part(file, bbox, notes) as network:
        files = export_scene(network, scene, say=notes.append, format=form, **how)
    size = sum(path.stat().st_size for path in files) / 1e6
    return [*notes, f"wrote {scene} ({len(files):,} files, {size:,.1f} MB)"]
