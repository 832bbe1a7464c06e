"""The command ``surface``: compares ways to find heights in elevation models."""

from __future__ import annotations

from pathlib import Path

import click

from osm2xodr.cli.options import (
    PATH,
    check_targets,
    declared_options,
    limit_options,
    output_option,
    overwrite_option,
    quiet_option,
)
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.reporting import details
from osm2xodr.system import label, stream_to


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
