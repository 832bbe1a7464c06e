"""Linear algebra on one thread, and all of them afterwards."""

from __future__ import annotations

import os
import subprocess
import sys

CODE = """
import numpy as np, scipy.sparse.linalg
from osm2xodr.system import one_thread
from osm2xodr.system.threads import _limit

def many() -> int:
    "Count the libraries that use more than one thread."
    undo = _limit()
    for call in undo:
        call()
    return len(undo)

one, other = np.random.default_rng(1).normal(size=(2, 100_000))
before = many()
with one_thread():
    with one_thread():
        pass
    print(float(one @ other).hex(), many())
print(before - many())
"""


def run(threads: str) -> list[str]:
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": threads}
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=True, env=environment)
    return done.stdout.splitlines()


def test_sums_are_those_of_one_thread_and_threads_come_back() -> None:
    one, many = run("1"), run("4")
    assert one == many
    assert one[0].endswith(" 0")
    assert one[1] == "0"
