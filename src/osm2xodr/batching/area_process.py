"""What a worker does with one area: it has it converted in a process of its own.

These are plain functions and data, because Dask sends them to workers by name.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from typing import Any, Final

from osm2xodr import __version__
from osm2xodr.batching.model import EMPTY
from osm2xodr.system import library_environment, record

# How long what a killed process leaves behind may take to end, s.
_STOP_GRACE: Final = 3.0


@record
class AreaJob:
    """An area to convert."""

    name: str  # The area
    arguments: tuple[str, ...]  # Of ``osm2xodr``, beginning with the command
    server: str = ""  # The module that has it converted in a process of its own
    batch: str = ""  # Id of the batch: several may use the same workers
    memory: int = 0  # Bytes that it may take if `arguments` do not bound them; 0 for no bound
    version: str = __version__  # Of osm2xodr, which must be the worker's
    block: str = ""  # The block that it is made with, whose areas follow each other; empty if it is made by itself


@record
class Outcome:
    """How the conversion of an area ended."""

    message: str  # Why it failed, in one sentence; empty if it did not
    seconds: float = 0.0  # Duration
    memory: int = 0  # Peak memory, bytes
    empty: bool = False  # Whether it failed because there is nothing to drive on
    apart: bool = False  # Whether its block cannot be laid out, so that it can only be made by itself


def area_environment() -> dict[str, str]:
    """Return the environment of the processes that convert areas."""
    environment = dict(os.environ)
    library_environment(environment)
    # Dask sets it for its workers: memory goes back to the system with each array. Areas take a third longer then.
    environment.pop("MALLOC_TRIM_THRESHOLD_", None)
    return environment


class _Server:
    """A process that converts areas: a module that reads requests and writes answers, each a line of JSON."""

    def __init__(self, module: str) -> None:
        self.thread = 0  # Which one has asked it last
        # In a session of its own (on Windows a group): Ctrl-C at the terminal reaches the batch alone, which stops
        # its areas in order.
        self._process = subprocess.Popen(
            [sys.executable, "-m", module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=area_environment(),
            start_new_session=True,
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )

    def ask(self, arguments: Sequence[str], *, more: bool) -> dict[str, Any] | None:
        """Run a conversion and return how it ended; None if the server ended.

        `more` says that the next one is of another area of the same block.
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            self._process.stdin.write(json.dumps({"arguments": arguments, "more": more}).encode() + b"\n")
            self._process.stdin.flush()
            line = self._process.stdout.readline()
        except (OSError, ValueError):
            # A ValueError means that another thread has closed the pipe.
            return None
        answer: dict[str, Any] | None = json.loads(line) if line.endswith(b"\n") else None
        return answer

    def end(self) -> None:
        """Tell it to stop its conversion and end."""
        assert self._process.stdin is not None
        with contextlib.suppress(OSError):
            self._process.stdin.close()

    def wait(self) -> bool:
        """Wait for its end, and return whether it ended normally."""
        status = self._process.wait()
        assert self._process.stdout is not None
        self._process.stdout.close()
        if status:
            self._end_forks()
        return status == 0

    def _end_forks(self) -> None:
        """End what a killed server has left behind, which would go on to write files."""
        # They are of its session; there is no such group when all have ended, and without forks there are none.
        if not hasattr(os, "killpg"):
            return
        with contextlib.suppress(ProcessLookupError):
            for number in (signal.SIGTERM, signal.SIGKILL):
                os.killpg(self._process.pid, number)
                end = time.monotonic() + _STOP_GRACE
                while time.monotonic() < end:
                    os.killpg(self._process.pid, 0)
                    time.sleep(0.02)


_lock = threading.Lock()
_idle: dict[str, list[_Server]] = {}
_busy: dict[str, list[_Server]] = {}
_ended: set[str] = set()


def blocks_of(jobs: Sequence[AreaJob]) -> list[list[AreaJob]]:
    """Return jobs that follow each other grouped by their blocks."""
    found: list[list[AreaJob]] = []
    for job in jobs:
        if found and job.block and found[-1][-1].block == job.block:
            found[-1].append(job)
        else:
            found.append([job])
    return found


def run_block(jobs: Sequence[AreaJob]) -> list[Outcome]:
    """Convert the areas of a block, and return how each ended."""
    return list(run_each(jobs))


def run_each(jobs: Sequence[AreaJob]) -> Iterator[Outcome]:
    """Convert the areas of a block, and yield how each ended, as they end.

    If the block cannot be laid out, no area is converted.
    """
    for place, job in enumerate(jobs):
        outcome = run_area(job, more=place + 1 < len(jobs))
        yield outcome
        if outcome.apart:
            for _ in jobs[place + 1 :]:
                yield outcome
            return


def run_area(job: AreaJob, *, more: bool = False) -> Outcome:
    """Convert an area, and return how that ended; a conversion that fails raises nothing.

    `more` says that the next area in this thread is of the same block.
    """
    if job.version != __version__:
        reason = f"the worker has osm2xodr {__version__}, and the batch {job.version}"
        return Outcome(f"{reason}; install the same on both")
    # First, so that one among the arguments overrides it.
    bound = ["--max-memory", str(job.memory)] if job.memory else []
    began = time.monotonic()
    while True:
        fresh, server = _take(job)
        if server is None:
            return Outcome("it was stopped", time.monotonic() - began)
        answer = server.ask([job.arguments[0], *bound, *job.arguments[1:]], more=more)
        if answer is not None:
            _give_back(job.batch, server, usable=True)
            message = _sentence(answer["status"], answer["message"])
            apart = bool(job.block and message and not answer["laid_out"])
            return Outcome(message, time.monotonic() - began, answer["memory"], answer["status"] == EMPTY, apart)
        _give_back(job.batch, server, usable=False)
        # An idle server may end by itself just as it is asked again.
        if not server.wait() or fresh:
            stopped = job.batch in _ended
            message = "it was stopped" if stopped else _killed("")
            return Outcome(message, time.monotonic() - began, apart=bool(job.block) and not stopped)


def end_areas(batch: str) -> None:
    """Stop all conversions of a batch on this worker, and end their servers."""
    with _lock:
        _ended.add(batch)
        idle, busy = _idle.pop(batch, []), list(_busy.get(batch, []))
    for server in (*idle, *busy):
        server.end()
    for server in idle:
        server.wait()


@atexit.register
def _end_all() -> None:
    """Stop everything when a worker ends before it was told that the batch is over."""
    with _lock:
        batches = {*_idle, *_busy}
    for batch in batches:
        end_areas(batch)


def _take(job: AreaJob) -> tuple[bool, _Server | None]:
    """Return whether the server for an area is new, and the server; None if the batch is over.

    It is the one that this thread has had before, which may keep a block, unless another one has taken that.
    """
    with _lock:
        if job.batch in _ended:
            return False, None
        waiting = _idle.get(job.batch, [])
        own = next((one for one in waiting if one.thread == threading.get_ident()), None)
        fresh = not waiting
        server = _Server(job.server) if not waiting else waiting.pop() if own is None else own
        if own is not None:
            waiting.remove(own)
        server.thread = threading.get_ident()
        _busy.setdefault(job.batch, []).append(server)
    return fresh, server


def _give_back(batch: str, server: _Server, *, usable: bool) -> None:
    """Keep a server for the next area; end it if it is not usable, or the batch is over."""
    with _lock:
        _busy[batch].remove(server)
        kept = usable and batch not in _ended
        if kept:
            _idle.setdefault(batch, []).append(server)
    if not kept:
        server.end()
        server.wait()


def _sentence(status: int, message: str) -> str:
    """Return why a conversion failed, by its exit status (negative: the signal that killed it) and its message."""
    if status == 0:
        return ""
    if status < 0:
        return _killed(f" by {signal.Signals(-status).name}")
    return message or f"it ended with exit status {status}; convert it alone to see why"


def _killed(how: str) -> str:
    return (
        f"its process was killed{how}, perhaps for want of memory; use fewer --workers, choose smaller areas, or give"
        " only --ways major"
    )
