"""Connecting roads keep to the carriageways of the streets inside their junction.

A curve from arm to arm may cut through what lies between bent streets, or swing out of them. What leaves the
carriageways is drawn along the way over the streets instead, whose corners are rounded.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Final

import numpy as np

from osm2xodr.curves import (
    PointTree,
    arctan2,
    chain_curves,
    chosen_curves,
    cosine,
    curve_ends,
    heading_change,
    hypot,
    lengths,
    pose,
    ranks,
    repeated,
    replace_curves,
    sine,
    smallest_radius,
    unique_inverse,
)
from osm2xodr.defaults import LEAST_TURN_BACK
from osm2xodr.geometry.connections.corner_paths import follow_corners, half_carriageways
from osm2xodr.geometry.connections.defaults import (
    LEAST_REDRAWN_RADIUS,
    LONGEST_REDRAWN,
    OFF_CARRIAGEWAY,
    TURNING_RADIUS_ACUTE,
)
from osm2xodr.geometry.connections.pose_to_pose import connect, detours, has_kinks, legs_through
from osm2xodr.geometry.connections.street_paths import (
    LEAST_RADIUS_ON_STREET,
    LanePaths,
    Poses,
    follow_streets,
    hardly_turn,
)
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

# Curves and streets are compared at places on both, m apart on streets and as shares of the curves.
_STREET_SPACING: Final = 1.0
_SHARES: Final = np.linspace(0.02, 0.98, 25)
# Every so manieth of these shares is compared first: for most curves that shows that they leave no carriageway.
_EVERY: Final = (6, 2, 1)
# What lies no farther from its way over the streets than this, m, at these shares of it, leaves no carriageway.
_NEAR: Final = 2.0
_FEW_SHARES: Final = np.array([0.3, 0.5, 0.7])
# Corners are rounded by taking the mean of places this far before and behind, m; places are this far apart, m, and
# lie at this share of the distance from the curve before to the rounded way: on it, or between for what leaves the
# carriageways by more than this, m. A choice.
ROUNDED: Final = (8.0, 16.0, 1.0)
_BETWEEN: Final = ((12.0, 16.0, 0.25), (12.0, 24.0, 0.55))
_FAR_OFF: Final = 1.5
# Curves as long as so many times their way are no longer than it.
_AS_LONG: Final = 1.1
# A curve is replaced if another one leaves the carriageways by so much less, m.
_LESS: Final = 0.5
# Turns are drawn with the largest radius between these, m, that keeps them to the carriageways; the range is halved
# so often, which finds it to 5 %. Smaller ones are tried at last, if nothing else does. Choices.
_RADII: Final = (LEAST_REDRAWN_RADIUS, 20.0, 5)
_SHARPEST: Final = (TURNING_RADIUS_ACUTE, LEAST_REDRAWN_RADIUS, 3)
# Curves have the first of these radii with which something helps, m, or that of the direct curve.
_LEAST_RADII: Final = (LEAST_REDRAWN_RADIUS, 0.0)
# How much less than this a curve leaves the carriageways decides nothing, m.
_NO_MATTER: Final = OFF_CARRIAGEWAY - _LESS

_Redraw = Callable[[PlanView, LanePaths, FloatArray], PlanView]


@dataclass(frozen=True, eq=False)
class Carriageways:
    """The streets that the connecting roads run on, and how wide they are."""

    lanes: LanePaths
    lines: PlanView  # OSM's lines of the streets
    half: FloatArray  # (n,) Half of the wider carriageway of the two arms of each connecting road, m
    arms: IntArray  # (n,) The same number for all connecting roads between the same two arms, there and back

    def beyond(self, plan: PlanView, curve: IntArray, row: IntArray, most: float | FloatArray = np.inf) -> FloatArray:
        """Return how far curves of a plan, drawn for some connecting roads, leave all carriageways, (curves,), m.

        A curve that is longer than its way over the streets runs on carriageways that are not its own: it counts as
        off by what it is longer. Of those that leave them by `_NO_MATTER` at most it is only an upper bound, which is
        no larger than that; of those that leave them by more than `most`, which is no less, some value above `most`.
        """
        length, half = lengths(plan, curve), self.half[row]
        back = np.abs(heading_change(plan, curve)) >= LEAST_TURN_BACK
        longer = np.where(back, -np.inf, length - _AS_LONG * self.lanes.length[row])
        most = np.broadcast_to(most, len(curve))
        distance = np.full((len(curve), len(_SHARES)), np.inf)
        out = np.full(len(curve), -np.inf)
        todo, known = np.flatnonzero(longer <= most), np.zeros(len(_SHARES), bool)
        for every in _EVERY:
            compared = np.arange(0, len(_SHARES), every)
            new = compared[~known[compared]]
            known[new] = True
            distance[np.ix_(todo, new)] = self._distances(plan, curve[todo], _SHARES[new])
            found = distance[np.ix_(todo, compared)]
            # Between two places, it is nowhere larger than if it grew by a metre per metre from both.
            between = np.diff(_SHARES[compared]) * length[todo, None]
            bound = found if every == 1 else (found[:, :-1] + found[:, 1:] + between) / 2
            out[todo] = bound.max(axis=1) - half[todo]
            todo = todo[(out[todo] > _NO_MATTER) & (found.max(axis=1) - half[todo] <= most[todo])]
            if not len(todo):
                break
        return np.maximum(out, longer)

    def _distances(self, plan: PlanView, curve: IntArray, shares: FloatArray) -> FloatArray:
        """Return the distances from the streets at shares of curves, (curves, shares), m."""
        each = np.repeat(curve, len(shares))
        x, y, _ = pose(plan, each, np.tile(shares, len(curve)) * lengths(plan, each))
        return np.reshape(self._places.nearest(np.column_stack([x, y]))[0], (len(curve), len(shares)))

    @cached_property
    def _places(self) -> PointTree:
        """Places on OSM's lines of all streets that the ways lead over."""
        paths = self.lanes.paths
        legs = np.column_stack([paths.curve, np.minimum(paths.s_from, paths.s_to), np.abs(paths.s_to - paths.s_from)])
        legs = np.unique(legs, axis=0)
        count = np.maximum(np.ceil(legs[:, 2] / _STREET_SPACING), 1).astype(np.int64) + 1
        of = repeated(count)
        s = legs[of, 1] + ranks(count) * (legs[:, 2] / (count - 1))[of]
        street = legs[of, 0].astype(np.int64)
        x, y, _ = pose(self.lines, street, s * (lengths(self.lines, street) / lengths(self.lanes.streets, street)))
        return PointTree(np.column_stack([x, y]))


def carriageways(lanes: LanePaths, ends: StreetEnds, entry: IntArray, exit_: IntArray) -> Carriageways:
    """Return the carriageways of connecting roads from street ends to street ends, (n,)."""
    arms = np.minimum(entry, exit_) * len(ends.left) + np.maximum(entry, exit_)
    half = np.maximum(half_carriageways(ends, entry), half_carriageways(ends, exit_))
    return Carriageways(lanes, ends.lines, half, arms)


def keep_to_carriageways(direct: PlanView, streets: Carriageways) -> PlanView:
    """Replace those of the direct curves, (n,), that leave the carriageways by such as leave them less.

    Curves follow smooth streets. Others turn as widely as the carriageways allow, turn at the corners of their way,
    or run along it with its corners rounded: the first of these that keeps to the carriageways, else what leaves them
    least. What cars hardly drive is tried last. All lanes between two arms, there and back, change together.
    """
    plan = follow_streets(direct, streets.lanes)
    rows = _far_from_their_way(plan, streets)
    if not len(rows):
        return plan
    drawing = _Drawing(plan, rows, streets)
    last = np.inf
    for least in _LEAST_RADII:
        # A lower limit allows more only where a direct curve is sharper than the last one.
        drawing.redraw(least, last)
        last = least
    return replace_curves(plan, rows, drawing.turns, np.arange(len(rows))) if drawing.changed else plan


class _Drawing:
    """Curves of a plan that may leave the carriageways, the turns, are drawn again.

    Attributes
    ----------
    turns
        Their curves, (n,).
    changed
        Whether any of them has changed.
    off
        How far they leave the carriageways, (n,), m.
    """

    def __init__(self, plan: PlanView, rows: IntArray, streets: Carriageways) -> None:
        back = np.abs(heading_change(plan, rows)) >= LEAST_TURN_BACK
        self.turns, self.off, self.changed = chosen_curves(plan, rows), streets.beyond(plan, rows, rows), False
        self._rows, self._streets = rows, streets
        self._number = streets.arms[rows]
        self._radius = smallest_radius(plan)[rows]  # Of the direct curves, m
        # And of what may be drawn instead where the direct curves are no sharper, m
        self._sharpest = np.where(
            hardly_turn(plan, rows, streets.lanes.chosen(rows)), LEAST_RADIUS_ON_STREET, LEAST_REDRAWN_RADIUS
        )
        self._least = 0.0  # What is drawn instead has this radius at least, m, or that of the direct curve
        self._longest = np.where(back, np.inf, LONGEST_REDRAWN * lengths(plan, rows))  # And is no longer than this, m
        self._outside = _outside(plan, rows, streets)  # How far outside the innermost way of their arms, m

    def redraw(self, least: float, sharper: float) -> None:
        """Draw the turns that leave the carriageways, and whose direct curve is `sharper` than this radius, m.

        Their radius is `least` at least, m, or that of the direct curve.
        """
        self._least = least
        place = self.off_by_more(OFF_CARRIAGEWAY, np.flatnonzero(_of_same(self._radius < sharper, self._number)))
        self.turn(place, *_RADII)
        for redraw, limit in _REDRAWINGS:
            place = self.off_by_more(limit, place)
            self.draw_if_less(redraw, place)
        self.turn(self.off_by_more(OFF_CARRIAGEWAY, place), *_SHARPEST, enough=_SHARPEST[0] - 1e-9)

    def off_by_more(self, limit: float, place: IntArray) -> IntArray:
        """Return those of some turns that leave the carriageways by more than a limit, m, or lie beside such."""
        return place[_of_same(self.off[place] > limit, self._number[place])]

    def draw(self, redraw: _Redraw, place: IntArray, most: FloatArray, enough: float = np.inf) -> IntArray:
        """Draw turns anew, and take the curves that leave the carriageways by `most` at most, (place,), m.

        None is sharper than its turn may be, unless its radius is `enough`, m. Those between the same arms change
        together. Return which have changed, as positions in `place`.
        """
        if not len(place):
            return place
        streets, rows, number = self._streets, self._rows[place], self._number[place]
        smallest = np.maximum(self._least, np.minimum(self._radius[place], self._sharpest[place])) - 1e-9
        drawn = redraw(chosen_curves(self.turns, place), streets.lanes.chosen(rows), self._outside[place])
        bad = smallest_radius(drawn) < np.minimum(smallest, enough)
        bad |= (lengths(drawn) > self._longest[place]) | has_kinks(drawn) | detours(drawn)
        good = np.flatnonzero(~_of_same(bad, number))
        if not len(good):
            return good
        beyond = streets.beyond(drawn, good, rows[good], most[good])
        kept = ~_of_same(beyond > most[good], number[good])
        good = good[kept]
        if len(good):
            self.turns, self.changed = replace_curves(self.turns, place[good], drawn, good), True
            self.off[place[good]] = beyond[kept]
        return good

    def draw_if_less(self, redraw: _Redraw, place: IntArray, enough: float = np.inf) -> IntArray:
        """Draw turns anew where that keeps them to the carriageways, or leaves these less; return which of them."""
        return self.draw(redraw, place, np.maximum(self.off[place] - _LESS, OFF_CARRIAGEWAY), enough)

    def turn(self, place: IntArray, least: float, largest: float, rounds: int, enough: float = np.inf) -> None:
        """Draw turns with the largest radius, m, that keeps them to the carriageways, or with the least of all."""
        place = place[self.draw_if_less(partial(_turned, radius=np.full(len(place), least)), place, enough)]
        place = place[~_of_same(self.off[place] > OFF_CARRIAGEWAY, self._number[place])]
        lower, upper, most = (np.full(len(place), value) for value in (least, largest, OFF_CARRIAGEWAY))
        for _ in range(rounds):
            radius = np.sqrt(lower * upper)
            fits = np.zeros(len(place), bool)
            fits[self.draw(partial(_turned, radius=radius), place, most, enough)] = True
            lower, upper = np.where(fits, radius, lower), np.where(fits, upper, radius)


def _outside(plan: PlanView, rows: IntArray, streets: Carriageways) -> FloatArray:
    """Return how far outside the innermost way between the same two arms, there and back, curves lie, (rows,), m."""
    lanes = streets.lanes
    inwards = np.sign(heading_change(plan, rows)) * (lanes.t_in[rows] + lanes.t_out[rows]) / 2
    group = unique_inverse(streets.arms[rows])[1]
    innermost = np.full(len(rows), -np.inf)
    np.maximum.at(innermost, group.ravel(), inwards)
    out: FloatArray = innermost[group.ravel()] - inwards
    return out


def _of_same(which: BoolArray, number: IntArray) -> BoolArray:
    """Say which rows have the same number as one of the marked rows, (n,)."""
    return np.isin(number, number[which]) if which.any() else which


def _far_from_their_way(plan: PlanView, streets: Carriageways) -> IntArray:
    """Return the curves that may lie aside of the carriageways."""
    lanes, total = streets.lanes, lengths(plan)
    rows = np.flatnonzero((total > 2 * _NEAR) & (np.diff(plan.start) > 0))
    far = np.zeros(len(rows), bool)
    for share in _FEW_SHARES:
        x, y, _ = pose(plan, rows, share * total[rows])
        px, py, _ = lanes.at_share(rows, np.full(len(rows), share))
        far |= hypot(x - px, y - py) > _NEAR
    return rows[_of_same(far, streets.arms[rows])]


def _turned(plan: PlanView, lanes: LanePaths, outside: FloatArray, radius: FloatArray) -> PlanView:
    """Return curves with the same ends that turn with an arc between lines.

    The innermost one has its radius, (n,), m, and the others turn about its centre.
    """
    begin, end = curve_ends(plan)
    return connect(*begin, *end, radius=radius + outside, longest=LONGEST_REDRAWN)


def along_the_way(plan: PlanView, lanes: LanePaths, rounding: tuple[float, float, float]) -> PlanView:
    """Return curves with the same ends that run along their ways, or between; `rounding` is as `ROUNDED`."""
    reach, spacing, share = rounding
    count = np.maximum((lanes.length / spacing).astype(np.int64), 1)
    of = repeated(count)
    run, length = (ranks(count) + 0.5) / count[of], lengths(plan)[of]
    x, y, hdg = _rounded(lanes, of, run * lanes.length[of], reach)
    if share < 1:
        cx, cy, before = pose(plan, of, run * length)
        x, y = share * x + (1 - share) * cx, share * y + (1 - share) * cy
        # The direction in which the place moves as both of those do.
        there, here = share * lanes.length[of], (1 - share) * length
        hdg = arctan2(there * sine(hdg) + here * sine(before), there * cosine(hdg) + here * cosine(before))
    begin, end = curve_ends(plan)
    one, other, first = legs_through(begin, (x, y, hdg), end, count)
    return chain_curves(connect(*one, *other), first)


def _rounded(lanes: LanePaths, row: IntArray, chainage: FloatArray, rounding: float) -> Poses:
    """Return poses on the ways over the streets with their corners rounded, (m,)."""
    reach = np.minimum(np.minimum(chainage, lanes.length[row] - chainage), rounding)
    around = np.concatenate([chainage - reach, chainage, chainage + reach])
    places = lanes.at_chainage(np.tile(row, 3), around)
    (x0, x, x1), (y0, y, y1) = (np.reshape(column, (3, len(row))) for column in places[:2])
    return (x0 + 2 * x + x1) / 4, (y0 + 2 * y + y1) / 4, arctan2(y1 - y0, x1 - x0)


def _along_the_way(
    plan: PlanView, lanes: LanePaths, outside: FloatArray, rounding: tuple[float, float, float]
) -> PlanView:
    return along_the_way(plan, lanes, rounding)


def _at_corners(plan: PlanView, lanes: LanePaths, outside: FloatArray) -> PlanView:
    return follow_corners(plan, lanes)


# In the order in which they are tried, for what leaves the carriageways by more than what, m.
_REDRAWINGS: Final[tuple[tuple[_Redraw, float], ...]] = (
    (_at_corners, OFF_CARRIAGEWAY),
    (partial(_along_the_way, rounding=ROUNDED), OFF_CARRIAGEWAY),
    *((partial(_along_the_way, rounding=item), _FAR_OFF) for item in _BETWEEN),
)
