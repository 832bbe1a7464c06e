"""The command ``report``: makes a page to explore a road network with."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

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
from osm2xodr.reporting import details
from osm2xodr.surface import expand
from osm2xodr.system import Progress, label, shown

# What share of the time each stage takes, s for a file of 200 MB.
_PLAN = (("reading", 23.0), ("checking the schema", 6.0), ("checking roads", 19.0), ("making the page", 10.0))


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

    plan = [item for item in _PLAN if not (no_check and item[0].startswith("checking"))]
    with shown(Progress(sys.stderr, quiet=quiet, plan=plan)):
        written = run(file, output, check=not no_check, **how)
    if not quiet:
        wrote = f"osm2xodr: wrote {label(output)} ({written.size / 1e6:,.1f} MB)"
        for line in (wrote, *details(written.diagnostics)):
            click.echo(line, err=True)
