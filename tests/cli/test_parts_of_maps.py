"""`convert --bbox` and `--polygon`: an area out of a map, as a batch cuts it, and elevation models named together."""

from __future__ import annotations

import io
import json
import shutil
import sys
import zipfile
from pathlib import Path

import pytest
from small_area import OSM, write_area, write_dem

import osm2xodr
from osm2xodr.cli import main

# The lane to the north of the village; the street at its end is a way of its own, whole.
BOX = "1.5715,42.5505,1.5725,42.5520"
RING = [[1.5715, 42.5505], [1.5725, 42.5505], [1.5725, 42.5520], [1.5715, 42.5520], [1.5715, 42.5505]]


@pytest.fixture
def area(tmp_path: Path) -> Path:
    return write_area(tmp_path)


@pytest.fixture
def dem(tmp_path: Path) -> Path:
    return write_dem(tmp_path)


def convert(*arguments: object) -> int:
    return main(["convert", *map(str, arguments)])


def polygons(folder: Path) -> Path:
    path = folder / "lane.geojson"
    path.write_text(json.dumps({"type": "Polygon", "coordinates": [RING]}), encoding="utf-8")
    return path


def test_a_box_gives_the_bytes_of_a_batch(area: Path, dem: Path, tmp_path: Path) -> None:
    out = tmp_path / "lane.xodr"
    assert convert(area, "--bbox", BOX, "--dem", dem, "-o", out, "--name", "lane", "-q") == 0
    table = tmp_path / "areas.csv"
    table.write_text(f'name,osm,dem,bbox\nlane,{area.name},{dem.name},"{BOX}"\n', encoding="utf-8")
    assert main(["batch", str(table), "-o", str(tmp_path / "out"), "--workers", "1", "-q"]) == 0
    assert out.read_bytes() == (tmp_path / "out" / "lane.xodr").read_bytes()
    whole = tmp_path / "whole.xodr"
    assert convert(area, "--dem", dem, "-o", whole, "--name", "lane", "-q") == 0
    assert whole.read_bytes() != out.read_bytes()
    assert len(osm2xodr.read(whole).roads) > len(osm2xodr.read(out).roads) == 1


def lengths(path: Path) -> list[float]:
    return [road.length for road in osm2xodr.read(path).roads]


def test_roads_reach_beyond_a_box_unless_they_are_clipped(
    area: Path, dem: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, clipped = tmp_path / "whole.xodr", tmp_path / "clipped.xodr"
    assert convert(area, "--bbox", BOX, "--dem", dem, "-o", out, "-q") == 0
    report = tmp_path / "report.json"
    given = area, "--bbox", BOX, "--clip", "--dem", dem, "-o", clipped, "-q", "--report-json", report
    assert convert(*given) == 0
    by_crop = tmp_path / "crop.xodr"
    assert main(["crop", str(out), "--bbox", BOX, "-o", str(by_crop), "-q"]) == 0
    assert clipped.read_bytes() == by_crop.read_bytes()
    assert sum(lengths(clipped)) < 0.9 * sum(lengths(out))
    said = json.loads(report.read_text("utf-8"))
    assert "clipped" in {item["code"] for item in said["diagnostics"]}
    assert said["output"]["bytes"] == clipped.stat().st_size
    # By the library, and in place of polygons.
    osm2xodr.convert(area, dem, tmp_path / "library.xodr", polygon=polygons(tmp_path), clip=True)
    assert lengths(tmp_path / "library.xodr") == pytest.approx(lengths(clipped))
    for words, why in (
        (["--clip"], "--clip is about a part of the map"),
        (["--bbox", BOX, "--clip", "--target", "sumo"], "--clip cannot cut the programmes of traffic lights"),
    ):
        assert convert(area, *words, "-o", tmp_path / "no.xodr") == 2
        assert why in capsys.readouterr().err


def test_polygons_standard_input_and_python_give_the_same(
    area: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, other = tmp_path / "box.xodr", tmp_path / "polygon.xodr"
    assert convert(area, "--bbox", BOX, "-o", out, "--name", "lane", "-q") == 0
    assert convert(area, "--polygon", polygons(tmp_path), "-o", other, "--name", "lane", "-q") == 0
    assert other.read_bytes() == out.read_bytes()
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(OSM.encode())))
    assert convert("-", "--bbox", BOX, "-o", other, "--name", "lane", "--overwrite", "-q") == 0
    assert other.read_bytes() == out.read_bytes()
    box = [float(word) for word in BOX.split(",")]
    conversion = osm2xodr.convert(area, output=other, bbox=box, name="lane")
    assert other.read_bytes() == out.read_bytes()
    assert (conversion.inputs["area"], conversion.inputs["bbox"]) == (str(area), "1.5715,42.5505,1.5725,42.552")


def test_the_report_says_what_was_asked_for(area: Path, tmp_path: Path) -> None:
    report = tmp_path / "lane.json"
    assert convert(area, "--bbox", BOX, "-o", tmp_path / "lane.xodr", "--report-json", report, "-q") == 0
    found = json.loads(report.read_bytes())["input"]
    assert (found["area"], found["bbox"], found["name"]) == (str(area), BOX, "village")
    assert "polygon" not in found


@pytest.mark.parametrize(
    ("words", "status", "message"),
    [
        (["--bbox", "1,2,3"], 2, "--bbox 1,2,3 is not 4 numbers; write west,south,east,north in degrees"),
        (["--bbox", "1.6,42.5,1.5,42.6"], 2, "--bbox 1.6,42.5,1.5,42.6 is empty; write west,south,east,north"),
        (["--bbox", "42,200,43,201"], 2, "--bbox 42,200,43,201 is not on Earth"),
        (
            ["--bbox", BOX, "--polygon", "lane.geojson"],
            2,
            "--bbox and --polygon exclude each other; give one of them",
        ),
        (["--polygon", "lane.geojson", "--frame", "f.json"], 2, "--polygon and --frame exclude each other"),
        (["--polygon", "none.geojson"], 1, "none.geojson cannot be read: no such file or directory; check the path"),
        (["--polygon", "village.osm"], 1, "village.osm is not GeoJSON"),
        (["--bbox", "2,43,3,44"], 1, "there is nothing to drive on in this part of village.osm; give another area"),
    ],
)
def test_wrong_areas_are_refused(
    words: list[str],
    status: int,
    message: str,
    area: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(area.parent)
    assert convert(area.name, *words, "-o", "out.xodr") == status
    assert message in capsys.readouterr().err
    assert not Path("out.xodr").exists()


def test_errors_name_the_map_and_not_the_cut(area: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Service roads that are private are driven by nobody, which the conversion of the cut finds out."""
    text = OSM.replace('v="residential"', 'v="residential"/><tag k="area" v="yes"').replace(
        'v="tertiary"', 'v="track"'
    )
    area.write_text(text, encoding="utf-8")
    assert convert(area, "--bbox", BOX, "-o", tmp_path / "out.xodr") == 1
    said = capsys.readouterr().err
    assert str(area) in said
    assert "osm2xodr-" not in said


def test_elevation_models_follow_one_flag(area: Path, dem: Path, tmp_path: Path) -> None:
    """As files, patterns, folders and zip archives, before and after the map."""
    folder = tmp_path / "dem"
    folder.mkdir()
    far = write_dem(folder, "far.tif", west=3.0)
    near = shutil.copy(dem, folder / "near.tif")
    archive = tmp_path / "dem.zip"
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as stream:
        stream.write(near, "tiles/near.tif")
    expected = tmp_path / "expected.xodr"
    assert convert(area, "--dem", far, "--dem", near, "-o", expected, "-q") == 0
    out = tmp_path / "out.xodr"
    for words in (
        [area, "--dem", far, near, "-o", out],
        ["--dem", far, near, area, "-o", out],
        [area, f"--dem={far}", near, "-o", out],
        [area, "--dem", folder, "-o", out],
        [area, "--dem", folder / "*.tif", "-o", out],
        [area, "-o", out, "--dem", archive],
    ):
        assert convert(*words, "-q", "--overwrite") == 0, words
        assert out.read_bytes() == expected.read_bytes(), words


def test_what_is_no_model_does_not_follow_the_flag(
    area: Path, dem: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert convert("--dem", dem, area, "other.osm", "-o", tmp_path / "out.xodr") == 2
    assert "other.osm: one area at a time" in capsys.readouterr().err
    assert convert(area, "--dem", tmp_path / "*.asc", "-o", tmp_path / "out.xodr") == 1
    assert "*.asc; check the pattern" in capsys.readouterr().err


def test_unlabelled_models_are_labelled(area: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, page = tmp_path / "out.xodr", tmp_path / "out.html"
    bare = write_dem(tmp_path, "bare.tif", crs=None)
    assert convert(area, "--dem", bare, "-o", out) == 1
    assert (
        "bare.tif: the raster has no coordinate reference system; name it with --dem-crs" in capsys.readouterr().err
    )
    assert convert(area, "--dem", bare, "--dem-crs", "EPSG:4326", "-o", out, "--html", page, "-q") == 0
    metres = osm2xodr.convert(area, bare, dem_crs="EPSG:4326").statistics.lowest
    feet = osm2xodr.convert(area, bare, dem_crs="EPSG:4326", dem_unit="ft").statistics.lowest
    assert feet == pytest.approx(0.3048 * metres, abs=0.05)
    assert main(["report", str(out), "--dem", str(bare), "-o", str(page), "--overwrite"]) == 1
    known = ["--dem-crs", "EPSG:4326", "-o", str(page), "--overwrite"]
    assert main(["report", str(out), "--dem", str(bare), *known, "-q"]) == 0
    assert main(["surface", str(bare), *known, "-q"]) == 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--dem-crs", "EPSG:1"], "--dem-crs EPSG:1: this coordinate reference system is not known; give a code"),
        (["--dem-crs", "EPSG:3855"], "--dem-crs EPSG:3855: EGM2008 height has no positions on Earth; give a code"),
        (["--dem-unit", "ells"], "--dem-unit ells: this unit is not known; give one such as m, ft or us-ft"),
    ],
)
def test_wrong_labels_are_refused(
    words: list[str], message: str, area: Path, dem: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert convert(area, "--dem", dem, *words, "-o", tmp_path / "out.xodr") == 1
    assert message in capsys.readouterr().err
    assert convert(area, *words, "-o", tmp_path / "out.xodr") == 2
    assert "is about elevation models; give one with --dem, or leave it out" in capsys.readouterr().err


def test_too_little_coverage_fails(area: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A model of 27 columns ends at 1.5725 E, a quarter of the street to the west of its end."""
    out = tmp_path / "out.xodr"
    part, share = write_dem(tmp_path, "part.tif", columns=27), ["--fail-below-coverage", "0.95"]
    assert convert(area, "--dem", part, *share, "-o", out) == 1
    assert "part.tif: only 79 % of the roads have a measured height, and --fail-below" in capsys.readouterr().err
    assert not out.exists()
    assert convert(area, "--dem", part, "--fail-below-coverage", "0.5", "-o", out) == 0
    assert "dem-gap" in capsys.readouterr().err
    assert convert(area, "--dem", write_dem(tmp_path), *share, "-o", out, "--overwrite", "-q") == 0
    assert convert(area, *share, "-o", out, "--overwrite") == 2
    assert "--fail-below-coverage is about elevation models" in capsys.readouterr().err
    assert convert(area, "--dem", part, "--fail-below-coverage", "95", "-o", out, "--overwrite") == 2
    assert "--fail-below-coverage: 95.0 cannot be; give 0 to 1" in capsys.readouterr().err
