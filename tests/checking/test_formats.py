"""Results as text, JSON, SARIF and JUnit."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from lxml import etree
from t_junction import one, road, sound_tree

from osm2xodr.checking import FORMATS, RULES, CheckOptions, CheckResult, Severity, check_file


@pytest.fixture
def result(tmp_path: Path) -> CheckResult:
    """One error, one warning, one note."""
    tree = sound_tree()
    road(tree, 4).set("length", "40.5")
    one(tree, "junction/priority").set("high", "77")
    one(tree, "road[@id='3']/elevationProfile/elevation").set("d", "0.00003")
    path = tmp_path / "map <1>.xodr"
    path.write_bytes(etree.tostring(tree))
    rules = ("road-length", "priority-road", "grade-steep")
    return check_file(path, CheckOptions(only=rules))


def test_text(result: CheckResult) -> None:
    lines = FORMATS["text"]([result], Severity.WARNING).splitlines()
    assert lines[0] == f"{result.path}: 1 error, 1 warning, 1 note (OpenDRIVE 1.6, 10 roads, 1 junction, 0.3 km)"
    assert lines[1].startswith("error   road 4 s 40.50 at 100.50,0.00 (49.000000 11.00137")
    assert lines[1].endswith("the road's length differs from the sum of its records by 0.5 m [road-length]")
    assert lines[2].startswith("warning line ")
    assert lines[2].endswith("junction 100: a priority names road 77, which is not in the file [priority-road]")
    assert "the grade reaches 22.5 % [grade-steep]" in lines[3]
    assert lines[4:6] == ["", "findings  rule"]
    assert lines[6] == f"       1  road-length (error): {RULES['road-length'].remedy}"
    assert len(lines) == 9


def test_json(result: CheckResult) -> None:
    document = json.loads(FORMATS["json"]([result], Severity.WARNING))
    assert (document["errors"], document["warnings"], document["notes"]) == (1, 1, 1)
    assert document["failed"] is True
    assert document["counts"][0] == {"rule": "road-length", "severity": "error", "findings": 1}
    first = document["findings"][0]
    assert (first["rule"], first["road"], first["s"], first["unit"]) == ("road-length", "4", 40.5, "m")
    assert first["value"] == pytest.approx(0.5)
    assert document["findings"][1]["road"] == ""
    assert document["findings"][1]["x"] is None
    assert document["not_checked"] == []


def test_json_fails_from_the_given_severity_on(result: CheckResult) -> None:
    assert json.loads(FORMATS["json"]([result], Severity.ERROR))["failed"] is True
    mended = CheckResult(*(getattr(result, name) for name in result.__dataclass_fields__))
    assert mended.failed(Severity.ERROR)
    notes = [item for item in result.counts if item.severity is Severity.INFO]
    only_notes = CheckResult(
        result.path, result.version, result.size, result.readers, result.rules, tuple(notes), (), ()
    )
    assert [only_notes.failed(severity) for severity in Severity] == [True, False, False]


def test_sarif(result: CheckResult) -> None:
    document = json.loads(FORMATS["sarif"]([result], Severity.WARNING))
    assert document["version"] == "2.1.0"
    run = document["runs"][0]
    assert [item["id"] for item in run["tool"]["driver"]["rules"]] == ["grade-steep", "priority-road", "road-length"]
    assert [item["level"] for item in run["results"]] == ["error", "warning", "note"]
    for item in run["results"]:
        assert run["tool"]["driver"]["rules"][item["ruleIndex"]]["id"] == item["ruleId"]
        place = item["locations"][0]["physicalLocation"]
        # A reference to a file is a URI.
        assert place["artifactLocation"]["uri"].endswith("map%20%3C1%3E.xodr")
        assert place["region"]["startLine"] >= 1
    first = run["results"][0]
    assert first["locations"][0]["logicalLocations"] == [{"fullyQualifiedName": "road/4"}]
    assert first["properties"]["value"] == pytest.approx(0.5)


def test_junit(result: CheckResult) -> None:
    root = etree.fromstring(FORMATS["junit"]([result], Severity.WARNING).encode())
    suite = root[0]
    assert (suite.get("tests"), suite.get("failures")) == ("3", "2")
    failed = {case.get("name"): case.find("failure") is not None for case in suite}
    assert failed == {"grade-steep": False, "priority-road": True, "road-length": True}
    failure = one(suite, "testcase[@name='road-length']/failure")
    assert failure.text is not None
    assert "road 4 s 40.50" in failure.text
    assert FORMATS["junit"]([result], Severity.ERROR).count("<failure") == 1


def test_the_same_bytes_every_time(result: CheckResult) -> None:
    again = check_file(result.path, CheckOptions(only=tuple(sorted(result.rules))))
    for write in FORMATS.values():
        assert write([again], Severity.WARNING) == write([result], Severity.WARNING)


def test_annotations_of_github(result: CheckResult) -> None:
    lines = FORMATS["github"]([result], Severity.WARNING).splitlines()
    assert lines[-1] == result.headline()
    assert len(lines) == len(result.findings) + 1
    for line, item in zip(lines, result.findings, strict=False):
        kind = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.INFO: "notice"}[item.severity]
        assert line.startswith(f"::{kind} file={result.path},line={max(item.line, 1)},title={item.rule}::")


def test_several_files(result: CheckResult) -> None:
    both = [result, result]
    assert len(json.loads(FORMATS["json"](both, Severity.WARNING))) == 2
    assert len(json.loads(FORMATS["sarif"](both, Severity.WARNING))["runs"]) == 2
    assert len(etree.fromstring(FORMATS["junit"](both, Severity.WARNING).encode()).findall("testsuite")) == 2
    assert FORMATS["text"](both, Severity.WARNING).count(result.headline()) == 2
