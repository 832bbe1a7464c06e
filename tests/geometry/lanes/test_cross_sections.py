"""Lanes from left to right become ids outwards from a centre, with their places across the road."""

from __future__ import annotations

import pytest
from lane_cases import section, street

from osm2xodr.geometry.lanes.cross_sections import EndLane, centre_lanes, cross_section, end_lanes
from osm2xodr.model import Rule

RIGHT, LEFT = Rule.RIGHT_HAND, Rule.LEFT_HAND


@pytest.mark.parametrize(
    ("text", "rule", "on_left", "centre"),
    [
        ("d< d>", RIGHT, 1, 0.0),
        ("d< d> d>", RIGHT, 1, 1.5),
        ("d> d>", RIGHT, 0, 3.0),
        ("d< d<", RIGHT, 2, -3.0),
        # Lanes for both directions lie on the side of those that run along the street.
        ("d< d= d>", RIGHT, 1, 1.5),
        ("d=", RIGHT, 0, 1.5),
        ("d> d<", LEFT, 1, 0.0),
        ("d> d> d<", LEFT, 2, -1.5),
        ("d> d= d<", LEFT, 2, -1.5),
        ("d=", LEFT, 1, -1.5),
    ],
)
def test_which_lanes_lie_left_of_the_centre(text: str, rule: Rule, on_left: int, centre: float) -> None:
    found = section(text, rule)
    assert (len(found.left), found.centre) == (on_left, centre)
    assert len(found.left) + len(found.right) == len(text.split())
    assert found.left_edge == -found.right_edge == 1.5 * len(text.split())


def test_lanes_are_counted_outwards_from_the_centre() -> None:
    found = cross_section(street("c< b< d> t>", middle_offset=0.5), RIGHT)
    assert [lane.type.value for lane in found.left] == ["bus", "biking"]
    assert [lane.type.value for lane in found.right] == ["driving", "taxi"]
    # 12 m about t = 0.5 m.
    assert (found.left_edge, found.centre, found.right_edge) == (6.5, 1.5, -5.5)


def places(lanes: tuple[EndLane, ...]) -> dict[int, float]:
    """Return t by lane id, in the order of the lanes."""
    return {lane.id: lane.t for lane in lanes}


def test_lanes_as_their_drivers_see_them() -> None:
    right = cross_section(street("c< d< d= d> c>"), RIGHT)
    left = cross_section(street("c> d> d= d< c<"), LEFT)
    for found, wanted in (
        (end_lanes(right, RIGHT, along=True), {-2: -3.5, -3: -6.0}),
        (end_lanes(right, RIGHT, along=False), {1: 3.5, 2: 6.0}),
        (end_lanes(left, LEFT, along=True), {3: 6.0, 2: 3.5}),
        (end_lanes(left, LEFT, along=False), {-2: -6.0, -1: -3.5}),
        (centre_lanes(right, along=True), {-1: 0.0}),
        (centre_lanes(left, along=False), {1: 0.0}),
        (centre_lanes(section("d= d="), along=True), {-1: 1.5, -2: -1.5}),
        (centre_lanes(section("d= d="), along=False), {-2: -1.5, -1: 1.5}),
    ):
        assert places(found) == pytest.approx(wanted)
        assert list(places(found)) == list(wanted)
    assert [lane.spec.type.value for lane in end_lanes(right, RIGHT, along=True)] == ["driving", "biking"]
