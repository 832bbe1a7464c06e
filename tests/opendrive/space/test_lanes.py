"""Heights and cross slopes, and the surface that they make.

Borders of lanes, and sections and lanes at places.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from xodr_text import cubics, document, lane, read_text, road, section

from osm2xodr.opendrive.space.finder import places_on
from osm2xodr.opendrive.space.lanes import elevation, grade, lane_borders, section_at, surface_points
from osm2xodr.opendrive.tables import ABSENT

LANES = (
    cubics("laneOffset", (0, 1.0), (50, 2.0))
    + section(0.0, lane(2, (0, 2.0)) + lane(1, (0, 3.0, 0.1)), lane(-1, (0, 4.0), (10, 5.0)))
    + section(50.0, lane(1, (0, 6.0), border=True), lane(-1, (0, -1.0), border=True) + lane(-2, (0, 2.0)))
)


def test_elevation_and_its_slope(tmp_path: Path) -> None:
    file = read_text(tmp_path, document(road(elevation=cubics("elevation", (0, 1.0, 0.1), (50, 7.0, 0.0, 0.01)))))
    roads, s = np.zeros(3, np.int64), np.array([20.0, 50.0, 60.0])
    np.testing.assert_allclose(elevation(file, roads, s), [3, 7, 8])
    np.testing.assert_allclose(elevation(file, roads, s, before=True), [3, 6, 8])
    np.testing.assert_allclose(grade(file, roads, s), [0.1, 0.0, 0.2])


def test_superelevation_makes_a_plane(tmp_path: Path) -> None:
    roll = 0.1
    file = read_text(
        tmp_path,
        document(road(elevation=cubics("elevation", (0, 5.0)), lateral=cubics("superelevation", (0, roll)))),
    )
    t = np.array([-10.0, 0.0, 10.0])
    x, y, z = surface_points(file, np.zeros(3, np.int64), np.full(3, 30.0), t, 1.0)
    np.testing.assert_allclose(x, 30)
    np.testing.assert_allclose(y, t * math.cos(roll) - math.sin(roll))
    np.testing.assert_allclose(z, 5 + t * math.sin(roll) + math.cos(roll))


def test_borders_add_up_from_the_lane_offset(tmp_path: Path) -> None:
    file = read_text(tmp_path, document(road(lanes=LANES)))
    assert file.lanes.id.tolist() == [2, 1, 0, -1, 1, 0, -1, -2]
    inner, outer = lane_borders(file, np.arange(4), np.full(4, 20.0))
    np.testing.assert_allclose(inner, [6, 1, 1, 1])
    np.testing.assert_allclose(outer, [8, 6, 1, -4])
    inner, outer = lane_borders(file, np.arange(4, 8), np.full(4, 60.0))
    np.testing.assert_allclose(inner, [2, 2, 2, 1])
    np.testing.assert_allclose(outer, [8, 2, 1, -1])


def test_the_end_of_a_section_is_its_own(tmp_path: Path) -> None:
    file = read_text(tmp_path, document(road(lanes=LANES)))
    inner, outer = lane_borders(file, np.array([1]), np.array([50.0]), before=True)
    np.testing.assert_allclose([inner[0], outer[0]], [1, 9])
    inner, outer = lane_borders(file, np.array([3]), np.array([10.0]), before=True)
    np.testing.assert_allclose(outer, [-3])


def test_lanes_at_places(tmp_path: Path) -> None:
    file = read_text(tmp_path, document(road(lanes=LANES), road("2", lanes="")))
    s = np.array([20.0, 20.0, 20.0, 60.0, 20.0])
    t = np.array([7.0, -3.9, -4.1, 0.0, 0.0])
    roads = np.array([0, 0, 0, 0, 1])
    places = places_on(file, roads, s, t)
    assert places.lane.tolist() == [0, 3, 3, 7, ABSENT]
    assert places.inside.tolist() == [True, True, False, True, False]
    np.testing.assert_allclose(places.distance, [0.0, 0.0, 0.1, 0.0, 0.0])
    assert section_at(file, roads, np.full(5, 50.0)).tolist() == [1, 1, 1, 1, ABSENT]
    assert section_at(file, roads[:1], np.array([50.0]), before=True).tolist() == [0]
