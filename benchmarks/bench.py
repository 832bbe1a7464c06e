"""Run osm2xodr beside SUMO netconvert and CARLA Osm2Odr on the same areas, in turns, and write a table.

    make bench                     the sample, and copies of it up to a million nodes
    make bench AREAS=FOLDER        and all areas in FOLDER/*/area.osm.pbf (or area.osm), with dem.tif if it is there

What counts is how the tools compare on one machine in one run; the seconds are those of this machine.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import osmium
from replicate import Area, count_nodes, replicate

ROOT = Path(__file__).resolve().parents[1]
SAMPLE = ROOT / "data" / "samples" / "andorra_ordino"
TOOLS = ("osm2xodr", "netconvert", "Osm2Odr")
_MEGABYTE = 1e6
_KILOBYTE = 1024
_FILE = re.compile(r"\s+\S*/\S+$")
_STAGE = re.compile(r"^ *([\d.]+) s  (.+)$", re.MULTILINE)
_CARLA = """
import sys, carla
settings = carla.Osm2OdrSettings()
settings.set_osm_way_types([
    "motorway", "motorway_link", "trunk", "trunk_link", "primary", "primary_link", "secondary", "secondary_link",
    "tertiary", "tertiary_link", "unclassified", "residential", "living_street", "service", "road"])
with open(sys.argv[1], encoding="utf-8") as area:
    text = carla.Osm2Odr.convert(area.read(), settings)
with open(sys.argv[2], "w", encoding="utf-8") as out:
    out.write(text)
"""


@dataclass
class Run:
    """What one run of one tool took: s, s, bytes, bytes; None where it failed."""

    wall: float
    cpu: float
    memory: int
    size: int
    stages: dict[str, float] = field(default_factory=dict)


def run(command: Sequence[str], output: Path, limit: float, *, watch: bool = False) -> Run | None:
    """Run a command that writes `output` and measure it with all its children; None if it fails or takes too long.

    Memory is that of the largest process; with `watch`, which costs time, that of all processes together.
    """
    output.unlink(missing_ok=True)
    together = 0
    with tempfile.TemporaryFile("w+") as log:
        began = time.monotonic()
        process = subprocess.Popen(command, stdout=log, stderr=log)
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() - began > limit:
                process.kill()
            if watch:
                together = max(together, memory_of(process.pid))
            time.sleep(0.005)
        wall = time.monotonic() - began
        process.returncode = os.waitstatus_to_exitcode(status)
        log.seek(0)
        text = log.read()
    if process.returncode or not output.exists():
        print(f"failed ({process.returncode}): {' '.join(command)}\n{text[-2000:]}", file=sys.stderr)
        return None
    # Without the files' places, which differ from machine to machine.
    stages = {_FILE.sub("", name): float(seconds) for seconds, name in _STAGE.findall(text)}
    cpu = usage.ru_utime + usage.ru_stime
    # The system's own figure is never below what this process had before it became the command.
    memory = together or usage.ru_maxrss * _KILOBYTE
    return Run(wall, cpu, memory, output.stat().st_size, stages)


def memory_of(pid: int) -> int:
    """Return the memory of a process and all that it started, bytes; what several share counts once. Linux only."""
    total = 0
    try:
        rows = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
        total += sum(int(row.split()[1]) * _KILOBYTE for row in rows if row.startswith("Pss:"))
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except OSError:
        # It has just ended.
        return total
    return total + sum(memory_of(int(child)) for child in children)


def as_xml(area: Area, folder: Path) -> Path:
    """Return the area as .osm, which is all that the other tools read."""
    if area.osm.suffix == ".osm":
        return area.osm
    beside = area.osm.with_suffix("")
    if beside.exists():
        return beside
    target = folder / f"{area.name}.osm"
    if not target.exists():
        writer = osmium.SimpleWriter(str(target))
        for item in osmium.FileProcessor(str(area.osm)):
            writer.add(item)
        writer.close()
    return target


def commands(area: Area, folder: Path) -> dict[str, tuple[list[str], Path]]:
    """Return for each tool what to run, and the file that it writes."""
    xml = as_xml(area, folder)
    sumo = shutil.which("netconvert", path=str(Path(sys.executable).parent)) or "netconvert"
    targets = {tool: folder / f"{area.name}.{tool}.xodr" for tool in TOOLS}
    heights = ["--dem", str(area.dem)] if area.dem else []
    own = [str(Path(sys.executable).parent / "osm2xodr"), "convert", str(area.osm), *heights]
    raster = ["--heightmap.geotiff", str(area.dem)] if area.dem else []
    other = [sumo, "--osm-files", str(xml), *raster, "--keep-edges.by-vclass", "passenger", "--geometry.remove"]
    other += ["--roundabouts.guess", "--ramps.guess", "--junctions.join", "--output.street-names"]
    return {
        "osm2xodr": ([*own, "-o", str(targets["osm2xodr"]), "--overwrite", "-v"], targets["osm2xodr"]),
        "netconvert": ([*other, "--opendrive-output", str(targets["netconvert"])], targets["netconvert"]),
        "Osm2Odr": ([sys.executable, "-c", _CARLA, str(xml), str(targets["Osm2Odr"])], targets["Osm2Odr"]),
    }


def measure(area: Area, folder: Path, repeat: int, limit: float) -> dict[str, list[Run]]:
    """Run all tools in turns; a turn before the others measures memory alone, and warms up the caches of the disk."""
    todo = commands(area, folder)
    runs: dict[str, list[Run]] = {tool: [] for tool in TOOLS}
    memory: dict[str, int] = {}
    for turn in range(repeat + 1):
        for tool, (command, output) in todo.items():
            if turn and tool not in memory:
                continue
            result = run(command, output, limit, watch=turn == 0)
            if result is None:
                memory.pop(tool, None)
            elif turn == 0:
                memory[tool] = result.memory
            else:
                runs[tool].append(replace(result, memory=memory[tool]))
        print(f"{area.name}: turn {turn} of {repeat} done", file=sys.stderr)
    for _, output in todo.values():
        output.unlink(missing_ok=True)
    return runs


def _median(values: Sequence[float]) -> float:
    return statistics.median(values)


def table(results: Sequence[tuple[Area, int, dict[str, list[Run]]]], repeat: int) -> str:
    """Return the page: one row per area and tool, then the stages of osm2xodr."""
    what = f"Medians of {repeat} runs" if repeat > 1 else "One run of each"
    about = [
        f"{what}, in turns, {os.cpu_count()} cores ({platform.machine()}),",
        f"Python {platform.python_version()}. Written by `make bench`.",
        "The ratios are to netconvert. osm2xodr reads .osm.pbf where there is one; netconvert and Osm2Odr .osm.",
        "Both of them have no junction surfaces and no smooth grades; Osm2Odr has no heights at all.",
    ]
    lines = [
        "# Speed",
        "",
        " ".join(about),
        "",
        "| area | nodes | tool | wall s | ratio | CPU s | memory MB | ratio | written MB | ratio |",
        "|---|--:|---|--:|--:|--:|--:|--:|--:|--:|",
    ]
    stages: list[str] = []
    for area, nodes, runs in results:
        base = runs["netconvert"]
        for tool in TOOLS:
            own = runs[tool]
            if not own:
                lines.append(f"| {area.name} | {nodes:,} | {tool} | failed | | | | | | |")
                continue
            cells = [f"{_median([item.wall for item in own]):.2f}"]
            cells.append(_ratio([item.wall for item in own], [item.wall for item in base]))
            cells.append(f"{_median([item.cpu for item in own]):.2f}")
            cells.append(f"{_median([item.memory for item in own]) / _MEGABYTE:.0f}")
            cells.append(_ratio([item.memory for item in own], [item.memory for item in base]))
            cells.append(f"{_median([item.size for item in own]) / _MEGABYTE:.1f}")
            cells.append(_ratio([item.size for item in own], [item.size for item in base]))
            what = f"{tool}{' with heights' if area.dem and tool != 'Osm2Odr' else ''}"
            lines.append(f"| {area.name} | {nodes:,} | {what} | {' | '.join(cells)} |")
        for name in dict.fromkeys(name for item in runs["osm2xodr"] for name in item.stages):
            seconds = _median([item.stages.get(name, 0.0) for item in runs["osm2xodr"]])
            stages.append(f"| {area.name} | {name} | {seconds:.2f} |")
    lines += ["", "## Stages of osm2xodr", "", "| area | stage | s |", "|---|---|--:|", *stages, ""]
    return "\n".join(lines)


def _ratio(own: Sequence[float], base: Sequence[float]) -> str:
    return f"{_median(own) / _median(base):.2f}" if base else ""


def areas_in(folder: Path) -> list[Area]:
    """Return the areas of a folder: one for each folder in it that has an area.osm or area.osm.pbf."""
    found = []
    for place in sorted(folder.iterdir()):
        files = [path for path in (place / "area.osm.pbf", place / "area.osm") if path.exists()]
        dem = place / "dem.tif"
        if files:
            found.append(Area(place.name, files[0], dem if dem.exists() else None))
    return found


def main() -> None:
    """Measure and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--areas", type=Path, help="folder of further areas")
    parser.add_argument("--nodes", type=int, default=1_000_000, help="size of the largest replication")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--limit", type=float, default=900.0, help="s that a run may take")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "benchmarks" / "RESULTS.md")
    options = parser.parse_args()
    sample = Area("sample", SAMPLE / "area.osm", SAMPLE / "dem.tif")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        areas = [sample, *(areas_in(options.areas) if options.areas else [])]
        copies = options.nodes // count_nodes(sample.osm)
        areas += [replicate(sample, count, folder) for count in sorted({max(copies // 8, 1), copies}) if count > 1]
        results = [
            (area, count_nodes(area.osm), measure(area, folder, options.repeat, options.limit)) for area in areas
        ]
    options.output.write_text(table(results, options.repeat), encoding="utf-8")


if __name__ == "__main__":
    main()
