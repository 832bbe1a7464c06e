"""Commands run apart, and what they refuse."""

from __future__ import annotations

import os
import resource
import subprocess
import sys

# Generous, for machines that do much else; what is not bounded takes minutes.
SECONDS = 60.0


def run(*words: object, **more: str) -> tuple[int, str, float]:
    """Run a command apart; return its exit status, standard error, and the most memory that it had, MB."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    done = subprocess.run(
        [sys.executable, "-m", "osm2xodr", *map(str, words)],
        capture_output=True,
        text=True,
        encoding="utf-8",
        errors="surrogateescape",
        timeout=SECONDS,
        env={**os.environ, **more},
        check=False,
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    return done.returncode, done.stderr, max(before, after) / 1e3


def refusal(status: int, error: str) -> str:
    """Return the one sentence of a refusal."""
    assert status == 1, error
    assert error.startswith("osm2xodr: error: "), error
    assert error.count("\n") == 1
    assert "a defect" not in error
    assert "internal error" not in error
    return error
