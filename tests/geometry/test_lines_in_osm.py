"""How ways lie to each other in OSM."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from osm_builder import ROAD, Area

from osm2xodr.geometry.clearance_report import WayLines

NODES = {1: (-300.0, 0.0), 2: (0.0, 0.0), 3: (300.0, 0.0), 4: (60.0, -2.0), 5: (120.0, -40.0), 6: (10.0, -50.0)}
NODES |= {7: (10.0, 50.0), 8: (0.0, 80.0), 9: (300.0, 80.0), 10: (0.0, -20.0), 11: (0.0, 0.0)}


@pytest.mark.parametrize(
    ("refs", "crosses", "node", "away", "apart"),
    [
        pytest.param([2, 4, 5], False, 2, 50.0, 0.0, id="parts"),
        pytest.param([6, 7], True, None, np.inf, 0.0, id="crosses"),
        pytest.param([10, 11, 8], True, None, np.inf, 0.0, id="nodes at one place"),
        pytest.param([8, 9], False, None, np.inf, 80.0, id="beside"),
        pytest.param([6, 7, 9, 3], True, None, np.inf, 0.0, id="meets elsewhere"),
    ],
)
def test_lines_around_a_place(
    tmp_path: Path, refs: list[int], crosses: bool, node: int | None, away: float, apart: float
) -> None:
    network, _ = Area(NODES, {10: ([1, 2, 3], ROAD), 20: (refs, ROAD)}).parse(tmp_path)
    # Positions are about the middle of the area.
    (first,) = [street.points[street.node_ids == 1][0] for street in network.streets if 1 in street.node_ids]
    place = np.array([first[0] + 350.0, first[1]])
    found = WayLines(network, {10, 20}).between({10}, {20}, place)
    assert found.crossing == ((10, 20) if crosses else None)
    assert found.node == node
    assert (found.away, found.apart) == pytest.approx((away, apart), abs=0.05)
