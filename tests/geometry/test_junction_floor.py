"""The floor of junctions when some of their sidewalks turn out too steep."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from floor_cases import connecting

from osm2xodr.curves import value_of_cubics
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import RoadOptions
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junction_floor import Floor, lay_floor
from osm2xodr.geometry.road_plan import RoadPlan, lay_out_sides, plan_roads
from osm2xodr.geometry.roads import floor_without, lay_out_floor
from osm2xodr.geometry.roadside import ends_instead
from osm2xodr.model import BoolArray, LaneType, Rule, StreetNetwork
from osm2xodr.osmParsing import ParseOptions, parse_osm

_SAMPLE = Path(__file__).parents[2] / "data" / "samples" / "andorra_ordino" / "area.osm"

Place = tuple[StreetNetwork, RoadPlan, ConnectingRoads, Floor]


@pytest.fixture(scope="module")
def place() -> Place:
    """Junctions with sidewalks round their corners, all roads through them, and their floor."""
    network = parse_osm(_SAMPLE, ParseOptions(), Diagnostics())
    plan = plan_roads(network, RoadOptions(), Diagnostics())
    through = plan.connecting.joined(lay_out_sides(network, plan).corners)
    return network, plan, through, lay_out_floor(network, plan, through)


def assert_same(one: Floor, other: Floor) -> None:
    assert (one.left, one.right) == (other.left, other.right)
    assert (one.paved_left, one.paved_right) == (other.paved_left, other.paved_right)
    assert [hole.road for hole in one.islands] == [hole.road for hole in other.islands]
    for hole, same in zip(one.islands, other.islands, strict=True):
        np.testing.assert_array_equal(hole.corners, same.corners)


def sidewalks(through: ConnectingRoads) -> BoolArray:
    return np.array([kind is LaneType.SIDEWALK for kind in through.lane_type], bool)


@pytest.mark.parametrize("share", [1, 2, 3])
def test_it_is_that_of_the_roads_that_are_left(place: Place, share: int) -> None:
    """Every sidewalk is left out, every other one, or every third."""
    network, plan, through, floor = place
    left_out = sidewalks(through)
    left_out[np.flatnonzero(left_out)[np.arange(int(left_out.sum())) % share > 0]] = False
    wanted = lay_out_floor(network, plan, through.chosen(~left_out))
    found = floor_without(network, plan, through, floor, left_out)
    assert_same(found, wanted)
    assert len(floor.left) + len(floor.right) != len(found.left) + len(found.right)


def test_sidewalks_of_corners_that_are_left_out_go_on_beside_lanes(place: Place) -> None:
    """As wide as on their arm, and to an end, but for those of corners that nobody turns round."""
    network, plan, _, _ = place
    sides = lay_out_sides(network, plan)
    corners = sides.corners.chosen(sidewalks(sides.corners))
    ends = ends_instead(plan.parts, sides.margins, plan.connecting, corners)
    arms = np.concatenate([corners.entry_width, corners.exit_width])
    # Most of those of one corner meet beside one edge, and are one.
    assert len(corners.length) < len(ends.row) < len(arms)
    for k in range(len(ends.row)):
        (kind, widths, height), *_ = reversed(list(ends.lanes(k, float(ends.length[k]))))
        assert (kind, height) == (LaneType.SIDEWALK, 0.12)
        begin, end = widths[0].a, value_of_cubics(widths, float(ends.length[k]))
        assert 0.1 <= max(begin, end) <= arms.max() + 1e-9
        assert min(begin, end) >= -1e-9


def test_islands_keep_the_order_of_their_junctions() -> None:
    """Three junctions side by side, each with lanes of 3 m round 6 m by 3 m."""
    around = ((-3, -1.5, 9, -1.5), (7.5, -3, 7.5, 6), (9, 4.5, -3, 4.5), (-1.5, 6, -1.5, -3))
    lines = [(x0 + dx, y0, x1 + dx, y1) for dx in (0.0, 50.0, 100.0) for x0, y0, x1, y1 in around]
    through = connecting(lines, [0] * 4 + [1] * 4 + [2] * 4)
    floor = lay_floor(through, Rule.RIGHT_HAND, is_island=lambda hole: True)
    number = np.arange(12)
    first, others = (floor.renumbered(np.where(rows, number, -1)) for rows in (number < 4, number >= 4))
    assert [hole.road // 4 for hole in others.islands] == [1, 2]
    assert_same(others.joined(first, through.junction), floor)


def test_nothing_is_laid_again_where_all_sidewalks_stay(place: Place) -> None:
    network, plan, through, floor = place
    assert floor_without(network, plan, through, floor, np.zeros(len(through.length), bool)) is floor
