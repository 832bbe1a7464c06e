"""Processes of this machine: they need no Dask, live for many areas, and leave nothing of one in the next."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from batch_runs import statuses, write_table, write_village
from small_area import street_grid, write_area

from osm2xodr.batching.area_process import AreaJob, area_environment, end_areas, run_area
from osm2xodr.batching.workers import Workers, running
from osm2xodr.cli import area_server, main
from osm2xodr.errors import Osm2xodrError


def test_a_batch_needs_no_dask(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("distributed", "dask"):
        for module in [item for item in sys.modules if item.split(".")[0] == name]:
            monkeypatch.delitem(sys.modules, module)
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    monkeypatch.chdir(tmp_path)
    write_table(tmp_path / "areas.csv", [{"name": "v", "osm": write_village(tmp_path, 0).name}])
    assert main(["batch", "areas.csv", "-o", "out", "-q"]) == 0
    assert statuses(Path("out")) == {"v": "done"}
    assert main(["batch", "nothing.csv", "-o", "elsewhere", "--scheduler", "tcp://127.0.0.1:9"]) == 1
    said = capsys.readouterr().err
    assert said == (
        "osm2xodr: error: --scheduler needs Dask: pip install 'osm2xodr[batch]', or leave --scheduler out\n"
    )
    assert not Path("elsewhere").exists()


@pytest.fixture
def key(request: pytest.FixtureRequest) -> Iterator[str]:
    yield request.node.name
    end_areas(request.node.name)


def forks() -> list[int]:
    """Return the processes that convert areas for this one."""
    servers = [item for item in psutil.Process().children() if area_server.__name__ in " ".join(item.cmdline())]
    return [fork.pid for server in servers for fork in server.children()]


def test_one_process_converts_area_after_area_until_one_fails(tmp_path: Path, key: str) -> None:
    def job(path: Path) -> AreaJob:
        words = ("convert", str(path), "-o", str(tmp_path / "a.xodr"), "-q", "--overwrite", "--jobs", "1")
        return AreaJob("a", words, area_server.__name__, key, memory=2_000_000_000)

    good, bad = write_area(tmp_path), write_area(tmp_path, "<osm", "bad.osm")
    town = write_area(tmp_path, street_grid(12), "town.osm")
    used = []
    for path, fails in ((good, False), (town, False), (good, False), (bad, True), (good, False)):
        outcome = run_area(job(path))
        assert (outcome.message != "") is fails, outcome.message
        used.append((forks(), outcome.memory))
    # Of the three in the middle the first two were made by the same process, and after the failure by another.
    assert len(used[0][0]) == 1
    assert used[0][0] == used[1][0] == used[2][0]
    assert used[3][0] == []
    assert len(used[4][0]) == 1
    assert used[4][0] != used[0][0]
    # Each has its own peak: that of the town is not the next one's.
    assert used[2][1] < used[1][1]


def test_what_conversions_load_is_loaded_once_for_all(tmp_path: Path) -> None:
    sample = Path(__file__).parents[2] / "data/samples/andorra_ordino"
    words = ["convert", str(sample / "area.osm"), "--dem", str(sample / "dem.tif"), "-o", str(tmp_path / "a.xodr")]
    script = (
        "import sys; from osm2xodr.cli import area_server, main; area_server.load(); known = set(sys.modules);"
        f" status = main({[*words, '-q', '--jobs', '1']}); print(status, sorted(set(sys.modules) - known))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout == "0 []\n"


STUCK = """
import collections, itertools
from osm2xodr import pipeline
from osm2xodr.cli import area_server

pipeline.convert = lambda *_: collections.deque(itertools.repeat(None, 10**12), maxlen=0)
area_server.main()
"""


def test_why_a_conversion_failed_comes_as_a_record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, key: str) -> None:
    """Whether it was refused, or killed in a library that heeds no signal when its time was up."""
    (tmp_path / "stuck.py").write_text(STUCK, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    words = ("convert", str(write_area(tmp_path)), "-o", str(tmp_path / "a.xodr"), "-q", "--timeout", "0.5")
    job = AreaJob("a", words, "stuck", key)
    killed, refused = run_area(job), run_area(dataclasses.replace(job, arguments=(*words, "--name")))
    assert killed.message.startswith("it takes longer than --timeout 0.5 s; allow more")
    assert killed.memory > 20e6
    assert refused.message == "Option '--name' requires an argument."


def test_areas_share_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("osm2xodr.batching.workers.available_memory", lambda: 3_000_000_000)
    taken: list[int] = []

    def run(jobs: list[AreaJob]) -> Iterator[object]:
        taken.extend(job.memory for job in jobs)
        return iter(jobs)

    monkeypatch.setattr("osm2xodr.batching.workers.run_each", run)
    jobs = [AreaJob(name, ()) for name in "abcd"]
    for workers in (Workers("", 2), Workers("", 9), Workers("", 2, memory=250_000_000), Workers("", 100)):
        with running(jobs, workers) as outcomes:
            assert sorted(job.name for job, _ in outcomes) == ["a", "b", "c", "d"]
    assert taken == [1_500_000_000] * 4 + [750_000_000] * 4 + [250_000_000] * 4 + [750_000_000] * 4


def test_what_cannot_be_started_is_said_and_ends_the_batch(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(jobs: list[AreaJob]) -> object:
        raise Osm2xodrError("no process can be started")

    monkeypatch.setattr("osm2xodr.batching.workers.run_each", fail)
    with pytest.raises(Osm2xodrError, match="no process"), running([AreaJob("a", ())], Workers("")) as outcomes:
        list(outcomes)


def test_areas_keep_their_memory_on_workers_of_dask(monkeypatch: pytest.MonkeyPatch) -> None:
    """Dask sets this for its workers (distributed.nanny.pre-spawn-environ)."""
    monkeypatch.setenv("MALLOC_TRIM_THRESHOLD_", "65536")
    monkeypatch.setenv("SOMETHING_ELSE", "kept")
    found = area_environment()
    assert "MALLOC_TRIM_THRESHOLD_" not in found
    assert (found["SOMETHING_ELSE"], found["PROJ_NETWORK"], found["OPENBLAS_NUM_THREADS"]) == ("kept", "OFF", "1")
