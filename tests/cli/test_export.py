"""The command export: formats by name, options, files that are there already."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from exported_network import network
from xodr_text import document, road

from osm2xodr.cli import main
from osm2xodr.exporting.geojson import LAYERS
from osm2xodr.library import EXPORT_LAYERS


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


def test_same_file_same_bytes(path: Path) -> None:
    for form in ("geojson", "glb", "obj"):
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
        ("a.geojson", ["--layers", "lanes,trees"], "no 'trees'"),
        ("map.xodr", ["--format", "glb"], "is one of the inputs"),
    ],
)
def test_wrong_usage(
    path: Path, capsys: pytest.CaptureFixture[str], target: str, arguments: list[str], words: str
) -> None:
    assert export(path, target, *arguments) == 2
    assert words in capsys.readouterr().err


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
