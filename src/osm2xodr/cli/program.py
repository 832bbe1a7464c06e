"""The command line: its commands, and what becomes of errors.

Modules of commands are loaded for the command that is given, and import at their top only what reading options needs;
the stages are loaded when there is work. The command ``completion`` makes shells complete commands and options.
"""

from __future__ import annotations

import atexit
import contextlib
import errno
import gc
import importlib
import signal
import sys
import traceback
from collections import UserDict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NoReturn

import click

from osm2xodr import __version__
from osm2xodr.cli.options import Session
from osm2xodr.errors import Osm2xodrError
from osm2xodr.system import (
    ENDING_SIGNALS,
    STANDARD_OUTPUT,
    occupy_closed_streams,
    own_process,
    patient_standard_error,
    silence_standard_output,
    stream_to,
)

if TYPE_CHECKING:
    from types import FrameType


OK, CANNOT, INTERRUPTED, TERMINATED = 0, 1, 130, 143

SHELLS = ("bash", "zsh", "fish")
# The variable by which shells ask for words.
_VARIABLE = "_OSM2XODR_COMPLETE"

# What is loaded is no garbage, but Python would search it for reference cycles after every 700 new objects, and all
# modules several times when the process ends.
gc.set_threshold(100_000)
atexit.register(gc.freeze)

# Where the documents are: in a checkout, in an installation.
_DOCUMENTS = (Path(__file__).parents[3] / "docs", Path(sys.prefix) / "share" / "doc" / "osm2xodr")

# Errors of standard streams that are closed, or that lead to a full disk or a dead device.
_STREAM_ERRORS = frozenset({errno.EBADF, errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO})
# What the C library says of libraries for which there is no room.
_NOT_MAPPED: Final = ("failed to map segment", "cannot allocate memory", "Cannot allocate memory")


class _Terminated(BaseException):
    """The system asked the process to end."""


def main(arguments: Sequence[str] | None = None, session: Session | None = None) -> int:
    """Run the command line and return its exit status; `session` receives why a command failed.

    0: done; 1: cannot be done; 2: wrong usage; 130 and 143: interrupted, ended by the system.
    """
    occupy_closed_streams()
    session = session or Session()
    with patient_standard_error():
        own_process()
        try:
            with _signals():
                status = cli.main(arguments, "osm2xodr", standalone_mode=False, obj=session)
            return status if isinstance(status, int) else OK
        except click.ClickException as error:
            session.message = error.format_message()
            error.show()
            return error.exit_code
        except (Exception, _Terminated) as error:
            session.error = error
            session.message, status = _ended(error, session.verbose)
            if session.message:
                click.echo(f"osm2xodr: error: {session.message}", err=True)
            return status


def _ended(error: BaseException, verbose: int) -> tuple[str, int]:
    """Return in one line why an error ends a command, empty if that need not be said, and the exit status."""
    # Up to 3.11 Python wraps what interrupts it while it makes a class.
    kinds = error, error.__cause__ if isinstance(error, Exception) else None
    if any(isinstance(item, (click.Abort, KeyboardInterrupt)) for item in kinds):
        return "interrupted", INTERRUPTED
    if any(isinstance(item, _Terminated) for item in kinds):
        return "ended by the system", TERMINATED
    if isinstance(error, BrokenPipeError):
        # Whoever read standard output has gone, as `head` does. That is no error to report.
        silence_standard_output()
        return "", CANNOT
    if isinstance(error, Osm2xodrError):
        reason = str(error)
    elif isinstance(error, MemoryError):
        reason = "the memory is not enough for this area; choose a smaller one, or give only --ways major"
    else:
        reason = _refused_by_system(error, verbose) if isinstance(error, OSError) else _crash(error, verbose)
    return " ".join(reason.split()), CANNOT


class _Commands(UserDict[str, Any]):
    """The commands by name, in the order of the manual, with the modules that they are in; loaded when asked for."""

    def __getitem__(self, name: str) -> click.Command:
        command: click.Command = getattr(importlib.import_module(f"osm2xodr.cli.{self.data[name]}"), name)
        return command


class _Program(click.Group):
    """The program, which says what to do with a file in place of a command."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write where the documents are, which messages name by their place in docs."""
        for folder in _DOCUMENTS:
            if (folder / "check.md").is_file():
                formatter.write_paragraph()
                formatter.write_text(f"Documents (docs): {folder}")
                return

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command."""
        name = args[0]
        if self.get_command(ctx, name) is None and (Path(name).suffix or Path(name).exists()):
            command = "check" if name.lower().endswith((".xodr", ".xodr.gz")) else "convert"
            rest = "" if command == "check" else " -o area.xodr"
            ctx.fail(f"{name} is no command; write osm2xodr {command} {name}{rest}")
        return super().resolve_command(ctx, args)


_COMMANDS: Final = _Commands(
    fetch="fetch",
    convert="convert",
    start="start",
    batch="batches",
    check="check",
    report="views",
    render="views",
    surface="views",
    locate="locate",
    export="export",
    crop="parts",
    merge="parts",
    explain="check",
    completion="program",
)


@click.group(
    cls=_Program,
    commands=_COMMANDS,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(__version__, "--version", message="%(prog)s %(version)s")
def cli() -> None:
    """Turn OpenStreetMap and elevation models into OpenDRIVE road networks."""


def _refused_by_system(error: OSError, verbose: int) -> str:
    """Return what the system refused."""
    reason = (error.strerror or str(error)).lower()
    if error.errno == errno.EMFILE:
        return f"{reason}; allow more of them (ulimit -n)"
    if error.filename is not None:
        if verbose > 1:
            traceback.print_exception(error)
        return f"{error.filename} cannot be used: {reason}; check the path"
    if error.errno not in _STREAM_ERRORS:
        return _crash(error, verbose)
    silence_standard_output()
    return f"standard input or output cannot be used: {reason}"


def _crash(error: BaseException, verbose: int) -> str:
    """Return how an unexpected error is reported; print its traceback on request."""
    # Libraries are loaded when they are needed.
    if isinstance(error, ImportError) and any(words in str(error) for words in _NOT_MAPPED):
        return "the memory is not enough to load the libraries; allow more (ulimit -v, ulimit -d)"
    if verbose > 1:
        traceback.print_exception(error)
    what = f"internal error ({type(error).__name__}: {error}); please report it with the command and the area"
    return what + ("" if verbose > 1 else "; -vv shows where it happened")


@contextlib.contextmanager
def _signals() -> Iterator[None]:
    """Turn the signals that end the process into an exception, so that temporary files are cleaned up."""

    def end(number: int, frame: FrameType | None) -> NoReturn:
        raise _Terminated

    before = {}
    for number in ENDING_SIGNALS:
        # Only the main thread may set handlers, and signals that are ignored (nohup) stay ignored.
        with contextlib.suppress(ValueError):
            if signal.getsignal(number) is signal.SIG_DFL:
                before[number] = signal.signal(number, end)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@click.command(
    short_help="Print what makes a shell complete commands and options.",
    epilog="""\b
Examples:
  osm2xodr completion bash > ~/.local/share/bash-completion/completions/osm2xodr
  osm2xodr completion zsh > ~/.zfunc/_osm2xodr
  osm2xodr completion fish > ~/.config/fish/completions/osm2xodr.fish

Exit status: 0 printed, 2 wrong usage, 130 interrupted.""",
)
@click.argument("shell", type=click.Choice(SHELLS))
@click.pass_context
def completion(context: click.Context, shell: str) -> None:
    """Print the script that makes SHELL (bash from 4.4 on, zsh, fish) complete commands, options and files."""
    # Here, so that other commands start without it.
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    assert kind is not None
    script = kind(context.find_root().command, {}, "osm2xodr", _VARIABLE)
    with stream_to(STANDARD_OUTPUT) as stream:
        # Not by `source`, which asks the shell for its version: it need not be installed here.
        stream.write((script.source_template % script.source_vars()).encode())
