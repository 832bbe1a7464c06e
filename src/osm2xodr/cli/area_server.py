"""A process that has areas converted one by one, by a fork of itself: ``python -m osm2xodr.cli.area_server``.

It has loaded all that conversions need, so that a fork starts at once. The fork converts one area after the other; if
it crashes or is killed for lack of memory, the next area gets a new one. The process reads a line of JSON per area
from standard input, the list of arguments of ``osm2xodr`` and whether the next area is of the same block, whose roads
the fork then keeps; and answers with a line of JSON on standard output (`_ANSWER`). When standard input ends, because
the process that started it has ended, it stops the running conversion and ends. Where the system has no forks, the
process converts the areas itself, and ends after one that may have left something behind.
"""

from __future__ import annotations

import _thread
import contextlib
import gc
import importlib
import json
import os
import queue
import select
import signal
import sys
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NoReturn

from osm2xodr.batching import EMPTY
from osm2xodr.errors import EmptyAreaError, Osm2xodrError
from osm2xodr.system import LimitError, TimeLimitError, release_memory

if TYPE_CHECKING:
    from osm2xodr.pipeline import Layouts

# How long a conversion may take to remove its temporary files before it is killed, s.
_STOP_GRACE: Final = 3.0
# The process ends after so long without an area, s; a choice.
_IDLE: Final = 60.0
# How often it checks whether a fork has ended whose pipe is still open, and a fork checks on its parent, s.
_CHECK: Final = 0.2
# How much of an answer is read at once, bytes.
_CHUNK: Final = 1 << 16
# A fork that holds more than this after an area, bytes beyond what it held at first, converts no further one: what is
# left of one area is not to count against the memory that the next one may take. A choice.
_MOST_KEPT: Final = 100_000_000
# Unit in which the system tells the peak memory of processes, bytes.
_KIBIBYTE: Final = 1 if sys.platform == "darwin" else 1024

# What the process answers about an area: exit status (negative: the signal that killed it), peak memory in bytes, why
# it failed (empty if it did not, or if nobody knows), and whether the area's block, if it is of one, is laid out.
_ANSWER: Final = ("status", "memory", "message", "laid_out")

_PRELOADED: Final = (
    "osm2xodr.cli.convert",
    "osm2xodr.python_api.converting",
    "osm2xodr.python_api.inputs",
    "osm2xodr.python_api.inputs",
    "osm2xodr.batching.areas",
    "osm2xodr.osmParsing.parsing",
    "osm2xodr.surface.reading",
    "osm2xodr.furniture.lane_sections",
    "osm2xodr.furniture.lights",
    "osm2xodr.furniture.objects",
    "osm2xodr.furniture.signs",
    "osm2xodr.xodrWriter.document",
    "osm2xodr.xodrWriter.furniture_text",
    "configparser",
    "pyproj",
    "rasterio.windows",
    "resource",
    "scipy.interpolate",
    "scipy.ndimage",
)


def main() -> None:
    """Serve until standard input ends, or nothing has come for a while."""
    # Standard output is for answers: what is printed goes to standard error.
    answers = os.dup(1)
    os.dup2(2, 1)
    load()
    if not hasattr(os, "fork"):
        _convert_here(answers)
        return
    # Forks share what was loaded as long as they do not look through it for garbage.
    gc.freeze()
    fork: _Fork | None = None
    while line := _next_line():
        fork = fork or _Fork(answers)
        answer = fork.convert(line)
        if answer.get("again"):
            # Nothing that an area before it has left behind may make an area fail.
            fork = _Fork(answers)
            answer = fork.convert(line)
        if answer.get("unwanted"):
            return
        fork = fork if answer.get("goes_on") else None
        os.write(answers, json.dumps({key: answer[key] for key in _ANSWER}).encode() + b"\n")
    if fork is not None:
        fork.stop()


def _convert_here(answers: int) -> None:
    """Convert areas in this process until standard input ends, or one has left something behind."""
    from osm2xodr.pipeline import Layouts

    layouts = Layouts()
    lines: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(lines,), daemon=True).start()
    while line := lines.get():
        answer = _run(json.loads(line), layouts, 0, None, None)
        os.write(answers, json.dumps({key: answer[key] for key in _ANSWER}).encode() + b"\n")
        if not answer["goes_on"]:
            return


def _read(lines: queue.SimpleQueue[bytes]) -> None:
    """Hand over the requests; at the end of standard input stop the conversion that runs."""
    with open(0, "rb", closefd=False) as requests:
        for line in requests:
            lines.put(line)
    lines.put(b"")
    _thread.interrupt_main(signal.SIGTERM)
    time.sleep(_STOP_GRACE)
    os._exit(1)


def load() -> None:
    """Load what conversions need."""
    for name in _PRELOADED:
        # The conversion will report what is missing.
        with contextlib.suppress(ImportError):
            importlib.import_module(name)


def _next_line() -> bytes:
    """Return the next request; empty when it is time to end."""
    line = b""
    while not line.endswith(b"\n"):
        if not select.select([0], [], [], _IDLE)[0] or not (more := os.read(0, 1 << 16)):
            return b""
        line += more
    return line


class _Fork:
    """A copy of this process that converts one area after the other."""

    def __init__(self, answers: int) -> None:
        theirs, self._requests = os.pipe()
        self._answers, reply = os.pipe()
        server = os.getpid()
        self._process = os.fork()
        if self._process == 0:
            for number in (answers, self._requests, self._answers):
                os.close(number)
            _serve(theirs, reply, server)
        for number in (theirs, reply):
            os.close(number)

    def convert(self, line: bytes) -> dict[str, object]:
        """Have a command run that is a line of JSON, and return how that ended.

        Beside `_ANSWER`, ``goes_on`` says that the fork can convert another area, ``again`` that a new one is to try
        this one, ``unwanted`` that standard input ended meanwhile.
        """
        with contextlib.suppress(BrokenPipeError):
            os.write(self._requests, line)
        reply = b""
        while not reply.endswith(b"\n"):
            ready = select.select([self._answers, 0], [], [], _CHECK)[0]
            if 0 in ready:
                self.stop()
                return {"unwanted": True}
            if self._answers in ready:
                reply += (more := os.read(self._answers, _CHUNK))
                if not more:
                    break
            # Watchers that it has forked may keep its pipes open when it has ended.
            if not ready and os.waitid(os.P_PID, self._process, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None:
                break
        answer: dict[str, object] = json.loads(reply) if reply.endswith(b"\n") else {"message": ""}
        if "status" in answer:
            if not answer["goes_on"]:
                self.stop()
            return answer
        # It was killed, or is about to be.
        self._close()
        _, status, usage = os.wait4(self._process, 0)
        memory, ended = _KIBIBYTE * usage.ru_maxrss, os.waitstatus_to_exitcode(status)
        return {"status": ended, "memory": memory, "message": answer["message"], "laid_out": False}

    def stop(self) -> None:
        """End the fork: give it time to clean up, and kill it if that takes too long."""
        self._close()
        os.kill(self._process, signal.SIGTERM)
        end = time.monotonic() + _STOP_GRACE
        while time.monotonic() < end:
            if os.waitpid(self._process, os.WNOHANG)[0]:
                return
            time.sleep(0.02)
        os.kill(self._process, signal.SIGKILL)
        os.waitpid(self._process, 0)

    def _close(self) -> None:
        for number in (self._requests, self._answers):
            os.close(number)


def _serve(requests: int, reply: int, server: int) -> NoReturn:
    """Run commands in the fork, which answer to the server, until no more are asked for."""

    def answer(record: Mapping[str, object]) -> None:
        os.write(reply, json.dumps(record).encode() + b"\n")

    status = 1
    try:
        nowhere = os.open(os.devnull, os.O_RDWR)
        for number in (0, 1):
            os.dup2(nowhere, number)
        os.close(nowhere)
        threading.Thread(target=_end_with, args=(server,), daemon=True).start()
        before = _data_size()
        from osm2xodr.pipeline import Layouts

        layouts = Layouts()
        with os.fdopen(requests, "rb") as lines:
            for place, line in enumerate(lines):
                answer(_run(json.loads(line), layouts, place, before, lambda why: answer({"message": why})))
        status = 0
    finally:
        # Not by `sys.exit`, which would unwind into the code of the server.
        os._exit(status)


def _run(
    request: dict[str, Any],
    layouts: Layouts,
    place: int,
    before: int | None,
    last_words: Callable[[str], None] | None,
) -> dict[str, object]:
    """Run the command in this `place` among those of the fork, which held `before` bytes of data when it began.

    `layouts` keep the roads of a block as long as there is more of it; `last_words` is as in `Session`.
    """
    from osm2xodr.cli.options import Session
    from osm2xodr.cli.program import main as run_command

    alone = before is None or not _forget_peak()
    session = Session(last_words=last_words, layouts=layouts)
    status = run_command(request["arguments"], session)
    if status and isinstance(session.error, EmptyAreaError):
        status = EMPTY
    memory, well = _peak(), status in (0, EMPTY)
    laid_out = layouts.full
    # Each area of a block may fail, as for want of heights, with nothing wrong in this process.
    refused = laid_out and isinstance(session.error, Osm2xodrError) and not isinstance(session.error, LimitError)
    if not request["more"]:
        layouts.clear()
    return {
        "status": status,
        "memory": memory,
        "message": session.message,
        "laid_out": laid_out,
        "goes_on": (well or refused) and (request["more"] or (not alone and _has_room(before or 0))),
        "again": not (well or refused) and place > 0 and not isinstance(session.error, TimeLimitError),
    }


def _has_room(before: int) -> bool:
    """Say whether little is left of the areas so far; conversions themselves collect no garbage."""
    if (_data_size() or 0) - before < _MOST_KEPT // 2:
        return True
    gc.unfreeze()
    gc.collect()
    release_memory()
    return (_data_size() or 0) - before < _MOST_KEPT


def _forget_peak() -> bool:
    """Have the system measure peak memory from here on, and return whether it can; only Linux does."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_bytes(b"5")
        return True
    return False


def _peak() -> int:
    """Return the peak memory of this process, bytes; 0 where the system does not tell."""
    measured = _status("VmHWM")
    if measured is not None:
        return measured
    # Here, because Windows does not have it.
    try:
        import resource
    except ImportError:
        return 0
    return _KIBIBYTE * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _data_size() -> int | None:
    """Return what `osm2xodr.system.limited` bounds, bytes; None where the system does not tell."""
    return _status("VmData")


def _status(name: str) -> int | None:
    """Return a size that Linux tells about this process, bytes."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines():
            if line.startswith(f"{name}:"):
                return 1024 * int(line.split()[1])
    return None


def _end_with(server: int) -> None:
    """End this fork soon after the server, which may be killed before it can stop it."""
    while os.getppid() == server:
        time.sleep(_CHECK)
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(_STOP_GRACE)
    os._exit(1)


if __name__ == "__main__":
    main()
