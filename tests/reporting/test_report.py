"""

What diagnostics mean: every code that the program uses is explained, and docs/diagnostics.md says the same.
"""

from __future__ import annotations

import importlib.util
import json
import math
from pathlib import Path

from raised_codes import raised_codes

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import ElevationReport, LayerCrossing, StructureRecord
from osm2xodr.python_api import read_corrections
from osm2xodr.reporting import codes
from osm2xodr.reporting.report import details, report
from osm2xodr.reporting.statistics import Statistics

FIGURES = Statistics(1200, 1, 0, 143_210.0, 12.0, -3.21, 1912.77, 0.9996)

ROOT = Path(__file__).parents[2]


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


def test_every_code_in_the_source_is_explained_with_its_kinds() -> None:
    raised = raised_codes()
    assert len(raised) > 100
    assert {"lane-count": {"guessed", "dropped", "repaired"}, "flat": {"note"}}.items() <= raised.items()
    known = {name: {kind.value for kind in item.kinds} for name, item in codes().items()}
    assert known == raised


def test_codes_are_in_order_and_say_what_to_do() -> None:
    assert list(codes()) == sorted(codes())
    for name, item in codes().items():
        assert item.meaning.endswith("."), name
        assert item.remedy.endswith("."), name
        assert list(item.kinds) == [kind for kind in Kind if kind in item.kinds], name


def test_no_two_codes_do_the_same_harm() -> None:
    harms = [item.harm for item in codes().values() if item.harm is not None]
    assert len(set(harms)) == len(harms) > 10
    # Heights that nobody measured do most harm.
    order = ["dem-gap", "no-height", "clearance", "restriction"]
    assert sorted(order, key=lambda name: codes()[name].harm or 0) == order


def test_the_document_is_in_step() -> None:
    spec = importlib.util.spec_from_file_location("diagnostics_table", ROOT / "tools" / "diagnostics_table.py")
    assert spec is not None
    assert spec.loader is not None
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    assert (ROOT / "docs" / "diagnostics.md").read_text(encoding="utf-8") == tool.page()
    assert all(f"\n| `{name}` | " in tool.page() for name in codes())


def test_mistakes_of_osm_are_some_of_the_kinds() -> None:
    for name, item in codes().items():
        assert set(item.osm) <= set(item.kinds), name
        # What is only missing in OSM is no mistake, but for classes and layers, which are there and mean nothing.
        assert Kind.GUESSED not in item.osm or name in ("highway-class", "layer"), name
    assert codes()["lane-count"].osm == (Kind.DROPPED, Kind.REPAIRED)
    assert codes()["steep"].osm == ()


def test_corrections_that_are_offered_can_be_read(tmp_path: Path) -> None:
    offered = {name: item for name, item in codes().items() if item.correction}
    assert {"lane-count", "speed", "clearance", "closed"} <= offered.keys()
    for name, item in offered.items():
        element = "node/1" if name == "ele" else "way/1"
        path = tmp_path / f"{name}.toml"
        path.write_text(item.line_for(element), encoding="utf-8")
        assert len(list(read_corrections(path).entries())) >= 1
        assert item.line_for("") == ""
    assert codes()["lane-count"].line_for("way/12") == "way.12.lanes = 2"
