"""Hostile input for some seconds: only results and clear errors may come of it. `tools/fuzz.py` goes on longer."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from fuzzing import FUZZERS, run_case

TOOL = Path(__file__).parents[2] / "tools" / "fuzz.py"
# Of `make test`, which has half a minute for all of them.
MINUTES = 0.1
FIRST = 1_000_000
# The same seeds on every machine, however fast it is.
MOST = {"dem": "300", "map": "15", "osm": "300", "xodr": "75"}
# Seeds that once found something. What they do changes with the fuzzers: what they found has tests of its own.
ONCE_FAILED = {
    "dem": (1_000_264, 101_000_439),
    "map": (
        1,
        8,
        13,
        19,
        29,
        33,
        38,
        45,
        56,
        71,
        77,
        111,
        124,
        140,
        144,
        220,
        295,
        323,
        673,
        1001,
        1195,
        1276,
        1552,
        1_000_004,
        7_000_074,
        7_000_102,
        7_000_677,
        12_000_066,
    ),
    "osm": (167, 190, 345, 103_005_170),
    "xodr": (103_000_557, 105_001_132),
}


@pytest.mark.parametrize("fuzzer", sorted(FUZZERS))
def test_nothing_breaks(fuzzer: str) -> None:
    """Run in a process of its own, which makes copies of itself: a crash ends none but those."""
    command = [sys.executable, str(TOOL), "--fuzzer", fuzzer, "--minutes", str(MINUTES), "--first", str(FIRST)]
    command += ["--most", MOST[fuzzer]]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    found = re.match(rf"{fuzzer}: ([\d,]+) cases, 0 findings\n", done.stdout)
    assert found, done.stdout
    assert int(found[1].replace(",", "")) > 0, "too slow to find anything"


@pytest.mark.parametrize(("fuzzer", "seed"), [(name, seed) for name, seeds in ONCE_FAILED.items() for seed in seeds])
def test_what_once_failed_does_not_again(fuzzer: str, seed: int) -> None:
    assert run_case(fuzzer, seed) == ""
