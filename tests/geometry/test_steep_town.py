"""A town on a hillside: streets keep to the ground through all of their junctions, and lanes meet there."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from elevation_helpers import Ground
from road_measures import RoadMeasures, profile_value
from street_cases import Case

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import build_roads
from osm2xodr.model import FloatArray, LaneType, Road, RoadMap
from osm2xodr.osmParsing import ParseOptions, parse_osm

# Streets each so many metres, m, and how many there are each way.
BLOCK, STREETS = 40.0, 4
# Directions in which the ground rises, rad: along one half of the streets, across both, and between.
DIRECTIONS = (0.0, 0.25 * math.pi, 0.4)
# Cell size and standard error of elevation models, m: one made from laser scans, and a coarse one.
MODELS = ((1.0, 0.15), (30.0, 2.0))
TOWNS = [(direction, *model) for direction in DIRECTIONS for model in MODELS]


def hillside(slope: float, direction: float, cell: float, sigma: float) -> Ground:
    gx, gy = slope * math.cos(direction), slope * math.sin(direction)
    return Ground(lambda x, y: 100.0 + gx * x + gy * y, cell_size=cell, sigma=sigma)


def build(case: Case, ground: Ground) -> RoadMap:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "town.osm"
        path.write_text(case.osm(), encoding="utf-8")
        network = parse_osm(path, ParseOptions(guessed_sidewalks=False, guessed_shoulders=False), Diagnostics())
    return build_roads(network, ground, Diagnostics())


@cache
def town(direction: float, cell: float, sigma: float, slope: float = 0.25) -> tuple[RoadMap, Ground]:
    """Return a grid of streets on a slope, which end one block beyond the outer ones, and its ground."""
    middle, count = 0.5 * (STREETS + 1), STREETS + 2
    nodes = {
        f"n{i}{j}": (BLOCK * (i - middle), BLOCK * (j - middle))
        for i in range(count)
        for j in range(count)
        if 0 < i <= STREETS or 0 < j <= STREETS
    }
    ways = {}
    for k in range(1, STREETS + 1):
        ways[10 + k] = (" ".join(f"n{i}{k}" for i in range(count)), "highway=residential")
        ways[20 + k] = (" ".join(f"n{k}{j}" for j in range(count)), "highway=residential")
    ground = hillside(slope, direction, cell, sigma)
    return build(Case(nodes, ways), ground), ground


def off_ground(roads: RoadMap, ground: Ground, road: Road) -> FloatArray:
    """Return how far the reference line of a road is above the ground at every metre, m."""
    measures, k = RoadMeasures(roads), [item.id for item in roads.roads].index(road.id)
    length = measures.length(road)
    out = []
    for s in np.linspace(0.0, length, max(2, math.ceil(length) + 1)).tolist():
        pose = measures.pose(road, s)
        z = float(ground.height(np.array([pose.x]), np.array([pose.y]))[0])
        out.append(profile_value(roads.elevation, k, s) - z)
    return np.array(out)


@pytest.mark.parametrize(("direction", "cell", "sigma"), TOWNS)
def test_streets_of_a_steep_town_lie_on_its_ground(direction: float, cell: float, sigma: float) -> None:
    roads, ground = town(direction, cell, sigma)
    assert sum(road.junction is None for road in roads.roads) == 2 * STREETS * (STREETS + 1)
    assert len({road.junction for road in roads.roads} - {None}) == STREETS * STREETS
    for road in roads.roads:
        dead_end = road.junction is None and None in (road.predecessor, road.successor)
        # Coarse models say little about a dead end of one block: it comes within their standard error.
        most = sigma if dead_end and cell > 20.0 else 0.5
        assert np.abs(off_ground(roads, ground, road)).max() < most, f"road {road.id} in junction {road.junction}"


@pytest.mark.parametrize(("cell", "sigma"), MODELS)
def test_lone_street_of_thirty_percent_is_as_steep_as_it_is(cell: float, sigma: float) -> None:
    ground = hillside(0.3, 0.0, cell, sigma)
    roads = build(Case({"a": (-150.0, 0.0), "b": (150.0, 0.0)}, {1: ("a b", "highway=residential")}), ground)
    (road,) = roads.roads
    assert np.abs(off_ground(roads, ground, road)).max() < 0.5
    rise = profile_value(roads.elevation, 0, 200.0) - profile_value(roads.elevation, 0, 100.0)
    assert abs(rise) == pytest.approx(30.0, abs=0.1)


@pytest.mark.parametrize(("cell", "sigma"), MODELS)
@pytest.mark.parametrize("direction", DIRECTIONS)
def test_street_that_turns_a_corner_on_a_slope_keeps_to_it(direction: float, cell: float, sigma: float) -> None:
    ground = hillside(0.25, direction, cell, sigma)
    nodes = {"a": (-60.0, 0.0), "b": (0.0, 0.0), "c": (0.0, 60.0)}
    roads = build(Case(nodes, {1: ("a b c", "highway=residential")}), ground)
    # On cells of 30 m with a standard error of 2 m a beam still rounds the corner off.
    for road in roads.roads:
        assert np.abs(off_ground(roads, ground, road)).max() < max(0.5, sigma)


def contacts(roads: RoadMap) -> Iterator[tuple[Road, bool, Road, bool]]:
    """Yield all contacts of connecting roads for cars: it, whether with its start, a road, whether with its start."""
    by_id = {road.id: road for road in roads.roads}
    for path in roads.roads:
        types = {lane.type for section in path.lane_sections for lane in section.lanes}
        if path.junction is None or LaneType.DRIVING not in types:
            continue
        for at_start, link in ((True, path.predecessor), (False, path.successor)):
            assert link is not None
            assert link.at_start is not None
            yield path, at_start, by_id[link.id], link.at_start


def end_of(roads: RoadMap, road: Road, at_start: bool) -> tuple[float, float, float]:
    """Return height, superelevation and length at an end of a road."""
    k, s = [item.id for item in roads.roads].index(road.id), 0.0
    length = RoadMeasures(roads).length(road)
    s = 0.0 if at_start else length
    return profile_value(roads.elevation, k, s), profile_value(roads.superelevation, k, s), s


@pytest.mark.parametrize(("direction", "cell", "sigma"), TOWNS)
def test_lanes_meet_at_the_junctions_of_a_steep_town(direction: float, cell: float, sigma: float) -> None:
    """In height and in cross slope, also for readers that do not know superelevation."""
    roads, _ = town(direction, cell, sigma)
    measures, count = RoadMeasures(roads), 0
    for path, at_start, road, road_at_start in contacts(roads):
        (z, roll, s), (z_road, roll_road, s_road) = (
            end_of(roads, path, at_start),
            end_of(roads, road, road_at_start),
        )
        # Superelevation is that to the right of +s, which turns where starts or ends touch.
        sign = -1.0 if at_start == road_at_start else 1.0
        assert roll == pytest.approx(sign * roll_road, abs=1e-5)
        place, there = measures.pose(path, s), measures.pose(road, s_road)
        t = (place.y - there.y) * math.cos(there.hdg) - (place.x - there.x) * math.sin(there.hdg)
        assert z == pytest.approx(z_road + t * math.tan(roll_road), abs=0.002)
        assert abs(roll) < 0.3
        count += 1
    assert count >= 2 * 12 * STREETS * STREETS


def test_side_streets_take_the_grade_of_the_street_that_climbs_as_cross_slope() -> None:
    roads, _ = town(0.0, 1.0, 0.15)
    measures = RoadMeasures(roads)
    ends = {}
    for _, _, road, at_start in contacts(roads):
        _, roll, s = end_of(roads, road, at_start)
        ends[road.id, at_start] = (measures.pose(road, s).hdg, math.tan(roll))
    across = [-roll * math.sin(hdg) for hdg, roll in ends.values() if abs(math.sin(hdg)) > 0.9]
    along = [roll for hdg, roll in ends.values() if abs(math.sin(hdg)) < 0.1]
    # They rise to the east, to the right of what runs north: superelevation raises the left.
    assert len(across) == len(along) == 4 * STREETS * STREETS // 2
    assert np.array(across) == pytest.approx(0.25, abs=0.1)
    assert np.array(along) == pytest.approx(0.0, abs=0.03)
