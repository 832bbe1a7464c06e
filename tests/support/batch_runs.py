"""Small areas for batches, and batches in processes of their own."""

from __future__ import annotations

import csv
import json
import os
import secrets
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import psutil
from small_area import OSM, write_area

# How long processes may outlive their batch, s.
_ORPHANS_GONE = 15.0
_MARK = "OSM2XODR_TEST_BATCH"


def write_village(folder: Path, number: int) -> Path:
    """Write a map of a few streets, of which no two are alike."""
    text = OSM.replace('lon="1.5740"', f'lon="{1.574 + number * 1e-5:.5f}"').replace(
        "Carrer Major", f"Carrer {number}"
    )
    return write_area(folder, text, f"village_{number:02d}.osm")


def write_table(path: Path, rows: Sequence[Mapping[str, object]]) -> Path:
    """Write a manifest in CSV."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, names, restval="")
        writer.writeheader()
        writer.writerows(rows)
    return path


def statuses(out: Path) -> dict[str, str]:
    """Return the status of each area, as the summary states it."""
    with (out / "summary.csv").open(encoding="utf-8", newline="") as stream:
        return {row["name"]: row["status"] for row in csv.DictReader(stream)}


def made(out: Path) -> list[str]:
    """Return the names of areas that are there."""
    return sorted(path.stem for path in out.glob("*.xodr"))


def noted(out: Path) -> list[str]:
    """Return the names of areas that the batch knows to be done."""
    return sorted(path.stem for path in (out / ".state").glob("*.json"))


@dataclass
class RunningBatch:
    """A batch in a process of its own.

    Parameters
    ----------
    process
        It.
    mark
        Which all of its processes have in their environment.
    """

    process: subprocess.Popen[str]
    mark: str

    def processes(self, words: str = "") -> list[psutil.Process]:
        """Return the processes that it has started, and itself, whose command has some words in it."""
        found = []
        for item in psutil.process_iter():
            try:
                ours = item.environ().get(_MARK) == self.mark and item.status() != psutil.STATUS_ZOMBIE
                if ours and words in " ".join(item.cmdline()):
                    found.append(item)
            except (psutil.NoSuchProcess, psutil.AccessDenied):
                continue
        return found

    def workers(self) -> list[psutil.Process]:
        """Return the processes that have areas converted by forks."""
        found = self.processes("osm2xodr.cli.area_server")
        return [item for item in found if item.ppid() == self.process.pid]

    def listening(self) -> set[str]:
        """Return the addresses at which its processes wait for others."""
        connections = []
        for process in self.processes():
            # Some of them come and go.
            with suppress(psutil.NoSuchProcess):
                connections += process.net_connections()
        return {item.laddr.ip for item in connections if item.status == psutil.CONN_LISTEN}

    def wait_for(self, moment: Callable[[], bool]) -> None:
        """Wait until something is so, or the batch has ended."""
        while self.process.poll() is None and not moment():
            time.sleep(0.01)

    def end(self, seconds: float = 120.0) -> tuple[int, str]:
        """Wait for its end, and return its exit status and what it said."""
        _, said = self.process.communicate(timeout=seconds)
        return self.process.returncode, said

    def orphans(self) -> list[str]:
        """Return the commands of processes that do not end by themselves in time."""
        until = time.monotonic() + _ORPHANS_GONE
        while left := self.processes():
            if time.monotonic() > until:
                commands = [" ".join(item.cmdline()) for item in left]
                for item in left:
                    item.kill()
                return commands
            time.sleep(0.05)
        return []


@dataclass
class Cluster:
    """A scheduler and a worker with two threads, which are somebody else's."""

    address: str
    scheduler: subprocess.Popen[bytes]
    worker: subprocess.Popen[bytes]

    def areas(self) -> list[psutil.Process]:
        """Return what the worker has started for areas."""
        found: list[psutil.Process] = psutil.Process(self.worker.pid).children(recursive=True)
        return found


@contextmanager
def cluster(folder: Path) -> Iterator[Cluster]:
    """Start a scheduler and a worker of Dask in a folder that is made for them."""
    folder.mkdir()
    contact = folder / "scheduler.json"

    def start(program: str, *options: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.dask_{program}", "--host", "127.0.0.1", *options]
        command += ["--no-dashboard", "--scheduler-file", str(contact)]
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=folder)

    processes = [start("scheduler", "--port", "0")]
    try:
        until = time.monotonic() + 30.0
        while not contact.exists() and time.monotonic() < until:
            time.sleep(0.05)
        processes.append(start("worker", "--nthreads", "2", "--no-nanny"))
        yield Cluster(json.loads(contact.read_text())["address"], *processes)
    finally:
        for process in reversed(processes):
            process.terminate()
            process.wait(timeout=20)


@contextmanager
def started(*arguments: object, cwd: Path | None = None) -> Iterator[RunningBatch]:
    """Start ``osm2xodr`` with warnings as errors, in a session of its own."""
    mark = secrets.token_hex(8)
    process = subprocess.Popen(
        [sys.executable, "-m", "osm2xodr", *map(str, arguments)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
        text=True,
        cwd=cwd,
        # One that is killed cannot remove its temporary folder.
        env={**os.environ, "PYTHONWARNINGS": "error", "TMPDIR": str(cwd or "."), _MARK: mark},
    )
    running = RunningBatch(process, mark)
    try:
        yield running
    finally:
        for item in running.processes():
            item.kill()
        process.communicate()
