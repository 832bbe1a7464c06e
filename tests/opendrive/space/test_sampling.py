"""Stations along roads: dense enough, and at every record.

Lanes as ribbons between common borders.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from xodr_text import cubics, document, geometry, lane, read_text, road, section

from osm2xodr.model import FloatArray
from osm2xodr.opendrive.space.positions import pose, surface_points
from osm2xodr.opendrive.space.sampling import lane_ribbons, sample_roads
from osm2xodr.opendrive.tables import ABSENT, OpenDrive

LANES = (
    cubics("laneOffset", (0, 1.0), (50, 2.0))
    + section(0.0, lane(2, (0, 2.0)) + lane(1, (0, 3.0, 0.1)), lane(-1, (0, 4.0), (10, 5.0)))
    + section(50.0, lane(1, (0, 6.0), border=True), lane(-1, (0, -1.0), border=True) + lane(-2, (0, 2.0)))
)


def at(file: OpenDrive, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    return pose(file, np.zeros(len(s), np.int64), s)


def test_chords_stay_within_the_tolerance(tmp_path: Path) -> None:
    """An arc with a lane whose outer border is farther out, and a hump."""
    lanes = section(0.0, "", lane(-1, (0, 8.0)))
    length = 100.0
    plan = geometry('<arc curvature="0.02"/>', length)
    hump = cubics("elevation", (0, 0.0, 0.0, 0.02, -0.0002))
    file = read_text(tmp_path, document(road(plan=plan, length=length, lanes=lanes, elevation=hump)))
    stations = sample_roads(file, 0.02, 50.0)
    assert stations.s[0] == 0
    assert stations.s[-1] == length
    low, high = stations.s[:-1], stations.s[1:]
    middle = 0.5 * (low + high)
    roads = np.zeros(len(middle), np.int64)
    ends = [surface_points(file, roads, s, np.full(len(s), -8.0)) for s in (low, high)]
    x, y, z = surface_points(file, roads, middle, np.full(len(middle), -8.0))
    sagitta = np.hypot(x - 0.5 * (ends[0][0] + ends[1][0]), y - 0.5 * (ends[0][1] + ends[1][1]))
    assert sagitta.max() <= 0.0201
    assert np.abs(z - 0.5 * (ends[0][2] + ends[1][2])).max() <= 0.0201
    # And they are no denser than they must be.
    assert len(stations.s) < 80


def test_every_record_and_section_begins_at_a_station(tmp_path: Path) -> None:
    offset = cubics("laneOffset", (0, 0.0), (37.5, 0.5))
    lanes = offset + section(0.0, lane(1, (0, 3.0), (12.25, 3.0))) + section(71.0, lane(1, (0, 3.0)))
    file = read_text(tmp_path, document(road(lanes=lanes, elevation=cubics("elevation", (0, 0.0), (5.5, 0.0)))))
    stations = sample_roads(file, 0.05, 1000.0)
    assert stations.s.tolist() == [0, 5.5, 12.25, 37.5, 71.0, 100.0]


def test_roads_without_a_place_have_no_stations(tmp_path: Path) -> None:
    broken = [road("2", plan=""), road("3").replace('length="100.0"', 'length="x"', 1), road("4", length=0.0)]
    file = read_text(tmp_path, document(road(), *broken))
    stations = sample_roads(file)
    assert np.diff(stations.start).tolist() == [11, 0, 0, 0]
    ribbons = lane_ribbons(file, stations)
    assert (ribbons.left[3:] == ABSENT).all()
    assert np.isnan(at(file, np.zeros(1))[0]).tolist() == [False]
    x, _, _ = pose(file, np.array([1]), np.zeros(1))
    assert np.isnan(x).all()


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
