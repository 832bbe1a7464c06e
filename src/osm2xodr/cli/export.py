"""The command ``export``: writes road networks for programs that show maps and scenes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from osm2xodr.cli.options import (
    check_targets,
    file_argument,
    limit_options,
    output_option,
    overwrite_option,
    quiet_option,
)
from osm2xodr.defaults import SAMPLE_STEP, SAMPLE_TOLERANCE
from osm2xodr.library import (
    EXPORT_FORMATS,
    EXPORT_LAYERS,
    EXPORT_PROJECTORS,
    export_format,
    materials_file,
    projector_file,
)
from osm2xodr.system import label


@click.command(
    short_help="Write a road network as GeoJSON, OBJ, glTF or Lanelet2.",
    epilog="""\b
Examples:
  osm2xodr export area.xodr -o area.geojson
  osm2xodr export area.xodr -o lanes.geojson --layers lanes
  osm2xodr export area.xodr -o area.glb
  osm2xodr export area.xodr -o area.obj --up y
  osm2xodr export area.xodr --to lanelet2 -o map/lanelet2_map.osm --projector mgrs

GeoJSON is in WGS 84 with heights, for QGIS and web maps. OBJ and glTF hold the surface of the lanes in metres, with
one material per type of lane; z is up in OBJ unless --up says otherwise, y is always up in glTF. OBJ comes with a
file of materials of the same name and .mtl. Lanelet2 (.osm) is OSM XML with heights, as Lanelet2's own library,
Autoware and CommonRoad read it; --projector adds map_projector_info.yaml beside it for Autoware.

Exit status: 0 written, 1 cannot export, 2 wrong usage, 130 interrupted.""",
)
@file_argument
@output_option("File")
@click.option(
    "--format",
    "--to",
    "format",
    type=click.Choice(EXPORT_FORMATS),
    help="What to write.  [default: by the file's name]",
)
@click.option("--layers", metavar="LIST", help=f"What GeoJSON has, of {','.join(EXPORT_LAYERS)}.  [default: all]")
@click.option("--up", type=click.Choice(("z", "y")), help="Axis that points up in OBJ.  [default: z]")
@click.option(
    "--projector",
    type=click.Choice(EXPORT_PROJECTORS),
    help="Coordinates of Lanelet2 that Autoware reads: those of FILE, or MGRS.  [default: local, without its file]",
)
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
def export(file: Path, output: Path, overwrite: bool, quiet: bool, **how: Any) -> None:
    """Write the roads of the OpenDRIVE FILE for programs that show maps (GeoJSON), scenes (OBJ, glTF), or drive."""
    form = export_format(output, how["format"])
    library, info = materials_file(output, form), projector_file(output, form, how["projector"])
    targets = [("-o", output), *([("the file of materials", library)] if library else [])]
    targets += [("the file of the projector", info)] if info else []
    check_targets(targets, [file], overwrite=overwrite)
    from osm2xodr.library import export as run, read
    from osm2xodr.opendrive import caveats

    network = read(file)
    lost: list[str] = []
    files = run(network, output, say=lost.append, **how)
    if not quiet:
        for line in (*caveats(network), *lost, f"wrote {' and '.join(map(label, files))}"):
            click.echo(f"osm2xodr: {line}", err=True)
