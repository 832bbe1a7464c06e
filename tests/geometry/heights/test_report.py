"""Diagnostics, figures and tables of heights."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import Ground, make_problem, solve, straight

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.geometry.heights.crossings import Crossings
from osm2xodr.geometry.heights.elements import Network, build_elements, build_samples, number_unknowns
from osm2xodr.geometry.heights.readings import Reading
from osm2xodr.geometry.heights.report import (
    Outcome,
    _report_crossings,
    element_grades,
    report,
    statistics,
    tabulate,
    tolerated_grade,
)
from osm2xodr.model import ElevationReport, LayerCrossing, RoadPlace, StructureRecord


def test_a_clearance_of_nothing_has_no_sign() -> None:
    problem = make_problem(
        [straight((-50.0, 0.0), (50.0, 0.0), spans=[(0.0, 1, 1)]), straight((0.0, -50.0), (0.0, 50.0))]
    )
    road, none = np.array([0], np.int64), np.zeros(0)
    at = np.array([50.0])
    crossings = Crossings(road, at, road + 1, at, np.array([5.2]), road, np.zeros((1, 2)))
    no_road = np.zeros(0, np.int64)
    reading = Reading(none, none, none, none, none, none > 0, none > 0, none, none, none)
    low, no = np.array([-0.04]), np.zeros(1, bool)
    outcome = Outcome(none, none, none, reading, no, none, none, crossings, low, no_road)
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
    # The least of pieces of 4 m within 3 m of the middle of both roads.
    gap = found.z(0, np.linspace(297.0, 303.0, 7)).min() - found.z(1, np.linspace(297.0, 303.0, 7)).max()
    assert bridge.clearance is not None
    assert gap - 0.05 < bridge.clearance < gap + 0.1
    assert bridge.above_ground is not None
    assert bridge.above_ground == pytest.approx(float(found.z(0, 300.0)[0]), abs=0.3)
    assert bridge.grade == pytest.approx(np.abs(found.grade(0, np.linspace(250.0, 350.0, 400))).max(), abs=1e-3)
    assert bridge.grade_limit == 0.15
    assert report.tight == ()
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


# ---------------------------------------------------------------- an outcome by hand


def by_hand() -> tuple[Network, Outcome]:
    """Return roads in elements of 20 m, with a sample every 10 m, and what was found for them.

    Road 70: 100 m to the east, ways 100, 101 (a bridge from 40 to 60 m) and 102. Road 71: 100 m to the north beneath
    that bridge, way 103. Road 72: 60 m, way 104, without heights and with nothing that holds it. Road 73: a tunnel of
    40 m, way 105.
    """
    roads = [
        straight((0.0, 0.0), (100.0, 0.0), spans=[(0.0, 0, 0), (40.0, 1, 1), (60.0, 0, 0)]),
        straight((50.0, -50.0), (50.0, 50.0)),
        straight((0.0, 300.0), (60.0, 300.0)),
        straight((0.0, 500.0), (40.0, 500.0), spans=[(0.0, 2, -1)]),
    ]
    problem = replace(make_problem(roads), road_id=np.array([70, 71, 72, 73]))
    elements = build_elements(problem, 20.0)
    samples = build_samples(problem, elements, np.full(4, 10.0))
    network = Network(problem, elements, samples, number_unknowns(problem, elements))
    assert len(samples.s) == 30
    road = elements.road[samples.element]
    surface = np.full(30, 10.0)
    off = np.zeros(30)
    # 6 m too high at 25 m of the first road, 7 m too low at 95 m of the second, the bridge 5 and 4 m up, the tunnel
    # 8 and 9 m down at its ends.
    off[2], off[19] = 6.0, -7.0
    off[4:6] = 5.0, 4.0
    off[26:] = -8.0, -2.0, -1.0, -9.0
    measured = road != 2
    reading = Reading(
        surface,
        surface,
        np.ones(30),
        np.ones(30),
        np.ones(30),
        measured,
        np.zeros(30, bool),
        np.ones(30),
        np.zeros(30),
        np.zeros(30),
    )
    grade = np.full(len(elements.h), 0.05)
    limit = np.full(len(elements.h), 0.1)
    grade[[1, 2, 8, 13, 14]] = 0.12, 0.2, 0.11, 0.15, 0.3
    limit[14] = 0.4
    chain = np.full(len(elements.h), -1)
    chain[2], chain[13:] = 0, 1
    one = np.array([0], np.int64)
    outcome = Outcome(
        z=surface + off,
        knots=np.zeros((len(elements.knot_s), 2)),
        planes=np.array([[5.0, 0.03, -0.04], [6.0, 0.0, 0.02]]),
        reading=reading,
        floating=np.array([False, False, True, True]),
        grade=grade,
        limit=limit,
        crossings=Crossings(one, np.array([50.0]), one + 1, np.array([50.0]), np.array([5.2]), one, np.zeros((1, 2))),
        clearance=np.array([4.56]),
        chain=chain,
    )
    return network, outcome


def messages(network: Network, outcome: Outcome) -> list[tuple[Kind, str, str, str]]:
    diagnostics = Diagnostics()
    report(network, outcome, diagnostics)
    return [(item.kind, item.code, item.osm_id, item.message) for item in diagnostics]


def test_all_that_is_guessed_and_not_met_is_reported() -> None:
    network, outcome = by_hand()
    problem = replace(network.problem, span_grade=np.array([0.1, 0.36, -0.36, 0.35, -0.35, np.nan]))
    assert messages(replace(network, problem=problem), outcome) == [
        (
            Kind.GUESSED,
            "no-height",
            "way/104",
            "the elevation model has no heights along 60 m of it, they are filled from around",
        ),
        (
            Kind.GUESSED,
            "no-ground",
            "way/105",
            "nothing it is connected to lies on the ground, 40 m of it take the ground's height",
        ),
        (Kind.NOTE, "steep", "way/101", "its grade reaches 20.0 %, more than the 10 % usual for its class"),
        (Kind.NOTE, "steep", "way/105", "its grade reaches 15.0 %, more than the 10 % usual for its class"),
        (
            Kind.NOTE,
            "clearance",
            "way/101",
            "it passes 4.6 m above way/103 instead of 5.2 m, more would make the roads too steep",
        ),
        (Kind.DROPPED, "incline", "way/101", "its incline is steeper than any street, it is ignored"),
        (Kind.DROPPED, "incline", "way/102", "its incline is steeper than any street, it is ignored"),
        # Not the first road, which has a bridge near by.
        (
            Kind.NOTE,
            "off-ground",
            "way/103",
            (
                "it lies up to 7.0 m below the ground of the elevation model, 4.0 m more than roads of its class are "
                "cut or filled: it keeps clear of the roads above or below"
            ),
        ),
    ]


def test_tables_name_the_worst_place_of_each_road() -> None:
    network, outcome = by_hand()
    found = tabulate(network, outcome)
    # 18 samples on the ground are measured: on the first road without the bridge, and on the second.
    off = np.abs(np.r_[6.0, -7.0, np.zeros(16)])
    figures = (found.bias, found.rms, found.p95)
    assert figures == pytest.approx((-1 / 18, np.sqrt(85 / 18), np.percentile(off, 95)))
    assert found == ElevationReport(
        *figures,
        farthest=(RoadPlace(71, 103, 95.0, -7.0, 0.0), RoadPlace(70, 100, 25.0, 6.0, 0.0)),
        # By share of the limit, at the middle of the element.
        steep=(
            RoadPlace(70, 101, 50.0, 0.2, 0.1),
            RoadPlace(73, 105, 10.0, 0.15, 0.1),
            RoadPlace(71, 103, 70.0, 0.11, 0.1),
        ),
        structures=(
            StructureRecord("bridge", (101,), (70,), 20.0, 5.0, 4.56, 103, 0.2, 0.1),
            StructureRecord("tunnel", (105,), (73,), 40.0, -9.0, None, None, 0.15, 0.1),
        ),
        tight=(LayerCrossing(70, 71, 101, 103, 4.56, 5.2),),
    )


def test_figures() -> None:
    network, outcome = by_hand()
    assert statistics(network.elements, outcome, tabulate(network, outcome)) == {
        "height_above_surface_mean_m": pytest.approx(-1.0 / 18.0),
        "height_above_surface_rms_m": pytest.approx(np.sqrt(85.0 / 18.0)),
        "height_above_surface_p95_m": pytest.approx(float(np.percentile(np.r_[6.0, 7.0, np.zeros(16)], 95))),
        "grade_max": 0.3,
        "grade_over_class_limit_km": pytest.approx(0.08),
        "junction_tilt_max": pytest.approx(0.05),
        "layer_crossings": 1.0,
        "layer_crossings_too_close": 1.0,
        "structures": 2.0,
        "structures_too_steep": 2.0,
    }


def test_figures_where_there_is_nothing_to_measure() -> None:
    network, outcome = by_hand()
    none = replace(outcome.reading, measured=np.zeros(30, bool))
    free = replace(outcome, reading=none, planes=np.zeros((0, 3)), clearance=np.array([5.2]))
    found = tabulate(network, free)
    assert (found.bias, found.rms, found.p95) == (0.0, 0.0, 0.0)
    assert (found.farthest, found.tight) == ((), ())
    assert [item.above_ground for item in found.structures] == [None, None]
    figures = statistics(network.elements, free, found)
    assert (figures["junction_tilt_max"], figures["layer_crossings_too_close"]) == (0.0, 0.0)


@pytest.mark.parametrize(("clearance", "short"), [(4.89, True), (4.91, False)])
def test_three_decimetres_less_clearance_are_tolerated(clearance: float, short: bool) -> None:
    network, outcome = by_hand()
    outcome = replace(outcome, clearance=np.array([clearance]))
    assert ("clearance" in {code for _, code, _, _ in messages(network, outcome)}) == short
    assert (tabulate(network, outcome).tight != ()) == short


def test_grades_up_to_a_quarter_more_than_usual_are_not_reported() -> None:
    """And two thousandths: an elastic limit gives way a little."""
    assert tolerated_grade(0.08) == pytest.approx(0.102)
    network, outcome = by_hand()
    for grade, steep in ((float(tolerated_grade(0.1)), False), (0.1271, True)):
        found = replace(outcome, grade=np.full(len(outcome.grade), grade), limit=np.full(len(outcome.grade), 0.1))
        ways = [way for _, code, way, _ in messages(network, found) if code == "steep"]
        assert ways == ([f"way/{way}" for way in range(100, 106)] if steep else [])
        too_steep = statistics(network.elements, found, tabulate(network, found))["structures_too_steep"]
        assert too_steep == (2.0 if steep else 0.0)


def test_gaps_of_roads_that_are_held_are_reported_where_they_lie_on_the_ground() -> None:
    """20 m of the first road's start, and its bridge."""
    network, outcome = by_hand()
    measured = outcome.reading.measured.copy()
    measured[[0, 1, 4, 5]] = False
    found = messages(network, replace(outcome, reading=replace(outcome.reading, measured=measured)))
    text = "m of it, they are filled from around"
    assert [(way, message) for _, code, way, message in found if code == "no-height"] == [
        ("way/100", f"the elevation model has no heights along 20 {text}"),
        ("way/104", f"the elevation model has no heights along 60 {text}"),
    ]


@pytest.mark.parametrize(("length", "reported"), [(1.0, True), (0.99, False)])
def test_gaps_of_less_than_a_metre_are_not_reported(length: float, reported: bool) -> None:
    ground = Ground(lambda x, y: 0.1 * x, known=lambda x, y: np.asarray(x < 150.0))
    found = solve([straight((0.0, 0.0), (100.0, 0.0)), straight((200.0, 0.0), (200.0 + length, 0.0))], ground)
    assert [item.osm_id for item in found.diagnostics if item.code == "no-height"] == ["way/101"] * reported


# A street may be cut by 2 m and the standard error of 1 m; limits give way by half a metre.
@pytest.mark.parametrize(("off", "reported"), [(3.51, True), (3.49, False)])
def test_roads_that_are_cut_deeper_than_their_class_are_named(off: float, reported: bool) -> None:
    network, outcome = by_hand()
    z = outcome.reading.z.copy()
    z[12] -= off
    ways = [way for _, code, way, _ in messages(network, replace(outcome, z=z)) if code == "off-ground"]
    assert ways == ["way/103"] * reported


def test_all_roads_far_off_the_ground_are_named_and_ten_tabulated() -> None:
    roads = [straight((0.0, 50.0 * k), (10.0, 50.0 * k)) for k in range(12)]
    problem = make_problem(roads)
    elements = build_elements(problem, 20.0)
    samples = build_samples(problem, elements, np.full(12, 10.0))
    network = Network(problem, elements, samples, number_unknowns(problem, elements))
    _, outcome = by_hand()
    none, every = np.zeros(0), np.ones(12)
    nowhere = np.zeros(0, np.int64)
    reading = Reading(every, every, every, every, every, every > 0, every < 0, every, 0.0 * every, 0.0 * every)
    outcome = Outcome(
        z=1.0 + 6.0 + np.arange(12.0),
        knots=np.zeros((24, 2)),
        planes=np.zeros((0, 3)),
        reading=reading,
        floating=every < 0,
        grade=0.0 * every,
        limit=0.1 * every,
        crossings=Crossings(nowhere, none, nowhere, none, none, nowhere, np.zeros((0, 2))),
        clearance=none,
        chain=np.full(12, -1),
    )
    worst = list(range(11, 1, -1))
    assert [way for _, _, way, _ in messages(network, outcome)] == [f"way/{100 + k}" for k in range(12)]
    found = tabulate(network, outcome)
    assert [(item.road, item.value) for item in found.farthest] == [(k, 6.0 + k) for k in worst]
    assert found.structures == ()


@pytest.mark.parametrize(
    ("z", "start", "end", "steepest"),
    [
        # 10 m long. A straight one; an S, steepest in its middle; a parabola, steepest at its end.
        (1.0, 0.1, 0.1, 0.1),
        (1.0, 0.0, 0.0, 0.15),
        (-1.0, 0.0, 0.0, 0.15),
        (1.0, 0.0, 0.2, 0.2),
        (-1.0, -0.2, 0.0, 0.2),
        # Grades 0.1 + 0.4 u - 0.6 u²: the vertex at a third.
        (1.0, 0.1, -0.1, 0.1 + 0.4 / 6.0),
        # Vertices before its start and beyond its end: 0.1 + 0.2 u + 0.1 u², 0.4 - 0.3 u + 0.1 u².
        (10 * (0.1 + 0.1 + 0.1 / 3), 0.1, 0.4, 0.4),
        (10 * (0.4 - 0.15 + 0.1 / 3), 0.4, 0.2, 0.4),
    ],
)
def test_largest_grade_of_an_element(z: float, start: float, end: float, steepest: float) -> None:
    elements = build_elements(make_problem([straight((0.0, 0.0), (10.0, 0.0))]), 20.0)
    knots = np.array([[3.0, start], [3.0 + z, end]])
    assert element_grades(elements, knots) == pytest.approx([steepest])


def test_roads_far_from_all_that_is_measured_are_reported_as_unknown() -> None:
    ground = Ground(lambda x, y: np.where(x < 500.0, 10.0, 20.0), known=lambda x, y: np.asarray(x < 500.0))
    near, far = straight((600.0, 0.0), (900.0, 0.0)), straight((3000.0, 0.0), (4500.0, 0.0))
    found = solve([straight((0.0, 0.0), (400.0, 0.0)), near, far], ground)
    (note,) = [item for item in found.diagnostics if item.code == "height-unknown"]
    assert note.kind is Kind.GUESSED
    assert note.message.startswith("the heights of 1.5 km of roads are not known: nothing within 1 km")
    gaps = [item.osm_id for item in found.diagnostics if item.code == "no-height"]
    assert gaps == ["way/101", "way/102"]
