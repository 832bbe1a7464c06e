from __future__ import annotations

import json
import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from border_cases import EAST, FIRST, WEST, alone, halves_of, stripes_of
from hypothesis import given, strategies as st
from real_readers import schema_errors
from sample_road_maps import FRAME, centre, crossing, furnished_crossing, lane, plan_view, profile
from scene_files import SAMPLES

from osm2xodr.checking import CheckOptions, Severity, check_drive
from osm2xodr.curves.cubics import cubic_slope, cubic_value
from osm2xodr.curves.plan_views import curvature_at, lengths, wrapped
from osm2xodr.curves.records import pose
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.geometry.tile_edges.own_area import keep_own_area
from osm2xodr.model import (
    BorderEnd,
    Borders,
    Cubic,
    ElevationReport,
    LaneSection,
    LayerCrossing,
    Road,
    RoadLink,
    RoadMap,
    RoadPlace,
    RoadType,
    Rule,
    StructureRecord,
)
from osm2xodr.opendrive.reader import read_xodr
from osm2xodr.pipeline import PipelineOptions, convert
from osm2xodr.reporting.report import report
from osm2xodr.reporting.statistics import Statistics
from osm2xodr.xodrWriter import WriteOptions, write_xodr

# A line that runs through road 1 of `crossing`, before and behind its lane section at s = 60, and one in the arc of
# road 2, which begins at x = 190.
BEFORE_SECTION, BEHIND_SECTION, IN_ARC = 30.0, 70.0, 200.0


@pytest.fixture(scope="module")
def village() -> RoadMap:
    """A real place as a whole."""
    scene = SAMPLES[0]
    return convert(PipelineOptions(scene.osm, (scene.dem,)), Diagnostics()).road_map


def about(value: float) -> Any:
    """Return what equals a number but for rounding, fit for the fields of a record."""
    return pytest.approx(value)


def split(road_map: RoadMap) -> RoadMap:
    return keep_own_area(road_map, Diagnostics())


def both(road_map: RoadMap, x: float) -> tuple[RoadMap, RoadMap]:
    return split(halves_of(road_map, x, WEST)), split(halves_of(road_map, x, EAST))


def written(road_map: RoadMap, path: Path) -> Path:
    with path.open("wb") as stream:
        write_xodr(road_map, stream, WriteOptions(name="half"), Diagnostics())
    return path


def ends_of(road_map: RoadMap) -> tuple[BorderEnd, ...]:
    assert road_map.border_ends is not None
    return road_map.border_ends


def widths_at(road_map: RoadMap, end: BorderEnd) -> dict[int, float]:
    """Return the widths of the lanes that have any at an end of a road."""
    k = index(road_map, end.road)
    section = road_map.roads[k].lane_sections[0 if end.at_start else -1]
    s = 0.0 if end.at_start else lengths(road_map.plan_view)[k] - section.s
    out = {}
    for item in section.lanes:
        holding = max((c for c in item.widths if c.s <= s + 1e-9), key=lambda c: c.s, default=None)
        if holding is not None and abs(holding.at(s - holding.s)) > 1e-6:
            out[item.id] = holding.at(s - holding.s)
    return out


def index(road_map: RoadMap, road: int) -> int:
    return [item.id for item in road_map.roads].index(road)


def at_end(road_map: RoadMap, end: BorderEnd) -> dict[str, float]:
    """Return what a road is like at one of its ends, worked out from its tables."""
    k = np.array([index(road_map, end.road)])
    s = np.array([0.0 if end.at_start else lengths(road_map.plan_view)[k[0]]])
    x, y, hdg = pose(road_map.plan_view, k, s)
    return {
        "x": float(x[0]),
        "y": float(y[0]),
        "hdg": float(hdg[0]),
        "z": float(cubic_value(road_map.elevation, k, s)[0]),
        "grade": float(cubic_slope(road_map.elevation, k, s)[0]),
        "superelevation": float(cubic_value(road_map.superelevation, k, s)[0]),
        "offset": float(cubic_value(road_map.lane_offset, k, s)[0]),
    }


def assert_halves_meet(west: RoadMap, east: RoadMap) -> int:
    """Check that each end at the border has another half that goes on alike; return their number."""
    others = list(ends_of(east))
    for end in ends_of(west):
        near = min(others, key=lambda other: math.hypot(other.x - end.x, other.y - end.y))
        others.remove(near)
        assert near.at_start != end.at_start
        assert near.osm_way_ids == end.osm_way_ids
        here, there = at_end(west, end), at_end(east, near)
        turn = float(wrapped(np.array([here.pop("hdg") - there.pop("hdg")]))[0])
        assert abs(turn) < 1e-9
        assert here == pytest.approx(there, rel=0, abs=1e-6)
        assert widths_at(west, end) == pytest.approx(widths_at(east, near), rel=0, abs=1e-6)
        assert (end.x, end.y, end.z) == (here["x"], here["y"], here["z"])
    assert others == []
    return len(ends_of(west))


# ---------------------------------------------------------------- a map made by hand


def test_a_line_is_cut_where_the_border_is() -> None:
    west, east = both(crossing(), BEFORE_SECTION)
    assert [road.id for road in west.roads] == [1000]
    assert [road.id for road in east.roads] == [50_000, 50_001, 50_002, 50_003]
    assert [junction.id for junction in east.junctions] == [50_004]
    assert west.junctions == ()
    cut = ends_of(west)[0].x
    assert cut == pytest.approx(BEFORE_SECTION, abs=1.0)
    assert ends_of(west) == (BorderEnd(1000, False, "east", cut, 0.0, 1000.0 + 0.02 * cut, 0.0, (111, 112)),)
    assert ends_of(east) == (BorderEnd(50_000, True, "west", cut, 0.0, 1000.0 + 0.02 * cut, 0.0, (111, 112)),)
    assert lengths(west.plan_view) == pytest.approx([cut], abs=1e-12)
    assert lengths(east.plan_view)[0] == pytest.approx(100.0 - cut, abs=1e-12)
    assert west.roads[0].successor is None
    assert east.roads[0].predecessor is None
    assert east.roads[0].successor == RoadLink(True, 50_004)
    assert west.borders is None
    assert west.places is None
    assert assert_halves_meet(west, east) == 1


def test_types_and_lane_sections_begin_with_their_piece() -> None:
    west, east = both(crossing(), BEFORE_SECTION)
    cut = ends_of(west)[0].x
    assert west.roads[0].types == (RoadType(0.0, "town", 50.0 / 3.6),)
    assert [item.s for item in east.roads[0].types] == [0.0, 60.0 - cut]
    assert [item.type for item in east.roads[0].types] == ["town", "townExpressway"]
    assert [item.s for item in east.roads[0].lane_sections] == [0.0, 60.0 - cut]
    # The lanes of the western half lead to none, those of the eastern half still from one section to the next.
    assert [item.successor for item in west.roads[0].lane_sections[0].lanes] == [None, None, None]
    first, second = east.roads[0].lane_sections
    assert [item.successor for item in first.lanes] == [1, None, -1]
    assert [item.predecessor for item in second.lanes] == [1, None, -1, None]
    assert second.lanes == crossing().roads[0].lane_sections[1].lanes


def test_widths_go_on_as_the_same_cubic() -> None:
    whole = crossing()
    west, east = both(whole, BEHIND_SECTION)
    cut = ends_of(west)[0].x
    assert BEHIND_SECTION - 1 < cut < BEHIND_SECTION
    bus = whole.roads[0].lane_sections[1].lanes[-1].widths
    before, after = (item.roads[0].lane_sections[k].lanes[-1].widths for item, k in ((west, -1), (east, 0)))
    assert before == (bus[0],)
    u = cut - 60.0
    assert [item.s for item in after] == [0.0, pytest.approx(20.0 - u)]
    for ds in (0.0, 1.0, 20.0 - u):
        assert after[0].at(ds) == pytest.approx(bus[0].at(u + ds), abs=1e-14)
    assert after[1] == Cubic(about(20.0 - u), 1.0)
    # Speeds and marks stay.
    assert [item.speed for item in east.roads[0].lane_sections[0].lanes] == [None, None, 30.0 * 0.44704, math.inf]
    assert assert_halves_meet(west, east) == 1


def test_an_arc_and_its_cubics_go_on_as_the_same() -> None:
    whole = crossing()
    west, east = both(whole, IN_ARC)
    end = ends_of(west)[0]
    # Half-way round: x = 190 + 20 sin(turn).
    turn = math.asin((end.x - 190.0) / 20.0)
    assert end.hdg == pytest.approx(turn, abs=1e-12)
    assert end.y == pytest.approx(20.0 * (1 - math.cos(turn)), abs=1e-12)
    assert east.plan_view.curvature.tolist() == [0.05]
    assert east.plan_view.s.tolist() == [0.0]
    s = np.linspace(0.0, float(lengths(east.plan_view)[0]), 5)
    road, there, ds = np.zeros(5, np.int64), np.ones(5, np.int64), 80.0 + 20.0 * turn
    for table in ("elevation", "superelevation", "lane_offset"):
        for what in (cubic_value, cubic_slope):
            expected = what(getattr(whole, table), there, s + ds)
            assert what(getattr(east, table), road, s) == pytest.approx(expected, abs=1e-12)
    assert [road.id for road in west.roads] == [1000, 1001, 1002, 1003]
    assert assert_halves_meet(west, east) == 1


def test_a_cut_where_records_and_sections_begin_leaves_no_slivers() -> None:
    whole = crossing()
    borders = halves_of(whole, BEFORE_SECTION, EAST).borders
    assert borders is not None
    for cut in (60.0 - 0.004, 60.0, 60.0 + 0.004):
        cuts = np.array([0.0, cut, 0.0])
        west, east = (
            split(
                replace(whole, borders=replace(borders, piece_s=cuts, partition=replace(borders.partition, own=own)))
            )
            for own in (WEST, EAST)
        )
        assert [section.s for section in west.roads[0].lane_sections] == [0.0]
        assert [section.s for section in east.roads[0].lane_sections] == [0.0]
        assert len(west.roads[0].types) == len(east.roads[0].types) == 1
        # The lane that opens behind the section's start is that of the eastern half alone.
        assert [item.id for item in west.roads[0].lane_sections[0].lanes] == [1, 0, -1]
        assert [item.id for item in east.roads[0].lane_sections[0].lanes] == [1, 0, -1, -2]
        assert all(item.widths[0].s == 0.0 for item in east.roads[0].lane_sections[0].lanes if item.id)
        assert assert_halves_meet(west, east) == 1


def test_a_lane_without_width_on_its_piece_is_none_of_it() -> None:
    whole = crossing()
    first, second = whole.roads[0].lane_sections
    late = replace(second.lanes[-1], widths=(Cubic(0.0, 0.0), Cubic(20.0, 0.0, 0.0, 0.03, -0.002), Cubic(30.0, 1.0)))
    road = replace(whole.roads[0], lane_sections=(first, LaneSection(60.0, (*second.lanes[:-1], late))))
    west, east = both(replace(whole, roads=(road, *whole.roads[1:])), BEHIND_SECTION)
    assert [item.id for item in west.roads[0].lane_sections[-1].lanes] == [1, 0, -1]
    assert [item.id for item in east.roads[0].lane_sections[0].lanes] == [1, 0, -1, -2]
    assert assert_halves_meet(west, east) == 1


@given(st.floats(min_value=0.5, max_value=209.5))
def test_halves_meet_wherever_the_border_is(x: float) -> None:
    west, east = both(crossing(), x)
    assert assert_halves_meet(west, east) == 1
    assert sum(float(lengths(half.plan_view).sum()) for half in (west, east)) == pytest.approx(
        200.0 + 10.0 * math.pi, abs=1e-9
    )


def test_roads_and_the_junctions_that_they_touch_are_of_one_area() -> None:
    whole = halves_of(crossing(), BEFORE_SECTION, EAST)
    assert whole.borders is not None
    wrong = replace(whole.borders, piece_area=np.full(3, WEST))
    with pytest.raises(ValueError, match="road 1 and the junction that it touches belong to different areas"):
        split(replace(whole, borders=wrong))


def test_junctions_keep_their_ways_under_new_ids() -> None:
    _, east = both(crossing(), BEFORE_SECTION)
    junction = east.junctions[0]
    assert [(item.incoming_road, item.connecting_road) for item in junction.connections] == [
        (50_000, 50_002),
        (50_001, 50_003),
    ]
    assert [item.lane_links for item in junction.connections] == [((-1, -1),), ((1, -1),)]
    assert junction.priorities == ((50_000, 50_001),)
    assert junction.osm_node_ids == (99,)
    assert [road.junction for road in east.roads] == [None, None, 50_004, 50_004]
    assert east.roads[2].predecessor == RoadLink(False, 50_000, False)
    assert east.roads[2].successor == RoadLink(False, 50_001, True)


def ring() -> RoadMap:
    """Make two half circles of radius 50 m that make a ring, the one in the south first; both run anticlockwise."""
    arc, k = 50.0 * math.pi, 1 / 50.0
    road = Road(
        1,
        "",
        None,
        RoadLink(False, 2, at_start=False),
        RoadLink(False, 2, at_start=True),
        (),
        (LaneSection(0.0, (lane(1, 1, 1), centre(), lane(-1, -1, -1))),),
        (7,),
    )
    other = replace(
        road, id=2, predecessor=RoadLink(False, 1, at_start=False), successor=RoadLink(False, 1, at_start=True)
    )
    return RoadMap(
        FRAME,
        Rule.RIGHT_HAND,
        (road, other),
        (),
        plan_view([[(0.0, -50.0, 0.0, -math.pi / 2, arc, k)], [(0.0, 50.0, 0.0, math.pi / 2, arc, k)]]),
        profile([[(0.0, 5.0, 0.0, 0.0, 0.0)]] * 2),
        profile([[], []]),
        profile([[], []]),
    )


def test_a_ring_that_is_cut_stays_linked_where_it_is_not() -> None:
    west, east = both(ring(), 10.0)
    first, second = west.roads
    # The west has the start of the first half and the end of the second one.
    assert (first.predecessor, first.successor) == (RoadLink(False, 1001, at_start=False), None)
    assert (second.predecessor, second.successor) == (None, RoadLink(False, 1000, at_start=True))
    assert [item.predecessor for item in first.lane_sections[0].lanes] == [1, None, -1]
    assert [item.successor for item in first.lane_sections[0].lanes] == [None, None, None]
    assert [(end.road, end.at_start) for end in ends_of(west)] == [(1000, False), (1001, True)]
    assert assert_halves_meet(west, east) == 2


def test_roads_of_two_areas_that_are_linked_end_at_the_border() -> None:
    whole = ring()
    nothing = np.zeros(0, np.int64)
    partition = halves_of(whole, 10.0, WEST).borders
    assert partition is not None
    borders = Borders(partition.partition, np.array([0, 1, 2]), np.zeros(2), np.array([WEST, EAST]), nothing)
    south = split(replace(whole, borders=borders))
    assert [road.id for road in south.roads] == [1000]
    assert (south.roads[0].predecessor, south.roads[0].successor) == (None, None)
    lanes = south.roads[0].lane_sections[0].lanes
    assert {(item.predecessor, item.successor) for item in lanes} == {(None, None)}
    assert [(end.road, end.at_start, end.neighbour) for end in ends_of(south)] == [
        (1000, True, "east"),
        (1000, False, "east"),
    ]


def test_a_border_to_nowhere_has_no_name() -> None:
    whole = halves_of(crossing(), BEFORE_SECTION, EAST)
    assert whole.borders is not None
    areas = np.where(whole.borders.piece_area == WEST, -1, whole.borders.piece_area)
    east = split(replace(whole, borders=replace(whole.borders, piece_area=areas)))
    assert [end.neighbour for end in ends_of(east)] == [""]


def test_a_map_without_borders_stays_as_it_is() -> None:
    whole = crossing()
    assert split(whole) is whole
    assert whole.border_ends is None


def test_too_many_roads_for_the_ids() -> None:
    east = halves_of(crossing(), BEFORE_SECTION, EAST, (20, 16))
    with pytest.raises(InputError) as error:
        split(east)
    assert str(error.value) == ("area 'east' has 5 roads and junctions, more than it has ids for; use smaller tiles")
    assert [road.id for road in split(halves_of(crossing(), BEFORE_SECTION, EAST, (21, 16))).roads] == [
        16,
        17,
        18,
        19,
    ]
    with pytest.raises(InputError, match="5 roads and junctions"):
        split(halves_of(crossing(), BEFORE_SECTION, EAST, (1, 2**31 - 4)))


def test_too_many_signals_for_the_ids() -> None:
    with pytest.raises(InputError, match=r"area .east. has 7 signals, objects, bridges and tunnels, more than"):
        split(halves_of(furnished_crossing(), BEFORE_SECTION, EAST, (7, 1)))


def test_an_area_without_roads() -> None:
    with pytest.raises(InputError) as error:
        split(halves_of(crossing(), -10.0, WEST))
    assert str(error.value) == "area 'west' has no road of its own; leave it out"


def test_the_elevation_report_is_that_of_the_own_roads() -> None:
    places = (RoadPlace(1, 111, 80.0, 6.0, 0.0), RoadPlace(1, 111, 10.0, 5.0, 0.0), RoadPlace(2, 113, 5.0, 4.0, 0.0))
    bridge = StructureRecord("bridge", (113,), (2,), 30.0, 6.0, 4.0, 3, 0.02, 0.1)
    over = LayerCrossing(2, 1, 113, 111, 4.0, 5.2)
    told = ElevationReport(0.1, 0.2, 0.3, places, places[:1], (bridge,), (over,))
    figures = {
        "road_km": 9.0,
        "connecting_road_km": 9.0,
        "grade_max": 9.0,
        "height_above_surface_rms_m": 0.9,
        "layer_crossings": 9.0,
        "structures": 9.0,
        "priorities": 9.0,
    }
    west, east = both(replace(crossing(), elevation_report=told, statistics=figures), BEFORE_SECTION)
    cut = ends_of(west)[0].x
    assert west.elevation_report == replace(
        told, farthest=(RoadPlace(1000, 111, 10.0, 5.0, 0.0),), steep=(), structures=(), tight=()
    )
    assert east.elevation_report == replace(
        told,
        farthest=(
            RoadPlace(50_000, 111, about(80.0 - cut), 6.0, 0.0),
            RoadPlace(50_001, 113, 5.0, 4.0, 0.0),
        ),
        steep=(RoadPlace(50_000, 111, about(80.0 - cut), 6.0, 0.0),),
        structures=(replace(bridge, roads=(50_001,)),),
        # They are nearest to each other where road 1 ends.
        tight=(replace(over, upper=50_001, lower=50_000),),
    )
    # The steepest place is within the arc, where the slope is a parabola: 0.02 - 2e-4 ds + 6e-7 ds².
    assert west.statistics == pytest.approx(
        {
            "road_km": cut / 1000,
            "connecting_road_km": 0.0,
            "grade_max": 0.02,
            "height_above_surface_rms_m": 0.9,
            "structures": 0.0,
            "priorities": 0.0,
        }
    )
    assert east.statistics == pytest.approx(
        {
            "road_km": (180.0 - cut + 10.0 * math.pi) / 1000,
            "connecting_road_km": 0.02,
            "grade_max": 0.02,
            "height_above_surface_rms_m": 0.9,
            "structures": 1.0,
            "priorities": 1.0,
        }
    )


def test_the_report_names_the_ends() -> None:
    west, _ = both(crossing(), BEFORE_SECTION)
    figures = Statistics(1, 0, 0, 30.0, 0.0, 0.0, 0.0, None)
    document = json.loads(report({}, [], figures, None, Diagnostics(), {}, ends_of(west)).decode())
    end = ends_of(west)[0]
    assert document["border_ends"] == [
        {
            "road": 1000,
            "at_start": False,
            "neighbour": "east",
            "x": end.x,
            "y": 0.0,
            "z": end.z,
            "hdg": 0.0,
            "osm_way_ids": [111, 112],
        }
    ]
    assert "border_ends" not in json.loads(report({}, [], figures, None, Diagnostics(), {}).decode())


# ---------------------------------------------------------------- a real place


def test_an_area_that_has_all_is_written_as_without_borders(village: RoadMap, tmp_path: Path) -> None:
    kept = split(alone(village))
    assert written(kept, tmp_path / "kept.xodr").read_bytes() == written(village, tmp_path / "all.xodr").read_bytes()
    assert kept.furniture.statistics == village.furniture.statistics
    assert kept.elevation_report == village.elevation_report
    assert kept.border_ends == ()
    known = {name: value for name, value in village.statistics.items() if name in kept.statistics}
    # Counted again from what is written, which joins elements of nearly the same grade.
    steepest = kept.statistics["grade_max"], known.pop("grade_max")
    assert steepest[0] == pytest.approx(steepest[1], abs=5e-4)
    rest = {name: value for name, value in kept.statistics.items() if name != "grade_max"}
    assert rest == pytest.approx(known, abs=1e-5)
    assert set(village.statistics) - set(kept.statistics) == {
        "grade_over_class_limit_km",
        "junction_tilt_max",
        "layer_crossings",
        "junctions_with_signals",
        "junctions_with_priorities",
        "all_way_stops",
        "roundabout_entries",
        "signs_followed",
    }


def test_halves_of_a_real_place_meet(village: RoadMap, tmp_path: Path) -> None:
    x = float(np.median(village.plan_view.x))
    halves = both(village, x)
    assert assert_halves_meet(*halves) > 10
    for half, first in zip(halves, FIRST, strict=True):
        ids = [road.id for road in half.roads] + [junction.id for junction in half.junctions]
        assert ids == list(range(first, first + len(ids)))
        path = written(half, tmp_path / f"{first}.xodr")
        found = check_drive(read_xodr(path), CheckOptions())
        assert [item for item in found.findings if item.severity is Severity.ERROR] == []
        assert schema_errors(path, "1.7") == []
    assert_nothing_is_lost(village, halves)


def test_stripes_cut_roads_several_times(village: RoadMap) -> None:
    halves = split(stripes_of(village, 200.0, WEST)), split(stripes_of(village, 200.0, EAST))
    assert assert_halves_meet(*halves) > 100
    assert_nothing_is_lost(village, halves)
    assert float(np.concatenate([half.plan_view.length for half in halves]).min()) > 1e-3
    for half in halves:
        for k, road in enumerate(half.roads):
            starts = [section.s for section in road.lane_sections]
            assert starts[0] == 0.0
            assert all(b - a > 0.009 for a, b in pairwise([*starts, float(lengths(half.plan_view)[k])]))


def assert_nothing_is_lost(whole: RoadMap, halves: tuple[RoadMap, RoadMap]) -> None:
    """Check that all that a map has is in exactly one of two parts of it."""
    assert sum(float(lengths(half.plan_view).sum()) for half in halves) == pytest.approx(
        float(lengths(whole.plan_view).sum()), abs=1e-6
    )
    nodes = [junction.osm_node_ids for half in halves for junction in half.junctions]
    assert sorted(nodes) == sorted(junction.osm_node_ids for junction in whole.junctions)
    assert len(halves[0].roads) + len(halves[1].roads) == len(whole.roads) + len(ends_of(halves[0]))
    for name in ("road_km", "connecting_road_km", "priorities"):
        assert sum(half.statistics[name] for half in halves) == pytest.approx(whole.statistics[name], abs=1e-9)
    for name in whole.furniture.statistics:
        assert sum(half.furniture.statistics[name] for half in halves) == whole.furniture.statistics[name]
    # Each stands where it stood.
    expected = sorted(standing(whole))
    found = sorted(place for half in halves for place in standing(half))
    assert len(found) == len(expected)
    assert np.array(found) == pytest.approx(np.array(expected), abs=1e-6)


def standing(road_map: RoadMap) -> list[tuple[float, float, float]]:
    """Return x and y, rounded, and curvature of the road, of all signals and objects without copies."""
    things = [(item.road, item.s, item.t) for item in road_map.furniture.signals]
    things += [(item.road, item.s, item.t) for item in road_map.furniture.objects if item.repeat is None]
    curve = np.array([index(road_map, road) for road, _, _ in things])
    s, t = np.array([(s, t) for _, s, t in things]).T
    x, y, hdg = pose(road_map.plan_view, curve, s)
    columns = x - t * np.sin(hdg), y + t * np.cos(hdg), curvature_at(road_map.plan_view, curve, s)
    return list(zip(*(np.round(column, 6).tolist() for column in columns), strict=True))
