"""Ways that run over arms, and long turns back, are drawn again."""

from __future__ import annotations

import math
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
