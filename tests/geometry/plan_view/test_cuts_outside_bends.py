"""Where roads end at tight bends: before them or beyond them, never within."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from street_cases import Case, Stages

from osm2xodr.geometry.defaults import HALF_NARROW_LANE
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.geometry.plan_view.cuts_outside_bends import places_clear_of_bends, trims_clear_of_bends
from osm2xodr.model import PlanView

# A T whose stem turns off squarely 20 m from the node.
BENT = Case(
    {"w": (-80.0, 0.0), "o": (0.0, 0.0), "e": (80.0, 0.0), "c": (0.0, -20.0), "d": (60.0, -20.0)},
    {1: ("w o", ""), 2: ("o e", ""), 3: ("o c d", "highway=service width=5")},
)


def bend(stages: Stages, end: int) -> tuple[float, float]:
    """Return where the arc of the end's street begins and ends, m from the node."""
    plan = stages.ends.plan_view
    records = range(int(plan.start[end // 2]), int(plan.start[end // 2 + 1]))
    (arc,) = (k for k in records if plan.curvature[k] != 0)
    return float(plan.s[arc]), float(plan.s[arc] + plan.length[arc])


def ended(trim: float, least: float, can_give: float = 80.0) -> tuple[float, float, float]:
    """Return where the road ends, and where the bend begins and ends, for a trim of the stem."""
    stages = BENT.stages()
    ends = stages.ends
    end = stages.end(3, 1)
    trims = np.zeros(len(ends.length))
    trims[end] = trim
    at_least = np.zeros(len(trims))
    at_least[end] = least
    most = np.full(len(trims), can_give)
    junction = np.where(np.arange(len(trims)) == end, 0, -1)
    found = trims_clear_of_bends(replace(ends), junction, trims, at_least, most)
    return float(found[end]), *bend(stages, end)


def test_an_end_in_a_bend_moves_beyond_it() -> None:
    begin, over = ended(0.0, 0.0)[1:]
    assert ended((begin + over) / 2, (begin + over) / 2)[0] == pytest.approx(over)


def test_an_end_stays_in_a_bend_where_its_street_cannot_give_that_much() -> None:
    begin, over = ended(0.0, 0.0)[1:]
    middle = (begin + over) / 2
    assert ended(middle, middle, over - 0.01)[0] == middle
    assert ended(middle, middle, over + 0.01)[0] == pytest.approx(over)


def test_an_end_moves_back_before_a_bend_where_its_junction_needs_no_more() -> None:
    begin = ended(0.0, 0.0)[1]
    widened = begin - 2.0
    assert begin - 3.0 - 0.1 < ended(widened, 5.0)[0] <= begin - 3.0
    # Not where that is more than turns need, nor where the junction does.
    assert ended(begin + 1.0, 5.0)[0] > begin + 1.0
    assert ended(widened, widened)[0] > widened


def test_an_end_far_from_bends_stays() -> None:
    begin = ended(0.0, 0.0)[1]
    assert defaults.BEND_IN_JUNCTION > 3.0
    assert ended(begin - 3.5, 2.0)[0] == begin - 3.5


@pytest.mark.parametrize("off", [-1e-12, 0.0, 1e-12])
def test_an_end_where_a_bend_is_over_stays(off: float) -> None:
    """Whichever side of the bend's end rounding puts it on, even though there would be room before the bend."""
    over = ended(0.0, 0.0)[2]
    assert ended(over + off, 0.0)[0] == pytest.approx(over, abs=1e-9)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_end_in_a_spiral_moves_to_where_it_is_gentle_enough(side: float) -> None:
    """From a circle of 25 m radius 30 m lead to a line: lanes 3 m off want 37.5 m, 20 m before its end."""
    stages = BENT.stages()
    end = stages.end(3, 1)
    rate = np.array([0.0, -side * 0.04 / 30.0, 0.0])
    bend, length = np.array([side * 0.04, side * 0.04, 0.0]), np.array([10.0, 30.0, 60.0])
    zero, s = np.zeros(3), np.array([0.0, 10.0, 40.0])
    streets = len(stages.ends.length) // 2
    start = np.where(np.arange(streets + 1) > end // 2, 3, 0)
    plan = PlanView(start, s, zero, zero, zero, length, bend, rate)
    edge = np.full(2 * streets, 3.0 + HALF_NARROW_LANE)
    ends = replace(stages.ends, plan_view=plan, left=edge, right=-edge, length=np.full(2 * streets, 100.0))
    junction = np.where(np.arange(2 * streets) == end, 0, -1)
    trim = np.where(junction == 0, 13.0, 0.0)
    found = trims_clear_of_bends(ends, junction, trim, trim, np.full(2 * streets, 80.0))
    assert found[end] == pytest.approx(20.0)


def bent(*length: float) -> PlanView:
    """Return a line, a bend of 6 m to the left and another line, of some length, m, as one curve."""
    plain, at = np.zeros(3), np.array(length)
    return PlanView(np.array([0, 3]), np.cumsum(at) - at, plain, plain, plain, at, np.array([0.0, 1 / 6, 0.0]))


@pytest.mark.parametrize(("side", "expected"), [(None, 36.0), (0, 36.0), (-1, 36.0), (1, 50.0)])
def test_a_place_moves_off_a_bend_to_the_side_that_it_should(side: int | None, expected: float) -> None:
    """A bend lies from s = 40 to 46: places are clear 3 m before it and 3 m behind it, in steps of 2 m from 42."""
    zero, edge = np.zeros(1, np.int64), np.array([3.0])
    sides = None if side is None else np.array([side])
    place, end = np.array([42.0]), np.array([100.0])
    found = places_clear_of_bends(bent(40.0, 6.0, 54.0), zero, place, -edge, edge, end, sides)
    assert found == pytest.approx([expected])


def test_a_place_moves_to_the_other_side_where_no_other_leads_off_a_bend() -> None:
    zero, edge = np.zeros(1, np.int64), np.array([3.0])
    place, end, side = np.array([42.0]), np.array([100.0]), np.array([1])
    found = places_clear_of_bends(bent(40.0, 40.0, 20.0), zero, place, -edge, edge, end, side)
    assert found == pytest.approx([36.0])
