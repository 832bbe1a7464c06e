"""The folders of `start`: whole or not at all, among files of others."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from scene_files import scene_named

import osm2xodr
from osm2xodr import OptionError, OutputError, Started

SCENE = scene_named("fremantle_placement")


def start(folder: Path, **options: Any) -> Started:
    return osm2xodr.start("autoware", SCENE.osm, folder, SCENE.dem, **options)


def test_files_of_others_stay(tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "diary.txt").write_text("dear diary", encoding="utf-8")
    with pytest.raises(OutputError, match="other files than what is written there"):
        start(mine)
    assert [path.name for path in mine.iterdir()] == ["diary.txt"]


def test_a_folder_is_made_anew(tmp_path: Path) -> None:
    folder = tmp_path / "here"
    first = start(folder)
    (folder / "diary.txt").write_text("dear diary", encoding="utf-8")
    before = {path: path.read_bytes() for path in first.files}
    second = start(folder)
    assert {path: path.read_bytes() for path in second.files} == before
    # Another simulator's files take their place, and not the diary's.
    third = osm2xodr.start("sumo", SCENE.osm, folder, SCENE.dem)
    there = {path for path in folder.rglob("*") if path.is_file()}
    assert there == {*third.files, folder / "diary.txt"}


def test_folders_below_go_with_their_files(tmp_path: Path) -> None:
    folder = tmp_path / "here"
    first = osm2xodr.start("carla", SCENE.osm, folder, SCENE.dem)
    assert folder / "import" / "area.glb" in first.files
    (folder / "import" / "notes.txt").write_text("mine", encoding="utf-8")
    second = start(folder)
    there = {path for path in folder.rglob("*") if path.is_file()}
    assert there == {*second.files, folder / "import" / "notes.txt"}
    (folder / "import" / "notes.txt").unlink()
    (folder / "import").rmdir()
    osm2xodr.start("carla", SCENE.osm, folder, SCENE.dem)
    start(folder)
    assert not (folder / "import").exists()


def test_links_to_elsewhere_are_not_followed(tmp_path: Path) -> None:
    folder, elsewhere = tmp_path / "here", tmp_path / "elsewhere"
    osm2xodr.start("carla", SCENE.osm, folder, SCENE.dem)
    (folder / "import").rename(elsewhere)
    (folder / "import").symlink_to(elsewhere)
    before = {path: path.read_bytes() for path in elsewhere.iterdir()}
    with pytest.raises(OutputError, match="is not of what was written there before"):
        osm2xodr.start("carla", SCENE.osm, folder, SCENE.dem, name="other")
    # Another simulator has nothing to write there, and removes nothing there.
    start(folder)
    assert {path: path.read_bytes() for path in elsewhere.iterdir()} == before


def test_indices_of_others_name_nothing_outside(tmp_path: Path) -> None:
    folder = tmp_path / "here"
    folder.mkdir()
    (tmp_path / "diary.txt").write_text("dear diary", encoding="utf-8")
    for name in ("../diary.txt", "a/../../diary.txt", str(tmp_path / "diary.txt"), "a//b", "a\\b"):
        (folder / "start.json").write_text(json.dumps({"files": [name]}), encoding="utf-8")
        with pytest.raises(OutputError, match="does not list the files that belong to it"):
            start(folder)
    assert (tmp_path / "diary.txt").read_text(encoding="utf-8") == "dear diary"


def test_the_readme_says_what_is_printed_and_whose_the_data_are(tmp_path: Path) -> None:
    started = start(tmp_path / "my map", name="Où, là?")
    text = (started.folder / "README.md").read_text(encoding="utf-8")
    assert text.startswith("# Ou_la, for Autoware\n")
    assert started.command.replace(f"'{started.folder}'", ".") in text
    assert "© [OpenStreetMap contributors](https://www.openstreetmap.org/copyright)" in text
    assert "(ODbL)" in text
    index = json.loads((started.folder / "start.json").read_text(encoding="utf-8"))
    assert index["simulator"] == "autoware"
    assert {started.folder / name for name in [*index["files"], "start.json"]} == set(started.files)
    for name in index["files"]:
        assert f"`{name}`" in text or name == "README.md"


def test_options_that_the_simulator_decides(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="target is not for this"):
        start(tmp_path / "a", target="sumo")
    with pytest.raises(OptionError, match="scene_tile is about CARLA"):
        start(tmp_path / "a", scene_tile=500.0)
    with pytest.raises(OptionError, match="'lgsvl' is unknown; choose from"):
        osm2xodr.start("lgsvl", SCENE.osm, tmp_path / "a")
    with pytest.raises(TypeError, match="has no option 'wayz'; do you mean 'ways'"):
        start(tmp_path / "a", wayz="major")
    assert list(tmp_path.iterdir()) == []
