"""Batches on workers: all areas come out as if alone, whatever happens to some of them, and stop when asked."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from batch_runs import Cluster, RunningBatch, cluster, made, noted, started, statuses, write_table, write_village
from small_area import street_grid, write_dem

from osm2xodr.batching import workers as running
from osm2xodr.cli import main

AREAS = 40
BROKEN, GREEDY = "area_13", "area_27"
GOOD = [name for name in (f"area_{k:02d}" for k in range(AREAS)) if name not in (BROKEN, GREEDY)]


def write_areas(folder: Path, count: int, **options: object) -> list[dict[str, object]]:
    """Write maps to a folder, and return the rows of a manifest beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    write_dem(folder)
    rows = []
    for k in range(count):
        path = write_village(folder, k)
        dem = f"{folder.name}/dem.tif" if k % 4 == 0 else ""
        rows.append({"name": f"area_{k:02d}", "osm": f"{folder.name}/{path.name}", "dem": dem, **options})
    return rows


@dataclass
class Forty:
    folder: Path
    status: int
    said: str
    made_when_killed: int
    workers: int
    workers_afterwards: int
    listening: set[str]
    killed: str  # The area that was converted just then

    @property
    def out(self) -> Path:
        return self.folder / "out"


@pytest.fixture(scope="module")
def forty(tmp_path_factory: pytest.TempPathFactory) -> Forty:
    """Forty areas on two workers, of which one is killed half-way; one map is broken, and one is too large."""
    folder = tmp_path_factory.mktemp("forty")
    rows = write_areas(folder / "maps", AREAS)
    by_name = {row["name"]: row for row in rows}
    (folder / str(by_name[BROKEN]["osm"])).write_text("<osm version='0.6'><node id='1' lat='42.5'", encoding="utf-8")
    (folder / str(by_name[GREEDY]["osm"])).write_text(street_grid(90), encoding="utf-8")
    by_name[GREEDY]["max-memory"] = "200M"
    write_table(folder / "areas.csv", rows)
    write_table(folder / "good.csv", [by_name[name] for name in GOOD])
    with started("batch", "areas.csv", "-o", "out", "--workers", 2, cwd=folder) as batch:
        batch.wait_for(lambda: len(made(folder / "out")) >= 10)
        workers = batch.workers()
        listening = batch.listening()
        before = len(made(folder / "out"))
        # The other one must not do all the rest before the first has a successor.
        workers[1].suspend()
        workers[0].kill()
        seen: set[int] = set()

        def replaced() -> bool:
            seen.update(item.pid for item in batch.workers())
            return len(seen - {workers[0].pid}) > 1

        batch.wait_for(replaced)
        workers[1].resume()
        afterwards = len(seen - {workers[0].pid})
        status, said = batch.end()
        assert batch.orphans() == []
    (killed,) = {name for name in GOOD if statuses(folder / "out")[name] == "failed"}
    return Forty(folder, status, said, before, len(workers), afterwards, listening, killed)


def test_a_worker_was_killed_half_way_and_replaced(forty: Forty) -> None:
    assert forty.workers == 2
    assert 10 <= forty.made_when_killed < len(GOOD)
    assert forty.workers_afterwards >= 2


def test_nobody_can_reach_the_workers(forty: Forty) -> None:
    assert forty.listening == set()


def test_bad_areas_fail_with_a_sentence_each(forty: Forty) -> None:
    assert forty.status == 1
    # Slow machines have lines of progress besides.
    (first,) = (line for line in forty.said.splitlines() if line.startswith(f"osm2xodr: {AREAS} areas in "))
    errors = [line for line in forty.said.splitlines() if line.startswith("osm2xodr: error: ")]
    assert first.endswith(f" s: {AREAS - 3} done, 3 failed; see out"), forty.said
    assert len(errors) == 3, forty.said
    (killed,) = (line for line in errors if line.startswith(f"osm2xodr: error: {forty.killed}: "))
    assert killed.startswith(f"osm2xodr: error: {forty.killed}: its process was killed, perhaps for want of memory")
    errors.remove(killed)
    assert errors[0].startswith(f"osm2xodr: error: {BROKEN}: maps/village_13.osm cannot be read as OSM data (")
    # Where memory ends first, in which library, is a matter of chance.
    assert errors[1].startswith(f"osm2xodr: error: {GREEDY}: ")
    assert "memory" in errors[1], forty.said
    assert "Traceback" not in forty.said


def test_all_others_are_done(forty: Forty) -> None:
    assert statuses(forty.out) == {
        name: "failed" if name in (BROKEN, GREEDY, forty.killed) else "done"
        for name in (f"area_{k:02d}" for k in range(AREAS))
    }
    files = {path.relative_to(forty.out).as_posix() for path in forty.out.rglob("*") if path.is_file()}
    good = [name for name in GOOD if name != forty.killed]
    expected = {f"{name}{ending}" for name in good for ending in (".xodr", ".json")}
    states = {".state/lock", *(f".state/{name}{ending}" for name in good for ending in (".json", ".png"))}
    assert files == expected | states | {"summary.csv", "index.html"}


def test_results_are_those_of_single_runs(forty: Forty, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(forty.folder / "maps", tmp_path / "maps")
    (tmp_path / "out").mkdir()
    monkeypatch.chdir(tmp_path)
    for k, name in ((k, f"area_{k:02d}") for k in range(AREAS)):
        if name not in GOOD or name == forty.killed:
            continue
        dem = ["--dem", "maps/dem.tif"] if k % 4 == 0 else []
        report = ["--report-json", f"out/{name}.json", "--name", name]
        assert main(["convert", f"maps/village_{k:02d}.osm", *dem, "-o", f"out/{name}.xodr", *report, "-q"]) == 0
        for ending in (".xodr", ".json"):
            file = f"out/{name}{ending}"
            assert (tmp_path / file).read_bytes() == (forty.folder / file).read_bytes(), file


def test_started_again_it_makes_what_failed_and_then_nothing(forty: Forty) -> None:
    there = set(made(forty.out))
    with started("batch", "good.csv", "-o", "out", cwd=forty.folder) as batch:
        code, said = batch.end()
    assert code == 0
    assert said.endswith(f" s: 1 done, {AREAS - 3} unchanged; see out\n")
    assert set(made(forty.out)) - there == {forty.killed}
    kept = [path for path in forty.out.rglob("area_*") if path.is_file()]
    before = {path: (path.stat().st_mtime_ns, path.stat().st_ino) for path in kept}
    program = (
        "import sys, time; from osm2xodr.cli import main; began = time.process_time()\n"
        "status = main(['batch', 'good.csv', '-o', 'out'])\n"
        "print(status, 'distributed' in sys.modules, time.process_time() - began)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False, cwd=forty.folder
    )
    assert done.returncode == 0, done.stderr
    status, dask, seconds = done.stdout.split()
    assert (status, dask) == ("0", "False")
    assert float(seconds) < 2.0
    assert " s: 38 unchanged; see out" in done.stderr
    assert {path: (path.stat().st_mtime_ns, path.stat().st_ino) for path in kept} == before
    assert set(statuses(forty.out).values()) == {"unchanged"}


def is_clean(batch: RunningBatch, out: Path) -> bool:
    """Whether nothing of a batch runs any more, and nothing half-written is there."""
    for path in out.glob("*.xodr"):
        assert path.read_bytes().endswith(b"</OpenDRIVE>\n")
        assert path.with_suffix(".json").exists()
    return batch.orphans() == [] and list(out.rglob("*.part")) == []


@pytest.mark.parametrize("count", [0, 2])
def test_ctrl_c_stops_it_and_the_same_command_goes_on(tmp_path: Path, count: int) -> None:
    out = tmp_path / "out"
    write_table(tmp_path / "areas.csv", write_areas(tmp_path / "maps", 12))
    with started("batch", "areas.csv", "-o", "out", "--workers", 2, cwd=tmp_path) as batch:
        batch.wait_for(lambda: len(noted(out)) >= count and bool(batch.workers()))
        before = noted(out)
        # As a terminal does it: to all processes of the group.
        os.killpg(batch.process.pid, signal.SIGINT)
        began = time.monotonic()
        status, said = batch.end()
        seconds = time.monotonic() - began
        assert is_clean(batch, out)
    assert status == 130
    assert said.count("\n") == 1
    assert said.startswith("osm2xodr: error: interrupted")
    assert seconds < 20.0
    there = noted(out)
    assert count <= len(before) <= len(there) < 12
    assert set(before) <= set(there) <= set(made(out))
    assert not (out / "summary.csv").exists()
    with started("batch", "areas.csv", "-o", "out", "--workers", 2, cwd=tmp_path) as batch:
        assert batch.end()[0] == 0
    found = statuses(out)
    # What ended just as it was interrupted is made again.
    assert sorted(name for name, status in found.items() if status == "unchanged") == there
    assert sorted(found) == made(out) == [f"area_{k:02d}" for k in range(12)]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_a_batch_that_is_ended_leaves_no_processes(tmp_path: Path, number: signal.Signals) -> None:
    out = tmp_path / "out"
    write_table(tmp_path / "areas.csv", write_areas(tmp_path / "maps", 8))
    with started("batch", "areas.csv", "-o", "out", "--workers", 2, cwd=tmp_path) as batch:
        batch.wait_for(lambda: len(made(out)) >= 1)
        batch.process.send_signal(number)
        status, said = batch.end()
        if number == signal.SIGKILL:
            # Nobody can keep it from leaving the record that it was writing; its areas clean up.
            assert batch.orphans() == []
            assert len(list((out / ".state").glob("*.part"))) <= 1
            (out / ".state" / ".osm2xodr-0123456789abcdef.part").write_text("half", encoding="utf-8")
            assert list(out.glob("*.part")) == []
        else:
            assert is_clean(batch, out)
    assert status == (143 if number == signal.SIGTERM else -number)
    assert said == ("osm2xodr: error: ended by the system\n" if number == signal.SIGTERM else "")
    with started("batch", "areas.csv", "-o", "out", "--workers", 2, cwd=tmp_path) as batch:
        assert batch.end()[0] == 0
        assert is_clean(batch, out)
    assert made(out) == [f"area_{k:02d}" for k in range(8)]


def test_an_existing_scheduler_is_used_and_left_alone(tmp_path: Path) -> None:
    rows = write_areas(tmp_path / "maps", 6)
    write_table(tmp_path / "areas.csv", rows)
    with cluster(tmp_path / "elsewhere") as dask:
        for expected in ("6 done", "6 unchanged"):
            with started("batch", "areas.csv", "-o", "out", "--scheduler", dask.address, cwd=tmp_path) as batch:
                status, said = batch.end()
                assert batch.processes() == []
            assert (status, said.count("\n")) == (0, 1)
            assert f": {expected}; see out" in said
        assert made(tmp_path / "out") == [row["name"] for row in rows]
        assert [process.poll() for process in (dask.scheduler, dask.worker)] == [None, None]


@contextmanager
def begun_elsewhere(folder: Path, dask: Cluster) -> Iterator[RunningBatch]:
    """Start a batch of twelve areas on somebody else's worker, and wait for the first."""
    write_table(folder / "areas.csv", write_areas(folder / "maps", 12))
    with started("batch", "areas.csv", "-o", "out", "--scheduler", dask.address, cwd=folder) as batch:
        batch.wait_for(lambda: len(noted(folder / "out")) >= 1)
        yield batch


def test_ctrl_c_stops_areas_on_workers_elsewhere_and_nothing_else(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with cluster(tmp_path / "elsewhere") as dask:
        with begun_elsewhere(tmp_path, dask) as batch:
            batch.process.send_signal(signal.SIGINT)
            status, said = batch.end()
            assert is_clean(batch, out)
        assert (status, said.count("\n")) == (130, 1)
        until = time.monotonic() + 10.0
        while dask.areas() and time.monotonic() < until:
            time.sleep(0.05)
        assert dask.areas() == []
        there = noted(out)
        assert 1 <= len(there) < 12
        with started("batch", "areas.csv", "-o", "out", "--scheduler", dask.address, cwd=tmp_path) as batch:
            assert batch.end()[0] == 0
        assert sorted(name for name, status in statuses(out).items() if status == "unchanged") == there
        assert [process.poll() for process in (dask.scheduler, dask.worker)] == [None, None]


def test_a_scheduler_that_dies_is_told_of(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with cluster(tmp_path / "elsewhere") as dask:
        with begun_elsewhere(tmp_path, dask) as batch:
            dask.scheduler.kill()
            status, said = batch.end()
        assert status == 1
        assert said.startswith("osm2xodr: error: the Dask scheduler is gone")
        assert said.count("\n") == 1
    # What is there is whole.
    assert set(noted(out)) <= set(made(out))
    assert is_clean(batch, out)


def test_a_scheduler_that_is_not_there_is_told_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(running, "_CONNECT_TIMEOUT", 1.0)
    table = write_table(tmp_path / "areas.csv", write_areas(tmp_path / "maps", 1))
    assert main(["batch", str(table), "-o", str(tmp_path / "out"), "--scheduler", "tcp://127.0.0.1:9"]) == 1
    said = capsys.readouterr().err
    assert said.startswith("osm2xodr: error: no Dask scheduler answers at tcp://127.0.0.1:9; start one there")
    assert said.count("\n") == 1
