"""Bus stops on streets and beside them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from object_cases import ROAD, STREET, has_corners, placed, s_of, said, side, thing, with_things, world_of
from street_cases import Case

from osm2xodr.model import RoadsideKind, Rule

EITHER = pytest.mark.parametrize("rule", list(Rule))
NEAR = 0.02


@EITHER
def test_a_bus_stop_beside_the_road_stands_at_the_kerb(rule: Rule) -> None:
    stop = thing(RoadsideKind.BUS_STOP, [(10.0, -6.0)], rule, name="Markt", bus_bay="yes")
    bay, post = placed(world_of(ROAD, rule, network=with_things(stop)))
    hand = side(rule)
    assert (post.type, post.subtype, post.name, post.orientation) == ("pole", "busStop", "bus stop Markt", "+")
    assert (post.s, post.t) == pytest.approx((s_of(10.0), -4.0 * hand), abs=NEAR)
    assert (bay.type, bay.subtype, bay.length, bay.width) == ("patch", "busBay", 44.0, 3.0)
    outer = [(bay.s - 22.0, -3.5), (bay.s - 10.0, -6.5), (bay.s + 10.0, -6.5), (bay.s + 22.0, -3.5)]
    assert has_corners(replace(bay, outline=bay.outline[:4]), [(s, t * hand) for s, t in outer])
    assert {round(bay.t + v, 3) for _, v, _, _ in bay.outline[4:]} == {-3.5 * hand}


@EITHER
@pytest.mark.parametrize(
    ("tags", "way", "along", "guessed"),
    [
        ("direction=forward", "", True, False),
        ("direction=backward", "", False, False),
        ("", "oneway=yes", True, False),
        ("", "", True, True),
    ],
)
def test_a_bus_stop_on_the_street_stands_on_the_side_of_its_traffic(
    rule: Rule, tags: str, way: str, along: bool, guessed: bool
) -> None:
    case = Case(STREET, {1: ("w a e", way)}, node_tags={"a": f"highway=bus_stop {tags}"})
    world = world_of(case, rule)
    (post,) = placed(world)
    left, right = world.lanes.carriageway(post.road, post.s)
    on_right = along == (rule is Rule.RIGHT_HAND)
    assert post.t == pytest.approx(right - 0.5 if on_right else left + 0.5)
    assert (post.orientation, post.osm_id) == ("+" if along else "-", "node/1002")
    assert ("bus-stop-side" in said(world)) is guessed


# A junction whose arms end some metres before its middle.
CROSSROADS = Case(
    {"w": (-100.0, 0.0), "a": (0.0, 0.0), "e": (100.0, 0.0), "n": (0.0, 100.0), "s": (0.0, -100.0)},
    {1: ("w a e", "lanes=2 width=7"), 2: ("n a s", "lanes=2 width=7")},
)


@EITHER
def test_a_bus_stop_beside_a_junction_moves_to_the_end_of_the_nearest_arm(rule: Rule) -> None:
    stop = thing(RoadsideKind.BUS_STOP, [(-6.0, -4.0)], rule, name="Markt")
    world = world_of(CROSSROADS, rule, network=with_things(stop))
    (post,) = placed(world)
    arm = next(arm for arms in world.nodes.arms.values() for arm in arms if arm.x < -5.0)
    end = world.lanes.length(arm.road) if arm.at_end else 0.0
    assert (post.road, post.orientation) == (arm.road, "+")
    assert (post.s, post.t) == pytest.approx((end, -4.0 * side(rule)), abs=NEAR)
    (words,) = said(world)["bus-stop-moved"]
    assert words.endswith(f"by {np.hypot(-6.0 - arm.x, 0.5):.1f} m")


@EITHER
def test_a_bus_stop_far_from_all_roads_is_left_out(rule: Rule) -> None:
    stop = thing(RoadsideKind.BUS_STOP, [(-40.0, -40.0)], rule)
    world = world_of(CROSSROADS, rule, network=with_things(stop))
    assert placed(world) == ()
    assert "roadside-left-out" in said(world)
