"""Where a reference line moves out of a tight bend: near the ends of its road, and where its lanes change."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from lane_cases import street

from osm2xodr.curves import lengths
from osm2xodr.geometry.junctions import JunctionLayout, RoadParts, shift_lines_out_of_bends
from osm2xodr.geometry.lanes import Stretch, cross_section
from osm2xodr.geometry.plan_view import FittedStreets
from osm2xodr.model import PlanView, Rule, StreetAttributes

# A straight line of 20 m, a quarter of a circle of 5 m radius, another line of 20 m.
_ARC = 5.0 * math.pi / 2
_LAST = 20.0 + _ARC
_AROUND = _LAST + 20.0
_TWO, _FOUR = street("d< d>", width=3.0), street("d< d< d> d>", width=3.0)


def _moved(
    begin: float = 0.0,
    end: float = _AROUND,
    change: float | None = None,
    *,
    turns: float = 1.0,
    radius: float = 5.0,
    lanes: StreetAttributes = _TWO,
) -> tuple[FittedStreets, JunctionLayout]:
    """Move the line of street 1, a bend to the left, of which a road is left; street 0 is straight."""
    curvature = turns / radius
    plan = PlanView(
        np.array([0, 1, 4]),
        np.array([0.0, 0.0, 20.0, _LAST]),
        np.array([0.0, 0.0, 20.0, 25.0]),
        np.array([50.0, 0.0, 0.0, turns * 5.0]),
        np.array([0.0, 0.0, 0.0, turns * math.pi / 2]),
        np.array([90.0, 20.0, _ARC, 20.0]),
        np.array([0.0, 0.0, curvature, 0.0]),
    )
    return _moved_line(plan, begin, end, change, lanes)


def _moved_line(
    plan: PlanView, begin: float, end: float, change: float | None, lanes: StreetAttributes = _TWO
) -> tuple[FittedStreets, JunctionLayout]:
    """Move the line of street 1, of which a road is left, and whose lanes may change in one place."""
    around = float(lengths(plan)[1])
    section = cross_section(lanes, Rule.RIGHT_HAND)
    borders = [0.0] if change is None else [0.0, change]
    pieces = tuple((s, lanes, section) for s in borders)
    first = Stretch(0.0, 90.0, lanes, section, (1,))
    edges = [begin, *borders[1:], end]
    second = tuple(Stretch(one - begin, other - begin, lanes, section, (2,)) for one, other in pairwise(edges))
    fitted = FittedStreets(plan, (((0.0, lanes, section),), pieces), np.zeros(2), np.zeros(2, bool))
    length = np.array([90.0, end - begin])
    parts = RoadParts(
        plan_view=plan,
        length=length,
        street=np.array([0, 1]),
        begin=np.array([0.0, begin]),
        end=np.array([90.0, end]),
        road_end=np.arange(4),
        end_junction=np.full((2, 2), -1),
        end_link=np.full((2, 2), -1),
        stretches=((first,), second),
        fitted=fitted,
        pieces=fitted.pieces,
    )
    layout = JunctionLayout(
        arms=(),
        nodes=(),
        junction=np.full(4, -1),
        inner=np.zeros(2, bool),
        trim=np.array([1.0, 2.0, begin, around - end]),
        most=np.array([1.0, 2.0, begin, around - end]),
        squeezed=np.zeros(2, bool),
        least=np.ones(2),
    )
    return shift_lines_out_of_bends(fitted, layout, parts, Rule.RIGHT_HAND)


@pytest.mark.parametrize(
    ("begin", "end", "change", "moves"),
    [
        (0.0, _AROUND, None, False),
        # Three metres within the road from its ends are looked at.
        (16.9, _AROUND, None, False),
        (17.1, _AROUND, None, True),
        (_LAST - 0.01, _AROUND, None, True),
        (_LAST + 0.01, _AROUND, None, False),
        (0.0, _LAST + 3.1, None, False),
        (0.0, _LAST + 2.9, None, True),
        (0.0, 20.01, None, True),
        (0.0, 19.99, None, False),
        # An end where line and arc meet lies on the road's side of that.
        (0.0, 20.0, None, False),
        (_LAST, _AROUND, None, False),
        # Where lanes change, three metres to either side.
        (0.0, _AROUND, 16.9, False),
        (0.0, _AROUND, 17.1, True),
        (0.0, _AROUND, 24.0, True),
        (0.0, _AROUND, _LAST + 2.9, True),
        (0.0, _AROUND, _LAST + 3.1, False),
        (10.0, _AROUND, 17.1, True),
        (10.0, _AROUND, 16.9, False),
        (16.0, _AROUND, _LAST + 3.1, False),
        # A road that is shorter than what is looked at.
        (15.0, 17.0, None, False),
        (_LAST + 0.1, _LAST + 0.5, None, False),
    ],
)
@pytest.mark.parametrize("turns", [1.0, -1.0])
def test_bends_matter_near_ends_and_where_lanes_change(
    begin: float, end: float, change: float | None, moves: bool, turns: float
) -> None:
    """The outer lane, 1.6 m beside the line, is less than 8 % longer once the line has moved three quarters there."""
    fitted, layout = _moved(begin, end, change, turns=turns)
    aside = -1.2 * turns if moves else 0.0
    assert (1 + 1.6 / 5) / (1 + 1.2 / 5) < 1.08 < (1 + 1.6 / 5) / (1 + 0.8 / 5)
    assert fitted.aside.tolist() == pytest.approx([0.0, aside], abs=1e-12)
    # The arc is longer by the angle that it turns; what lies before and behind it is as long as before.
    longer = abs(aside) * math.pi / 2
    assert lengths(fitted.plan_view).tolist() == pytest.approx([90.0, _AROUND + longer])

    def station(s: float) -> float:
        return s + longer * min(max((s - 20.0) / _ARC, 0.0), 1.0)

    assert [s for s, _, _ in fitted.pieces[1]] == pytest.approx([0.0] if change is None else [0.0, station(change)])
    trim = [1.0, 2.0, station(begin), _AROUND + longer - station(end)]
    assert layout.trim.tolist() == pytest.approx(trim)
    section = fitted.pieces[1][-1][2]
    assert (section.left_edge, section.centre, section.right_edge) == pytest.approx(
        (3.0 - aside, -aside, -3.0 - aside)
    )
    assert fitted.pieces[0][0][2].left_edge == 3.0


@pytest.mark.parametrize(
    ("radius", "lanes", "aside"),
    [
        # (1 + outer / radius) / (1 + aside / radius) is 1.08 at most, by the smallest quarter that does.
        (22.0, _TWO, 0.0),
        (20.02, _TWO, 0.0),
        (19.98, _TWO, -0.4),
        (18.0, _TWO, -0.4),
        (10.0, _TWO, -0.8),
        (5.0, _TWO, -1.2),
        (2.2, _TWO, -1.6),
        # In centimetres: three quarters of 1.65 m.
        (5.0, street("d< d>", width=3.05), -1.24),
        (45.0, _FOUR, -1.15),
        (40.0, _FOUR, -2.3),
        (25.0, _FOUR, -3.45),
        (12.0, _FOUR, -3.45),
    ],
)
@pytest.mark.parametrize("turns", [1.0, -1.0])
def test_lines_move_no_farther_than_they_must(
    radius: float, lanes: StreetAttributes, aside: float, turns: float
) -> None:
    fitted, _ = _moved(18.0, radius=radius, lanes=lanes, turns=turns)
    assert fitted.aside[1] == pytest.approx(turns * aside, abs=1e-12)


def _along(*records: tuple[float, float]) -> PlanView:
    """Return a line of 90 m, and one of records of length and curvature."""
    x, y, hdg = 0.0, 0.0, 0.0
    rows = [(0.0, 0.0, 50.0, 0.0, 90.0, 0.0)]
    s = 0.0
    for length, curvature in records:
        rows.append((s, x, y, hdg, length, curvature))
        # The chord of an arc.
        half = 0.5 * length * curvature
        chord = length * (math.sin(half) / half if half else 1.0)
        x, y = x + chord * math.cos(hdg + half), y + chord * math.sin(hdg + half)
        s, hdg = s + length, hdg + length * curvature
    return PlanView(np.array([0, 1, len(rows)]), *(np.array(column) for column in zip(*rows, strict=True)))


@pytest.mark.parametrize("turns", [1.0, -1.0])
@pytest.mark.parametrize(
    ("radius", "aside"),
    [(20.0, -1.2), (2.1, -1.2), (1.9, -0.8), (1.4, -0.8), (1.3, -0.4), (0.7, -0.4), (0.6, 0.0)],
)
def test_no_bend_of_the_other_hand_shrinks_to_less_than_two_fifths(radius: float, aside: float, turns: float) -> None:
    """A line that is moved out of the bend at its start runs inside of a later one."""
    other = radius * math.pi / 2
    plan = _along((20.0, 0.0), (_ARC, turns / 5.0), (20.0, 0.0), (other, -turns / radius), (20.0, 0.0))
    fitted, _ = _moved_line(plan, 18.0, 60.0 + _ARC + other, None)
    assert fitted.aside[1] == pytest.approx(turns * aside, abs=1e-12)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("away", [0.0, 0.25, 0.5, 1.5, 2.75, 3.0, 3.25])
def test_bends_however_short_matter_up_to_three_metres_from_a_change_of_lanes(away: float, side: float) -> None:
    """An arc of 0.2 m length and 5 m radius."""
    plan = _along((40.0, 0.0), (0.2, 0.2), (40.0, 0.0))
    fitted, _ = _moved_line(plan, 0.0, 80.2, 40.1 + side * away)
    assert (fitted.aside[1] != 0.0) == (away <= 3.0)


@pytest.mark.parametrize("away", [0.0, 0.25, 0.5, 1.5, 2.75, 3.0, 3.25])
def test_bends_however_short_matter_up_to_three_metres_from_ends(away: float) -> None:
    plan = _along((40.0, 0.0), (0.2, 0.2), (40.0, 0.0))
    for begin, end in ((40.1 - away, 80.2), (0.0, 40.1 + away)):
        fitted, _ = _moved_line(plan, begin, end, None)
        assert (fitted.aside[1] != 0.0) == (away <= 3.0)
