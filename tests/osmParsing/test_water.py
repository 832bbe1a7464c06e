"""Water of OSM files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from osm_builder import LAT_0, LAT_PER_METRE, LON_0, LON_PER_METRE, Area

from osm2xodr.model import FloatArray
from osm2xodr.osmParsing import read_surroundings

NODES = {1: (0.0, 0.0), 2: (20.0, 0.0), 3: (20.0, 10.0), 4: (0.0, 10.0)} | {
    5: (5.0, 3.0),
    6: (15.0, 3.0),
    7: (15.0, 7.0),
}


def metres(line: FloatArray) -> list[list[float]]:
    out: list[list[float]] = np.rint((line - (LON_0, LAT_0)) / (LON_PER_METRE, LAT_PER_METRE)).tolist()
    return out


def test_lakes_have_islands_and_the_coast_keeps_its_direction(tmp_path: Path) -> None:
    ways = {
        10: ([1, 2, 3, 4, 1], ""),
        11: ([5, 6, 7, 5], ""),
        12: ([7, 2, 1], "natural=coastline"),
        13: ([5, 6, 7, 5], "waterway=dock"),
        14: ([1, 2, 3, 1], "building=yes"),
    }
    members = [("way", 10, "outer"), ("way", 11, "inner")]
    area = Area(NODES, ways, {20: (members, "type=multipolygon natural=water water=lake")})
    found = read_surroundings(area.write(tmp_path))
    dock, lake = found.water.areas
    assert (dock.osm_id, metres(dock.outline), dock.holes) == ("way/13", [[5, 3], [15, 3], [15, 7]], ())
    assert (lake.osm_id, metres(lake.outline)) == ("relation/20", [[0, 0], [20, 0], [20, 10], [0, 10]])
    assert [metres(hole) for hole in lake.holes] == [[[5, 3], [15, 3], [15, 7]]]
    assert [metres(line) for line in found.water.coastlines] == [[[15, 7], [20, 0], [0, 0]]]
    assert [building.osm_id for building in found.buildings] == ["way/14"]


def test_water_of_some_seasons_underground_or_not_whole_is_left_out(tmp_path: Path) -> None:
    ways = {
        10: ([1, 2, 3, 1], "natural=water intermittent=yes"),
        11: ([1, 2, 3, 1], "natural=water tunnel=culvert"),
        12: ([1, 2, 3], "natural=water"),
        13: ([1, 2, 99, 1], "natural=water"),
        14: ([1, 99, 2], "natural=coastline"),
        15: ([1, 2, 3, 1], "natural=wetland"),
    }
    found = read_surroundings(Area(NODES, ways).write(tmp_path))
    assert found.water.areas == ()
    assert found.water.coastlines == ()
