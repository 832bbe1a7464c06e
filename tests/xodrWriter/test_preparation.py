"""Road maps that no stage should make are refused, not written.

Arcs and spirals that are too flat for readers to compute with.

Lanes for buses and for cars that lead to one lane.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from sample_road_maps import centre, crossing, furnished_crossing, lane, plan_view, profile, straight_roads

from osm2xodr.conventions import TARGETS
from osm2xodr.curves import pose
from osm2xodr.errors import OutputError
from osm2xodr.model import (
    Connection,
    Furniture,
    LaneSection,
    LaneType,
    ObjectRepeat,
    PlanView,
    Road,
    RoadLink,
    RoadMap,
    RoadObject,
    RoadStructure,
)
from osm2xodr.xodrWriter.formatting import Words
from osm2xodr.xodrWriter.options import DIALECTS
from osm2xodr.xodrWriter.preparation import LARGEST_RADIUS, check_road_map, with_exits_for_all, without_flat_curves

SUMO = Words(DIALECTS["1.7"], TARGETS["sumo"].lane_types)


def test_a_sound_map_gives_its_lengths() -> None:
    assert check_road_map(crossing()) == pytest.approx([100.0, 80.0 + 10.0 * np.pi, 10.0, 10.0])


def no_roads() -> RoadMap:
    return straight_roads(0)


def repeated_id() -> RoadMap:
    one = straight_roads(2)
    return replace(one, roads=(one.roads[0], one.roads[0]))


def junction_with_the_id_of_a_road() -> RoadMap:
    one = crossing()
    return replace(one, junctions=(replace(one.junctions[0], id=1),))


def id_zero() -> RoadMap:
    one = straight_roads(1)
    return replace(one, roads=(replace(one.roads[0], id=0),))


def table_too_short() -> RoadMap:
    return replace(straight_roads(3), lane_offset=profile([[], []]))


def no_geometry() -> RoadMap:
    one = straight_roads(2)
    record = (0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
    return replace(one, plan_view=plan_view([[record, record], []]))


def no_height() -> RoadMap:
    one = straight_roads(2)
    return replace(one, elevation=profile([[], [(0.0, 1.0, 0.0, 0.0, 0.0)]]))


def no_length() -> RoadMap:
    one = straight_roads(2)
    return replace(one, plan_view=replace(one.plan_view, length=np.array([1.0, 0.0])))


def infinite_position() -> RoadMap:
    one = straight_roads(2)
    return replace(one, plan_view=replace(one.plan_view, x=np.array([np.inf, 0.0])))


def infinite_slope() -> RoadMap:
    return replace(
        straight_roads(2), elevation=profile([[(0.0, 1.0, 0.0, 0.0, 0.0)], [(0.0, 1.0, np.inf, 0.0, 0.0)]])
    )


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (no_roads, "there is no road to write"),
        (repeated_id, "ids of their own above 0"),
        (junction_with_the_id_of_a_road, "ids of their own above 0"),
        (id_zero, "ids of their own above 0"),
        (table_too_short, "the tables of a road map do not fit its roads"),
        (no_geometry, r"road 2 \(way/102\) has no geometry"),
        (no_height, r"road 1 \(way/101\) has no height"),
        (no_length, "a road or a piece of one has no length"),
        (infinite_position, r"road 1 \(way/101\) has a number that is not finite in its plan view"),
        (infinite_slope, r"road 2 \(way/102\) has a number that is not finite in its elevation"),
    ],
)
def test_defects(make: object, message: str) -> None:
    assert callable(make)
    with pytest.raises(OutputError, match=message + ".*please report it"):
        check_road_map(make())


# ---------------------------------------------------------------- furniture

FURNITURE = furnished_crossing().furniture


def test_sound_furniture_passes() -> None:
    assert len(check_road_map(furnished_crossing())) == 4
    assert len(check_road_map(crossing())) == 4


def signal_of_no_road() -> Furniture:
    return replace(FURNITURE, signals=(replace(FURNITURE.signals[0], road=77), *FURNITURE.signals[1:]))


def signal_behind_the_end() -> Furniture:
    return replace(FURNITURE, signals=(replace(FURNITURE.signals[0], s=100.1), *FURNITURE.signals[1:]))


def reference_before_the_start() -> Furniture:
    return replace(FURNITURE, references=(replace(FURNITURE.references[0], s=-1.0),))


def repeat_behind_the_end() -> Furniture:
    fence = ObjectRepeat(10.0, 95.0, 0.0, 5.0, 5.0, 0.1, 1.0)
    return Furniture(objects=(RoadObject(1, 1, "barrier", "", "", 10.0, 5.0, repeat=fence, osm_id="way/9"),))


def bridge_behind_the_end() -> Furniture:
    return Furniture(structures=(RoadStructure(1, 1, 50.0, 51.0, "bridge", "steel"),))


def controller_of_nothing() -> Furniture:
    return replace(FURNITURE, controllers=(replace(FURNITURE.controllers[0], signals=()),))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (signal_of_no_road, r"signal 1 \(node/42\) stands on road 77, which is not there"),
        (signal_behind_the_end, r"signal 1 \(node/42\) does not stand within the 100\.000 m of road 1: s 100\.100"),
        (reference_before_the_start, r"a reference to signal 1 does not stand within the 10\.000 m of road 3"),
        (repeat_behind_the_end, r"object 1 \(way/9\) does not stand within the 100\.000 m of road 1"),
        (bridge_behind_the_end, r"bridge 1 does not stand within the 100\.000 m of road 1: s 50\.000"),
        (controller_of_nothing, "controller 1 has no signal"),
    ],
)
def test_defects_of_furniture(make: Callable[[], Furniture], message: str) -> None:
    road_map: RoadMap = replace(furnished_crossing(), furniture=make())
    with pytest.raises(OutputError, match=message + ".*this is a defect of osm2xodr"):
        check_road_map(road_map)


def one_arc(length: float, radius: float, rate: float = 0.0) -> PlanView:
    """A curve of one record that starts at (3, 4)."""
    values = [np.array([value]) for value in (0.0, 3.0, 4.0, 0.5, length, 1.0 / radius, rate)]
    return PlanView(np.array([0, 1]), *values)


@pytest.mark.parametrize(
    ("radius", "length", "count"),
    [
        (32e6, 130.0, 1),
        (-1e6, 70.0, 1),
        # 74.8 m of such an arc lie within 0.7 mm of a line.
        (1e6, 100.0, 2),
        (-300e3, 150.0, 4),
        (200.1e3, 160.0, 5),
    ],
)
def test_flat_arcs_become_lines_along_them(radius: float, length: float, count: int) -> None:
    plan = one_arc(length, radius)
    found = without_flat_curves(plan)
    assert found.start.tolist() == [0, count]
    assert found.curvature.tolist() == [0.0] * count
    assert found.length.tolist() == pytest.approx([length / count] * count, abs=1e-12)
    assert found.s == pytest.approx(np.arange(count) * length / count, abs=1e-12)
    s = np.linspace(0.0, length, 33)
    (x, y, hdg), (x0, y0, hdg0) = (pose(item, np.zeros(33, int), s) for item in (found, plan))
    off = np.hypot(x - x0, y - y0)
    assert 0.1e-3 * (abs(radius) < 1e7) < off.max() < 1e-3
    assert off[0] < 1e-9
    assert off[-1] < 1e-6
    assert np.abs(hdg - hdg0).max() < 1e-4
    assert np.rad2deg(np.abs(np.diff(found.hdg))).max(initial=0.0) < 0.01


def test_other_records_stay() -> None:
    for plan in (
        one_arc(50.0, 0.99 * LARGEST_RADIUS),
        one_arc(12.0, 1e6, 1e-6),
        one_arc(50.0, 5e5, 1e-6),
        one_arc(50.0, np.inf),
    ):
        assert without_flat_curves(plan) is plan


def test_neighbours_of_flat_arcs_stay() -> None:
    values = [[0.0, 50.0, 150.0], [0.0, 50.0, 150.0], [0.0] * 3, [0.0] * 3, [50.0, 100.0, 20.0], [0.0, 1e-6, 0.01]]
    plan = PlanView(np.array([0, 1, 3]), *(np.array(item) for item in values))
    found = without_flat_curves(plan)
    assert found.start.tolist() == [0, 1, 4]
    assert found.curvature.tolist() == [0.0, 0.0, 0.0, 0.01]
    assert found.hdg.tolist() == pytest.approx([0.0, 25e-6, 75e-6, 0.0], abs=1e-12)


# What esmini and libOpenDRIVE take for 0, 1/m.
SMALL = 1e-6


def as_read(plan: PlanView) -> PlanView:
    """The records as esmini 3.6 reads them: spirals that hardly bend are lines or arcs, others may begin straight."""
    change = plan.rate * plan.length
    curvature = np.where((plan.rate != 0.0) & (np.abs(plan.curvature) < SMALL), 0.0, plan.curvature)
    return replace(plan, curvature=curvature, rate=np.where(np.abs(change) < SMALL, 0.0, plan.rate))


@pytest.mark.parametrize(
    ("length", "start", "end"),
    [
        # A road of Portland.
        (783.55, 3.44e-7, -1.59e-7),
        (400.0, 0.004, 0.004 + 9e-7),
        (300.0, 8e-7, 2e-3),
        (300.0, -8e-7, 2e-3),
        (900.0, -9e-7, 1.5e-6),
        (20.0, 9e-7, 0.04),
        (3000.0, 0.0, 9e-7),
        # Hardly more than a line.
        (250.0, 2e-8, 3e-8),
    ],
)
def test_readers_meet_the_places_of_flat_spirals(length: float, start: float, end: float) -> None:
    plan = one_arc(length, np.inf, (end - start) / length)
    plan = replace(plan, curvature=np.array([start]))
    found = without_flat_curves(plan)
    s = np.linspace(0.0, length, 41)
    zero = np.zeros(41, int)
    x0, y0, hdg0 = pose(plan, zero, s)
    wrong = pose(as_read(plan), zero, s)
    assert np.hypot(wrong[0] - x0, wrong[1] - y0).max() > 1.2e-4
    for read in (found, as_read(found)):
        x, y, hdg = pose(read, zero, s)
        off = np.hypot(x - x0, y - y0)
        assert off.max() < 1.2e-3
        assert off[-1] < 2e-5
        # The last line of a flat arc has the heading of its middle.
        assert abs(hdg[-1] - hdg0[-1]) < 1e-4
    # Records begin where those before them end.
    joints = np.arange(1, len(found.s))
    x, y, hdg = pose(found, np.zeros(len(joints), int), found.s[joints] - 1e-9)
    assert np.hypot(x - found.x[joints], y - found.y[joints]).max() < 2e-5
    assert found.length.sum() == pytest.approx(length, abs=1e-9)
    assert found.length.min() >= 0.24
    # ASAM's checker calls lines that go on in the same direction redundant.
    lines = (found.curvature == 0.0) & (found.rate == 0.0)
    assert np.abs(np.diff(found.hdg))[lines[1:] & lines[:-1]].min(initial=1.0) > 1e-6


def two_lanes_to_one(bus_exit: int = -1) -> RoadMap:
    """`crossing` with a way from the bus lane of road 1, road 6, to a lane of road 2 as well."""
    found = crossing()
    ways = (
        LaneSection(0.0, (centre(None), lane(-1, -2, -3, None))),
        LaneSection(4.0, (centre(None), lane(-3, -1, bus_exit))),
    )
    added = Road(6, "", 5, RoadLink(False, 1, False), RoadLink(False, 2, True), (), ways, ())
    (junction,) = found.junctions
    connections = (*junction.connections, Connection(2, 1, 6, ((-2, -1),)))
    line: list[tuple[float, ...]] = [(0.0, 0.0, 0.0, 0.0, 10.0, 0.0)]
    return replace(
        found,
        roads=(*found.roads, added),
        junctions=(replace(junction, connections=connections),),
        plan_view=plan_view([line] * 5),
        elevation=profile([[]] * 5),
        superelevation=profile([[]] * 5),
        lane_offset=profile([[]] * 5),
    )


def lane_types(road_map: RoadMap) -> list[list[LaneType]]:
    """Types of the lanes of all connecting roads but their centre, section after section."""
    return [
        [item.type for section in road.lane_sections for item in section.lanes if item.id]
        for road in road_map.roads
        if road.junction is not None
    ]


def test_a_way_for_buses_gives_way_to_one_for_cars() -> None:
    found = with_exits_for_all(two_lanes_to_one(), SUMO)
    driving, shoulder = LaneType.DRIVING, LaneType.SHOULDER
    assert lane_types(found) == [[driving], [driving], [shoulder, shoulder]]
    assert found.junctions == two_lanes_to_one().junctions


def test_a_way_for_buses_to_a_lane_of_its_own_stays() -> None:
    road_map = two_lanes_to_one(bus_exit=-2)
    assert with_exits_for_all(road_map, SUMO) is road_map


def test_ways_for_all_stay() -> None:
    """As where the lane beside is one for cars, and for readers that know lanes for buses."""
    road_map = two_lanes_to_one()
    assert with_exits_for_all(road_map, Words(DIALECTS["1.7"])) is road_map
    assert with_exits_for_all(road_map, Words(DIALECTS["1.4"], TARGETS["sumo"].lane_types)) is road_map
    first, *others = road_map.roads
    *before, last = first.lane_sections
    cars = replace(
        last, lanes=tuple(replace(item, type=LaneType.DRIVING) if item.id else item for item in last.lanes)
    )
    all_cars = replace(road_map, roads=(replace(first, lane_sections=(*before, cars)), *others))
    assert with_exits_for_all(all_cars, SUMO) is all_cars


@pytest.mark.parametrize("kind", [LaneType.BUS, LaneType.TAXI])
def test_without_a_lane_for_cars_buses_keep_their_way(kind: LaneType) -> None:
    road_map = two_lanes_to_one()
    first, *others = road_map.roads
    *before, last = first.lane_sections
    apart = replace(last, lanes=tuple(replace(item, type=kind) if item.id else item for item in last.lanes))
    road_map = replace(road_map, roads=(replace(first, lane_sections=(*before, apart)), *others))
    assert with_exits_for_all(road_map, SUMO) is road_map
