"""The command ``export``: road networks for programs that show maps and scenes."""

from __future__ import annotations

from pathlib import Path

import click

from osm2xodr import __version__
from osm2xodr.cli.options import check_targets, limit_options, output_option, overwrite_option
from osm2xodr.defaults import SAMPLE_STEP, SAMPLE_TOLERANCE
from osm2xodr.system import STANDARD_OUTPUT, label, stream_to

FORMATS = ("geojson", "obj", "glb")
# `osm2xodr.exporting.LAYERS`, which is too slow to load for --help; a test holds them equal.
LAYERS = ("roads", "lanes", "junctions", "signals", "objects")
_SUFFIXES = {".geojson": "geojson", ".json": "geojson", ".obj": "obj", ".glb": "glb"}


@click.command(
    short_help="Write a road network as GeoJSON, OBJ or glTF.",
    epilog="""\b
Examples:
  osm2xodr export area.xodr -o area.geojson
  osm2xodr export area.xodr -o lanes.geojson --layers lanes
  osm2xodr export area.xodr -o area.glb
  osm2xodr export area.xodr -o area.obj --up y

GeoJSON is in WGS 84 with heights, for QGIS and web maps. OBJ and glTF hold the surface of the lanes in metres, with
one material per type of lane; z is up in OBJ unless --up says otherwise, y is always up in glTF. OBJ comes with a
file of materials of the same name and .mtl.

Exit status: 0 written, 1 cannot export, 2 wrong usage.""",
)
@click.argument("file", type=click.Path(path_type=Path))
@output_option("File")
@click.option("--format", "form", type=click.Choice(FORMATS), help="What to write.  [default: by the file's name]")
@click.option("--layers", metavar="LIST", help=f"What GeoJSON has, of {','.join(LAYERS)}.  [default: all]")
@click.option("--up", type=click.Choice(("z", "y")), help="Axis that points up in OBJ.  [default: z]")
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
@click.option("-q", "--quiet", is_flag=True, help="Say nothing but errors.")
@limit_options
def export(
    file: Path,
    output: Path,
    form: str | None,
    layers: str | None,
    up: str | None,
    tolerance: float,
    step: float,
    overwrite: bool,
    quiet: bool,
) -> None:
    """Write the roads of the OpenDRIVE FILE for programs that show maps (GeoJSON) and scenes (OBJ, glTF)."""
    form = form or _form_of(output)
    chosen = _layers(layers)
    for option, value, needed in (("--layers", layers, "geojson"), ("--up", up, "obj")):
        if value is not None and form != needed:
            raise click.UsageError(f"{option} is for {needed} alone; leave it out")
    library = output.with_suffix(".mtl") if form == "obj" and output != STANDARD_OUTPUT else None
    targets = [("-o", output), *([("the file of materials", library)] if library else [])]
    check_targets(targets, [file], overwrite=overwrite)
    from osm2xodr import exporting
    from osm2xodr.opendrive import caveats, read_xodr

    network = read_xodr(file)
    if form == "geojson":
        with stream_to(output) as stream:
            exporting.write_geojson(network, stream, tolerance, step, chosen)
    else:
        mesh = exporting.road_mesh(network, tolerance, step)
        with stream_to(output) as stream:
            if form == "glb":
                exporting.write_glb(mesh, network.header, stream, __version__)
            else:
                exporting.write_obj(mesh, stream, library.name if library else None, y_up=up == "y")
                if library is not None:
                    with stream_to(library) as materials:
                        materials.write(exporting.material_library(mesh))
    if not quiet:
        told = label(output) + (f" and {library}" if library else "")
        for line in (*caveats(network), f"wrote {told}"):
            click.echo(f"osm2xodr: {line}", err=True)


def _form_of(output: Path) -> str:
    """Return the format that a file's name asks for."""
    form = _SUFFIXES.get(output.suffix.lower())
    if form is None:
        raise click.UsageError(f"{output} does not tell what to write; end it in .geojson, .obj or .glb, or --format")
    return form


def _layers(text: str | None) -> tuple[str, ...]:
    """Read a list of layers."""
    if text is None:
        return LAYERS
    words = [word.strip() for word in text.split(",")]
    wrong = [word for word in words if word not in LAYERS]
    if wrong:
        raise click.UsageError(f"--layers has no {wrong[0]!r}; choose from {','.join(LAYERS)}")
    return tuple(word for word in LAYERS if word in words)
