"""Lanes as ribbons between common borders."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from xodr_text import cubics, document, lane, read_text, road, section

from osm2xodr.opendrive.space.ribbons import lane_ribbons
from osm2xodr.opendrive.space.sampling import sample_roads
from osm2xodr.opendrive.tables import ABSENT

LANES = (
    cubics("laneOffset", (0, 1.0), (50, 2.0))
    + section(0.0, lane(2, (0, 2.0)) + lane(1, (0, 3.0, 0.1)), lane(-1, (0, 4.0), (10, 5.0)))
    + section(50.0, lane(1, (0, 6.0), border=True), lane(-1, (0, -1.0), border=True) + lane(-2, (0, 2.0)))
)


def test_neighbours_share_their_border(tmp_path: Path) -> None:
    file = read_text(tmp_path, document(road(lanes=LANES)))
    ribbons = lane_ribbons(file, sample_roads(file))
    assert ribbons.left.tolist() == [0, 1, ABSENT, 2, 4, ABSENT, 5, 6]
    assert ribbons.right.tolist() == [1, 2, ABSENT, 3, 5, ABSENT, 6, 7]
    first, last = ribbons.start[1], ribbons.start[2] - 1
    # The first section ends before the step of its lane offset.
    assert ribbons.t[first] == pytest.approx(4.0)
    assert ribbons.t[last] == pytest.approx(9.0)
    np.testing.assert_allclose(ribbons.y, ribbons.t)
