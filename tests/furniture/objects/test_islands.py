"""Islands in junctions as objects: where they stand, and that no car drives over them."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lxml import etree
from sample_road_maps import furnished_crossing
from scene_files import Conversions, scene_named

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


def test_without_islands_nothing_changes() -> None:
    road_map = furnished_crossing()
    assert with_islands(road_map, Diagnostics()) is road_map


def test_the_triangle_behind_the_slip_lane_is_raised_and_no_lane_leads_over_it(conversions: Conversions) -> None:
    conversion = conversions.of(scene_named("fremantle_placement"))
    made = [item for item in _islands(conversion.path) if conversion.network.roads[item[0]].connecting]
    assert len(made) == 1
    road, s, t, corners = made[0]
    x, y, hdg = (float(v[0]) for v in conversion.network.roads[road].pose(np.array([s])))
    middle = complex(x, y) + t * 1j * complex(math.cos(hdg), math.sin(hdg))
    ring = np.array([middle + complex(u, v) * complex(math.cos(hdg), math.sin(hdg)) for u, v in corners])
    across = ring.real * np.roll(ring.imag, -1) - ring.imag * np.roll(ring.real, -1)
    assert 20.0 < 0.5 * abs(float(across.sum())) < 55.0
    nearest = math.inf
    for item in conversion.network.roads.values():
        for number, lane in item.sections[0].lanes.items() if item.connecting else ():
            if lane.type == "driving":
                places = item.lane_middle(0, number, np.linspace(0.0, item.length, 40))
                away = np.abs((places[:, 0] + 1j * places[:, 1])[:, None] - ring)
                nearest = min(nearest, float(away.min()))
    assert nearest > 1.2


def _islands(path: Path) -> list[tuple[str, float, float, list[tuple[float, float]]]]:
    found = []
    for road in etree.parse(path).getroot().findall("road"):
        for item in road.findall("objects/object[@type='trafficIsland']"):
            corners = [
                (float(str(corner.get("u"))), float(str(corner.get("v"))))
                for corner in item.findall("outlines/outline/cornerLocal")
            ]
            found.append((str(road.get("id")), float(str(item.get("s"))), float(str(item.get("t"))), corners))
    return found
