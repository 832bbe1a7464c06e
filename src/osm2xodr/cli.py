"""The command line: options in, messages and an exit status out. Nothing else.

Only what is needed to read options is imported at the top; the stages are loaded when there is work for them.
"""

from __future__ import annotations

import contextlib
import signal
import sys
import time
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from osm2xodr import __version__, defaults
from osm2xodr.delivery import STANDARD_OUTPUT, deliver, label, silence_standard_output
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import Osm2xodrError
from osm2xodr.report import Progress, details, summary
from osm2xodr.xodrWriter import VERSIONS, WriteOptions, check_target

if TYPE_CHECKING:
    from types import FrameType

    from osm2xodr.pipeline import ConvertOptions

OK, CANNOT, INTERRUPTED, TERMINATED = 0, 1, 130, 143

# `osm2xodr.surface.METHODS`, which is too slow to load for --help; a test holds them equal.
SURFACE_METHODS = ("nearest", "bilinear", "bicubic", "polynomial")

_MEGABYTE = 1e6


class _Terminated(BaseException):
    """The system asked the process to end."""


@dataclass
class _Session:
    """What outlives the reading of options: how much to say about a crash."""

    verbose: int = 0


@dataclass(frozen=True)
class _Arguments:
    """The options of ``convert`` as click hands them over."""

    area: Path
    dem: tuple[Path, ...]
    output: Path
    overwrite: bool
    name: str | None
    date: str
    ways: str
    include_private: bool
    xodr_version: str
    left_hand: bool
    right_hand: bool
    default_lane_width: float | None
    surface: str
    polynomial_order: int
    allow_partial: bool
    report_json: Path | None
    verbose: int
    quiet: bool


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status.

    0: done; 1: cannot be done; 2: wrong usage; 130 and 143: interrupted, ended by the system.

    Parameters
    ----------
    arguments
        Without the program's name; by default those of the process.
    """
    session = _Session()
    try:
        with _signals():
            status = cli.main(
                None if arguments is None else list(arguments), "osm2xodr", standalone_mode=False, obj=session
            )
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except click.Abort:
        return _fail("interrupted", INTERRUPTED)
    except _Terminated:
        return _fail("ended by the system", TERMINATED)
    except BrokenPipeError:
        # Whoever read standard output has had enough. Nobody is there to be told.
        silence_standard_output()
        return CANNOT
    except Osm2xodrError as error:
        return _fail(str(error))
    except MemoryError:
        return _fail("the memory is not enough for this area; choose a smaller one, or give only --ways major")
    except Exception as error:
        return _crash(error, session.verbose)
    return status if isinstance(status, int) else OK


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, "--version", message="%(prog)s %(version)s")
def cli() -> None:
    """Turn OpenStreetMap and elevation models into OpenDRIVE road networks."""


@cli.command(
    short_help="Convert an OpenStreetMap file to OpenDRIVE.",
    epilog="""\b
Examples:
  osm2xodr convert area.osm --dem dem.tif -o area.xodr
  osm2xodr convert area.osm.pbf --dem west.tif --dem east.tif -o area.xodr --overwrite
  osm2xodr convert area.osm.gz -o flat.xodr --ways major --xodr-version 1.4
  osm2xodr convert area.osm -o - --ways motorway,motorway_link | gzip > area.xodr.gz

Exit status: 0 written, 1 cannot convert, 2 wrong usage.""",
)
@click.argument("area", type=click.Path(path_type=Path))
@click.option(
    "--dem",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Elevation model: GeoTIFF, HGT or VRT, any CRS. May be repeated; without it the world is flat at 0.",
)
@click.option(
    "-o",
    "--output",
    required=True,
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="OpenDRIVE file to write; - for standard output.",
)
@click.option("--overwrite", is_flag=True, help="Replace files that exist.")
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
    default=defaults.SURFACE_METHOD,
    show_default=True,
    help="How heights between the cells of the elevation model are found.",
)
@click.option(
    "--polynomial-order",
    type=click.IntRange(2, 5),
    metavar="2-5",
    default=defaults.POLYNOMIAL_ORDER,
    show_default=True,
    help="Degree of the trend that fills gaps of the elevation model.",
)
@click.option("--allow-partial", is_flag=True, help="Accept elevation models that cover less than half of the roads.")
@click.option(
    "--report-json",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write all that was guessed, dropped and repaired, each with its OSM id.",
)
@click.option("-v", "--verbose", count=True, help="Say how long each stage takes; -vv: all details, and tracebacks.")
@click.option("-q", "--quiet", is_flag=True, help="Say nothing but errors.")
@click.pass_obj
def convert(session: _Session, /, **options: Any) -> None:
    """Convert AREA, an OpenStreetMap file (.osm, .osm.gz, .osm.bz2, .osm.pbf), to OpenDRIVE."""
    arguments = _Arguments(**options)
    session.verbose = arguments.verbose
    _check_files(arguments)
    live = sys.stderr.isatty() and not arguments.quiet
    progress = Progress(sys.stderr, live=live, verbose=arguments.verbose > 0 and not arguments.quiet)
    began = time.monotonic()
    progress.stage("starting")
    try:
        from osm2xodr.pipeline import convert as run

        wanted = _convert_options(arguments)
        diagnostics = Diagnostics()
        conversion = run(wanted, diagnostics, progress.stage)
        progress.stage(f"writing {label(arguments.output)}")
        name = _area_name(arguments.area) if arguments.name is None else arguments.name
        how = WriteOptions(arguments.xodr_version, name, arguments.date, __version__)
        inputs = _inputs(arguments, name)
        size = deliver(conversion, diagnostics, arguments.output, how, arguments.report_json, inputs)
    finally:
        progress.done()
    if not arguments.quiet:
        seconds = time.monotonic() - began
        click.echo(
            f"osm2xodr: wrote {label(arguments.output)} ({size / _MEGABYTE:,.1f} MB, OpenDRIVE"
            f" {arguments.xodr_version}) in {seconds:,.1f} s",
            err=True,
        )
        for line in summary(conversion.statistics, diagnostics, bool(arguments.dem)):
            click.echo(line, err=True)
        if arguments.verbose > 1:
            for line in details(diagnostics):
                click.echo(line, err=True)


def _check_files(arguments: _Arguments) -> None:
    """Refuse outputs that would do harm or cannot be, before any work is done."""
    if arguments.left_hand and arguments.right_hand:
        raise click.UsageError("--left-hand and --right-hand exclude each other; give one of them")
    inputs = (arguments.area, *arguments.dem)
    targets = [("-o", arguments.output)]
    if arguments.report_json is not None:
        targets.append(("--report-json", arguments.report_json))
        if _same_file(arguments.output, arguments.report_json):
            raise click.UsageError("-o and --report-json name the same file; give two")
    for option, target in targets:
        if target == STANDARD_OUTPUT:
            continue
        check_target(target)
        if any(_same_file(target, item) for item in inputs):
            raise click.UsageError(f"{option} {target} is one of the inputs; give another file")
        if target.is_file() and not arguments.overwrite:
            raise click.UsageError(f"{target} exists; give another file, or --overwrite to replace it")


def _same_file(one: Path, other: Path) -> bool:
    """Whether two paths lead to the same file, be it there or not."""
    try:
        return one.samefile(other)
    except OSError:
        return one.absolute() == other.absolute()


def _convert_options(arguments: _Arguments) -> ConvertOptions:
    """Turn options into those of the stages."""
    from osm2xodr.model import Rule
    from osm2xodr.osmParsing.options import ParseOptions, parse_ways_option
    from osm2xodr.pipeline import ConvertOptions
    from osm2xodr.surface import SurfaceOptions

    rule = Rule.LEFT_HAND if arguments.left_hand else Rule.RIGHT_HAND if arguments.right_hand else None
    try:
        ways = parse_ways_option(arguments.ways)
    except ValueError as error:
        raise click.UsageError(f"--ways: {error}") from error
    try:
        parse = ParseOptions(ways, arguments.include_private, rule, arguments.default_lane_width)
    except ValueError as error:
        raise click.UsageError(f"--default-lane-width: {error}") from error
    surface = SurfaceOptions(arguments.surface, arguments.polynomial_order, arguments.allow_partial)
    return ConvertOptions(arguments.area, arguments.dem, parse, surface)


def _inputs(arguments: _Arguments, name: str) -> dict[str, Any]:
    """Return what was asked for, for the report."""
    return {
        "osm2xodr": __version__,
        "area": str(arguments.area),
        "dem": [str(path) for path in arguments.dem],
        "name": name,
        "ways": arguments.ways,
        "include_private": arguments.include_private,
        "left_hand": True if arguments.left_hand else False if arguments.right_hand else None,
        "default_lane_width": arguments.default_lane_width,
        "surface": arguments.surface,
        "polynomial_order": arguments.polynomial_order,
        "allow_partial": arguments.allow_partial,
    }


def _area_name(area: Path) -> str:
    """Return the name of a file without the endings of OSM files."""
    name = area.name
    for ending in (".gz", ".bz2", ".osm", ".pbf", ".xml", ".osm"):
        name = name.removesuffix(ending)
    return name


def _fail(message: str, status: int = CANNOT) -> int:
    """Say in one line what went wrong and return the exit status."""
    click.echo(f"osm2xodr: error: {' '.join(message.split())}", err=True)
    return status


def _crash(error: Exception, verbose: int) -> int:
    """Apologize for an error that nobody thought of."""
    if verbose > 1:
        traceback.print_exception(error)
    more = "" if verbose > 1 else "; -vv shows where it happened"
    text = " ".join(str(error).split())
    return _fail(
        f"sorry, the conversion stopped at a defect of osm2xodr ({type(error).__name__}: {text});"
        f" please report it with the command and the area{more}"
    )


@contextlib.contextmanager
def _signals() -> Iterator[None]:
    """Turn the wish to end the process into an exception, so that temporary files are cleaned up."""

    def end(number: int, frame: FrameType | None) -> NoReturn:
        raise _Terminated

    before = {}
    for number in (signal.SIGTERM, signal.SIGHUP):
        # Only the main thread may do this, and what is ignored (nohup) stays ignored.
        with contextlib.suppress(ValueError):
            if signal.getsignal(number) is signal.SIG_DFL:
                before[number] = signal.signal(number, end)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
