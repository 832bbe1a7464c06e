"""The command export: formats by name, options, files that are there already."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from exported_network import network
from xodr_text import document, road

from osm2xodr.cli import main
from osm2xodr.exporting.geojson import LAYERS
from osm2xodr.python_api import EXPORT_LAYERS


@pytest.fixture
def path(tmp_path: Path) -> Path:
    network(tmp_path)
    return tmp_path / "map.xodr"


def export(path: Path, target: str, *arguments: str) -> int:
    return main(["export", str(path), "-o", str(path.parent / target), *arguments])


def test_layers_of_the_command_are_those_of_the_module() -> None:
    assert EXPORT_LAYERS == LAYERS


def test_formats_by_name(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for target in ("a.geojson", "a.glb", "a.obj"):
        assert export(path, target) == 0
        assert target in capsys.readouterr().err
    folder = path.parent
    assert json.loads((folder / "a.geojson").read_text(encoding="utf-8"))["type"] == "FeatureCollection"
    assert (folder / "a.glb").read_bytes()[:4] == b"glTF"
    assert "mtllib a.mtl" in (folder / "a.obj").read_text(encoding="utf-8")
    materials = (folder / "a.mtl").read_text(encoding="utf-8")
    assert [line.split()[1] for line in materials.splitlines() if line.startswith("newmtl")] == ["biking", "driving"]


def test_a_part(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert export(path, "whole.geojson", "--layers", "lanes") == 0
    whole = json.loads((path.parent / "whole.geojson").read_text(encoding="utf-8"))["features"]
    lon, lat = np.array([point[:2] for item in whole for ring in item["geometry"]["coordinates"] for point in ring]).T
    middle = (lon.min() + lon.max()) / 2.0
    box = f"{lon.min() - 1e-4},{lat.min() - 1e-4},{middle},{lat.max() + 1e-4}"
    assert export(path, "part.geojson", "--layers", "lanes", "--bbox", box) == 0
    part = json.loads((path.parent / "part.geojson").read_text(encoding="utf-8"))["features"]
    east = max(point[0] for item in part for ring in item["geometry"]["coordinates"] for point in ring)
    # Roads are cut within a metre of the border, 1.4e-5 degrees.
    assert lon.min() < east < middle + 1.5e-5
    assert "left out: " in capsys.readouterr().err


def test_same_file_same_bytes(path: Path) -> None:
    for form in ("geojson", "glb", "obj", "osm"):
        assert export(path, f"a.{form}") == 0
        assert export(path, f"a.{form}", "--overwrite") == 0
        first = (path.parent / f"a.{form}").read_bytes()
        assert export(path, f"a.{form}", "--overwrite") == 0
        assert (path.parent / f"a.{form}").read_bytes() == first


@pytest.mark.parametrize(
    ("target", "arguments", "words"),
    [
        ("a.dae", [], "a.dae does not tell it"),
        ("a.glb", ["--layers", "lanes"], "--layers is for geojson alone"),
        ("a.geojson", ["--up", "y"], "--up is for obj alone"),
        ("a.glb", ["--projector", "mgrs"], "--projector is for lanelet2 alone"),
        ("a.geojson", ["--layers", "lanes,trees"], "no 'trees'"),
        ("map.xodr", ["--format", "glb"], "is one of the inputs"),
    ],
)
def test_wrong_usage(
    path: Path, capsys: pytest.CaptureFixture[str], target: str, arguments: list[str], words: str
) -> None:
    assert export(path, target, *arguments) == 2
    assert words in capsys.readouterr().err


def test_lanelet2_and_its_projector(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = path.parent
    assert export(path, "plain.osm") == 0
    said = capsys.readouterr().err
    assert "1 lights" not in said
    assert "wrote" in said
    assert not (folder / "map_projector_info.yaml").exists()
    assert export(path, "map.xml", "--to", "lanelet2", "--projector", "local") == 0
    assert (folder / "map.xml").read_bytes() == (folder / "plain.osm").read_bytes()
    assert (folder / "map_projector_info.yaml").read_text(encoding="utf-8") == "projector_type: Local\n"
    assert export(path, "b.osm", "--projector", "mgrs") == 2
    assert "map_projector_info.yaml exists" in capsys.readouterr().err
    assert export(path, "b.osm", "--projector", "mgrs", "--overwrite") == 0
    assert "mgrs_grid: 32UPA" in (folder / "map_projector_info.yaml").read_text(encoding="utf-8")


def test_what_lanelet2_has_not_is_said(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = path.read_text(encoding="utf-8").replace('type="biking"', 'type="parking"')
    path.write_text(text, encoding="utf-8")
    assert export(path, "a.osm") == 0
    assert "lanes that Lanelet2 has no lanelets for are left out: 1 parking" in capsys.readouterr().err
    assert export(path, "b.osm", "-q") == 0
    assert capsys.readouterr().err == ""


def test_files_are_not_overwritten_unasked(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (path.parent / "a.mtl").write_text("mine", encoding="utf-8")
    assert export(path, "a.obj") == 2
    assert "a.mtl exists" in capsys.readouterr().err
    assert (path.parent / "a.mtl").read_text(encoding="utf-8") == "mine"
    assert not (path.parent / "a.obj").exists()


def test_what_cannot_be_exported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "map.xodr"
    path.write_text(document(road(lanes=""), header='<header revMajor="1" revMinor="4"/>'), encoding="utf-8")
    assert export(path, "a.glb") == 1
    assert "has no lane with a surface" in capsys.readouterr().err
    assert export(path, "a.geojson") == 1
    assert "GeoJSON is always in WGS 84" in capsys.readouterr().err
    assert [item.name for item in tmp_path.iterdir()] == ["map.xodr"]


def test_scenes(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = path.parent / "scene"
    assert main(["export", str(path), "--scene", str(target)]) == 0
    assert "files" in capsys.readouterr().err
    assert (target / "scene.json").is_file()
    assert main(["export", str(path), "--scene", str(target)]) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert main(["export", str(path), "--scene", str(target), "--format", "obj", "--overwrite"]) == 0
    assert (target / "scene.mtl").is_file()
    assert not list(target.glob("*.glb"))


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["-o", "a.glb", "--scene", "s"],
        ["-o", "a.glb", "--tile", "500"],
        ["--scene", "s", "--layers", "roads"],
        ["--scene", "s", "--format", "geojson"],
        ["--scene", "s", "--tile", "30"],
    ],
)
def test_options_that_exclude_each_other(path: Path, arguments: list[str], tmp_path: Path) -> None:
    places = [str(tmp_path / word) if word in {"a.glb", "s"} else word for word in arguments]
    assert main(["export", str(path), *places]) == 2
    assert not (tmp_path / "s").exists()
    assert not (tmp_path / "a.glb").exists()
