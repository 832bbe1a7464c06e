"""Heights and cross slopes, and the surface that they make."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from xodr_text import cubics, document, read_text, road

from osm2xodr.opendrive.space.profiles import elevation, grade, surface_points


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
