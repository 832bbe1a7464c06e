"""Readers of OpenDRIVE take what is cropped and merged as they take the whole."""

from __future__ import annotations

from pathlib import Path

import pytest
from real_readers import carla_answers, qc_result, sumo_net
from scene_files import Conversions, scene_named

import osm2xodr

# Through the middle of the roundabout's place, degrees of longitude.
SCENE = "fremantle_placement"
BORDER = 115.75586


@pytest.fixture(scope="module")
def files(conversions: Conversions, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    whole = conversions.of(scene_named(SCENE)).path
    folder = tmp_path_factory.mktemp("parts")
    parts = {
        "west": osm2xodr.crop(whole, folder / "west.xodr", bbox=(115.7, -32.1, BORDER, -32.0)),
        "east": osm2xodr.crop(whole, folder / "east.xodr", bbox=(BORDER, -32.1, 115.8, -32.0)),
    }
    merged = osm2xodr.merge(parts.values(), folder / "merged.xodr")
    return {"whole": whole, **parts, "merged": merged}


@pytest.mark.parametrize("name", ["west", "east", "merged"])
def test_check_carla_sumo_and_asam_find_nothing(files: dict[str, Path], name: str, tmp_path: Path) -> None:
    assert not osm2xodr.check(files["whole"]).failed()
    assert not osm2xodr.check(files[name]).failed()
    net = sumo_net(files[name], tmp_path)
    assert (net.exit_status, net.errors) == (0, [])
    assert net.edges > 0
    assert qc_result(files[name], tmp_path).issues == []
    assert carla_answers(files[name])


def test_the_merged_file_has_the_lanes_of_the_whole(files: dict[str, Path], tmp_path: Path) -> None:
    nets = {name: sumo_net(files[name], tmp_path) for name in ("whole", "merged")}
    assert nets["merged"].lane_km == pytest.approx(nets["whole"].lane_km, rel=0.01)
