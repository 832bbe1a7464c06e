"""The options of ``batch``, the areas that they ask for, and the options of ``convert`` that areas may have."""

from __future__ import annotations

import difflib
import functools
import shlex
from dataclasses import field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

import click
from click.core import ParameterSource

from osm2xodr.cli.convert import convert
from osm2xodr.cli.options import PATH, Parsed, given_options, usage_errors
from osm2xodr.errors import Osm2xodrError
from osm2xodr.python_api import DECLARATIONS
from osm2xodr.system import parse_duration, parse_memory, record

if TYPE_CHECKING:
    from osm2xodr.batching import PlannedArea

_Command = TypeVar("_Command")

# Those that bound a conversion are not handed to it, but to what runs it.
_BOUNDS: Final = frozenset({"max_memory", "timeout"})
# All others the batch decides, or they would have areas write files that it knows nothing of.
_PER_AREA: Final = _BOUNDS | {name for name, declared in DECLARATIONS.items() if declared.per_area}


def _length(text: str) -> float:
    from osm2xodr.batching import parse_length

    return parse_length(text)


def _option(*names: str, **how: Any) -> Any:
    """Declare a field that an option of click fills."""
    return field(metadata={"click": click.option(*names, **how)})


@record
class BatchArguments:
    """The options of ``batch``, in the order of its --help."""

    manifest: Path | None = field(metadata={"click": click.argument("manifest", type=PATH, required=False)})
    source: Path | None = _option("--from", "source", type=PATH, metavar="FILE", help="Map to cut areas out of.")
    tiles: float | None = _option(
        "--tiles", type=Parsed("length", _length), metavar="SIDE", help="Cut it into squares, such as 5km."
    )
    areas: Path | None = _option(
        "--areas",
        type=PATH,
        metavar="FILE",
        help="Cut out the polygons of a GeoJSON file, which their property name or id names.",
    )
    dem: tuple[str, ...] = _option(
        "--dem",
        multiple=True,
        metavar="PATTERN",
        help="Elevation models of areas that name none: a file, a pattern such as 'dem/*.tif', or a folder. May be"
        " repeated.",
    )
    output: Path = _option("-o", "--output", type=PATH, metavar="DIR", required=True, help="Folder to write to.")
    options: str = _option(
        "--options", default="", metavar="TEXT", help="Options of convert for all areas, such as '--ways major'."
    )
    corrections: Path | None = _option(
        "--corrections",
        type=PATH,
        metavar="FILE",
        help="What you know better than OpenStreetMap, for all areas; docs/corrections.md describes it.",
    )
    shared_frame: bool = _option(
        "--shared-frame",
        is_flag=True,
        help="Give all areas the same projection, ids of their own, and roads that meet at the borders.",
    )
    surroundings: bool = _option(
        "--surroundings",
        is_flag=True,
        help="Cut out buildings and water as well, for scenes; they change no road network.",
    )
    workers: int | None = _option(
        "--workers",
        "--jobs",
        "workers",
        type=click.IntRange(1),
        metavar="N",
        help="How many areas are converted at once.  [default: one per core]",
    )
    scheduler: str = _option(
        "--scheduler",
        default="",
        metavar="ADDRESS",
        help="Use the workers of a Dask scheduler, such as tcp://host:8786; they need the same osm2xodr, and all"
        " files under the same paths.",
    )
    max_memory: int | None = _option(
        "--max-memory",
        type=Parsed("memory", parse_memory),
        metavar="SIZE",
        help="Memory that an area may take, such as 2G.  [default: an equal share of what is free]",
    )
    timeout: float | None = _option(
        "--timeout",
        type=Parsed("duration", parse_duration),
        metavar="TIME",
        help="Time that an area may take, such as 10min.  [default: no bound]",
    )
    force: bool = _option(
        "--force",
        is_flag=True,
        help="Make everything anew: areas that have not changed, and what is cut out of maps.",
    )
    dry_run: bool = _option("--dry-run", is_flag=True, help="List the areas, and do nothing.")
    verbose: int = _option(
        "-v", "--verbose", count=True, help="Report each area as it ends; -vv: all details, and tracebacks."
    )
    quiet: bool = _option("-q", "--quiet", is_flag=True, help="Say nothing but errors.")


def batch_options(command: _Command) -> _Command:
    """Add the options of ``batch`` to a command."""
    for item in reversed(fields(BatchArguments)):
        command = item.metadata["click"](command)
    return command


def refuse_contradictions(arguments: BatchArguments) -> None:
    """Refuse options that contradict each other, with `click.UsageError`, and a scheduler without Dask."""
    outlines = [option for option, given in (("--tiles", arguments.tiles), ("--areas", arguments.areas)) if given]
    if (arguments.manifest is None) == (arguments.source is None):
        raise click.UsageError("give either a MANIFEST, or a map with --from")
    if arguments.source is not None and len(outlines) != 1:
        raise click.UsageError("--from needs either --tiles, such as --tiles 5km, or --areas FILE")
    if arguments.source is None and outlines:
        raise click.UsageError(f"{outlines[0]} needs a map to cut areas out of; give it with --from")
    if arguments.source is None and arguments.shared_frame:
        raise click.UsageError("--shared-frame needs areas of one map; give it with --from")
    if arguments.scheduler:
        from osm2xodr.batching import check_dask

        check_dask()
    if arguments.scheduler and arguments.workers is not None:
        raise click.UsageError("--workers is for this machine, and --scheduler for others; give one of them")


def area_options() -> dict[str, bool]:
    """Return the long names of the options of ``convert`` that areas may have, and whether each has no value."""
    options = [item for item in convert.params if isinstance(item, click.Option) and item.name in _PER_AREA]
    return {max(item.opts, key=len).removeprefix("--"): item.is_flag for item in options}


@functools.lru_cache
def check_area_options(words: tuple[str, ...], has_dem: bool) -> tuple[str, ...]:
    """Return options of ``convert`` in the order of its declarations, the last one of each.

    `has_dem` says whether the area has elevation models. ValueError: an option is unknown, wrong, or not for areas of
    a batch.
    """
    if not words:
        # Checking options loads the stages, which takes a while.
        return ()
    if {"--help", "-h"} & set(words):
        raise ValueError("--help is not an option of areas; run osm2xodr convert --help")
    try:
        context = convert.make_context("convert", ["area.osm", "-o", "out.xodr", *words])
        given = {name for name in context.params if context.get_parameter_source(name) is ParameterSource.COMMANDLINE}
        wrong = sorted(given - _PER_AREA - {"area", "output"})
        if context.params["output"] != Path("out.xodr"):
            wrong.insert(0, "output")
        if wrong:
            raise click.UsageError(
                f"--{wrong[0].replace('_', '-')} cannot be given to areas of a batch; leave it out"
            )
        _try(context.params, has_dem)
    except click.NoSuchOption as error:
        near = difflib.get_close_matches(error.option_name.lstrip("-"), area_options(), 1)
        hint = f"; do you mean --{near[0]}?" if near else "; osm2xodr convert --help lists them"
        raise ValueError(f"convert has no option {error.option_name}{hint}") from error
    except click.ClickException as error:
        raise ValueError(error.format_message().rstrip(".")) from error
    out: list[str] = []
    for param in convert.params:
        if param.name in given & _PER_AREA:
            value = context.params[param.name]
            long = max(param.opts, key=len)
            out += [long] if isinstance(value, bool) else [long, f"{value}"]
    return tuple(out)


def _try(params: dict[str, Any], has_dem: bool) -> None:
    """Refuse options that conversions would refuse."""
    from osm2xodr.python_api import pipeline_options

    try:
        with usage_errors():
            options = given_options({name: value for name, value in params.items() if name in DECLARATIONS})
            pipeline_options(params["area"], (Path("dem.tif"),) if has_dem else (), options)
    except Osm2xodrError as error:
        raise click.UsageError(str(error)) from error


def parse_options(text: str) -> tuple[str, ...]:
    """Return the words of ``--options``, which must be options of ``convert`` for areas."""
    try:
        words = tuple(shlex.split(text))
    except ValueError as error:
        raise click.UsageError(f"--options: {str(error).lower()}; check the quotes") from error
    try:
        # Which areas have elevation models is not known yet.
        check_area_options(words, True)
    except ValueError as error:
        raise click.UsageError(f"--options: {error}") from error
    return words


@record
class Plan:
    """The areas of a batch, and the bounds of the map, degrees, that tiles are cut out of."""

    areas: list[PlannedArea]
    bounds: tuple[float, float, float, float] | None = None


def plan(arguments: BatchArguments) -> Plan:
    """Return the areas of a batch.

    Raises `click.UsageError` if an option is wrong, `InputError` if the list of areas or the map is.
    """
    from osm2xodr.batching import (
        Area,
        ManifestContext,
        bounds_of,
        make_tiles,
        outlined,
        read_areas,
        read_manifest,
        recall_bounds,
    )
    from osm2xodr.surface import expand

    given = parse_options(arguments.options)
    # Workers of a scheduler run in other folders.
    base = Path.cwd() if arguments.scheduler else Path()
    dems = expand([str(base / pattern) for pattern in arguments.dem])
    if arguments.manifest is not None:
        context = ManifestContext(area_options(), check_area_options, dems, given)
        return Plan([outlined(area) for area in read_manifest(base / arguments.manifest, context)])
    assert arguments.source is not None
    try:
        options = check_area_options(given, bool(dems))
    except ValueError as error:
        raise click.UsageError(f"--options: {error}") from error
    common = Area("", base / arguments.source, dems, options)
    if arguments.areas is not None:
        return Plan(read_areas(arguments.areas, common))
    assert arguments.tiles is not None
    bounds = recall_bounds(base / arguments.output, common.osm) or bounds_of(common.osm)
    return Plan(make_tiles(bounds, arguments.tiles, common, in_blocks=arguments.shared_frame), bounds)
