"""The command ``convert``: its options and messages."""

from __future__ import annotations

import contextlib
import dataclasses
import gc
import json
import os
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from osm2xodr.cli.options import (
    PATH,
    Session,
    check_targets,
    declared_options,
    given_options,
    limit_options,
    output_option,
    overwrite_option,
    quiet_option,
)
from osm2xodr.defaults import CHECK_FINDINGS, REPORT_FINDINGS
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.library import DECLARATIONS
from osm2xodr.reporting import Progress, Style, details, kinds_of_findings, summary
from osm2xodr.system import STANDARD_OUTPUT, label

if TYPE_CHECKING:
    from osm2xodr.reporting import Conversion, Line, Written

_MEGABYTE = 1e6
_MAP_SUFFIXES = frozenset({".osm", ".pbf", ".gz", ".bz2"})
_COLOURS = {Style.HEADING: "yellow", Style.ATTENTION: "yellow"}
# In --help these stand after the options that only the command line has.
_LAST = ("frame", "jobs")


class _Convert(click.Command):
    """The command, which says what to do with files that follow the area."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the arguments."""
        rest = super().parse_args(ctx, args)
        if ctx.args:
            more = ctx.args[0]
            if Path(more).suffix.lower() in _MAP_SUFFIXES:
                raise click.UsageError(f"{more}: one area at a time; osmium merge joins files", ctx)
            raise click.UsageError(f"{more}: elevation models stand after --dem; write --dem {more}", ctx)
        return rest


@click.command(
    cls=_Convert,
    context_settings={"allow_extra_args": True},
    short_help="Convert an OpenStreetMap file to OpenDRIVE.",
    epilog="""\b
Examples:
  osm2xodr convert area.osm --dem dem.tif -o area.xodr
  osm2xodr convert area.osm.pbf --dem west.tif --dem east.tif -o area.xodr --overwrite
  osm2xodr convert area.osm.gz -o flat.xodr --ways major --xodr-version 1.4
  osm2xodr convert area.osm --dem dem.tif -o area.xodr --check --html area.html
  osm2xodr convert - -o area.xodr < area.osm
  osm2xodr convert area.osm -o - --ways motorway,motorway_link | gzip > area.xodr.gz

Exit status: 0 written, 1 cannot convert, or --check found something, 2 wrong usage, 130 interrupted.""",
)
@click.argument("area", type=PATH)
@click.option(
    "--dem",
    multiple=True,
    type=PATH,
    metavar="FILE",
    help="Elevation model: GeoTIFF, HGT or VRT, any CRS. May be repeated; without it the world is flat at 0.",
)
@output_option("OpenDRIVE file")
@overwrite_option
@declared_options(name for name in DECLARATIONS if name not in _LAST)
@click.option(
    "--report-json",
    type=PATH,
    metavar="FILE",
    help="Write all that was guessed, dropped and repaired, each with its OSM id.",
)
@click.option("--check", is_flag=True, help="Check what was written, as the command check does.")
@click.option(
    "--html",
    type=PATH,
    metavar="FILE",
    help="Write a page to explore the road network with, as the command report does.",
)
@declared_options(_LAST)
@click.option(
    "-v",
    "--verbose",
    count=True,
    help="Say how long each stage takes, and what was found how often; -vv: all details, and tracebacks.",
)
@quiet_option
@click.pass_obj
@limit_options
def convert(
    session: Session,
    /,
    area: Path,
    dem: tuple[Path, ...],
    output: Path,
    overwrite: bool,
    report_json: Path | None,
    check: bool,
    html: Path | None,
    verbose: int,
    quiet: bool,
    **values: Any,
) -> int:
    """Convert AREA, an OpenStreetMap file (.osm, .osm.gz, .osm.bz2, .osm.pbf; - for standard input), to OpenDRIVE."""
    session.verbose = verbose
    given = area
    area = click.get_current_context().with_resource(_on_disk(area))
    options = given_options(values)
    for option, wanted in (("--check", check), ("--html", html is not None)):
        if wanted and output == STANDARD_OUTPUT:
            raise click.UsageError(f"{option} needs what was written as a file; give one with -o")
    targets = [("-o", output), ("--report-json", report_json), ("--html", html)]
    inputs = [area, *dem, *([Path(options.frame)] if options.frame else [])]
    check_targets([(name, path) for name, path in targets if path is not None], inputs, overwrite=overwrite)
    progress = Progress(sys.stderr, live=sys.stderr.isatty() and not quiet, verbose=verbose > 0 and not quiet)
    began = time.monotonic()
    # The data of the stages has no reference cycles; the search for some takes up to a fifth of the time.
    gc.disable()
    progress.stage("starting")
    try:
        from osm2xodr.library import convert as run

        conversion = run(area, dem, options=options, on_stage=progress.stage)
        # A file that standard input is kept in has another name each time.
        conversion = dataclasses.replace(conversion, inputs={**conversion.inputs, "area": str(given)})
        progress.stage(f"writing {label(output)}")
        written = conversion.write(output, report_json=report_json)
    finally:
        progress.done()
        gc.enable()
    about = summary(conversion, written.diagnostics, has_heights=bool(dem))
    command = "" if output == STANDARD_OUTPUT else conversion.load_command(output)
    if not quiet:
        _report(conversion, written, time.monotonic() - began, verbose)
    log = conversion.report(written) if html is not None else b""
    # The check and the page read the file, and need the memory.
    del conversion
    status = findings = 0
    try:
        if check or html is not None:
            status, findings = _check_and_show(output, area, dem, html, log, check=check, quiet=quiet)
    finally:
        if not quiet:
            _sum_up(about.lines(findings, 1 + check + (html is not None) + bool(command)), command)
    return status


@contextlib.contextmanager
def _on_disk(area: Path) -> Iterator[Path]:
    """Yield the file of an area, which is read twice: standard input is kept in a temporary one meanwhile."""
    if area != STANDARD_OUTPUT:
        yield area
        return
    import shutil
    import tempfile

    with tempfile.TemporaryDirectory(prefix="osm2xodr-") as folder:
        path = Path(folder) / "standard_input"
        with path.open("wb") as stream:
            shutil.copyfileobj(sys.stdin.buffer, stream)
        yield path


def _report(conversion: Conversion, written: Written, seconds: float, verbose: int) -> None:
    """Print what was written, and on request what was found."""
    size = f"{written.size / _MEGABYTE:,.1f} MB, OpenDRIVE {conversion.options.version}"
    _say(f"osm2xodr: wrote {label(written.path)} ({size}) in {seconds:,.1f} s")
    for text in kinds_of_findings(written.diagnostics) if verbose else []:
        _say(text)
    for text in details(written.diagnostics) if verbose > 1 else []:
        _say(text)


def _sum_up(lines: Sequence[Line], command: str) -> None:
    """Print the summary, and what loads the file, if a reader needs to be told."""
    for line in lines:
        _say(line.text, line.style)
    if command:
        _say(f"osm2xodr: load it with: {command}")


def _say(text: str, style: Style = Style.PLAIN) -> None:
    """Print a line; colours are for terminals, unless NO_COLOR (https://no-color.org) is set."""
    colour = _COLOURS.get(style)
    plain = colour is None or os.environ.get("NO_COLOR")
    click.echo(text if plain else click.style(text, fg=colour, bold=style is Style.HEADING), err=True)


def _check_and_show(
    output: Path, area: Path, dem: tuple[Path, ...], html: Path | None, log: bytes, *, check: bool, quiet: bool
) -> tuple[int, int]:
    """Check the file that was written and make the page about it, as asked for.

    Returns the exit status and the number of errors and warnings.
    """
    from osm2xodr.checking import CheckOptions, Severity, check_drive
    from osm2xodr.opendrive import read_xodr

    # Both need the file and the findings, which take longest: they share them.
    file = read_xodr(output)
    result = check_drive(file, CheckOptions(most=REPORT_FINDINGS))
    status = findings = 0
    if check:
        listed = result.worst(CHECK_FINDINGS)
        for line in [listed.headline()] if quiet else listed.lines(Severity.WARNING):
            click.echo(line, err=True)
        status = int(result.failed())
        findings = result.count(Severity.ERROR) + result.count(Severity.WARNING)
    if html is not None:
        from osm2xodr.viewing import ReportOptions, write_report

        about = ReportOptions(area, dem, json.loads(log))
        size = write_report(file, html, about, Diagnostics(), result)
        if not quiet:
            click.echo(f"osm2xodr: wrote {label(html)} ({size / _MEGABYTE:,.1f} MB)", err=True)
    return status, findings
