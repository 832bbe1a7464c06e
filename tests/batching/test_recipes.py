"""The recipes of docs/batch.md do what they say."""

from __future__ import annotations

import csv
import os
import re
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from small_area import write_area, write_dem

from osm2xodr.batching.summary import COLUMNS

yaml = pytest.importorskip("yaml", reason="comes with distributed")

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "batch.md").read_text(encoding="utf-8")
_OUTLINE = {
    "type": "Polygon",
    "coordinates": [[[1.569, 42.549], [1.5725, 42.549], [1.5725, 42.552], [1.569, 42.552], [1.569, 42.549]]],
}


def recipes(language: str) -> list[str]:
    """Return the code blocks of a language."""
    return re.findall(rf"```{language}\n(.*?)```", TEXT, re.DOTALL)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a map of two streets, elevation models and a manifest, and the programs that recipes call."""
    programs = tmp_path / "bin"
    programs.mkdir()
    (programs / "osm2xodr").write_text(f'#!/bin/sh\nexec "{sys.executable}" -m osm2xodr "$@"\n')
    (programs / "osm2xodr").chmod(0o755)
    for name in ("areas", "dem", "maps"):
        (tmp_path / name).mkdir()
    write_area(tmp_path, name="country.osm")
    write_dem(tmp_path / "dem")
    (tmp_path / "areas.toml").write_text(
        '[defaults]\ndem = "dem/*.tif"\n[[area]]\nname = "west"\nosm = "country.osm"\n'
        "bbox = [1.569, 42.549, 1.5725, 42.552]\n[[area]]\nname = 'whole'\nosm = 'country.osm'\n"
    )
    return tmp_path


def run(folder: Path, *command: str, **more: str) -> subprocess.CompletedProcess[str]:
    """Run a command in the folder, with its programs."""
    environment = {**os.environ, "PATH": f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}", **more}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def statuses(folder: Path) -> dict[str, str]:
    with (folder / "out" / "summary.csv").open(newline="", encoding="utf-8") as stream:
        return {row["name"]: row["status"] for row in csv.DictReader(stream)}


def test_the_rule_per_area_makes_what_is_not_there(folder: Path) -> None:
    (folder / "Makefile").write_text(recipes("make")[0])
    for name in ("a.osm", "b.osm"):
        shutil.copy(folder / "country.osm", folder / "areas" / name)
    done = run(folder, "make", "--silent")
    assert done.returncode == 0, done.stderr
    files = sorted(path.name for path in (folder / "roads").iterdir())
    assert files == ["a.json", "a.xodr", "b.json", "b.xodr"]
    before = {path: path.stat().st_mtime_ns for path in (folder / "roads").iterdir()}
    later = time.time() + 5.0
    os.utime(folder / "areas" / "b.osm", (later, later))
    assert run(folder, "make", "--silent").returncode == 0
    changed = {path.name for path, when in before.items() if path.stat().st_mtime_ns != when}
    assert changed == {"b.json", "b.xodr"}
    (folder / "areas" / "c.osm").write_text("<osm>")
    failed = run(folder, "make", "--silent", "--keep-going")
    assert failed.returncode == 2
    assert "c.osm" in failed.stderr
    assert not (folder / "roads" / "c.xodr").exists()


def test_the_rule_for_all_makes_the_batch_and_what_stands_on_it(folder: Path) -> None:
    (folder / "Makefile").write_text(recipes("make")[1])
    done = run(folder, "make", "--silent", "batch")
    assert done.returncode == 0, done.stderr
    assert statuses(folder) == {"west": "done", "whole": "done"}
    done = run(folder, "make", "--silent", "out/whole.checked")
    assert done.returncode == 0, done.stderr
    assert statuses(folder) == {"west": "unchanged", "whole": "unchanged"}
    checked = folder / "out" / "whole.checked"
    assert "whole.xodr" in checked.read_text()
    before = checked.stat().st_mtime_ns
    assert run(folder, "make", "--silent", "out/whole.checked").returncode == 0
    assert checked.stat().st_mtime_ns == before


def test_the_workflow_converts_checks_and_fails_with_an_area(folder: Path) -> None:
    workflow: Any = yaml.safe_load(recipes("yaml")[0])
    # YAML 1.1 takes "on" for true; GitHub does not.
    assert set(workflow) == {"name", True, "permissions", "jobs"}
    steps = workflow["jobs"]["convert"]["steps"]
    assert all(("uses" in step) != ("run" in step) for step in steps)
    commands = {step["name"]: step["run"] for step in steps if "run" in step}
    assert commands.pop("Install").startswith('pip install "osm2xodr @ git+')
    assert list(commands) == ["Convert", "Check"]
    kept = steps[-1]
    assert (kept["if"], kept["with"]["path"]) == ("always()", "out")
    for command in commands.values():
        done = run(folder, "bash", "-e", "-c", command)
        assert done.returncode == 0, done.stderr
    assert {path.name for path in (folder / "out").glob("*.xml")} == {"west.xml", "whole.xml"}
    # A workflow that goes on with what its cache holds, and with a map that is damaged.
    (folder / "country.osm").write_text("<osm>")
    done = run(folder, "bash", "-e", "-c", commands["Convert"])
    assert done.returncode == 1
    assert statuses(folder) == {"west": "failed", "whole": "failed"}
    assert (folder / "out" / "index.html").is_file()


def test_the_job_of_gitlab_converts(folder: Path) -> None:
    (job,) = yaml.safe_load(recipes("yaml")[1]).values()
    assert job["artifacts"]["when"] == job["cache"]["when"] == "always"
    assert job["artifacts"]["paths"] == job["cache"]["paths"] == ["out/"]
    assert all(line.startswith("pip install") for line in job["before_script"])
    for line in job["script"]:
        done = run(folder, "bash", "-e", "-c", line)
        assert done.returncode == 0, done.stderr
    assert statuses(folder) == {"west": "done", "whole": "done"}


def test_the_line_of_cron_calls_the_script_that_is_there() -> None:
    mail, line = recipes("cron")[0].splitlines()
    assert mail.startswith("MAILTO=")
    assert re.fullmatch(r"(\d+|\*) (\d+|\*) (\d+|\*) (\d+|\*) (\d+|\*)  cd \S+ && \./weekly\.sh", line)


def test_the_weekly_script_takes_a_new_map_and_is_silent(folder: Path) -> None:
    (script,) = [text for text in recipes("sh") if text.startswith("#!/bin/sh")]
    (folder / "weekly.sh").write_text(script)
    shutil.copy(folder / "country.osm", folder / "map.osm")
    packed = "import osmium, sys\nwith osmium.SimpleWriter(sys.argv[2]) as out:\n"
    packed += "    for item in osmium.FileProcessor(sys.argv[1]): out.add(item)\n"
    assert run(folder, sys.executable, "-c", packed, "map.osm", "server.osm.pbf").returncode == 0
    # As curl does, it gives nothing if the file is as new as that of the server.
    (folder / "bin" / "curl").write_text(
        "#!/bin/sh\n[ country.osm.pbf -nt server.osm.pbf ] || cp server.osm.pbf country.osm.pbf.new\n"
    )
    (folder / "bin" / "curl").chmod(0o755)
    done = run(folder, "sh", "weekly.sh")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    first = statuses(folder)
    assert "done" in first.values()
    done = run(folder, "sh", "weekly.sh")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert statuses(folder) == {name: status.replace("done", "unchanged") for name, status in first.items()}


@pytest.mark.parametrize("language", ["toml", "csv"])
def test_the_manifests_convert(folder: Path, language: str) -> None:
    (manifest,) = recipes(language)
    # The map of the tests is text.
    (folder / f"areas.{language}").write_text(manifest.replace(".osm.pbf", ".osm"))
    shutil.copy(folder / "country.osm", folder / "harbour.osm")
    (found,) = (folder / "dem").iterdir()
    for name in ("fine.tif", "coarse.tif"):
        shutil.copy(found, folder / "dem" / name)
    (folder / "valley.geojson").write_text(repr(_OUTLINE).replace("'", '"'))
    done = run(folder, "osm2xodr", "batch", f"areas.{language}", "-o", "out", "--workers", "1")
    assert done.returncode == 0, done.stderr
    assert list(statuses(folder)) == ["harbour", "old_town", "valley"]
    assert statuses(folder)["old_town"] == "done"


def test_the_columns_of_the_summary_are_explained() -> None:
    section = TEXT[TEXT.index("## The summary") : TEXT.index("## Time and memory")]
    cells = re.findall(r"^\| (`.*?) \|", section, re.MULTILINE)
    assert re.findall(r"`(\w+)`", " ".join(cells)) == list(COLUMNS)


@pytest.fixture
def port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


@pytest.fixture
def cluster(folder: Path, port: int) -> Iterator[list[str]]:
    """The commands of the document, with the scheduler and the workers running; the last one is left."""
    pytest.importorskip("distributed")
    (text,) = [text for text in recipes("sh") if "dask scheduler" in text]
    commands = [line for line in text.splitlines() if not line.startswith("#")]
    commands = [line.replace("10.0.0.1", "127.0.0.1").replace("8786", str(port)) for line in commands]
    assert [line.split()[0] for line in commands] == ["dask", "dask", "osm2xodr"]
    running = []
    try:
        for line in commands[:2]:
            words = [sys.executable, "-m", *line.split(), *(["--no-dashboard"] if "scheduler" in line else [])]
            nowhere = subprocess.DEVNULL
            running.append(subprocess.Popen(words, cwd=folder, stdout=nowhere, stderr=nowhere))
            wait_for(port)
        yield commands[2:]
    finally:
        for process in reversed(running):
            process.terminate()
        for process in running:
            process.wait(timeout=30)


def wait_for(port: int) -> None:
    """Wait until something listens."""
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        with socket.socket() as trying:
            if trying.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.1)
    pytest.fail(f"nothing listens at {port}")


def test_the_commands_for_several_machines_work(folder: Path, cluster: list[str]) -> None:
    (command,) = cluster
    done = run(folder, "bash", "-e", "-c", command)
    assert done.returncode == 0, done.stderr
    assert statuses(folder) == {"west": "done", "whole": "done"}
