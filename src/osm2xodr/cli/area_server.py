"""A process that converts areas one by one, each in a fork of itself: ``python -m osm2xodr.cli.area_server``.

It has loaded all that conversions need, so that each of them starts at once, and one that crashes or is killed for
lack of memory takes nothing but its fork with it. It reads a line of JSON per area from standard input, the list of
arguments of ``osm2xodr``, and answers with a line on standard output. When standard input ends, because the process
that started it has ended, it stops the running conversion and ends.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import select
import signal
import sys
import threading
import time
from typing import Final, NoReturn

from osm2xodr.batch import EMPTY
from osm2xodr.errors import EmptyAreaError

# How long a conversion may take to remove its temporary files before it is killed, s.
_STOP_GRACE: Final = 3.0
# The process ends after so long without an area, s; a choice.
_IDLE: Final = 60.0
# How often it checks whether a fork has ended that left its standard error open, and a fork checks on its parent, s.
_CHECK: Final = 0.2
# How much is kept of the messages of a conversion, bytes.
_KEPT: Final = 1 << 16

_PRELOADED: Final = (
    "osm2xodr.cli",
    "osm2xodr.pipeline",
    "osm2xodr.batch.shared_frame",
    "osm2xodr.osmParsing.parsing",
    "osm2xodr.surface.reading",
    "osm2xodr.furniture.lights",
    "osm2xodr.furniture.objects",
    "osm2xodr.furniture.signs",
    "osm2xodr.xodrWriter.document",
    "pyproj",
    "rasterio.windows",
    "scipy.interpolate",
    "scipy.sparse.csgraph",
)


def main() -> None:
    """Serve until standard input ends, or nothing has come for a while."""
    # Standard output is for answers: what libraries print goes to standard error.
    answers = os.dup(1)
    os.dup2(2, 1)
    for name in _PRELOADED:
        # The conversion will report what is missing.
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    while line := _next_line():
        answer = _convert(json.loads(line), answers)
        if answer is None:
            return
        os.write(answers, json.dumps(answer).encode() + b"\n")


def _next_line() -> bytes:
    """Return the next request; empty when it is time to end."""
    line = b""
    while not line.endswith(b"\n"):
        if not select.select([0], [], [], _IDLE)[0] or not (more := os.read(0, 1 << 16)):
            return b""
        line += more
    return line


def _convert(arguments: list[str], answers: int) -> dict[str, object] | None:
    """Run a command in a fork of this process; None if standard input ended meanwhile."""
    messages, messages_end = os.pipe()
    server = os.getpid()
    fork = os.fork()
    if fork == 0:
        os.close(messages)
        os.close(answers)
        _run(arguments, messages_end, server)
    os.close(messages_end)
    try:
        text, wanted = _listen(messages, fork)
    finally:
        os.close(messages)
    if not wanted:
        _stop(fork)
        return None
    _, status, usage = os.wait4(fork, 0)
    # In kibibytes on Linux, in bytes on macOS.
    memory = usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    return {"status": os.waitstatus_to_exitcode(status), "memory": memory, "said": text.decode("utf-8", "replace")}


def _listen(messages: int, fork: int) -> tuple[bytes, bool]:
    """Return the last messages of a fork when it has ended, and False if standard input ended before."""
    text = b""
    while True:
        ready = select.select([messages, 0], [], [], _CHECK)[0]
        if 0 in ready:
            return text, False
        if messages in ready:
            more = os.read(messages, _KEPT)
            if not more:
                return text, True
            text = (text + more)[-_KEPT:]
        elif os.waitid(os.P_PID, fork, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None:
            return text, True


def _stop(fork: int) -> None:
    """End a fork: give it time to clean up, and kill it if that takes too long."""
    os.kill(fork, signal.SIGTERM)
    end = time.monotonic() + _STOP_GRACE
    while time.monotonic() < end:
        if os.waitpid(fork, os.WNOHANG)[0]:
            return
        time.sleep(0.02)
    os.kill(fork, signal.SIGKILL)
    os.waitpid(fork, 0)


def _run(arguments: list[str], messages_end: int, server: int) -> NoReturn:
    """Run a command in the fork, with standard error to the server, and end with its exit status."""
    status = 1
    try:
        nowhere = os.open(os.devnull, os.O_RDWR)
        for number, stream in ((0, nowhere), (1, nowhere), (2, messages_end)):
            os.dup2(stream, number)
        os.close(nowhere)
        os.close(messages_end)
        threading.Thread(target=_end_with, args=(server,), daemon=True).start()
        from osm2xodr.cli.options import Session
        from osm2xodr.cli.program import main as run_command

        session = Session()
        status = run_command(arguments, session)
        if status and isinstance(session.error, EmptyAreaError):
            status = EMPTY
        sys.stderr.flush()
    finally:
        # Not by `sys.exit`, which would unwind into the code of the server.
        os._exit(status)


def _end_with(server: int) -> None:
    """End this fork soon after the server, which may be killed before it can stop it."""
    while os.getppid() == server:
        time.sleep(_CHECK)
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(_STOP_GRACE)
    os._exit(1)


if __name__ == "__main__":
    main()
