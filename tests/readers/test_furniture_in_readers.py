"""Readers see signals, controllers and crosswalks of a map made by hand where they are."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lxml import etree
from real_readers import carla_answers, qc_result, schema_errors, sumo_net
from sample_road_maps import furnished_crossing

from osm2xodr.checking import CheckOptions, Severity, check_file
from osm2xodr.conventions.targets import TARGETS
from osm2xodr.curves.cubics import cubic_value
from osm2xodr.curves.records import pose
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import FloatArray
from osm2xodr.xodrWriter import VERSIONS, WriteOptions, write_xodr

# CARLA moves the posts of lights along s, so that they do not stand in stop signs, m.
CARLA_SHIFT = 0.25
# CARLA computes in single precision, and turns crosswalks by the lane offset's slope.
PRECISION = 0.05


def file_of(folder: Path, version: str = "1.7", target: str = "generic") -> Path:
    stream = io.BytesIO()
    write_xodr(furnished_crossing(), stream, WriteOptions(version, target=TARGETS[target]), Diagnostics())
    path = folder / f"{target}-{version}.xodr"
    path.write_bytes(stream.getvalue())
    return path


def place(road: int, s: float, t: float) -> FloatArray:
    """Return x, y, z on the map's roads, m."""
    road_map = furnished_crossing()
    curve, at = np.array([road - 1]), np.array([s])
    x, y, hdg = pose(road_map.plan_view, curve, at)
    z = cubic_value(road_map.elevation, curve, at)
    return np.array([x - t * np.sin(hdg), y + t * np.cos(hdg), z])[:, 0]


@pytest.fixture(scope="module")
def carla(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return carla_answers(file_of(tmp_path_factory.mktemp("carla")))


def test_carla_finds_signals_and_references(carla: dict[str, Any]) -> None:
    found = {(item["id"], item["road"]): item for item in carla["landmarks"]}
    assert set(found) == {("1", 1), ("2", 2), ("3", 1), ("1", 3), ("2", 4)}
    for signal in furnished_crossing().furniture.signals:
        item = found[str(signal.id), signal.road]
        assert (item["type"], item["country"], item["light"]) == (signal.type, signal.country, signal.dynamic)
        meant = place(signal.road, signal.s, signal.t)
        assert np.hypot(*(np.array(item["place"]) - meant)[:2]) <= CARLA_SHIFT + PRECISION
        assert item["place"][2] == pytest.approx(meant[2] + signal.z_offset, abs=PRECISION)
    assert (found["3", 1]["value"], found["3", 1]["unit"]) == (70.0, "km/h")
    assert found["1", 1]["lanes"] == [[-2, -1]]
    assert found["1", 3]["lanes"] == [[-1, -1]]


@pytest.mark.parametrize("target", ["generic", "carla"])
def test_carla_finds_crosswalks_in_place(target: str, tmp_path: Path) -> None:
    (found,) = carla_answers(file_of(tmp_path, target=target))["crosswalks"]
    # Its axis u runs across the road, to the left.
    meant = [place(1, 80.0 - v, u) for u, v in ((-3.5, 2.0), (3.5, 2.0), (3.5, -2.0), (-3.5, -2.0), (-3.5, 2.0))]
    assert np.abs(np.array(found)[:, :2] - np.array(meant)[:, :2]).max() < PRECISION


def test_netconvert_makes_a_traffic_light(tmp_path: Path) -> None:
    net = sumo_net(file_of(tmp_path), tmp_path)
    assert net.errors == []
    root = etree.parse(str(tmp_path / "generic-1.7.net.xml")).getroot()
    (logic,) = root.iterfind("tlLogic")
    assert logic.get("id") == "5"
    controlled = [item for item in root.iterfind("connection") if item.get("tl") == "5"]
    assert {(item.get("from"), item.get("to")) for item in controlled} == {("-1#1", "-2"), ("2", "1#1")}


@pytest.mark.parametrize("target", TARGETS)
def test_the_checker_of_asam_finds_nothing(target: str, tmp_path: Path) -> None:
    result = qc_result(file_of(tmp_path, target=target), tmp_path)
    assert result.issues == []
    assert "error" not in result.checkers


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("target", TARGETS)
def test_it_is_valid(target: str, version: str, tmp_path: Path) -> None:
    assert schema_errors(file_of(tmp_path, version, target), version) == []


def test_our_own_check_finds_nothing_about_furniture(tmp_path: Path) -> None:
    words = ("signal", "object", "controller", "crosswalk", "outline", "user-data", "misplaced", "unreadable")
    result = check_file(file_of(tmp_path), CheckOptions(readers=("carla", "esmini", "sumo")))
    about = [item for item in result.findings if any(word in item.rule for word in words)]
    # The hand-made light 2 and its reference name no lanes, as CARLA would want.
    assert {item.rule for item in about} == {"signal-without-lanes"}
    assert all(item.severity <= Severity.WARNING for item in about)
