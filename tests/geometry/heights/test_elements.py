"""Roads cut into elements, and the numbering of unknowns."""

from __future__ import annotations

from elevation_helpers import make_problem, straight

from osm2xodr.geometry.heights import ProfileProblem
from osm2xodr.geometry.heights.elements import build_elements, components, number_unknowns


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
    assert components(problem, unknowns).tolist() == [0, 0, 0, 1]
