"""The commands ``render``, ``report`` and ``surface``: pictures and pages of road networks and elevation models."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from osm2xodr import defaults
from osm2xodr.cli.options import (
    PATH,
    DemCommand,
    check_targets,
    declared_options,
    dem_option,
    file_argument,
    limit_options,
    output_option,
    overwrite_option,
    quiet_option,
)
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.python_api import PICTURE_FORMATS, RENDER_WIDTH_LEAST
from osm2xodr.reporting import details
from osm2xodr.surface import expand
from osm2xodr.system import Progress, label, shown, stream_to
from osm2xodr.viewing import PICTURE_COLOURS

# What share of the time each stage takes, s for a file of 200 MB.
_RENDER_PLAN = (("reading", 23.0), ("drawing", 20.0))

# What share of the time each stage takes, s for a file of 200 MB.
_REPORT_PLAN = (("reading", 23.0), ("checking the schema", 6.0), ("checking roads", 19.0), ("making the page", 10.0))


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

    with shown(Progress(sys.stderr, quiet=quiet, plan=_RENDER_PLAN)):
        written = run(file, output, **how)
    if not quiet:
        click.echo(f"osm2xodr: wrote {label(output)} ({written.size / 1e6:,.2f} MB)", err=True)


@click.command(
    cls=DemCommand,
    short_help="Make a page to explore a road network with.",
    epilog="""\b
Examples:
  osm2xodr report area.xodr -o report.html
  osm2xodr report area.xodr --osm area.osm --dem dem.tif --report-json area.json -o report.html

Exit status: 0 written, 1 cannot read or write, 2 wrong usage, 130 interrupted.""",
)
@file_argument
@output_option("HTML page")
@click.option("--osm", type=PATH, metavar="AREA", help="OpenStreetMap file to hold the roads against.")
@dem_option("Elevation models to hold the heights against")
@declared_options(("dem_crs", "dem_unit", "dem_encoding"))
@click.option(
    "--report-json",
    type=PATH,
    metavar="FILE",
    help="What convert --report-json wrote: all that was guessed, dropped and repaired.",
)
@click.option("--title", default="", metavar="TEXT", help="Headline.  [default: name of the road network]")
@click.option("--no-check", is_flag=True, help="Do not look for defects of FILE.")
@click.option(
    "--scene/--no-scene",
    default=None,
    help="Show in 3D the scene that export --scene makes: ground with --dem, buildings and water with --osm.  "
    "[default: up to 250 km of roads]",
)
@overwrite_option
@quiet_option
@limit_options
def report(file: Path, output: Path, no_check: bool, overwrite: bool, quiet: bool, **how: Any) -> None:
    """Show FILE, a road network in OpenDRIVE, as one page of HTML that needs no network.

    Map, 3D, profiles, heights against elevation models, coverage of OpenStreetMap, and findings of check.
    """
    how["dem"] = expand(how["dem"])
    inputs = [file, *how["dem"], *(path for path in (how["osm"], how["report_json"]) if path is not None)]
    check_targets([("-o", output)], inputs, overwrite=overwrite)
    from osm2xodr.python_api import report as run

    plan = [item for item in _REPORT_PLAN if not (no_check and item[0].startswith("checking"))]
    with shown(Progress(sys.stderr, quiet=quiet, plan=plan)):
        written = run(file, output, check=not no_check, **how)
    if not quiet:
        wrote = f"osm2xodr: wrote {label(output)} ({written.size / 1e6:,.1f} MB)"
        for line in (wrote, *details(written.diagnostics)):
            click.echo(line, err=True)


@click.command(
    short_help="Compare ways to find heights in elevation models.",
    epilog="""\b
Examples:
  osm2xodr surface dem.tif -o report.html
  osm2xodr surface fine.tif coarse.tif --bbox 11.55,49.97,11.62,50.00 -o report.html

Exit status: 0 written, 1 cannot compare, 2 wrong usage, 130 interrupted.""",
)
@click.argument("dem", nargs=-1, required=True, type=PATH)
@output_option("HTML page")
@click.option("--bbox", metavar="W,S,E,N", help="Look only there, degrees, WGS 84.  [default: all of each model]")
@declared_options(("dem_crs", "dem_unit", "dem_encoding"))
@overwrite_option
@quiet_option
@limit_options
def surface(
    dem: tuple[Path, ...], output: Path, bbox: str | None, overwrite: bool, quiet: bool, **known: str | None
) -> None:
    """Compare interpolations and polynomials on elevation models DEM, as one page with tables and pictures."""
    from osm2xodr.surface import compare_surfaces, expand
    from osm2xodr.viewing import surface_page

    dem = expand(dem)
    check_targets([("-o", output)], dem, overwrite=overwrite)
    box = None if bbox is None else _box(bbox)
    diagnostics = Diagnostics()
    page = surface_page(compare_surfaces(dem, box, diagnostics, **known))
    with stream_to(output) as stream:
        stream.write(page)
    if not quiet:
        for line in (f"osm2xodr: wrote {label(output)}", *details(diagnostics)):
            click.echo(line, err=True)


def _box(text: str) -> tuple[float, float, float, float]:
    """Read west, south, east, north."""
    try:
        west, south, east, north = (float(word) for word in text.split(","))
    except ValueError:
        raise click.UsageError(f"--bbox {text} is not 4 numbers; write west,south,east,north in degrees") from None
    return west, south, east, north
