"""Connecting roads that turn where the streets inside their junction turn."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from road_measures import assert_sound
from street_cases import Case, built_links, mirrored_links

from osm2xodr.curves.plan_views import chain_curves, lengths, smallest_radius
from osm2xodr.curves.records import pose
from osm2xodr.geometry.connections.corner_paths import follow_corners
from osm2xodr.geometry.connections.pose_to_pose import connect, has_kinks
from osm2xodr.geometry.connections.street_paths import LanePaths, lane_paths, lay_out_paths
from osm2xodr.model import FloatArray, PlanView, Rule

# A path from the west over 30 m to the north and on to the east; the origin is in the middle.
STEP = Case(
    {
        "w": (-60.0, -15.0),
        "a": (0.0, -15.0),
        "b": (0.0, 15.0),
        "e": (60.0, 15.0),
        "s": (0.0, -60.0),
        "n": (0.0, 60.0),
    },
    {1: ("w a", ""), 2: ("b e", ""), 3: ("s a", ""), 4: ("b n", ""), 5: ("a b", "")},
)


def laid_out(height: float = 30.0) -> LanePaths:
    """Lay out the way of a lane, as if both nodes were one junction whose arms end 8 m from them."""
    nodes = {name: (x, math.copysign(height / 2, y) if abs(y) < 20 else y) for name, (x, y) in STEP.nodes.items()}
    stages = Case(nodes, STEP.ways).stages()
    numbers = {(stages.way(item.entry), stages.way(item.exit)): item for item in stages.movements}
    whole = numbers.get((1, 2))
    if whole is None:
        first, second = numbers[(1, 5)], numbers[(5, 2)]
        whole = replace(first, exit=second.exit, inner=((second.entry // 2, second.entry % 2 == 1),))
    trim = np.full(len(stages.ends.length), 8.0)
    paths = lay_out_paths([whole], stages.ends, trim, lambda *_: (-1.5, -1.5))
    side = np.array([-1.5])
    return lane_paths(paths, stages.ends.plan_view, np.array([0]), side, side)


def direct(y0: float, y1: float) -> PlanView:
    values = (-8.0, y0, 0.0, 8.0, y1, 0.0)
    return connect(*(np.array([value]) for value in values))


def followed() -> tuple[PlanView, PlanView]:
    plan = direct(-21.5, 18.5)
    return plan, follow_corners(plan, laid_out(40.0))


def places(plan: PlanView) -> FloatArray:
    s = np.linspace(0.0, float(lengths(plan)[0]), 400)
    x, y, _ = pose(plan, np.zeros(len(s), np.int64), s)
    return np.column_stack([x, y])


def test_each_corner_gets_a_turn_of_its_own() -> None:
    plan, turned = followed()
    xy = places(turned)
    # The lane of the inner street lies 1.5 m right of it; straight on between the corners.
    between = xy[np.abs(xy[:, 1]) < 3.0]
    assert len(between) > 20
    assert between[:, 0] == pytest.approx(1.5, abs=0.05)
    assert smallest_radius(turned)[0] >= 5.0
    cut = places(plan)
    assert np.abs(cut[np.abs(cut[:, 1]) < 3.0, 0] - 1.5).max() > 1.0


def test_its_ends_stay() -> None:
    plan, turned = followed()
    for share in (0.0, 1.0):
        before = np.array(pose(plan, np.array([0]), share * lengths(plan)))
        after = np.array(pose(turned, np.array([0]), share * lengths(turned)))
        assert after == pytest.approx(before, abs=1e-6)


@pytest.mark.parametrize("degrees", [5.0, 90.0, 200.0])
def test_a_way_to_and_fro_is_not_followed(degrees: float) -> None:
    """From the west to the junction's northern node and back, along the middle of the one lane between."""
    angle = np.radians(degrees)
    cos, sin = np.cos(angle), np.sin(angle)
    nodes = {name: (cos * x - sin * y, sin * x + cos * y) for name, (x, y) in STEP.nodes.items()}
    stages = Case(nodes, STEP.ways).stages()
    first = next(item for item in stages.movements if (stages.way(item.entry), stages.way(item.exit)) == (1, 5))
    street, along = first.exit // 2, first.exit % 2 == 0
    spike = replace(first, exit=first.entry, inner=((street, along), (street, not along)))
    trim = np.full(len(stages.ends.length), 8.0)
    paths = lay_out_paths([spike], stages.ends, trim, lambda *_: (0.0, 0.0))
    assert paths.length == pytest.approx(2 * 8.0 + 2 * 30.0, abs=0.5)
    x, y = np.array([-8.0, -8.0]), np.array([-16.5, -13.5])
    x, y, hdg = cos * x - sin * y, sin * x + cos * y, angle + np.array([0.0, np.pi])
    plan = connect(x[:1], y[:1], hdg[:1], x[1:], y[1:], hdg[1:])
    side = np.array([-1.5])
    alone = follow_corners(plan, lane_paths(paths, stages.ends.plan_view, np.array([0]), side, side))
    # No curve turns round on the spot.
    assert not has_kinks(alone).any()
    assert alone.hdg == pytest.approx(plan.hdg)
    assert lengths(alone) == pytest.approx(lengths(plan))


def test_what_keeps_near_its_way_is_left_alone() -> None:
    _, turned = followed()
    # It is redrawn as it is, where it is at the limit of straying but for rounding.
    assert places(follow_corners(turned, laid_out(40.0))) == pytest.approx(places(turned), abs=1e-6)


def test_curves_are_joined_end_to_start() -> None:
    rows = np.array([(0.0, 0.0, 0.0, 10.0, 10.0, np.pi / 2), (10.0, 10.0, np.pi / 2, 20.0, 20.0, 0.0)])
    pieces = connect(*rows.T)
    joined = chain_curves(pieces, np.array([0, 2]))
    assert len(joined.start) == 2
    assert lengths(joined)[0] == pytest.approx(lengths(pieces).sum())
    x, y, hdg = pose(joined, np.array([0, 0]), np.array([lengths(pieces)[0], lengths(joined)[0]]))
    assert x == pytest.approx([10.0, 20.0])
    assert y == pytest.approx([10.0, 20.0])
    assert hdg == pytest.approx([np.pi / 2, 0.0])


def test_a_line_that_goes_on_as_a_line_is_one() -> None:
    rows = np.array(
        [
            (0.0, 0.0, 0.0, 10.0, 0.0, 0.0),
            (10.0, 0.0, 2 * np.pi, 15.0, 0.0, 0.0),
            (15.0, 0.0, 0.0, 25.0, 10.0, np.pi / 2),
            (0.0, 5.0, 0.0, 7.0, 5.0, 0.0),
        ]
    )
    joined = chain_curves(connect(*rows.T), np.array([0, 3, 4]))
    assert joined.start.tolist() == [0, 2, 3]
    assert joined.length == pytest.approx([15.0, 5.0 * np.pi, 7.0])
    assert joined.s == pytest.approx([0.0, 15.0, 0.0])


# Aisles of a car park between two streets, close enough to be one junction at either end.
AISLES = Case(
    {
        "w": (-80.0, 0.0), "a": (0.0, 0.0), "b": (9.0, 0.0), "c": (18.0, 0.0), "e": (90.0, 0.0),
        "p": (0.0, 60.0), "q": (9.0, -60.0), "r": (18.0, 60.0),
    },
    {1: ("w a", ""), 2: ("a b", ""), 3: ("b c", ""), 4: ("c e", ""), 5: ("a p", ""), 6: ("b q", ""), 7: ("c r", "")},
)  # fmt: skip


def test_aisles_are_alike_on_both_sides_of_the_road() -> None:
    right, left = AISLES.build(), AISLES.mirrored().build(Rule.LEFT_HAND)
    assert_sound(right)
    assert_sound(left)
    assert mirrored_links(set(built_links(right))) == set(built_links(left))
    lengths_right = sorted(lengths(right.plan_view).round(6).tolist())
    assert sorted(lengths(left.plan_view).round(6).tolist()) == pytest.approx(lengths_right, abs=5e-3)
    widest = [k for k, road in enumerate(right.roads) if road.junction]
    assert smallest_radius(right.plan_view)[widest].min() >= 3.0 - 1e-6


@pytest.mark.parametrize(("height", "turned"), [(7.0, False), (20.0, True)])
def test_a_low_step_is_driven_in_one_curve(height: float, turned: bool) -> None:
    """Its curve keeps within 3 m of the streets; beside a high one it does not."""
    plan = direct(-height / 2 - 1.5, height / 2 - 1.5)
    assert (follow_corners(plan, laid_out(height)) is not plan) == turned
