"""Standard streams: closed or full ones must not spoil what is written elsewhere; progress goes to standard error."""

from __future__ import annotations

import contextlib
import io
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Final, TextIO

# Numbers of the standard streams and the modes of their substitutes: input for writing and output for reading, so
# that whoever needs the stream gets an error. Messages on standard error may be lost.
_SUBSTITUTES: Final = ((0, os.O_WRONLY), (1, os.O_RDONLY), (2, os.O_WRONLY))

# Time from which how much longer it takes can be told, s; lines beyond terminals are at least so far apart, and from
# the start of the command, s; those of terminals, s. Choices.
_TELLING: Final = 2.0
_APART: Final = 10.0
_REWRITTEN: Final = 0.1
# Below this share of the work the time that is left is anybody's guess.
_LEAST_SHARE: Final = 0.05


class _Patient(io.TextIOBase):
    """Standard error that loses text on a full disk or a closed pipe instead of raising an error."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write `text`, or lose it."""
        with contextlib.suppress(OSError, ValueError):
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Write what is buffered, or lose it."""
        # Called once more as the interpreter ends, when modules are gone.
        try:  # noqa: SIM105
            self._stream.flush()
        except (OSError, ValueError):
            pass

    def isatty(self) -> bool:
        """Return whether it is a terminal."""
        return self._stream.isatty()

    def fileno(self) -> int:
        """Return the file descriptor."""
        return self._stream.fileno()

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """Name of the encoding."""
        return self._stream.encoding

    @property
    def errors(self) -> str | None:  # type: ignore[override]
        """How letters are treated that the encoding lacks."""
        return self._stream.errors


def occupy_closed_streams() -> None:
    """Open a substitute for each standard stream that is closed.

    Otherwise the next file that is opened gets its number, and all that libraries print goes into that file.
    """
    for number, flags in _SUBSTITUTES:
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, flags)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
    # Python sets the streams to None that were closed when it started.
    if sys.stdin is None:
        sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115
    if sys.stdout is None:
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    if sys.stderr is None:
        sys.stderr = open(2, "w", encoding="utf-8", errors="backslashreplace", closefd=False)  # noqa: SIM115


@contextlib.contextmanager
def patient_standard_error() -> Iterator[None]:
    """Let no failing message on standard error stop the work in the block."""
    before = sys.stderr
    sys.stderr = _Patient(before)
    try:
        yield
    finally:
        sys.stderr = before


class Progress:
    """What a command shows of its progress.

    `plan` has the stages in order, by how their names begin, and about what share of the time each takes, in any
    unit.
    Whoever is `quiet` sees nothing; who is `verbose` a line with the time of each stage when it ends.
    """

    def __init__(
        self,
        stream: TextIO,
        *,
        quiet: bool = False,
        verbose: bool = False,
        plan: Sequence[tuple[str, float]] = (),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.is_silent = quiet
        self._stream = stream
        self._live = stream.isatty() and not quiet
        self._plain = not (self._live or quiet or verbose)
        self._verbose = verbose and not quiet
        self._plan = plan
        self._clock = clock
        self._process = os.getpid()
        self._start = self._printed = clock()
        self._at = -1
        self._stage = ""
        self._began = 0.0
        self._written = False  # Whether there is a line to clear

    def stage(self, name: str) -> None:
        """End the stage that runs, and begin another one."""
        self.done()
        self._stage, self._began = name, self._clock()
        later = range(self._at + 1, len(self._plan))
        self._at = next((k for k in later if name.startswith(self._plan[k][0])), self._at)
        self._print(name, self._share(0.0), self._start, at_once=True)

    def advance(self, part: float) -> None:
        """Say which part of the stage that runs is done, 0 to 1."""
        if self._stage:
            self._print(self._stage, self._share(part), self._start)

    def show(self, text: str, share: float | None, start: float) -> None:
        """Show a text about something of which a share is done since `start`, a time of the clock, s."""
        self._print(text, share, start)

    def now(self) -> float:
        """Return the time of the clock, s."""
        return self._clock()

    def done(self) -> None:
        """End the stage that runs, if any, and clear its line."""
        if self._process != os.getpid():
            return
        self.clear()
        if self._stage and self._verbose:
            self._stream.write(f"{self._clock() - self._began:7.2f} s  {self._stage}\n")
        self._stream.flush()
        self._stage = ""

    def clear(self) -> None:
        """Clear the line, if there is one: it may be another's by now."""
        if self._written:
            self._stream.write("\r\x1b[K")
            self._stream.flush()
        self._written = False

    def _share(self, part: float) -> float | None:
        """Return what share of all stages is done."""
        if self._at < 0:
            return None
        weights = [weight for _, weight in self._plan]
        return (sum(weights[: self._at]) + min(max(part, 0.0), 1.0) * weights[self._at]) / sum(weights)

    def _print(self, text: str, share: float | None, start: float, *, at_once: bool = False) -> None:
        """Write a line if it is time for one; copies of the process stay silent."""
        if not (self._live or self._plain) or self._process != os.getpid():
            return
        now = self._clock()
        if self._live and (at_once or now - self._printed >= _REWRITTEN):
            self._stream.write(f"\r\x1b[K{text} …{_state(share, now - start)}")
            self._written = True
        elif self._plain and now - self._start >= _APART and (at_once or now - self._printed >= _APART):
            self._stream.write(f"osm2xodr: {text}{_state(share, now - start)}\n")
        else:
            return
        self._printed = now
        self._stream.flush()


def _state(share: float | None, seconds: float) -> str:
    """Return what is done and about how much longer the rest takes, after so many seconds."""
    if share is None:
        return ""
    done = f" {100.0 * share:.0f} %"
    if seconds < _TELLING or share < _LEAST_SHARE or share >= 1.0:
        return done
    return f"{done}, {time_left(seconds * (1.0 - share) / share)}"


def time_left(seconds: float) -> str:
    """Return how long something still takes, in words."""
    if seconds < 90.0:
        return f"about {max(1.0, seconds):.0f} s left"
    return f"about {seconds / 60.0:.0f} min left" if seconds < 5400.0 else f"about {seconds / 3600.0:.1f} h left"


# What is shown; the last one counts.
_shown: list[Progress] = []


@contextmanager
def shown(progress: Progress) -> Iterator[Progress]:
    """Let `stage` and `advance` show what they are told, unless nobody is to see it."""
    if progress.is_silent:
        yield progress
        return
    _shown.append(progress)
    try:
        yield progress
    finally:
        _shown.remove(progress)
        progress.done()


def stage(name: str) -> None:
    """Say that a stage of the work begins."""
    if _shown:
        _shown[-1].stage(name)


def advance(part: float) -> None:
    """Say which part of the stage is done, 0 to 1."""
    if _shown:
        _shown[-1].advance(part)
