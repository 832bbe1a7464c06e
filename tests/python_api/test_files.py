"""Functions for files from Python: what the command line does, by the same functions."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from small_area import OSM, write_area
from viewed_file import viewed_text

import osm2xodr
from osm2xodr.cli import main


@pytest.fixture
def xodr(tmp_path: Path) -> Path:
    path = tmp_path / "small.xodr"
    path.write_text(viewed_text("Village"), encoding="utf-8")
    return path


def test_a_file_is_read_once_for_all(xodr: Path, tmp_path: Path) -> None:
    network = osm2xodr.read(xodr)
    assert osm2xodr.check(network) == osm2xodr.check(str(xodr))
    for function, name in ((osm2xodr.report, "a.html"), (osm2xodr.render, "a.svg"), (osm2xodr.export, "a.glb")):
        function(network, tmp_path / name)
        first = (tmp_path / name).read_bytes()
        function(str(xodr), str(tmp_path / name))
        assert (tmp_path / name).read_bytes() == first
    place = osm2xodr.Locator(network).at_inertial(np.array([20.0]), np.array([0.0]))
    assert len(place.start) == 2
    by_path = osm2xodr.Locator(xodr).at_inertial(np.array([20.0]), np.array([0.0]))
    assert by_path.road.tolist() == place.road.tolist()
    with pytest.raises(osm2xodr.InputError):
        osm2xodr.Locator(str(tmp_path / "none.xodr"))


def test_the_bytes_are_those_of_the_command_line(xodr: Path, tmp_path: Path) -> None:
    own, other = tmp_path / "own", tmp_path / "other"
    own.mkdir()
    other.mkdir()
    page = osm2xodr.report(xodr, own / "a.html", title="Ours", check=False)
    assert main(["report", str(xodr), "-o", str(other / "a.html"), "--title", "Ours", "--no-check", "-q"]) == 0
    assert page.size == (own / "a.html").stat().st_size
    osm2xodr.render(xodr, own / "a.png", bbox_xy=(20, -20, 100, 20), width=300, color="height")
    box = ["--bbox-xy", "20,-20,100,20", "--width", "300", "--color", "height"]
    assert main(["render", str(xodr), "-o", str(other / "a.png"), "-q", *box]) == 0
    assert osm2xodr.export(xodr, own / "a.obj", up="y") == (own / "a.obj", own / "a.mtl")
    assert main(["export", str(xodr), "-o", str(other / "a.obj"), "-q", "--up", "y"]) == 0
    names = sorted(path.name for path in own.iterdir())
    assert names == ["a.html", "a.mtl", "a.obj", "a.png"]
    assert [(own / name).read_bytes() for name in names] == [(other / name).read_bytes() for name in names]


def test_checks_are_chosen(xodr: Path) -> None:
    assert osm2xodr.check(xodr, readers=()).readers == ()
    assert osm2xodr.check(xodr, readers="carla, esmini").readers == ("carla", "esmini")
    assert osm2xodr.check(xodr, only="road-length").rules == {"road-length"}
    assert "overlap" not in osm2xodr.check(xodr, ignore=["overlap"]).rules


def test_what_the_conversion_reported_can_be_given_as_read(xodr: Path, tmp_path: Path) -> None:
    log = {"diagnostics": [{"kind": "note", "code": "flat", "osm_id": None, "message": "all is flat"}]}
    path = tmp_path / "log.json"
    path.write_text(json.dumps(log), encoding="utf-8")
    osm2xodr.report(xodr, tmp_path / "a.html", report_json=log)
    osm2xodr.report(xodr, tmp_path / "b.html", report_json=path)
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


@pytest.mark.parametrize(
    ("function", "options", "message"),
    [
        (osm2xodr.check, {"readers": "matlab"}, "readers: matlab is no reader that check knows"),
        (osm2xodr.check, {"only": ["gap"]}, "only: gap is no rule"),
        (osm2xodr.check, {"ignore": "gap"}, "ignore: gap is no rule"),
        (osm2xodr.check, {"max_findings": -1}, "max_findings: -1 findings per rule cannot be listed"),
        (osm2xodr.render, {"output": "a.jpg"}, "format: a.jpg is neither .svg nor .png"),
        (osm2xodr.render, {"output": "a.svg", "bbox": (1, 2, 3)}, "bbox 1,2,3 is not 4 numbers"),
        (osm2xodr.render, {"output": "a.svg", "bbox": "1,2,3,4", "bbox_xy": "1,2,3,4"}, "bbox and bbox_xy exclude"),
        (osm2xodr.render, {"output": "a.svg", "width": 3}, "width: 3 cannot be; give 200 to 16,384 pixels"),
        (osm2xodr.render, {"output": "a.svg", "color": "taste"}, "color: 'taste' is unknown"),
        (osm2xodr.export, {"output": "a.obj", "layers": "lanes"}, "layers is for geojson alone"),
        (osm2xodr.export, {"output": "a.geojson", "layers": ["trees"]}, "layers has no 'trees'"),
        (osm2xodr.export, {"output": "a.glb", "step": 0}, "step: 0 m is not above 0"),
        (osm2xodr.export, {"output": "a", "format": "stl"}, "format: 'stl' is unknown"),
    ],
)
def test_options_that_cannot_be(function: Any, options: dict[str, Any], message: str, xodr: Path) -> None:
    with pytest.raises(osm2xodr.OptionError) as caught:
        function(xodr, **options)
    assert str(caught.value).startswith(message)
    assert set(caught.value.options) <= {*options, "format"}


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    for function in (osm2xodr.read, osm2xodr.check):
        with pytest.raises(osm2xodr.InputError, match=r"none\.xodr"):
            function(tmp_path / "none.xodr")


def test_the_map_of_another_place_is_refused(tmp_path: Path) -> None:
    area, xodr = write_area(tmp_path), tmp_path / "own.xodr"
    osm2xodr.convert(area, output=xodr)
    other = write_area(tmp_path, OSM.replace('lon="1.57', 'lon="2.57'), "other.osm")
    with pytest.raises(osm2xodr.CoverageError, match=r"other\.osm: its ways lie 82 km and more from the roads of "):
        osm2xodr.report(xodr, tmp_path / "a.html", osm=other, check=False)
    assert not (tmp_path / "a.html").exists()
    osm2xodr.report(xodr, tmp_path / "a.html", osm=area, check=False)


def test_addresses_are_named_as_such() -> None:
    with pytest.raises(osm2xodr.InputError, match=r"area\.osm is read from a file alone, not from an addr"):
        osm2xodr.convert("https://example.org/area.osm")


def test_options_about_elevation_models_need_one(tmp_path: Path) -> None:
    area = write_area(tmp_path)
    with pytest.raises(osm2xodr.OptionError, match="vertical_datum is about elevation models; give") as found:
        osm2xodr.convert(area, vertical_datum="EPSG:3855")
    assert found.value.options == ("dem", "vertical_datum")


def test_locate_is_the_command(xodr: Path, capsys: pytest.CaptureFixture[str]) -> None:
    places: tuple[dict[str, Any], ...] = (
        {"x": 10.0, "y": -2.0},
        {"lat": 50.0, "lon": 11.0001},
        {"road": "1", "s": 20.0, "lane": -1, "offset": 0.5},
        {"road": "1", "s": 20.0, "t": 2.0},
    )
    for keywords in places:
        words = [f"--{name}={value}" for name, value in keywords.items()]
        assert main(["locate", str(xodr), "--json", "--all", *words]) == 0
        found = json.loads(capsys.readouterr().out)["places"]
        assert osm2xodr.locate(xodr, **keywords) == found
        assert osm2xodr.locate(osm2xodr.read(xodr), **keywords) == found
    if TYPE_CHECKING:
        osm2xodr.locate(xodr, latt=1.0)  # type: ignore[call-arg]


@pytest.mark.parametrize(
    ("keywords", "words"),
    [
        ({}, "give lat and lon, x and y, or road and s"),
        ({"lat": 1.0}, "give lat and lon"),
        ({"x": 1.0, "y": 1.0, "road": "1", "s": 0.0}, "give lat and lon"),
        ({"x": 1.0, "y": 1.0, "lane": -1}, "t, lane and offset go with road and s alone"),
        ({"road": "1", "s": 0.0, "t": 1.0, "lane": -1}, "t and lane are two ways"),
        ({"road": "1", "s": 0.0, "offset": 1.0}, "offset counts from the middle of a lane"),
    ],
)
def test_places_that_are_not_given_in_one_way(keywords: dict[str, Any], words: str, xodr: Path) -> None:
    with pytest.raises(osm2xodr.OptionError, match=words):
        osm2xodr.locate(xodr, **keywords)
