"""Which marks of lanes are written, and that those who need them find them."""

from __future__ import annotations

import io
from dataclasses import replace

import pytest
from lxml import etree
from sample_road_maps import crossing

from osm2xodr.conventions.targets import TARGETS
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import Cubic, Lane, LaneSection, LaneType, RoadMark
from osm2xodr.xodrWriter import WriteOptions, write_xodr

NONE, SOLID = RoadMark("none", width=0.0), RoadMark("solid")
CENTRE = Lane(0, LaneType.NONE, (), road_mark=NONE)


def lane(number: int, kind: LaneType, mark: RoadMark = NONE) -> Lane:
    return Lane(number, kind, (Cubic(0.0, 3.0),), road_mark=mark)


def marks(*lanes: Lane, in_junction: bool, target: str = "generic") -> dict[int, str | None]:
    """Return the marks of lanes as they are written, by lane id: None for none at all."""
    road_map = crossing()
    section = (LaneSection(0.0, lanes),)
    index = 2 if in_junction else 1
    roads = [replace(road, lane_sections=section) if k == index else road for k, road in enumerate(road_map.roads)]
    stream = io.BytesIO()
    write_xodr(replace(road_map, roads=tuple(roads)), stream, WriteOptions(target=TARGETS[target]), Diagnostics())
    found = etree.fromstring(stream.getvalue()).findall("road")[index].findall(".//lane")
    return {
        int(str(item.get("id"))): next((mark.get("type") for mark in item.iter("roadMark")), None) for item in found
    }


def test_connecting_roads_have_no_mark_where_none_is_painted() -> None:
    lanes = (lane(1, LaneType.BORDER), CENTRE, lane(-1, LaneType.DRIVING), lane(-2, LaneType.SIDEWALK))
    assert marks(*lanes, in_junction=True) == {1: None, 0: None, -1: None, -2: None}


def test_carla_finds_the_marks_of_all_lanes_for_cars_and_within() -> None:
    lanes = (lane(1, LaneType.BORDER), CENTRE, lane(-1, LaneType.DRIVING), lane(-2, LaneType.SIDEWALK))
    assert marks(*lanes, in_junction=True, target="carla") == {1: None, 0: "none", -1: "none", -2: None}


def test_lanes_inside_of_one_with_a_mark_keep_theirs() -> None:
    lanes = (CENTRE, lane(-1, LaneType.DRIVING), lane(-2, LaneType.BORDER, SOLID), lane(-3, LaneType.SIDEWALK))
    assert marks(*lanes, in_junction=True) == {0: "none", -1: "none", -2: "solid", -3: None}


@pytest.mark.parametrize("kind", [LaneType.DRIVING, LaneType.BUS, LaneType.BIKING, LaneType.PARKING])
def test_outside_junctions_lanes_that_vehicles_are_on_keep_theirs(kind: LaneType) -> None:
    lanes = (
        *(lane(3, LaneType.SIDEWALK), lane(2, LaneType.BORDER), lane(1, kind), CENTRE),
        *(lane(-1, LaneType.SIDEWALK), lane(-2, kind), lane(-3, LaneType.SHOULDER)),
    )
    expected = {3: None, 2: None, 1: "none", 0: "none", -1: "none", -2: "none", -3: None}
    assert marks(*lanes, in_junction=False) == expected


def test_a_centre_without_a_mark_and_lane_links_stand_in_one_line() -> None:
    stream = io.BytesIO()
    write_xodr(crossing(), stream, WriteOptions(), Diagnostics())
    assert b'    <center><lane id="0" type="none"/></center>\n' in stream.getvalue()
    assert b'><laneLink from="-1" to="-1"/></connection>\n' in stream.getvalue()
