"""The command ``convert``: its options and messages."""

from __future__ import annotations

import dataclasses
import gc
import json
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from osm2xodr.cli.config import check_replay, config_option
from osm2xodr.cli.options import (
    PATH,
    DemCommand,
    Session,
    check_targets,
    declared_options,
    dem_option,
    given_options,
    limit_options,
    output_option,
    overwrite_option,
    quiet_option,
)
from osm2xodr.conventions import TARGETS, Group, programmes_file
from osm2xodr.defaults import CHECK_FINDINGS, REPORT_FINDINGS
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.python_api import DECLARATIONS
from osm2xodr.reporting import Style, details, kinds_of_findings, summary
from osm2xodr.surface import expand
from osm2xodr.system import STANDARD_OUTPUT, Progress, label, shown, stage

if TYPE_CHECKING:
    from osm2xodr.pipeline import Layouts
    from osm2xodr.python_api import AreaMap, ConvertOptions
    from osm2xodr.reporting import Conversion, Line, Written
    from osm2xodr.viewing import ReportOptions

_MEGABYTE = 1e6
_MAP_SUFFIXES = frozenset({".osm", ".pbf", ".gz", ".bz2", ".xz", ".zst"})
_COLOURS = {Style.HEADING: "yellow", Style.ATTENTION: "yellow"}
# Groups in --help of the options that only the command line has; the others are about the machine.
_WHAT = frozenset({"dem", "config", "from_report"})
_OUTPUT = frozenset({"output", "overwrite", "report_json", "osm_issues", "check", "html", "verbose", "quiet"})
# Whether --help shows the options of the last group as well.
_ALL = "osm2xodr.help-all"


def group_of(option: str) -> Group:
    """Return the group of an option in --help, by its name in Python."""
    if option in DECLARATIONS:
        return DECLARATIONS[option].group
    return Group.WHAT if option in _WHAT else Group.OUTPUT if option in _OUTPUT else Group.MACHINE


class _Convert(DemCommand):
    """The command, with its options in groups, which says what to do with files that follow the area."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options: those of tiles and experts by their names, unless all are asked for."""
        options = [item for item in self.get_params(ctx) if isinstance(item, click.Option)]
        for group in Group:
            here = [item for item in options if group_of(item.name or "") is group]
            if group is Group.MORE and _ALL not in ctx.meta:
                formatter.write_paragraph()
                names = ", ".join(item.opts[0] for item in here)
                formatter.write_text(f"{group.value} (--help-all): {names}")
                continue
            with formatter.section(group.value):
                formatter.write_dl([record for item in here if (record := item.get_help_record(ctx))])

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the arguments."""
        rest = super().parse_args(ctx, args)
        if ctx.args:
            more = ctx.args[0]
            if Path(more).suffix.lower() in _MAP_SUFFIXES:
                raise click.UsageError(f"{more}: one area at a time; osmium merge joins files", ctx)
            raise click.UsageError(f"{more}: elevation models stand after --dem; write --dem {more}", ctx)
        return rest


def _help_all(ctx: click.Context, _: click.Parameter, value: bool) -> None:
    if value:
        ctx.meta[_ALL] = True
        click.echo(ctx.get_help())
        ctx.exit()


@click.command(
    cls=_Convert,
    context_settings={"allow_extra_args": True},
    short_help="Convert an OpenStreetMap file to OpenDRIVE.",
    epilog="""\b
Examples:
  osm2xodr convert area.osm --dem dem.tif -o area.xodr
  osm2xodr convert area.osm.pbf --dem west.tif east.tif -o area.xodr --overwrite
  osm2xodr convert country.osm.pbf --bbox 1.50,42.50,1.55,42.55 --dem dem -o area.xodr
  osm2xodr convert area.osm.gz -o flat.xodr --ways major --xodr-version 1.4
  osm2xodr convert area.osm --dem dem.tif -o area.xodr --check --html area.html
  osm2xodr convert - -o area.xodr < area.osm
  osm2xodr convert --config osm2xodr.toml
  osm2xodr convert area.osm -o - --ways motorway,motorway_link | gzip > area.xodr.gz

Exit status: 0 written, 1 cannot convert, or --check found something, 2 wrong usage, 130 interrupted.""",
)
@click.argument("area", type=PATH)
@dem_option("Elevation models, any CRS; without one the world is flat at 0, but for bridges and tunnels")
@output_option("OpenDRIVE file")
@overwrite_option
@declared_options(DECLARATIONS)
@click.option(
    "--report-json",
    type=PATH,
    metavar="FILE",
    help="Write all that was guessed, dropped and repaired, each with its OSM id.",
)
@click.option(
    "--osm-issues",
    type=PATH,
    metavar="FILE",
    help="Write OpenStreetMap's mistakes, as far as they were found, as GeoJSON with links.",
)
@click.option("--check", is_flag=True, help="Check what was written, as the command check does.")
@click.option(
    "--html",
    type=PATH,
    metavar="FILE",
    help="Write a page to explore the road network with, as the command report does.",
)
@config_option
@click.option(
    "-v",
    "--verbose",
    count=True,
    help="Say how long each stage takes, and what was found how often; -vv: all details, and tracebacks.",
)
@quiet_option
@click.option(
    "--help-all", is_flag=True, is_eager=True, expose_value=False, callback=_help_all, help="Show all options."
)
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
    osm_issues: Path | None,
    check: bool,
    html: Path | None,
    config: Path | None,
    from_report: Path | None,
    verbose: int,
    quiet: bool,
    **values: Any,
) -> int:
    """Convert AREA, an OpenStreetMap file (.osm, .osm.pbf, or packed: .osm.gz, .bz2, .xz, .zip, .zst), to OpenDRIVE.

    - stands for standard input.
    """
    session.verbose = verbose
    options = given_options(values)
    for option, wanted in (("--check", check), ("--html", html is not None)):
        if wanted and output == STANDARD_OUTPUT:
            raise click.UsageError(f"{option} needs what was written as a file; give one with -o")
    targets = [("-o", output), ("--report-json", report_json), ("--osm-issues", osm_issues), ("--html", html)]
    if TARGETS[options.target].programmes_option and output != STANDARD_OUTPUT:
        targets.append(("-o", programmes_file(output)))
    dem = expand(dem)
    named = (options.frame, options.polygon, options.corrections, config, from_report)
    inputs = [area, *dem, *(Path(path) for path in named if path is not None)]
    check_targets([(name, path) for name, path in targets if path is not None], inputs, overwrite=overwrite)
    files = output, report_json, osm_issues, html
    asked = _Wanted(area, dem, *files, from_report, check=check, verbose=verbose, quiet=quiet)
    began = time.monotonic()
    progress = Progress(sys.stderr, quiet=quiet, verbose=verbose > 0, plan=_plan(asked, options))
    with shown(progress):
        stage("starting")
        from osm2xodr.python_api import area_map

        with area_map(area, options, stage) as found:
            return _convert(asked, options, found, progress, began, session.layouts)


def _plan(wanted: _Wanted, options: ConvertOptions) -> list[tuple[str, float]]:
    """Return the stages, and about what share of the time each takes, s for a town of 60,000 people."""
    cut = options.bbox is not None or options.polygon is not None
    show = wanted.check or wanted.html is not None
    stages = [
        ("starting", 0.3, True),
        ("cutting", 1.0, cut),
        ("reading", 0.8, True),
        ("reading the elevation model", 0.5, bool(wanted.dem)),
        ("building roads", 2.5, True),
        ("placing", 0.5, True),
        ("cutting roads", 0.2, options.frame is not None),
        ("writing", 0.3, True),
        ("reading", 1.2, show),
        ("checking the schema", 0.3, show),
        ("checking roads", 1.0, show),
        ("making the page", 0.5, wanted.html is not None),
    ]
    return [(name, share) for name, share, is_done in stages if is_done]


@dataclasses.dataclass(frozen=True)
class _Wanted:
    """What the command is to do."""

    area: Path
    dem: tuple[Path, ...]
    output: Path
    report_json: Path | None
    osm_issues: Path | None
    html: Path | None
    from_report: Path | None
    check: bool
    verbose: int
    quiet: bool


def _convert(
    wanted: _Wanted,
    options: ConvertOptions,
    found: AreaMap,
    progress: Progress,
    began: float,
    layouts: Layouts | None,
) -> int:
    """Convert a map, write what is wanted, say so, and return the exit status."""
    output, html, quiet = wanted.output, wanted.html, wanted.quiet
    # The data of the stages has no reference cycles; the search for some takes up to a fifth of the time.
    gc.disable()
    try:
        from osm2xodr.python_api import clipping, convert as run

        try:
            conversion = run(found.path, wanted.dem, options=found.options, on_stage=found.on_stage, layouts=layouts)
            # What was asked for, whatever file is read for it.
            inputs = options.inputs(wanted.area, wanted.dem)
            conversion = dataclasses.replace(conversion, inputs=inputs, clip=clipping(options))
            progress.stage(f"writing {label(output)}")
            written = conversion.write(output, report_json=wanted.report_json, osm_issues=wanted.osm_issues)
        finally:
            progress.done()
        about = summary(conversion, written.diagnostics, has_heights=bool(wanted.dem))
        command = "" if output == STANDARD_OUTPUT else conversion.load_command(output)
        if not quiet:
            report_conversion(conversion, written, time.monotonic() - began, wanted.verbose)
        log = conversion.report(written) if html is not None else b""
        # The check and the page read the file, and need the memory. The search would go through all of it once more.
        del conversion
    finally:
        # What is left is used until the end. The first search would go through all of it.
        gc.freeze()
        gc.enable()
    status = findings = 0
    try:
        if wanted.check or html is not None:
            from osm2xodr.viewing import ReportOptions

            about_page = ReportOptions(
                *(found.path, wanted.dem, json.loads(log or b"null")),
                dem_crs=options.dem_crs,
                dem_unit=options.dem_unit,
                dem_encoding=options.dem_encoding,
            )
            status, findings = _check_and_show(wanted, about_page, progress)
    finally:
        if not quiet:
            sum_up(about.lines(findings, 1 + wanted.check + (html is not None) + bool(command)))
            if command:
                _echo(f"osm2xodr: load it with: {command}")
    if wanted.from_report is not None:
        check_replay(wanted.from_report, written, click.get_current_context())
    return status


def report_conversion(conversion: Conversion, written: Written, seconds: float, verbose: int) -> None:
    """Print what was written, and on request what was found."""
    size = f"{written.size / _MEGABYTE:,.1f} MB, OpenDRIVE {conversion.options.version}"
    _echo(f"osm2xodr: wrote {label(written.path)} ({size}) in {seconds:,.1f} s")
    for text in kinds_of_findings(written.diagnostics) if verbose else []:
        _echo(text)
    for text in details(written.diagnostics) if verbose > 1 else []:
        _echo(text)


def sum_up(lines: Sequence[Line]) -> None:
    """Print the summary of a conversion."""
    for line in lines:
        _echo(line.text, line.style)


def _echo(text: str, style: Style = Style.PLAIN) -> None:
    """Print a line; colours are for terminals, unless NO_COLOR (https://no-color.org) is set."""
    colour = _COLOURS.get(style)
    plain = colour is None or os.environ.get("NO_COLOR")
    click.echo(text if plain else click.style(text, fg=colour, bold=style is Style.HEADING), err=True)


def _check_and_show(wanted: _Wanted, about: ReportOptions, progress: Progress) -> tuple[int, int]:
    """Check the file that was written and make the page about it, as asked for.

    Returns the exit status and the number of errors and warnings.
    """
    from osm2xodr.checking import CheckOptions, Severity, check_drive
    from osm2xodr.opendrive import read_xodr

    # Both need the file and the findings, which take longest: they share them.
    file = read_xodr(wanted.output)
    result = check_drive(file, CheckOptions(most=REPORT_FINDINGS))
    progress.done()
    status = findings = 0
    if wanted.check:
        listed = result.worst(CHECK_FINDINGS)
        for line in [listed.headline()] if wanted.quiet else listed.lines(Severity.WARNING):
            click.echo(line, err=True)
        status = int(result.failed())
        findings = result.count(Severity.ERROR) + result.count(Severity.WARNING)
    if wanted.html is not None:
        from osm2xodr.viewing import write_report

        size = write_report(file, wanted.html, about, Diagnostics(), result)
        progress.done()
        if not wanted.quiet:
            click.echo(f"osm2xodr: wrote {label(wanted.html)} ({size / _MEGABYTE:,.1f} MB)", err=True)
    return status, findings
