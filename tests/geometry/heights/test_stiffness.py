"""How much more roads bend in hills and where they turn on slopes.

Stiffness of the network, and bridges and tunnels as chains.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import Ground, RoadSpec, make_problem, solve, straight

from osm2xodr.geometry.heights.crossings import find_crossings
from osm2xodr.geometry.heights.elements import Network, build_elements, build_samples, hermite, number_unknowns
from osm2xodr.geometry.heights.readings import Reading
from osm2xodr.geometry.heights.stiffness import (
    Chains,
    arm_deviations,
    bridges_above,
    deflection_stiffness,
    estimated_elements,
    find_chains,
    network_stiffness,
    road_flexibility,
    rotation_stiffness,
)
from osm2xodr.geometry.options import ElevationOptions
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


def chains(roads: list[RoadSpec], junctions: list[tuple[float, float]]) -> Chains:
    problem = make_problem(roads, junctions)
    return find_chains(problem, build_elements(problem, 60.0))


def test_chain_runs_over_a_link_and_turns_with_the_roads() -> None:
    found = chains(
        [
            straight((0.0, 0.0), (100.0, 0.0), end_link=3, spans=[(0.0, 0, 0), (60.0, 1, 1)]),
            straight((200.0, 0.0), (100.0, 0.0), end_link=1, spans=[(0.0, 0, 0), (60.0, 1, 1)]),
        ],
        [],
    )
    assert found.chain[[1, 4]].tolist() == [0, 0] if len(found.chain) > 4 else found.chain.tolist() == [-1, 0, -1, 0]
    on = found.chain >= 0
    assert sorted(found.sign[on].tolist()) == [-1.0, 1.0]
    assert found.loose.tolist() == [False]


def test_chains_end_at_junctions_and_loose_ends() -> None:
    bridge = [(0.0, 1, 1)]
    found = chains(
        [
            straight((-50.0, 0.0), (-5.0, 0.0), end=0, spans=bridge),
            straight((5.0, 0.0), (50.0, 0.0), start=0, spans=bridge),
            straight((0.0, 5.0), (0.0, 50.0), start=0),
        ],
        [(0.0, 0.0)],
    )
    assert found.chain.tolist() == [0, 1, -1]
    assert found.loose.tolist() == [True, True]


def test_chain_goes_straight_on_over_a_junction_on_a_bridge() -> None:
    bridge = [(0.0, 1, 1)]
    found = chains(
        [
            straight((-50.0, 0.0), (-5.0, 0.0), end=0, spans=bridge),
            straight((50.0, 1.0), (5.0, 0.0), end=0, spans=bridge),
            straight((4.0, 3.0), (40.0, 20.0), start=0, spans=bridge),
        ],
        [(0.0, 0.0)],
    )
    # The ramp leaves at 25 degrees: straight on is straighter.
    assert found.chain.tolist() == [0, 0, 1]
    assert found.sign[0] == -found.sign[1]


def test_chain_does_not_turn_at_a_junction_on_a_bridge() -> None:
    bridge = [(0.0, 1, 1)]
    roads = [
        straight((0.0, -5.0), (0.0, -50.0), start=0, spans=bridge),
        straight((5.0, 0.0), (50.0, 0.0), start=0, spans=bridge),
    ]
    assert chains(roads, [(0.0, 0.0)]).chain.tolist() == [0, 1]


def test_junctions_tend_to_be_level() -> None:
    problem = make_problem([straight((5.0, 0.0), (50.0, 0.0), start=0)], [(0.0, 0.0)])
    elements = build_elements(problem, 50.0)
    samples = build_samples(problem, elements, np.array([10.0]))
    network = Network(problem, elements, samples, number_unknowns(problem, elements))
    matrix = network_stiffness(network, find_chains(problem, elements), np.array([5e-5])).toarray()
    # Across its only road nothing else resists the tilt.
    assert matrix[2, :3] == pytest.approx([0.0, 0.0, 1.0 / 0.3**2])


def spoked(distance: float) -> Network:
    """Return a road of 45 m that ends so far from its junction's origin, m, and another one whose end is carried."""
    roads = [
        straight((distance, 0.0), (distance + 45.0, 0.0), start=0),
        straight((200.0, 245.0), (200.0, 205.0), end=1),
    ]
    problem = replace(make_problem(roads, [(0.0, 0.0), (200.0, 200.0)]), carried=np.array([False, True]))
    elements = build_elements(problem, 50.0)
    samples = build_samples(problem, elements, np.full(2, 10.0))
    return Network(problem, elements, samples, number_unknowns(problem, elements))


def test_arms_deviate_from_the_planes_of_their_junctions() -> None:
    network = spoked(5.0)
    end, distance, height, grade = arm_deviations(network)
    assert end.tolist() == [0]
    assert distance == pytest.approx([5.0])
    # A plane 7 m high that rises by 0.1 to the east, and an arm 1 m above it that climbs by 0.04 more.
    x = np.linalg.lstsq(network.unknowns.to_knots.toarray()[:2], np.array([8.5, 0.14]), rcond=None)[0]
    x[:3] = 7.0, 0.1, 0.3
    assert height @ x == pytest.approx([1.0])
    assert grade @ x == pytest.approx([0.04])


@pytest.mark.parametrize(("distance", "counted"), [(5.0, 5.0), (12.0, 12.0), (0.2, 1.0)])
def test_arms_bend_away_from_their_planes_as_beams(distance: float, counted: float) -> None:
    network, q = spoked(distance), 5e-5
    matrix = network_stiffness(network, find_chains(network.problem, network.elements), np.array([q, q])).toarray()
    to_knots = network.unknowns.to_knots.toarray()
    _, _, height, grade = arm_deviations(network)
    for dz, dg in ((1.0, 0.0), (0.0, 0.1), (0.3, -0.2), (1.0, 1.5 / counted)):
        # The road beyond is straight: all the energy is that of the way to the junction's middle.
        s = np.array([0.0, 45.0])
        knots = np.zeros(len(to_knots))
        knots[:4] = np.column_stack([dz + dg * s, [dg, dg]]).ravel()
        x = np.linalg.lstsq(to_knots, knots, rcond=None)[0]
        assert height @ x == pytest.approx([dz])
        assert grade @ x == pytest.approx([dg])
        # The cubic that leaves the plane at the middle, 0 and level there: z = a s² + b s³, energy 1 / q of z''².
        d = counted
        a, b = 3 * dz / d**2 - dg / d, dg / d**2 - 2 * dz / d**3
        energy = 4 * a**2 * d + 12 * a * b * d**2 + 12 * b**2 * d**3
        assert x @ matrix @ x == pytest.approx(energy / q, rel=1e-6)


def test_leveling_pulls_roads_on_the_ground_alone() -> None:
    problem = make_problem([straight((0.0, 0.0), (80.0, 0.0), spans=[(0.0, 0, 0), (50.0, 1, 1)])])
    elements = build_elements(problem, 50.0)
    samples = build_samples(problem, elements, np.array([10.0]))
    network = Network(problem, elements, samples, number_unknowns(problem, elements))
    found, to_knots = find_chains(problem, elements), network.unknowns.to_knots.toarray()
    flexibility, slope = np.full(2, 5e-5), np.linalg.inv(to_knots) @ [0.0, 0.1, 5.0, 0.1, 8.0, 0.1]
    plain, leveled = (network_stiffness(network, found, flexibility, tau).toarray() for tau in (0.0, 4.0))
    slope = np.r_[slope, np.zeros(len(plain) - len(slope))]
    # A tension of 4 1/m times the square of a grade of 10 % over 50 m.
    assert slope @ (leveled - plain) @ slope == pytest.approx(4.0 * 0.1**2 * 50.0)


def test_stiffness_of_beams_on_an_elastic_foundation() -> None:
    # Integrated numerically: a hinged end that is turned by 1, and a long beam that is lifted by 1 m.
    w, q = 0.05, 5e-5
    problem = make_problem([straight((0.0, 0.0), (600.0, 0.0))])
    elements = build_elements(problem, 2.0)
    samples = build_samples(problem, elements, np.array([1.0]))
    network = Network(problem, elements, samples, number_unknowns(problem, elements))
    size = len(elements.knot_s) * 2
    to_knots = network.unknowns.to_knots.toarray()
    rows = network.knot_rows(samples.element, samples.u, hermite).toarray()
    bed = (
        to_knots @ network_stiffness(network, find_chains(problem, elements), np.full(300, q)).toarray() @ to_knots.T
    )
    bed += rows.T @ (w * samples.ds[:, None] * rows)
    hinged = np.delete(np.arange(size), 0)
    turned = np.linalg.solve(bed[np.ix_(hinged, hinged)], np.eye(size - 1)[0])[0]
    assert 1.0 / turned == pytest.approx(float(rotation_stiffness(np.array(w), q)), rel=1e-3)
    middle = 2 * (len(elements.knot_s) // 2)
    lifted = np.linalg.solve(bed, np.eye(size)[middle])[middle]
    assert 1.0 / lifted == pytest.approx(float(deflection_stiffness(np.array(w), np.array(q))), rel=1e-3)


def gorge(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.where(np.abs(x) < 45.0, 100.0 - 40.0 * np.cos(np.pi * x / 90.0) ** 2, 100.0)


def test_bridge_over_a_gorge_stays_level() -> None:
    spans = [(0.0, 0, 0), (140.0, 1, 1), (260.0, 0, 0)]
    found = solve([straight((-200.0, 0.0), (200.0, 0.0), spans=spans)], Ground(gorge))
    _, _, _, z = found.along(0)
    assert z == pytest.approx(100.0, abs=0.05)


def test_without_structures_the_road_follows_the_gorge() -> None:
    spans = [(0.0, 0, 0), (140.0, 1, 1), (260.0, 0, 0)]
    options = ElevationOptions(structures=False)
    found = solve([straight((-200.0, 0.0), (200.0, 0.0), spans=spans)], Ground(gorge), options=options)
    assert found.z(0, 200.0) < 95.0


def test_long_tunnel_under_a_ridge_runs_straight_from_portal_to_portal() -> None:
    # The roads climb toward both portals; what has no tension would arch 25 m high in between.
    ground = Ground(lambda x, y: np.where(np.abs(x) < 950.0, 500.0, 100.0 - 0.05 * (np.abs(x) - 1000.0) + 0.01 * x))
    spans = [(0.0, 0, 0), (300.0, 2, -1), (2300.0, 0, 0)]
    found = solve([straight((-1300.0, 0.0), (1300.0, 0.0), spans=spans)], ground)
    s, x, _, z = found.along(0)
    inside = np.abs(x) < 900.0
    assert np.abs(z[inside] - (100.0 + 0.01 * x[inside])).max() < 8.0
    assert found.grade(0, s[inside]) == pytest.approx(0.01, abs=0.03)
    assert found.z(0, 0.0) == pytest.approx(72.0, abs=0.2)


def test_structures_of_linked_roads_are_one_chord() -> None:
    # Two halves of a bridge that meet head-on, the second one drawn from its far end.
    a = straight((-200.0, 0.0), (0.0, 0.0), end_link=3, spans=[(0.0, 0, 0), (140.0, 1, 1)])
    b = straight((200.0, 0.0), (0.0, 0.0), end_link=1, spans=[(0.0, 0, 0), (140.0, 1, 1)])
    found = solve([a, b], Ground(lambda x, y: gorge(x, y) + 0.02 * x))
    for road in (0, 1):
        _, x, _, z = found.along(road)
        assert z == pytest.approx(100.0 + 0.02 * x, abs=0.05)
    assert found.grade(0, 200.0) == pytest.approx(-found.grade(1, 200.0), abs=1e-12)


def test_tunnel_that_the_edge_cuts_does_not_run_away() -> None:
    spans = [(0.0, 0, 0), (200.0, 2, -1)]
    found = solve([straight((0.0, 0.0), (2000.0, 0.0), spans=spans)], Ground(lambda x, y: 0.05 * x))
    _, _, _, z = found.along(0)
    assert z.max() < 15.0
    assert z.min() > -0.1


def test_bridges_above_each_other_are_counted_from_the_top() -> None:
    """A bridge over a street, below another one, below a third: the street is none, and neither is a tunnel."""
    roads = [
        straight((-200.0, 10.0 * k), (200.0, 10.0 * k), spans=[(0.0, 0, 0), (50.0, *level), (350.0, 0, 0)])
        for k, level in enumerate([(0, 0), (2, -1)])
    ]
    roads += [
        straight((50.0 * k, -200.0), (-50.0 * k, 200.0), spans=[(0.0, 0, 0), (50.0, 1, k), (350.0, 0, 0)])
        for k in (1, 2, 3)
    ]
    problem = make_problem(roads, [])
    elements = build_elements(problem, 60.0)
    network = Network(
        problem, elements, build_samples(problem, elements, np.full(5, 20.0)), number_unknowns(problem, elements)
    )
    crossings = find_crossings(problem, network.unknowns.end_node)[0]
    found = bridges_above(network, find_chains(problem, elements), crossings)
    on = elements.structure > 0
    assert {(int(road), int(count)) for road, count in zip(elements.road[on], found[on], strict=True)} == {
        (1, 0),
        (2, 2),
        (3, 1),
        (4, 0),
    }
    assert not found[~on].any()


def test_the_upper_bridge_rises_and_the_lower_one_stays_straight() -> None:
    """Over a valley, with the portals of both at one height."""
    spans = [[(0.0, 0, 0), (200.0, 1, layer), (800.0, 0, 0)] for layer in (1, 2)]
    roads = [
        straight((-500.0, 0.0), (500.0, 0.0), spans=spans[0]),
        straight((0.0, -500.0), (0.0, 500.0), spans=spans[1]),
    ]
    valley = Ground(lambda x, y: 20.0 - 15.0 * ((np.abs(x) < 290.0) & (np.abs(y) < 290.0)), cell_size=5.0, sigma=0.5)
    found = solve(roads, valley)
    lower, upper = (float(found.z(road, 500.0)[0]) for road in (0, 1))
    assert upper - lower > 5.0
    # Of what is wanted the upper one takes most.
    assert 0.0 <= 20.0 - lower < 0.4 * (upper - 20.0)
