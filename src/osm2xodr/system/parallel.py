"""Work on several cores: functions that run in copies of this process.

Copies are made by `fork`: they share all of the parent's arrays and send back what the function returns. No result
depends on the number of jobs, so the bytes written are the same for any of them. Where the system cannot fork,
everything runs in this process, one after the other.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Generic, TypeVar

from osm2xodr.errors import Osm2xodrError

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

# How often a copy checks whether its parent still lives, s.
_PARENT_CHECK = 0.2

T = TypeVar("T")
Item = TypeVar("Item")


class Task(Generic[T]):
    """The result of a function, computed in a copy of this process (`apart`) or when it is asked for.

    The function must neither write files nor change the parent's data: only its result comes back.
    """

    def __init__(self, function: Callable[[], T], *, apart: bool) -> None:
        self._function = function
        self._process: BaseProcess | None = None
        if apart and can_fork():
            self._start()

    def _start(self) -> None:
        # Here, because most commands do not need it.
        import multiprocessing

        context = multiprocessing.get_context("fork")
        self._receiver, sender = context.Pipe(duplex=False)
        self._process = context.Process(target=_run, args=(self._function, sender, os.getpid()), daemon=True)
        with warnings.catch_warnings():
            # Python warns that the copy lacks the threads of this process. Those of the OSM reader and of linear
            # algebra wait for work, hold no lock, and are not used in the copy.
            warnings.simplefilter("ignore", DeprecationWarning)
            self._process.start()
        sender.close()

    def result(self) -> T:
        """Wait for the function's result and return it, or raise what it raised.

        `Osm2xodrError` says that the copy of the process was killed.
        """
        if self._process is None:
            return self._function()
        try:
            value, error = self._receiver.recv()
        except EOFError:
            self._process.join()
            raise Osm2xodrError(
                f"a worker process was killed (exit status {self._process.exitcode}), perhaps for want of memory;"
                " try again with --jobs 1"
            ) from None
        finally:
            self._receiver.close()
        self._process.join()
        if error is not None:
            raise error
        out: T = value
        return out

    def cancel(self) -> None:
        """Stop the copy of the process, if one runs."""
        if self._process is not None and self._process.is_alive():
            self._process.kill()
            self._process.join()


def can_fork() -> bool:
    """Return whether this system copies processes."""
    return hasattr(os, "fork")


def available_jobs() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def map_parallel(function: Callable[[Item], T], items: Sequence[Item], jobs: int) -> list[T]:
    """Return the function's value for each item, in order, computed by `jobs` processes; this one does its share.

    Items are dealt out in turns, so that neighbours, which often take equally long, spread over the processes. As for
    `Task`, the function must not change the parent's data.
    """
    jobs = max(1, min(jobs, len(items)))
    work = [partial(_values, function, items[k::jobs]) for k in range(jobs)]
    tasks = [Task(share, apart=True) for share in work[1:]]
    try:
        shares = [work[0](), *(task.result() for task in tasks)]
    except BaseException:
        for task in tasks:
            task.cancel()
        raise
    return [shares[k % jobs][k // jobs] for k in range(len(items))]


def _values(function: Callable[[Item], T], items: Sequence[Item]) -> list[T]:
    return [function(item) for item in items]


def _run(function: Callable[[], T], sender: Connection, parent: int) -> None:
    """Send a function's result or error to the parent."""
    # The parent reports an interruption; copies just end.
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    try:
        value: tuple[T | None, BaseException | None] = function(), None
    except Exception as error:
        value = None, error
    # The pipe is broken if the parent was killed.
    with contextlib.suppress(BrokenPipeError):
        sender.send(value)
    sender.close()


def _end_with(parent: int) -> None:
    """End this process soon after its parent, which may be killed before it can stop its copies."""
    while os.getppid() == parent:
        time.sleep(_PARENT_CHECK)
    os._exit(1)
