"""Ways that run over arms, and long turns back, are drawn again."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from osm2xodr.curves import curves_of, lengths, smallest_radius
from osm2xodr.geometry.connections import ConnectingRoads, draw_tighter, tighter_ways
from osm2xodr.geometry.junctions import JunctionLayout, RoadParts
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import Access, LaneType, PlanView


def connecting(plan: PlanView) -> ConnectingRoads:
    zero = np.zeros(1)
    columns: dict[str, Any] = dict.fromkeys(
        ("entry_t", "exit_t", "entry_aside", "exit_aside", "height"), zero
    ) | dict.fromkeys(("entry_width", "exit_width"), zero + 3.0)
    return ConnectingRoads(
        plan_view=plan,
        length=lengths(plan),
        junction=np.array([0]),
        entry=np.array([1]),
        exit=np.array([2]),
        entry_lane=np.array([-1]),
        exit_lane=np.array([-1]),
        against=np.array([False]),
        joins_cars=np.array([False]),
        lane_type=(LaneType.DRIVING,),
        access=(Access.ALL,),
        inner=((),),
        **columns,
    )


@pytest.mark.parametrize(("ahead", "drawn_again"), [(10.0, False), (20.0, True)])
def test_a_turn_back_that_is_too_long_begins_at_once(
    ahead: float, drawn_again: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Lanes 10 m apart, and half a circle of 5 m between them so far ahead: 35.7 m, or 55.7 m."""
    none = np.zeros(0, np.int64)
    monkeypatch.setattr(tighter_ways, "ways_over_arms", lambda *_: (none, none, np.zeros(0)))
    piece, bend = np.array([[ahead, 5 * math.pi, ahead]]), np.array([[0.0, 0.2, 0.0]])
    before = connecting(curves_of(np.zeros(1), np.zeros(1), np.zeros(1), piece, bend))
    nothing = cast("StreetEnds", None), cast("JunctionLayout", None), cast("RoadParts", None)
    after = draw_tighter(*nothing, before)
    assert (after is not before) == drawn_again
    if drawn_again:
        # Two quarters of the smallest circle, and 2 m between them
        assert smallest_radius(after.plan_view)[0] == pytest.approx(4.0, abs=0.01)
        assert after.length[0] == pytest.approx(4 * math.pi + 2.0, abs=0.01)


@pytest.mark.parametrize("diagonal", [False, True])
def test_a_way_over_an_arm_is_not_drawn_tighter_where_it_would_leave_the_carriageways(
    diagonal: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A way turns right and left over three streets with square corners; a shorter one would run across them.

    With a street there, it may.
    """
    overrun = [(np.zeros(1, np.int64), np.zeros(1, np.int64), np.ones(1))]
    none = np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0)
    monkeypatch.setattr(tighter_ways, "ways_over_arms", lambda *_: overrun.pop() if overrun else none)
    x, y, hdg = np.array([[0.0, 0.0, 0.0], [20.0, 0.0, -math.pi / 2], [20.0, -30.0, 0.0], [0.0, 0.0, 0.0]]).T
    hdg[3], along = math.atan2(-30.0, 40.0), np.array([[20.0], [30.0], [20.0], [50.0]])
    lines = curves_of(x, y, hdg, along, np.zeros((4, 1)))
    # The nodes of the last one belong to the junction, or do not.
    node = np.array([0, 1, 1, 2, 2, 3, *([0, 3] if diagonal else [4, 5])])
    ends = SimpleNamespace(node=node, left=np.full(8, 3.0), right=np.full(8, -3.0), lines=lines)
    layout = SimpleNamespace(nodes=((0, 1, 2, 3),))
    parts = SimpleNamespace(street_end=lambda: np.arange(8))
    quarter = 3 * math.pi
    piece, bend = np.array([[14.0, quarter, 18.0, quarter, 14.0]]), np.array([[0.0, -1 / 6, 0.0, 1 / 6, 0.0]])
    before = connecting(curves_of(np.zeros(1), np.zeros(1), np.zeros(1), piece, bend))
    made = cast("StreetEnds", ends), cast("JunctionLayout", layout), cast("RoadParts", parts)
    after = draw_tighter(*made, before)
    if diagonal:
        assert after.length[0] < before.length[0] - 10.0
    else:
        assert after.length == pytest.approx(before.length, abs=1e-12)
