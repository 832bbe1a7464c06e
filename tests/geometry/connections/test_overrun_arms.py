"""Arms are cut back where ways through their junction run over them."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from road_measures import RoadMeasures, assert_sound
from street_cases import Case

from osm2xodr.curves import pose, project
from osm2xodr.geometry.connections import ConnectingRoads, clear_arms, overrun_arms
from osm2xodr.geometry.junctions import JunctionLayout, RoadParts
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import RoadMap, Rule


def farthest_overrun(roads: RoadMap, way: int) -> float:
    """Return how far from its end at the junction other ways through it lie on the road of a way, m."""
    (road,) = (k for k, item in enumerate(roads.roads) if item.osm_way_ids == (way,) and item.junction is None)
    item = roads.roads[road]
    measures = RoadMeasures(roads)
    half = sum(lane.widths[0].a for lane in item.lane_sections[0].lanes if lane.id) / 2
    at_start = item.predecessor is not None
    far = 0.0
    for k, other in enumerate(roads.roads):
        joined = {link.id for link in (other.predecessor, other.successor) if link is not None}
        if other.junction is None or item.id in joined:
            continue
        along = np.linspace(0.0, measures.length(other), 60)
        x, y, _ = pose(roads.plan_view, np.full(60, k), along)
        s, t, distance = project(roads.plan_view, np.full(60, road), x, y)
        on = (np.abs(t) < half) & (distance < np.abs(t) + 1e-3)
        out = s if at_start else measures.length(item) - s
        far = max(far, float(out[on].max(initial=0.0)))
    return far


@pytest.mark.parametrize("rule", list(Rule))
def test_the_arm_ahead_of_a_swing_gives_way(rule: Rule) -> None:
    """A street turns back at an angle of 14 degrees; who turns into it swings out over the road ahead."""
    angle = math.radians(14.0)
    nodes = {
        "w": (-90.0, 0.0),
        "o": (0.0, 0.0),
        "e": (90.0, 0.0),
        "x": (-90 * math.cos(angle), -90 * math.sin(angle)),
    }
    case = Case(nodes, {1: ("w o", ""), 2: ("o e", ""), 3: ("o x", "highway=residential")})
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    assert_sound(roads)
    assert farthest_overrun(roads, 2) <= 2.0


@pytest.mark.parametrize(
    ("far", "other", "given"),
    [(4.0, 0.0, (4.5, 0.0)), (20.0, 0.0, (8.98, 0.0)), (9.5, 9.5, (4.49, 4.49)), (0.0, 0.0, (0.0, 0.0))],
)
def test_an_end_may_take_what_the_other_has_not(
    far: float, other: float, given: tuple[float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A street of 30 m gives 10 m and 8 m to its junctions; 3 m and 2 cm of the other 12 m stay."""
    found = np.array([far, other])
    arms = np.flatnonzero(found)
    monkeypatch.setattr(overrun_arms, "ways_over_arms", lambda *_: (arms, found[arms]))
    ends = cast("StreetEnds", SimpleNamespace(length=np.array([30.0, 30.0])))
    layout = cast("JunctionLayout", SimpleNamespace(trim=np.array([10.0, 8.0]), junction=np.array([0, 1])))
    trim = clear_arms(ends, layout, cast("RoadParts", None), cast("ConnectingRoads", None))
    assert trim - layout.trim == pytest.approx(given)


def test_pieces_are_near_an_arm_where_any_place_on_them_may_be() -> None:
    """An arm to the east takes places from 2 m behind its end to 40 m ahead, up to 12 m aside; pieces reach 2 m."""
    one, road = np.ones(1), np.zeros(1, np.int64)
    arm = overrun_arms._Arms(road, np.zeros(1, bool), 2 * one, -2 * one, 0 * one, 0 * one, one, 0 * one)
    x = np.array([-1.9, -3.9, -4.1, 39.9, 41.9, 42.1, 5.0, 5.0, 5.0])
    y = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -11.9, 13.9, 14.1])
    pair = np.zeros(len(x), np.int64)
    assert arm.near(pair, x, y, 2 * one).tolist() == [0, 3, 6]
    assert arm.near(pair, x, y, 2 * one, 2.0).tolist() == [0, 1, 3, 4, 6, 7]
