"""Islands in junctions: which gaps between lanes get kerbs, and where these run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from floor_cases import connecting
from scipy import ndimage

from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junction_floor import Hole, is_island, lay_floor
from osm2xodr.geometry.junction_floor.islands import largest_part
from osm2xodr.model import FloatArray, LaneType, Rule

# Lanes of 3 m around a gap, 6 m from west to east (0 to 6) and 4 m from south to north (0 to 4).
AROUND = ((-3.0, -1.5, 9.0, -1.5), (7.5, -3.0, 7.5, 7.0), (9.0, 5.5, -3.0, 5.5), (-1.5, 7.0, -1.5, -3.0))


def ring(half: float) -> tuple[FloatArray, FloatArray]:
    """Return the four lines of a square around the middle of the gap, from begin to end."""
    corners = np.array([(3 - half, 2 - half), (3 + half, 2 - half), (3 + half, 2 + half), (3 - half, 2 + half)])
    return corners, np.roll(corners, -1, axis=0)


def islands(roads: ConnectingRoads) -> tuple[Hole, ...]:
    """Return all places that may be islands: streets go round any of them."""
    return lay_floor(roads, Rule.RIGHT_HAND, is_island=lambda hole: True).islands


def hole() -> Hole:
    (found,) = islands(connecting(AROUND))
    return found


def test_kerbs_run_within_the_gap_counter_clockwise() -> None:
    found = hole()
    assert found.area == pytest.approx(24.0, rel=0.08)
    assert found.corners.min(axis=0) == pytest.approx([0.2, 0.2], abs=0.25)
    assert found.corners.max(axis=0) == pytest.approx([5.8, 3.8], abs=0.25)
    assert (found.corners > 0.0).all()
    assert (found.corners < (6.0, 4.0)).all()
    x, y = found.corners.T
    assert 15.0 < 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) < 24.0
    assert len(found.corners) <= 16


def test_the_floor_below_is_the_same() -> None:
    floor = lay_floor(connecting(AROUND), Rule.RIGHT_HAND)
    assert len(floor.left) + len(floor.right) >= 1


def test_beside_a_sidewalk_there_is_none() -> None:
    roads = connecting(AROUND)
    beside = replace(roads, lane_type=(LaneType.SIDEWALK, *roads.lane_type[1:]))
    assert islands(beside) == ()


def test_small_and_narrow_gaps_are_none() -> None:
    small = ((-3.0, -1.5, 5.0, -1.5), (3.9, -3.0, 3.9, 5.0), (5.0, 3.9, -3.0, 3.9), (-1.5, 5.0, -1.5, -3.0))
    narrow = ((-3.0, -1.5, 15.0, -1.5), (13.5, -3.0, 13.5, 5.0), (15.0, 2.3, -3.0, 2.3), (-1.5, 5.0, -1.5, -3.0))
    for lines in (small, narrow):
        assert islands(connecting(lines)) == ()


def test_streets_must_go_round_it() -> None:
    begin, end = ring(4.5)
    assert is_island(hole(), begin, end)
    assert not is_island(hole(), begin[:3], end[:3])
    assert not is_island(hole(), begin[:0], end[:0])


def test_a_gap_that_fills_little_of_what_streets_enclose_is_none() -> None:
    assert not is_island(hole(), *ring(8.0))


@pytest.mark.parametrize("seed", range(20))
def test_the_largest_part_is_the_first_of_that_size(seed: int) -> None:
    cells = np.random.default_rng(seed).random((17, 23)) < 0.2 + 0.03 * seed
    label, _ = ndimage.label(cells)
    expected = label == np.bincount(label.ravel())[1:].argmax() + 1
    assert largest_part(cells).tolist() == expected.tolist()
