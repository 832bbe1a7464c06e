"""The command ``start``: makes a folder that a simulator runs, and says with which command."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import click

from osm2xodr.cli.convert import report_conversion, sum_up
from osm2xodr.cli.options import (
    PATH,
    DemCommand,
    Session,
    declared_options,
    dem_option,
    given_options,
    limit_options,
    overwrite_option,
    quiet_option,
)
from osm2xodr.python_api import DECLARATIONS
from osm2xodr.starting import NOT_CHOSEN, SIMULATORS
from osm2xodr.surface import expand
from osm2xodr.system import Progress, shown, stage

# What share of the time each stage takes, s for a town of 60,000 people.
_PLAN = (
    ("starting", 0.3),
    ("cutting", 1.0),
    ("reading", 0.8),
    ("reading the elevation model", 0.5),
    ("building roads", 2.5),
    ("placing", 0.5),
    ("writing", 0.3),
    ("making", 3.0),
)


@click.command(
    cls=DemCommand,
    short_help="Make a folder that CARLA, SUMO, esmini or Autoware runs.",
    epilog="""\b
Examples:
  osm2xodr start carla area.osm --dem dem.tif -o area_carla
  osm2xodr start sumo area.osm --dem dem.tif -o area_sumo
  osm2xodr start esmini area.osm --dem dem.tif -o area_esmini
  osm2xodr start autoware area.osm --dem dem.tif -o area_autoware

The last line names the one command that runs it, and so does README.md in the folder. docs/start.md says more. SUMO's
network is made by its netconvert, which has to be installed.

Exit status: 0 written, 1 cannot be made, 2 wrong usage, 130 interrupted.""",
)
@click.argument("simulator", type=click.Choice(SIMULATORS))
@click.argument("area", type=PATH)
@dem_option("Elevation models, any CRS; without one the world is flat at 0, but for bridges and tunnels")
@click.option("-o", "--output", "folder", required=True, type=PATH, metavar="DIR", help="Folder to write.")
@click.option(
    "--scene-tile",
    type=float,
    metavar="M",
    help="Width of the tiles of CARLA's scene.  [default: one tile up to 2.5 km, else 2000]",
)
@overwrite_option
@declared_options(name for name in DECLARATIONS if name not in NOT_CHOSEN)
@click.option("-v", "--verbose", count=True, help="Say what was found how often; -vv: all details, and tracebacks.")
@quiet_option
@click.pass_obj
@limit_options
def start(
    session: Session,
    /,
    simulator: str,
    area: Path,
    dem: tuple[Path, ...],
    folder: Path,
    scene_tile: float | None,
    overwrite: bool,
    verbose: int,
    quiet: bool,
    **values: Any,
) -> None:
    """Make a folder of AREA that SIMULATOR runs: road network, traffic or scenario, and what starts it.

    AREA and most options are those of convert; the target follows from the simulator.
    """
    session.verbose = verbose
    options = given_options(values)
    if folder.is_dir() and any(folder.iterdir()) and not overwrite:
        raise click.UsageError(f"{folder} exists; give another folder, or --overwrite to replace it")
    began = time.monotonic()
    with shown(Progress(sys.stderr, quiet=quiet, verbose=verbose > 0, plan=list(_PLAN))) as progress:
        stage("starting")
        from osm2xodr.reporting import summary
        from osm2xodr.starting import start as run

        try:
            made = run(simulator, area, folder, expand(dem), options, scene_tile=scene_tile, on_stage=stage)
        finally:
            progress.done()
    if quiet:
        return
    report_conversion(made.conversion, made.written, time.monotonic() - began, verbose)
    about = summary(made.conversion, made.written.diagnostics, has_heights=bool(dem))
    sum_up(about.lines(used=3 + len(made.notes), more="-v"))
    size = sum(path.stat().st_size for path in made.files) / 1e6
    for line in made.notes:
        click.echo(f"osm2xodr: {line}", err=True)
    click.echo(f"osm2xodr: wrote {folder} ({len(made.files):,} files, {size:,.1f} MB)", err=True)
    click.echo(f"osm2xodr: run it with: {made.command}", err=True)
