"""Islands in junctions as objects: where they stand, and that no car drives over them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sample_road_maps import furnished_crossing

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.furniture import with_islands
from osm2xodr.model import Island


def test_the_corners_are_where_the_island_is() -> None:
    road_map = furnished_crossing()
    # Beside the way back, the fourth road, which runs west from (110, 0).
    corners = np.array([(102.0, 6.0), (106.0, 6.0), (106.0, 9.0), (102.0, 8.0)])
    found = Diagnostics()
    furniture = with_islands(replace(road_map, islands=(Island(5, 3, corners),)), found).furniture
    (made,) = (item for item in furniture.objects if item.name == "island" and item.road == 4)
    assert (made.type, made.height, made.length, made.width) == ("trafficIsland", 0.12, 4.0, 3.0)
    assert (made.s, made.t) == pytest.approx((6.0, -7.25))
    # u runs west, v south.
    assert [(110.0 - made.s - u, -made.t - v) for u, v, _, _ in made.outline] == [
        pytest.approx(tuple(corner)) for corner in corners.tolist()
    ]
    ids = [item.id for item in furniture.objects] + [item.id for item in furniture.signals]
    assert len(set(ids)) == len(ids)
    assert furniture.statistics["objects"] == len(furniture.objects)
    assert [(item.code, item.osm_id) for item in found] == [("junction-island", "node/99")]


def test_mapped_ones_have_their_id_and_no_guess() -> None:
    road_map = furnished_crossing()
    corners = np.array([(102.0, 6.0), (106.0, 6.0), (106.0, 9.0), (102.0, 8.0)])
    found = Diagnostics()
    furniture = with_islands(replace(road_map, islands=(Island(-1, 3, corners, "way/7"),)), found).furniture
    (made,) = (item for item in furniture.objects if item.name == "island" and item.road == 4)
    assert (made.osm_id, made.type, list(found)) == ("way/7", "trafficIsland", [])


def test_without_islands_nothing_changes() -> None:
    road_map = furnished_crossing()
    assert with_islands(road_map, Diagnostics()) is road_map
