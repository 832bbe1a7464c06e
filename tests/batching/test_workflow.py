"""Which areas a batch makes anew, and what it leaves of those that it cannot make."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import secrets
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import psutil
import pytest
from batch_runs import made, statuses, write_table, write_village
from small_area import OSM, write_area, write_dem

import osm2xodr
from osm2xodr import __version__
from osm2xodr.batching import workflow
from osm2xodr.batching.area_process import AreaJob, Outcome, end_areas, run_area
from osm2xodr.batching.kept_cuts import load_state, save_state
from osm2xodr.batching.out_dir import open_out_dir
from osm2xodr.batching.workers import Workers
from osm2xodr.cli import area_server, main


class Here:
    """Runs areas in this process, one after the other, and remembers which."""

    def __init__(self) -> None:
        self.jobs: list[AreaJob] = []
        # Processes for areas stay in the folder that they were started in.
        self.key = secrets.token_hex(8)

    @contextmanager
    def running(self, jobs: Sequence[AreaJob], workers: Workers) -> Iterator[Iterator[tuple[AreaJob, Outcome]]]:
        def outcomes() -> Iterator[tuple[AreaJob, Outcome]]:
            for job in jobs:
                self.jobs.append(job)
                yield job, run_area(dataclasses.replace(job, server=workers.server, batch=self.key))

        yield outcomes()

    def taken(self) -> list[str]:
        names = [job.name for job in self.jobs]
        self.jobs.clear()
        return names


@contextmanager
def running_here(folder: Path) -> Iterator[Here]:
    """Run batches in a folder."""
    found = Here()
    with pytest.MonkeyPatch.context() as patches:
        patches.setattr(workflow, "running", found.running)
        patches.chdir(folder)
        yield found
    end_areas(found.key)


@pytest.fixture(scope="module")
def three_villages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a batch that has been made."""
    folder = tmp_path_factory.mktemp("three")
    write_dem(folder)
    rows = [{"name": f"v{k}", "osm": write_village(folder, k).name} for k in range(3)]
    rows[0]["dem"] = "dem.tif"
    write_table(folder / "areas.csv", rows)
    with running_here(folder) as found:
        assert main(["batch", "areas.csv", "-o", "out"]) == 0
    assert sorted(found.taken()) == ["v0", "v1", "v2"]
    return folder


@pytest.fixture
def here(three_villages: Path, tmp_path: Path) -> Iterator[Here]:
    """Batches in a copy of this folder, all files of which have the same times."""
    shutil.copytree(three_villages, tmp_path, dirs_exist_ok=True)
    with running_here(tmp_path) as found:
        yield found


AREA_SERVER = area_server.__name__
SAMPLE = Path(__file__).parents[2] / "data" / "samples" / "andorra_ordino" / "area.osm"


def again(*more: str) -> int:
    return main(["batch", "areas.csv", "-o", "out", *more])


def test_batches_from_python_are_those_of_the_command(here: Here) -> None:
    results = osm2xodr.batch("out", "areas.csv")
    assert [(item.name, item.status) for item in results] == [(f"v{k}", "unchanged") for k in range(3)]
    ended: list[str] = []
    options: osm2xodr.AreaKeywords = {
        "default_lane_width": 3.0,
        "ways": ["tertiary", "residential"],
        "left_hand": False,
    }
    results = osm2xodr.batch(
        Path("out"),
        manifest="areas.csv",
        timeout="10min",
        max_memory="2G",
        on_end=lambda result: ended.append(result.name),
        **options,
    )
    assert [item.status for item in results] == ["done"] * 3
    assert sorted(ended) == sorted(here.taken()) == ["v0", "v1", "v2"]
    words = "--right-hand --default-lane-width 3 --ways tertiary,residential"
    assert again("--options", words) == 0
    assert here.taken() == []
    if TYPE_CHECKING:
        osm2xodr.batch("out", "areas.csv", wais="major")  # type: ignore[call-arg]


@pytest.mark.parametrize(
    ("keywords", "words"),
    [
        ({}, "give either a MANIFEST, or a map with source"),
        ({"manifest": "areas.csv", "shared_frame": True}, "shared_frame needs areas of one map; give it with source"),
        ({"source": "village_01.osm"}, "source needs either tiles, such as tiles 5km, or areas FILE"),
        ({"source": "village_01.osm", "tiles": "wide"}, "tiles: "),
        ({"manifest": "areas.csv", "ways": "footway"}, "ways: 'footway' is not a kind of way"),
        ({"manifest": "areas.csv", "name": "x"}, "name cannot be given to areas of a batch; leave it out"),
    ],
)
def test_batches_from_python_that_cannot_be(here: Here, keywords: dict[str, Any], words: str) -> None:
    with pytest.raises(osm2xodr.OptionError, match=words):
        osm2xodr.batch("out", **keywords)
    assert here.taken() == []


def test_what_is_unchanged_is_left_alone(here: Here) -> None:
    assert again() == 0
    assert here.taken() == []
    assert statuses(Path("out")) == dict.fromkeys(["v0", "v1", "v2"], "unchanged")
    assert again("--force") == 0
    assert sorted(here.taken()) == ["v0", "v1", "v2"]


def test_a_file_that_is_written_again_with_the_same_content_is_unchanged(here: Here) -> None:
    path = Path("village_01.osm")
    os.utime(path, ns=(1, 1))
    assert again() == 0
    assert here.taken() == []
    state = load_state(Path("out/.state/v1.json"))
    assert state is not None
    assert [mark.mtime_ns for mark in state.inputs] == [1]


@pytest.mark.parametrize(
    ("change", "anew"),
    [
        (lambda: write_area(Path(), OSM.replace("Carrer", "Rue"), "village_01.osm"), ["v1"]),
        (lambda: write_dem(Path(), columns=50), ["v0"]),
        (lambda: Path("out/v2.xodr").unlink(), ["v2"]),
        (lambda: Path("out/v2.json").write_text("{}"), ["v2"]),
        (lambda: Path("out/.state/v1.json").write_text("{"), ["v1"]),
        (lambda: Path("out/.state/v1.json").write_text('{"format": 0}'), ["v1"]),
        (lambda: write_table(Path("areas.csv"), [{"name": "v1", "osm": "village_01.osm", "ways": "all"}]), ["v1"]),
        (lambda: write_table(Path("areas.csv"), [{"name": "v1", "osm": "village_01.osm", "timeout": "1h"}]), []),
        (lambda: write_table(Path("areas.csv"), [{"name": "v3", "osm": "village_01.osm"}]), ["v3"]),
    ],
    ids=["map", "dem", "gone", "altered", "no-state", "other-format", "option", "bound", "name"],
)
def test_what_has_changed_is_made_anew(here: Here, change: object, anew: list[str]) -> None:
    assert callable(change)
    change()
    assert again() == 0
    assert sorted(here.taken()) == anew
    assert again() == 0
    assert here.taken() == []


VIRTUAL = """<VRTDataset rasterXSize="60" rasterYSize="40"><SRS>EPSG:4326</SRS>
<GeoTransform>1.565, 0.0002777777777777778, 0, 42.556, 0, -0.0002777777777777778</GeoTransform>
<VRTRasterBand dataType="Float32" band="1"><SimpleSource>
<SourceFilename relativeToVRT="1">part.tif</SourceFilename><SourceBand>1</SourceBand>
</SimpleSource></VRTRasterBand></VRTDataset>"""


def test_what_lies_behind_a_virtual_elevation_model_counts(here: Here) -> None:
    write_dem(Path(), "part.tif")
    Path("dem.vrt").write_text(VIRTUAL)
    write_table(Path("areas.csv"), [{"name": "v1", "osm": "village_01.osm", "dem": "dem.vrt"}])
    for anew in (["v1"], []):
        assert again() == 0
        assert here.taken() == anew
    write_dem(Path(), "part.tif", columns=50)
    assert again() == 0
    assert here.taken() == ["v1"]
    # What cannot be read is for the conversion to say.
    Path("dem.vrt").write_text("<VRTDataset>")
    assert again() == 1
    assert statuses(Path("out")) == {"v1": "failed"}


def test_another_version_makes_all_anew(here: Here, monkeypatch: pytest.MonkeyPatch) -> None:
    path = Path("out/.state/v1.json")
    path.write_text(path.read_text().replace('"version": "', '"version": "0.0.'))
    assert again() == 0
    assert here.taken() == ["v1"]


def test_an_area_that_fails_leaves_nothing_and_stops_no_other(here: Here, capsys: pytest.CaptureFixture[str]) -> None:
    Path("village_01.osm").write_text("<osm", encoding="utf-8")
    Path("village_02.osm").unlink()
    capsys.readouterr()
    assert again("-q") == 1
    said = capsys.readouterr().err.splitlines()
    assert said[0].startswith("osm2xodr: error: v1: village_01.osm ")
    assert said[1:] == ["osm2xodr: error: v2: village_02.osm does not exist; check the path of the OSM file"]
    assert statuses(Path("out")) == {"v0": "unchanged", "v1": "failed", "v2": "failed"}
    assert sorted(path.name for path in Path("out").rglob("*") if path.name.startswith("v")) == [
        "v0.json",
        "v0.json",
        "v0.png",
        "v0.xodr",
    ]


def test_areas_that_are_no_longer_asked_for_stay(here: Here, capsys: pytest.CaptureFixture[str]) -> None:
    write_table(Path("areas.csv"), [{"name": "v1", "osm": "village_01.osm"}])
    capsys.readouterr()
    assert again() == 0
    assert "  note: old-areas: files of areas that are no longer in the batch stay: v0, v2" in capsys.readouterr().err
    assert made(Path("out")) == ["v0", "v1", "v2"]
    assert statuses(Path("out")) == {"v1": "unchanged"}


def test_one_batch_at_a_time(here: Here, capsys: pytest.CaptureFixture[str]) -> None:
    with open_out_dir(Path("out")):
        assert again("--force") == 1
    assert "another batch works in out; wait for its end, or choose another -o" in capsys.readouterr().err
    assert here.taken() == []


def test_what_killed_processes_left_is_removed(here: Here) -> None:
    for folder in ("out", "out/.state"):
        Path(folder, ".osm2xodr-0123456789abcdef.part").touch()
    assert again() == 0
    assert list(Path("out").rglob("*.part")) == []


def test_cut_areas(here: Here, capsys: pytest.CaptureFixture[str]) -> None:
    """The street runs from 1.5700 to 1.5740 E; nothing is in the last area."""
    boxes = {"west": "1.569,42.549,1.571,42.551", "all": "1.56,42.54,1.58,42.56", "sea": "3.0,42.5,3.1,42.6"}
    rows = [{"name": name, "osm": "village_00.osm", "bbox": box} for name, box in boxes.items()]
    write_table(Path("areas.csv"), rows)
    assert again() == 0
    assert here.taken() == ["all", "west"]
    found = {"west": "done", "all": "done", "sea": "empty"}
    assert statuses(Path("out")) == found
    assert sorted(path.name for path in Path("out/.cuts").glob("*.pbf")) == ["all.osm.pbf", "west.osm.pbf"]
    assert again() == 0
    assert here.taken() == []
    assert statuses(Path("out")) == {"west": "unchanged", "all": "unchanged", "sea": "empty"}
    # What changes elsewhere in the map changes no cut.
    node = '<node id="90" lat="40.1" lon="1.1"/><node id="91" lat="40.1" lon="1.2"/>'
    way = '<way id="99"><nd ref="90"/><nd ref="91"/><tag k="highway" v="primary"/></way>'
    text = Path("village_00.osm").read_text(encoding="utf-8")
    Path("village_00.osm").write_text(text.replace("</osm>", f"{node}{way}</osm>"), encoding="utf-8")
    assert again() == 0
    assert here.taken() == []
    Path("village_00.osm").write_text(text.replace("residential", "service"), encoding="utf-8")
    assert again() == 0
    assert set(here.taken()) <= {"all", "west"}
    assert Path("out/.cuts/all.osm.pbf").exists()


def test_corrections_are_for_all_areas(here: Here, capsys: pytest.CaptureFixture[str]) -> None:
    """Each applies what lies in it; what matches nothing is told over the whole."""
    known = Path("known.toml")
    known.write_text("way.10.lanes = 3\nway.11.drop = true\nway.99.width = 6.0\n", encoding="utf-8")
    boxes = {"west": "1.569,42.549,1.571,42.551", "all": "1.56,42.54,1.58,42.56"}
    write_table(Path("areas.csv"), [{"name": name, "osm": "village_00.osm", "bbox": boxes[name]} for name in boxes])
    assert again("--corrections", "known.toml") == 0
    assert here.taken() == ["all", "west"]

    def told(name: str) -> list[tuple[str, str]]:
        found = json.loads(Path(f"out/{name}.json").read_bytes())["diagnostics"]
        return [(item["code"], item["osm_id"]) for item in found if item["code"].startswith("correction")]

    assert told("west") == [("correction", "way/10")]
    assert sorted(told("all")) == [("correction", "way/10"), ("correction", "way/11")]
    unused = "note: correction-unused: width: it matches nothing in any area, or changes nothing there (way/99)"
    said = capsys.readouterr().err
    assert said.count("correction-unused") == 1
    assert unused in said
    assert again("--corrections", "known.toml") == 0
    assert here.taken() == []
    assert unused in capsys.readouterr().err
    known.write_text("way.10.lanes = 4\n", encoding="utf-8")
    assert again("--corrections", "known.toml") == 0
    assert here.taken() == ["all", "west"]
    assert "correction-unused" not in capsys.readouterr().err
    known.write_text("way.10.lanes = many\n", encoding="utf-8")
    assert again("--corrections", "known.toml") == 1
    assert "known.toml is not TOML" in capsys.readouterr().err
    assert here.taken() == []


def test_a_way_that_is_kept_makes_an_area(here: Here) -> None:
    Path("known.toml").write_text('way.11.keep = "service"\n', encoding="utf-8")
    text = Path("village_00.osm").read_text(encoding="utf-8").replace('"residential"', '"footway"')
    Path("village_00.osm").write_text(text, encoding="utf-8")
    write_table(Path("areas.csv"), [{"name": "north", "osm": "village_00.osm", "bbox": "1.56,42.551,1.58,42.56"}])
    assert again() == 0
    assert statuses(Path("out")) == {"north": "empty"}
    assert again("--corrections", "known.toml") == 0
    assert statuses(Path("out")) == {"north": "done"}


def test_an_area_without_ways_that_are_asked_for_is_empty(here: Here) -> None:
    rows = [{"name": "cut", "osm": "village_00.osm", "bbox": "1.56,42.54,1.58,42.56"}]
    write_table(Path("areas.csv"), rows)
    for _ in range(2):
        assert again("--options", "--ways motorway") == 0
        # Which the cut knows without a conversion.
        assert here.taken() == []
        assert statuses(Path("out")) == {"cut": "empty"}
    assert again() == 0
    assert here.taken() == ["cut"]
    assert statuses(Path("out")) == {"cut": "done"}


def test_an_area_of_which_the_conversion_leaves_nothing_is_empty(here: Here) -> None:
    """Its only way begins and ends at the same place."""
    nodes = "".join(f'<node id="{k}" lat="42.55" lon="1.57"/>' for k in (1, 2))
    way = '<way id="1"><nd ref="1"/><nd ref="2"/><tag k="highway" v="primary"/></way>'
    Path("point.osm").write_text(f'<osm version="0.6">{nodes}{way}</osm>', encoding="utf-8")
    write_table(Path("areas.csv"), [{"name": "cut", "osm": "point.osm", "bbox": "1.56,42.54,1.58,42.56"}])
    for taken in (["cut"], []):
        assert again() == 0
        assert here.taken() == taken
        assert statuses(Path("out")) == {"cut": "empty"}


def test_tiles_of_a_map(here: Here) -> None:
    assert main(["batch", "--from", "village_00.osm", "--tiles", "200m", "--dem", "*.tif", "-o", "tiles"]) == 0
    found = statuses(Path("tiles"))
    assert made(Path("tiles")) == sorted(name for name, status in found.items() if status == "done")
    assert 2 <= len(made(Path("tiles"))) <= 6
    assert all(job.arguments[2:4] == ("--dem", "dem.tif") for job in here.jobs)


def test_states_survive_a_round_trip(here: Here, tmp_path: Path) -> None:
    state = load_state(Path("out/.state/v0.json"))
    assert state is not None
    assert [Path(mark.path).name for mark in state.inputs] == ["village_00.osm", "dem.tif"]
    assert [mark.path for mark in state.outputs] == ["out/v0.xodr", "out/v0.json"]
    save_state(tmp_path / "copy.json", state)
    assert load_state(tmp_path / "copy.json") == state
    assert load_state(tmp_path / "none.json") is None


def test_a_conversion_by_itself(tmp_path: Path) -> None:
    area, dem = write_area(tmp_path), tmp_path / "dem.tif"
    words = ("convert", str(area), "--dem", str(dem), "-o", str(tmp_path / "a.xodr"), "-q")
    job = AreaJob("a", words, AREA_SERVER, "one")
    outcome = run_area(job)
    assert outcome.message == f"{dem}: there is no such elevation model; check the path"
    assert outcome.memory > 20e6
    other = run_area(dataclasses.replace(job, version="0.0"))
    assert other.message == f"the worker has osm2xodr {__version__}, and the batch 0.0; install the same on both"
    end_areas("one")
    assert run_area(job).message == "it was stopped"


ENDING = """
import sys, threading
from osm2xodr.batching.area_process import AreaJob, run_area
from osm2xodr.cli import area_server
job = AreaJob("a", ("convert", sys.argv[1], "-o", "a.xodr", "-q"), area_server.__name__, "a batch")
thread = threading.Thread(target=run_area, args=(job,), daemon=True)
thread.start()
thread.join(float(sys.argv[2]))
"""


@pytest.mark.parametrize(("area", "seconds"), [("village.osm", "60"), (str(SAMPLE), "0.5")])
def test_a_worker_that_ends_untold_leaves_nothing_open(tmp_path: Path, area: str, seconds: str) -> None:
    """With a conversion behind it, or in the middle of one."""
    write_area(tmp_path)
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", ENDING, area, seconds],
        capture_output=True,
        check=False,
        text=True,
        cwd=tmp_path,
        timeout=60,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert not list(tmp_path.glob("*.part"))
    assert (tmp_path / "a.xodr").exists() == (area == "village.osm")


@pytest.mark.parametrize("server", [False, True], ids=["conversion", "its-parent"])
def test_a_killed_conversion_says_so(tmp_path: Path, server: bool) -> None:
    # It takes seconds, and is killed at once; on a busy machine it may be through before that.
    message = ""
    for attempt in range(8):
        message = message or _killed(f"killed-{server}-{attempt}", tmp_path / f"{attempt}.xodr", server)
    how = "" if server else " by SIGKILL"
    assert message.split(",")[0] == f"its process was killed{how}"


def _killed(batch: str, output: Path, server: bool) -> str:
    """Kill a conversion, or the process that forks conversions, and return what the outcome says of it."""
    job = AreaJob("a", ("convert", str(SAMPLE), "-o", str(output), "-q"), AREA_SERVER, batch)
    outcomes: list[Outcome] = []
    thread = threading.Thread(target=lambda: outcomes.append(run_area(job)))
    thread.start()
    family: list[psutil.Process] = []
    while len(family) < 2 and thread.is_alive():
        # Other tests may have left children of other kinds.
        with contextlib.suppress(psutil.NoSuchProcess):
            servers = [item for item in psutil.Process().children() if AREA_SERVER in item.cmdline()]
            family = [item for child in servers for item in (child, *child.children())]
        time.sleep(0.02)
    with contextlib.suppress(psutil.NoSuchProcess, IndexError):
        family[0 if server else 1].kill()
    thread.join(timeout=30.0)
    end_areas(job.batch)
    assert psutil.wait_procs(family, timeout=15.0)[1] == []
    return outcomes[0].message


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "give either a MANIFEST, or a map with --from"),
        (["areas.csv", "--from", "x.osm"], "give either a MANIFEST, or a map with --from"),
        (["--from", "x.osm"], "--from needs either --tiles, such as --tiles 5km, or --areas FILE"),
        (["--from", "x.osm", "--tiles", "1km", "--areas", "a"], "--from needs either --tiles"),
        (["areas.csv", "--tiles", "1km"], "--tiles needs a map to cut areas out of; give it with --from"),
        (["areas.csv", "--shared-frame"], "--shared-frame needs areas of one map; give it with --from"),
        (["areas.csv", "--workers", "2", "--scheduler", "tcp://a:1"], "--workers is for this machine"),
        (["areas.csv", "--tiles", "much"], "'much' is not a length; give one such as 5km or 800m"),
        (["areas.csv", "--max-memory", "1M"], "less than the 200M that it takes to start"),
        (["areas.csv", "--options", "--wais all"], "--options: convert has no option --wais; do you mean --ways?"),
        (["areas.csv", "--options", "--ways dirt"], "--options: --ways: "),
        (["areas.csv", "--options", "--jobs 3"], "--options: --jobs cannot be given to areas of a batch"),
        (["areas.csv", "--options", "'"], "--options: no closing quotation; check the quotes"),
    ],
)
def test_wrong_usage_is_refused_before_any_work(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    words: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["batch", "-o", "out", *arguments]) == 2
    assert words in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_dry_run_lists_areas(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_table(
        tmp_path / "a.csv", [{"name": "one", "osm": "x.osm"}, {"name": "two", "osm": "y.osm", "bbox": "1,2,3,4"}]
    )
    assert main(["batch", "a.csv", "-o", "out", "--dry-run"]) == 0
    assert capsys.readouterr().out == "one: x.osm\ntwo: y.osm (cut out)\n"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv"]
