"""Says on standard error how far a command is, and about how much longer it takes.

Whatever works calls `stage` and `advance`, which do nothing unless a command shows them. Terminals show one line that
is rewritten. Elsewhere a line is written when a stage begins, and every ten seconds, and none at all by commands that
are done within ten seconds.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Final, TextIO

# Time from which how much longer it takes can be told, s; lines beyond terminals are at least so far apart, and from
# the start of the command, s; those of terminals, s. Choices.
_TELLING: Final = 2.0
_APART: Final = 10.0
_REWRITTEN: Final = 0.1
# Below this share of the work the time that is left is anybody's guess.
_LEAST_SHARE: Final = 0.05


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
