"""Arms are cut back where ways through their junction run over them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from road_measures import RoadMeasures, assert_sound
from street_cases import Case

from osm2xodr.curves import pose, project
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
