"""Boundaries of junctions: which lanes' edges and arms' end faces they consist of."""

from __future__ import annotations

import io
import math
from dataclasses import replace

import pytest
from lxml import etree
from sample_road_maps import crossing, plan_view

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import with_boundaries
from osm2xodr.model import BoundaryEdge, BoundaryJoint, Cubic, Lane, LaneSection, LaneType, RoadMap
from osm2xodr.xodrWriter import WriteOptions, write_xodr

END = math.inf


def bounded(road_map: RoadMap) -> tuple[BoundaryJoint | BoundaryEdge, ...]:
    return with_boundaries(road_map, Diagnostics()).junctions[0].boundary


def test_a_street_that_runs_through_is_bounded_by_both_of_its_ways() -> None:
    # The bus lane of the first arm ends at the junction: the boundary crosses the others alone.
    assert bounded(crossing()) == (
        BoundaryJoint(2, at_start=True),
        BoundaryEdge(4, -1, 0.0, END),
        BoundaryJoint(1, at_start=False, first_lane=1, last_lane=-1),
        BoundaryEdge(3, -1, 0.0, END),
    )


def test_sidewalks_lie_within() -> None:
    road_map = crossing()
    # As wide as the bus lane of the first arm.
    walk = Lane(-2, LaneType.SIDEWALK, (Cubic(0.0, 1.0),))
    roads = [
        replace(item, lane_sections=(LaneSection(0.0, (*item.lane_sections[0].lanes, walk)),))
        if item.id in (2, 3)
        else item
        for item in road_map.roads
    ]
    assert bounded(replace(road_map, roads=tuple(roads)))[2:] == (
        BoundaryJoint(1, at_start=False),
        BoundaryEdge(3, -2, 0.0, END),
    )


@pytest.mark.parametrize(("width", "lanes"), [(0.25, (1, -1)), (0.75, (None, None))])
def test_a_boundary_crosses_lanes_that_are_reached_to_their_middle(
    width: float, lanes: tuple[int | None, int | None]
) -> None:
    """Floor beside a way, as wide as said at the bus lane of the first arm, which is 1 m wide."""
    road_map = crossing()
    floor = Lane(-2, LaneType.BORDER, (Cubic(0.0, width, -width / 10.0),))
    roads = [
        replace(item, lane_sections=(LaneSection(0.0, (*item.lane_sections[0].lanes, floor)),))
        if item.id == 3
        else item
        for item in road_map.roads
    ]
    found = bounded(replace(road_map, roads=tuple(roads)))
    assert BoundaryJoint(1, False, *lanes) in found


def test_a_way_without_another_beside_it_bounds_its_junction_on_both_sides() -> None:
    road_map = crossing()
    one_way = replace(road_map.junctions[0], connections=road_map.junctions[0].connections[:1])
    roads = road_map.roads[:3]
    plan = plan_view(
        [
            [(0.0, 0.0, 0.0, 0.0, 100.0, 0.0)],
            [(0.0, 110.0, 0.0, 0.0, 80.0, 0.0), (80.0, 190.0, 0.0, 0.0, 5.0, 0.05)],
            [(0.0, 100.0, 0.0, 0.0, 10.0, 0.0)],
        ]
    )
    elevation = type(road_map.elevation)(
        road_map.elevation.start[:4],
        *(getattr(road_map.elevation, name)[: road_map.elevation.start[3]] for name in ("s", "a", "b", "c", "d")),
    )
    none = type(road_map.elevation)(road_map.elevation.start[:4] * 0, *[road_map.elevation.s[:0]] * 5)
    only = replace(
        road_map,
        roads=roads,
        junctions=(one_way,),
        plan_view=plan,
        elevation=elevation,
        superelevation=none,
        lane_offset=none,
    )
    assert bounded(only) == (
        BoundaryJoint(2, at_start=True, first_lane=-1, last_lane=-1),
        BoundaryEdge(3, 0, END, 0.0),
        BoundaryJoint(1, at_start=False, first_lane=-1, last_lane=-1),
        BoundaryEdge(3, -1, 0.0, END),
    )


def test_roads_that_do_not_meet_have_none_and_that_is_said() -> None:
    road_map = crossing()
    # The second way ends 3 m beside its arm.
    plan = road_map.plan_view
    y = plan.y.copy()
    y[-1] += 3.0
    found = Diagnostics()
    assert with_boundaries(replace(road_map, plan_view=replace(plan, y=y)), found).junctions[0].boundary == ()
    assert [(item.code, item.message) for item in found] == [
        ("junction-boundary", "1 of 1 junctions have no boundary: their roads leave gaps between arms")
    ]


@pytest.mark.parametrize(("version", "count"), [("1.7", 0), ("1.8", 4)])
def test_only_1_8_has_words_for_it(version: str, count: int) -> None:
    stream = io.BytesIO()
    road_map = with_boundaries(crossing(), Diagnostics())
    write_xodr(road_map, stream, WriteOptions(version), Diagnostics())
    rows = [dict(item.attrib) for item in etree.fromstring(stream.getvalue()).findall("junction/boundary/segment")]
    assert len(rows) == count
    assert rows[2:] == [] or rows[2:] == [
        {"type": "joint", "roadId": "1", "contactPoint": "end", "jointLaneStart": "1", "jointLaneEnd": "-1"},
        {"type": "lane", "roadId": "3", "boundaryLane": "-1", "sStart": "start", "sEnd": "end"},
    ]
