"""Buildings of OSM files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from osm_builder import LAT_0, LAT_PER_METRE, LON_0, LON_PER_METRE, Area

from osm2xodr.model import Building, FloatArray
from osm2xodr.osmParsing.surroundings import read_buildings

NODES = {1: (0.0, 0.0), 2: (20.0, 0.0), 3: (20.0, 10.0), 4: (0.0, 10.0)} | {
    5: (5.0, 3.0),
    6: (15.0, 3.0),
    7: (15.0, 7.0),
    8: (5.0, 7.0),
}


def read(tmp_path: Path, area: Area) -> tuple[tuple[Building, ...], tuple[str, ...]]:
    return read_buildings(area.write(tmp_path))


def metres(outline: FloatArray) -> list[list[float]]:
    out: list[list[float]] = np.rint((outline - (LON_0, LAT_0)) / (LON_PER_METRE, LAT_PER_METRE)).tolist()
    return out


def test_ways_have_heights_and_roofs(tmp_path: Path) -> None:
    tags = "building=house building:levels=2 roof:shape=gabled roof:height=2.5 roof:orientation=across"
    (found,), broken = read(tmp_path, Area(NODES, {9: ([1, 2, 3, 4, 1], tags)}))
    assert broken == ()
    assert (found.osm_id, found.kind, found.is_part) == ("way/9", "house", False)
    assert metres(found.outline) == [[0, 0], [20, 0], [20, 10], [0, 10]]
    assert (found.levels, found.roof_height, found.roof_shape, found.ridge_across) == (2.0, 2.5, "gabled", True)
    assert (found.height, found.min_height, found.min_level, found.roof_levels) == (None, None, None, None)


def test_units_and_nonsense(tmp_path: Path) -> None:
    tags = "building:part=yes height=30' min_height=3 building:levels=many building:min_level=1.5 roof:levels=1m"
    (found,), _ = read(tmp_path, Area(NODES, {9: ([1, 2, 3, 4, 1], tags)}))
    assert found.is_part
    assert found.height == 30 * 0.3048
    assert (found.min_height, found.levels, found.min_level, found.roof_levels) == (3.0, None, 1.5, None)
    (high,), _ = read(tmp_path, Area(NODES, {9: ([1, 2, 3, 4, 1], "building=yes height=9000")}))
    assert high.height is None


def test_multipolygons_are_joined_from_ways_and_have_courtyards(tmp_path: Path) -> None:
    ways = {10: ([3, 2, 1], ""), 11: ([3, 4, 1], ""), 12: ([5, 6, 7, 8, 5], "")}
    members = [("way", 10, "outer"), ("way", 11, "outer"), ("way", 12, "inner")]
    area = Area(NODES, ways, {20: (members, "type=multipolygon building=yes height=12")})
    (found,), broken = read(tmp_path, area)
    assert broken == ()
    assert (found.osm_id, found.height) == ("relation/20", 12.0)
    assert metres(found.outline) == [[20, 10], [20, 0], [0, 0], [0, 10]]
    assert [metres(hole) for hole in found.holes] == [[[5, 3], [15, 3], [15, 7], [5, 7]]]


def test_what_is_not_whole_or_below_the_ground_is_left_out(tmp_path: Path) -> None:
    ways = {
        9: ([1, 2, 3, 4], "building=yes"),
        10: ([1, 2, 3, 1], "building=yes location=underground"),
        11: ([1, 2, 3, 1], "building=no"),
        12: ([1, 2, 99, 1], "building=yes"),
        13: ([1, 2, 3], ""),
    }
    area = Area(NODES, ways, {20: ([("way", 13, "outer")], "type=multipolygon building=yes")})
    found, broken = read(tmp_path, area)
    assert found == ()
    assert broken == ("way/9", "relation/20", "way/12")
