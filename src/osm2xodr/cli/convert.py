"""The command ``convert``: its options, and what it says."""

from __future__ import annotations

import gc
import json
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from osm2xodr import __version__
from osm2xodr.cli import defaults
from osm2xodr.cli.convert_options import Arguments, area_name, convert_options, report_inputs
from osm2xodr.cli.options import Session, check_targets, limit_options, output_option, overwrite_option
from osm2xodr.conventions import DEFAULT_TARGET, TARGETS
from osm2xodr.defaults import CHECK_FINDINGS, POLYNOMIAL_ORDER, REPORT_FINDINGS, SURFACE_METHOD
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.furniture import EXTRA_OBJECTS
from osm2xodr.reporting import Progress, deliver, details, report_text, summary
from osm2xodr.system import STANDARD_OUTPUT, label
from osm2xodr.xodrWriter import VERSIONS, WriteOptions

if TYPE_CHECKING:
    from osm2xodr.reporting import Conversion

# `osm2xodr.surface.METHODS`, which is too slow to load for --help; a test holds them equal.
SURFACE_METHODS = ("nearest", "bilinear", "bicubic", "polynomial")
# Likewise `osm2xodr.surface.DEM_TYPES`.
DEM_TYPES = ("auto", "dtm", "dsm")

_MEGABYTE = 1e6


@click.command(
    short_help="Convert an OpenStreetMap file to OpenDRIVE.",
    epilog="""\b
Examples:
  osm2xodr convert area.osm --dem dem.tif -o area.xodr
  osm2xodr convert area.osm.pbf --dem west.tif --dem east.tif -o area.xodr --overwrite
  osm2xodr convert area.osm.gz -o flat.xodr --ways major --xodr-version 1.4
  osm2xodr convert area.osm --dem dem.tif -o area.xodr --check --html area.html
  osm2xodr convert area.osm -o - --ways motorway,motorway_link | gzip > area.xodr.gz

Exit status: 0 written, 1 cannot convert, or --check found something, 2 wrong usage.""",
)
@click.argument("area", type=click.Path(path_type=Path))
@click.option(
    "--dem",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Elevation model: GeoTIFF, HGT or VRT, any CRS. May be repeated; without it the world is flat at 0.",
)
@output_option("OpenDRIVE file")
@overwrite_option
@click.option("--name", metavar="TEXT", help="Name of the road network.  [default: that of AREA]")
@click.option("--date", default="", metavar="TEXT", help="Date for the header, such as 2024-05-01.  [default: none]")
@click.option(
    "--ways",
    default="drivable",
    show_default=True,
    metavar="LIST",
    help="Which ways: major, drivable, all, or values of OSM's highway, separated by commas.",
)
@click.option("--include-private", is_flag=True, help="Keep ways that are closed to the public.")
@click.option(
    "--xodr-version",
    type=click.Choice(VERSIONS),
    default=WriteOptions().version,
    show_default=True,
    help="Version of OpenDRIVE.",
)
@click.option("--left-hand", is_flag=True, help="Traffic drives on the left.  [default: as in the country]")
@click.option("--right-hand", is_flag=True, help="Traffic drives on the right.  [default: as in the country]")
@click.option(
    "--default-lane-width",
    type=float,
    metavar="METRES",
    help="Width of lanes where OSM gives none.  [default: by class of road]",
)
@click.option(
    "--surface",
    type=click.Choice(SURFACE_METHODS),
    default=SURFACE_METHOD,
    show_default=True,
    help="How heights between the cells of the elevation model are found.",
)
@click.option(
    "--polynomial-order",
    type=click.IntRange(2, 5),
    metavar="2-5",
    default=POLYNOMIAL_ORDER,
    show_default=True,
    help="Degree of the trend that fills gaps of the elevation model.",
)
@click.option(
    "--dem-type",
    type=click.Choice(DEM_TYPES),
    default="auto",
    show_default=True,
    help="Whether elevation models show the ground (dtm), or canopy and roofs (dsm), which roads then see through.",
)
@click.option(
    "--dem-sigma",
    type=float,
    metavar="METRES",
    help="Standard error of the elevation models' heights.  [default: estimated]",
)
@click.option(
    "--vertical-datum",
    metavar="DATUM",
    help="Turn heights into this datum: ellipsoid, or a code such as EPSG:3855 (EGM2008).  [default: as they are]",
)
@click.option(
    "--dem-vertical-datum",
    metavar="DATUM",
    help="Datum of the elevation models' heights, likewise.  [default: as the files say]",
)
@click.option("--allow-partial", is_flag=True, help="Accept elevation models that cover less than half of the roads.")
@click.option(
    "--smoothing",
    type=float,
    default=1.0,
    show_default=True,
    metavar="FACTOR",
    help="Factor on the length over which heights are smoothed.",
)
@click.option(
    "--max-grade",
    metavar="TABLE",
    help="Largest grades by class, such as motorway=0.05,residential=12%.  [default: see docs/elevation.md]",
)
@click.option("--no-structures", is_flag=True, help="Lay bridges and tunnels on the ground.")
@click.option(
    "--superelevation",
    is_flag=True,
    help="Bank motorways and trunk roads as a fine elevation model (cells up to 2 m) shows.",
)
@click.option("--turnarounds", is_flag=True, help="End every dead end of a two-way street in a loop.")
@click.option(
    "--target",
    type=click.Choice(list(TARGETS)),
    default=DEFAULT_TARGET,
    show_default=True,
    help="Reader to write for where readers contradict each other; generic suits CARLA, esmini and SUMO.",
)
@click.option(
    "--objects",
    metavar="LIST",
    help=f"Further objects: {', '.join(EXTRA_OBJECTS)}, or all.  [default: none]",
)
@click.option(
    "--no-furniture", is_flag=True, help="Write the carriageway alone: no signals, objects and lanes beside it."
)
@click.option(
    "--report-json",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write all that was guessed, dropped and repaired, each with its OSM id.",
)
@click.option("--check", is_flag=True, help="Check what was written, as the command check does.")
@click.option(
    "--html",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write a page to explore the road network with, as the command report does.",
)
@click.option(
    "--frame",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Areas side by side, as batch --shared-frame writes them: cut roads at the border of the one that AREA is"
    " named after.",
)
@click.option(
    "--jobs",
    type=click.IntRange(1),
    metavar="N",
    help="Processes that work at once; the result is the same for any number.  [default: one per core, up to"
    f" {defaults.MOST_JOBS}]",
)
@click.option("-v", "--verbose", count=True, help="Say how long each stage takes; -vv: all details, and tracebacks.")
@click.option("-q", "--quiet", is_flag=True, help="Say nothing but errors.")
@click.pass_obj
@limit_options
def convert(session: Session, /, **options: Any) -> int:
    """Convert AREA, an OpenStreetMap file (.osm, .osm.gz, .osm.bz2, .osm.pbf), to OpenDRIVE."""
    arguments = Arguments(**options)
    session.verbose = arguments.verbose
    _refuse_contradictions(arguments)
    live = sys.stderr.isatty() and not arguments.quiet
    progress = Progress(sys.stderr, live=live, verbose=arguments.verbose > 0 and not arguments.quiet)
    began = time.monotonic()
    # What the stages hand on has no circles. Looking for some takes up to a fifth of the time.
    gc.disable()
    progress.stage("starting")
    try:
        from osm2xodr.pipeline import convert as run

        wanted = convert_options(arguments)
        diagnostics = Diagnostics()
        conversion = run(wanted, diagnostics, progress.stage)
        progress.stage(f"writing {label(arguments.output)}")
        name = area_name(arguments.area) if arguments.name is None else arguments.name
        target = TARGETS[arguments.target]
        how = WriteOptions(arguments.xodr_version, name, arguments.date, __version__, target=target)
        inputs = report_inputs(arguments, name)
        size = deliver(conversion, diagnostics, arguments.output, how, arguments.report_json, inputs, wanted.jobs)
    finally:
        progress.done()
        gc.enable()
    if not arguments.quiet:
        _tell(arguments, conversion, diagnostics, size, time.monotonic() - began)
    log = report_text(conversion, diagnostics, arguments.output, how, inputs, size) if arguments.html else b""
    # The page and the check read what was written, and need the memory.
    del conversion
    return _look_at(arguments, log)


def _refuse_contradictions(arguments: Arguments) -> None:
    """Refuse options that do not go together, and outputs that cannot be, before any work is done."""
    if arguments.left_hand and arguments.right_hand:
        raise click.UsageError("--left-hand and --right-hand exclude each other; give one of them")
    targets = [("-o", arguments.output)]
    if arguments.report_json is not None:
        targets.append(("--report-json", arguments.report_json))
    if arguments.html is not None:
        targets.append(("--html", arguments.html))
    for option, given in (("--check", arguments.check), ("--html", arguments.html is not None)):
        if given and arguments.output == STANDARD_OUTPUT:
            raise click.UsageError(f"{option} needs what was written as a file; give one with -o")
    inputs = [arguments.area, *arguments.dem, *([arguments.frame] if arguments.frame else [])]
    check_targets(targets, inputs, overwrite=arguments.overwrite)


def _tell(arguments: Arguments, conversion: Conversion, diagnostics: Diagnostics, size: int, seconds: float) -> None:
    """Say what was written."""
    click.echo(
        f"osm2xodr: wrote {label(arguments.output)} ({size / _MEGABYTE:,.1f} MB, OpenDRIVE"
        f" {arguments.xodr_version}) in {seconds:,.1f} s",
        err=True,
    )
    elevation = conversion.road_map.elevation_report if arguments.dem else None
    for line in summary(conversion.statistics, diagnostics, has_heights=bool(arguments.dem), elevation=elevation):
        click.echo(line, err=True)
    if arguments.verbose > 1:
        for line in details(diagnostics):
            click.echo(line, err=True)


def _look_at(arguments: Arguments, log: bytes) -> int:
    """Check what was written and make the page about it, where wanted; return the exit status."""
    if not arguments.check and arguments.html is None:
        return 0
    from osm2xodr.checking import CheckOptions, Severity, check_drive
    from osm2xodr.opendrive import read_xodr

    # Both need what was written and what is wrong with it, which take longer than all else: they share it.
    file = read_xodr(arguments.output)
    result = check_drive(file, CheckOptions(most=REPORT_FINDINGS))
    status = 0
    if arguments.check:
        listed = result.worst(CHECK_FINDINGS)
        for line in [listed.headline()] if arguments.quiet else listed.lines(Severity.WARNING):
            click.echo(line, err=True)
        status = int(result.failed())
    if arguments.html is not None:
        from osm2xodr.viewing import ReportOptions, write_report

        about = ReportOptions(arguments.area, arguments.dem, json.loads(log))
        size = write_report(file, arguments.html, about, Diagnostics(), result)
        if not arguments.quiet:
            click.echo(f"osm2xodr: wrote {label(arguments.html)} ({size / _MEGABYTE:,.1f} MB)", err=True)
    return status
