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
    assert found.water.unclosed == ("way/12",)
    # What is known of an outline with nodes that are not in the file is kept.
    assert [(area.osm_id, [metres(line) for line in area.lines]) for area in found.water.open_areas] == [
        ("way/13", [[[0, 0], [20, 0]]])
    ]


def test_multipolygons_that_are_not_whole_keep_their_lines_and_islands(tmp_path: Path) -> None:
    ways = {10: ([1, 2], ""), 11: ([3, 2], ""), 12: ([5, 6, 7, 5], ""), 14: ([4, 1, 3, 4], "")}
    river = [("way", 10, "outer"), ("way", 11, "outer"), ("way", 13, "outer"), ("way", 12, "inner")]
    lakes = [("way", 14, "outer"), ("way", 10, "outer")]
    tags = "type=multipolygon natural=water"
    path = Area(NODES, ways, {20: (river, tags), 21: (lakes, tags)}).write(tmp_path)
    found = read_surroundings(path).water
    first, second = found.open_areas
    assert [metres(line) for line in first.lines] == [[[0, 0], [20, 0], [20, 10]]]
    assert [metres(hole) for hole in first.holes] == [[[5, 3], [15, 3], [15, 7]]]
    assert [area.osm_id for area in found.areas] == [second.osm_id] == ["relation/21"]
    assert [metres(line) for line in second.lines] == [[[0, 0], [20, 0]]]
    assert found.bounds is None
    box = '<bounds minlat="49.9" minlon="9.9" maxlat="50.1" maxlon="10.25"/>'
    path.write_text(path.read_text().replace('<osm version="0.6">', f'<osm version="0.6">{box}'))
    assert read_surroundings(path).water.bounds == (9.9, 49.9, 10.25, 50.1)
