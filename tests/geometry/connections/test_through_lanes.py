"""Lanes lead straight on where others open beside them, and through junctions."""

from __future__ import annotations

import pytest
from road_measures import RoadMeasures, assert_sound, profile_value
from street_cases import Case

from osm2xodr.geometry import defaults
from osm2xodr.model import RoadMap, Rule


def a_right_turn_lane() -> Case:
    """One way from west to east: a lane for right turns opens 60 m before a junction, and is not there behind it."""
    return Case(
        {"a": (-600.0, 0.0), "b": (-60.0, 0.0), "c": (0.0, 0.0), "d": (600.0, 0.0), "s": (0.0, -80.0)},
        {
            1: ("a b", "highway=secondary oneway=yes lanes=2 width=6 maxspeed=50"),
            2: ("b c", "highway=secondary oneway=yes lanes=3 width=9 turn:lanes=through|through|right maxspeed=50"),
            3: ("c d", "highway=secondary oneway=yes lanes=2 width=6 maxspeed=50"),
            4: ("c s", "highway=secondary oneway=yes lanes=1 width=3"),
        },
    )


def left_edge(roads: RoadMap, way: int, s: float) -> float:
    """Return t of the left edge of a one-way road, at s from its start, or from its end if negative, m."""
    road = next(item for item in roads.roads if way in item.osm_way_ids and item.junction is None)
    measures = RoadMeasures(roads)
    s = s if s >= 0.0 else measures.length(road) + s
    section = max(k for k, item in enumerate(road.lane_sections) if item.s <= s)
    return max(t for edges in measures.edges(road, section, s).values() for t in edges)


def test_a_short_stretch_with_a_turn_lane_shifts_as_a_whole() -> None:
    """About the middle of OSM's line its lanes would lie 1.5 m left of those before and behind: 1 m is taken back."""
    roads = a_right_turn_lane().build()
    assert_sound(roads)
    assert left_edge(roads, 1, 0.0) == pytest.approx(3.0)
    assert left_edge(roads, 2, -5.0) == pytest.approx(4.5 - defaults.IN_LINE_MOST_TURNS)
    assert left_edge(roads, 3, 200.0) == pytest.approx(3.0)


def test_traffic_on_the_left_is_the_mirror_image() -> None:
    right, left = a_right_turn_lane().build(), a_right_turn_lane().mirrored().build(Rule.LEFT_HAND)
    for way, s in ((1, -70.0), (2, -5.0), (3, 0.0)):
        # Seen from the other side, the left edge is the right one.
        width = 9.0 if way == 2 else 6.0
        assert left_edge(left, way, s) == pytest.approx(width - left_edge(right, way, s), abs=1e-6)


@pytest.mark.parametrize(("beside", "kept"), [(12.0, 1.0), (8.2, 0.5), (7.75, 0.05)])
def test_the_opposite_carriageway_keeps_its_room(beside: float, kept: float) -> None:
    """A lane for left turns opens toward it: the lanes that go on would be in line if it lay farther left."""
    tags = "highway=secondary oneway=yes maxspeed=50"
    case = Case(
        {
            "a": (-600.0, 0.0), "b": (-60.0, 0.0), "c": (0.0, 0.0), "d": (600.0, 0.0), "n": (0.0, beside),
            "w": (-600.0, beside), "e": (600.0, beside), "s": (0.0, 100.0),
        },
        {
            1: ("a b", f"{tags} lanes=2 width=6"),
            2: ("b c", f"{tags} lanes=3 width=9 turn:lanes=left|through|through"),
            3: ("c d", f"{tags} lanes=2 width=6"),
            4: ("e n w", f"{tags} lanes=2 width=6"),
            5: ("c n s", "highway=secondary lanes=2 width=6"),
        },
    )  # fmt: skip
    roads = case.build()
    assert_sound(roads)
    shift = kept * defaults.IN_LINE_MOST_TURNS
    assert left_edge(roads, 2, -5.0) == pytest.approx(4.5 + shift, abs=0.02)


def test_lanes_that_are_in_line_stay() -> None:
    nodes = {"a": (-300.0, 0.0), "b": (0.0, 0.0), "c": (300.0, 0.0), "s": (0.0, -80.0)}
    ways = {k: (path, "highway=secondary") for k, path in enumerate(("a b", "b c", "b s"), start=1)}
    roads = Case(nodes, ways).build()
    main = [k for k, road in enumerate(roads.roads) if road.junction is None]
    assert all(profile_value(roads.lane_offset, k, s) == 0.0 for k in main for s in (0.0, 50.0, 250.0))


def test_ramps_are_in_line_with_ramps_alone() -> None:
    """A ramp that joins lies beside the lanes of the motorway, wherever its line begins."""
    nodes = {"a": (-900.0, 0.0), "b": (0.0, 0.0), "c": (900.0, 0.0), "r": (-150.0, -20.0)}
    ways = {
        1: ("a b", "highway=motorway oneway=yes lanes=2"),
        2: ("b c", "highway=motorway oneway=yes lanes=3"),
        3: ("r b", "highway=motorway_link oneway=yes lanes=1"),
    }
    roads = Case(nodes, ways).build()
    assert left_edge(roads, 3, -1.0) == pytest.approx(left_edge(roads, 3, 1.0))
    main = {way: left_edge(roads, way, s) for way, s in ((1, -1.0), (2, 0.0))}
    # Half of the lane that is added lies left of the line, and half of the shift on either side.
    assert main[1] - 3.75 == pytest.approx(3.75 * 1.5 - main[2], abs=0.05)
    assert main[1] - 3.75 > 0.3
