"""What a worker does with one area: it has it converted in a process of its own.

Everything here is plain functions and data, since it is sent to workers by name.
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
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from osm2xodr import __version__
from osm2xodr.batch.model import EMPTY
from osm2xodr.system import ONE_THREAD_ENVIRONMENT

_ERROR: Final = "osm2xodr: error: "
_USAGE: Final = "Error: "


@dataclass(frozen=True, slots=True)
class AreaJob:
    """An area to convert."""

    batch: str  # Tells batches apart that use the same workers
    name: str  # The area
    arguments: tuple[str, ...]  # Of ``osm2xodr``, from the name of the command on
    memory: int = 0  # Bytes that it may take where `arguments` do not bound them; 0 for no bound
    version: str = __version__  # Of osm2xodr, which must be the worker's


@dataclass(frozen=True, slots=True)
class Outcome:
    """How the conversion of an area ended."""

    message: str  # Why it failed, one sentence; empty if it did not
    seconds: float = 0.0  # How long it took
    memory: int = 0  # Most memory that it took, bytes
    empty: bool = False  # Whether it failed because there is nothing to drive on


class _Server:
    """A running `osm2xodr.cli.area_server`."""

    def __init__(self) -> None:
        # More threads of linear algebra would make results depend on the machine; PROJ fetches no grids.
        environment = {**os.environ, **ONE_THREAD_ENVIRONMENT, "PROJ_NETWORK": "OFF"}
        # In a session of its own: a Ctrl-C at the terminal is for the batch, which stops its areas in order.
        self._process = subprocess.Popen(
            [sys.executable, "-m", "osm2xodr.cli.area_server"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=environment,
            start_new_session=True,
        )

    def ask(self, arguments: Sequence[str]) -> dict[str, Any] | None:
        """Return what became of a conversion; None if the server ended."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            self._process.stdin.write(json.dumps(arguments).encode() + b"\n")
            self._process.stdin.flush()
            line = self._process.stdout.readline()
        except (OSError, ValueError):
            # The latter where another thread has ended the server.
            return None
        answer: dict[str, Any] | None = json.loads(line) if line.endswith(b"\n") else None
        return answer

    def end(self) -> None:
        """Have it stop what it does and end."""
        assert self._process.stdin is not None
        with contextlib.suppress(OSError):
            self._process.stdin.close()

    def wait(self) -> bool:
        """Wait until it has ended, and return whether it did so in order."""
        status = self._process.wait()
        assert self._process.stdout is not None
        self._process.stdout.close()
        return status == 0


_lock = threading.Lock()
_idle: dict[str, list[_Server]] = {}
_busy: dict[str, list[_Server]] = {}
_ended: set[str] = set()


def run_area(job: AreaJob) -> Outcome:
    """Convert an area.

    Parameters
    ----------
    job
        The area.

    Returns
    -------
    Outcome
        How it ended; that conversions fail is no exception.
    """
    if job.version != __version__:
        return Outcome(
            f"the worker has osm2xodr {__version__}, and the batch {job.version}; install the same on both"
        )
    began = time.monotonic()
    while True:
        fresh, server = _take(job.batch)
        if server is None:
            return Outcome("it was stopped", time.monotonic() - began)
        answer = server.ask(_arguments(job))
        if answer is not None:
            _give_back(job.batch, server)
            message = _sentence(answer["status"], answer["said"])
            return Outcome(message, time.monotonic() - began, answer["memory"], answer["status"] == EMPTY)
        _forget(job.batch, server)
        # One that has waited for long ends just as it is asked again.
        if not server.wait() or fresh:
            message = "it was stopped" if job.batch in _ended else _killed("")
            return Outcome(message, time.monotonic() - began)


def end_areas(batch: str) -> None:
    """Stop all conversions of a batch on this worker, and let go of what they needed."""
    with _lock:
        _ended.add(batch)
        idle, busy = _idle.pop(batch, []), list(_busy.get(batch, []))
    for server in (*idle, *busy):
        server.end()
    for server in idle:
        server.wait()


@atexit.register
def _end_all() -> None:
    """Stop everything where a worker ends without having been told that the batch is over."""
    with _lock:
        batches = {*_idle, *_busy}
    for batch in batches:
        end_areas(batch)


def _take(batch: str) -> tuple[bool, _Server | None]:
    """Return a server and whether it is a new one; none if the batch is over."""
    with _lock:
        if batch in _ended:
            return False, None
        waiting = _idle.get(batch)
        fresh = not waiting
        server = _Server() if not waiting else waiting.pop()
        _busy.setdefault(batch, []).append(server)
    return fresh, server


def _give_back(batch: str, server: _Server) -> None:
    with _lock:
        _busy[batch].remove(server)
        over = batch in _ended
        if not over:
            _idle.setdefault(batch, []).append(server)
    if over:
        server.end()
        server.wait()


def _forget(batch: str, server: _Server) -> None:
    with _lock:
        _busy[batch].remove(server)
    server.end()


def _arguments(job: AreaJob) -> list[str]:
    """Return the arguments with the bound on memory first, so that a later one holds."""
    bound = ["--max-memory", str(job.memory)] if job.memory else []
    return [job.arguments[0], *bound, *job.arguments[1:]]


def _sentence(status: int, said: str) -> str:
    """Say why a conversion failed, by its exit status (negative: the signal that killed it) and what it said."""
    if status == 0:
        return ""
    if status < 0:
        return _killed(f" by {signal.Signals(-status).name}")
    for line in reversed(said.splitlines()):
        for start in (_ERROR, _USAGE):
            if line.startswith(start):
                return line[len(start) :].strip()
    return f"it ended with exit status {status}; convert it alone to see why"


def _killed(how: str) -> str:
    return (
        f"its process was killed{how}, perhaps for want of memory; use fewer --workers, choose smaller areas, or give"
        " only --ways major"
    )
