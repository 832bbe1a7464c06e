"""Bounds on what one run of a command may use: memory and time."""

from __future__ import annotations

import contextlib
import faulthandler
import os
import re
import select
import signal
from collections.abc import Iterator
from types import FrameType
from typing import Final, NoReturn

from osm2xodr.errors import Osm2xodrError

_UNITS: Final = {"": 1, "K": 10**3, "M": 10**6, "G": 10**9, "KI": 2**10, "MI": 2**20, "GI": 2**30}
_SECONDS: Final = {"": 1.0, "s": 1.0, "min": 60.0, "m": 60.0, "h": 3600.0}
# Below this the interpreter and its libraries do not even start, bytes.
LEAST_MEMORY: Final = 200_000_000
# How long libraries may go on after the time is up before the process is ended from outside, s.
_GRACE: Final = 3.0


class LimitError(Osm2xodrError):
    """A run used more than it was allowed to."""


def parse_memory(text: str) -> int:
    """Read an amount of memory such as ``2G``, ``1500MB`` or ``1.5GiB``, bytes.

    Raises
    ------
    ValueError
        It is none, or too little to start with.
    """
    match = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([kmg]i?)?b?\s*", text, re.IGNORECASE)
    if match is None:
        raise ValueError(f"{text!r} is no amount of memory; give one such as 2G or 1500M")
    size = int(float(match[1]) * _UNITS[(match[2] or "").upper()])
    if size < LEAST_MEMORY:
        raise ValueError(f"{text} is less than the {LEAST_MEMORY // 10**6}M that it takes to start")
    return size


def parse_duration(text: str) -> float:
    """Read a duration such as ``90``, ``90s``, ``10min`` or ``2h``, s.

    Raises
    ------
    ValueError
        It is none, or not above 0.
    """
    match = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*(s|min|m|h)?\s*", text)
    seconds = float(match[1]) * _SECONDS[match[2] or ""] if match else 0.0
    if seconds <= 0.0:
        raise ValueError(f"{text!r} is no duration; give one such as 90s, 10min or 2h")
    return seconds


@contextlib.contextmanager
def limited(memory: int | None, seconds: float | None) -> Iterator[None]:
    """Bound what happens inside.

    Parameters
    ----------
    memory
        Bytes that each process may take for its data; None for no bound. Where the system cannot bound it, that is an
        error.
    seconds
        How long it may take, s; None for no bound. Only the main thread can be bounded.

    Raises
    ------
    LimitError
        Either was not enough.
    """
    with _memory_limit(memory), _time_limit(seconds):
        try:
            yield
        except MemoryError:
            if memory is None:
                raise
            raise LimitError(
                f"more memory is needed than --max-memory {memory / 1e6:,.0f} MB; allow more, choose a smaller area,"
                " or give only --ways major"
            ) from None


@contextlib.contextmanager
def _memory_limit(memory: int | None) -> Iterator[None]:
    if memory is None:
        yield
        return
    try:
        import resource
    except ImportError:
        raise LimitError("this system cannot bound memory; leave --max-memory out") from None
    # Data alone: libraries and files that are mapped for reading are shared and cost nothing.
    before = resource.getrlimit(resource.RLIMIT_DATA)
    hard = before[1]
    bound = memory if hard == resource.RLIM_INFINITY else min(memory, hard)
    resource.setrlimit(resource.RLIMIT_DATA, (bound, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, before)


@contextlib.contextmanager
def _time_limit(seconds: float | None) -> Iterator[None]:
    if seconds is None:
        yield
        return

    words = (
        f"it takes longer than --timeout {seconds:g} s; allow more, choose a smaller area, or give only --ways major"
    )

    def end(number: int, frame: FrameType | None) -> NoReturn:
        raise LimitError(words)

    before = signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        with _hard_end(seconds + _GRACE, words):
            yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


@contextlib.contextmanager
def _hard_end(seconds: float, words: str) -> Iterator[None]:
    """End the process with exit status 1 when libraries are still busy after a while, s, and do not hear signals.

    A copy of the process says why, since nothing of Python runs in this one then.
    """
    if not hasattr(os, "fork"):
        yield
        return
    ours, theirs = os.pipe()
    teller = os.fork()
    if teller == 0:
        _tell_late(ours, theirs, seconds, words)
    os.close(ours)
    with open(os.devnull, "wb") as nowhere:
        faulthandler.dump_traceback_later(seconds + 0.5, exit=True, file=nowhere)
        try:
            yield
        finally:
            faulthandler.cancel_dump_traceback_later()
            os.close(theirs)
            os.kill(teller, signal.SIGKILL)
            os.waitpid(teller, 0)


def _tell_late(ours: int, theirs: int, seconds: float, words: str) -> NoReturn:
    """Wait for the parent to end, and say why it will if it has not after a while, s."""
    try:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)
        os.close(theirs)
        if not select.select([ours], [], [], seconds)[0]:
            os.write(2, f"osm2xodr: error: {words}\n".encode())
    finally:
        os._exit(0)
