"""Turns that are sharper than a car drives swing out where there is room for it."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from road_measures import assert_sound, smallest_radius_of
from street_cases import Case

from osm2xodr.geometry import defaults
from osm2xodr.geometry.connections import ConnectingRoads, connect, runs_backwards
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.model import Rule

# Two carriageways, 4.6 m apart, and a street that crosses them, where one may turn back.
DUAL = Case(
    {
        "w1": (-80.0, 2.3), "w2": (-80.0, -2.3), "e1": (80.0, 2.3), "e2": (80.0, -2.3),
        "o1": (0.0, 2.3), "o2": (0.0, -2.3), "n": (0.0, 60.0), "s": (0.0, -60.0),
    },
    {
        1: ("o1 w1", "oneway=yes"), 2: ("w2 o2", "oneway=yes"),
        3: ("e1 o1", "oneway=yes"), 4: ("o2 e2", "oneway=yes"),
        5: ("s o2", ""), 6: ("o2 o1", ""), 7: ("o1 n", ""),
    },
)  # fmt: skip


@pytest.mark.parametrize("rule", list(Rule))
@pytest.mark.parametrize("apart", [2.2, 2.8, 3.4, 4.0])
def test_no_turn_back_folds_its_lane(apart: float, rule: Rule) -> None:
    """Even where there is no room to swing out, the inner edge keeps a radius."""
    nodes = {name: (x, math.copysign(apart / 2, y) if abs(y) < 10 else y) for name, (x, y) in DUAL.nodes.items()}
    case = replace(DUAL, nodes=nodes)
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    assert_sound(roads)
    widths = {road.id: lane.widths[0].a for road in roads.roads for lane in road.lane_sections[0].lanes if lane.id}
    inner = [
        smallest_radius_of(roads.plan_view, k) - widths[road.id] / 2
        for k, road in enumerate(roads.roads)
        if road.junction is not None
    ]
    assert min(inner) > 0.1 * defaults.INNER_EDGE_RADIUS - 1e-9


@pytest.mark.parametrize(("end", "ahead", "backwards"), [(1, 3.0, False), (1, -3.0, True), (0, -3.0, False)])
def test_roads_whose_exit_lies_straight_behind_run_backwards(end: int, ahead: float, backwards: bool) -> None:
    """From either end of a road of 50 m to a lane in the same heading, some way to the east, m."""
    one, x = np.ones(1), np.array([50.0 * end])
    hdg = np.array([0.0 if end else math.pi])
    road = connect(0 * one, 0 * one, 0 * one, 50 * one, 0 * one, 0 * one)
    plan = connect(x, 0 * one, hdg, x + ahead, 0 * one, hdg)
    connecting = SimpleNamespace(plan_view=plan, entry=np.array([end]))
    parts = SimpleNamespace(plan_view=road, length=np.array([50.0]))
    assert runs_backwards(cast("ConnectingRoads", connecting), cast("RoadParts", parts)).tolist() == [backwards]
