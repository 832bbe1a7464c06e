"""A process that converts areas one after the other, each in a copy of itself.

It is started by ``python -m osm2xodr.cli.area_server``. It has loaded what conversions need, so that each of them
starts at once; and a conversion that crashes, or is killed for want of memory, ends nothing but its copy. It reads
one line of JSON per area from standard input, the list of arguments of ``osm2xodr``, and answers with one line on
standard output. When its standard input ends, since whoever started it has ended, it stops the conversion that
runs, and ends.
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

# How long a conversion that is to stop has for its temporary files, s, before it is killed.
_BATCH_STOP_GRACE: Final = 3.0
# A process that has not been given an area for so long ends, s; a choice.
_BATCH_IDLE: Final = 60.0

_PRELOADED: Final = (
    "osm2xodr.cli",
    "osm2xodr.pipeline",
    "osm2xodr.batch.partition_file",
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
# How often it looks whether a copy whose standard error stays open has ended, and a copy after its parent, s.
_LOOK: Final = 0.2
# What is kept of what a conversion says, bytes.
_KEPT: Final = 1 << 16


def main() -> None:
    """Serve until standard input ends, or nothing has come for a while."""
    # All that is printed by mistake goes nowhere: standard output is for answers.
    answers = os.dup(1)
    os.dup2(2, 1)
    for name in _PRELOADED:
        # Whatever is missing will be missed, and told of, by the conversion.
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    while line := _next_line():
        answer = _convert(json.loads(line), answers)
        if answer is None:
            return
        os.write(answers, json.dumps(answer).encode() + b"\n")


def _next_line() -> bytes:
    """Return what is asked for next; nothing when it is time to end."""
    line = b""
    while not line.endswith(b"\n"):
        if not select.select([0], [], [], _BATCH_IDLE)[0]:
            return b""
        more = os.read(0, 1 << 16)
        if not more:
            return b""
        line += more
    return line


def _convert(arguments: list[str], answers: int) -> dict[str, object] | None:
    """Run a command in a copy of this process; None if nobody wants its answer any more."""
    said, says = os.pipe()
    server = os.getpid()
    copy = os.fork()
    if copy == 0:
        os.close(said)
        os.close(answers)
        _run(arguments, says, server)
    os.close(says)
    try:
        text, wanted = _listen(said, copy)
    finally:
        os.close(said)
    if not wanted:
        _stop(copy)
        return None
    _, status, usage = os.wait4(copy, 0)
    # Linux counts it in kibibytes, macOS in bytes.
    memory = usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    return {"status": os.waitstatus_to_exitcode(status), "memory": memory, "said": text.decode("utf-8", "replace")}


def _listen(said: int, copy: int) -> tuple[bytes, bool]:
    """Return the last of what a copy says until it ends, and whether anybody still wants to know."""
    text = b""
    while True:
        ready = select.select([said, 0], [], [], _LOOK)[0]
        if 0 in ready:
            return text, False
        if said in ready:
            more = os.read(said, _KEPT)
            if not more:
                return text, True
            text = (text + more)[-_KEPT:]
        elif os.waitid(os.P_PID, copy, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None:
            return text, True


def _stop(copy: int) -> None:
    """End a copy: give it time to clean up, and kill it if that takes too long."""
    os.kill(copy, signal.SIGTERM)
    end = time.monotonic() + _BATCH_STOP_GRACE
    while time.monotonic() < end:
        if os.waitpid(copy, os.WNOHANG)[0]:
            return
        time.sleep(0.02)
    os.kill(copy, signal.SIGKILL)
    os.waitpid(copy, 0)


def _run(arguments: list[str], says: int, server: int) -> NoReturn:
    """Be the copy: run the command with its own standard streams, and end with its exit status."""
    status = 1
    try:
        nowhere = os.open(os.devnull, os.O_RDWR)
        for number, stream in ((0, nowhere), (1, nowhere), (2, says)):
            os.dup2(stream, number)
        os.close(nowhere)
        os.close(says)
        threading.Thread(target=_end_with, args=(server,), daemon=True).start()
        from osm2xodr.cli.options import Session
        from osm2xodr.cli.program import main as run_command

        session = Session()
        status = run_command(arguments, session)
        if status and isinstance(session.error, EmptyAreaError):
            status = EMPTY
        sys.stderr.flush()
    finally:
        # Not the way of `sys.exit`, which would go on in the code of the server.
        os._exit(status)


def _end_with(server: int) -> None:
    """End this copy soon after the server, which may be killed without a chance to stop it."""
    while os.getppid() == server:
        time.sleep(_LOOK)
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(_BATCH_STOP_GRACE)
    os._exit(1)


if __name__ == "__main__":
    main()
