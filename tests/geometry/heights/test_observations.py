"""What is observed: weights, kinds and thresholds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import Ground, make_problem, solve, straight

from osm2xodr.curves.cubics import cubic_value
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.heights import solve_profiles
from osm2xodr.geometry.heights.elements import build_elements, number_unknowns
from osm2xodr.geometry.heights.observations import portal_distance
from osm2xodr.model import FloatArray

PLANE = Ground(lambda x, y: 300.0 + 0.05 * x - 0.03 * y)


def test_distance_to_portals_reaches_over_nodes() -> None:
    roads = [
        straight((0.0, 0.0), (100.0, 0.0), end=0, spans=[(0.0, 0, 0), (70.0, 2, -1)]),
        straight((110.0, 0.0), (150.0, 0.0), start=0),
        straight((105.0, 5.0), (105.0, 60.0), start=0),
    ]
    problem = make_problem(roads, [(105.0, 0.0)])
    elements = build_elements(problem, 200.0)
    behind, ahead = portal_distance(elements, number_unknowns(problem, elements).end_node)
    assert elements.structure.tolist() == [0, 2, 0, 0]
    assert ahead[[0, 2, 3]].tolist() == [0.0, np.inf, np.inf]
    assert behind[[0, 2, 3]].tolist() == [np.inf, 0.0, 0.0]


def test_tunnel_alone_lies_level_at_the_height_of_the_ground() -> None:
    found = solve([straight((0.0, 0.0), (300.0, 0.0), spans=[(0.0, 2, -1)])], PLANE)
    assert found.z(0, np.linspace(0.0, 300.0, 9)) == pytest.approx(307.5, abs=0.1)
    assert found.codes() == {"no-ground"}


def test_incline_tags_count_where_heights_say_little() -> None:
    ground = Ground(lambda x, y: np.zeros(len(x)) + 0.0 * x, cell_size=10.0, sigma=8.0)
    plain = solve([straight((0.0, 0.0), (200.0, 0.0))], ground)
    tagged = solve([straight((0.0, 0.0), (200.0, 0.0), grade=0.1)], ground)
    absurd = solve([straight((0.0, 0.0), (200.0, 0.0), grade=0.9)], ground)
    assert plain.grade(0, 100.0) == pytest.approx(0.0, abs=1e-9)
    assert 0.03 < float(tagged.grade(0, 100.0)[0]) < 0.1
    assert absurd.grade(0, 100.0) == pytest.approx(0.0, abs=1e-9)
    assert absurd.codes() == {"incline"}


def with_ele(z: list[float], ground: Ground) -> tuple[FloatArray, FloatArray]:
    """Return x and z of a road of 400 m with ``ele`` at even distances."""
    roads = [straight((-200.0, 0.0), (200.0, 0.0))]
    n = len(z)
    problem = replace(
        make_problem(roads),
        ele_road=np.zeros(n, np.int64),
        ele_s=(np.arange(n) + 0.5) * 400.0 / n,
        ele_z=np.array(z, np.float64),
    )
    solution = solve_profiles(problem, ground, Diagnostics())
    s = np.linspace(0.0, 400.0, 401)
    return s - 200.0, cubic_value(solution.elevation, np.zeros(401, np.int64), s)


def test_ele_tags_count_where_there_are_no_heights() -> None:
    beyond = Ground(
        lambda x, y: np.full(len(x), 40.0), cell_size=10.0, sigma=1.0, known=lambda x, y: np.asarray(x < -100.0)
    )
    x, plain = with_ele([], beyond)
    _, tagged = with_ele([40.0, 40.0, 47.0, 54.0], beyond)
    assert plain == pytest.approx(40.0, abs=0.01)
    # The ground is a guess there, good for 30 m; a tag is good for 5 m.
    assert tagged[x < -150.0] == pytest.approx(40.0, abs=0.6)
    assert 49.0 < tagged[350] < 55.0


def test_ele_tags_hardly_count_against_heights_and_outliers_not_at_all() -> None:
    ground = Ground(lambda x, y: np.full(len(x), 40.0) + 0.01 * x, cell_size=10.0, sigma=1.0)
    plain = with_ele([], ground)[1]
    assert np.abs(with_ele([44.0, 44.0, 44.0, 44.0], ground)[1] - plain).max() < 0.5
    # 48 m: an ellipsoidal height.
    assert np.abs(with_ele([88.0, 88.0, 88.0, 88.0], ground)[1] - plain).max() < 0.05


def test_carriageways_of_one_street_are_level_with_each_other() -> None:
    # On a hillside; 3 % across over 15 m.
    ground = Ground(lambda x, y: 0.03 * y, cell_size=30.0, sigma=6.0)

    def gap(name: int) -> float:
        a = straight((-400.0, 0.0), (400.0, 0.0), oneway=1, name=name)
        b = straight((400.0, 15.0), (-400.0, 15.0), oneway=1, name=name)
        found = solve([a, b], ground)
        return float(found.z(1, 400.0)[0] - found.z(0, 400.0)[0])

    assert gap(-1) == pytest.approx(0.45, abs=0.03)
    assert 0.2 < gap(0) < 0.41
