"""Cut a large map into tiles that fit: how CPU time and memory grow with the map.

``python benchmarks/country.py AREA.osm DEM.tif FOLDER COPIES...`` replicates an area so often, each time makes tiles
of 5 km of it, and prints a line of a table: nodes, tiles, CPU seconds and peak memory of the main process, that reads
and cuts the map, and the same of its workers.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

from replicate import Area, count_nodes, replicate

_RUN = """
import json, resource, sys
from osm2xodr.cli import main
status = main(sys.argv[1:])
own, others = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
cpu = [item.ru_utime + item.ru_stime for item in (own, others)]
print(json.dumps([status, *cpu, own.ru_maxrss, others.ru_maxrss]))
"""


def measure(area: Area, folder: Path, workers: int) -> str:
    """Make the tiles of an area, and return a row of the table."""
    out = folder / f"{area.name}_tiles"
    dem = ["--dem", str(area.dem)] if area.dem is not None else []
    options = ["--tiles", "5km", "--shared-frame", "--force", "--workers", str(workers), "-q"]
    words = ["batch", "--from", str(area.osm), *dem, *options, "-o", str(out)]
    began = time.monotonic()
    found = subprocess.run([sys.executable, "-c", _RUN, *words], check=True, capture_output=True, text=True)
    wall = time.monotonic() - began
    status, main_cpu, workers_cpu, main_kib, most_kib = json.loads(found.stdout.splitlines()[-1])
    if status:
        raise SystemExit(found.stderr)
    tiles, nodes = len(list(out.glob("x*.xodr"))), count_nodes(area.osm)
    each = workers_cpu / tiles
    return (
        f"| {nodes:,} | {tiles} | {main_cpu:.1f} | {1e6 * main_cpu / nodes:.1f} | {main_kib / 1024:.0f} |"
        f" {workers_cpu:.1f} | {each:.2f} | {most_kib / 1024:.0f} | {wall:.0f} |"
    )


def main() -> None:
    """Measure one size after the other."""
    osm, dem, folder = (Path(word) for word in sys.argv[1:4])
    print("| nodes | tiles | main CPU s | us per node | main MB | workers CPU s | s per tile | worker MB | wall s |")
    print("|--:|--:|--:|--:|--:|--:|--:|--:|--:|")
    for copies in map(int, sys.argv[4:]):
        print(measure(replicate(Area("sample", osm, dem), copies, folder), folder, 1), flush=True)


if __name__ == "__main__":
    main()
