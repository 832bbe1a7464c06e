"""The report's page: what is in it, and what is not."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from page_cases import TERTIARY, info_of, write_plane
from viewed_file import HOSTILE, viewed_file, write_ways

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.opendrive.space import frame_of
from osm2xodr.opendrive.tables import OpenDrive
from osm2xodr.viewing import ReportOptions, write_report
from osm2xodr.viewing.page import _as_json, _compressed, make_report


def report_of(source: Path | OpenDrive, **options: Any) -> bytes:
    return make_report(source, ReportOptions(**{"check": False, **options}), Diagnostics())


def test_the_page_is_one_file_that_may_load_nothing(tmp_path: Path) -> None:
    page = report_of(viewed_file(tmp_path)).decode()
    assert re.findall(r'<(?:script|link|img|iframe)[^>]*(?:src|href)="(?!data:,)', page) == []
    assert "url(" not in page.replace("url(#default#VML)", "")
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page)
    assert policy is not None
    assert policy.group(1).startswith("default-src 'none'; script-src 'sha256-")
    assert not {"unsafe-inline", "unsafe-eval", "http:", "https:", "*"} & set(re.split(r"[ ;']+", policy.group(1)))
    for kind in ("script", "style"):
        for text in re.findall(rf"<{kind}>(.*?)</{kind}>", page, re.DOTALL):
            digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
            assert f"'sha256-{digest}'" in policy.group(1)


def test_names_stand_in_the_page_only_as_text(tmp_path: Path) -> None:
    page = report_of(viewed_file(tmp_path))
    assert b"window.owned" not in page.replace(b"window.owned=1&lt;/script&gt;", b"").replace(
        b"onerror=&#x27;window.owned=2&#x27;&gt;", b""
    )
    assert b"<title>&lt;/script&gt;&lt;script&gt;" in page
    assert info_of(page)["road"]["name"] == [HOSTILE, "", ""]


def test_the_licences_are_at_its_head(tmp_path: Path) -> None:
    head = report_of(viewed_file(tmp_path)).partition(b"</head>")[0].decode()
    for owner in ("Volodymyr Agafonkin", "Leon Sorokin", "three.js authors"):
        assert owner in head


def test_the_same_input_gives_the_same_bytes(tmp_path: Path) -> None:
    file = viewed_file(tmp_path)
    assert report_of(file) == report_of(file) == report_of(tmp_path / "map.xodr")


def test_furniture_and_junctions_have_places(tmp_path: Path) -> None:
    info = info_of(report_of(viewed_file(tmp_path)))
    x0, y0 = info["origin"]
    road, x, y, z, heading, foot, _, is_light, _, attributes, _ = info["signals"][0]
    assert (road, x + x0, y + y0, z, is_light) == (0, 110.0, -6.0, 15.5, 1)
    # It faces the traffic that comes along s, 3 m above the road.
    assert abs(heading) == pytest.approx(math.pi, abs=1e-3)
    assert foot == 3.0
    assert dict(attributes)["type"] == "1000001"
    assert info["object_types"] == ["crosswalk"]
    assert info["junctions"]["name"] == ["Corner"]
    assert info["junctions"]["x"][0] + x0 == pytest.approx(130.0)
    assert info["structures"] == {"1": [["tunnel", 20.0, 60.0, "Hill"]]}
    assert info["road"]["classes"] == ["town", "", ""]


def test_degrees_are_those_of_the_projection(tmp_path: Path) -> None:
    file = viewed_file(tmp_path)
    info = info_of(report_of(file))
    fit, (x0, y0) = info["geographic"], info["origin"]
    x, y = np.array([0.0, 140.0, 190.0]), np.array([0.0, 0.0, 40.0])
    u, v = (x - x0 - fit["x"]) / fit["scale"], (y - y0 - fit["y"]) / fit["scale"]
    powers = [(i, j) for i in range(fit["order"] + 1) for j in range(fit["order"] + 1 - i)]
    frame, _ = frame_of(file.header)
    assert frame is not None
    for values, wanted in zip((fit["lon"], fit["lat"]), frame.to_geographic(x, y), strict=True):
        found = sum(value * u**i * v**j for value, (i, j) in zip(values, powers, strict=True))
        np.testing.assert_allclose(found, wanted, atol=1e-9)


def test_heights_are_held_against_the_elevation_model(tmp_path: Path) -> None:
    file = viewed_file(tmp_path)
    info = info_of(report_of(file, dem=(write_plane(tmp_path, file),)))
    rows = {row[0]: row[1:] for row in info["accuracy"]["rows"]}
    # The street is 10 + 0.05 x, the ground 8 + 0.05 x.
    assert rows["class town"] == [0.12, 2.0, 2.0, 2.0, 2.0]
    assert ["rms off the elevation model, on the ground", f"{rows['on the ground'][2]:.2f} m"] in info["figures"]
    assert rows["bridges and tunnels"][0] == pytest.approx(0.04, abs=0.01)
    assert info["has_ground"]
    assert [mode["key"] for mode in info["modes"]] == ["type", "class", "height", "grade", "error", "speed"]
    # 0.16 at the end of the bend; the street has 0.05.
    assert info["accuracy"]["steep"][0] == [1, 80.0, 0.16]
    assert info["accuracy"]["steep"][1][2] == 0.05
    assert info["terrain"]["nx"] * info["terrain"]["ny"] == pytest.approx(40_000, rel=0.02)


def test_ways_without_a_road_are_listed(tmp_path: Path) -> None:
    file = viewed_file(tmp_path)
    ways = {
        4: (TERTIARY, [(0.0, 1.0), (120.0, 1.0)]),
        5: ('<tag k="highway" v="residential"/>', [(10.0, 60.0), (110.0, 60.0)]),
        6: ('<tag k="highway" v="footway"/>', [(10.0, 80.0), (110.0, 80.0)]),
        7: ('<tag k="highway" v="service"/><tag k="service" v="driveway"/>', [(10.0, 90.0), (110.0, 90.0)]),
    }
    info = info_of(report_of(file, osm=write_ways(tmp_path, file, ways)))
    assert info["coverage"]["rows"] == [["all", 0.22, 0.12], ["tertiary", 0.12, 0.12], ["residential", 0.1, 0.0]]
    assert info["figures"][-1] == ["of OSM's car ways covered", "54.5 %"]
    way, highway, name, length, missing, x, y = info["coverage"]["missing"][0]
    assert (way, highway, name, length, missing) == (5, "residential", "", 100.0, 100.0)
    assert (x + info["origin"][0], y + info["origin"][1]) == pytest.approx((65.0, 60.0), abs=6.0)
    assert len(info["coverage"]["missing"]) == 1
    assert info["ways"] == {"0": [[4, 0.0, 120.0, "tertiary", "Hauptstraße"]]}
    assert info["limits"] == {"0": 0.12}


def test_a_way_across_a_road_is_not_that_road(tmp_path: Path) -> None:
    file = viewed_file(tmp_path)
    ways = {4: (TERTIARY, [(60.0, -50.0), (60.0, 50.0)])}
    assert info_of(report_of(file, osm=write_ways(tmp_path, file, ways)))["ways"] == {}


def test_bridges_of_osm_count_where_the_file_names_none(tmp_path: Path) -> None:
    text = (tmp_path / "map.xodr", viewed_file(tmp_path))[0].read_text(encoding="utf-8")
    (tmp_path / "bare.xodr").write_text(re.sub("<objects><tunnel.*?</objects>", "", text), encoding="utf-8")
    file = viewed_file(tmp_path)
    bridge = TERTIARY + '<tag k="bridge" v="yes"/>'
    area = write_ways(tmp_path, file, {4: (bridge, [(30.0, 0.0), (70.0, 0.0)])})
    info = info_of(report_of(tmp_path / "bare.xodr", osm=area))
    kind, begin, end, name = info["structures"]["0"][0]
    assert (kind, begin, end, name) == ("bridge", pytest.approx(30.0, abs=0.1), pytest.approx(70.0, abs=0.1), "way/4")


def test_connecting_roads_between_tunnels_are_in_the_tunnel(tmp_path: Path) -> None:
    file = viewed_file(tmp_path)
    text = (tmp_path / "map.xodr").read_text(encoding="utf-8").replace('s="20" length="40"', 's="0" length="80"')
    arms = '<objects><tunnel id="18" s="90" length="30"/><object id="9"'
    (tmp_path / "hill.xodr").write_text(text.replace('<objects><object id="9"', arms), encoding="utf-8")
    info = info_of(report_of(tmp_path / "hill.xodr"))
    assert {road: [row[:3] for row in rows] for road, rows in info["structures"].items()} == {
        "0": [["tunnel", 90.0, 120.0]],
        "1": [["tunnel", 0.0, 80.0]],
        "2": [["tunnel", 0.0, 20.0]],
    }
    assert "2" not in info_of(report_of(file))["structures"]


def test_messages_of_the_conversion_are_shown_with_their_place(tmp_path: Path) -> None:
    file = viewed_file(tmp_path)
    area = write_ways(tmp_path, file, {4: (TERTIARY, [(0.0, 1.0), (120.0, 1.0)])})
    said = [
        {"kind": "guessed", "code": "lane-count", "osm_id": "way/4", "message": "one lane"},
        {"kind": "repaired", "code": "gap", "osm_id": "javascript:alert(1)", "message": "joined"},
    ]
    info = info_of(report_of(file, osm=area, log={"input": {"area": "somewhere/area.osm"}, "diagnostics": said}))
    assert "area.osm" in info["log"]["text"]
    assert "somewhere" not in info["log"]["text"]
    assert info["log"]["items"][0] == ["repaired", "gap", "", "joined", None, None, ""]
    assert info["log"]["items"][1][:4] == ["guessed", "lane-count", "way/4", "one lane"]
    assert info["log"]["items"][1][4] is not None
    assert info["log"]["items"][1][6] == "way.4.lanes = 2"


def test_findings_are_those_of_check(tmp_path: Path) -> None:
    file = viewed_file(tmp_path)
    info = info_of(report_of(file, check=True))
    from osm2xodr.checking import CheckOptions, check_drive

    wanted = check_drive(file, CheckOptions())
    assert info["finding_count"] == sum(item.findings for item in wanted.counts) > 0
    assert [row[1] for row in info["findings"]] == [item.rule for item in wanted.findings]
    assert [row[0] for row in info["findings"]] == [item.severity.word for item in wanted.findings]
    grave = [
        sum(item.findings for item in wanted.counts if item.severity.word == word) for word in ("error", "warning")
    ]
    assert info["figures"][-1] == ["errors and warnings", f"{grave[0]} + {grave[1]}"]
    placed = next(row for row in info["findings"] if row[5] is not None)
    assert np.hypot(placed[5], placed[6]) < 300.0
    assert info["modes"][-1]["key"] == "finding"


def test_a_file_that_does_not_say_where_it_lies_cannot_be_compared(tmp_path: Path) -> None:
    viewed_file(tmp_path)
    text = re.sub("<geoReference>.*?</geoReference>", "", (tmp_path / "map.xodr").read_text(encoding="utf-8"))
    (tmp_path / "lost.xodr").write_text(text, encoding="utf-8")
    info = info_of(report_of(tmp_path / "lost.xodr"))
    assert info["geographic"] is None
    with pytest.raises(InputError, match=r"no geoReference.*leave --osm and --dem out"):
        report_of(tmp_path / "lost.xodr", dem=(tmp_path / "plane.tif",))


def test_an_empty_network_makes_a_page_all_the_same(tmp_path: Path) -> None:
    (tmp_path / "empty.xodr").write_text(
        '<OpenDRIVE><header revMajor="1" revMinor="7"/></OpenDRIVE>', encoding="utf-8"
    )
    info = info_of(report_of(tmp_path / "empty.xodr"))
    assert info["road"]["id"] == []
    assert info["figures"][0] == ["roads", "0"]


def test_the_report_is_written_as_a_whole(tmp_path: Path) -> None:
    out = tmp_path / "report.html"
    size = write_report(viewed_file(tmp_path), out, ReportOptions(check=False), Diagnostics())
    assert out.stat().st_size == size
    assert out.read_bytes().startswith(b"<!doctype html>")
    assert size < 1_200_000


def test_the_same_bytes_give_the_same_text() -> None:
    text = _compressed(b"abc" * 100)
    assert text == _compressed(b"abc" * 100)
    assert gzip.decompress(base64.b64decode(text)) == b"abc" * 100


def test_json_has_only_finite_numbers_and_whole_characters() -> None:
    assert json.loads(_as_json({"name": "Straße \udc80"})) == {"name": "Straße ?"}
    with pytest.raises(ValueError, match="Out of range"):
        _as_json([math.nan])
