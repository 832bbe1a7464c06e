"""Which marks of lanes are written, and that those who need them find them."""

from __future__ import annotations

import io
import math
from dataclasses import replace

import pytest
from lxml import etree
from sample_road_maps import crossing

from osm2xodr.conventions.targets import TARGETS
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import Cubic, Lane, LaneSection, LaneType, RoadMark, RoadType
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


def test_a_line_is_an_element_with_all_that_belongs_to_it() -> None:
    stream = io.BytesIO()
    write_xodr(crossing(), stream, WriteOptions(), Diagnostics())
    lines = stream.getvalue().splitlines()
    assert not [line for line in lines if line.startswith(b" ")]
    assert '<center><lane id="0" type="none"/></center>' in stream.getvalue().decode()
    assert b'><laneLink from="-1" to="-1"/></connection>' in stream.getvalue()
    # Several lanes never share a line, but for the empty centre.
    assert max(line.count(b"</lane>") for line in lines) == 1


@pytest.mark.parametrize(
    ("index", "of_road", "of_lane", "written"),
    [
        pytest.param(2, 10.0, 10.0, None, id="as its connecting road"),
        pytest.param(2, math.inf, math.inf, None, id="none, as its connecting road"),
        pytest.param(2, 10.0, 20.0, "72", id="other than its connecting road"),
        pytest.param(2, None, 10.0, "36", id="the road has none"),
        pytest.param(1, 10.0, 10.0, "36", id="outside junctions, for SUMO"),
    ],
)
def test_lanes_repeat_no_limit_of_their_connecting_road(
    index: int, of_road: float | None, of_lane: float, written: str | None
) -> None:
    road_map = crossing()
    section = (LaneSection(0.0, (CENTRE, replace(lane(-1, LaneType.DRIVING), speed=of_lane))),)
    road = replace(road_map.roads[index], lane_sections=section, types=(RoadType(0.0, "town", of_road),))
    # The same section on a road of another limit
    other = replace(road_map.roads[3], lane_sections=section, types=(RoadType(0.0, "town", 5.0),))
    roads = (*road_map.roads[:index], road, *road_map.roads[index + 1 : 3], other, *road_map.roads[4:])
    stream = io.BytesIO()
    write_xodr(replace(road_map, roads=roads), stream, WriteOptions(), Diagnostics())
    elements = etree.fromstring(stream.getvalue()).findall("road")
    speeds = [[item.get("max") for item in elements[k].findall(".//lane/speed")] for k in (index, 3)]
    assert speeds[0] == ([] if written is None else [written])
    assert len(speeds[1]) == 1
