"""Work on several cores: functions that run in copies of this process.

Copies are made by `fork`: they share all of the parent's arrays and send back what the function returns. No result
depends on the number of jobs, so the bytes written are the same for any of them. Where the system cannot fork,
everything runs in this process, one after the other.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Generator, Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Generic, TypeVar

from osm2xodr.errors import Osm2xodrError
from osm2xodr.system.limits import ENDING_SIGNALS

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

# How often a copy checks whether its parent still lives, s.
_PARENT_CHECK = 0.2

T = TypeVar("T")
Item = TypeVar("Item")


class _Copy(Generic[T]):
    """A copy of this process, which works and hands back one value after the other.

    It waits with each until the one before is fetched.
    """

    def __init__(self, work: Callable[[], Iterable[T]]) -> None:
        # Here, because most commands do not need it.
        import multiprocessing

        context = multiprocessing.get_context("fork")
        self._receiver: Connection
        self._receiver, sender = context.Pipe(duplex=False)
        self._process: BaseProcess = context.Process(target=_run, args=(work, sender, os.getpid()), daemon=True)
        with warnings.catch_warnings():
            # Python warns that the copy lacks the threads of this process. Those of the OSM reader and of linear
            # algebra wait for work, hold no lock, and are not used in the copy.
            warnings.simplefilter("ignore", DeprecationWarning)
            self._process.start()
        sender.close()

    def fetch(self) -> T:
        """Wait for the next value and return it, or raise what the work raised."""
        try:
            value, error = self._receiver.recv()
        except EOFError:
            self._process.join()
            raise Osm2xodrError(
                f"a worker process was killed (exit status {self._process.exitcode}), perhaps for want of memory;"
                " free some, or convert with --jobs 1"
            ) from None
        if error is not None:
            raise error
        out: T = value
        return out

    def end(self) -> None:
        """Stop the copy if it still runs."""
        self._receiver.close()
        if self._process.is_alive():
            self._process.kill()
        self._process.join()


class Task(Generic[T]):
    """The result of a function, computed once: in a copy of this process (`apart`), or when it is first asked for.

    The function must neither write files nor change the parent's data: only its result comes back. At the end of a
    ``with`` block the copy is stopped.
    """

    def __init__(self, function: Callable[[], T], *, apart: bool) -> None:
        self._function = function
        self._found: tuple[T] | None = None
        self._copy = _Copy(lambda: (function(),)) if apart and can_fork() else None

    def __enter__(self) -> Task[T]:
        return self

    def __exit__(self, *_: object) -> None:
        self.cancel()

    def result(self) -> T:
        """Wait for the function's result and return it, or raise what it raised.

        `Osm2xodrError` says that the copy of the process was killed.
        """
        if self._found is None:
            self._found = (self._function() if self._copy is None else self._fetched(self._copy),)
        return self._found[0]

    @staticmethod
    def _fetched(copy: _Copy[T]) -> T:
        try:
            return copy.fetch()
        finally:
            copy.end()

    def cancel(self) -> None:
        """Stop the copy of the process, if one runs."""
        if self._copy is not None:
            self._copy.end()


def can_fork() -> bool:
    """Return whether this process may be copied: the system can, and it is no copy that must not have copies."""
    # What is not loaded has made no copies.
    process = sys.modules.get("multiprocessing.process")
    return hasattr(os, "fork") and not (process and process.current_process().daemon)


def available_jobs() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def map_parallel(function: Callable[[Item], T], items: Sequence[Item], jobs: int) -> Generator[T, None, None]:
    """Yield the function's value for each item, in order, computed by `jobs` processes; this one does its share.

    Items are dealt out in turns, so that neighbours, which often take equally long, spread over the processes. Each
    copy holds one value at most that has not been asked for. As for `Task`, the function must not change the parent's
    data.
    """
    jobs = max(1, min(jobs, len(items))) if can_fork() else 1
    copies = [_Copy(partial(map, function, items[k::jobs])) for k in range(1, jobs)]
    try:
        for k, item in enumerate(items):
            yield copies[k % jobs - 1].fetch() if k % jobs else function(item)
    finally:
        for copy in copies:
            copy.end()


def _run(work: Callable[[], Iterable[T]], sender: Connection, parent: int) -> None:
    """Send the values of some work to the parent, or the error that ends it."""
    # The parent reports an interruption; copies just end.
    for number in (signal.SIGINT, *ENDING_SIGNALS):
        signal.signal(number, signal.SIG_DFL)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    # The pipe is broken if the parent was killed.
    with contextlib.suppress(BrokenPipeError):
        try:
            for value in work():
                sender.send((value, None))
        except BrokenPipeError:
            raise
        except Exception as error:
            sender.send((None, error))
    sender.close()


def _end_with(parent: int) -> None:
    """End this process soon after its parent, which may be killed before it can stop its copies."""
    while os.getppid() == parent:
        time.sleep(_PARENT_CHECK)
    os._exit(1)
