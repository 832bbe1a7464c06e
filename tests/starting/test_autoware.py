"""The folder for Autoware: Lanelet2's own library reads the map, and no datum is made up."""

from __future__ import annotations

from pathlib import Path

import pytest
from lanelet_graph import ExpectedGraph, LaneletMap, read_map
from scene_files import SAMPLES

import osm2xodr
from osm2xodr import Started

(SAMPLE,) = SAMPLES


@pytest.fixture(scope="module")
def sample(tmp_path_factory: pytest.TempPathFactory) -> Started:
    return osm2xodr.start("autoware", SAMPLE.osm, tmp_path_factory.mktemp("start") / "autoware", SAMPLE.dem)


@pytest.fixture(scope="module")
def loaded(sample: Started) -> LaneletMap:
    return read_map(sample.folder / "lanelet2_map.osm")


def test_names_are_those_that_autoware_looks_for(sample: Started) -> None:
    names = [path.name for path in sample.files]
    assert names == [
        "README.md",
        "lanelet2_map.osm",
        "map.xodr",
        "map_projector_info.yaml",
        "start.json",
    ]
    assert f'map_path:="$(realpath {sample.folder})"' in sample.command


def test_lanelet2_reads_it_without_errors(sample: Started, loaded: LaneletMap) -> None:
    assert loaded.errors == []
    assert len(loaded.lanelets) > 900
    expected = ExpectedGraph(sample.folder / "map.xodr", loaded.lanelets)
    assert loaded.edges["vehicle"].follow == expected.following("vehicle")


def test_no_datum_is_claimed(sample: Started) -> None:
    assert (sample.folder / "map_projector_info.yaml").read_text(encoding="utf-8") == "projector_type: Local\n"


def test_places_are_those_of_the_road_network(sample: Started) -> None:
    """So that a cloud in the coordinates of map.xodr, as the README asks for, fits."""
    text = (sample.folder / "lanelet2_map.osm").read_text(encoding="utf-8")
    header = (sample.folder / "map.xodr").read_text(encoding="utf-8").split("<header", 1)[1].split(">", 1)[0]
    bounds = dict(item.split("=") for item in header.split() if "=" in item)
    west, east = (float(bounds[side].strip('"')) for side in ("west", "east"))
    x = [float(part.split('"', 1)[0]) for part in text.split('k="local_x" v="')[1:]]
    # Lanes lie beside the reference lines that the header bounds.
    assert west - 15.0 < min(x) < west + 15.0
    assert east - 15.0 < max(x) < east + 15.0


def test_the_readme_says_what_is_missing(sample: Started) -> None:
    text = (sample.folder / "README.md").read_text(encoding="utf-8")
    assert "There is no `pointcloud_map.pcd`" in text
    assert "--projector mgrs" in text
    assert Path("lanelet2_map.osm").name in text
