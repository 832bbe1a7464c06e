"""What is observed: weights, kinds and thresholds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import Ground, RoadSpec, cross, make_problem, solve, straight

from osm2xodr.curves.cubics import cubic_value
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.heights import Pins, solve_profiles
from osm2xodr.geometry.heights.elements import Network, build_elements, build_samples, number_unknowns
from osm2xodr.geometry.heights.observations import (
    Kind,
    earthwork_samples,
    observe_cut_bridges,
    observe_dual_carriageways,
    observe_ele,
    observe_ground,
    observe_inclines,
    observe_junctions,
    observe_pins,
    portal_distance,
    weigh_heights,
)
from osm2xodr.geometry.heights.readings import Reading
from osm2xodr.model import FloatArray

PLANE = Ground(lambda x, y: 300.0 + 0.05 * x - 0.03 * y)


def network_of(roads: list[RoadSpec], junctions: list[tuple[float, float]], spacing: float = 10.0) -> Network:
    """Return roads cut into elements of at most 20 m with samples this far apart, m."""
    problem = make_problem(roads, junctions)
    elements = build_elements(problem, 20.0)
    samples = build_samples(problem, elements, np.full(len(roads), spacing))
    return Network(problem, elements, samples, number_unknowns(problem, elements))


def reading(count: int, z: float = 0.0, sigma: float = 2.0, cell: float = 10.0, covered: bool = False) -> Reading:
    """Return heights of one quality whose errors are correlated over 25 m."""
    every = np.ones(count)
    flags = every > 0, (every > 0) & covered
    return Reading(
        z * every, z * every, sigma * every, 25.0 * every, cell * every, *flags, np.nan * every, 0 * every, 0 * every
    )


def test_sample_weighs_as_its_length_of_road() -> None:
    network = network_of([straight((0.0, 0.0), (100.0, 0.0))], [])
    weight, floating = weigh_heights(network, reading(10))
    assert weight == pytest.approx(np.full(10, 10.0 / (25.0 * 2.0**2)))
    assert floating.tolist() == [False]


def test_junction_weighs_as_ten_metres_of_road() -> None:
    network = network_of([straight((0.0, 0.0), (100.0, 0.0), start=0)], [(-5.0, 0.0)])
    block = observe_junctions(network, reading(1, z=7.0), mean=3.0)
    assert block.weight == pytest.approx([10.0 / (25.0 * 2.0**2)])
    assert block.value.tolist() == [4.0]
    assert block.kind.tolist() == [Kind.JUNCTION_HEIGHT]
    assert block.rows.toarray()[0, :3].tolist() == [1.0, 0.0, 0.0]


def test_junction_holds_its_roads_at_the_height_of_its_middle() -> None:
    # The middle lies on a hump of 1 m that none of the samples along the four roads sees.
    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        return np.asarray(np.where(np.hypot(x, y) < 3.0, 1.0, 0.0))

    roads = cross(size=12.0, trim=4.0)
    z = solve(roads, Ground(height, cell_size=5.0, sigma=0.5), [(0.0, 0.0)]).solution.junction_plane[0, 0]
    assert 0.1 < z < 0.5


@pytest.mark.parametrize(("arms", "share"), [((0, 0), 1.0), ((1, 0), 0.01), ((1, 1), 0.0), ((2, 2), 0.0)])
def test_junction_on_a_structure_does_not_see_the_ground(arms: tuple[int, int], share: float) -> None:
    roads = [
        straight((-5.0, 0.0), (-100.0, 0.0), start=0, spans=[(0.0, arms[0], 0), (50.0, 0, 0)]),
        straight((5.0, 0.0), (100.0, 0.0), start=0, spans=[(0.0, arms[1], 0)]),
    ]
    block = observe_junctions(network_of(roads, [(0.0, 0.0)]), reading(1), mean=0.0)
    assert block.weight == pytest.approx([share * 10.0 / (25.0 * 2.0**2)])


def test_junction_of_tunnels_alone_keeps_the_ground() -> None:
    roads = [straight((side, 0.0), (20.0 * side, 0.0), start=0, spans=[(0.0, 2, -1)]) for side in (-5.0, 5.0)]
    block = observe_junctions(network_of(roads, [(0.0, 0.0)]), reading(1), mean=0.0)
    assert block.weight == pytest.approx([10.0 / (25.0 * 2.0**2)])


def test_deck_runs_over_its_junction_as_if_there_was_no_river() -> None:
    roads = [
        straight((-300.0, 0.0), (-5.0, 0.0), end=0, spans=[(0.0, 0, 0), (150.0, 1, 1)]),
        straight((5.0, 0.0), (300.0, 0.0), start=0, spans=[(0.0, 1, 1), (145.0, 0, 0)]),
    ]
    river = Ground(lambda x, y: np.where(np.abs(x) < 120.0, -10.0, 0.01 * x), cell_size=5.0, sigma=0.5)
    found = solve(roads, river, [(0.0, 0.0)])
    s, x, _, z = found.along(0)
    deck = s > 150.0
    assert z[deck] == pytest.approx(0.01 * x[deck], abs=0.3)
    assert found.solution.junction_plane[0, 0] == pytest.approx(0.0, abs=0.3)


def test_ground_holds_the_end_of_a_bridge_that_the_maps_edge_cuts() -> None:
    roads = [
        straight((0.0, 0.0), (300.0, 0.0), spans=[(0.0, 0, 0), (200.0, 1, 1)]),
        straight((0.0, 50.0), (300.0, 50.0), spans=[(0.0, 0, 0), (100.0, 2, -1)]),
    ]
    network = network_of(roads, [])
    block = observe_cut_bridges(network, reading(len(network.samples.s), z=7.0), mean=3.0)
    assert block.value.tolist() == [4.0]
    assert block.weight == pytest.approx([1.0 / 5.0**2])
    assert block.kind.tolist() == [Kind.CUT_BRIDGE]
    # A bridge of 600 m may be 18 m high.
    long = network_of([straight((0.0, 0.0), (600.0, 0.0), spans=[(0.0, 1, 1)], start=0)], [(0.0, 0.0)])
    block_long = observe_cut_bridges(long, reading(len(long.samples.s)), mean=0.0)
    assert block_long.sigma == pytest.approx([18.0])
    # The height of the last knot of road 0, and of nothing else.
    knots = block.rows.toarray() @ np.linalg.pinv(network.unknowns.to_knots.toarray())
    last = 2 * int(network.elements.end_knots[0, 1])
    assert np.flatnonzero(np.abs(knots[0]) > 1e-9).tolist() == [last]


@pytest.mark.parametrize(("cell", "reach"), [(10.0, 8.0), (30.0, 15.0)])
def test_ground_near_portals_hardly_counts(cell: float, reach: float) -> None:
    spans = [(0.0, 0, 0), (100.0, 2, -1), (160.0, 0, 0)]
    network = network_of([straight((0.0, 0.0), (260.0, 0.0), spans=spans)], [], spacing=1.0)
    weight, _ = weigh_heights(network, reading(260, cell=cell))
    s = network.samples.s
    inside = (s > 100.0) & (s < 160.0)
    near = ~inside & (s > 100.0 - reach) & (s < 160.0 + reach)
    full = 1.0 / (25.0 * 2.0**2)
    assert weight[inside].tolist() == [0.0] * 60
    assert weight[near] == pytest.approx(np.full(2 * int(reach), 0.01 * full))
    assert weight[~inside & ~near] == pytest.approx(np.full(200 - 2 * int(reach), full))


def test_what_nothing_holds_takes_guesses() -> None:
    network = network_of([straight((0.0, 0.0), (100.0, 0.0), spans=[(0.0, 2, -1)])], [])
    weight, floating = weigh_heights(network, reading(10))
    assert weight == pytest.approx(np.full(10, 10.0 / (200.0 * 30.0**2)))
    assert floating.tolist() == [True]


def test_heights_of_surface_models_have_thresholds_of_their_own() -> None:
    network = network_of([straight((0.0, 0.0), (100.0, 0.0))], [])
    for covered, above, below in ((False, 3.0, 3.0), (True, 1.5, 8.0)):
        block = observe_ground(network, reading(10, covered=covered), np.ones(10), 0.0)
        assert block.kind.tolist() == [Kind.ROAD_HEIGHT] * 10
        assert block.above.tolist() == [above] * 10
        assert block.below.tolist() == [below] * 10
        assert block.canopy.tolist() == [covered] * 10
        assert block.floor.tolist() == [1e-3] * 10


def test_estimated_ground_loses_weight_later() -> None:
    network = network_of([straight((0.0, 0.0), (100.0, 0.0), start=0)], [(-5.0, 0.0)])
    ground = reading(10, cell=30.0)
    estimated = replace(ground, log_relief=np.where(np.arange(10) < 4, -3.0, np.nan))
    block = observe_ground(network, estimated, np.ones(10), 0.0)
    assert block.above.tolist() == block.below.tolist() == [6.0] * 4 + [3.0] * 6
    assert observe_junctions(network, estimated.part(slice(1)), 0.0).above.tolist() == [6.0]


def test_pins_never_lose_weight() -> None:
    network = network_of([straight((0.0, 0.0), (100.0, 0.0))], [])
    pins = Pins(np.array([0, 0]), np.array([30.0, 60.0]), np.array([5.0, np.nan]), np.array([0.02, np.nan]))
    block = observe_pins(replace(network, problem=replace(network.problem, pins=pins)), mean=1.0)
    assert block.value.tolist() == [4.0, 0.02]
    assert block.kind.tolist() == [Kind.PIN] * 2
    far = block.robust_factors(np.full(2, 1e6), block.sigma, geman_mcclure=True)
    assert far.tolist() == [1.0, 1.0]
    assert block.weight == pytest.approx([1e8, 1e8])


def test_incline_weighs_as_its_share_of_a_hundred_metres() -> None:
    roads = [straight((0.0, 0.0), (100.0, 0.0), grade=grade) for grade in (0.1, 0.36, np.nan)]
    network = network_of(roads, [])
    block = observe_inclines(network)
    assert block.value.tolist() == [0.1] * 5
    assert block.kind.tolist() == [Kind.GRADE] * 5
    assert block.sigma.tolist() == [0.02] * 5
    assert block.weight == pytest.approx(np.full(5, 20.0 / (100.0 * 0.02**2)))
    # The grade of a plane along the first road.
    x = np.zeros(block.rows.shape[1])
    x[network.unknowns.z_columns] = 1.0
    assert block.rows @ x == pytest.approx(np.zeros(5))


def test_ele_is_good_for_two_and_a_half_metres() -> None:
    network = network_of([straight((0.0, 0.0), (100.0, 0.0))], [])
    none = observe_ele(network, mean=0.0)
    assert none.rows.shape == (0, network.unknowns.to_knots.shape[1])
    problem = replace(network.problem, ele_road=np.array([0]), ele_s=np.array([30.0]), ele_z=np.array([440.0]))
    block = observe_ele(replace(network, problem=problem), mean=400.0)
    assert (block.value.tolist(), block.sigma.tolist()) == ([40.0], [2.5])
    assert block.weight == pytest.approx([1.0 / 6.25])
    assert block.kind.tolist() == [Kind.TAGGED_HEIGHT]


@pytest.mark.parametrize(("apart", "cell", "pairs"), [(24.0, 30.0, 10), (26.0, 30.0, 0), (24.0, 10.0, 0)])
def test_dual_carriageways_are_level_within_25_metres_on_coarse_cells(apart: float, cell: float, pairs: int) -> None:
    roads = [
        straight((0.0, 0.0), (100.0, 0.0), oneway=1, name=0),
        straight((100.0, apart), (0.0, apart), oneway=1, name=0),
    ]
    block = observe_dual_carriageways(network_of(roads, []), reading(20, cell=cell))
    assert block.value.tolist() == [0.0] * pairs
    assert block.weight == pytest.approx(np.full(pairs, 10.0 / (1.7 * 30.0 * 0.5**2)))


def test_robust_factors_are_those_of_cauchy_and_of_geman_and_mcclure() -> None:
    network = network_of([straight((0.0, 0.0), (30.0, 0.0))], [])
    block = observe_ground(network, reading(4, covered=True), np.ones(4), 0.0)
    residual = 2.0 * np.array([1.5, 3.0, -8.0, 1e6])
    cauchy = block.robust_factors(residual, block.sigma, geman_mcclure=False)
    assert cauchy == pytest.approx([0.5, 0.2, 0.5, 1e-3])
    assert block.robust_factors(residual, block.sigma, geman_mcclure=True) == pytest.approx([0.25, 0.04, 0.25, 1e-3])


def test_bare_ground_keeps_weight_as_huber_would_have_it() -> None:
    """Its force stays the same however far off it is, in both rounds: no ground is ever dropped."""
    network = network_of([straight((0.0, 0.0), (40.0, 0.0), start=0)], [(-5.0, 0.0)])
    blocks = [
        observe_ground(network, reading(4), np.ones(4), 0.0),
        observe_junctions(network, replace(reading(1), covered=np.zeros(1, bool)), 0.0),
    ]
    for block, residual in zip(blocks, (np.array([3.0, -6.0, 12.0, -600.0]), np.array([60.0])), strict=True):
        assert block.bare.all()
        # Three standard errors of 2 m.
        expected = np.minimum(1.0, 6.0 / np.abs(residual))
        for geman_mcclure in (False, True):
            found = block.robust_factors(residual, block.sigma, geman_mcclure=geman_mcclure)
            assert found == pytest.approx(expected)
    assert not observe_ground(network, reading(4, covered=True), np.ones(4), 0.0).bare.any()
    assert not observe_inclines(network_of([straight((0.0, 0.0), (40.0, 0.0), grade=0.1)], [])).bare.any()


def test_hill_that_limits_push_a_road_from_is_not_dropped() -> None:
    # A knoll of 10 m that a motorway cuts through: twice as heavy ground keeps pulling, so it stands out more.
    def cut(sigma: float) -> float:
        ground = Ground(lambda x, y: 10.0 * np.exp(-((x / 40.0) ** 2)), cell_size=10.0, sigma=sigma)
        found = solve([straight((-400.0, 0.0), (400.0, 0.0), highway="motorway")], ground)
        return float(found.z(0, 400.0)[0])

    loose, usual, precise = cut(4.0), cut(1.0), cut(0.2)
    assert loose < usual < precise
    assert precise > 7.0


def test_cuts_and_fills_count_on_bare_measured_ground_away_from_structures() -> None:
    network = network_of([straight((0.0, 0.0), (400.0, 0.0), spans=[(0.0, 0, 0), (200.0, 1, 1), (240.0, 0, 0)])], [])
    found = reading(40)
    found = replace(found, measured=np.arange(40) != 2, covered=np.arange(40) == 3)
    counts = earthwork_samples(network, found)
    s = network.samples.s
    wanted = (s < 140.0) | (s > 300.0)
    wanted[[2, 3]] = False
    assert counts.tolist() == wanted.tolist()
    # Half a cell where that is more.
    coarse = earthwork_samples(network, replace(found, cell=np.full(40, 200.0)))
    assert s[coarse].min() == 5.0
    assert s[coarse].max() == 395.0
    assert not coarse[(s > 100.0) & (s < 340.0)].any()


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


def test_roads_are_held_at_pins_and_have_a_record_there() -> None:
    """Half a metre above the ground and with a grade of its own; one without a height is a knot alone."""
    roads = [straight((0.0, 200.0), (300.0, 200.0)), straight((0.0, 0.0), (300.0, 0.0))]
    pins = Pins(np.array([1, 1]), np.array([100.0, 220.0]), np.array([3.5, np.nan]), np.array([0.04, np.nan]))
    ground = Ground(lambda x, y: 0.03 * x, cell_size=10.0, sigma=1.0)
    plain = make_problem(roads)
    free, held = (
        solve_profiles(problem, ground, Diagnostics()).elevation for problem in (plain, replace(plain, pins=pins))
    )
    places = held.s[held.start[1] :].tolist()
    assert 100.0 in places
    assert 220.0 in places
    k = held.start[1] + places.index(100.0)
    assert (held.a[k], held.b[k]) == pytest.approx((3.5, 0.04), abs=1e-6)
    s, road = np.linspace(0.0, 300.0, 61), np.ones(61, np.int64)
    off = cubic_value(held, road, s) - cubic_value(free, road, s)
    assert off[20] == pytest.approx(0.5, abs=0.02)
    # What lies far away stays.
    assert np.abs(off[s > 220.0]).max() < 0.05
    assert cubic_value(held, 0 * road, s) == pytest.approx(cubic_value(free, 0 * road, s), abs=1e-3)


def test_two_samples_make_a_pair() -> None:
    """Two roads of one sample each; a road by itself has nothing to be level with."""
    roads = [straight((0.0, 0.0), (8.0, 0.0), oneway=1, name=0), straight((8.0, 9.0), (0.0, 9.0), oneway=1, name=0)]
    assert len(observe_dual_carriageways(network_of(roads, []), reading(2, cell=30.0)).value) == 1
    assert len(observe_dual_carriageways(network_of(roads[:1], []), reading(1, cell=30.0)).value) == 0


@pytest.mark.parametrize(
    ("more", "pairs"),
    [
        ({}, 10),
        # Another name, none, both ways, the same way, that is: against the direction in which it is drawn.
        ({"name": 1}, 0),
        ({"name": -1}, 0),
        ({"oneway": 0}, 0),
        ({"oneway": -1}, 0),
        ({"turned": 180.0}, 0),
        ({"turned": 180.0, "oneway": -1}, 10),
        # Within 25 degrees they are opposite.
        ({"turned": 23.0, "apart": 0.0}, 10),
        ({"turned": 29.0, "apart": 0.0}, 0),
        # On another layer, and on a bridge.
        ({"layer": 1}, 0),
        ({"structure": 1}, 0),
        # Only what lies side by side.
        ({"ahead": 50.0}, 6),
        ({"ahead": 115.0}, 0),
        ({"apart": -12.0}, 10),
    ],
)
def test_carriageways_of_one_street_run_opposite_ways_side_by_side(more: dict[str, float], pairs: int) -> None:
    """An eastbound road of 100 m, and one beside it that has these attributes."""
    given = {"oneway": 1, "name": 0, "apart": 12.0, "ahead": 0.0, "turned": 0.0, "layer": 0, "structure": 0} | more
    c, s = 50.0 * np.cos(np.deg2rad(given["turned"])), 50.0 * np.sin(np.deg2rad(given["turned"]))
    x, y = 50.0 + given["ahead"], given["apart"]
    other = straight(
        (x + c, y + s),
        (x - c, y - s),
        oneway=int(given["oneway"]),
        name=int(given["name"]),
        spans=((0.0, int(given["structure"]), int(given["layer"])),),
    )
    network = network_of([straight((0.0, 0.0), (100.0, 0.0), oneway=1, name=0), other], [])
    found = len(observe_dual_carriageways(network, reading(20, cell=30.0)).value)
    assert found == pairs


def test_level_pairs_are_beside_each_other() -> None:
    roads = [
        straight((0.0, 0.0), (100.0, 0.0), oneway=1, name=0),
        straight((100.0, 12.0), (0.0, 12.0), oneway=1, name=0),
    ]
    network = network_of(roads, [])
    block = observe_dual_carriageways(network, reading(20, cell=30.0))
    assert (block.kind.tolist(), block.sigma.tolist()) == ([Kind.DIFFERENCE] * 10, [0.5] * 10)
    # Heights of x along the first road and of 3 x along the second, which is drawn the other way.
    place = network.elements.knot_s
    first = np.arange(len(place)) < network.elements.knot_start[1]
    z, grade = np.where(first, place, 3.0 * (100.0 - place)), np.where(first, 1.0, -3.0)
    assert block.rows @ unknowns_of(network, z, grade) == pytest.approx(-2.0 * (5.0 + 10.0 * np.arange(10)))


def unknowns_of(network: Network, z: FloatArray, grade: FloatArray) -> FloatArray:
    """Return the unknowns that give these heights and grades at the knots."""
    knots = np.column_stack([z, grade]).ravel()
    return np.asarray(np.linalg.lstsq(network.unknowns.to_knots.toarray(), knots, rcond=None)[0])


@pytest.mark.parametrize("missing", ["ele_road", "ele_s", "ele_z"])
def test_heights_without_a_place_are_none(missing: str) -> None:
    network = network_of([straight((0.0, 0.0), (100.0, 0.0))], [])
    problem = replace(
        network.problem,
        ele_road=None if missing == "ele_road" else np.array([0]),
        ele_s=None if missing == "ele_s" else np.array([30.0]),
        ele_z=None if missing == "ele_z" else np.array([440.0]),
    )
    assert len(observe_ele(replace(network, problem=problem), mean=0.0).value) == 0


def test_rows_are_the_heights_and_grades_at_their_places() -> None:
    """On roads of z = 3 + 0.02 s + 1e-3 s², with knots at 0, 20, 40 … m."""
    network = network_of([straight((0.0, 0.0), (100.0, 0.0), grade=0.1), straight((0.0, 50.0), (100.0, 50.0))], [])

    def height(s: FloatArray) -> FloatArray:
        return np.asarray(3.0 + 0.02 * s + 1e-3 * s**2)

    s = network.elements.knot_s
    x = unknowns_of(network, height(s), 0.02 + 2e-3 * s)
    ground = observe_ground(network, reading(20, z=7.0), np.arange(20.0), mean=2.0)
    assert ground.rows @ x == pytest.approx(height(network.samples.s))
    assert (ground.value.tolist(), ground.weight.tolist()) == ([5.0] * 20, list(range(20)))
    assert ground.sigma.tolist() == [2.0] * 20
    incline = observe_inclines(network)
    middle = np.arange(10.0, 100.0, 20.0)
    assert incline.rows @ x == pytest.approx(0.02 + 2e-3 * middle)
    place = np.array([0.0, 33.0, 100.0])
    problem = replace(
        network.problem,
        ele_road=np.array([1, 0, 1]),
        ele_s=place,
        ele_z=np.ones(3),
        pins=Pins(np.array([0, 1, 1]), place, np.ones(3), np.zeros(3)),
    )
    network = replace(network, problem=problem)
    assert observe_ele(network, 0.0).rows @ x == pytest.approx(height(place))
    pins = observe_pins(network, 0.0)
    assert pins.rows @ x == pytest.approx(np.r_[height(place), 0.02 + 2e-3 * place])
    assert pins.sigma.tolist() == [1e-4] * 6


def test_what_is_measured_holds_the_roads_that_it_is_connected_to() -> None:
    """Two roads at one junction, of which one is measured; a road by itself that is not, and a tunnel."""
    roads = [
        straight((0.0, 0.0), (100.0, 0.0), end=0),
        straight((110.0, 0.0), (210.0, 0.0), start=0),
        straight((0.0, 500.0), (100.0, 500.0)),
        straight((0.0, 900.0), (100.0, 900.0), spans=[(0.0, 2, -1)]),
    ]
    network = network_of(roads, [(105.0, 0.0)])
    road = network.elements.road[network.samples.element]
    found = replace(reading(40), measured=(road == 0) | (road == 3))
    weight, floating = weigh_heights(network, found)
    assert floating.tolist() == [False, False, True, True]
    guess = 10.0 / (200.0 * 30.0**2)
    assert weight == pytest.approx(np.where(road < 2, 10.0 / (25.0 * 2.0**2), guess))


def test_distance_to_portals_along_a_road_and_not_over_to_the_next() -> None:
    roads = [
        straight((0.0, 0.0), (120.0, 0.0), spans=[(0.0, 0, 0), (30.0, 1, 1), (50.0, 0, 0), (90.0, 2, -1)]),
        straight((0.0, 100.0), (60.0, 100.0)),
        straight((0.0, 200.0), (10.0, 200.0), spans=[(0.0, 1, 1)]),
        straight((0.0, 300.0), (60.0, 300.0), spans=[(0.0, 1, 1), (20.0, 0, 0)]),
        straight((0.0, 400.0), (60.0, 400.0), spans=[(0.0, 0, 0), (40.0, 1, 1)]),
    ]
    problem = make_problem(roads)
    elements = build_elements(problem, 20.0)
    behind, ahead = portal_distance(elements, number_unknowns(problem, elements).end_node)
    ground = elements.structure == 0
    inf = np.inf
    assert elements.s[ground].tolist() == [0.0, 15.0, 50.0, 70.0, 0.0, 20.0, 40.0, 20.0, 40.0, 0.0, 20.0]
    assert behind[ground].tolist() == [inf, inf, 0.0, 20.0, inf, inf, inf, 0.0, 20.0, inf, inf]
    assert ahead[ground].tolist() == [15.0, 0.0, 20.0, 0.0, inf, inf, inf, inf, inf, 20.0, 0.0]
