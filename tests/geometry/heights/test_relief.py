"""How much more roads bend in hills and where they turn on slopes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import RoadSpec, make_problem, straight

from osm2xodr.geometry.heights.elements import Network, build_elements, build_samples, number_unknowns
from osm2xodr.geometry.heights.readings import Reading
from osm2xodr.geometry.heights.relief import estimated_elements, road_flexibility
from osm2xodr.model import FloatArray

Q = 5e-5


def network_of(roads: list[RoadSpec], spacing: float = 10.0) -> Network:
    problem = make_problem(roads)
    elements = build_elements(problem, 20.0)
    samples = build_samples(problem, elements, np.full(len(roads), spacing))
    return Network(problem, elements, samples, number_unknowns(problem, elements))


def reading(network: Network, z: FloatArray | float = 0.0, sigma: float = 0.0) -> Reading:
    """Return bare, measured ground whose relief was not estimated."""
    one = np.ones(len(network.samples.s))
    heights = one * z
    flags = one > 0, one < 0
    return Reading(heights, heights, sigma * one, one, one, *flags, np.nan * one, 0 * one, 0 * one)


def flexibility(network: Network, found: Reading, usual: float = Q) -> FloatArray:
    return road_flexibility(network, found, np.full(len(network.elements.h), usual))


def test_roads_of_plains_bend_as_their_class_does() -> None:
    network = network_of([straight((0.0, 0.0), (1000.0, 0.0))])
    assert flexibility(network, reading(network)) == pytest.approx(np.full(50, Q))
    slope = replace(reading(network, 0.2 * network.samples.s), across=np.full(100, 0.3))
    assert flexibility(network, slope, 3e-5) == pytest.approx(np.full(50, 3e-5))


@pytest.mark.parametrize("times", [0.1, 1.0, 4.0, 100.0])
def test_relief_of_coarse_cells_makes_roads_more_flexible(times: float) -> None:
    network = network_of([straight((0.0, 0.0), (100.0, 0.0)), straight((0.0, 50.0), (100.0, 50.0))])
    # Relief A / k⁴ gives curvature along a line the density A k / 4, here at 0.025 rad/m.
    log_relief = np.where(np.arange(20) < 10, np.log(times * Q * 4.0 / 0.025), np.nan)
    found = replace(reading(network), log_relief=log_relief)
    assert flexibility(network, found) == pytest.approx([Q * max(times, 1.0) ** 0.6] * 5 + [Q] * 5)
    assert estimated_elements(network, found).tolist() == [True] * 5 + [False] * 5


def test_relief_of_fine_models_is_seen_along_the_roads() -> None:
    """Heights whose second differences over 30 m are as those of white curvature, plus errors."""
    density, sigma, count = 5e-3, 0.2, 60
    rng = np.random.default_rng(5)
    # In one square of 400 m many roads on rough ground, in another one on level ground.
    rough = [straight((1.0, 6.0 * k + 1.0), (391.0, 6.0 * k + 1.0)) for k in range(count)]
    level = [straight((401.0, 6.0 * k + 1.0), (791.0, 6.0 * k + 1.0)) for k in range(count)]
    network = network_of([*rough, *level], 3.0)
    road, s = network.elements.road[network.samples.element], network.samples.s
    z = rng.normal(0.0, sigma, len(s))
    for k in range(count):
        at = np.flatnonzero(road == k)
        bend = rng.normal(0.0, np.sqrt(density / 3.0), len(at))
        z[at] += np.cumsum(np.cumsum(bend) * 3.0) * 3.0
    found = flexibility(network, reading(network, z, sigma))
    hills, plain = found[network.elements.road < count], found[network.elements.road >= count]
    assert hills == pytest.approx(np.full(len(hills), Q * (density / Q) ** 0.6), rel=0.15)
    assert plain == pytest.approx(np.full(len(plain), Q), rel=0.3)
    # Canopy says nothing of the ground, nor does what is not measured, nor errors alone.
    covered = replace(reading(network, z, sigma), covered=np.ones(len(s), bool))
    nowhere = replace(reading(network, z, sigma), measured=np.zeros(len(s), bool))
    for nothing in (covered, nowhere, reading(network, rng.normal(0.0, 0.2, len(s)), 0.4)):
        assert flexibility(network, nothing) == pytest.approx(np.full(len(network.elements.h), Q))


def test_walls_and_short_roads_make_no_relief() -> None:
    wall = network_of([straight((0.0, 0.0), (390.0, 0.0))], 3.0)
    # One step of 6 m on level ground: most second differences are 0.
    found = reading(wall, np.where(wall.samples.s > 200.0, 6.0, 0.0))
    assert flexibility(wall, found) == pytest.approx(np.full(20, Q))
    short = network_of([straight((0.0, 9.0 * k), (55.0, 9.0 * k)) for k in range(30)], 3.0)
    rough = reading(short, np.random.default_rng(1).normal(0.0, 3.0, len(short.samples.s)))
    assert flexibility(short, rough) == pytest.approx(np.full(len(short.elements.h), Q))


@pytest.mark.parametrize("curvature", [0.05, -0.05])
def test_bends_on_a_slope_have_the_curvature_that_it_gives_them(curvature: float) -> None:
    network = network_of([RoadSpec(0.0, 0.0, 0.0, 60.0, curvature), straight((0.0, 99.0), (60.0, 99.0))])
    found = replace(reading(network), across=np.full(12, 0.2))
    # A vertical curvature of 0.2 * 0.05 1/m all along an element of 20 m.
    assert flexibility(network, found) == pytest.approx([Q + 0.01**2 * 20.0] * 3 + [Q] * 3)


def test_no_roads() -> None:
    network = network_of([])
    assert flexibility(network, reading(network)).tolist() == []
    assert estimated_elements(network, reading(network)).tolist() == []
