"""Rings of roundabouts: one circle, or one smooth curve, with the streets that join them on it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from road_measures import Pose, RoadMeasures, assert_smooth, assert_sound, curve_length, pose_at, records
from street_cases import Case

from osm2xodr.curves import end_curvature
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.geometry.plan_view.streets import FittedStreets, fit_streets
from osm2xodr.model import Rule, StreetNetwork

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
RING_WAY = 50
# Spirals that are arcs within 1e-6 rad at either end are written as such.
_SPIRAL_AS_ARC = 2e-6
Nodes = list[tuple[float, float]]


def on_ellipse(long: float, short: float, count: int, noise: float = 0.0) -> Nodes:
    angle = np.arange(count) * 2 * np.pi / count
    xy = np.column_stack([long * np.cos(angle), short * np.sin(angle)])
    return [(x, y) for x, y in (xy + np.random.default_rng(7).normal(0.0, noise, xy.shape)).tolist()]


def roundabout(ring: Nodes, arms: tuple[int, ...], tags: str = "junction=roundabout", closed: bool = True) -> Case:
    """Make a ring of one way with two-way streets that run straight out from some of its nodes."""
    nodes = {f"r{k}": place for k, place in enumerate(ring)}
    ways = {RING_WAY: (" ".join([*nodes, *(["r0"] if closed else [])]), tags)}
    for k in arms:
        x, y = ring[k]
        nodes[f"a{k}"] = (x + 80 * x / math.hypot(x, y), y + 80 * y / math.hypot(x, y))
        ways[k + 1] = (f"a{k} r{k}", "")
    return Case(nodes, ways)


def fitted_case(case: Case, rule: Rule = Rule.RIGHT_HAND) -> tuple[StreetNetwork, FittedStreets, Diagnostics]:
    case = case if rule is Rule.RIGHT_HAND else case.mirrored()
    network = case.stages(rule).network
    diagnostics = Diagnostics()
    return network, fit_streets(network, diagnostics), diagnostics


def ring_streets(network: StreetNetwork) -> list[int]:
    return [street.id for street in network.streets if street.pieces[0][1].roundabout]


def curvatures(network: StreetNetwork, fitted: FittedStreets) -> list[float]:
    return [item[3] for street in ring_streets(network) for item in records(fitted.plan_view, street)]


def ends(fitted: FittedStreets, street: int) -> tuple[Pose, Pose]:
    length = curve_length(fitted.plan_view, street)
    return pose_at(fitted.plan_view, street, 0.0), pose_at(fitted.plan_view, street, length)


def assert_one_smooth_ring(network: StreetNetwork, fitted: FittedStreets) -> None:
    """Check that streets meet at intersections, and those of the ring in one heading."""
    heading: dict[int, list[Pose]] = {}
    place: dict[int, list[Pose]] = {}
    for street in network.streets:
        assert_smooth(fitted.plan_view, street.id, turn=_SPIRAL_AS_ARC)
        for node, pose in zip((street.start, street.end), ends(fitted, street.id), strict=True):
            place.setdefault(node, []).append(pose)
            if street.pieces[0][1].roundabout:
                heading.setdefault(node, []).append(pose)
    for node, poses in place.items():
        assert all(pose.gap(poses[0]) < 1e-6 for pose in poses), f"gap at intersection {node}"
    for one, other in heading.values():
        assert one.turn(other) < 1e-6


def distances_to_nodes(network: StreetNetwork, fitted: FittedStreets) -> list[float]:
    found = []
    for street in ring_streets(network):
        length = curve_length(fitted.plan_view, street)
        poses = [pose_at(fitted.plan_view, street, s) for s in np.linspace(0.0, length, max(3, int(length / 0.1)))]
        for x, y in network.streets[street].points.tolist():
            found.append(min(math.hypot(pose.x - x, pose.y - y) for pose in poses))
    return found


@EITHER
def test_a_noisy_circle_of_six_nodes_is_one_circle(rule: Rule) -> None:
    network, fitted, _ = fitted_case(roundabout(on_ellipse(12.0, 12.0, 6, 0.15), (0, 1, 3, 4)), rule)
    assert len(ring_streets(network)) == 4
    found = curvatures(network, fitted)
    assert len(found) == 4
    side = 1.0 if rule is Rule.RIGHT_HAND else -1.0
    assert [side / k for k in found] == pytest.approx([12.0] * 4, rel=0.02)
    assert found == pytest.approx([found[0]] * 4, rel=1e-12)
    assert sum(curve_length(fitted.plan_view, k) for k in ring_streets(network)) == pytest.approx(
        2 * math.pi / abs(found[0]), abs=1e-9
    )
    assert_one_smooth_ring(network, fitted)
    assert max(distances_to_nodes(network, fitted)) < 0.35


def test_a_ring_drawn_with_four_nodes_is_round() -> None:
    network, fitted, _ = fitted_case(roundabout(on_ellipse(10.0, 10.0, 4), (0, 1, 2, 3)))
    assert [1 / k for k in curvatures(network, fitted)] == pytest.approx([10.0] * 4, abs=0.02)
    assert_one_smooth_ring(network, fitted)


def test_a_ring_without_intersections_is_round() -> None:
    network, fitted, _ = fitted_case(roundabout(on_ellipse(9.0, 9.0, 8), ()))
    (street,) = ring_streets(network)
    ((_, start, length, curvature),) = records(fitted.plan_view, street)
    assert 1 / curvature == pytest.approx(9.0, abs=0.02)
    assert length == pytest.approx(2 * math.pi / curvature, abs=1e-9)
    assert start.gap(ends(fitted, street)[1]) < 1e-9


@EITHER
@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_an_oval_bends_to_one_side_only(rule: Rule, noise: float) -> None:
    network, fitted, _ = fitted_case(roundabout(on_ellipse(24.0, 14.0, 18, noise), (0, 5, 9, 14)), rule)
    found = np.array(curvatures(network, fitted)) * (1.0 if rule is Rule.RIGHT_HAND else -1.0)
    assert found.min() >= 0.0
    # The ellipse's own radii run from 8.2 to 41.1 m.
    assert 1 / found.max() == pytest.approx(8.2, rel=0.3)
    assert_one_smooth_ring(network, fitted)
    assert max(distances_to_nodes(network, fitted)) < defaults.RING_TOLERANCE + 0.02


@EITHER
def test_curvature_is_continuous_all_along_an_oval(rule: Rule) -> None:
    """Between its records, and from the last street to the first; an ellipse's runs from b/a² to a/b²."""
    network, fitted, _ = fitted_case(roundabout(on_ellipse(24.0, 14.0, 24), (0, 5, 11, 17)), rule)
    plan, streets = fitted.plan_view, np.array(ring_streets(network))
    begin, end = plan.curvature, end_curvature(plan)
    first, last = plan.start[streets], plan.start[streets + 1] - 1
    inner = np.concatenate([np.arange(a, b) for a, b in zip(first.tolist(), last.tolist(), strict=True)])
    assert np.abs(end[inner] - begin[inner + 1]).max() < 1e-6
    # Streets run with the traffic, one after the other.
    at_node = {network.streets[k].start: k for k in streets.tolist()}
    follows = plan.start[[at_node[network.streets[k].end] for k in streets.tolist()]]
    assert np.abs(end[last] - begin[follows]).max() < 1e-6
    side = 1.0 if rule is Rule.RIGHT_HAND else -1.0
    at = side * begin[np.append(inner, last)]
    assert at.min() == pytest.approx(14 / 24**2, rel=0.3)
    assert at.max() == pytest.approx(24 / 14**2, rel=0.2)


def test_plan_views_of_arcs_have_no_spirals_in_rings_either() -> None:
    network = roundabout(on_ellipse(24.0, 14.0, 18), (0, 5, 9, 14)).stages(Rule.RIGHT_HAND).network
    arcs, spirals = (fit_streets(network, Diagnostics(), spirals=k).plan_view for k in (False, True))
    assert not arcs.rate.any()
    assert spirals.rate.any()


def test_a_waist_stays_a_waist() -> None:
    """A ring like a peanut, r = 16 + 6.5 cos 2φ: 1.5 m hollow on both sides, where its own curvature is -0.18 1/m."""
    angle = np.arange(24) * 2 * np.pi / 24
    radius = 16 + 6.5 * np.cos(2 * angle)
    ring = [(x, y) for x, y in np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]).tolist()]
    network, fitted, _ = fitted_case(roundabout(ring, (0, 3, 12, 15)))
    found = curvatures(network, fitted)
    assert -0.25 < min(found) < -0.05
    assert max(found) < 0.2
    assert_one_smooth_ring(network, fitted)
    assert max(distances_to_nodes(network, fitted)) < defaults.RING_TOLERANCE + 0.02


def test_a_ring_with_a_sharp_corner_is_reported_as_uneven() -> None:
    """A drop: half a circle and a corner of 60 degrees, far from it, which no smooth curve passes."""
    arc = [(10 * math.cos(a), 10 * math.sin(a)) for a in np.deg2rad(np.arange(30.0, 331.0, 30.0))]
    drop = [*arc, (25.0, 0.0)]
    network, fitted, diagnostics = fitted_case(roundabout(drop, (2, 5, 8)))
    assert [(item.code, item.osm_id) for item in diagnostics] == [("ring-uneven", f"way/{RING_WAY}")]
    for street in network.streets:
        assert_smooth(fitted.plan_view, street.id)


def test_a_ring_that_the_area_cuts_off_is_part_of_a_circle() -> None:
    most = on_ellipse(14.0, 14.0, 12, 0.1)[:9]
    network, fitted, _ = fitted_case(roundabout(most, (3, 6), closed=False))
    found = curvatures(network, fitted)
    assert [1 / k for k in found] == pytest.approx([14.0] * len(found), rel=0.02)
    assert len(found) == 3


def test_a_bend_tagged_as_roundabout_is_not_a_ring() -> None:
    bend = on_ellipse(14.0, 14.0, 12)[:4]
    network, fitted, diagnostics = fitted_case(roundabout(bend, (), closed=False))
    assert len(ring_streets(network)) == 1
    assert len(curvatures(network, fitted)) > 1
    assert len(diagnostics) == 0


def test_streets_that_join_follow_the_ring_and_lie_as_before_farther_out() -> None:
    ring = on_ellipse(12.0, 12.0, 8)
    ring[2] = (0.0, 12.5)
    network, fitted, _ = fitted_case(roundabout(ring, (2, 6)))
    (arm,) = [s for s in network.streets if s.pieces[0][1].osm_way_id == 3]
    last = ends(fitted, arm.id)[1]
    assert 12.0 < last.y < 12.4
    assert last.x == pytest.approx(0.0, abs=0.05)
    far = pose_at(fitted.plan_view, arm.id, 60.0)
    assert far.x == pytest.approx(0.0, abs=0.05)
    assert_one_smooth_ring(network, fitted)


def test_left_hand_rings_are_mirror_images() -> None:
    case = roundabout(on_ellipse(24.0, 14.0, 18, 0.1), (0, 5, 9, 14))
    one, right, _ = fitted_case(case)
    _, left, _ = fitted_case(case, Rule.LEFT_HAND)
    for street in ring_streets(one):
        for s in np.linspace(0.0, 10.0, 5):
            a, b = pose_at(right.plan_view, street, float(s)), pose_at(left.plan_view, street, float(s))
            # OSM's coordinates are rounded to 1 cm, differently on either side of the equator.
            assert (a.x, a.y) == pytest.approx((b.x, -b.y), abs=0.03)


@EITHER
@pytest.mark.parametrize("ring", [on_ellipse(12.0, 12.0, 6, 0.15), on_ellipse(24.0, 14.0, 18, 0.1)])
def test_roads_and_junctions_of_a_ring_are_sound(rule: Rule, ring: Nodes) -> None:
    case = roundabout(ring, (0, 1, 3, 4) if len(ring) == 6 else (0, 5, 9, 14))
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    assert_sound(roads)
    measures = RoadMeasures(roads)
    assert len([road for road in roads.roads if road.osm_way_ids == (RING_WAY,)]) == 4
    assert sum(len(junction.priorities) for junction in roads.junctions) >= 4
    assert min(measures.length(road) for road in roads.roads) > 0.5
