"""The command ``batch``: its progress and its messages."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from osm2xodr.cli.batch_options import BatchArguments, Plan, batch_options, plan, refuse_contradictions
from osm2xodr.cli.options import Session
from osm2xodr.diagnostics import Diagnostics, counted
from osm2xodr.reporting import details
from osm2xodr.system import Progress

if TYPE_CHECKING:
    from osm2xodr.batching import Listener, Result

_FAILED, _INTERRUPTED = 1, 130
_GIGABYTE = 1e9


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
@batch_options
@click.pass_obj
def batch(session: Session, /, **options: Any) -> int:
    """Convert many areas: those that MANIFEST (.toml, .csv) lists, or those cut out of one map."""
    arguments = BatchArguments(**options)
    session.verbose = arguments.verbose
    refuse_contradictions(arguments)
    progress = _BatchProgress(quiet=arguments.quiet, verbose=bool(arguments.verbose))
    try:
        progress.stage("reading the list of areas")
        planned = plan(arguments)
        progress.clear()
        if not arguments.dry_run:
            return _run(arguments, planned, progress)
        for item in planned.areas:
            click.echo(f"{item.area.name}: {item.area.osm}" + (" (cut out)" if item.outline is not None else ""))
        return 0
    except KeyboardInterrupt:
        progress.clear()
        click.echo(f"osm2xodr: error: interrupted{progress.so_far()}; the same command goes on", err=True)
        return _INTERRUPTED
    finally:
        progress.clear()


def _run(arguments: BatchArguments, planned: Plan, progress: _BatchProgress) -> int:
    """Run a batch, report its results, and return the exit status."""
    began = time.monotonic()
    own = frozenset(name for param in batch.params for name in param.opts)
    results, diagnostics = run(arguments, planned, progress, own)
    progress.clear()
    _report(arguments, results, diagnostics, time.monotonic() - began)
    return _FAILED if any(_failed(result) for result in results) else 0


def run(
    arguments: BatchArguments, planned: Plan, listener: Listener, own: frozenset[str]
) -> tuple[list[Result], Diagnostics]:
    """Run a batch, and return the results of its areas and what is to be said of it.

    `own` are the names of the options of the command that runs it, such as ``--workers``; none where there is none.
    """
    from osm2xodr.batching import BatchOptions, Workers, keep_bounds, open_out_dir, run_batch, write_summary
    from osm2xodr.cli import area_server
    from osm2xodr.model import Corrections
    from osm2xodr.python_api import read_corrections
    from osm2xodr.system import available_jobs

    diagnostics = Diagnostics()
    workers = Workers(
        area_server.__name__, arguments.workers or available_jobs(), arguments.scheduler, arguments.max_memory
    )
    known, corrections = arguments.corrections, Corrections()
    if known is not None:
        # Workers of a scheduler run in other folders.
        known = Path.cwd() / known if arguments.scheduler else known
        corrections = read_corrections(known, shared=True)
    how = BatchOptions(
        workers,
        arguments.timeout,
        arguments.shared_frame,
        arguments.force,
        known,
        corrections,
        arguments.surroundings,
        own,
    )
    output = Path.cwd() / arguments.output if arguments.scheduler else arguments.output
    with open_out_dir(output) as out:
        if planned.bounds is not None:
            keep_bounds(output, planned.areas[0].area.osm, planned.bounds)
        results = run_batch(planned.areas, out, how, diagnostics, listener)
        listener.stage("writing the summary")
        write_summary(output, results)
    return results, diagnostics


class _BatchProgress:
    """Shows on standard error how a batch goes on.

    On terminals in one line that is rewritten, elsewhere in one every ten seconds; on request (`verbose`) in a line
    for each area as it ends.
    """

    def __init__(self, *, quiet: bool, verbose: bool) -> None:
        self._line = Progress(sys.stderr, quiet=quiet, verbose=verbose)
        self._verbose = verbose
        self._began = 0.0
        self._all = self._ended = self._failed = 0
        self._weight = self._done = 0.0

    def stage(self, name: str) -> None:
        """Show the stage that begins."""
        self._line.show(name, None, self._line.now())

    def begin(self, areas: int) -> None:
        """Begin to count areas."""
        self._all = areas

    def settle(self, ended: int, failed: int) -> None:
        """Count areas that need no conversion."""
        self._ended, self._failed = ended, failed

    def convert(self, weights: Sequence[float]) -> None:
        """Count conversions; the weights are estimates of their times, in any unit."""
        self._began, self._weight, self._done = self._line.now(), sum(weights), 0.0
        self._line.show(self._count(), 0.0, self._began)

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
        self._line.show(self._count(), self._done / self._weight if self._weight else None, self._began)

    def so_far(self) -> str:
        """Return how many areas have ended."""
        return f" after {self._ended:,} of {counted(self._all, 'area')}" if self._all else ""

    def clear(self) -> None:
        """Clear the line."""
        self._line.clear()

    def _count(self) -> str:
        """Return how many of all areas have ended."""
        failed = f", {self._failed:,} failed" if self._failed else ""
        return f"{self._ended:,} of {counted(self._all, 'area')}{failed}"


def _failed(result: Result) -> bool:
    from osm2xodr.batching import Status

    return result.status is Status.FAILED


def _report(arguments: BatchArguments, results: Sequence[Result], diagnostics: Diagnostics, seconds: float) -> None:
    """Print the results of the areas."""
    if not arguments.quiet:
        states = [result.status.value for result in results]
        parts = [f"{states.count(state):,} {state}" for state in ("done", "unchanged", "empty", "failed")]
        counts = ", ".join(part for part in parts if not part.startswith("0 "))
        found = f"{counted(len(results), 'area')} in {seconds:,.1f} s: {counts}"
        for line in (f"osm2xodr: {found}; see {arguments.output}", *details(diagnostics)):
            click.echo(line, err=True)
    for result in filter(_failed, results):
        click.echo(f"osm2xodr: error: {result.name}: {result.message}", err=True)
