"""The command ``locate``: the same place in all coordinates."""

from __future__ import annotations

import csv
import io
import json
import math
import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, strategies as st
from pyproj import Transformer
from xodr_text import PROJECTION, cubics, document, geometry, lane, road, section

from osm2xodr.cli import main

ROADS = (
    road(
        "17",
        geometry("<line/>", 40.0, x=100.0) + geometry('<arc curvature="0.02"/>', 60.0, 40.0, 140.0),
        100.0,
        lanes=section(0.0, lane(1, (0, 3.0)), lane(-1, (0, 3.0, 0.01))),
        elevation=cubics("elevation", (0, 200.0, 0.05)),
        lateral=cubics("superelevation", (0, 0.02)),
    ).replace('name=""', 'name="High Street"'),
    road(
        "bridge",
        geometry("<line/>", 60.0, x=120.0, y=-30.0, hdg=math.pi / 2),
        60.0,
        elevation=cubics("elevation", (0, 208.0)),
        junction="5",
    ),
    '<junction id="5" name=""/>',
)


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("locate") / "map.xodr"
    target.write_text(document(*ROADS), encoding="utf-8")
    return target


def locate(path: Path, capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    assert main(["locate", str(path), *map(str, arguments)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def located(path: Path, capsys: pytest.CaptureFixture[str], *arguments: object) -> dict[str, Any]:
    places: list[dict[str, Any]] = json.loads(locate(path, capsys, *arguments, "--json"))["places"]
    return places[0]


def test_a_lane(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    place = located(path, capsys, "--road", 17, "--lane", -1, "--s", 20)
    # The lane is 3.2 m wide there.
    assert place["t"] == pytest.approx(-1.6)
    assert place["x"] == pytest.approx(120.0)
    assert place["y"] == pytest.approx(-1.6 * math.cos(0.02), abs=1e-6)
    assert place["z"] == pytest.approx(201.0 - 1.6 * math.sin(0.02), abs=1e-6)
    assert place["height"] == place["z"]
    assert place["grade"] == 0.05
    assert place["superelevation"] == 0.02
    assert place["hdg"] == 0.0
    assert (place["road_name"], place["lane"], place["lane_type"], place["offset"]) == (
        "High Street",
        -1,
        "driving",
        0,
    )
    lon, lat = Transformer.from_crs(PROJECTION, "EPSG:4326", always_xy=True).transform(place["x"], place["y"])
    assert (place["lat"], place["lon"]) == (pytest.approx(lat, abs=1e-9), pytest.approx(lon, abs=1e-9))


def test_an_offset_counts_from_the_middle_of_the_lane(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    place = located(path, capsys, "--road", 17, "--lane", 1, "--offset", -0.5, "--s", 20)
    assert (place["t"], place["offset"]) == (1.0, -0.5)


@given(st.floats(0, 100), st.floats(-2.99, 2.99))
def test_there_and_back_by_all_ways(path: Path, s: float, t: float) -> None:
    """Road to Earth to road, and road to inertial to road: within a millimetre."""
    from osm2xodr.opendrive.locating import Locator
    from osm2xodr.opendrive.reader import read_xodr

    locator = Locator(read_xodr(path))
    import numpy as np

    start = locator.describe(locator.on_roads(["17"], np.array([s]), np.array([t]), [None], np.zeros(1)))[0]
    one, other = (np.array([start[name]], np.float64) for name in ("lat", "lon"))
    x, y = (np.array([start[name]], np.float64) for name in ("x", "y"))
    for places in (locator.at_geographic(one, other), locator.at_inertial(x, y)):
        found = [item for item in locator.describe(places) if item["road"] == "17"]
        assert len(found) == 1
        for name in ("s", "t", "x", "y", "z"):
            assert found[0][name] == pytest.approx(start[name], abs=1e-3)


def test_the_bridge_and_the_road_below(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = json.loads(locate(path, capsys, "--x", 121, "--y", 1, "--all", "--json"))
    assert [(item["road"], item["junction"]) for item in found["places"]] == [("17", None), ("bridge", "5")]
    assert found["others"] == 0
    best = json.loads(locate(path, capsys, "--x", 121, "--y", 1, "--json"))
    assert best["places"] == found["places"][:1]
    assert best["others"] == 1


def test_only_lanes_of_some_types(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    both = json.loads(locate(path, capsys, "--x", 121, "--y", 1, "--all", "--json", "--lane-type", "driving"))
    assert {item["lane_type"] for item in both["places"]} == {"driving"}
    assert main(["locate", str(path), "--x", "121", "--y", "1", "--lane-type", "dream"]) == 2
    assert "has no lanes of type 'dream'; it has " in capsys.readouterr().err


def test_text_for_people(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = locate(path, capsys, "--x", 121, "--y", 1)
    assert "road     17 (High Street)\n" in text
    assert "lane     1 (driving), section from s=0.0000 m, 0.4998 m right of its middle\n" in text
    assert "height   201.0700 m\n" in text
    assert "grade    5.00 %\n" in text
    assert text.endswith("1 more road lies here; --all shows all\n")


def test_a_place_beside_all_roads(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    place = located(path, capsys, "--x", 90, "--y", 0)
    assert (place["road"], place["s"], place["distance"]) == ("17", 0, 10)


def test_many_places_keep_their_columns(path: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    points = tmp_path / "points.csv"
    points.write_text('name, x, y,z\n"a, b",121,1,7\nfar,90,0,\n', encoding="utf-8")
    rows = list(csv.DictReader(io.StringIO(locate(path, capsys, "--points", points))))
    assert [row["name"] for row in rows] == ["a, b", "far"]
    assert [row["input_z"] for row in rows] == ["7", ""]
    assert [row["road"] for row in rows] == ["17", "17"]
    assert float(rows[0]["s"]) == 21
    assert [float(row["distance"]) for row in rows] == [0, 10]
    every = list(csv.DictReader(io.StringIO(locate(path, capsys, "--points", points, "--all"))))
    assert [row["road"] for row in every] == ["17", "bridge", "17"]
    listed = json.loads(locate(path, capsys, "--points", points, "--json"))
    assert [item["point"]["name"] for item in listed] == ["a, b", "far"]
    assert listed[0]["places"][0]["s"] == 21


def test_many_places_on_roads(path: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    points = tmp_path / "points.csv"
    points.write_text("road,s,lane,t\n17,20,-1,\nbridge,10,,0.5\n", encoding="utf-8")
    rows = list(csv.DictReader(io.StringIO(locate(path, capsys, "--points", points))))
    assert [(row["road"], row["lane"], float(row["t"])) for row in rows] == [("17", "-1", -1.6), ("bridge", "1", 0.5)]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--lat", "50"], "--lat and --lon"),
        (["--x", "1", "--y", "2", "--lane", "1"], "--lane does not go with --x and --y"),
        (["--x", "1", "--y", "2", "--points", "a.csv"], "--points stands for all"),
    ],
)
def test_wrong_usage(path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], words: str) -> None:
    assert main(["locate", str(path), *arguments]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--road", "18", "--s", "0"], "has no road '18'"),
        (["--road", "17", "--s", "100.5"], "s=100.5 is not on road 17, which is 100 m long"),
        (["--road", "17", "--s", "1", "--lane", "-4"], "has no lane -4 there; its lanes are 1, 0, -1"),
        (["--road", "17", "--s", "1", "--offset", "1"], "give lane, too"),
        (["--road", "17", "--s", "1", "--t", "1", "--lane", "1"], "two ways"),
        (["--x", "nan", "--y", "0"], "x 'nan' is not a number"),
        (["--points", "none.csv"], "cannot read none.csv"),
    ],
)
def test_what_cannot_be_found(
    path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    assert main(["locate", str(path), *arguments]) == 1
    error = capsys.readouterr().err
    assert re.fullmatch(r"osm2xodr: error: .+\n", error)
    assert words in error


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a,b\n1,2\n", "has no columns lat and lon"),
        ("", "has no columns"),
        ("x,y\n1,2\n1,two\n", "line 3: y 'two' is not a number"),
        ("road,s,lane\n17,1,0.5\n", "line 2: lane '0.5' is not a lane id"),
    ],
)
def test_tables_that_cannot_be_read(
    path: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path, text: str, words: str
) -> None:
    points = tmp_path / "points.csv"
    points.write_text(text, encoding="utf-8")
    assert main(["locate", str(path), "--points", str(points)]) == 1
    assert words in capsys.readouterr().err


def test_what_is_left_out_is_told(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "map.xodr"
    shape = '<shape s="0" t="0" a="0" b="0.1" c="0" d="0"/>'
    path.write_text(document(road(lateral=shape, more="<wheel/>")), encoding="utf-8")
    assert main(["locate", str(path), "--x", "1", "--y", "1", "--json"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["places"][0]["s"] == 1
    assert "has 1 thing that OpenDRIVE does not allow" in err
    assert "1 road has a lateral <shape>" in err


def test_files_without_a_place_on_earth(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "map.xodr"
    path.write_text(document(*ROADS, header='<header revMajor="1" revMinor="4"/>'), encoding="utf-8")
    place = located(path, capsys, "--x", 121, "--y", 1)
    assert (place["lat"], place["lon"]) == (None, None)
    assert "lat, lon unknown: the file has no geoReference" in locate(path, capsys, "--x", 121, "--y", 1)
    assert main(["locate", str(path), "--lat", "50", "--lon", "11"]) == 1
    assert "give --x and --y instead" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("place", "message"),
    [
        (("--lat", 91, "--lon", 1), "lat 91 is not within -90 to 90 degrees"),
        (("--lat", 1, "--lon", -400), "lon -400 is not within -360 to 360 degrees"),
        (("--x", 9_700_000, "--y", 0), r"the nearest road of .*map\.xodr lies 9,700 km away; check the coordinates"),
        (
            ("--lat", 89.9, "--lon", 100),
            r"the nearest road of .*map\.xodr lies [\d,]+ km away; check the coordinates",
        ),
    ],
)
def test_places_that_are_not_in_the_network(
    place: tuple[object, ...], message: str, path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["locate", str(path), *map(str, place)]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert re.fullmatch(f"osm2xodr: error: {message}.*\n", err)


def test_a_place_far_away_is_an_empty_row(path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    points = tmp_path / "points.csv"
    points.write_text("x,y\n120,0\n9999,0\n99999,0\n")
    rows = list(csv.DictReader(io.StringIO(locate(path, capsys, "--points", points))))
    assert [row["road"] for row in rows] == ["17", "17", ""]
    assert rows[2]["distance"] == ""
