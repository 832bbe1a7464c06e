"""`convert --corrections` and `--osm-issues`, in configs, in repeated runs, from Python, and with other options."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from small_area import OSM, write_area, write_dem

import osm2xodr
from osm2xodr.cli import main

KNOWN = """
way.10.lanes = 3
way.10.speed = 30
way.11.drop = true
way.99.width = 6.0
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_area(tmp_path)
    write_dem(tmp_path)
    (tmp_path / "known.toml").write_text(KNOWN, encoding="utf-8")
    return tmp_path


def convert(*arguments: object) -> int:
    return main(["convert", *map(str, arguments)])


def corrections_in(report: Path) -> list[tuple[str, str, str]]:
    """Return code, element and key of what a report says about corrections."""
    found = json.loads(report.read_bytes())["diagnostics"]
    return [
        (item["code"], item["osm_id"], item["message"].partition(":")[0])
        for item in found
        if item["code"].startswith("correction")
    ]


def test_each_correction_is_applied_or_reported(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, report = folder / "out.xodr", folder / "out.json"
    arguments = [folder / "village.osm", "--corrections", folder / "known.toml", "--report-json", report, "-o", out]
    assert convert(*arguments) == 0
    assert sorted(corrections_in(report)) == [
        ("correction", "way/10", "lanes"),
        ("correction", "way/10", "speed"),
        ("correction", "way/11", "drop"),
        ("correction-unused", "way/99", "width"),
    ]
    text = out.read_text(encoding="utf-8")
    assert '<speed max="30" unit="km/h"/>' in text
    assert 'code="osm_way_ids" value="11"' not in text
    said = capsys.readouterr().err
    assert "correction-unused: width: no such way is read of the map (way/99)" in said
    assert "3 repaired" in said


def test_corrections_for_more_areas_may_match_nothing(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report = folder / "out.json"
    arguments = [folder / "village.osm", "--corrections", folder / "known.toml", "--corrections-shared"]
    assert convert(*arguments, "--report-json", report, "-o", folder / "out.xodr") == 0
    assert {code for code, _, _ in corrections_in(report)} == {"correction"}
    assert "correction-unused" not in capsys.readouterr().err
    assert convert(folder / "village.osm", "--corrections-shared", "-o", folder / "other.xodr") == 2
    assert "--corrections-shared is about --corrections; give them, or leave it out" in capsys.readouterr().err


def test_a_file_that_says_nothing_changes_nothing(folder: Path) -> None:
    (folder / "none.toml").write_text("", encoding="utf-8")
    for name, more in (("one", []), ("other", ["--corrections", folder / "none.toml"])):
        arguments = [folder / "village.osm", "--dem", folder / "dem.tif", "--name", "same", "-q", *more]
        assert convert(*arguments, "-o", folder / f"{name}.xodr", "--report-json", folder / f"{name}.json") == 0
    assert (folder / "one.xodr").read_bytes() == (folder / "other.xodr").read_bytes()
    inputs = [json.loads((folder / f"{name}.json").read_bytes())["input"] for name in ("one", "other")]
    assert "corrections" not in inputs[0]
    assert inputs[1] == {**inputs[0], "corrections": str(folder / "none.toml")}


def test_configs_repeated_runs_and_python_do_the_same(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = folder / "first.xodr"
    known, report = folder / "known.toml", folder / "first.json"
    assert convert(folder / "village.osm", "--corrections", known, "-o", first, "--report-json", report, "-q") == 0
    wanted = first.read_bytes()
    config = folder / "osm2xodr.toml"
    config.write_text(
        'area = "village.osm"\n[options]\ncorrections = "known.toml"\n'
        '[outputs]\nxodr = "second.xodr"\nosm-issues = "issues.geojson"\n',
        encoding="utf-8",
    )
    monkeypatch.chdir(folder.parent)
    assert convert("--config", config, "-q") == 0
    assert (folder / "second.xodr").read_bytes() == wanted
    assert json.loads((folder / "issues.geojson").read_bytes())["type"] == "FeatureCollection"
    assert convert("--from-report", report, "-o", folder / "third.xodr", "-q") == 0
    assert (folder / "third.xodr").read_bytes() == wanted
    osm2xodr.convert(folder / "village.osm", output=folder / "fourth.xodr", corrections=known)
    assert (folder / "fourth.xodr").read_bytes() == wanted


def test_another_file_of_corrections_is_another_run(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    known, report = folder / "known.toml", folder / "out.json"
    arguments = [folder / "village.osm", "--corrections", known, "-o", folder / "out.xodr", "--report-json", report]
    assert convert(*arguments, "-q") == 0
    known.write_text(KNOWN.replace("lanes = 3", "lanes = 4"), encoding="utf-8")
    assert convert("--from-report", report, "--overwrite", "-q") == 1
    assert "is not what" in capsys.readouterr().err


def test_a_wrong_file_ends_the_run_before_it_begins(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    known = folder / "known.toml"
    known.write_text("way.10.lans = 3", encoding="utf-8")
    assert convert(folder / "village.osm", "--corrections", known, "-o", folder / "out.xodr") == 1
    error = f"osm2xodr: error: {known}: way/10: 'lans' is unknown; do you mean 'lanes'?"
    assert error in capsys.readouterr().err
    assert not (folder / "out.xodr").exists()
    assert convert(folder / "village.osm", "--corrections", known, "-o", known, "--overwrite") == 2
    assert "is one of the inputs" in capsys.readouterr().err


def test_a_way_is_kept_in_a_part_of_a_map(folder: Path) -> None:
    """Also where nothing else of the part becomes a street."""
    text = OSM.replace('<tag k="highway" v="tertiary"/>', '<tag k="highway" v="footway"/>')
    text = text.replace('<tag k="highway" v="residential"/>', '<tag k="highway" v="footway"/>')
    area = write_area(folder, text)
    (folder / "known.toml").write_text('way.10.keep = "service"', encoding="utf-8")
    part = ["--bbox", "1.569,42.549,1.575,42.552", "-o", folder / "out.xodr", "-q"]
    assert convert(area, *part) == 1
    assert convert(area, *part, "--corrections", folder / "known.toml") == 0
    assert 'value="10"' in (folder / "out.xodr").read_text(encoding="utf-8")


WRONG = OSM.replace('<tag k="lanes" v="2"/>', '<tag k="lanes" v="many"/>').replace(
    '<tag k="highway" v="residential"/>', '<tag k="highway" v="residential"/><tag k="width" v="-3"/>'
)


def issues(path: Path) -> dict[str, dict[str, Any]]:
    return {item["properties"]["osm"]: item for item in json.loads(path.read_bytes())["features"]}


def test_mistakes_of_openstreetmap_are_listed_with_links(folder: Path) -> None:
    area, out, found = write_area(folder, WRONG), folder / "out.xodr", folder / "issues.geojson"
    assert convert(area, "-o", out, "--osm-issues", found, "-q") == 0
    assert issues(found) == {
        "way/10": {
            "type": "Feature",
            "geometry": {"type": "Point", "coordinates": [1.572, 42.55]},
            "properties": {
                "osm": "way/10",
                "url": "https://www.openstreetmap.org/way/10",
                "code": "lane-count",
                "kind": "dropped",
                "message": "lanes=many is not a number of lanes and is ignored",
            },
        },
        "way/11": {
            "type": "Feature",
            "geometry": {"type": "Point", "coordinates": [1.572, 42.5515]},
            "properties": {
                "osm": "way/11",
                "url": "https://www.openstreetmap.org/way/11",
                "code": "width",
                "kind": "dropped",
                "message": "width=-3 is not the width of a road and is ignored",
            },
        },
    }
    # The list has the form of corrections; filled in, it is one.
    document = json.loads(found.read_bytes())
    document["features"][0]["properties"]["lanes"] = 4
    known = folder / "known.geojson"
    known.write_text(json.dumps(document), encoding="utf-8")
    report = folder / "out.json"
    arguments = ["--corrections", known, "--report-json", report, "--osm-issues", found, "--overwrite", "-q"]
    assert convert(area, "-o", out, *arguments) == 0
    assert corrections_in(report) == [("correction", "way/10", "lanes")]
    assert list(issues(found)) == ["way/11"]


def test_the_list_of_mistakes_is_an_output_like_others(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    area, out, found = folder / "village.osm", folder / "out.xodr", folder / "issues.geojson"
    found.write_text("mine", encoding="utf-8")
    assert convert(area, "-o", out, "--osm-issues", found) == 2
    assert f"{found} exists; give another file, or --overwrite to replace it" in capsys.readouterr().err
    assert found.read_text(encoding="utf-8") == "mine"
    assert convert(area, "-o", out, "--osm-issues", out) == 2
    assert "name the same file" in capsys.readouterr().err
    assert convert(area, "-o", out, "--osm-issues", area / "issues.geojson") == 1
    assert not out.exists()
    # A part of a map, whose cut is gone in the end.
    box = ["--bbox", "1.569,42.549,1.575,42.552"]
    assert convert(write_area(folder, WRONG), *box, "-o", out, "--osm-issues", found, "--overwrite", "-q") == 0
    assert list(issues(found)) == ["way/10", "way/11"]


def test_from_python_as_well(folder: Path) -> None:
    network = osm2xodr.convert(write_area(folder, WRONG), bbox=(1.569, 42.549, 1.575, 42.552))
    network.write(folder / "out.xodr", osm_issues=folder / "issues.geojson")
    assert list(issues(folder / "issues.geojson")) == ["way/10", "way/11"]


def test_lines_to_paste_are_offered(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert convert(folder / "village.osm", "-o", folder / "out.xodr", "-vv") == 0
    assert "(way/11); correct it by way.11.lanes = 2\n" in capsys.readouterr().err
    assert main(["explain", "lane-count"]) == 0
    assert "Line for --corrections: way.ID.lanes = 2" in capsys.readouterr().out
