"""Things beside roads, and tram tracks in them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from object_cases import ROAD, STREET, placed, road_of_way, s_of, said, side, thing, with_things, world_of
from street_cases import Case

from osm2xodr.model import RoadsideKind, Rule

EITHER = pytest.mark.parametrize("rule", list(Rule))
NEAR = 0.02
# A track from the west to the south.
_ARC = [(-9.6 + 8.0 * math.sin(angle), -9.6 + 8.0 * math.cos(angle)) for angle in np.linspace(0.0, math.pi / 2, 12)]
ROUND_THE_CORNER = [(-50.0, -1.6), *_ARC, (-1.6, -50.0)]


@EITHER
def test_a_fence_beside_the_road_becomes_a_repeated_object(rule: Rule) -> None:
    fence = thing(RoadsideKind.FENCE, [(-40.0, 6.0), (30.0, 6.0)], rule, height="1.8")
    world = world_of(ROAD, rule, network=with_things(fence))
    (item,) = placed(world)
    t = 6.0 * side(rule)
    assert (item.type, item.subtype, item.name, item.osm_id) == ("railing", "fence", "fence", "way/77")
    assert item.road == road_of_way(world, 1)
    assert (item.s, item.t) == pytest.approx((s_of(-40.0), t), abs=NEAR)
    repeat = item.repeat
    assert repeat is not None
    assert (repeat.s, repeat.length) == pytest.approx((item.s, 70.0), abs=NEAR)
    assert (repeat.t_start, repeat.t_end) == pytest.approx((t, t), abs=NEAR)
    assert (repeat.distance, repeat.width, repeat.height) == (0.0, 0.1, 1.8)


@EITHER
def test_a_line_with_a_corner_becomes_as_many_pieces_as_it_has(rule: Rule) -> None:
    wall = thing(RoadsideKind.WALL, [(40.0, 6.0), (0.0, 6.0), (-20.0, 9.0), (-50.0, 9.0)], rule)
    world = world_of(ROAD, rule, network=with_things(wall))
    found = placed(world)
    ends = [
        (item.repeat.s, item.repeat.s + item.repeat.length, item.repeat.t_start, item.repeat.t_end)
        for item in found
        if item.repeat is not None
    ]
    hand = side(rule)
    np.testing.assert_allclose(
        ends,
        [
            (s_of(-50.0), s_of(-20.0), 9.0 * hand, 9.0 * hand),
            (s_of(-20.0), s_of(0.0), 9.0 * hand, 6.0 * hand),
            (s_of(0.0), s_of(40.0), 6.0 * hand, 6.0 * hand),
        ],
        atol=0.05,
    )


@EITHER
def test_things_drawn_on_the_edge_go_beside_the_carriageway(rule: Rule) -> None:
    rail = thing(RoadsideKind.GUARD_RAIL, [(-40.0, 2.9), (30.0, 2.9)], rule)
    (item,) = placed(world_of(ROAD, rule, network=with_things(rail)))
    # Edge at 3.5 m, gap of 0.1 m, half of 0.3 m.
    assert item.t == pytest.approx(3.75 * side(rule))


def test_things_on_or_across_the_carriageway_are_left_out() -> None:
    on = thing(RoadsideKind.FENCE, [(-40.0, 1.0), (30.0, 1.0)])
    across = thing(RoadsideKind.FENCE, [(20.0, 4.0), (20.0, 12.0)])
    far = thing(RoadsideKind.HEDGE, [(-40.0, 14.0), (30.0, 14.0)])
    world = world_of(ROAD, network=with_things(on, across, far))
    assert placed(world) == ()
    assert said(world)["roadside-left-out"] == [
        "2 ways with a fence left out: no part runs beside a carriageway within 10 m",
        "1 way with a hedge left out: no part runs beside a carriageway within 10 m",
    ]


def test_a_line_that_crosses_the_road_is_cut_there() -> None:
    wall = thing(RoadsideKind.WALL, [(-40.0, 8.0), (-10.0, 6.0), (10.0, -6.0), (40.0, -8.0)])
    found = placed(world_of(ROAD, network=with_things(wall)))
    assert len(found) >= 2
    for item in found:
        assert item.repeat is not None
        for t in (item.repeat.t_start, item.repeat.t_end):
            assert abs(t) >= 3.5 + 0.15


@EITHER
def test_bollards_in_a_row_are_round_and_apart(rule: Rule) -> None:
    row = thing(RoadsideKind.BOLLARD, [(0.0, -4.5), (12.0, -4.5)], rule)
    (item,) = placed(world_of(ROAD, rule, network=with_things(row)))
    assert (item.type, item.radius, item.length, item.width) == ("pole", 0.1, 0.0, 0.0)
    assert item.repeat is not None
    assert (item.repeat.distance, item.height) == (1.5, 0.9)


@pytest.mark.parametrize(("kerb", "height"), [("raised", 0.12), ("lowered", 0.03), ("flush", 0.0), ("", 0.12)])
def test_kerbs_are_as_high_as_tagged(kerb: str, height: float) -> None:
    line = thing(RoadsideKind.KERB, [(-40.0, 3.6), (30.0, 3.6)], kerb=kerb)
    (item,) = placed(world_of(ROAD, network=with_things(line)))
    assert (item.type, item.subtype, item.height) == ("none", "kerb", height)


@EITHER
def test_lamps_and_trees_are_placed_on_request(rule: Rule) -> None:
    things = (
        thing(RoadsideKind.STREET_LAMP, [(10.0, 4.2)], rule, height="8 m"),
        thing(RoadsideKind.TREE, [(20.0, -3.0)], rule),
        thing(RoadsideKind.TREE, [(30.0, 0.5)], rule),
        thing(RoadsideKind.BOLLARD, [(40.0, 5.0)], rule),
    )
    assert [item.type for item in placed(world_of(ROAD, rule, network=with_things(*things)))] == ["pole"]
    world = world_of(ROAD, rule, network=with_things(*things), extra=frozenset({"lamps", "trees"}))
    lamp, tree, bollard = placed(world)
    hand = side(rule)
    assert (lamp.type, lamp.height, lamp.radius) == ("streetLamp", 8.0, 0.1)
    assert (lamp.s, lamp.t) == pytest.approx((s_of(10.0), 4.2 * hand), abs=NEAR)
    # Its trunk of 0.6 m is moved to the edge.
    assert tree.type == "tree"
    assert tree.t == pytest.approx(-3.9 * hand)
    assert bollard.t == pytest.approx(5.0 * hand, abs=NEAR)
    assert said(world)["roadside-left-out"] == ["1 tree left out: on the carriageway"]


@EITHER
def test_tram_tracks_lie_where_their_way_runs(rule: Rule) -> None:
    track = thing(RoadsideKind.TRAM_TRACK, [(-50.0, 1.5), (50.0, 1.5)], rule, gauge="1000")
    found = placed(world_of(ROAD, rule, network=with_things(track)))
    assert [(item.type, item.subtype, item.name) for item in found] == [("patch", "tramTrack", "tram track")] * 2
    assert sorted(round(item.t * side(rule), 1) for item in found) == [1.0, 2.0]
    assert all(item.repeat is not None and item.repeat.length == pytest.approx(100.0, abs=NEAR) for item in found)


@EITHER
@pytest.mark.parametrize("points", [[(-50.0, 1.5), (50.0, 1.5)], ROUND_THE_CORNER])
def test_tram_tracks_run_on_through_junctions(points: list[tuple[float, float]], rule: Rule) -> None:
    nodes = {"w": (-80.0, 0.0), "o": (0.0, 0.0), "e": (80.0, 0.0), "s": (0.0, -80.0), "n": (0.0, 80.0)}
    ways = {k: (f"{name} o", "lanes=2 width=7") for k, name in enumerate("wesn", start=1)}
    track = thing(RoadsideKind.TRAM_TRACK, points, rule)
    world = world_of(Case(nodes, ways), rule, network=with_things(track))
    found = placed(world)
    length = float(np.hypot(*np.diff(np.array(points), axis=0).T).sum())
    by_place: dict[bool, float] = {True: 0.0, False: 0.0}
    inside = {road.id for road in world.road_map.roads if road.junction is not None}
    for item in found:
        # Along roads they repeat; through junctions they are straight pieces.
        assert (item.repeat is None) == (item.road in inside)
        by_place[item.road in inside] += (item.length if item.repeat is None else item.repeat.length) / 2
        assert item.width == pytest.approx(0.07)
    assert by_place[True] > 9.0
    assert sum(by_place.values()) == pytest.approx(length, abs=0.3)


@EITHER
@pytest.mark.parametrize("at_level", [True, False])
def test_tram_tracks_cross_streets_at_shared_nodes_only(at_level: bool, rule: Rule) -> None:
    track = thing(RoadsideKind.TRAM_TRACK, [(10.0, -30.0), (10.0, 0.0), (10.0, 30.0)], rule)
    nodes = {"w": (-60.0, 0.0), "a": (10.0, 0.0), "e": (60.0, 0.0)}
    case = Case(nodes, {1: ("w a e", "lanes=2 width=7")})
    if at_level:
        track = replace(track, node_ids=np.array([900, 1002, 902]))
    world = world_of(case, rule, network=with_things(track))
    found = placed(world)
    assert len(found) == (2 if at_level else 0)
    if at_level:
        assert sorted(item.s for item in found) == pytest.approx([70.0 - 0.7175, 70.0 + 0.7175], abs=NEAR)
        for item in found:
            assert (item.t, abs(item.hdg), item.length) == pytest.approx((0.0, math.pi / 2, 7.0), abs=0.5)
            assert item.repeat is None


@EITHER
def test_tracks_above_a_tunnel_are_not_on_its_road(rule: Rule) -> None:
    """The street goes under from x = 0 on: the track on the ground above it ends there."""
    under = Case(STREET, {1: ("w a", "lanes=2 width=7"), 2: ("a e", "lanes=2 width=7 tunnel=yes layer=-1")})
    track = thing(RoadsideKind.TRAM_TRACK, [(-50.0, 1.5), (50.0, 1.5)], rule)
    found = placed(world_of(under, rule, network=with_things(track)))
    portal = s_of(STREET["a"][0])
    assert len(found) == 2
    for item in found:
        assert item.repeat is not None
        assert item.repeat.s == pytest.approx(s_of(-50.0), abs=NEAR)
        assert portal - 5.0 < item.repeat.s + item.repeat.length <= portal + 1e-6


def test_tracks_beside_the_carriageway_are_left_out() -> None:
    track = thing(RoadsideKind.TRAM_TRACK, [(-50.0, 6.0), (50.0, 6.0)])
    assert placed(world_of(ROAD, network=with_things(track))) == ()


@EITHER
def test_streets_with_tracks_have_them_in_their_inner_lanes(rule: Rule) -> None:
    world = world_of(Case(STREET, {1: ("w a e", "lanes=2 width=7 embedded_rails=tram")}), rule)
    found = placed(world)
    assert sorted(round(item.t, 4) for item in found) == [-2.4675, -1.0325, 1.0325, 2.4675]
    assert {item.osm_id for item in found} == {"way/1"}
    assert all(
        item.repeat is not None and item.repeat.length == pytest.approx(world.lanes.length(item.road))
        for item in found
    )
