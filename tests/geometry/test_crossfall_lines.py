"""Crossfall runs on through junctions at which carriageways only part or join."""

from __future__ import annotations

import math
from functools import cache
from itertools import product

import numpy as np
import pytest
from road_measures import Pose, RoadMeasures, assert_sound, profile_value
from street_cases import Case

from osm2xodr.geometry.crossfall_lines import Kinked
from osm2xodr.model import LaneType, Road, RoadMap, Rule

MAIN = "highway=motorway oneway=yes lanes={} maxspeed=120"
RAMP = "highway=motorway_link oneway=yes lanes=1 maxspeed=80"
# An exit and an entry of a motorway with three lanes, two between them.
NODES = {
    "a": (-900.0, 0.0),
    "b": (0.0, 0.0),
    "c": (900.0, 0.0),
    "d": (1800.0, 0.0),
    "p": (90.0, -12.0),
    "q": (500.0, -120.0),
    "r": (810.0, -12.0),
    "s": (400.0, -120.0),
}
WAYS = {
    1: ("a b", MAIN.format(3) + " turn:lanes=||slight_right"),
    2: ("b c", MAIN.format(2)),
    3: ("c d", MAIN.format(3)),
    4: ("b p q", RAMP),
    5: ("s r c", RAMP),
}


@cache
def interchange(rule: Rule = Rule.RIGHT_HAND) -> RoadMap:
    case = Case(NODES, WAYS)
    return (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)


def surface(roads: RoadMap, road: Road, s: float, t: float, banked: bool = True) -> tuple[Pose, float]:
    """Return a place of a road and its height, for readers that know superelevation or do not."""
    measures = RoadMeasures(roads)
    k = measures.index[road.id]
    roll = profile_value(roads.superelevation, k, s) if banked else 0.0
    return measures.pose(road, s).beside(t), profile_value(roads.elevation, k, s) + t * math.tan(roll)


def own_lane(path: Road) -> int:
    (lane,) = (item.id for item in path.lane_sections[0].lanes if item.type is LaneType.DRIVING)
    return lane


def roll(roads: RoadMap, way: int, s: float) -> float:
    """Return the cross slope of the road of a way, seen along it, at s from its start, or its end if negative."""
    measures = RoadMeasures(roads)
    road = next(item for item in roads.roads if item.junction is None and way in item.osm_way_ids)
    at = s if s >= 0.0 else measures.length(road) + s
    return math.tan(profile_value(roads.superelevation, measures.index[road.id], at))


@pytest.mark.parametrize("rule", list(Rule))
def test_all_arms_and_paths_fall_to_the_side_of_slow_traffic(rule: Rule) -> None:
    roads = interchange(rule)
    assert_sound(roads)
    measures = RoadMeasures(roads)
    expected = 0.025 if rule is Rule.RIGHT_HAND else -0.025
    paths = [item for item in roads.roads if item.junction is not None]
    assert len(paths) == 6
    for path, share in product(paths, (0.0, 0.3, 0.7, 1.0)):
        tilt = profile_value(roads.superelevation, measures.index[path.id], share * measures.length(path))
        assert math.tan(tilt) == pytest.approx(expected, abs=0.004)
    for way, s in ((1, -0.01), (2, 0.01), (2, -0.01), (3, 0.01)):
        assert roll(roads, way, s) == pytest.approx(expected, abs=0.004)


@pytest.mark.parametrize("banked", [True, False])
@pytest.mark.parametrize("rule", list(Rule))
def test_no_reader_finds_a_step_of_height(rule: Rule, banked: bool) -> None:
    """Along lanes; readers that ignore superelevation take every lane for level."""
    roads = interchange(rule)
    measures = RoadMeasures(roads)
    by_id = {road.id: road for road in roads.roads}
    for path in (item for item in roads.roads if item.junction is not None):
        lane = next(item for item in path.lane_sections[0].lanes if item.id == own_lane(path))
        for at_start, link, beyond in (
            (True, path.predecessor, lane.predecessor),
            (False, path.successor, lane.successor),
        ):
            assert link is not None
            assert beyond is not None
            other = by_id[link.id]
            _, edges = measures.at_end(path, at_start)
            _, edges_beyond = measures.at_end(other, bool(link.at_start))
            s = 0.0 if at_start else measures.length(path)
            s_beyond = 0.0 if link.at_start else measures.length(other)
            for t, t_beyond in zip(edges[lane.id], edges_beyond[beyond], strict=True):
                here, z = surface(roads, path, s, t, banked)
                there, z_beyond = surface(roads, other, s_beyond, t_beyond, banked)
                assert here.gap(there) < 1e-3
                assert z == pytest.approx(z_beyond, abs=2e-5)


def test_paths_are_one_surface() -> None:
    """Where lanes to the ramp and along the motorway overlap, beside each other or at the nose, heights agree."""
    roads = interchange()
    measures = RoadMeasures(roads)
    places = []
    for path in (item for item in roads.roads if item.junction is not None):
        for share in range(11):
            s = share / 10 * measures.length(path)
            for t in measures.edges(path, 0, s)[own_lane(path)]:
                places.append((path.junction, path.id, *surface(roads, path, s, t)))
    near = 0
    for (j, one, here, z), (i, other, there, height) in product(places, places):
        if j == i and one != other and here.gap(there) < 0.5:
            near += 1
            assert z == pytest.approx(height, abs=0.02)
    assert near > 20


def test_lanes_lie_where_they_would_lie_without_it() -> None:
    """Paths run from reference line to reference line, but their lanes, in place and width, are the same."""
    roads, level = interchange(), Case(NODES, WAYS).build(superelevation="none")
    measures, others = RoadMeasures(roads), RoadMeasures(level)
    by_id = {road.id: road for road in roads.roads}
    askew = 0
    for path, other in zip(roads.roads, level.roads, strict=True):
        if path.junction is None:
            continue
        for at_start, link in ((True, path.predecessor), (False, path.successor)):
            assert link is not None
            touched = measures.at_end(by_id[link.id], bool(link.at_start))[0]
            assert measures.at_end(path, at_start)[0].gap(touched) < 1e-6
        wanted = [edge_points(others, other, share / 2000) for share in range(2001)]
        for share in range(21):
            for side, place in enumerate(edge_points(measures, path, share / 20)):
                assert min(place.gap(points[side]) for points in wanted) < 0.06
        middle = 0.5 * measures.length(path)
        askew += abs(sum(measures.edges(path, 0, middle)[own_lane(path)]) / 2) > 0.5
    assert askew == 6


def edge_points(measures: RoadMeasures, path: Road, share: float) -> tuple[Pose, Pose]:
    """Return the places of the inner and of the outer edge of a path's lane at a share of its length."""
    s = share * measures.length(path)
    inner, outer = measures.edges(path, 0, s)[own_lane(path)]
    pose = measures.pose(path, s)
    return pose.beside(inner), pose.beside(outer)


def test_junctions_with_streets_of_both_directions_stay_level() -> None:
    ways = WAYS | {4: ("b p q", "highway=trunk lanes=2")}
    roads = Case(NODES, ways).build()
    assert roll(roads, 1, -0.01) == pytest.approx(0.0, abs=1e-6)
    assert roll(roads, 2, 0.01) == pytest.approx(0.0, abs=1e-6)
    assert roll(roads, 2, -0.01) == pytest.approx(0.025, abs=0.004)


def test_ramps_come_back_to_the_height_of_a_level_world() -> None:
    roads = interchange()
    measures = RoadMeasures(roads)
    ramp = next(item for item in roads.roads if item.junction is None and 4 in item.osm_way_ids)
    k = measures.index[ramp.id]
    # Its line lies some metres to the right of the motorway's, on its carriageway.
    assert -0.25 < profile_value(roads.elevation, k, 0.0) < -0.05
    assert profile_value(roads.elevation, k, measures.length(ramp)) == 0.0


def test_cubics_that_continue_the_one_before_are_not_written() -> None:
    at = np.array([0.0, 10.0, 30.0, 0.0, 5.0, 20.0])
    # A parabola in two pieces, and a line that bends at 5 m.
    value = np.array([1.0, 2.0, 10.0, 3.0, 3.0, 18.0])
    before, after = np.array([[0.0, 0.2, 0.6, 0.0, 0.0, 1.0], [0.0, 0.2, 0.6, 0.0, 1.0, 1.0]])
    records = Kinked(np.array([0, 3, 6]), at, value, before, after).records()
    assert records.start.tolist() == [0, 1, 3]
    assert records.s.tolist() == [0.0, 0.0, 5.0]
    assert records.a.tolist() == [1.0, 3.0, 3.0]
    assert records.c.tolist() == pytest.approx([0.01, 0.0, 0.0], abs=1e-12)


def test_cubics_that_a_checker_calls_redundant_are_one() -> None:
    # Cubics of 0.5 and 49.5 m whose coefficients about s = 0 differ by 8e-7 at most, though they are 2 mm apart at
    # the end; ASAM's checker takes less than 1e-6 for the same. The ends of what is left are those of both.
    at = np.array([0.0, 0.5, 50.0])
    step = 8e-7 * (at - 0.5) ** 2 * (at > 0.5)
    value = 3.66 - 3e-5 * at**2 + step
    slope = -6e-5 * at + 1.6e-6 * (at - 0.5) * (at > 0.5)
    records = Kinked(np.array([0, 3]), at, value, slope, slope).records()
    assert records.s.tolist() == [0.0]
    assert records.a[0] + 50.0 * (records.b[0] + 50.0 * (records.c[0] + 50.0 * records.d[0])) == pytest.approx(
        value[2]
    )
    other = slope + 1.6e-6 * (at - 0.5) * (at > 0.5)
    assert Kinked(np.array([0, 3]), at, value + step, other, other).records().s.tolist() == [0.0, 0.5]


def test_cubics_that_become_redundant_are_one_as_well() -> None:
    # A width of 2.5 m that wobbles by hundredths of a millimetre: only when the first piece has taken in the second
    # does it differ from the third by less than what counts.
    at = np.array([0.0, 4.698, 10.731, 20.0])
    value = 2.5 + np.array([1.3e-5, 1.8e-5, -9e-6, 0.0])
    slope = np.array([8.3e-7, -1.32e-6, -8.2e-7, 8.6e-7])
    records = Kinked(np.array([0, 4]), at, value, slope, slope).records()
    assert records.s.tolist() == [0.0]
    assert records.a.tolist() == [value[0]]
