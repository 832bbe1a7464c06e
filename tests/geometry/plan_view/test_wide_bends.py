"""Bends of streets give the inner edge of the carriageway a radius of its own, and stay near OSM's line."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from road_measures import assert_smooth, curve_length, pose_at
from street_cases import Case

from osm2xodr.curves.plan_views import smallest_radius
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.defaults import INNER_EDGE_RADIUS
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.geometry.plan_view.streets import FittedStreets, fit_streets
from osm2xodr.model import FloatArray, Rule

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
RESIDENTIAL_HALF = 2.75

Nodes = dict[str, tuple[float, float]]


def street(nodes: Nodes, tags: str, rule: Rule) -> tuple[FittedStreets, FloatArray, Diagnostics]:
    """Fit one street through nodes in their order; also return where they lie."""
    case = Case(nodes, {1: (" ".join(nodes), tags)})
    case = case if rule is Rule.RIGHT_HAND else case.mirrored()
    diagnostics = Diagnostics()
    network = case.stages(rule).network
    return fit_streets(network, diagnostics), network.streets[0].points, diagnostics


def bent(*steps: tuple[float, float]) -> Nodes:
    """Return nodes after steps: a turn in degrees, then a length."""
    x = y = hdg = 0.0
    nodes = {"a": (x, y)}
    for k, (turn, length) in enumerate(steps):
        hdg += math.radians(turn)
        x, y = x + length * math.cos(hdg), y + length * math.sin(hdg)
        nodes[f"n{k}"] = (x, y)
    return nodes


def farthest(fitted: FittedStreets, line: FloatArray) -> float:
    """Return how far the nodes' line is from the curve at most, m."""
    plan = fitted.plan_view
    places = [pose_at(plan, 0, float(s)) for s in np.linspace(0.0, curve_length(plan, 0), 2000)]
    curve = np.array([(place.x, place.y) for place in places])
    share = np.linspace(0.0, 1.0, 50)[:, None]
    along = np.concatenate([a + share * (b - a) for a, b in pairwise(line)])
    return float(np.hypot(*(along[:, None] - curve[None]).transpose(2, 0, 1)).min(1).max())


# What is folded without: a hairpin of one node and of two, a corner beside another, a jog, corners row upon row.
FOLDED = {
    "hairpin": (bent((0, 40), (133, 40)), 6.5),
    "hairpin of two": (bent((0, 40), (59, 2.2), (103, 40)), 4.0),
    "corner": (bent((0, 17), (-8, 4.1), (-109, 4.6), (-4, 10)), 2.5),
    "jog": (bent((0, 20), (-81, 2.4), (77, 20)), 2.5),
    "many": (bent((0, 30), (-38, 2.1), (-53, 1.5), (-45, 1.9), (-5, 30)), 3.0),
}


@pytest.mark.parametrize("name", FOLDED)
def test_a_street_drawn_the_other_way_has_the_same_bends(name: str) -> None:
    nodes, _ = FOLDED[name]
    one, _, _ = street(nodes, "highway=residential", Rule.RIGHT_HAND)
    other, _, _ = street(dict(reversed(nodes.items())), "highway=residential", Rule.RIGHT_HAND)
    length = curve_length(one.plan_view, 0)
    assert curve_length(other.plan_view, 0) == pytest.approx(length, abs=1e-6)
    for share in np.linspace(0.0, 1.0, 41).tolist():
        there = pose_at(other.plan_view, 0, (1.0 - share) * length)
        assert pose_at(one.plan_view, 0, share * length).gap(there) < 1e-5


@EITHER
@pytest.mark.parametrize("name", FOLDED)
def test_the_inner_edge_keeps_its_radius(name: str, rule: Rule) -> None:
    nodes, most = FOLDED[name]
    fitted, line, diagnostics = street(nodes, "highway=residential", rule)
    (radius,) = smallest_radius(fitted.plan_view)
    assert radius == pytest.approx(RESIDENTIAL_HALF + INNER_EDGE_RADIUS, abs=1e-9)
    assert_smooth(fitted.plan_view, 0, close=1e-6, turn=1e-6)
    assert fitted.plan_view.length.min() > 0.02
    assert farthest(fitted, line) < most
    assert [item.code for item in diagnostics] == []


@EITHER
def test_a_slight_bend_beside_a_corner_does_not_become_one(rule: Rule) -> None:
    """It bends the other way by 10 degrees: turned with the corner's radius, the outer edge would be tight there."""
    fitted, line, _ = street(bent((0, 40), (-107, 8.0), (10, 40)), "highway=residential", rule)
    turn = fitted.plan_view.length * fitted.plan_view.curvature * (1 if rule is Rule.RIGHT_HAND else -1)
    radius = RESIDENTIAL_HALF + INNER_EDGE_RADIUS
    assert turn.sum() == pytest.approx(math.radians(-97.0), abs=0.02)
    tight = np.abs(fitted.plan_view.curvature) > 0.99 / radius
    assert turn[tight & (turn > 0.0)].sum() < math.radians(2.0)
    assert farthest(fitted, line) < 2.0


@EITHER
def test_the_ends_stay_where_they_are(rule: Rule) -> None:
    nodes = bent((0, 30), (100, 3.5), (10, 3.0))
    fitted, line, _ = street(nodes, "highway=residential", rule)
    plan = fitted.plan_view
    end = pose_at(plan, 0, curve_length(plan, 0))
    assert (end.x, end.y) == pytest.approx(tuple(line[-1]), abs=1e-6)
    assert (plan.x[0], plan.y[0]) == pytest.approx(tuple(line[0]), abs=1e-9)


def test_wide_bends_stay_as_they_are() -> None:
    """A quarter that is cut by 2 m has a radius of 4.8 m and more."""
    fitted, _, _ = street(bent((0, 40), (90, 40)), "highway=residential", Rule.RIGHT_HAND)
    assert smallest_radius(fitted.plan_view)[0] > RESIDENTIAL_HALF + INNER_EDGE_RADIUS + 1e-3
    assert len(fitted.plan_view.s) == 3


def test_a_wider_carriageway_gets_a_wider_bend() -> None:
    nodes = bent((0, 40), (-59, 3.0), (-50, 40))
    for tags, half in (("highway=residential lanes=1 oneway=yes width=3", 1.5), ("highway=residential", 2.75)):
        fitted, _, _ = street(nodes, tags, Rule.RIGHT_HAND)
        assert smallest_radius(fitted.plan_view)[0] >= half + INNER_EDGE_RADIUS - 1e-9


def test_what_lies_along_the_street_moves_with_it() -> None:
    """The second way begins at a node beyond the bend: there it stays."""
    nodes = bent((0, 40), (133, 40), (30, 30))
    case = Case(nodes, {1: ("a n0 n1", "highway=residential"), 2: ("n1 n2", "highway=residential maxspeed=30")})
    network = case.stages().network
    fitted = fit_streets(network, Diagnostics())
    place = pose_at(fitted.plan_view, 0, fitted.pieces[0][1][0])
    x, y = network.streets[0].points[2]
    assert math.hypot(place.x - x, place.y - y) < defaults.CORNER_CUT


def test_a_wide_carriageway_moves_off_its_corner() -> None:
    """Lanes of 12 m turn by 110 degrees at one node: an arc of r = 6.5 m passes it at r (1/cos 55° - 1) = 4.8 m."""
    nodes = bent((0, 60), (110, 60))
    fitted, line, diagnostics = street(nodes, "highway=residential lanes=4 width=12", Rule.RIGHT_HAND)
    assert smallest_radius(fitted.plan_view)[0] == pytest.approx(6.0 + INNER_EDGE_RADIUS, abs=1e-9)
    assert farthest(fitted, line) < 6.5 * (1 / math.cos(math.radians(55)) - 1)
    assert [item.code for item in diagnostics] == []


def test_a_bend_without_room_is_reported() -> None:
    """Thirteen metres of carriageway turn back within one of ten."""
    nodes = bent((0, 40), (90, 5), (90, 40))
    fitted, _, diagnostics = street(nodes, "highway=primary lanes=6", Rule.RIGHT_HAND)
    assert smallest_radius(fitted.plan_view)[0] < 9.0
    assert [(item.code, item.osm_id) for item in diagnostics] == [("tight-bend", "way/1")]
