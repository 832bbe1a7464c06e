"""Streets of continuous curvature, through intersections and between corners."""

from __future__ import annotations

import numpy as np
import pytest
from road_measures import Pose, curve_length, pose_at
from street_cases import Case

from osm2xodr.curves import curvature_at, curves_of, end_curvature, project, smallest_radius
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.plan_view import defaults, smooth_streets
from osm2xodr.geometry.plan_view.street_smoothing import Parts, smooth_parts
from osm2xodr.geometry.plan_view.streets import FittedStreets, fit_streets
from osm2xodr.model import PlanView, StreetNetwork

# Two streets that go on in each other with a bend of 9 degrees, which a third joins.
_THROUGH = Case(
    {"a": (-150.0, 0.0), "m": (0.0, 0.0), "b": (150.0, 24.0), "c": (0.0, -100.0)},
    {1: ("a m", ""), 2: ("b m", ""), 3: ("c m", "")},
)


def _fitted(case: Case) -> tuple[StreetNetwork, FittedStreets]:
    network = case.stages().network
    return network, fit_streets(network, Diagnostics())


def _end_at_intersection(network: StreetNetwork, plan: PlanView, way: int) -> tuple[Pose, float]:
    """Return the pose of a way's street where it meets the others, away from there, and its curvature to the left."""
    street = next(item for item in network.streets if item.pieces[0][1].osm_way_id == way)
    at_start = sum(street.start in (item.start, item.end) for item in network.streets) > 1
    s = 0.0 if at_start else curve_length(plan, street.id)
    found = pose_at(plan, street.id, s)
    bend = float(curvature_at(plan, np.array([street.id]), np.array([s]))[0])
    return found, bend if at_start else -bend


def test_a_street_goes_on_through_an_intersection_with_one_curvature() -> None:
    network, fitted = _fitted(_THROUGH)
    smooth = smooth_streets(network, fitted)
    before = [_end_at_intersection(network, fitted.plan_view, way) for way in (1, 2)]
    after = [_end_at_intersection(network, smooth.plan_view, way) for way in (1, 2)]
    kinks = [np.sin(one[0].hdg - other[0].hdg) for one, other in (before, after)]
    assert abs(kinks[0]) == pytest.approx(np.sin(np.arctan(24 / 150)), abs=1e-4)
    assert abs(kinks[1]) < 1e-7
    assert after[0][0].gap(after[1][0]) < 1e-7
    assert abs(after[0][1]) > 1e-3
    assert abs(after[0][1] + after[1][1]) < 1e-7
    # The street that joins them stays.
    row = next(street.id for street in network.streets if street.pieces[0][1].osm_way_id == 3)
    assert (
        smooth.plan_view.length[smooth.plan_view.start[row]] == fitted.plan_view.length[fitted.plan_view.start[row]]
    )


def test_unchained_streets_do_not_depend_on_what_lies_beyond_their_ends() -> None:
    network, fitted = _fitted(_THROUGH)
    assert smooth_streets(network, fitted, chained=False) is fitted


def test_places_move_along() -> None:
    """Where lanes change stays where it is, within the shift, whichever way the chain runs."""
    nodes = {f"n{k}": (20.0 * k, 0.02 * (20.0 * k) ** 2 / 2) for k in range(8)}
    for ways in (
        {1: ("n0 n1 n2 n3 n4", "lanes=2"), 2: ("n4 n5 n6 n7", "lanes=3")},
        {1: ("n7 n6 n5 n4", "lanes=2"), 2: ("n4 n3 n2 n1 n0", "lanes=3")},
    ):
        network, fitted = _fitted(Case(nodes, ways))
        smooth = smooth_streets(network, fitted)
        before = pose_at(fitted.plan_view, 0, fitted.pieces[0][1][0])
        after = pose_at(smooth.plan_view, 0, smooth.pieces[0][1][0])
        assert 0.0 < before.gap(after) < 1.5 * defaults.SMOOTH_SHIFT


def test_straight_streets_stay() -> None:
    network, fitted = _fitted(Case({"a": (0.0, 0.0), "b": (100.0, 0.0)}, {1: ("a b", "")}))
    assert smooth_streets(network, fitted) is fitted


def test_a_corner_that_cannot_become_smooth_stays_alone() -> None:
    """What no car drives is left as it is; the bends on both sides of it become smooth."""
    zero = np.zeros(1)
    bend = np.array([[60.0, 40.0, 60.0]]), np.array([[0.0, 0.02, 0.0]])
    one = curves_of(zero, zero, zero, *bend)
    # A hairpin of half a metre's radius: nothing can be smooth there without becoming sharper.
    curl = np.array([[60.0, 40.0, 60.0, 0.5 * np.pi, 60.0, 40.0, 60.0]]), np.array([[0, 0.02, 0, 2.0, 0, -0.02, 0]])
    plan = curves_of(zero, zero, zero, *curl)
    parts = Parts.whole(plan, np.zeros((1, 2), bool))
    found, places = smooth_parts(plan, parts, (np.zeros(0, np.int64), np.zeros(0)))
    assert smallest_radius(found)[0] > 0.44
    steps = np.abs(found.curvature[1:] - end_curvature(found)[:-1])
    at = found.s[1:][steps > 1e-6]
    assert (np.abs(at - 161.0) < 30.0).all()
    assert (found.rate != 0.0)[[0, -1]].all()
    before, after = places[0]
    assert before[0] == after[0] == 0.0
    assert after[-1] == pytest.approx(curve_length(found, 0))
    assert (np.diff(after) >= 0).all()
    x, y, _ = (np.array([value]) for value in (one.x[2], one.y[2], 0.0))
    assert project(found, np.array([0]), x, y)[2][0] < defaults.SMOOTH_SHIFT_MOST
