"""Lanes narrow towards junctions where the roads through them are too short for the change."""

from __future__ import annotations

import numpy as np
import pytest
from street_cases import Case

from osm2xodr.geometry.connections.narrowing import _reachable
from osm2xodr.model import Rule


def test_widths_shrink_until_tapers_lead_from_each_to_all_others() -> None:
    width = np.array([5.5, 2.5, 3.0, 4.0])
    one, other = np.array([0, 2, 3]), np.array([1, 0, 2])
    most = np.array([1.0, 0.25, 5.0])
    assert _reachable(width, one, other, most).tolist() == [3.25, 2.5, 3.0, 4.0]
    # A lane that has become narrow passes it on, along a chain.
    chain = _reachable(np.array([2.0, 5.0, 5.0]), np.array([0, 1]), np.array([1, 2]), np.array([1.0, 1.0]))
    assert chain.tolist() == [2.0, 3.0, 4.0]


@pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
def test_a_wide_lane_narrows_before_a_junction_to_narrow_ones(rule: Rule) -> None:
    """One lane of 5.5 m leads over a junction of a few metres to two of 2.5 m."""
    case = Case(
        {"a": (-80.0, 0.0), "b": (0.0, 0.0), "c": (80.0, 0.0), "d": (0.0, 60.0)},
        {
            1: ("a b", "highway=tertiary oneway=yes lanes=1 width=5.5"),
            2: ("b c", "highway=tertiary oneway=yes lanes=2 width=5"),
            3: ("b d", "highway=service oneway=yes"),
        },
    )
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    through = [road for road in roads.roads if road.junction is not None]
    for road in through:
        for lane in road.lane_sections[0].lanes:
            for cubic in lane.widths:
                # The slope of a smooth step is greatest in its middle: c^2 / (-3 d).
                assert cubic.d == 0.0 or cubic.c**2 / abs(3 * cubic.d) < 0.2
    wide = next(road for road in roads.roads if road.osm_way_ids == (1,))
    widths = [lane.widths for lane in wide.lane_sections[0].lanes if lane.id]
    assert widths[0][0].a == pytest.approx(5.5)
    # A metre before the junction the lane is as narrow as some 8 m to a lane of 2.5 m ask for, less a centimetre that
    # rounding may take: 2.5 + 8.2 / 7.75 - 0.01.
    (end,) = (road.lane_sections[-1] for road in roads.roads if road is wide)
    assert [round(item.widths[-1].a, 1) for item in end.lanes if item.id] == [3.5]
