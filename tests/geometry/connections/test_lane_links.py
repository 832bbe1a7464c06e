"""Lane links as drivers see them: turns back to the side of their exit, links kept where no arm has moved."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from street_cases import Case

from osm2xodr.geometry.connections.lane_links import _turns, find_lane_links
from osm2xodr.geometry.junctions.road_parts import cut_roads
from osm2xodr.geometry.plan_view.streets import fit_streets
from osm2xodr.model import Rule


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(("degrees", "turns_back"), [(160.0, False), (170.0, True), (-160.0, False), (-170.0, True)])
def test_a_turn_back_has_the_side_of_its_exit(degrees: float, turns_back: bool, side: float) -> None:
    """Driving to the east, with the exit 8 m to the left or to the right."""
    turn = math.radians(degrees)
    found = _turns(np.zeros(1), np.array([turn]), np.zeros(1), np.array([-8.0 * side]))
    assert found[0] == pytest.approx(math.copysign(turn, side) if turns_back else turn)


def test_links_stay_where_no_arm_has_moved() -> None:
    nodes = {"w": (-80.0, 0.0), "a": (0.0, 0.0), "b": (60.0, 0.0), "e": (140.0, 0.0), "s": (0.0, -80.0)}
    nodes["n"] = (60.0, 80.0)
    ways = {1: ("w a", ""), 2: ("a b", ""), 3: ("b e", ""), 4: ("s a", ""), 5: ("b n", "")}
    stages = Case(nodes, ways).stages()
    fitted = fit_streets(stages.network, stages.diagnostics)
    before = cut_roads(stages.network, fitted, stages.layout)
    links = find_lane_links(before, stages.movements, Rule.RIGHT_HAND)
    assert len(links.rows) == 12
    trim = stages.layout.trim.copy()
    trim[stages.end(4, 1)] += 2.0
    moved = cut_roads(stages.network, fitted, replace(stages.layout, trim=trim), before)
    again = find_lane_links(moved, stages.movements, Rule.RIGHT_HAND, links)
    kept = {row.junction for row in again.rows if any(row is other for other in links.rows)}
    assert kept == {stages.layout.junction[stages.end(5, 2)]}
    assert [(row.junction, row.entry, row.exit) for row in again.rows] == [
        (row.junction, row.entry, row.exit) for row in links.rows
    ]
