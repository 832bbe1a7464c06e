"""Diagnostics, figures and tables of heights."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import Ground, make_problem, solve, straight

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.geometry.heights.crossings import Crossings
from osm2xodr.geometry.heights.readings import Reading
from osm2xodr.geometry.heights.report import Outcome, _report_crossings


def test_a_clearance_of_nothing_has_no_sign() -> None:
    problem = make_problem(
        [straight((-50.0, 0.0), (50.0, 0.0), spans=[(0.0, 1, 1)]), straight((0.0, -50.0), (0.0, 50.0))]
    )
    road, none = np.array([0], np.int64), np.zeros(0)
    crossings = Crossings(road, np.array([50.0]), road + 1, np.array([50.0]), np.array([5.2]))
    no_road = np.zeros(0, np.int64)
    reading = Reading(none, none, none, none, none, none > 0, none > 0, none, none)
    outcome = Outcome(none, none, none, reading, none > 0, none, none, crossings, np.array([-0.04]), no_road)
    for height, word in ((-0.04, "0.0"), (-0.3, "-0.3"), (1.26, "1.3")):
        diagnostics = Diagnostics()
        _report_crossings(problem, replace(outcome, clearance=np.array([height])), diagnostics)
        (note,) = diagnostics
        assert note.osm_id == "way/100"
        assert note.message.startswith(f"it passes {word} m above way/101 instead of 5.2 m")


def test_road_without_heights_is_filled_and_reported() -> None:
    ground = Ground(lambda x, y: np.where(x < 500.0, 10.0 + 0.02 * x, 20.0), known=lambda x, y: np.asarray(x < 500.0))
    roads = [straight((0.0, 0.0), (400.0, 0.0)), straight((600.0, 0.0), (900.0, 0.0))]
    found = solve(roads, ground)
    assert found.z(1, np.linspace(0.0, 300.0, 9)) == pytest.approx(20.0, abs=0.02)
    notes = [item for item in found.diagnostics if item.code == "no-height"]
    assert [(item.kind, item.osm_id) for item in notes] == [(Kind.GUESSED, "way/101")]
    assert "300 m" in notes[0].message
    assert found.solution.statistics["height_measured_share"] == pytest.approx(4 / 7, abs=0.02)


def test_steep_road_is_reported_and_smooth_roads_are_not() -> None:
    ground = Ground(lambda x, y: 0.24 * x)
    found = solve([straight((0.0, 0.0), (300.0, 0.0))], ground)
    assert [item.osm_id for item in found.diagnostics if item.code == "steep"] == ["way/100"]
    assert found.solution.statistics["grade_over_class_limit_km"] == pytest.approx(0.3, abs=0.01)
    assert (
        solve([straight((0.0, 0.0), (300.0, 0.0))], Ground(lambda x, y: 300.0 + 0.05 * x - 0.03 * y)).codes() == set()
    )


def test_report_names_bridges_and_what_they_cross() -> None:
    upper = [(0.0, 0, 0), (250.0, 1, 1), (350.0, 0, 0)]
    ground = Ground(lambda x, y: 0.01 * x, cell_size=10.0, sigma=1.0)
    roads = [straight((-300.0, 0.0), (300.0, 0.0), spans=upper), straight((0.0, -300.0), (0.0, 300.0))]
    found = solve(roads, ground)
    report = found.solution.report
    assert report is not None
    (bridge,) = report.structures
    assert (bridge.kind, bridge.osm_way_ids, bridge.roads) == ("bridge", (101,), (0,))
    assert bridge.length == pytest.approx(100.0)
    assert bridge.crossed_way == 103
    gap = float(found.z(0, 300.0)[0] - found.z(1, 300.0)[0])
    assert bridge.clearance == pytest.approx(gap, abs=1e-6)
    assert bridge.above_ground is not None
    assert bridge.above_ground == pytest.approx(float(found.z(0, 300.0)[0]), abs=0.3)
    assert bridge.grade == pytest.approx(np.abs(found.grade(0, np.linspace(250.0, 350.0, 400))).max(), abs=1e-3)
    assert bridge.grade_limit == 0.15
    assert report.tight == ()
    assert report.measured_share == 1.0
    assert found.solution.statistics["structures"] == 1.0


def test_report_measures_against_the_surface() -> None:
    # What the road cannot follow: a pit of 3 m over 8 m.
    ground = Ground(lambda x, y: np.where(np.abs(x) < 4.0, -3.0, 0.0) + 0.0 * x, cell_size=4.0, sigma=0.5)
    found = solve([straight((-200.0, 0.0), (200.0, 0.0))], ground)
    report = found.solution.report
    assert report is not None
    _, x, y, z = found.along(0, 0.25)
    off = z - ground.height(x, y)
    assert report.rms == pytest.approx(float(np.sqrt(np.mean(off**2))), rel=0.15)
    assert report.bias == pytest.approx(float(np.mean(off)), abs=0.02)
    assert (report.farthest[0].road, report.farthest[0].osm_way_id) == (0, 100)
    assert report.farthest[0].s == pytest.approx(200.0, abs=4.0)
    assert report.farthest[0].value == pytest.approx(float(off[np.argmax(np.abs(off))]), abs=0.3)


def test_roads_far_from_all_that_is_measured_are_reported_as_unknown() -> None:
    ground = Ground(lambda x, y: np.where(x < 500.0, 10.0, 20.0), known=lambda x, y: np.asarray(x < 500.0))
    near, far = straight((600.0, 0.0), (900.0, 0.0)), straight((3000.0, 0.0), (4500.0, 0.0))
    found = solve([straight((0.0, 0.0), (400.0, 0.0)), near, far], ground)
    (note,) = [item for item in found.diagnostics if item.code == "height-unknown"]
    assert note.kind is Kind.GUESSED
    assert note.message.startswith("the heights of 1.5 km of roads are not known: nothing within 1 km")
    gaps = [item.osm_id for item in found.diagnostics if item.code == "no-height"]
    assert gaps == ["way/101", "way/102"]
