"""Curves and cross-sections of whole streets."""

from __future__ import annotations

import pytest
from road_measures import assert_smooth, curve_length, pose_at
from street_cases import Case

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.plan_view.streets import fit_streets, outer_lanes
from osm2xodr.model import Rule


def test_a_closed_street_is_opened_on_its_longest_side() -> None:
    """Its curve starts and ends in the middle of that side, in one heading."""
    corners = {"a": (0.0, 0.0), "b": (40.0, 0.0), "c": (40.0, 90.0), "d": (0.0, 80.0)}
    network = Case(corners, {1: ("a b c d a", "")}).stages().network
    fitted = fit_streets(network, Diagnostics())
    start, end = pose_at(fitted.plan_view, 0, 0.0), pose_at(fitted.plan_view, 0, curve_length(fitted.plan_view, 0))
    assert_smooth(fitted.plan_view, 0)
    assert start.gap(end) < 1e-6
    assert start.turn(end) < 1e-6
    _, b, c, *_ = network.streets[0].points
    assert (start.x, start.y) == pytest.approx(tuple((b + c) / 2))
    assert fitted.pieces[0][0][0] == 0.0


def test_attributes_change_where_ways_meet() -> None:
    nodes = {"a": (0.0, 0.0), "b": (100.0, 0.0), "c": (160.0, 0.0)}
    network = Case(nodes, {1: ("a b", "lanes=2"), 2: ("b c", "lanes=3")}).stages().network
    (pieces,) = fit_streets(network, Diagnostics()).pieces
    assert [s for s, _, _ in pieces] == pytest.approx([0.0, 100.0], abs=0.02)
    assert [item.osm_way_id for _, item, _ in pieces] == [1, 2]


def test_outer_lanes_are_those_of_one_direction() -> None:
    network = Case({"a": (0.0, 0.0), "b": (100.0, 0.0)}, {1: ("a b", "lanes=2 width=7")}).stages().network
    fitted = fit_streets(network, Diagnostics())
    along, back = (outer_lanes(fitted, Rule.RIGHT_HAND, 0, way) for way in (True, False))
    assert along == pytest.approx((-1.75, -1.75))
    assert back == pytest.approx((-1.75, -1.75))
