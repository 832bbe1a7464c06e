"""The client of CARLA 0.9.16 loads the files and drives on them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from lane_graph import LaneGraph, LaneKey
from real_readers import carla_answers
from scene_files import SCENES, Conversion, Conversions, Scene
from xodr_file import XodrFile

# CARLA computes in single precision.
PRECISION = 0.01
# How far apart waypoints may be that are one metre of reference line apart: on a lane beside it, a turn adds to that,
# and so does the slant of a lane where others open or end.
WIDEST_OFFSET, SHARPEST_TURN = 8.0, 0.3
SLACK = 0.15
STEEPEST = 0.35


@dataclass(frozen=True)
class Drive:
    """A conversion and what CARLA sees of it."""

    conversion: Conversion
    answers: dict[str, Any]


@pytest.fixture(scope="module", params=SCENES, ids=str)
def drive(request: pytest.FixtureRequest, conversions: Conversions) -> Drive:
    scene: Scene = request.param
    conversion = conversions.of(scene)
    return Drive(conversion, carla_answers(conversion.path))


def test_its_origin_is_in_the_area(drive: Drive) -> None:
    lat, lon = drive.answers["origin_lat_lon"]
    west, south, east, north = drive.conversion.osm.bounds_deg
    assert west < lon < east or west < lon + 360 < east
    assert south < lat < north


def test_lanes_lie_where_the_standard_says(drive: Drive) -> None:
    by_lane: dict[LaneKey, list[list[float]]] = {}
    for road, section, lane, *figures in drive.answers["places"]:
        by_lane.setdefault((str(road), section, lane), []).append(figures)
    assert by_lane
    for (road_id, section, lane), rows in by_lane.items():
        found = np.array(rows)
        meant = drive.conversion.network.roads[road_id].lane_middle(section, lane, found[:, 0])
        assert np.abs(found[:, 1:4] - meant).max() < PRECISION, (road_id, section, lane)


def test_it_finds_every_lane(drive: Drive) -> None:
    network = drive.conversion.network
    found = {_key(network, item) for item in drive.answers["lanes"]}
    meant = {
        (road.id, k, lane.id)
        for road in network.roads.values()
        for k, section in enumerate(road.sections)
        for lane in section.lanes.values()
        if lane.type == "driving"
    }
    assert found == meant


def test_it_goes_on_from_lane_to_lane_as_the_file_says(drive: Drive) -> None:
    network = drive.conversion.network
    found = {(_key(network, a), _key(network, b)) for a, b in drive.answers["topology"]}
    meant = {(a, b) for a, ways_on in LaneGraph(network).next.items() for b in ways_on}
    assert len(meant) > 0
    assert (
        found - {(lane, lane) for lane in LaneGraph(network).ends()} == meant
    )  # a dead end, it says, leads to itself


def test_waypoints_follow_each_other_without_gaps(drive: Drive) -> None:
    steps = drive.answers["steps"]
    assert len(steps) > 100
    far = [s for s in steps if not s["flat"] <= 1.0 + SLACK + WIDEST_OFFSET * min(s["turn"], SHARPEST_TURN)]
    assert far == []


def test_waypoints_follow_each_other_without_steps(drive: Drive) -> None:
    high = [s for s in drive.answers["steps"] if not abs(s["rise"]) <= STEEPEST * max(s["flat"], 1.0) + SLACK]
    assert high == []


def _key(network: XodrFile, item: list[int]) -> LaneKey:
    road, section, lane = item
    assert str(road) in network.roads
    return str(road), section, lane
