"""Where crossings lie, and which roads they cross."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from junction_cases import CASES
from light_cases import point, with_tags
from object_cases import footway, has_corners, node_at, road_of_way, said, side, with_footways, world_of
from street_cases import Case

from osm2xodr.furniture.objects.calming import crossing_objects
from osm2xodr.furniture.objects.crossings import find_crossings
from osm2xodr.furniture.world.world import Crossing, World
from osm2xodr.model import Rule, StreetNetwork

EITHER = pytest.mark.parametrize("rule", list(Rule))
STREET = {"w": (0.0, 0.0), "a": (50.0, 0.0), "b": (51.0, 0.0), "e": (100.0, 0.0)}
ROAD = Case(STREET, {1: ("w a b e", "lanes=2 width=7")})
X = CASES["x"].case
# 12 m before the middle of the junction on both sides, and 7 m and 2 m from it on one.
ARMS = Case(
    {**X.nodes, "wi": (-12.0, 0.0), "inner": (-7.0, 0.0), "near": (-2.0, 0.0), "ei": (12.0, 0.0)},
    {1: ("w wi inner near o", ""), 2: ("o ei e", ""), 3: ("s o", ""), 4: ("o n", "")},
)


def number(name: str) -> int:
    """Return the OSM id of a node of `ARMS`."""
    return 1001 + list(ARMS.nodes).index(name)


def found_at(world: World, crossing: Crossing) -> complex:
    return point(world.road_map, crossing.road, crossing.s, 0.5 * (crossing.left + crossing.right))


@pytest.mark.parametrize(
    ("tags", "width"),
    [
        ("crossing=traffic_signals", 4.0),
        ("crossing=marked", 3.0),
        ("crossing:width=2.5", 2.5),
        ("width=0.5", 1.83),
        ("width=wide", 3.0),
    ],
)
def test_crossings_are_as_wide_as_tagged_or_usual(tags: str, width: float) -> None:
    world = world_of(with_tags(ROAD, a=f"highway=crossing {tags}"))
    (crossing,) = find_crossings(world)
    assert crossing.width == width
    assert ("crossing-width" in said(world)) is ("width" not in tags)


@EITHER
def test_a_crossing_spans_the_carriageway_at_its_node(rule: Rule) -> None:
    world = world_of(with_tags(ROAD, a="highway=crossing crossing=traffic_signals"), rule)
    (crossing,) = find_crossings(world)
    assert crossing.osm_id == "node/1002"
    assert (crossing.s, crossing.width) == pytest.approx((50.0, 4.0), abs=0.02)
    assert crossing.signals
    assert (crossing.left, crossing.right) == pytest.approx((3.5, -3.5))
    assert not crossing.at_start
    assert not crossing.at_end
    (item,) = crossing_objects(world, [crossing])
    assert (item.type, item.subtype, item.name) == ("crosswalk", "marked", "marked crossing")
    assert (item.length, item.width, item.hdg) == pytest.approx((4.0, 7.0, 0.0))
    assert item.orientation == "none"
    assert has_corners(item, [(48.0, -3.5), (52.0, -3.5), (52.0, 3.5), (48.0, 3.5)])
    assert {corner[2:] for corner in item.outline} == {(0.0, 0.0)}


def test_two_nodes_of_one_crossing_are_one() -> None:
    world = world_of(with_tags(ROAD, a="highway=crossing", b="highway=crossing crossing=traffic_signals"))
    (crossing,) = find_crossings(world)
    assert (crossing.osm_id, crossing.signals) == ("node/1003", True)
    assert said(world)["crossing-merged"] == ["the crossing overlaps that of node/1003: both become one"]


@EITHER
def test_a_way_that_crosses_makes_a_crossing_of_a_node_without_tags(rule: Rule) -> None:
    def crossed(network: StreetNetwork) -> StreetNetwork:
        way = footway([(50.0, -9.0), (50.0, 0.0), (50.0, 9.0)], [501, 1002, 502], rule, width="5")
        other = replace(footway([(60.0, -9.0), (60.0, 9.0)], [503, 504], rule), crossing=False)
        return with_footways(network, way, other)

    world = world_of(ROAD, rule, network=crossed)
    (crossing,) = find_crossings(world)
    assert (crossing.osm_id, crossing.width, crossing.marking) == ("node/1002", 5.0, "unmarked")
    assert crossing.s == pytest.approx(50.0, abs=0.02)
    assert "crossing-width" not in said(world)


@EITHER
def test_a_crossing_in_a_junction_lies_where_it_is_mapped(rule: Rule) -> None:
    world = world_of(with_tags(ARMS, inner="highway=crossing"), rule)
    (crossing,) = find_crossings(world)
    road = world.lanes.road(crossing.road)
    assert road.junction == crossing.junction
    # The way through the junction on which its traffic drives straight on.
    assert {road.predecessor.id, road.successor.id} == {road_of_way(world, 1), road_of_way(world, 2)}  # type: ignore[union-attr]
    assert found_at(world, crossing).real == pytest.approx(node_at(world, number("inner")).real, abs=0.01)
    assert crossing.on_course[0] == road_of_way(world, 1)
    assert crossing.on_course[1] > world.lanes.length(road_of_way(world, 1))
    assert crossing.at_end
    assert "crossing-moved" not in said(world)
    (item,) = crossing_objects(world, [crossing])
    # From kerb to kerb over both directions, and not farther.
    assert 6.0 <= item.width <= 8.0


@EITHER
def test_a_crossing_keeps_off_traffic_that_runs_straight_along_it(rule: Rule) -> None:
    """The node lies 2 m from the middle of the junction, on the lanes of the street across."""
    world = world_of(with_tags(ARMS, near="highway=crossing"), rule)
    (crossing,) = find_crossings(world)
    off = abs(found_at(world, crossing).real - node_at(world, number("o")).real)
    # Half a carriageway of 6 m and half of the crossing, and no farther than needed.
    assert 3.0 + 1.5 <= off <= 3.0 + 1.5 + 1.1
    middle = world_of(with_tags(ARMS, o="highway=crossing"), rule)
    (other,) = find_crossings(middle)
    (message,) = said(middle)["crossing-moved"]
    moved = abs(found_at(middle, other) - node_at(middle, number("o")))
    assert 4.5 <= moved <= 5.6
    assert float(message.split()[-2]) == pytest.approx(moved, abs=0.15)


@EITHER
def test_a_way_shows_which_arm_is_crossed_at_a_junction_node(rule: Rule) -> None:
    """Its middle node is the junction; it runs across the street from west to east."""

    def crossed(network: StreetNetwork) -> StreetNetwork:
        return with_footways(network, footway([(-9.0, 0.0), (0.0, 0.0), (9.0, 0.0)], [501, number("o"), 502], rule))

    world = world_of(ARMS, rule, network=crossed)
    (crossing,) = find_crossings(world)
    assert crossing.on_course[0] in (road_of_way(world, 3), road_of_way(world, 4))
    off = abs(found_at(world, crossing).imag - node_at(world, number("o")).imag)
    assert 4.5 <= off <= 5.6


@EITHER
def test_a_crosswalk_in_a_junction_runs_like_the_way_across(rule: Rule) -> None:
    def crossed(network: StreetNetwork) -> StreetNetwork:
        way = footway([(-10.0, -6.0), (-7.0, 0.0), (-4.0, 6.0)], [501, number("inner"), 502], rule)
        return with_footways(network, way)

    world = world_of(ARMS, rule, network=crossed)
    (crossing,) = find_crossings(world)
    assert crossing.junction >= 0
    # 3 m on for 6 m aside, for traffic in either direction.
    assert crossing.skew == pytest.approx(0.5 * side(rule), abs=0.01)


@EITHER
def test_only_crossings_near_a_junction_make_traffic_stop_there(rule: Rule) -> None:
    signalled = world_of(with_tags(ARMS, wi="highway=crossing crossing=traffic_signals", ei="highway=crossing"), rule)
    by_way = {signalled.lanes.road(item.road).osm_way_ids[0]: item for item in find_crossings(signalled)}
    assert by_way[1].at_end
    assert by_way[2].at_start
    far = Case({**STREET, "x": (180.0, 0.0), "n": (200.0, 99.0), "o": (200.0, 0.0)}, {})
    far = Case(far.nodes, {1: ("w a o", ""), 2: ("o n", ""), 3: ("x o", "")}, node_tags={"a": "highway=crossing"})
    (alone,) = find_crossings(world_of(far, rule))
    assert not alone.at_start
    assert not alone.at_end


def test_crossings_out_of_reach_are_reported() -> None:
    """A node of a street that has become a piece of a junction, without an arm along it."""
    world = world_of(with_tags(ARMS, near="highway=crossing"))
    places = world.places
    road = np.full_like(places.road, -1)
    lost = replace(world, places=replace(places, road=road, junction=np.full_like(places.junction, 999_999)))
    assert find_crossings(lost) == ()
    assert said(lost)["crossing-left-out"] == [
        "the crossing is left out: it lies in a junction, more than 15 m from every road that it could cross"
    ]


TEE = Case(
    {
        "w": (-100.0, 0.0),
        "o": (0.0, 0.0),
        "near": (2.5, 0.0),
        "in": (4.0, 0.0),
        "e": (100.0, 0.0),
        "si": (0.0, -4.5),
        "s": (0.0, -100.0),
    },
    {1: ("w o", ""), 2: ("o near in e", ""), 3: ("s si o", "")},
)


def ends_of_line(world: World, crossing: Crossing, rule: Rule) -> list[complex]:
    """Return the ends of a crossing seen from the middle of `TEE`, in the order of y, m, mirrored for left-hand."""
    left, right = (point(world.road_map, crossing.road, crossing.s, t) for t in (crossing.left, crossing.right))
    along = (left - right) / abs(left - right) * -1j
    middle = 0.5 * (crossing.left + crossing.right)
    found = [
        end + along * crossing.skew * (t - middle) for end, t in ((left, crossing.left), (right, crossing.right))
    ]
    seen = [end - node_at(world, 1002) for end in found]
    return sorted((z if side(rule) > 0 else z.conjugate() for z in seen), key=lambda z: z.imag)


@EITHER
def test_a_crossing_leads_from_kerb_to_kerb_where_corners_are_round(rule: Rule) -> None:
    """Right before a street of 6 m the mouth of the other one is wider than its lanes."""
    world = world_of(with_tags(TEE, si="highway=crossing"), rule)
    (crossing,) = find_crossings(world)
    west, east = sorted(ends_of_line(world, crossing, rule), key=lambda z: z.real)
    assert -6.0 < west.imag == pytest.approx(east.imag, abs=0.01)
    assert 4.5 < east.real < 5.5
    assert west.real == pytest.approx(-east.real, abs=0.3)


@EITHER
@pytest.mark.parametrize(("node", "moved"), [("in", 0.0), ("near", 1.0)])
def test_a_crossing_ends_at_kerbs_and_not_in_the_mouth_of_another_street(node: str, moved: float, rule: Rule) -> None:
    world = world_of(with_tags(TEE, **{node: "highway=crossing"}), rule)
    (crossing,) = find_crossings(world)
    low, high = ends_of_line(world, crossing, rule)
    assert low.real == pytest.approx(TEE.nodes[node][0] + moved, abs=0.1)
    assert high.imag == pytest.approx(3.0, abs=0.4)
    # The corner begins 3 m from the middle of its own street.
    assert -8.0 < low.imag < -3.5
