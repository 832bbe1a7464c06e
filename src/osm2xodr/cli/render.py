"""The command ``render``: draws a road network."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from osm2xodr import defaults
from osm2xodr.cli.options import (
    check_targets,
    file_argument,
    limit_options,
    output_option,
    overwrite_option,
    quiet_option,
)
from osm2xodr.python_api import PICTURE_FORMATS, RENDER_WIDTH_LEAST
from osm2xodr.system import Progress, label, shown
from osm2xodr.viewing import PICTURE_COLOURS

# What share of the time each stage takes, s for a file of 200 MB.
_PLAN = (("reading", 23.0), ("drawing", 20.0))


@click.command(
    short_help="Draw a road network.",
    epilog="""\b
Examples:
  osm2xodr render area.xodr -o area.svg
  osm2xodr render area.xodr --color grade --bbox 7.415,43.730,7.425,43.738 -o grades.png
  osm2xodr render area.xodr --bbox-xy -200,-150,200,150 --width 800 --format png -o - > middle.png

Exit status: 0 written, 1 cannot draw, 2 wrong usage, 130 interrupted.""",
)
@file_argument
@output_option("SVG or PNG picture")
@click.option(
    "--format", type=click.Choice(PICTURE_FORMATS), help="Kind of picture.  [default: by the name of the file]"
)
@click.option("--bbox", metavar="W,S,E,N", help="Draw only this: degrees, WGS 84.  [default: everything]")
@click.option("--bbox-xy", metavar="W,S,E,N", help="Likewise: metres, x and y of FILE.")
@click.option(
    "--width",
    type=click.IntRange(RENDER_WIDTH_LEAST, defaults.RENDER_WIDTH_MOST),
    default=defaults.RENDER_WIDTH,
    show_default=True,
    metavar="PIXELS",
    help="Width of the picture.",
)
@click.option(
    "--color",
    type=click.Choice(PICTURE_COLOURS),
    default=PICTURE_COLOURS[0],
    show_default=True,
    help="What roads are coloured by: type of lane, height, grade or speed limit.",
)
@overwrite_option
@quiet_option
@limit_options
def render(file: Path, output: Path, overwrite: bool, quiet: bool, **how: Any) -> None:
    """Draw FILE, a road network in OpenDRIVE, from above, with a legend and a scale."""
    check_targets([("-o", output)], [file], overwrite=overwrite)
    from osm2xodr.python_api import render as run

    with shown(Progress(sys.stderr, quiet=quiet, plan=_PLAN)):
        written = run(file, output, **how)
    if not quiet:
        click.echo(f"osm2xodr: wrote {label(output)} ({written.size / 1e6:,.2f} MB)", err=True)
