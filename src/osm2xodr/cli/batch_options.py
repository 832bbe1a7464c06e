"""The areas that the options of ``batch`` ask for, and the options of ``convert`` that areas may have."""

from __future__ import annotations

import difflib
import functools
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click
from click.core import ParameterSource

from osm2xodr.cli.convert import convert
from osm2xodr.cli.options import given_options, usage_errors
from osm2xodr.errors import Osm2xodrError
from osm2xodr.library import DECLARATIONS

if TYPE_CHECKING:
    from osm2xodr.batch import ManifestContext, PlannedArea

# Those that bound a conversion are not handed to it, but to what runs it.
_BOUNDS: Final = frozenset({"max_memory", "timeout"})
# All others the batch decides, or they would have areas write files that it knows nothing of.
_PER_AREA: Final = _BOUNDS | {name for name, declared in DECLARATIONS.items() if declared.per_area}


@dataclass(frozen=True)
class BatchArguments:
    """The options of ``batch`` as click hands them over."""

    manifest: Path | None
    source: Path | None
    tiles: float | None
    areas: Path | None
    dem: tuple[str, ...]
    output: Path
    options: str
    shared_frame: bool
    workers: int | None
    scheduler: str
    max_memory: int | None
    timeout: float | None
    force: bool
    keep_cuts: bool
    dry_run: bool
    verbose: int
    quiet: bool


def refuse_contradictions(arguments: BatchArguments) -> None:
    """Refuse options that contradict each other, with `click.UsageError`."""
    outlines = [option for option, given in (("--tiles", arguments.tiles), ("--areas", arguments.areas)) if given]
    if (arguments.manifest is None) == (arguments.source is None):
        raise click.UsageError("give either a MANIFEST, or a map with --from")
    if arguments.source is not None and len(outlines) != 1:
        raise click.UsageError("--from needs either --tiles, such as --tiles 5km, or --areas FILE")
    if arguments.source is None and outlines:
        raise click.UsageError(f"{outlines[0]} needs a map to cut areas out of; give it with --from")
    if arguments.source is None and arguments.shared_frame:
        raise click.UsageError("--shared-frame needs areas of one map; give it with --from")
    if arguments.scheduler and arguments.workers is not None:
        raise click.UsageError("--workers is for this machine, and --scheduler for others; give one of them")


def area_options() -> dict[str, bool]:
    """Return the long names of the options of ``convert`` that areas may have, and whether each has no value."""
    found = {}
    for param in convert.params:
        if isinstance(param, click.Option) and param.name in _PER_AREA:
            long = max(param.opts, key=len)
            found[long.removeprefix("--")] = param.is_flag
    return found


def check_area_options(words: Sequence[str]) -> tuple[str, ...]:
    """Return options of ``convert`` in the order of its declarations, the last one of each.

    Raises
    ------
    ValueError
        An option is unknown, wrong, or not for areas of a batch.
    """
    return _checked(tuple(words))


@functools.lru_cache
def _checked(words: tuple[str, ...]) -> tuple[str, ...]:
    if not words:
        # Checking options loads the stages, which takes a while.
        return ()
    if {"--help", "-h"} & set(words):
        raise ValueError("--help is not an option of areas; run osm2xodr convert --help")
    try:
        context = convert.make_context("convert", ["area.osm", "-o", "out.xodr", *words])
        _refuse(context)
        _try(dict(context.params))
    except click.NoSuchOption as error:
        near = difflib.get_close_matches(error.option_name.lstrip("-"), area_options(), 1)
        hint = f"; do you mean --{near[0]}?" if near else "; osm2xodr convert --help lists them"
        raise ValueError(f"convert has no option {error.option_name}{hint}") from error
    except click.ClickException as error:
        raise ValueError(error.format_message().rstrip(".")) from error
    out: list[str] = []
    for param in convert.params:
        if param.name not in _PER_AREA:
            continue
        if context.get_parameter_source(param.name) is ParameterSource.COMMANDLINE:
            value = context.params[param.name]
            long = max(param.opts, key=len)
            out += [long] if isinstance(value, bool) else [long, f"{value}"]
    return tuple(out)


def _refuse(context: click.Context) -> None:
    given = {name for name in context.params if context.get_parameter_source(name) is ParameterSource.COMMANDLINE}
    wrong = sorted(given - _PER_AREA - {"area", "output"})
    if context.params["output"] != Path("out.xodr"):
        wrong.insert(0, "output")
    if wrong:
        raise click.UsageError(f"--{wrong[0].replace('_', '-')} cannot be given to areas of a batch; leave it out")


def _try(params: dict[str, Any]) -> None:
    """Refuse options that conversions would refuse."""
    from osm2xodr.library import pipeline_options

    try:
        with usage_errors():
            options = given_options({name: value for name, value in params.items() if name in DECLARATIONS})
            pipeline_options(params["area"], (), options)
    except Osm2xodrError as error:
        raise click.UsageError(str(error)) from error


def parse_options(text: str) -> tuple[str, ...]:
    """Return the words of ``--options``, which must be options of ``convert`` for areas."""
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise click.UsageError(f"--options: {str(error).lower()}; check the quotes") from error
    try:
        check_area_options(words)
    except ValueError as error:
        raise click.UsageError(f"--options: {error}") from error
    return tuple(words)


@dataclass(frozen=True)
class Plan:
    """The areas of a batch, and the bounds of the map, degrees, that tiles are cut out of."""

    areas: list[PlannedArea]
    bounds: tuple[float, float, float, float] | None = None


def plan(arguments: BatchArguments) -> Plan:
    """Return the areas of a batch.

    Raises
    ------
    click.UsageError
        An option is wrong.
    InputError
        The list of areas or the map is wrong or cannot be read.
    """
    from osm2xodr.batch import Area, expand, make_tiles, outlined, read_areas, read_manifest

    given = parse_options(arguments.options)
    # Workers of a scheduler run in other folders.
    base = Path.cwd() if arguments.scheduler else Path()
    dems = expand([str(base / pattern) for pattern in arguments.dem])
    if arguments.manifest is not None:
        return Plan([outlined(area) for area in read_manifest(base / arguments.manifest, _context(dems, given))])
    assert arguments.source is not None
    common = Area("", base / arguments.source, dems, check_area_options(given))
    if arguments.areas is not None:
        return Plan(read_areas(arguments.areas, common))
    from osm2xodr.batch import bounds_of, recall_bounds

    assert arguments.tiles is not None
    bounds = recall_bounds(base / arguments.output, common.osm) or bounds_of(common.osm)
    return Plan(make_tiles(bounds, arguments.tiles, common), bounds)


def _context(dems: tuple[Path, ...], given: tuple[str, ...]) -> ManifestContext:
    from osm2xodr.batch import ManifestContext

    return ManifestContext(area_options(), check_area_options, dems, given)
