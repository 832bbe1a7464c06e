"""Sidewalks round corners join sidewalks."""

from __future__ import annotations

from pathlib import Path

from osm_builder import Area
from xodr_file import read_xodr

import osm2xodr

WALKS = "highway=residential lanes=2 width=6 sidewalk=both"
NODES = {1: (0.0, 0.0), 2: (60.0, 0.0), 3: (140.0, 0.0), 4: (-80.0, 0.0), 5: (0.0, 80.0)}


def test_where_a_parking_lane_begins_later_in_the_only_section(tmp_path: Path) -> None:
    ways = {
        10: ([1, 2], WALKS),
        11: ([2, 3], WALKS + " parking:right=lane parking:right:orientation=parallel"),
        12: ([4, 1], WALKS),
        13: ([1, 5], WALKS),
    }
    out = tmp_path / "area.xodr"
    osm2xodr.convert(Area(NODES, ways).write(tmp_path), output=out)
    roads = read_xodr(out).roads
    (street,) = (
        number
        for number, road in roads.items()
        if any(lane.type == "parking" for section in road.sections for lane in section.lanes.values())
    )
    (whole,) = roads[street].sections
    kinds = []
    for road in roads.values():
        for link, section, side in ((road.predecessor, 0, "predecessors"), (road.successor, -1, "successors")):
            if road.connecting and link is not None and link.element_id == street:
                for lane in road.sections[section].lanes.values():
                    kinds += [(lane.type, whole.lanes[number].type) for number in getattr(lane, side)]
    assert kinds.count(("sidewalk", "sidewalk")) == 2
    assert {one for one, other in kinds if one != other} == set()
