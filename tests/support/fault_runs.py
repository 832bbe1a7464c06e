"""Conversions that are stopped from outside, and what they leave."""

from __future__ import annotations

import os
import random
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

OLD: Final = b"what was there before"
# After so many seconds, or once this holds for the folder.
Moment = float | Callable[[Path], bool]
_PART: Final = re.compile(r"\.osm2xodr-[0-9a-f]{16}\.part")
# How long a copy of a process may outlive it, s.
_ORPHANS_GONE: Final = 5.0


@dataclass(frozen=True)
class Outcome:
    """How a conversion ended, and what it left.

    Parameters
    ----------
    status
        Exit status; negative: killed by that signal.
    target
        ``old``, ``new`` or ``broken``.
    parts
        Temporary files that stayed.
    strange
        Other files that were not there before.
    orphans
        Processes that outlived it.
    message
        What it said on standard error.
    seconds
        How long it ran.
    """

    status: int
    target: str
    parts: tuple[str, ...]
    strange: tuple[str, ...]
    orphans: tuple[int, ...]
    message: str
    seconds: float


def command(*arguments: object) -> list[str]:
    """Return the command line of the converter."""
    return [sys.executable, "-m", "osm2xodr", *map(str, arguments)]


def interrupted(folder: Path, arguments: Sequence[object], new: bytes, at: Moment, number: int) -> Outcome:
    """Convert into a folder with an old result, send a signal, and look at what is there.

    Parameters
    ----------
    folder
        An empty folder.
    arguments
        Of ``convert``, without its target.
    new
        What the target holds if the conversion gets to its end.
    at
        When to send it: after so many seconds, or once this holds for the folder.
    number
        The signal.
    """
    target = folder / "map.xodr"
    target.write_bytes(OLD)
    began = time.monotonic()
    process = subprocess.Popen(
        command("convert", *arguments, "-o", target, "--overwrite", "-q"),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
        text=True,
    )
    if callable(at):
        while process.poll() is None and not at(folder):
            time.sleep(0.001)
    else:
        time.sleep(max(0.0, at - (time.monotonic() - began)))
    process.send_signal(number)
    process.wait(timeout=60)
    seconds = time.monotonic() - began
    orphans = _orphans(process.pid)
    assert process.stderr is not None
    message = process.stderr.read()
    process.stderr.close()
    names = sorted(item.name for item in folder.iterdir() if item != target)
    held = target.read_bytes() if target.is_file() else b""
    return Outcome(
        process.returncode,
        "old" if held == OLD else "new" if held == new else "broken",
        tuple(name for name in names if _PART.fullmatch(name)),
        tuple(name for name in names if not _PART.fullmatch(name)),
        orphans,
        message,
        seconds,
    )


def is_writing(folder: Path) -> bool:
    """Whether the result is being written."""
    return any(_PART.fullmatch(name) for name in os.listdir(folder))


def moments(count: int, first: float, last: float, writing: int, seed: int) -> list[Moment]:
    """Return random moments, s, spread evenly over a time, and then some in which the result is being written."""
    dice = random.Random(seed)
    spread: list[Moment] = [first + (k + dice.random()) * (last - first) / count for k in range(count)]
    return spread + [is_writing] * writing


def _orphans(session: int) -> tuple[int, ...]:
    """Return the processes of a session that do not end by themselves in time."""
    until = time.monotonic() + _ORPHANS_GONE
    while left := _members(session):
        if time.monotonic() > until:
            for pid in left:
                os.kill(pid, signal.SIGKILL)
            return left
        time.sleep(0.05)
    return ()


def _members(session: int) -> tuple[int, ...]:
    found = []
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            try:
                fields = (folder / "stat").read_text().rsplit(")", 1)[1].split()
            except OSError:
                continue
            if int(fields[3]) == session and fields[0] not in "ZX":
                found.append(int(folder.name))
    return tuple(found)
