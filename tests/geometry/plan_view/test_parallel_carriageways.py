"""Streets side by side: apart, and narrow enough to fit, but never narrower than a car drives."""

from __future__ import annotations

import math

import numpy as np
import pytest
from street_cases import Case

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.lanes import Piece
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.geometry.plan_view.parallel_carriageways import separate_parallel_streets
from osm2xodr.geometry.plan_view.streets import FittedStreets, fit_streets

# Headings along a bend, rad.
_BEND = np.deg2rad(np.arange(-80.0, 81.0, 10.0)).tolist()


def separated(case: Case) -> tuple[FittedStreets, list[str]]:
    """Return the streets of a case, separated, and what was reported."""
    network = case.stages().network
    diagnostics = Diagnostics()
    return separate_parallel_streets(network, fit_streets(network, Diagnostics()), diagnostics), [
        item.code for item in diagnostics
    ]


def drawn(pieces: tuple[Piece, ...]) -> list[tuple[float, float, float]]:
    """Return of each piece of a street its start, the middle of its lanes and their width, m."""
    return [(s, 0.5 * (item.left_edge + item.right_edge), item.left_edge - item.right_edge) for s, _, item in pieces]


def beside(apart: float, one: str, other: str = "", length: float = 200.0, *, opposite: bool = False) -> Case:
    """Return two straight streets beside each other, the second one to the left, the same way or against it."""
    nodes = {"a": (0.0, 0.0), "b": (length, 0.0), "c": (0.0, apart), "d": (length, apart)}
    return Case(nodes, {1: ("a b", one), 2: ("d c" if opposite else "c d", other or one)})


# Two streets of two lanes and 6 m lack 6.2 m less their distance. Up to .5 m of that lanes of 2.75 m give, 1 m more
# their lines, up to 1.8 m lanes of 2.1 m, and the rest lines again; lines do not move for less than .15 m.
@pytest.mark.parametrize(
    ("apart", "aside", "share"),
    [
        (6.3, 0.0, 1.0),
        (6.15, 0.0, 1.0),
        (5.75, 0.0, 0.92),
        (5.55, 0.0, 0.89),
        (4.9, 0.4, 0.91),
        (4.35, 0.5, 0.85),
        (3.4, 0.5, 0.7),
        (3.1, 0.65, 0.7),
        (2.9, 0.0, 1.0),
    ],
)
@pytest.mark.parametrize("opposite", [False, True])
def test_lanes_narrow_first_and_lines_move_last(apart: float, aside: float, share: float, opposite: bool) -> None:
    found, reported = separated(beside(apart, "width=6", opposite=opposite))
    (first,), (second,) = (drawn(pieces) for pieces in found.pieces)
    assert first == pytest.approx((0.0, -aside, 6.0 * share))
    assert second == pytest.approx((0.0, -aside if opposite else aside, 6.0 * share))
    assert reported.count("moved-aside") == (2 if aside else 0)
    assert reported.count("lanes-narrowed") == (2 if share < 1.0 else 0)


def test_the_width_of_one_lane_gives_more_than_that_of_several() -> None:
    """Variances of half widths: .95^2 and .3^2; they lack .4 m, and no line moves."""
    found, reported = separated(beside(5.3, "oneway=yes lanes=1 width=4", "oneway=yes lanes=2 width=7"))
    ((_, _, width),), ((_, _, other_width),) = (drawn(pieces) for pieces in found.pieces)
    both = 0.95**2 + 0.3**2
    assert width == pytest.approx(4.0 - 0.8 * 0.95**2 / both, abs=0.04)
    assert other_width == pytest.approx(7.0 - 0.8 * 0.3**2 / both, abs=0.07)
    assert reported == ["lanes-narrowed"] * 2


def test_what_narrow_lanes_cannot_give_the_street_beside_gives() -> None:
    """A roundabout's line does not move, and the lanes of both keep 70 % of their width."""
    nodes = {f"r{k}": (20.0 * math.cos(a), 20.0 * math.sin(a)) for k, a in enumerate(np.deg2rad(range(0, 360, 15)))}
    ways = {1: (" ".join([*nodes, "r0"]), "junction=roundabout oneway=yes lanes=1 width=5"), 2: ("w x", "width=6")}
    found, _ = separated(Case({**nodes, "w": (-60.0, -23.9), "x": (60.0, -23.9)}, ways))
    assert {round(middle, 9) for _, middle, _ in drawn(found.pieces[0])} == {0.0}
    assert min(middle for _, middle, _ in drawn(found.pieces[1])) < -0.2


@pytest.mark.parametrize(("highway", "distance"), [("motorway", 0.5), ("trunk", 0.2)])
def test_opposite_carriageways_of_a_motorway_keep_a_median(highway: str, distance: float) -> None:
    """Each moves by .5 m for a median of 2.5 m, and its lanes do not narrow; those of a trunk road do."""
    tags = f"highway={highway} oneway=yes lanes=2 width=7.5"
    found, _ = separated(beside(7.0, tags, opposite=True))
    ((_, middle, width),), ((_, other_middle, other_width),) = (drawn(pieces) for pieces in found.pieces)
    kept = 7.0 - other_middle - middle - 0.5 * (width + other_width)
    assert kept == pytest.approx(distance, abs=0.08)
    assert middle == other_middle == (-0.5 if highway == "motorway" else 0.0)
    assert width == pytest.approx(7.5 if highway == "motorway" else 0.9 * 7.5, abs=0.02)


def test_of_two_motorways_the_one_with_more_lanes_beside_those_that_lead_on_moves() -> None:
    """Its line may lie up to 3.75 m beside the middle of its lanes; that of the other one is taken to be right."""
    tags = "highway=motorway oneway=yes lanes={} width={}"
    found, reported = separated(beside(13.0, tags.format(3, 11.25), tags.format(4, 15), opposite=True))
    ((_, middle, width),), ((_, other_middle, other_width),) = (drawn(pieces) for pieces in found.pieces)
    lack = 5.625 + 7.5 + 2.5 - 13.0
    assert -middle == pytest.approx(lack * 0.5 / 4.75, abs=0.01)
    assert -other_middle == pytest.approx(lack * 4.25 / 4.75, abs=0.01)
    assert (width, other_width) == (11.25, 15.0)
    assert reported == ["moved-aside"] * 2


def test_only_what_lies_beside_the_other_street_changes() -> None:
    """A street of 400 m, of which another one of 40 m lies beside the middle."""
    nodes = {"a": (0.0, 0.0), "b": (400.0, 0.0), "c": (180.0, 4.9), "d": (220.0, 4.9)}
    found, _ = separated(Case(nodes, {1: ("a b", "width=6"), 2: ("c d", "width=6")}))
    reach = 4.0 + defaults.SEPARATED_BEYOND
    first, changed, last = drawn(found.pieces[0])
    assert first == pytest.approx((0.0, 0.0, 6.0))
    assert changed[0] == pytest.approx(184.0 - reach, abs=8.0)
    assert changed[1:] == pytest.approx((-0.4, 0.91 * 6.0))
    assert last[0] == pytest.approx(216.0 + reach, abs=8.0)
    assert last[1:] == pytest.approx((0.0, 6.0))


def three_streets(apart: float, tags: str) -> Case:
    """Return three streets beside each other, the second one in the middle."""
    nodes = {f"{name}{k}": (200.0 * k, n * apart) for n, name in ((1, "a"), (0, "b"), (-1, "c")) for k in (0, 1)}
    return Case(nodes, {k: (f"{name}0 {name}1", tags) for k, name in enumerate("abc", start=1)})


def test_a_street_between_two_others_stays_and_narrows() -> None:
    found, reported = separated(three_streets(4.88, "width=6"))
    assert reported.count("moved-aside") == 2
    left, middle, right = (drawn(pieces)[0] for pieces in found.pieces)
    assert middle[1] == 0.0
    assert left[1] == pytest.approx(0.41)
    assert right[1] == pytest.approx(-0.41)
    # They lack .91 m still, which both give alike.
    assert middle[2] == pytest.approx(0.84 * 6.0)


@pytest.mark.parametrize(
    ("tags", "width", "said"),
    [
        # 70 % of 2.75 m
        ("highway=residential lanes=2 width=5.5", 1.92, False),
        ("highway=service lanes=2 width=5", defaults.NARROWEST_LANE, True),
        ("highway=service lanes=2 width=3.6", defaults.NARROWEST_LANE, True),
        ("highway=service lanes=2 width:lanes:forward=1.7 width:lanes:backward=1.7", 1.7, True),
    ],
)
def test_lanes_for_cars_stay_wide_enough_for_cars(tags: str, width: float, said: bool) -> None:
    network = three_streets(2.9, tags).stages().network
    diagnostics = Diagnostics()
    found = separate_parallel_streets(network, fit_streets(network, Diagnostics()), diagnostics)
    assert [lane.width for lane in found.pieces[1][0][1].lanes_ltr] == [pytest.approx(width, abs=0.01)] * 2
    narrowed = [item.message for item in diagnostics if item.code == "lanes-narrowed" and item.osm_id == "way/2"]
    assert [f"below {defaults.NARROWEST_LANE:g} m" in message for message in narrowed] == [said]


@pytest.mark.parametrize(("highway", "moved"), [("residential", True), ("motorway_link", False)])
def test_streets_that_part_slowly_are_arms_only_as_far_as_a_junction_reaches(highway: str, moved: bool) -> None:
    """Both begin at one node, are 4.6 m apart after 30 m and stay so up to 95 m."""
    nodes = {"o": (0.0, 0.0), "a": (95.0, 0.0), "b": (30.0, 4.6), "c": (95.0, 4.6), "w": (-50.0, 0.0)}
    tags = f"highway={highway} width=5.5 oneway=no"
    found, reported = separated(Case(nodes, {1: ("o a", tags), 2: ("o b c", tags), 3: ("w o", tags)}))
    assert (drawn(found.pieces[0])[0][1] < 0.0) is moved
    assert reported.count("moved-aside") == (2 if moved else 0)


@pytest.mark.parametrize(("apart", "aside"), [(6.3, 0.0), (5.0, 0.31), (2.0, 0.0)])
def test_a_street_in_a_bend_fits_beside_the_one_that_it_touches(apart: float, aside: float) -> None:
    """A bend of 15 m in radius comes nearest between places of which none is abreast and parallel."""
    bend = {f"p{k}": (103.0 + 15.0 * math.sin(a), apart + 15.0 * (1.0 - math.cos(a))) for k, a in enumerate(_BEND)}
    nodes = {"a": (0.0, 0.0), "b": (200.0, 0.0), "c": (30.0, 90.0), **bend, "d": (180.0, 90.0)}
    ways = {1: ("a b", "width=6"), 2: (" ".join(["c", *bend, "d"]), "width=6")}
    found, reported = separated(Case(nodes, ways))
    assert min(middle for _, middle, _ in drawn(found.pieces[0])) == pytest.approx(-aside, abs=0.05)
    assert reported.count("moved-aside") == (2 if aside else 0)
