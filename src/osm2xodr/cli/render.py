"""The command ``render``: a picture of a road network."""

from __future__ import annotations

from pathlib import Path

import click

from osm2xodr import defaults
from osm2xodr.cli.options import check_targets, limit_options, output_option, overwrite_option
from osm2xodr.system import STANDARD_OUTPUT, label
from osm2xodr.viewing import PICTURE_COLOURS, PictureOptions

KINDS = ("svg", "png")


@click.command(
    short_help="Draw a road network.",
    epilog="""\b
Examples:
  osm2xodr render area.xodr -o area.svg
  osm2xodr render area.xodr --color grade --bbox 7.415,43.730,7.425,43.738 -o grades.png
  osm2xodr render area.xodr --bbox-xy -200,-150,200,150 --width 800 --format png -o - > middle.png

Exit status: 0 written, 1 cannot draw, 2 wrong usage.""",
)
@click.argument("file", type=click.Path(path_type=Path))
@output_option("SVG or PNG picture")
@click.option(
    "--format", "kind", type=click.Choice(KINDS), help="Kind of picture.  [default: by the name of the file]"
)
@click.option("--bbox", metavar="W,S,E,N", help="Draw only this: degrees, WGS 84.  [default: everything]")
@click.option("--bbox-xy", metavar="W,S,E,N", help="Likewise: metres, x and y of FILE.")
@click.option(
    "--width",
    type=click.IntRange(200, defaults.RENDER_WIDTH_MOST),
    default=defaults.RENDER_WIDTH,
    show_default=True,
    metavar="PIXELS",
    help="Width of the picture.",
)
@click.option(
    "--color",
    "colour",
    type=click.Choice(PICTURE_COLOURS),
    default=PICTURE_COLOURS[0],
    show_default=True,
    help="What roads are coloured by: type of lane, height, grade or speed limit.",
)
@overwrite_option
@click.option("-q", "--quiet", is_flag=True, help="Say nothing but errors.")
@limit_options
def render(
    file: Path,
    output: Path,
    kind: str | None,
    bbox: str | None,
    bbox_xy: str | None,
    width: int,
    colour: str,
    overwrite: bool,
    quiet: bool,
) -> None:
    """Draw FILE, a road network in OpenDRIVE, from above, with a legend and a scale."""
    if bbox is not None and bbox_xy is not None:
        raise click.UsageError("--bbox and --bbox-xy exclude each other; give one of them")
    check_targets([("-o", output)], [file], overwrite=overwrite)
    kind = kind or _kind(output)
    degrees = None if bbox is None else _box("--bbox", bbox, "degrees")
    metres = None if bbox_xy is None else _box("--bbox-xy", bbox_xy, "metres")
    from osm2xodr.opendrive import read_xodr
    from osm2xodr.viewing import box_of_degrees, write_picture

    drive = read_xodr(file)
    if degrees is not None:
        metres = box_of_degrees(drive, degrees)
    size = write_picture(drive, output, PictureOptions(metres, width, colour), kind)
    if not quiet:
        click.echo(f"osm2xodr: wrote {label(output)} ({size / 1e6:,.2f} MB)", err=True)


def _kind(output: Path) -> str:
    """Tell the kind of picture from the name of its file."""
    kind = output.suffix.lower().removeprefix(".")
    if kind in KINDS:
        return kind
    if output == STANDARD_OUTPUT:
        raise click.UsageError("-o - has no name that tells the kind of picture; give --format svg or --format png")
    raise click.UsageError(f"-o {output} is neither .svg nor .png; name it so, or give --format")


def _box(option: str, text: str, unit: str) -> tuple[float, float, float, float]:
    """Read west, south, east, north."""
    try:
        west, south, east, north = (float(word) for word in text.split(","))
    except ValueError:
        raise click.UsageError(f"{option} {text} is not 4 numbers; write west,south,east,north in {unit}") from None
    if not (west < east and south < north):
        raise click.UsageError(f"{option} {text} is empty; write west,south,east,north in {unit}")
    return west, south, east, north
