"""The command ``batch``: its options, its progress and its messages."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from osm2xodr.cli.batch_options import BatchArguments, Plan, plan, refuse_contradictions
from osm2xodr.cli.options import Parsed, Session
from osm2xodr.diagnostics import Diagnostics, counted
from osm2xodr.reporting import details
from osm2xodr.system import parse_duration, parse_memory

if TYPE_CHECKING:
    from osm2xodr.batch import BatchOptions, PlannedArea, Result

_FAILED, _INTERRUPTED = 1, 130
_GIGABYTE = 1e9


def _length(text: str) -> float:
    from osm2xodr.batch import parse_length

    return parse_length(text)


@click.command(
    short_help="Convert many areas, on all cores or a cluster.",
    epilog="""\b
Examples:
  osm2xodr batch areas.toml -o out
  osm2xodr batch areas.csv -o out --dem 'dem/*.tif' --options '--ways major --target carla'
  osm2xodr batch --from country.osm.pbf --tiles 5km --shared-frame --dem 'dem/*.tif' -o out
  osm2xodr batch --from country.osm.pbf --areas towns.geojson --dem dem -o out --max-memory 2G

\b
A manifest in TOML; in CSV the same names are the columns:
  [defaults]
  dem = ["dem/*.tif"]
  ways = "major"
  [[area]]
  name = "harbour"
  osm = "country.osm.pbf"
  bbox = [1.50, 42.50, 1.55, 42.55]
  left-hand = true

Started again, it only converts areas that failed, or whose map, elevation models, options or version have changed.
The files of an area that fails are removed.

Exit status: 0 all areas are there, 1 some failed, 2 wrong usage, 130 interrupted.""",
)
@click.argument("manifest", type=click.Path(path_type=Path), required=False)
@click.option("--from", "source", type=click.Path(path_type=Path), metavar="FILE", help="Map to cut areas out of.")
@click.option("--tiles", type=Parsed("length", _length), metavar="SIDE", help="Cut it into squares, such as 5km.")
@click.option(
    "--areas",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Cut out the polygons of a GeoJSON file, which their property name or id names.",
)
@click.option(
    "--dem",
    multiple=True,
    metavar="PATTERN",
    help="Elevation models of areas that name none: a file, a pattern such as 'dem/*.tif', or a folder. May be"
    " repeated.",
)
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), metavar="DIR", required=True, help="Folder to write to."
)
@click.option(
    "--options", default="", metavar="TEXT", help="Options of convert for all areas, such as '--ways major'."
)
@click.option(
    "--shared-frame",
    is_flag=True,
    help="Give all areas the same projection, ids of their own, and roads that meet at the borders.",
)
@click.option(
    "--workers",
    type=click.IntRange(1),
    metavar="N",
    help="How many areas are converted at once.  [default: one per core]",
)
@click.option(
    "--scheduler",
    default="",
    metavar="ADDRESS",
    help="Use the workers of a Dask scheduler, such as tcp://host:8786; they need the same osm2xodr, and all files"
    " under the same paths.",
)
@click.option(
    "--max-memory",
    type=Parsed("memory", parse_memory),
    metavar="SIZE",
    help="Memory that an area may take, such as 2G.  [default: an equal share of what is free]",
)
@click.option(
    "--timeout",
    type=Parsed("duration", parse_duration),
    metavar="TIME",
    help="Time that an area may take, such as 10min.  [default: no bound]",
)
@click.option("--force", is_flag=True, help="Convert areas that have not changed as well.")
@click.option("--keep-cuts", is_flag=True, help="Keep what is cut out of maps, in the folder .cuts.")
@click.option("--dry-run", is_flag=True, help="List the areas, and do nothing.")
@click.option("-v", "--verbose", count=True, help="Report each area as it ends; -vv: all details, and tracebacks.")
@click.option("-q", "--quiet", is_flag=True, help="Say nothing but errors.")
@click.pass_obj
def batch(session: Session, /, **options: Any) -> int:
    """Convert many areas: those that MANIFEST (.toml, .csv) lists, or those cut out of one map."""
    arguments = BatchArguments(**options)
    session.verbose = arguments.verbose
    refuse_contradictions(arguments)
    progress = _BatchProgress(live=sys.stderr.isatty() and not arguments.quiet, verbose=bool(arguments.verbose))
    try:
        progress.stage("reading the list of areas")
        planned = plan(arguments)
        progress.clear()
        if arguments.dry_run:
            return _list(planned.areas)
        return _run(arguments, planned, progress)
    except KeyboardInterrupt:
        progress.clear()
        click.echo(f"osm2xodr: error: interrupted{progress.so_far()}; the same command goes on", err=True)
        return _INTERRUPTED
    finally:
        progress.clear()


def _run(arguments: BatchArguments, planned: Plan, progress: _BatchProgress) -> int:
    """Run a batch, report its results, and return the exit status."""
    from osm2xodr.batch import keep_bounds, open_out_dir, run_batch, write_summary

    began = time.monotonic()
    diagnostics = Diagnostics()
    output = Path.cwd() / arguments.output if arguments.scheduler else arguments.output
    with open_out_dir(output) as out:
        if planned.bounds is not None:
            keep_bounds(output, planned.areas[0].area.osm, planned.bounds)
        results = run_batch(planned.areas, out, _batch_options(arguments), diagnostics, progress)
        progress.stage("writing the summary")
        write_summary(output, results)
    progress.clear()
    _report(arguments, results, diagnostics, time.monotonic() - began)
    return _FAILED if any(_failed(result) for result in results) else 0


def _batch_options(arguments: BatchArguments) -> BatchOptions:
    from osm2xodr.batch import BatchOptions, Workers
    from osm2xodr.system import available_jobs

    workers = Workers(arguments.workers or available_jobs(), arguments.scheduler, arguments.max_memory)
    return BatchOptions(workers, arguments.timeout, arguments.shared_frame, arguments.force, arguments.keep_cuts)


class _BatchProgress:
    """Shows on standard error how a batch goes on.

    On terminals (`live`) in one line that is rewritten, on request (`verbose`) in a line for each area as it ends.
    """

    def __init__(self, *, live: bool, verbose: bool) -> None:
        self._live = live
        self._verbose = verbose
        self._began = 0.0
        self._all = self._ended = self._failed = 0
        self._weight = self._done = 0.0

    def stage(self, name: str) -> None:
        """Show the stage that begins."""
        self._line(f"{name} …")

    def begin(self, weights: Sequence[float]) -> None:
        """Begin to count areas; the weights are estimates of their times, in any unit."""
        self._began, self._all, self._weight = time.monotonic(), len(weights), sum(weights)
        self._line(f"0 of {counted(self._all, 'area')}")

    def end(self, result: Result, weight: float) -> None:
        """Count an area that has ended."""
        self._ended += 1
        self._failed += _failed(result)
        self._done += weight
        if self._verbose:
            self.clear()
            memory = f", {result.memory / _GIGABYTE:.1f} GB" if result.memory else ""
            why = f": {result.message}" if result.message else ""
            click.echo(f"{result.seconds:7.2f} s  {result.name} {result.status.value}{memory}{why}", err=True)
        failed = f", {self._failed:,} failed" if self._failed else ""
        self._line(f"{self._ended:,} of {counted(self._all, 'area')}{failed}, {self._left()}")

    def so_far(self) -> str:
        """Return how many areas have ended."""
        return f" after {self._ended:,} of {counted(self._all, 'area')}" if self._all else ""

    def clear(self) -> None:
        """Clear the line."""
        if self._live:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()

    def _left(self) -> str:
        """Return an estimate of the time that is left."""
        seconds = (time.monotonic() - self._began) * (self._weight - self._done) / self._done
        if seconds < 90.0:
            return f"about {max(1.0, seconds):.0f} s left"
        return f"about {seconds / 60.0:.0f} min left" if seconds < 5400.0 else f"about {seconds / 3600.0:.1f} h left"

    def _line(self, text: str) -> None:
        if self._live:
            sys.stderr.write(f"\r\x1b[K{text}")
            sys.stderr.flush()


def _failed(result: Result) -> bool:
    from osm2xodr.batch import Status

    return result.status is Status.FAILED


def _list(planned: Sequence[PlannedArea]) -> int:
    """Print the areas and return the exit status."""
    for item in planned:
        click.echo(f"{item.area.name}: {item.area.osm}" + (" (cut out)" if item.outline is not None else ""))
    return 0


def _report(arguments: BatchArguments, results: Sequence[Result], diagnostics: Diagnostics, seconds: float) -> None:
    """Print the results of the areas."""
    failed = [result for result in results if _failed(result)]
    if not arguments.quiet:
        states = [result.status.value for result in results]
        parts = [f"{states.count(state):,} {state}" for state in ("done", "unchanged", "empty", "failed")]
        counts = ", ".join(part for part in parts if not part.startswith("0 "))
        click.echo(
            f"osm2xodr: {counted(len(results), 'area')} in {seconds:,.1f} s: {counts}; see {arguments.output}",
            err=True,
        )
        for line in details(diagnostics):
            click.echo(line, err=True)
    for result in failed:
        click.echo(f"osm2xodr: error: {result.name}: {result.message}", err=True)
