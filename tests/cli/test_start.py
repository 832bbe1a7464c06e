"""The command start: what it prints, and what it refuses."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
from scene_files import scene_named

from osm2xodr.cli import main

SCENE = scene_named("fremantle_placement")


def start(folder: Path, *arguments: str) -> int:
    return main(["start", "autoware", str(SCENE.osm), "--dem", str(SCENE.dem), "-o", str(folder), *arguments])


def test_the_last_line_runs_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "my map"
    assert start(folder) == 0
    lines = capsys.readouterr().err.splitlines()
    assert lines[-2].startswith(f"osm2xodr: wrote {folder} (5 files, ")
    label, command = lines[-1].split(": run it with: ")
    assert label == "osm2xodr"
    assert shlex.split(command)[:2] == ["ros2", "launch"]
    assert f"$(realpath '{folder}')" in command
    # What was converted, as convert says it; without options that are not there.
    assert "junctions" in "".join(lines)
    assert any(line.endswith("repaired: -v") for line in lines)


def test_options_of_convert_are_taken(tmp_path: Path) -> None:
    assert start(tmp_path / "a", "--xodr-version", "1.4", "--name", "Perth", "-q") == 0
    text = (tmp_path / "a" / "map.xodr").read_text(encoding="utf-8")
    assert 'revMajor="1" revMinor="4" name="Perth"' in text
    assert (tmp_path / "a" / "README.md").read_text(encoding="utf-8").startswith("# Perth, for Autoware\n")


def test_a_folder_that_is_there_is_asked_about(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert start(tmp_path / "a", "-q") == 0
    assert start(tmp_path / "a", "-q") == 2
    assert "exists; give another folder, or --overwrite to replace it" in capsys.readouterr().err
    assert start(tmp_path / "a", "-q", "--overwrite") == 0
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "diary.txt").write_text("dear diary", encoding="utf-8")
    assert start(tmp_path / "b", "-q", "--overwrite") == 1
    assert "has other files than what is written there" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--scene-tile", "500"], "--scene-tile is about CARLA"),
        (["--target", "sumo"], "No such option"),
        (["--frame", "f.json"], "No such option"),
        (["--ways", "rivers"], "--ways: 'rivers' is not a kind of way"),
    ],
)
def test_wrong_usage(arguments: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert start(tmp_path / "a", *arguments) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "a").exists()
