"""The client of CARLA 0.9.16 loads the files and drives on them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lane_graph import LaneGraph, LaneKey
from lxml import etree
from real_readers import carla_answers
from scene_files import SCENES, Conversion, Conversions, Scene
from xodr_file import XodrFile

# CARLA computes in single precision.
PRECISION = 0.01
# Corners, s and t are rounded, and headings to 1e-5.
CROSSWALK_PRECISION = 0.02
# How far apart waypoints may be that are one metre of reference line apart: on a lane beside it, a turn adds to that,
# and so does the slant of a lane where others open or end.
WIDEST_OFFSET, SHARPEST_TURN = 8.0, 0.3
SLACK = 0.15
STEEPEST = 0.35


def parse(path: Path) -> Any:
    """Parse a file; typed as anything, for every element may be absent and a test is to fail then."""
    return etree.parse(str(path), etree.XMLParser(huge_tree=True)).getroot()


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
        road = drive.conversion.network.roads[road_id]
        meant = road.lane_middle(section, lane, found[:, 0])
        if road.superelevation.value(found[:, 0]).any():
            # CARLA leaves lanes at the height of the road.
            meant[:, 2] = road.elevation.value(found[:, 0])
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


def test_landmarks_are_where_the_file_says(drive: Drive) -> None:
    network = drive.conversion.network
    meant = {
        (element.get("id"), road.get("id")): (element, kind)
        for road in parse(drive.conversion.path).iter("road")
        for kind in ("signal", "signalReference")
        for element in road.iter(kind)
    }
    found = {(item["id"], str(item["road"])): item for item in drive.answers["landmarks"]}
    assert len(found) == len(drive.answers["landmarks"])
    assert set(found) <= set(meant)
    for key, (element, kind) in meant.items():
        lanes = [[int(part.get("fromLane")), int(part.get("toLane"))] for part in element.iter("validity")]
        if lanes == [[0, 0]]:
            # A light for people beside whom there is no lane of theirs; CARLA leaves it out.
            assert element.get("type") == "1000002"
            continue
        item = found[key]
        # Without them CARLA takes the lanes of the other direction.
        assert lanes
        assert item["lanes"] == lanes
        if kind == "signal":
            s, t = float(element.get("s")), float(element.get("t"))
            place = network.roads[key[1]].points(np.array([s]), np.array([t]))[0]
            assert np.hypot(*(np.array(item["place"]) - place)[:2]) <= _post_shift(item) + PRECISION, key


def _post_shift(item: dict[str, Any]) -> float:
    """Return how far CARLA moves a sign, m: lights 0.25 m along the road, signs off lanes that they stand on."""
    return 0.25 if item["light"] else 0.0


def test_crosswalks_are_where_the_file_says(drive: Drive) -> None:
    network = drive.conversion.network
    meant = []
    for road in parse(drive.conversion.path).iter("road"):
        for element in road.iter("object"):
            if element.get("type") == "crosswalk":
                at, t, turn = (float(element.get(name, 0.0)) for name in ("s", "t", "hdg"))
                place = network.roads[road.get("id")].points(np.array([at]), np.array([t]))[0]
                heading = float(network.roads[road.get("id")].pose(np.array([at]))[2][0]) + turn
                corners = [
                    [float(c.get("u")), float(c.get("v"))] for c in element.find("outlines").iter("cornerLocal")
                ]
                turned = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
                meant.append(place[:2] + np.array(corners) @ turned)
    found = [np.array(corners)[:-1, :2] for corners in drive.answers["crosswalks"]]
    assert len(found) == len(meant)
    middles = np.array([corners.mean(axis=0) for corners in found]).reshape(-1, 2)
    for corners in meant:
        nearest = found[int(np.argmin(np.hypot(*(middles - corners.mean(axis=0)).T)))]
        assert np.abs(nearest - corners).max() < CROSSWALK_PRECISION


def _key(network: XodrFile, item: list[int]) -> LaneKey:
    road, section, lane = item
    assert str(road) in network.roads
    return str(road), section, lane
