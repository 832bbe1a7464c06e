"""Roads cut into elements, and the numbering of unknowns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import RoadSpec, make_problem, straight

from osm2xodr.geometry.heights import ProfileProblem
from osm2xodr.geometry.heights.elements import (
    Network,
    bending_matrices,
    build_elements,
    build_samples,
    components,
    element_at,
    end_poses,
    hermite,
    hermite_slope,
    number_unknowns,
    on_plane,
    tension_matrices,
)


def test_elements_end_where_the_structure_changes() -> None:
    problem = make_problem([straight((0.0, 0.0), (200.0, 0.0), spans=[(0.0, 0, 0), (50.0, 1, 1), (80.0, 0, 0)])])
    elements = build_elements(problem, 60.0)
    assert elements.s.tolist() == [0.0, 50.0, 80.0, 140.0]
    assert elements.h.tolist() == [50.0, 30.0, 60.0, 60.0]
    assert elements.structure.tolist() == [0, 1, 0, 0]
    assert elements.knot_start.tolist() == [0, 5]


def test_slivers_are_no_elements() -> None:
    problem = make_problem([straight((0.0, 0.0), (100.0, 0.0), spans=[(0.0, 1, 1), (0.2, 0, 0), (99.7, 1, 1)])])
    assert build_elements(problem, 60.0).s.tolist() == [0.0, 50.0]


def test_components_by_links_and_junctions() -> None:
    roads = [
        straight((0.0, 0.0), (9.0, 0.0), end_link=2),
        straight((9.0, 0.0), (20.0, 0.0), start_link=1, end=0),
        straight((21.0, 1.0), (30.0, 9.0), start=0),
        straight((50.0, 0.0), (60.0, 0.0)),
    ]
    problem: ProfileProblem = make_problem(roads, [(20.5, 0.5)])
    unknowns = number_unknowns(problem, build_elements(problem, 60.0))
    assert components(unknowns).tolist() == [0, 0, 0, 1]


def test_the_first_span_holds_from_the_start_of_its_road() -> None:
    problem = make_problem([straight((0.0, 0.0), (60.0, 0.0), spans=[(3.0, 1, 1), (40.0, 0, 0)])])
    elements = build_elements(problem, 60.0)
    assert (elements.s.tolist(), elements.structure.tolist()) == ([0.0, 40.0], [1, 0])


@pytest.mark.parametrize(
    ("border", "starts"), [(0.9, [0.0]), (1.0, [0.0, 1.0]), (99.0, [0.0, 99.0]), (99.1, [0.0]), (40.0, [0.0, 40.0])]
)
def test_stretches_have_a_metre_at_least(border: float, starts: list[float]) -> None:
    problem = make_problem([straight((0.0, 0.0), (100.0, 0.0), spans=[(0.0, 0, 0), (border, 1, 1)])])
    assert build_elements(problem, 100.0).s.tolist() == starts


def test_two_changes_within_a_metre_are_one() -> None:
    spans = [(0.0, 0, 0), (40.0, 1, 1), (40.9, 0, 0), (70.0, 1, 1), (71.0, 0, 0)]
    elements = build_elements(make_problem([straight((0.0, 0.0), (100.0, 0.0), spans=spans)]), 100.0)
    assert elements.s.tolist() == [0.0, 40.0, 70.0, 71.0]


def test_spans_of_one_structure_are_cut_together_and_each_element_has_that_of_its_middle() -> None:
    spans = [(0.0, 0, 0), (26.0, 0, 0), (70.0, 0, 0)]
    roads = [straight((0.0, 0.0), (100.0, 0.0), spans=spans), straight((0.0, 9.0), (30.0, 9.0))]
    elements = build_elements(make_problem(roads), np.array([25.0, 60.0]))
    assert elements.s.tolist() == [0.0, 25.0, 50.0, 75.0, 0.0]
    assert elements.span.tolist() == [0, 1, 1, 2, 3]
    assert elements.road.tolist() == [0, 0, 0, 0, 1]
    assert elements.knot.tolist() == [0, 1, 2, 3, 5]
    assert elements.knot_s.tolist() == [0.0, 25.0, 50.0, 75.0, 100.0, 0.0, 30.0]
    assert elements.end_knots.tolist() == [[0, 4], [5, 6]]
    assert elements.end_elements.tolist() == [[0, 3], [4, 4]]
    at = element_at(elements, np.array([0, 0, 0, 1, 1]), np.array([0.0, 24.9, 25.0, 0.0, 30.0]))
    assert at.tolist() == [0, 0, 1, 4, 4]


def test_samples_are_spread_evenly_along_each_element() -> None:
    roads = [straight((0.0, 0.0), (40.0, 0.0)), RoadSpec(5.0, 0.0, 0.5 * np.pi, 9.0)]
    problem = make_problem(roads)
    found = build_samples(problem, build_elements(problem, 20.0), np.array([7.0, 20.0]))
    assert found.element.tolist() == [0, 0, 0, 1, 1, 1, 2]
    assert found.ds == pytest.approx([20 / 3] * 6 + [9.0])
    assert found.u == pytest.approx([1 / 6, 1 / 2, 5 / 6] * 2 + [1 / 2])
    assert found.s == pytest.approx([10 / 3, 10.0, 50 / 3, 70 / 3, 30.0, 110 / 3, 4.5])
    assert found.x == pytest.approx([*found.s[:6], 5.0])
    assert found.y == pytest.approx([0.0] * 6 + [4.5])
    assert found.hdg == pytest.approx([0.0] * 6 + [0.5 * np.pi])


def test_cubics_are_met_and_their_energy_is_that_of_beams_and_strings() -> None:
    """z = 2 + 0.3 s - 0.02 s² + 1e-3 s³ over 8 m."""
    h = 8.0
    dofs = np.array([2.0, 0.3, 2.0 + 2.4 - 1.28 + 0.512, 0.3 - 0.32 + 0.192])
    u = np.linspace(0.0, 1.0, 9)
    s, length = h * u, np.full(9, h)
    assert hermite(u, length) @ dofs == pytest.approx(2.0 + 0.3 * s - 0.02 * s**2 + 1e-3 * s**3)
    assert hermite_slope(u, length) @ dofs == pytest.approx(0.3 - 0.04 * s + 3e-3 * s**2)
    # Gauss-Legendre with three places is exact.
    x, w = np.sqrt(0.6) * np.array([-1.0, 0.0, 1.0]), np.array([5.0, 8.0, 5.0]) / 9.0
    s, w = 0.5 * h * (1 + x), 0.5 * h * w
    bend, slope = -0.04 + 6e-3 * s, 0.3 - 0.04 * s + 3e-3 * s**2
    one = np.array([h])
    assert dofs @ bending_matrices(one)[0] @ dofs == pytest.approx(w @ bend**2)
    assert dofs @ tension_matrices(one)[0] @ dofs == pytest.approx(w @ slope**2)
    for matrices in (bending_matrices(one), tension_matrices(one)):
        assert matrices[0] == pytest.approx(matrices[0].T)


def test_unknowns_are_planes_then_free_ends_then_inner_knots() -> None:
    """Two roads at a junction, the first of which touches the start of a third with its start."""
    roads = [
        straight((0.0, 0.0), (50.0, 0.0), start_link=4, end=0),
        straight((55.0, 10.0), (55.0, 90.0), start=0),
        straight((0.0, 0.0), (-30.0, 0.0), start_link=0),
    ]
    problem = make_problem(roads, [(55.0, 0.0)])
    elements = build_elements(problem, 40.0)
    unknowns = number_unknowns(problem, elements)
    assert elements.knot_s.tolist() == [0.0, 25.0, 50.0, 0.0, 40.0, 80.0, 0.0, 30.0]
    # Three of the plane; the common start, both ends at the junction, the free ends of the second and of the third
    # road; two inner knots.
    assert unknowns.to_knots.shape == (16, 17)
    assert unknowns.junctions == 1
    assert unknowns.z_columns.tolist() == [0, 3, 5, 7, 9, 11, 13, 15]
    assert unknowns.end_node[[1, 2]].tolist() == [0, 0]
    assert unknowns.end_node[0] == unknowns.end_node[4]
    assert len(set(unknowns.end_node.tolist())) == 4
    # The common start is 4 m high and rises by 0.05 along the first road.
    knots = (unknowns.to_knots @ np.r_[7.0, 0.1, 0.2, 4.0, 0.05, np.arange(5.0, 17.0)]).reshape(-1, 2)
    assert knots[[0, 6]].tolist() == [[4.0, 0.05], [4.0, -0.05]]
    # Road ends at junctions have heights and grades of their own.
    assert knots[[2, 3, 5, 7]].tolist() == [[5.0, 6.0], [7.0, 8.0], [9.0, 10.0], [11.0, 12.0]]
    assert knots[[1, 4]].tolist() == [[13.0, 14.0], [15.0, 16.0]]


def test_where_crossfall_runs_through_a_junction_its_roads_end_on_its_plane() -> None:
    roads = [straight((0.0, 0.0), (50.0, 0.0), end=0), straight((55.0, 10.0), (55.0, 40.0), start=0, end=1)]
    problem = replace(make_problem(roads, [(55.0, 0.0), (55.0, 45.0)]), carried=np.array([True, False]))
    unknowns = number_unknowns(problem, build_elements(problem, 60.0))
    # Six of the planes, the free start of the first road and the end of the second.
    assert unknowns.to_knots.shape == (8, 10)
    assert unknowns.z_columns.tolist() == [0, 3, 6, 8]
    assert on_plane(problem).tolist() == [False, True, True, False]
    # A plane of height 7 and slopes 0.1 and 0.2.
    knots = (unknowns.to_knots @ np.r_[7.0, 0.1, 0.2, 90.0, 91.0, 92.0, 3.0, 4.0, 5.0, 6.0]).reshape(-1, 2)
    assert knots[[1, 2]].tolist() == [pytest.approx([6.5, 0.1]), pytest.approx([9.0, 0.2])]
    assert knots[[0, 3]].tolist() == [[3.0, 4.0], [5.0, 6.0]]


def test_without_junctions_no_end_lies_on_a_plane() -> None:
    problem = replace(make_problem([straight((0.0, 0.0), (50.0, 0.0))]), carried=np.zeros(0, bool))
    assert on_plane(problem).tolist() == [False, False]


@pytest.mark.parametrize("link", [2, 5, 0])
def test_links_must_be_symmetric(link: int) -> None:
    roads = [straight((0.0, 9.0 * k), (20.0, 9.0 * k)) for k in range(3)]
    roads[0].end_link, roads[1].start_link = 2, 1
    problem = make_problem(roads)
    assert number_unknowns(problem, build_elements(problem, 60.0)).to_knots.shape[1] == 10
    roads[2].start_link = link
    problem = make_problem(roads)
    with pytest.raises(ValueError, match=r"^end_link must be symmetric$"):
        number_unknowns(problem, build_elements(problem, 60.0))


def test_ends_and_places_along_roads() -> None:
    roads = [straight((0.0, 0.0), (30.0, 40.0)), RoadSpec(0.0, 0.0, 0.0, 10.0 * np.pi, curvature=0.1)]
    problem = make_problem(roads)
    x, y, hdg = end_poses(problem)
    assert x == pytest.approx([0.0, 30.0, 0.0, 0.0], abs=1e-9)
    assert y == pytest.approx([0.0, 40.0, 0.0, 20.0], abs=1e-9)
    assert hdg == pytest.approx([np.arctan2(4, 3)] * 2 + [0.0, np.pi])
    elements = build_elements(problem, 25.0)
    samples = build_samples(problem, elements, np.full(2, 25.0))
    network = Network(problem, elements, samples, number_unknowns(problem, elements))
    element, u = network.place(np.array([0, 0, 0, 1]), np.array([-1.0, 30.0, 51.0, 5.0 * np.pi]))
    assert element.tolist() == [0, 1, 1, 3]
    assert u == pytest.approx([0.0, 0.2, 1.0, 0.0])
