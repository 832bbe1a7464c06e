"""Bounds on the memory and time of one run of a command, giving memory back, and signals that end the process.

These are deferred where something has to be finished first.
"""

from __future__ import annotations

import contextlib
import faulthandler
import importlib.util
import os
import re
import select
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from types import FrameType, TracebackType
from typing import Final, NoReturn

from osm2xodr.errors import Osm2xodrError

_UNITS: Final = {"": 1, "K": 10**3, "M": 10**6, "G": 10**9, "KI": 2**10, "MI": 2**20, "GI": 2**30}
_SECONDS: Final = {"": 1.0, "s": 1.0, "min": 60.0, "m": 60.0, "h": 3600.0}
# Less is not enough for the interpreter and its libraries to start, bytes.
LEAST_MEMORY: Final = 200_000_000
# What the interpreter and its libraries map before there is any data, bytes: without it linear algebra tries for ever
# to get its buffers. On two cores a small area takes 330 MB, and each thread of the OSM reader maps some more.
_LEAST_ADDRESSES: Final = 400_000_000
# How long libraries may go on after the time is up before the process is killed, s.
_GRACE: Final = 3.0
# Where Linux tells the bounds on the memory of the process's container.
_CONTROL_GROUPS: Final = Path("/sys/fs/cgroup")
# When the end is tried again if Python dropped it, s.
_AGAIN: Final = 0.01
# What asks a process to end, as far as the system has it: Windows has no SIGHUP.
ENDING_SIGNALS: Final = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))
_SMALLER: Final = "or give a smaller file"


class LimitError(Osm2xodrError):
    """A run needs more memory or time than it may have."""


class TimeLimitError(LimitError):
    """A run needs more time than it may have."""


def parse_memory(text: str) -> int:
    """Return an amount of memory such as ``2G``, ``1500MB`` or ``1.5GiB`` in bytes.

    ValueError: the text is not an amount of memory, or too small a one to start with.
    """
    match = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([kmg]i?)?b?\s*", text, re.IGNORECASE)
    if match is None:
        raise ValueError(f"{text!r} is not an amount of memory; give one such as 2G or 1500M")
    size = int(float(match[1]) * _UNITS[(match[2] or "").upper()])
    if size < LEAST_MEMORY:
        raise ValueError(f"{text} is less than the {LEAST_MEMORY // 10**6}M that it takes to start")
    return size


def parse_duration(text: str) -> float:
    """Return a duration such as ``90``, ``90s``, ``10min`` or ``2h`` in seconds; ValueError for others, and for 0."""
    match = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*(s|min|m|h)?\s*", text)
    seconds = float(match[1]) * _SECONDS[match[2] or ""] if match else 0.0
    if seconds <= 0.0:
        raise ValueError(f"{text!r} is not a duration; give one such as 90s, 10min or 2h")
    return seconds


def available_memory() -> int | None:
    """Return how much memory this process and its children may still take, bytes: of the machine and its container.

    Where the system tells only how much there is, it is that; None where memory cannot be bounded.
    """
    if importlib.util.find_spec("resource") is None:
        return None
    found = [os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")]
    with contextlib.suppress(OSError, ValueError, StopIteration):
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        found.append(1024 * int(next(line for line in lines if line.startswith("MemAvailable:")).split()[1]))
    # Of control groups, in their two versions; "max" and numbers beyond the memory of the machine are no bounds.
    for name in ("memory.max", "memory/memory.limit_in_bytes"):
        with contextlib.suppress(OSError, ValueError):
            found.append(int((_CONTROL_GROUPS / name).read_text(encoding="ascii")))
    return min(found)


@contextlib.contextmanager
def limited(
    memory: int | None,
    seconds: float | None,
    remedy: str = _SMALLER,
    *,
    last_words: Callable[[str], None] | None = None,
) -> Iterator[None]:
    """Bound the memory and time of a block; None for no bound.

    `memory` are bytes that each process may take for its data. `seconds` work in the main thread alone. `remedy` is
    what else can be done than to allow more. Where a library goes on when the time is up, the process is killed, and
    a copy of it calls `last_words` with the reason, which by default is printed. `LimitError` says that they were not
    enough, that the system cannot bound them, or that its own bounds (``ulimit``) leave too little to start.
    """
    _check_system_limits()
    with _memory_limit(memory), _time_limit(seconds, remedy, last_words or _print_error):
        try:
            yield
        except MemoryError:
            if memory is None:
                raise
            raise LimitError(
                f"more memory is needed than --max-memory {memory / 1e6:,.0f} MB; allow more, {remedy}"
            ) from None


def _check_system_limits() -> None:
    """Refuse to start where the system's bounds on memory leave too little; elsewhere take early what cannot wait."""
    try:
        import resource
    except ImportError:
        return
    bounded = False
    for kind, option, least in (
        (resource.RLIMIT_AS, "-v", _LEAST_ADDRESSES),
        (resource.RLIMIT_DATA, "-d", LEAST_MEMORY),
    ):
        bound = resource.getrlimit(kind)[0]
        if bound == resource.RLIM_INFINITY:
            continue
        bounded = True
        if bound < least:
            raise LimitError(
                f"the system allows {bound / 1e6:,.0f} MB of memory (ulimit {option}), less than the"
                f" {least / 1e6:,.0f} MB that it takes to start; allow more"
            )
    if bounded:
        _take_buffers()


def _take_buffers() -> None:
    """Let the libraries of linear algebra allocate their buffers: if they cannot later, they try for ever or exit."""
    import numpy as np
    import scipy.linalg

    square = np.eye(2)
    np.linalg.solve(square @ square, square)
    scipy.linalg.solve(square, square)


@contextlib.contextmanager
def _memory_limit(memory: int | None) -> Iterator[None]:
    if memory is None:
        yield
        return
    try:
        import resource
    except ImportError:
        raise LimitError("this system cannot bound memory; leave --max-memory out") from None
    _take_buffers()
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
def _time_limit(seconds: float | None, remedy: str, last_words: Callable[[str], None]) -> Iterator[None]:
    if seconds is None:
        yield
        return
    if not hasattr(signal, "setitimer"):
        raise LimitError("this system cannot bound time; leave --timeout out")

    message = f"it takes longer than --timeout {seconds:g} s; allow more, {remedy}"
    is_up = False

    def end(number: int, frame: FrameType | None) -> NoReturn:
        nonlocal is_up
        is_up = True
        raise TimeLimitError(message)

    def end_again(lost: sys.UnraisableHookArgs) -> None:
        if isinstance(lost.exc_value, LimitError):
            signal.setitimer(signal.ITIMER_REAL, _AGAIN)
        else:
            hook(lost)

    def end_unseen(kind: type[BaseException], value: BaseException, trace: TracebackType | None) -> None:
        if not isinstance(value, LimitError):
            print_hook(kind, value, trace)

    # Python drops exceptions that arise in callbacks, as of weak references when modules are imported. Those that
    # arise when GDAL calls back are printed before.
    hook, sys.unraisablehook = sys.unraisablehook, end_again
    print_hook, sys.excepthook = sys.excepthook, end_unseen
    before = signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        with _hard_end(seconds + _GRACE, partial(last_words, message)):
            yield
    except Exception:
        # Libraries turn what interrupts them into errors of their own.
        if is_up:
            raise TimeLimitError(message) from None
        raise
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
        sys.unraisablehook, sys.excepthook = hook, print_hook


@contextlib.contextmanager
def _hard_end(seconds: float, explain: Callable[[], None]) -> Iterator[None]:
    """Kill the process, with exit status 1, if it is still busy after `seconds` in a library that ignores signals.

    A copy of the process says why, since no Python code runs in this one by then.
    """
    if not hasattr(os, "fork"):
        yield
        return
    ours, theirs = os.pipe()
    watcher = os.fork()
    if watcher == 0:
        _watch(ours, theirs, seconds, explain)
    os.close(ours)
    with open(os.devnull, "wb") as nowhere:
        faulthandler.dump_traceback_later(seconds + 0.5, exit=True, file=nowhere)
        try:
            yield
        finally:
            faulthandler.cancel_dump_traceback_later()
            os.close(theirs)
            os.kill(watcher, signal.SIGKILL)
            os.waitpid(watcher, 0)


def _watch(ours: int, theirs: int, seconds: float, explain: Callable[[], None]) -> NoReturn:
    """Say why if the parent still runs after `seconds`; then it is about to be killed."""
    try:
        for number in (signal.SIGINT, *ENDING_SIGNALS):
            signal.signal(number, signal.SIG_IGN)
        os.close(theirs)
        if not select.select([ours], [], [], seconds)[0]:
            explain()
    finally:
        os._exit(0)


def _print_error(message: str) -> None:
    os.write(2, f"osm2xodr: error: {message}\n".encode())


def release_memory() -> None:
    """Give memory that is no longer used back to the system, where the C library can (glibc's ``malloc_trim``).

    Threads that decode an OSM file keep a heap of their own that nothing else would use again, and small objects
    leave gaps behind that are of little use to the large arrays of the next stage.
    """
    # Here, because most commands do not need it.
    import ctypes

    # Without a name Windows has no library to open.
    with contextlib.suppress(TypeError, OSError):
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
        if trim is not None:
            trim(0)


@contextlib.contextmanager
def uninterrupted() -> Iterator[None]:
    """Defer the signals that end the process to the end of the block.

    SIGINT is blocked, also for threads and processes that are started meanwhile, and for those that they start:
    Ctrl-C at the terminal reaches this process alone, which then stops its workers in order. Where the system blocks
    no signals, it is deferred as the others.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    deferred: list[int] = []

    def defer(number: int, frame: FrameType | None) -> None:
        deferred.append(number)

    can_block = hasattr(signal, "pthread_sigmask")
    numbers = ENDING_SIGNALS if can_block else (signal.SIGINT, *ENDING_SIGNALS)
    before = {number: signal.getsignal(number) for number in numbers}
    for number, handler in before.items():
        if handler is not signal.SIG_IGN:
            signal.signal(number, defer)
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if can_block else set()
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for late in deferred[:1]:
            signal.raise_signal(late)
        if can_block:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
