"""Reference lines of connecting roads on which carriageways keep their crossfall where they part or join.

A connecting road runs along the middle of its lane. Where its arms fall to one side, that middle lies higher or lower
than their reference lines, but for readers that ignore superelevation it does not: they would find a step at every
link. A connecting road that runs from reference line to reference line, with its lane beside it, has the height of
both, for all readers. The lane stays where it was.
"""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import (
    RaggedTable,
    Table,
    chosen_curves,
    cosine,
    cubic_slope,
    cubic_value,
    find_record,
    heading_change,
    lengths,
    owners,
    pose,
    profile_of,
    replace_curves,
    sine,
    slope_of,
    smallest_radius,
    smooth_step,
    starts,
    wrapped,
)
from osm2xodr.geometry.connections import ConnectingRoads, connect
from osm2xodr.geometry.heights import (
    ProfileProblem,
    either_profile,
    end_poses,
    fast_spans,
    hermite_cubics,
    one_way_fast_ends,
    only_curves,
    spread_curves,
)
from osm2xodr.geometry.junction_floor import Floor
from osm2xodr.model import BoolArray, Cubic, CubicProfile, FloatArray, IntArray, PlanView
from osm2xodr.system import record

# The lanes of a junction that keeps its crossfall turn by this at most, rad, and lie askew to their reference lines
# by this at most, rad. Choices: carriageways that part within 30 m; gores are far more acute.
_MOST_TURN: Final = 0.35
_MOST_ASKEW: Final = 0.5
# At junctions with warped arms no lane turns by more than this, rad: a line from an arm back to itself has no length.
_TURNS_ROUND: Final = 2.6
# A lane beside the inside of a bend reaches this far toward the bend's middle, as a share of the radius.
_MOST_FOLDED: Final = 0.75
# Beside such a line a lane lies no farther off than at both ends by more than this, m.
_MOST_APART: Final = 0.5
# Widths of lanes across such a line change by at most this per metre. A choice: 1 in 5 is a funnel.
_FASTEST_WIDENING: Final = 0.1
# Least radius of these reference lines, m: lanes lie beside them, on either side. A choice.
_LEAST_RADIUS: Final = 25.0
# Rounds of Newton's method for places abreast of each other, which nearly straight curves reach at once.
_ROUNDS: Final = 6
# Places nearer to each other than this are one knot, m.
_SAME_PLACE: Final = 0.05
# Cubics that differ by less than this where the second ends are one, m. A choice: far below what is seen.
_SAME_CUBIC: Final = 1e-4
# So are those whose coefficients about s = 0 all differ by less: ASAM's checker calls them redundant.
_REDUNDANT: Final = 1e-6
# Pieces longer than this have a place half-way, m. A choice.
_LONG: Final = 2.0
# Least length of one curve beside that of the other: keeps quotients finite in bends that fold.
_LEAST_SHARE: Final = 0.1


@record(eq=False)
class Kinked(RaggedTable):
    """Values at places along curves, with a slope on either side: one cubic from each place to the next.

    What lies beside a curve has another slope along it where its curvature steps.
    """

    start: IntArray  # (n + 1,) Index of each curve's first place
    # (places,)
    s: FloatArray
    value: FloatArray
    before: FloatArray  # Slope up to the place
    after: FloatArray  # Slope from the place on

    @property
    def curve(self) -> IntArray:
        """The curve of each place, (places,)."""
        return owners(self.start)

    def records(self) -> CubicProfile:
        """Return the cubics, those that only continue the one before joined with it, until none does."""
        profile = hermite_cubics(self.start, self.s, self.value, self.before, self.after)
        begin = np.delete(np.arange(len(self.s)), self.start[1:] - 1)
        h, into = self.s[begin + 1] - self.s[begin], self.before[begin + 1]
        bend = np.diff(profile.c) - 3 * profile.d[:-1] * h[:-1]
        steps = (profile.b[1:] - into[:-1], bend, np.diff(profile.d))
        slope, second, third = (np.abs(step) for step in steps)
        same = h[1:] * (slope + h[1:] * (second + h[1:] * third)) < _SAME_CUBIC
        same |= _redundant(*steps, self.s[begin[1:]])
        keep = np.ones(len(self.s), bool)
        keep[begin[1:][same]] = False
        keep[self.start[:-1]] = True
        if keep.all():
            return profile
        columns = (column[keep] for column in (self.s, self.value, self.before, self.after))
        return Kinked(starts(np.bincount(self.curve[keep])), *columns).records()


def _redundant(b: FloatArray, c: FloatArray, d: FloatArray, s: FloatArray) -> BoolArray:
    """Whether cubics are those before, given what their coefficients change by at the places s, m, between."""
    about_0 = (s * (s * (c - s * d) - b), b - s * (2 * c - 3 * s * d), c - 3 * s * d, d)
    return np.asarray((np.abs(np.stack(about_0)) < _REDUNDANT).all(axis=0))


@record(eq=False)
class CrossfallLines(Table):
    """Reference lines of some connecting roads, from that of the road before to that of the road behind."""

    row: IntArray  # (n,) The connecting roads, in ascending order
    plan_view: PlanView  # n curves
    middle: Kinked  # How far left of them the lane's middle lies, m; n curves
    wider: Kinked  # How many times as wide as the lane what the lines' normals cut from it is, at the same places


def find_crossfall_lines(
    problem: ProfileProblem, connecting: ConnectingRoads, sloping: BoolArray
) -> tuple[BoolArray, BoolArray, CrossfallLines]:
    """Return which junctions crossfall may run through, which may have warped arms, (J,), and their reference lines.

    The lines are those of the connecting roads of these junctions. Crossfall runs through where all arms are built
    for speed and driven one way, and all lanes lead nearly straight on; warped are arms of slower roads at the
    junctions that are `sloping`, (J,).
    """
    carried = _straight_junctions(problem, connecting)
    warped = _turning_junctions(problem, connecting) & sloping & ~carried
    beside = connecting.beside_cars() | connecting.joins_cars
    row = np.flatnonzero((carried | warped)[connecting.junction] & ~beside)
    lane = chosen_curves(connecting.plan_view, row)
    x, y, hdg = end_poses(problem)
    entry, exit_, junction = connecting.entry[row], connecting.exit[row], connecting.junction[row]
    at_start = np.arange(len(hdg)) % 2 == 0
    leaving, arriving = hdg + np.where(at_start, np.pi, 0.0), hdg + np.where(at_start, 0.0, np.pi)
    line = connect(x[entry], y[entry], leaving[entry], x[exit_], y[exit_], arriving[exit_])
    middle, wider = _lanes_beside(lane, line)
    askew = (wider.value * cosine(_MOST_ASKEW) > 1.0) | (wider.value < 1.0)
    half = 0.5 * np.maximum(connecting.entry_width, connecting.exit_width)[row][middle.curve]
    bend = np.stack([_curvature(line, middle.curve, middle.s, before) for before in (True, False)])
    folds = (bend * middle.value + np.abs(bend) * half > _MOST_FOLDED).any(axis=0)
    lines = CrossfallLines(row, line, middle, wider)
    ends = np.stack([middle.value[middle.start[:-1]], middle.value[middle.start[1:] - 1]])[:, middle.curve]
    folds |= np.abs(middle.value - np.clip(middle.value, ends.min(axis=0), ends.max(axis=0))) > _MOST_APART
    width = _lane_widths(lines, on_crossfall_lines(connecting, lines))
    folds |= np.maximum(np.abs(width.before), np.abs(width.after)) > _FASTEST_WIDENING
    carried[junction[middle.curve[askew]]] = warped[junction[middle.curve[askew | folds]]] = False
    carried[junction[smallest_radius(line) < _LEAST_RADIUS]] = False
    fits = (carried | warped)[junction]
    return carried, warped, lines.chosen(fits)


def _turning_junctions(problem: ProfileProblem, connecting: ConnectingRoads) -> BoolArray:
    """Return the junctions without an arm that is built for speed, and without ways that turn round, (J,)."""
    junction = problem.end_junction.ravel()
    fits = np.zeros(len(problem.junction_xy), bool)
    fits[connecting.junction] = True
    fast = np.repeat(np.add.reduceat(fast_spans(problem), problem.span_start[:-1], dtype=np.int64) > 0, 2)
    fits[junction[(junction >= 0) & fast]] = False
    cars = np.flatnonzero(~(connecting.beside_cars() | connecting.joins_cars))
    turn = np.abs(heading_change(connecting.plan_view, cars))
    fits[connecting.junction[cars[(turn > _TURNS_ROUND) | (connecting.entry[cars] == connecting.exit[cars])]]] = False
    return fits


def _straight_junctions(problem: ProfileProblem, connecting: ConnectingRoads) -> BoolArray:
    """Return the junctions whose arms are all fast and one-way, and whose lanes all lead nearly straight on, (J,)."""
    junction = problem.end_junction.ravel()
    fits = np.zeros(len(problem.junction_xy), bool)
    fits[connecting.junction] = True
    fits[junction[(junction >= 0) & (one_way_fast_ends(problem) == 0)]] = False
    row = np.flatnonzero(fits[connecting.junction])
    plain = ~(connecting.beside_cars() | connecting.joins_cars)[row]
    straight = plain & ~connecting.against[row] & (np.abs(heading_change(connecting.plan_view, row)) <= _MOST_TURN)
    fits[connecting.junction[row[~straight]]] = False
    return fits


def _lanes_beside(lane: PlanView, line: PlanView) -> tuple[Kinked, Kinked]:
    """Return how far left of the lines, (n,), the middles of their lanes lie, m, and how much wider these are there.

    The line's normal cuts the lane askew: both are tan and 1 / cos of the angle between them, in slope and value.
    """
    every = np.arange(len(line.start) - 1)
    # Where the curvature of either changes, and half-way between.
    joint = np.setdiff1d(np.arange(len(lane.s)), lane.start[:-1])
    of = owners(lane.start)[joint]
    beside = _abreast(line, of, lane.x[joint], lane.y[joint], lane.s[joint] / lengths(lane)[of])
    curve = np.concatenate([every, owners(line.start), of])
    curve, at = _places(curve, np.concatenate([lengths(line), line.s, beside]))
    gap = np.flatnonzero((curve[1:] == curve[:-1]) & (np.diff(at) > _LONG))
    half_way = (at[gap] + at[gap + 1]) / 2
    curve, at = _places(np.concatenate([curve, curve[gap]]), np.concatenate([at, half_way]))
    x, y, hdg = pose(line, curve, at)
    u = _cut_by_normals(lane, curve, x, y, hdg, at / lengths(line)[curve])
    px, py, lane_hdg = pose(lane, curve, u)
    left = (py - y) * cosine(hdg) - (px - x) * sine(hdg)
    askew = wrapped(lane_hdg - hdg)
    start = np.searchsorted(curve, np.arange(len(every) + 1)).astype(np.int64)
    askew[start[:-1]] = askew[start[1:] - 1] = 0.0
    tan, wider = slope_of(askew), 1.0 / cosine(askew)
    slopes, changes = [], []
    for before in (True, False):
        here, there = _curvature(line, curve, at, before), _curvature(lane, curve, u, before)
        along = 1.0 - here * left
        slopes.append(along * tan)
        changes.append(wider * tan * (there * along * wider - here))
    return Kinked(start, at, left, *slopes), Kinked(start, at, wider, *changes)


def _curvature(plan: PlanView, curve: IntArray, s: FloatArray, before: bool = False) -> FloatArray:
    """Return the curvature at s of curves, (m,), 1/m, or its limit from before."""
    k = find_record(plan.start, plan.s, curve, s, before=before)
    return np.asarray(plan.curvature[k] + plan.rate[k] * (s - plan.s[k]))


def _places(curve: IntArray, s: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return places along curves in order, those that are too near to the one before left out, but for their ends."""
    order = np.lexsort((s, curve))
    curve, s = curve[order], s[order]
    same = curve[1:] == curve[:-1]
    near = same & (np.diff(s) < _SAME_PLACE)
    first, last = np.ones((2, len(s)), bool)
    first[1:] = last[:-1] = ~same
    keep = np.ones(len(s), bool)
    keep[1:] &= ~near | last[1:]
    # What lies right before an end makes way for it.
    keep[:-1] &= ~(near & last[1:]) | first[:-1]
    return curve[keep], s[keep]


def _abreast(line: PlanView, curve: IntArray, x: FloatArray, y: FloatArray, share: FloatArray) -> FloatArray:
    """Return s of the places on lines whose normals go through points, (m,), from a guess as shares of lengths."""
    length = lengths(line)[curve]
    s = share * length
    for _ in range(_ROUNDS):
        lx, ly, hdg = pose(line, curve, s)
        along = (x - lx) * cosine(hdg) + (y - ly) * sine(hdg)
        left = (y - ly) * cosine(hdg) - (x - lx) * sine(hdg)
        s = np.clip(s + along / np.maximum(1.0 - _curvature(line, curve, s) * left, _LEAST_SHARE), 0.0, length)
    return s


def _cut_by_normals(
    lane: PlanView, curve: IntArray, x: FloatArray, y: FloatArray, hdg: FloatArray, share: FloatArray
) -> FloatArray:
    """Return s of the places at which lanes are cut by the normals of poses, (m,), likewise."""
    length = lengths(lane)[curve]
    s = share * length
    for _ in range(_ROUNDS):
        px, py, phdg = pose(lane, curve, s)
        along = (px - x) * cosine(hdg) + (py - y) * sine(hdg)
        s = np.clip(s - along / np.maximum(cosine(phdg - hdg), _LEAST_SHARE), 0.0, length)
    return s


def on_crossfall_lines(connecting: ConnectingRoads, lines: CrossfallLines) -> ConnectingRoads:
    """Return connecting roads of which some have other reference lines, and their lanes beside them."""
    row, middle = lines.row, lines.middle
    plan = replace_curves(connecting.plan_view, row, lines.plan_view, np.arange(len(row)))
    columns = {name: getattr(connecting, name).copy() for name in ("entry_t", "exit_t", "entry_aside", "exit_aside")}
    columns["entry_t"][row] = columns["exit_t"][row] = 0.0
    columns["entry_aside"][row] = middle.value[middle.start[:-1]]
    columns["exit_aside"][row] = middle.value[middle.start[1:] - 1]
    return replace(connecting, plan_view=plan, length=lengths(plan), **columns)


def lane_offsets_beside(
    lines: CrossfallLines, connecting: ConnectingRoads, side: FloatArray, usual: CubicProfile
) -> CubicProfile:
    """Return the lane offsets of C connecting roads, of which some run on such lines; `usual` are all others'.

    `side`, (C,), is -1 where lanes lie left of their inner edge, 1 where they lie right of it.
    """
    width, middle = _lane_widths(lines, connecting), lines.middle
    half = 0.5 * side[lines.row][middle.curve]
    value, before, after = (
        getattr(middle, name) + half * getattr(width, name) for name in ("value", "before", "after")
    )
    own = Kinked(middle.start, middle.s, value, before, after).records()
    others = np.ones(len(connecting.length), bool)
    others[lines.row] = False
    return either_profile(spread_curves(own, lines.row, len(others)), only_curves(usual, others))


def lane_widths_on(lines: CrossfallLines, connecting: ConnectingRoads) -> dict[int, tuple[Cubic, ...]]:
    """Return the widths of the lanes of connecting roads that run on such lines, by index of the road."""
    return dict(zip(lines.row.tolist(), _cubics(_lane_widths(lines, connecting).records()), strict=True))


def _lane_widths(lines: CrossfallLines, connecting: ConnectingRoads) -> Kinked:
    """Return the widths of lanes where the normals of their lines cut them, m: they change in a smooth step."""
    wider, curve = lines.wider, lines.row[lines.wider.curve]
    start, begin = connecting.change_start()[curve], connecting.entry_width[curve]
    over, rise = connecting.length[curve] - start, connecting.exit_width[curve] - begin
    u = np.maximum(wider.s - start, 0.0) / over
    width, slope = begin + rise * smooth_step(u), 6.0 * rise * (u - u * u) / over
    before, after = (slope * wider.value + width * change for change in (wider.before, wider.after))
    return Kinked(wider.start, wider.s, width * wider.value, before, after)


def floor_on(lines: CrossfallLines, drawn: FloatArray, floor: Floor) -> Floor:
    """Return a floor whose strips run along these lines; they were laid along lanes of these lengths, (C,), m."""
    share = lengths(lines.plan_view) / drawn[lines.row]
    factor, left, right = lines.wider.records(), dict(floor.left), dict(floor.right)
    for k, row in enumerate(lines.row.tolist()):
        for strips in (left, right):
            if row in strips:
                strips[row] = _along_line(strips[row], float(share[k]), lines.wider, factor, k)
    return replace(floor, left=left, right=right)


def _along_line(
    widths: tuple[Cubic, ...], share: float, wider: Kinked, factor: CubicProfile, curve: int
) -> tuple[Cubic, ...]:
    """Return widths along a lane as they are along the line beside it, which is `share` times as long."""
    at = wider.s[wider.start[curve] : wider.start[curve + 1]]
    two = share * share
    strip = profile_of([[Cubic(c.s * share, c.a, c.b / share, c.c / two, c.d / (two * share)) for c in widths]])
    own = np.append(strip.s, at[-1])
    far = np.abs(at[:, None] - own).min(axis=1) > _SAME_PLACE
    s = np.sort(np.concatenate([own, at[far]]))
    along, across = np.zeros(len(s), np.int64), np.full(len(s), curve)
    width, times = cubic_value(strip, along, s), cubic_value(factor, across, s)
    before, after = (
        cubic_slope(strip, along, s, before=end) * times + width * cubic_slope(factor, across, s, before=end)
        for end in (True, False)
    )
    return _cubics(Kinked(starts([len(s)]), s, width * times, before, after).records())[0]


def _cubics(profile: CubicProfile) -> list[tuple[Cubic, ...]]:
    """Return the records of each curve."""
    rows = list(zip(*(getattr(profile, name).tolist() for name in "sabcd"), strict=True))
    return [tuple(Cubic(*row) for row in rows[a:b]) for a, b in itertools.pairwise(profile.start.tolist())]
