"""What the commands of the command line share."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import click

from osm2xodr.system import STANDARD_OUTPUT, check_target, limited, parse_duration, parse_memory

_Command = TypeVar("_Command", bound=Callable[..., Any])


@dataclass
class Session:
    """What outlives the reading of options: how much to say about a crash, and what the command could not do."""

    verbose: int = 0
    error: Exception | None = None


overwrite_option = click.option("--overwrite", is_flag=True, help="Replace files that exist.")


def output_option(what: str) -> Callable[[_Command], _Command]:
    """Return the option -o, which names the file of some kind that a command writes."""
    return click.option(
        "-o",
        "--output",
        required=True,
        type=click.Path(path_type=Path),
        metavar="FILE",
        help=f"{what} to write; - for standard output.",
    )


class Parsed(click.ParamType):  # type: ignore[type-arg,unused-ignore]
    """An option whose text a function reads."""

    def __init__(self, name: str, parse: Callable[[str], float]) -> None:
        self.name = name
        self._parse = parse

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read the text, and refuse what the function refuses."""
        try:
            return self._parse(value)
        except ValueError as error:
            self.fail(str(error), param, ctx)


def limit_options(command: _Command) -> _Command:
    """Give a command the options that bound its memory and time; it does not see them itself."""

    @click.option(
        "--max-memory",
        type=Parsed("memory", parse_memory),
        metavar="SIZE",
        help="Stop if a process needs more memory, such as 2G.  [default: no bound]",
    )
    @click.option(
        "--timeout",
        type=Parsed("duration", parse_duration),
        metavar="TIME",
        help="Stop after a while, such as 90s or 10min.  [default: no bound]",
    )
    @functools.wraps(command)
    def bounded(*args: Any, max_memory: int | None, timeout: float | None, **options: Any) -> Any:
        with limited(max_memory, timeout):
            return command(*args, **options)

    return bounded  # type: ignore[return-value]


def check_targets(targets: Sequence[tuple[str, Path]], inputs: Sequence[Path], *, overwrite: bool) -> None:
    """Refuse outputs that would do harm or cannot be, before any work is done.

    Parameters
    ----------
    targets
        Each with the option that names it.
    inputs
        Files that must not be overwritten.
    overwrite
        Whether files that exist may be replaced.

    Raises
    ------
    click.UsageError
        Two outputs are the same file, one is an input or exists.
    OutputError
        A target cannot be written.
    """
    for k, (option, target) in enumerate(targets):
        for other_option, other in targets[:k]:
            if _same_file(target, other):
                raise click.UsageError(f"{other_option} and {option} name the same file; give two")
    for option, target in targets:
        if target == STANDARD_OUTPUT:
            continue
        check_target(target)
        if any(_same_file(target, item) for item in inputs):
            raise click.UsageError(f"{option} {target} is one of the inputs; give another file")
        if target.is_file() and not overwrite:
            raise click.UsageError(f"{target} exists; give another file, or --overwrite to replace it")


def _same_file(one: Path, other: Path) -> bool:
    """Whether two paths lead to the same file, be it there or not."""
    try:
        return one.samefile(other)
    except OSError:
        return one.absolute() == other.absolute()
