"""Time grows with the network and no faster."""

from __future__ import annotations

import time
from io import BytesIO
from pathlib import Path

from replicate import Area, replicate
from scene_files import scene_named

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.pipeline import PipelineOptions, convert
from osm2xodr.xodrWriter import WriteOptions, write_xodr

# So many copies of 25 roads that what each conversion costs anyway does not count: 25 roads take .3 s, 400 take 1.2.
COPIES = 16
TIMES = 8


def seconds_and_roads(area: Area) -> tuple[float, int]:
    """Return the processor time of a conversion, s, and how many roads it made."""
    assert area.dem is not None
    diagnostics = Diagnostics()
    began = time.process_time()
    road_map = convert(PipelineOptions(area.osm, (area.dem,)), diagnostics).road_map
    write_xodr(road_map, BytesIO(), WriteOptions(), diagnostics)
    return time.process_time() - began, len(road_map.roads)


def test_a_network_of_eight_times_the_size_takes_no_more_time_per_road(tmp_path: Path) -> None:
    scene = scene_named("montlake_roundabout")
    area = Area(scene.name, scene.osm, scene.dem)
    one, eight = (replicate(area, copies, tmp_path) for copies in (COPIES, TIMES * COPIES))
    seconds_and_roads(one)  # the first run also loads what is loaded once
    small, small_roads = min(seconds_and_roads(one) for _ in range(2))
    large, large_roads = seconds_and_roads(eight)
    if large / large_roads > 1.25 * small / small_roads:
        # Somebody else may have had the machine.
        large = min(large, seconds_and_roads(eight)[0])
    assert large_roads == TIMES * small_roads
    assert large / large_roads <= 1.25 * small / small_roads
