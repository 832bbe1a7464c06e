"""Options and checks that several commands share."""

from __future__ import annotations

import contextlib
import functools
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, TypeVar

import click

from osm2xodr.conventions import Declaration
from osm2xodr.errors import OptionError
from osm2xodr.python_api import DECLARATIONS, ConvertOptions
from osm2xodr.system import STANDARD_OUTPUT, check_target, limited, parse_duration, parse_memory

if TYPE_CHECKING:
    from osm2xodr.pipeline import Layouts

_Command = TypeVar("_Command", bound=Callable[..., Any])

_ADDRESS: Final = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+://")


class _LocalPath(click.Path):
    """The type of a file: an address is refused in its own spelling, which a path would take for a folder."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path."""
        if isinstance(value, str) and _ADDRESS.match(value):
            self.fail(f"{value} is an address, and files are read from disk alone; download it first", param, ctx)
        return super().convert(value, param, ctx)


PATH: Final = _LocalPath(path_type=Path)
# Endings of files that stand for themselves after elevation models, in small letters: maps, road networks, lists.
_NO_MODELS: Final = frozenset({"", ".osm", ".pbf", ".gz", ".bz2", ".xml", ".xodr", ".toml", ".csv"})
# Options that have another name on the command line than in Python.
_SPELLINGS: Final = MappingProxyType({"readers": "for"})


@dataclass
class Session:
    """What a command hands to the code around it."""

    verbose: int = 0  # How much to say about an internal error
    error: BaseException | None = None  # The error that the command ended with
    message: str = ""  # Why it failed, in one sentence; empty if it did not
    # Takes that sentence, in a copy of the process, where the process is killed for want of time; None to print it
    last_words: Callable[[str], None] | None = None
    layouts: Layouts | None = None  # Keeps the roads of a block of areas for the next command


file_argument = click.argument("file", type=PATH)
overwrite_option = click.option("--overwrite", is_flag=True, help="Replace files that exist.")
quiet_option = click.option("-q", "--quiet", is_flag=True, help="Say nothing but errors.")


def output_option(what: str) -> Callable[[_Command], _Command]:
    """Return the option -o, the file of some kind that a command writes."""
    return click.option(
        "-o", "--output", required=True, type=PATH, metavar="FILE", help=f"{what} to write; - for standard output."
    )


def declared_options(names: Iterable[str]) -> Callable[[_Command], _Command]:
    """Return a decorator that adds declared options of a conversion to a command."""

    def add(command: _Command) -> _Command:
        for name in reversed(list(names)):
            command = _click_option(name, DECLARATIONS[name])(command)
        return command

    return add


def _click_option(name: str, declared: Declaration) -> Callable[[_Command], _Command]:
    flag = f"--{name.replace('_', '-')}"
    if declared.kind is bool:
        return click.option(flag, is_flag=True, help=declared.help)
    kind: Any = declared.kind
    if declared.choices:
        kind = click.Choice(declared.choices)
    elif kind is int:
        kind = click.IntRange(declared.least, declared.most)
    elif kind is Path:
        kind = PATH
    shown = declared.default not in (None, "")
    return click.option(
        flag, type=kind, default=declared.default, show_default=shown, metavar=declared.metavar, help=declared.help
    )


def given_options(values: Mapping[str, Any]) -> ConvertOptions:
    """Return the options of a conversion as click hands them over; a flag that is not there says nothing."""
    return ConvertOptions(**{name: value for name, value in values.items() if value is not False})


class DemCommand(click.Command):
    """A command whose option --dem takes several files at once: click gives an option one."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the arguments."""
        return super().parse_args(ctx, _each_its_dem(args))


def _each_its_dem(args: Sequence[str]) -> list[str]:
    """Return arguments with --dem before each of the elevation models that follow it."""
    out: list[str] = []
    # Whether the next word is the value of --dem, and whether further ones may be.
    value = more = False
    for place, word in enumerate(args):
        if word == "--":
            return [*out, *args[place:]]
        if value:
            value, more = False, True
        elif word.startswith("-"):
            value, more = word == "--dem", word.startswith("--dem=")
        elif more and (Path(word).suffix.lower() not in _NO_MODELS or Path(word).is_dir()):
            out.append("--dem")
        else:
            more = False
        out.append(word)
    return out


def dem_option(what: str) -> Callable[[_Command], _Command]:
    """Return the option --dem, elevation models for some purpose."""
    text = (
        f"{what}: files, patterns such as 'dem/*.tif', folders; GeoTIFF, HGT, ASC, IMG, VRT, or these in zip files."
    )
    return click.option("--dem", multiple=True, type=PATH, metavar="FILE...", help=text)


@contextlib.contextmanager
def usage_errors() -> Iterator[None]:
    """Turn the refusal of an option into wrong usage, in the spelling of the command line."""
    try:
        yield
    except OptionError as error:
        text = str(error)
        for name in error.options:
            text = re.sub(rf"\b{name}\b", f"--{_SPELLINGS.get(name, name).replace('_', '-')}", text, count=1)
        raise click.UsageError(text) from error


class Parsed(click.ParamType):  # type: ignore[type-arg,unused-ignore]
    """The type of an option whose text a function parses, raising ValueError."""

    def __init__(self, name: str, parse: Callable[[str], float]) -> None:
        self.name = name
        self._parse = parse

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Parse the text."""
        try:
            return self._parse(value)
        except ValueError as error:
            self.fail(str(error), param, ctx)


def limit_options(command: _Command) -> _Command:
    """Add options that bound the memory and time of a command, which does not see them itself."""

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
        remedy = ["choose a smaller area, or give only --ways major"] if "ways" in options else []
        session = click.get_current_context().find_object(Session) or Session()
        with limited(max_memory, timeout, *remedy, last_words=session.last_words), usage_errors():
            return command(*args, **options)

    return bounded  # type: ignore[return-value]


def check_targets(targets: Sequence[tuple[str, Path]], inputs: Sequence[Path], *, overwrite: bool) -> None:
    """Refuse outputs that would do harm or cannot be written, before any work is done.

    `targets` come with the options that name them. `inputs` must not be overwritten, and other files that exist only
    if `overwrite` says so. Raises `click.UsageError` if two outputs are the same file, or one is an input or exists,
    and `OutputError` if one cannot be written.
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
    """Return whether two paths lead to the same file, existing or not."""
    try:
        return one.samefile(other)
    except OSError:
        return one.absolute() == other.absolute()
