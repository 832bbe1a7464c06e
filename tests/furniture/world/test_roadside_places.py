"""Places beside roads do not depend on how many points are looked up at once."""

from __future__ import annotations

import numpy as np
import pytest
from object_cases import ROAD, world_of

from osm2xodr.furniture.world import roadside_places
from osm2xodr.furniture.world.roadside_places import RoadsideFinder


def test_points_are_placed_beside_the_road(monkeypatch: pytest.MonkeyPatch) -> None:
    finder = RoadsideFinder(world_of(ROAD))
    x, y = np.linspace(-90.0, 90.0, 23), np.linspace(-20.0, 20.0, 23)
    whole = finder.places(x, y)
    # The carriageway is 7 m wide, and things belong to a road up to 10 m from its edge. Frames have a scale.
    near = np.abs(y) <= 13.5
    assert ((whole.road >= 0) == near).all()
    assert whole.beyond[near] == pytest.approx(np.abs(y[near]) - 3.5, abs=2e-3)
    monkeypatch.setattr(roadside_places, "_AT_ONCE", 4)
    parts = finder.places(x, y)
    for name in ("road", "s", "t", "left", "right"):
        np.testing.assert_array_equal(getattr(parts, name), getattr(whole, name))
    assert len(finder.places(x[:0], y[:0]).road) == 0
