"""Every command on a system that lacks what only POSIX has: signals, forks, locks, and bounds on memory and time."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from batch_runs import made, statuses, write_table, write_village
from small_area import OSM, write_area, write_dem

# Python runs a module of this name at its start, also in the processes that a batch starts.
_TAKEN_AWAY = """
import os, signal, sys
for module, names in (
    (signal, ("SIGHUP", "SIGALRM", "SIGXCPU", "SIGKILL", "setitimer", "alarm", "ITIMER_REAL", "pthread_sigmask")),
    (os, ("fork", "forkpty", "killpg", "getpgid", "setsid", "wait4", "waitid", "fchmod", "fchown", "getuid",
          "sched_getaffinity")),
):
    for name in names:
        if hasattr(module, name):
            delattr(module, name)
sys.modules["fcntl"] = sys.modules["resource"] = None
"""
_COMMANDS = (
    "convert village.osm --dem dem.tif -o a.xodr --html b.html --report-json a.json",
    "check a.xodr",
    "report a.xodr --dem dem.tif --osm village.osm -o a.html",
    "render a.xodr -o a.png",
    "surface dem.tif -o surface.html",
    "locate a.xodr --lon 1.5705 --lat 42.55",
    "export a.xodr --scene scene",
    "export a.xodr --scene scene --overwrite",
    "export a.xodr -o a.geojson",
    "crop a.xodr --roads 1 -o c.xodr",
    "crop a.xodr --roads 2 -o d.xodr",
    "merge c.xodr d.xodr -o m.xodr",
    "explain clearance",
    "fetch --bbox 1.569,42.549,1.575,42.552 --extract village.osm --no-dem -o got --cache cache",
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "sitecustomize.py").write_text(_TAKEN_AWAY, encoding="utf-8")
    write_area(tmp_path)
    write_dem(tmp_path)
    return tmp_path


def start(folder: Path, *words: str) -> subprocess.Popen[str]:
    environment = {**os.environ, "PYTHONPATH": str(folder / "site")}
    command = [sys.executable, "-m", "osm2xodr", *words]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, cwd=folder, env=environment, stdout=pipe, stderr=pipe, text=True)


def run(folder: Path, *words: str) -> tuple[int, str]:
    """Return the exit status of a command and what it said."""
    process = start(folder, *words)
    out, err = process.communicate(timeout=120)
    return process.returncode, out + err


def test_every_command_works(folder: Path) -> None:
    wrong = {}
    for line in _COMMANDS:
        status, said = run(folder, *line.split())
        if status:
            wrong[line] = said
    assert not wrong
    assert (folder / "scene" / "scene.json").is_file()


@pytest.mark.parametrize(("option", "value", "what"), [("--max-memory", "2G", "memory"), ("--timeout", "60", "time")])
def test_bounds_that_cannot_be_are_refused(folder: Path, option: str, value: str, what: str) -> None:
    status, said = run(folder, "convert", "village.osm", "-o", "a.xodr", option, value)
    assert status == 1
    assert said == f"osm2xodr: error: this system cannot bound {what}; leave {option} out\n"


def test_batch(folder: Path) -> None:
    write_area(folder, OSM.replace("42.5515", "42.5516"), "hamlet.osm")
    write_area(folder, "<osm version='0.6'>", "broken.osm")
    areas = "".join(f'[[area]]\nname = "{name}"\nosm = "{name}.osm"\n' for name in ("village", "hamlet", "broken"))
    (folder / "m.toml").write_text(areas, encoding="utf-8")
    status, said = run(folder, "batch", "m.toml", "-o", "out", "--workers", "2")
    assert status == 1
    assert "broken.osm cannot be read as OSM data" in said
    assert statuses(folder / "out") == {"village": "done", "hamlet": "done", "broken": "failed"}
    assert made(folder / "out") == ["hamlet", "village"]


def test_an_interrupted_batch_leaves_nothing_half_written(folder: Path) -> None:
    for number in range(6):
        write_village(folder, number)
    rows = [{"name": f"v{number}", "osm": f"village_{number:02d}.osm"} for number in range(6)]
    table = write_table(folder / "m.csv", rows)
    process = start(folder, "batch", table.name, "-o", "out", "--workers", "2")
    while not made(folder / "out"):
        assert process.poll() is None
        time.sleep(0.05)
    process.terminate()
    _, said = process.communicate(timeout=60)
    assert process.returncode == 143, said
    assert len(made(folder / "out")) < 6
    assert not list((folder / "out").rglob(".osm2xodr-*.part"))
    assert run(folder, "batch", table.name, "-o", "out", "--workers", "2")[0] == 0
    assert len(made(folder / "out")) == 6
