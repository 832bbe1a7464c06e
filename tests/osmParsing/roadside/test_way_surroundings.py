"""How densely streets lie around a way, and people cross it."""

from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.model import FloatArray
from osm2xodr.osmParsing.roadside import WayPieces
from osm2xodr.osmParsing.roadside.way_surroundings import crossing_densities, street_densities


def density(dwellings: str, distance: float) -> list[float]:
    """Return the density around a road of 200 m and around a street of 200 m beside it."""
    points = np.array([(-100.0, 0.0), (100.0, 0.0), (-100.0, distance), (100.0, distance)])
    found = street_densities(points, np.array([2, 2]), np.array([0, 1]), ["tertiary", dwellings])
    return [float(value) for value in found[0]]


def density_of(nodes: list[int], points: FloatArray) -> float:
    """Return the density around one road beside the residential street of nodes 3 and 4."""
    lines = points[[*nodes, 3, 4]]
    return float(street_densities(lines, np.array([2, 2]), np.array([0, 1]), ["tertiary", "residential"])[0, 0])


@pytest.mark.parametrize("dwellings", ["residential", "living_street"])
def test_streets_with_houses_nearby_count(dwellings: str) -> None:
    # Windows of 300 m hold all of a street that is at most 100 m away and 200 m long.
    assert density(dwellings, 80.0) == pytest.approx([200.0 / 9.0] * 2, abs=0.1)


def test_those_farther_away_and_other_roads_do_not_count() -> None:
    assert density("residential", 320.0)[0] == 0.0
    assert density("unclassified", 80.0) == [0.0, 0.0]


@pytest.mark.parametrize(("highway", "counts"), [("secondary", True), ("primary", False), ("service", False)])
def test_streets_of_a_grid_count_with_those_that_have_houses(highway: str, counts: bool) -> None:
    lines = np.array([(-100.0, 0.0), (100.0, 0.0), (-100.0, 80.0), (100.0, 80.0)])
    found = street_densities(lines, np.array([2, 2]), np.array([0, 1]), ["residential", highway])
    assert found[0, 0] == pytest.approx(200.0 / 9.0, abs=0.1)
    assert found[1, 0] == pytest.approx((400.0 if counts else 200.0) / 9.0, abs=0.1)


def test_a_way_of_two_pieces_has_their_mean() -> None:
    points = np.array([(0.0, 0.0), (100.0, 0.0), (1100.0, 0.0), (0.0, 50.0), (100.0, 50.0)])
    near, far = density_of([0, 1], points), density_of([1, 2], points)
    assert near > 2.0 * far > 0.0
    lines, counts, ways = points[[0, 1, 1, 2, 3, 4]], np.array([2, 2, 2]), np.array([0, 0, 1])
    both = street_densities(lines, counts, ways, ["tertiary", "residential"])[0, 0]
    assert both == pytest.approx((100.0 * near + 1000.0 * far) / 1100.0)


def test_crossings_count_once_and_only_where_people_cross() -> None:
    # A way of 300 m in two pieces that share node 12, at which people cross, and a way of 100 m. Nodes 10 to 14
    # have the numbers 0 to 4.
    points = np.array([(0.0, 0.0), (200.0, 0.0), (200.0, 0.0), (300.0, 0.0), (0.0, 50.0), (100.0, 50.0)])
    pieces = WayPieces(points, np.array([0, 2, 2, 1, 3, 4]), np.array([2, 2, 2]), np.array([0, 0, 1]))
    tags = {
        10: {"highway": "crossing"},
        11: {"highway": "traffic_signals"},
        12: {"highway": "crossing", "crossing": "marked"},
        13: {"highway": "crossing", "crossing": "no"},
        99: {"highway": "crossing"},
    }
    found = crossing_densities(pieces, 3, np.arange(10, 15), tags)
    assert found.tolist() == pytest.approx([2.0 / 300.0, 0.0, 0.0])
