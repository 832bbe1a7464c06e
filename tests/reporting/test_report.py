from __future__ import annotations

import json
import math
from pathlib import Path

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import ElevationReport, LayerCrossing, StructureRecord
from osm2xodr.reporting.report import details, report
from osm2xodr.reporting.statistics import Statistics

FIGURES = Statistics(1200, 1, 0, 143_210.0, 12.0, -3.21, 1912.77, 0.9996)


def some() -> Diagnostics:
    found = Diagnostics()
    found.note("late", "", "a note")
    for way in range(1500):
        found.guessed("lane-count", f"way/{way}", "no lanes given, 2 taken.")
    found.dropped("bad-node", "node/7", "node/7 has no position")
    found.guessed("lane-width", "way/3", "no width given")
    found.guessed("lane-width", "way/4", "no width given")
    return found


def test_heights_in_the_report() -> None:
    bridge = StructureRecord("bridge", (1,), (2,), 30.0, 6.0, 4.0, 3, 0.02, 0.1)
    tunnel = StructureRecord("tunnel", (4,), (5,), 90.0, -9.0, None, None, 0.03, 0.1)
    tight = LayerCrossing(2, 7, 1, 3, 4.0, 5.2)
    found = ElevationReport(0.021, 1.5, 3.0, (), (), (bridge, bridge, tunnel), (tight,))
    document = json.loads(report({}, [], FIGURES, found, Diagnostics(), {}).decode())
    assert document["elevation"]["structures"][2]["clearance"] is None
    assert document["elevation"]["tight"] == [
        {"upper": 2, "lower": 7, "upper_way": 1, "lower_way": 3, "clearance": 4.0, "wanted": 5.2}
    ]


def test_details() -> None:
    lines = details(some())
    assert len(lines) == 1504
    assert lines[0] == "  note: late: a note"
    assert lines[1] == "  guessed: lane-count: no lanes given, 2 taken (way/0); correct it by way.0.lanes = 2"


def test_report_is_json_whatever_it_holds() -> None:
    found = Diagnostics()
    found.repaired("name", "way/1", "a name with half a character \udc80 and ü")
    figures = Statistics(1, 0, 0, 1.0, 0.0, math.nan, math.inf, None, {"k": math.nan})
    document = json.loads(
        report({"area": Path("a.osm")}, [], figures, None, found, {"file": "b.xodr"}).decode("utf-8")
    )
    assert document["statistics"]["lowest"] is None
    assert document["statistics"]["further"] == {"k": None}
    assert document["elevation"] is None
    assert document["input"] == {"area": "a.osm"}
    assert document["output"] == {"file": "b.xodr"}
    assert document["counts"] == [{"kind": "repaired", "code": "name", "count": 1}]
    assert document["diagnostics"] == [
        {"kind": "repaired", "code": "name", "osm_id": "way/1", "message": "a name with half a character ? and ü"}
    ]
