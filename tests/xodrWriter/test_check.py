"""Road maps that no stage should make are refused, not written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from sample_road_maps import crossing, furnished_crossing, plan_view, profile, straight_roads

from osm2xodr.errors import OutputError
from osm2xodr.model import Furniture, ObjectRepeat, RoadMap, RoadObject, RoadStructure
from osm2xodr.xodrWriter.check import check_road_map


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
