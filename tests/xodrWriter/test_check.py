"""Road maps that no stage should make are refused, not written."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sample_road_maps import crossing, plan_view, profile, straight_roads

from osm2xodr.errors import OutputError
from osm2xodr.model import RoadMap
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
    ],
)
def test_defects(make: object, message: str) -> None:
    assert callable(make)
    with pytest.raises(OutputError, match=message + ".*please report it"):
        check_road_map(make())
