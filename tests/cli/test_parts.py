"""The commands crop and merge: options, files that are there already, what is said."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import pytest
from xodr_text import document, geometry, road

from osm2xodr.cli import main
from osm2xodr.opendrive import read_xodr


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "map.xodr"
    path.write_text(document(road("1"), road("2", geometry("<line/>", 50.0, y=300.0), 50.0)), encoding="utf-8")
    return path


def crop(path: Path, *arguments: str) -> int:
    return main(["crop", str(path), "-o", str(path.parent / "part.xodr"), *arguments])


# The file's projection has its origin at 50° N, 11° E: 0.0007 degrees of longitude are 50 m there.
BOX = "10.999,49.999,11.0007,50.001"


def test_boxes_and_polygons(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert crop(path, "--bbox", BOX) == 0
    said = capsys.readouterr().err
    assert "1 end of a road was cut off" in said
    assert "left out: 1 road" in said
    part = path.parent / "part.xodr"
    assert read_xodr(part).roads.length.tolist() == [50]
    first = part.read_bytes()
    ring = [[10.999, 49.999], [11.0007, 49.999], [11.0007, 50.001], [10.999, 50.001]]
    area = path.parent / "area.geojson"
    area.write_text(json.dumps({"type": "Polygon", "coordinates": [[*ring, ring[0]]]}), encoding="utf-8")
    assert crop(path, "--polygon", str(area)) == 2
    assert "part.xodr exists" in capsys.readouterr().err
    assert crop(path, "--polygon", str(area), "--overwrite", "-q") == 0
    assert capsys.readouterr().err == ""
    assert part.read_bytes() == first


def test_roads_of_a_packed_file(path: Path) -> None:
    packed = path.with_suffix(".xodr.gz")
    packed.write_bytes(gzip.compress(path.read_bytes()))
    assert crop(packed, "--roads", "2") == 0
    assert read_xodr(path.parent / "part.xodr").roads.id == ("2",)


@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        ([], 2, "give one of --bbox, --polygon and --roads"),
        (["--bbox", BOX, "--roads", "1"], 2, "give one of --bbox, --polygon and --roads"),
        (["--roads", "1,7"], 2, "has no road '7'"),
        (["--bbox", "1,2,3"], 2, "is not 4 numbers"),
        (["--bbox", "1,2,3,4"], 1, "has no road in this part"),
        (["--polygon", "nowhere.geojson"], 1, "cannot be read"),
    ],
)
def test_what_cannot_be_cropped(
    path: Path, arguments: list[str], status: int, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert crop(path, *arguments) == status
    assert words in capsys.readouterr().err
    assert not (path.parent / "part.xodr").exists()


def test_a_file_from_nowhere_is_cropped_by_roads_alone(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    header = '<header revMajor="1" revMinor="7"/>'
    path.write_text(document(road("1"), header=header), encoding="utf-8")
    assert crop(path, "--bbox", BOX) == 1
    assert "no geoReference" in capsys.readouterr().err
    assert crop(path, "--roads", "1") == 0


def test_merging(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = path.parent / "other.xodr"
    other.write_text(document(road("1", geometry("<line/>", 50.0, x=100.0), 50.0)), encoding="utf-8")
    whole = path.parent / "whole.xodr"
    assert main(["merge", str(path), str(other), "-o", str(whole)]) == 0
    said = capsys.readouterr().err
    assert "1 pair of ends of roads that meet: linked" in said
    assert f"wrote {whole}" in said
    assert read_xodr(whole).roads.id == ("1", "2", "3")
    assert main(["merge", str(path), "-o", str(path.parent / "one.xodr")]) == 2
    assert "merge needs two or more" in capsys.readouterr().err
    assert main(["merge", str(path), str(other), "-o", str(other), "--overwrite"]) == 2
    assert "is one of the inputs" in capsys.readouterr().err
    assert main(["merge", str(path), "-", "-o", str(path.parent / "two.xodr")]) == 1
    assert "standard input cannot be read twice" in capsys.readouterr().err
