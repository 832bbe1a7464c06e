"""Stops conversions at random moments and prints what they leave.

python tools/faults.py --runs 50
python tools/faults.py --runs 50 --signal TERM --area AREA.osm --dem DEM.tif
"""

from __future__ import annotations

import argparse
import collections
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from fault_runs import command, interrupted, moments

SAMPLE = Path(__file__).parents[1] / "data" / "samples" / "andorra_ordino"
SIGNALS = {"KILL": signal.SIGKILL, "TERM": signal.SIGTERM, "INT": signal.SIGINT, "HUP": signal.SIGHUP}


def main() -> int:
    """Run what the command line asks for; 1 if anything was left half."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=50, help="at random moments; a fifth more while writing")
    parser.add_argument("--signal", choices=sorted(SIGNALS), default="KILL")
    parser.add_argument("--area", type=Path, default=SAMPLE / "area.osm")
    parser.add_argument("--dem", type=Path, default=SAMPLE / "dem.tif")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    arguments = [given.area, "--dem", given.dem, "--jobs", given.jobs]
    with tempfile.TemporaryDirectory() as place:
        whole = Path(place) / "whole.xodr"
        began = time.monotonic()
        subprocess.run(command("convert", *arguments, "-o", whole, "-q"), check=True)
        longest = time.monotonic() - began
        print(f"undisturbed: {longest:.1f} s, {whole.stat().st_size:,} bytes", flush=True)
        when = moments(given.runs, 0.0, longest, given.runs // 5, given.seed)
        counts: collections.Counter[str] = collections.Counter()
        failed = 0
        for k, at in enumerate(when):
            folder = Path(place) / str(k)
            folder.mkdir()
            seen = interrupted(folder, arguments, whole.read_bytes(), at, SIGNALS[given.signal])
            counts[f"{seen.target} result, exit status {seen.status}, {len(seen.parts)} temporary files"] += 1
            bad = seen.target == "broken" or seen.strange or seen.orphans or "Traceback" in seen.message
            if bad or (seen.parts and given.signal != "KILL"):
                failed += 1
                print(f"at {at}: {seen}", flush=True)
    for what, count in sorted(counts.items()):
        print(f"{count:4d}  {what}")
    print(f"{len(when)} runs ended by SIG{given.signal}, {failed} left what they should not")
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
