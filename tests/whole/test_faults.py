"""Conversions that are stopped, started twice, or robbed of what they need: old results stay, or new ones are there.

`tools/faults.py` does the same many more times.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from fault_runs import OLD, command, interrupted, moments
from scene_files import scene_named
from small_area import write_area, write_dem

from osm2xodr.cli import main
from osm2xodr.surface.grids import raster_file as dem_module
from osm2xodr.system.parallel import Task

SAMPLE = scene_named("andorra_ordino")
RUNS = int(os.environ.get("OSM2XODR_FAULTS", "2"))


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, float]:
    """What the sample becomes undisturbed, and how long that takes, s."""
    out = tmp_path_factory.mktemp("whole") / "map.xodr"
    began = time.monotonic()
    subprocess.run(command("convert", *arguments(), "-o", out, "-q"), check=True)
    return out.read_bytes(), time.monotonic() - began


def arguments() -> list[object]:
    return [SAMPLE.osm, "--dem", SAMPLE.dem, "--jobs", 2]


@pytest.fixture
def area(tmp_path: Path) -> Path:
    return write_area(tmp_path)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    made = tmp_path / "out"
    made.mkdir()
    return made


def test_killed_at_any_moment(tmp_path: Path, whole: tuple[bytes, float]) -> None:
    """The old result is whole, nothing but a temporary file stays, and it does not disturb the next conversion."""
    new, longest = whole
    for k, at in enumerate(moments(RUNS, 0.0, longest, 1, seed=1)):
        folder = tmp_path / str(k)
        folder.mkdir()
        seen = interrupted(folder, arguments(), new, at, signal.SIGKILL)
        assert seen.status == -signal.SIGKILL or (seen.status, seen.target) == (0, "new")
        assert seen.target in ("old", "new")
        assert (seen.strange, seen.orphans, seen.message) == ((), (), "")
        assert len(seen.parts) <= 1
    left = set(os.listdir(folder))
    assert main(["convert", *map(str, arguments()), "-o", str(folder / "map.xodr"), "--overwrite", "-q"]) == 0
    assert (folder / "map.xodr").read_bytes() == new
    assert set(os.listdir(folder)) == left


@pytest.mark.parametrize(
    ("number", "status", "words"),
    [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "ended by the system")],
)
def test_asked_to_end(
    number: signal.Signals, status: int, words: str, tmp_path: Path, whole: tuple[bytes, float]
) -> None:
    new, longest = whole
    for k, at in enumerate(moments(RUNS // 2, 0.5 * longest, longest, 1, seed=2)):
        folder = tmp_path / str(k)
        folder.mkdir()
        seen = interrupted(folder, arguments(), new, at, number)
        # Python itself may be starting or ending, when nothing of the converter runs.
        if seen.target == "new":
            assert seen.status in (0, status, -number)
        else:
            assert seen.target == "old"
            assert seen.status in (status, -number)
        if seen.status == status:
            assert seen.message.strip().endswith(f"osm2xodr: error: {words}")
        assert (seen.parts, seen.strange, seen.orphans) == ((), (), ())


def test_copies_of_a_killed_process_end() -> None:
    script = (
        "import time, sys\n"
        "from osm2xodr.system.parallel import Task\n"
        "task = Task(lambda: time.sleep(60), apart=True)\n"
        "print(task._copy._process.pid, flush=True)\n"
        "task.result()\n"
    )
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    copy = int(process.stdout.readline())
    assert Path(f"/proc/{copy}").exists()
    process.kill()
    process.wait()
    process.stdout.close()
    until = time.monotonic() + 10
    while Path(f"/proc/{copy}").exists() and time.monotonic() < until:
        time.sleep(0.05)
    assert not Path(f"/proc/{copy}").exists()


def test_a_copy_ends_by_itself_when_all_is_well() -> None:
    assert Task(lambda: 7, apart=True).result() == 7


def test_two_conversions_onto_one_target(tmp_path: Path, folder: Path) -> None:
    """Either result is there in the end as a whole, never a mixture."""
    one, other = write_area(tmp_path), write_area(tmp_path, name="other.osm")
    other.write_text(other.read_text(encoding="utf-8").replace("Carrer Major", "Carrer Nou"), encoding="utf-8")
    results = []
    for name in (one, other):
        out = tmp_path / f"{name.stem}.xodr"
        assert main(["convert", str(name), "-o", str(out), "-q", "--name", "map"]) == 0
        results.append(out.read_bytes())
    assert results[0] != results[1]
    target = folder / "map.xodr"
    running = [
        subprocess.Popen(command("convert", name, "-o", target, "--overwrite", "-q", "--name", "map"))
        for name in (one, other) * 2
    ]
    assert [process.wait(timeout=120) for process in running] == [0] * 4
    assert target.read_bytes() in results
    assert os.listdir(folder) == ["map.xodr"]


# ---------------------------------------------------------------- what is taken away on the way


def while_reading_cells(monkeypatch: pytest.MonkeyPatch, action: Callable[[], object]) -> None:
    """Do something between the look at an elevation model and the reading of its cells."""
    read = dem_module.read_heights

    def disturbed(*given: object, **more: object) -> object:
        action()
        return read(*given, **more)  # type: ignore[arg-type]

    monkeypatch.setattr("osm2xodr.surface.mosaic.read_heights", disturbed)


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:2000])


def overwrite(path: Path) -> None:
    path.write_bytes(b"no raster any more")


@pytest.mark.parametrize("harm", [Path.unlink, cut, overwrite])
def test_an_elevation_model_that_is_lost_while_it_is_read(
    harm: Callable[[Path], object],
    tmp_path: Path,
    area: Path,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    dem = write_dem(tmp_path)
    while_reading_cells(monkeypatch, lambda: harm(dem))
    target = folder / "map.xodr"
    target.write_bytes(OLD)
    assert main(["convert", str(area), "--dem", str(dem), "-o", str(target), "--overwrite"]) == 1
    assert "the raster is damaged or cut short, its cells cannot be read; get it whole\n" in capsys.readouterr().err
    assert target.read_bytes() == OLD
    assert os.listdir(folder) == ["map.xodr"]


def test_a_folder_that_is_removed_during_the_conversion_is_made_again(
    tmp_path: Path, area: Path, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    while_reading_cells(monkeypatch, lambda: shutil.rmtree(folder, ignore_errors=True))
    dem = write_dem(tmp_path)
    assert main(["convert", str(area), "--dem", str(dem), "-o", str(folder / "map.xodr"), "-q"]) == 0
    assert os.listdir(folder) == ["map.xodr"]


# ---------------------------------------------------------------- targets


@pytest.mark.parametrize("link", [os.symlink, os.link])
@pytest.mark.parametrize("which", ["area", "dem"])
def test_an_input_is_never_the_target(
    link: Callable[[Path, Path], None], which: str, tmp_path: Path, area: Path, folder: Path
) -> None:
    dem = write_dem(tmp_path)
    given = area if which == "area" else dem
    before = given.read_bytes()
    link(given, folder / "map.xodr")
    for option in (["-o", folder / "map.xodr"], ["-o", folder / "x.xodr", "--report-json", folder / "map.xodr"]):
        assert main(["convert", str(area), "--dem", str(dem), *map(str, option), "--overwrite"]) == 2
    assert given.read_bytes() == before
    assert os.listdir(folder) == ["map.xodr"]


def test_a_link_to_nothing_is_followed(area: Path, folder: Path) -> None:
    (folder / "link.xodr").symlink_to(folder / "real.xodr")
    assert main(["convert", str(area), "-o", str(folder / "link.xodr"), "-q"]) == 0
    assert (folder / "link.xodr").is_symlink()
    assert (folder / "real.xodr").read_bytes().startswith(b"<?xml")


def test_a_link_to_itself_is_refused(area: Path, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "loop.xodr").symlink_to(folder / "loop.xodr")
    assert main(["convert", str(area), "-o", str(folder / "loop.xodr"), "-q"]) == 1
    error = capsys.readouterr().err
    assert error.startswith(f"osm2xodr: error: cannot write {folder / 'loop.xodr'}: ")
    assert "symbolic link" in error
    assert os.listdir(folder) == ["loop.xodr"]


# ---------------------------------------------------------------- standard streams

CLOSED_STREAMS = ["<&-", ">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-", "2>/dev/full"]


def in_shell(redirection: str, *words: object) -> subprocess.CompletedProcess[str]:
    shell = ["sh", "-c", f'"$@" {redirection}', "sh", *command(*words)]
    return subprocess.run(shell, capture_output=True, text=True, timeout=120, check=False)


@pytest.mark.parametrize("redirection", CLOSED_STREAMS)
def test_closed_streams_change_no_file(redirection: str, tmp_path: Path, area: Path, folder: Path) -> None:
    dem = write_dem(tmp_path)
    expected = tmp_path / "expected.xodr"
    assert main(["convert", str(area), "--dem", str(dem), "-o", str(expected), "-q", "--name", "map"]) == 0
    target = folder / "map.xodr"
    more = ["--name", "map", "--jobs", 2, "-vv"]
    done = in_shell(redirection, "convert", area, "--dem", dem, "-o", target, *more)
    assert (done.returncode, done.stdout) == (0, "")
    assert target.read_bytes() == expected.read_bytes()
    assert os.listdir(folder) == ["map.xodr"]


@pytest.mark.parametrize(
    ("redirection", "words", "message"),
    [
        (">&-", ["convert", "AREA", "-q", "-o", "-"], "cannot write standard output: bad file descriptor"),
        (">&-", ["check", "-q", "FILE"], "cannot write standard output: bad file descriptor"),
        ("<&-", ["check", "-"], "cannot read -: bad file descriptor; give a file of OpenDRIVE"),
        (">&-", ["--version"], "standard input or output cannot be used: bad file descriptor"),
        (">/dev/full", ["--help"], "standard input or output cannot be used: no space left on device"),
    ],
)
def test_a_stream_that_is_needed(redirection: str, words: list[str], message: str, area: Path, folder: Path) -> None:
    file = folder / "map.xodr"
    assert main(["convert", str(area), "-o", str(file), "-q"]) == 0
    done = in_shell(redirection, *({"AREA": area, "FILE": file}.get(word, word) for word in words))
    assert (done.returncode, done.stdout, done.stderr) == (1, "", f"osm2xodr: error: {message}\n")
