from __future__ import annotations

import numpy as np
import pytest
from sample_road_maps import straight_roads

from osm2xodr.geometry import mark_unmeasured
from osm2xodr.model import BoolArray, FloatArray, RoadMap, Surface, SurfaceQuality


class Part:
    """A surface that is measured up to x = 3."""

    cell_size = sigma = 1.0

    def heights(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, BoolArray]:
        return 0.0 * x, self.measured(x, y)

    def measured(self, x: FloatArray, y: FloatArray) -> BoolArray:
        return x < 3.0

    def quality(self, x: FloatArray, y: FloatArray) -> SurfaceQuality:
        raise NotImplementedError


def marked(roads: int, surface: Surface | None = None) -> list[list[tuple[float, float]]]:
    road_map: RoadMap = mark_unmeasured(straight_roads(roads), surface or Part())
    found = road_map.unmeasured
    assert found is not None
    pairs = list(zip(found.begin.tolist(), found.end.tolist(), strict=True))
    return [pairs[a:b] for a, b in zip(found.start[:-1].tolist(), found.start[1:].tolist(), strict=True)]


def test_stretches_end_halfway_between_places() -> None:
    # Roads of 10 m that start at x = 0, 1, 2, 3 and head 0.5 rad from east: looked up at s = 0, 5 and 10.
    assert marked(4) == [[(2.5, 10.0)], [(2.5, 10.0)], [(2.5, 10.0)], [(0.0, 10.0)]]


class Hole(Part):
    """A surface with a hole round the middle of the first road."""

    def measured(self, x: FloatArray, y: FloatArray) -> BoolArray:
        return np.asarray(np.hypot(x - 5.0 * np.cos(0.5), y - 5.0 * np.sin(0.5)) > 0.5)


def test_holes_within_roads() -> None:
    assert marked(2, Hole()) == [[(2.5, 7.5)], []]


def test_nothing_to_mark() -> None:
    class Whole(Part):
        def measured(self, x: FloatArray, y: FloatArray) -> BoolArray:
            return np.ones(len(x), bool)

    road_map = mark_unmeasured(straight_roads(3), Whole())
    assert road_map.unmeasured is not None
    assert road_map.unmeasured.total(np.full(3, 10.0)) == pytest.approx(0.0, abs=0.0)
