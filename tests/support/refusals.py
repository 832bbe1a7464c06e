"""Commands run apart, and what they refuse."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile

# Generous, for machines that do much else; what is not bounded takes minutes.
SECONDS = 60.0


# Runs a command and says how much memory it had. A process that is forked off this one would begin with what it has.
_MEASURED = """
import os, resource, subprocess, sys
status = subprocess.run([sys.executable, "-m", "osm2xodr", *sys.argv[2:]]).returncode
with open(sys.argv[1], "w") as stream:
    stream.write(str(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss))
if status < 0:
    os.kill(os.getpid(), -status)
sys.exit(status)
"""


def run(*words: object, **more: str) -> tuple[int, str, float]:
    """Run a command apart; return its exit status, standard error, and the most memory that it had, MB."""
    with tempfile.NamedTemporaryFile("r", encoding="ascii") as memory:
        done = subprocess.run(
            [sys.executable, "-c", _MEASURED, memory.name, *map(str, words)],
            capture_output=True,
            text=True,
            encoding="utf-8",
            errors="surrogateescape",
            timeout=SECONDS,
            env={**os.environ, **more},
            check=False,
        )
        return done.returncode, done.stderr, float(memory.read() or "nan") / 1e3


def refusal(status: int, error: str) -> str:
    """Return the one sentence of a refusal."""
    assert status == 1, error
    assert error.startswith("osm2xodr: error: "), error
    assert error.count("\n") == 1
    assert "a defect" not in error
    assert "internal error" not in error
    return error
