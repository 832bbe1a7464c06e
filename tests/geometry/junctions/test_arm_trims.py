"""What a junction takes of its arms, against the geometry of straight streets."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from osm2xodr.geometry.junctions.arm_trims import footprints
from osm2xodr.geometry.plan_view.ends import StreetEnds
from osm2xodr.model import PlanView

# Edges count as apart once they are this far from each other, m; roads end farther out by the clearance.
GAP = 0.3
CLEARANCE = 0.5
FREE = GAP + CLEARANCE


def star(
    arms: list[tuple[float, float]],
    *,
    kerb: float = 4.0,
    reach: float = 40.0,
    length: float = 200.0,
    layers: list[int] | None = None,
    nodes: list[int] | None = None,
    one_way_out: bool = False,
    starts: list[tuple[float, float]] | None = None,
) -> StreetEnds:
    """Make straight streets that start at one place, or at `starts`: (heading in degrees, half width) each."""
    n = len(arms)
    hdg = np.deg2rad([angle for angle, _ in arms])
    half = np.repeat([width for _, width in arms], 2)
    x, y = np.array(starts or [(0.0, 0.0)] * n).T
    plan = PlanView(np.arange(n + 1), np.zeros(n), x, y, hdg, np.full(n, length), np.zeros(n))
    ends = 2 * n
    node = np.full(ends, -1, np.int64)
    node[0::2] = 0 if nodes is None else nodes
    return StreetEnds(
        plan_view=plan,
        length=np.full(ends, length),
        node=node,
        left=half,
        right=-half,
        hdg=np.column_stack([hdg, hdg + math.pi]).ravel(),
        enters=np.full(ends, not one_way_out),
        leaves=np.ones(ends, bool),
        kerb=np.full(ends, kerb),
        reach=np.full(ends, reach),
        roundabout=np.zeros(ends, bool),
        raised=np.zeros(ends, bool),
        layer=np.zeros(ends, np.int64) if layers is None else np.repeat(layers, 2),
        aside=np.zeros(ends),
        lines=plan,
        piece_start=np.arange(n + 1),
        piece_s=np.zeros(n),
        piece_level=np.zeros(n, np.int64) if layers is None else 3 * np.array(layers),
    )


def taken(ends: StreetEnds) -> tuple[list[float], list[float]]:
    """Return what the starts of all streets give as one junction, bare and with kerbs."""
    arms = list(range(0, len(ends.length), 2))
    bare, wished = footprints(ends, [arms])
    assert not bare[1::2].any()
    assert not wished[1::2].any()
    return bare[0::2].tolist(), wished[0::2].tolist()


@pytest.mark.parametrize("turned", [0.0, 33.0, 200.0])
@pytest.mark.parametrize(("one", "other"), [(2.75, 2.75), (3.0, 5.5), (7.0, 2.5)])
def test_arms_of_a_square_crossing_end_at_the_edge_of_the_crossing_street(
    one: float, other: float, turned: float
) -> None:
    bare, wished = taken(star([(turned, one), (turned + 90, other), (turned + 180, one), (turned + 270, other)]))
    assert bare == pytest.approx([other + FREE, one + FREE] * 2, abs=0.02)
    assert wished == pytest.approx([other + FREE + 4.0, one + FREE + 4.0] * 2, abs=0.02)


@pytest.mark.parametrize("turned", [0.0, 33.0, 200.0])
def test_streets_shorter_than_the_junction_count_as_if_they_ran_on(turned: float) -> None:
    bare, _ = taken(star([(turned, 4.0), (turned + 90, 3.0), (turned + 180, 4.0)], length=1.5))
    assert bare == pytest.approx([3.0 + FREE, 4.0 + FREE, 3.0 + FREE], abs=0.02)


def test_arms_of_a_t() -> None:
    bare, wished = taken(star([(0.0, 3.0), (180.0, 3.0), (90.0, 2.5)], kerb=5.0))
    assert bare == pytest.approx([2.5 + FREE, 2.5 + FREE, 3.0 + FREE], abs=0.02)
    assert wished == pytest.approx([7.5 + FREE, 7.5 + FREE, 8.0 + FREE], abs=0.02)


@pytest.mark.parametrize(("angle", "half"), [(10.0, 1.5), (20.0, 2.5), (35.0, 3.0), (60.0, 3.0)])
def test_arms_that_join_at_an_acute_angle_end_where_their_edges_part(angle: float, half: float) -> None:
    """The inner edges of two streets of half width w meet at w / tan(angle / 2) from the node."""
    bare, _ = taken(star([(0.0, half), (angle, half), (180.0 + angle / 2, half)]))
    part = (half * (1 + math.cos(math.radians(angle))) + GAP) / math.sin(math.radians(angle))
    assert part > half / math.tan(math.radians(angle) / 2)
    assert bare[:2] == pytest.approx([part + CLEARANCE] * 2, abs=0.15)


def test_no_arm_is_cut_farther_back_than_it_reaches() -> None:
    bare, _ = taken(star([(0.0, 3.5), (3.0, 3.5), (180.0, 3.5)], reach=40.0))
    assert bare[:2] == pytest.approx([40.0 + CLEARANCE] * 2, abs=1e-9)
    far, _ = taken(star([(0.0, 3.5), (5.0, 3.5), (180.0, 3.5)], reach=100.0))
    expected = (3.5 * (1 + math.cos(math.radians(5.0))) + GAP) / math.sin(math.radians(5.0))
    assert far[:2] == pytest.approx([expected + CLEARANCE] * 2, abs=0.5)


def test_kerbs_are_tangents_of_their_radius_and_not_too_long() -> None:
    """At an angle a between two arms a kerb of radius r takes r / tan(a / 2) of either."""
    bare, wished = taken(star([(0.0, 2.0), (120.0, 2.0), (240.0, 2.0)], kerb=5.0))
    assert np.subtract(wished, bare) == pytest.approx([5.0 / math.tan(math.radians(60.0))] * 3, abs=1e-9)
    bare, wished = taken(star([(0.0, 2.0), (40.0, 2.0), (200.0, 2.0)], kerb=5.0))
    assert wished[0] - bare[0] == pytest.approx(8.0, abs=1e-9)


def test_where_nobody_turns_there_is_no_kerb() -> None:
    bare, wished = taken(star([(0.0, 2.0), (90.0, 2.0), (180.0, 2.0)], one_way_out=True))
    assert wished == bare


def test_streets_on_different_layers_do_not_end_for_each_other() -> None:
    arms = [(0.0, 3.0), (180.0, 3.0), (90.0, 3.0), (270.0, 3.0)]
    bare, _ = taken(star(arms, layers=[0, 0, 1, 1], nodes=[0, 0, 1, 1]))
    assert max(bare) < 1.0 + CLEARANCE
    same_node, _ = taken(star(arms, layers=[0, 0, 1, 1]))
    assert same_node == pytest.approx([3.0 + FREE] * 4, abs=0.02)


def test_junctions_do_not_see_each_other() -> None:
    ends = star([(0.0, 2.0), (90.0, 3.0), (180.0, 2.0), (0.0, 9.0), (90.0, 9.0), (180.0, 9.0)])
    together, _ = footprints(ends, [[0, 2, 4], [6, 8, 10]])
    alone, _ = footprints(ends, [[0, 2, 4]])
    assert together[:6].tolist() == alone[:6].tolist()
    assert not alone[6:].any()
    none, wished = footprints(ends, [])
    assert not none.any()
    assert not wished.any()


@pytest.mark.parametrize(("angle", "kerb"), [(23.0, False), (27.0, True), (158.0, True), (162.0, False)])
def test_there_is_a_kerb_where_one_turns_round_a_corner(angle: float, kerb: bool) -> None:
    bare, wished = taken(star([(0.0, 2.0), (angle, 2.0), (180.0 + angle / 2, 2.0)], kerb=3.0))
    end = bare.index(min(bare[0], bare[1])) if angle < 90.0 else 0
    others = [180.0 - angle / 2, angle]
    rounded = [3.0 / math.tan(math.radians(other) / 2) for other in others if 25.0 < other < 160.0]
    assert wished[end] - bare[end] == pytest.approx(min(8.0, max(rounded, default=0.0)), abs=1e-9)
    assert (angle in others and 25.0 < angle < 160.0) == kerb


@pytest.mark.parametrize(("angle", "rounded"), [(158.0, True), (162.0, False)])
def test_an_arm_that_runs_on_almost_straight_has_no_kerb(angle: float, rounded: bool) -> None:
    bare, wished = taken(star([(0.0, 2.0), (angle, 2.0)], kerb=3.0))
    tangent = 3.0 / math.tan(math.radians(angle) / 2)
    assert np.subtract(wished, bare) == pytest.approx([tangent if rounded else 0.0] * 2, abs=1e-9)


@pytest.mark.parametrize(("away", "crossed"), [(7.6, True), (13.0, True), (15.1, True), (15.4, False), (16.0, False)])
def test_an_arm_that_comes_close_again_far_out_is_another_place(away: float, crossed: bool) -> None:
    """A street of 6 m crosses the arm, whose edges would meet it 2.7 m before its line."""
    bare, _ = taken(star([(0.0, 2.0), (90.0, 3.0)], starts=[(0.0, 0.0), (away, -16.0)]))
    assert bare[0] == pytest.approx(away + 3.0 + FREE if crossed else CLEARANCE, abs=0.02)


# Two streets of 6 m side by side reach into each other by 0.1 m or 0.4 m; from somewhere on one of them is a bridge.
@pytest.mark.parametrize(
    ("apart", "bridge", "taken_m"), [(5.9, 30.0, 30.5), (5.9, 20.0, 26.0), (5.9, 300.0, 40.5), (5.6, 30.0, 40.5)]
)
def test_arms_side_by_side_end_where_one_comes_to_another_level(apart: float, bridge: float, taken_m: float) -> None:
    ends = star([(0.0, 3.0), (0.0, 3.0)], starts=[(0.0, 0.0), (0.0, apart)])
    places, levels = np.array([0.0, 0.0, bridge]), np.array([0, 0, 4])
    ends = replace(ends, piece_start=np.array([0, 1, 3]), piece_s=places, piece_level=levels)
    bare, _ = taken(ends)
    assert bare == pytest.approx([taken_m, taken_m], abs=0.6)


def test_levels_that_differ_from_the_node_on_part_no_arms() -> None:
    ends = star([(0.0, 3.0), (0.0, 3.0)], starts=[(0.0, 0.0), (0.0, 5.9)], layers=[0, 1], nodes=[0, 0])
    assert taken(ends)[0] == pytest.approx([40.5, 40.5], abs=0.01)
