"""The ends of streets as flat arrays, and that roads end, and streets are cut in two, outside tight bends."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from osm2xodr.curves import (
    arctan2,
    curvature_at,
    end_curvature,
    find_record,
    heading_at,
    hypot,
    lengths,
    owners,
    pose,
    running_lengths,
    starts,
    sum_before,
)
from osm2xodr.geometry.defaults import (
    ARM_REACH,
    ARM_REACH_MOTORWAY,
    ARM_SETBACK_STEP,
    FAST_HIGHWAYS,
    HALF_NARROW_LANE,
    TIGHT_BEND,
)
from osm2xodr.geometry.lanes import CrossSection, Piece
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.model import BoolArray, Direction, FloatArray, IntArray, PlanView, StreetNetwork, Structure
from osm2xodr.system import record

# A place is clear of bends where none is tight within the last of these distances, m: a few steps of a reader.
_PROBES: Final = np.arange(0.0, 3.01, 0.25)
# An end before a bend keeps this much more distance, m.
_SLIVER: Final = 0.01
# An end that was moved lies where a bend ends: this far within the road, m, it is certain on which side of that.
_WITHIN: Final = 1e-6
# How far places may move along their curves to be clear of bends, m, in the order of preference. Choices.
_SHIFTS: Final = (0.0, *(sign * step for step in np.arange(2.0, 20.1, 2.0) for sign in (1.0, -1.0)))
# Rounds in which ends move; a bend that begins where another ends takes one more.
_ROUNDS: Final = 3


@record(eq=False)
class StreetEnds:
    """All ends of all streets."""

    plan_view: PlanView  # Curves of the streets
    length: FloatArray  # (ends,) Length of the end's street, m
    node: IntArray  # (ends,) Intersection that it lies at; -1 for rings without one
    # (ends,) Edges of the carriageway left (positive) and right (negative) of the outward direction, m
    left: FloatArray
    right: FloatArray
    hdg: FloatArray  # (ends,) Outward heading at the node, rad
    # (ends,) Whether cars drive on it into the junction, and out of it
    enters: BoolArray
    leaves: BoolArray
    kerb: FloatArray  # (ends,) Radius that its corners should have, m
    reach: FloatArray  # (ends,) How far along it its junction may reach, m
    # (ends,) Part of a roundabout; on a bridge or in a tunnel; OSM's layer
    roundabout: BoolArray
    raised: BoolArray
    layer: IntArray
    aside: FloatArray  # (ends,) How far left of the line of OSM, in the outward direction, the end's curve lies, m
    lines: PlanView  # OSM's lines of the streets
    # (streets + 1,) Where the pieces of each street begin; (pieces,) where each begins along it, m, and its level:
    # equal numbers for equal layers and structures
    piece_start: IntArray
    piece_s: FloatArray
    piece_level: IntArray

    def levels(self, end: IntArray, u: FloatArray) -> IntArray:
        """Return the level at distances u from the node along ends, both (n,), m."""
        place = np.where(end % 2 == 1, self.length[end] - u, u)
        return self.piece_level[find_record(self.piece_start, self.piece_s, end // 2, place)]


def street_ends(
    network: StreetNetwork,
    plan: PlanView,
    sections: tuple[tuple[CrossSection, CrossSection], ...],
    aside: FloatArray | None = None,
) -> StreetEnds:
    """Collect the ends of all streets; `sections` are those at each street's start and end.

    `aside` (streets,) is how far left of the lines of OSM the curves lie, m; 0 if left out.
    """
    streets = network.streets
    length = np.repeat(lengths(plan), 2)
    end = np.arange(2 * len(streets))
    at_end = end % 2 == 1
    hdg = heading_at(plan, end // 2, np.where(at_end, length, 0.0)) + np.where(at_end, np.pi, 0.0)
    attributes = [piece[1] for street in streets for piece in (street.pieces[0], street.pieces[-1])]
    left_edge = np.array([section.left_edge for pair in sections for section in pair])
    right_edge = np.array([section.right_edge for pair in sections for section in pair])
    directions = [item.car_directions() for item in attributes]
    forward = np.array([Direction.FORWARD in item for item in directions], bool)
    backward = np.array([Direction.BACKWARD in item for item in directions], bool)
    highway = [item.highway for item in attributes]
    return StreetEnds(
        plan_view=plan,
        length=length,
        node=np.array([node for street in streets for node in (street.start, street.end)], np.int64),
        left=np.where(at_end, -right_edge, left_edge),
        right=np.where(at_end, -left_edge, right_edge),
        hdg=hdg,
        enters=np.where(at_end, forward, backward),
        leaves=np.where(at_end, backward, forward),
        kerb=np.array([defaults.KERB_RADIUS.get(h, defaults.KERB_RADIUS_OTHER) for h in highway]),
        reach=np.array([ARM_REACH_MOTORWAY if h in FAST_HIGHWAYS else ARM_REACH for h in highway]),
        roundabout=np.array([item.roundabout for item in attributes], bool),
        raised=np.array([item.structure is not Structure.GROUND for item in attributes], bool),
        layer=np.array([item.layer for item in attributes], np.int64),
        aside=np.zeros(len(end)) if aside is None else np.repeat(aside, 2) * np.where(at_end, -1.0, 1.0),
        lines=_straight_lines([street.points for street in streets]),
        piece_start=starts([len(street.pieces) for street in streets]),
        piece_s=_piece_places(network, length[0::2]),
        piece_level=np.array(
            [3 * item.layer + item.structure.value for street in streets for _, item in street.pieces], np.int64
        ),
    )


def _piece_places(network: StreetNetwork, length: FloatArray) -> FloatArray:
    """Return where the pieces of streets begin along curves of this length, (streets,), m."""
    out: list[float] = []
    for street, size in zip(network.streets, length.tolist(), strict=True):
        if len(street.pieces) == 1:
            out.append(0.0)
            continue
        chainage = running_lengths(street.points)
        out += (chainage[[first for first, _ in street.pieces]] * (size / chainage[-1])).tolist()
    return np.array(out)


def _straight_lines(polylines: list[FloatArray]) -> PlanView:
    """Return polylines as curves, of a straight line from each of their points to the next."""
    points, start = np.concatenate(polylines), starts([len(item) for item in polylines])
    begins = np.delete(np.arange(len(points)), start[1:] - 1)
    x, y = points[begins].T
    dx, dy = (points[begins + 1] - points[begins]).T
    size, start = hypot(dx, dy), start - np.arange(len(start))
    return PlanView(start, sum_before(size, start), x, y, arctan2(dy, dx), size, np.zeros(len(size)))


def outward_pose(ends: StreetEnds, end: IntArray, u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y and outward heading at distance u from the node along ends, all (n,)."""
    at_end = end % 2 == 1
    s = np.where(at_end, ends.length[end] - u, u)
    x, y, hdg = pose(ends.plan_view, end // 2, s)
    return x, y, hdg + np.where(at_end, np.pi, 0.0)


def trims_clear_of_bends(
    ends: StreetEnds, junction: IntArray, trim: FloatArray, least: FloatArray, most: FloatArray
) -> FloatArray:
    """Return trims moved out of bends in which lanes are much longer than the reference line, (ends,), m.

    Inside a junction a bend does no harm: connecting roads run along the middle of their lane. Ends in no junction
    (-1) stay. `least` (ends,), m, is what junctions need: an end moves back before a bend where that is nearer and
    enough. `most` (ends,), m, is what streets can give.
    """
    trim = trim.copy()
    candidates = np.flatnonzero(junction >= 0)
    for _ in range(_ROUNDS):
        bent, before, beyond = _first_bend(ends, candidates, trim[candidates])
        back = bent & (before >= least[candidates]) & (trim[candidates] - before <= 2 * ARM_SETBACK_STEP)
        trim[candidates[back]] = before[back]
        candidates, bent, beyond = candidates[~back], bent[~back], beyond[~back]
        near = beyond - trim[candidates] < defaults.BEND_IN_JUNCTION
        move = bent & near & (beyond <= most[candidates])
        if not move.any():
            break
        trim[candidates[move]] = beyond[move]
        candidates = candidates[move]
    return trim


def _first_bend(ends: StreetEnds, end: IntArray, trim: FloatArray) -> tuple[BoolArray, FloatArray, FloatArray]:
    """Say which ends lie at a tight bend, how far from the node an end before it may lie, and where it is over, m."""
    plan = ends.plan_view
    # Lanes left and right of the street's own direction.
    at_end = end % 2 == 1
    left = np.where(at_end, -ends.right[end], ends.left[end]) - HALF_NARROW_LANE
    right = np.where(at_end, -ends.left[end], ends.right[end]) + HALF_NARROW_LANE
    bent = np.zeros(len(end), bool)
    before = np.full(len(end), np.inf)
    beyond = trim.copy()
    for probe in _PROBES + _WITHIN:
        u = np.minimum(trim + probe, ends.length[end])
        s = np.where(at_end, ends.length[end] - u, u)
        k = find_record(plan.start, plan.s, end // 2, s)
        curvature = plan.curvature[k] + plan.rate[k] * (s - plan.s[k])
        tight = _outer_excess(curvature, right, left) > TIGHT_BEND
        first, last = _tight_part(plan, k, right, left)
        over = np.where(at_end, ends.length[end] - first, last)
        under = np.where(at_end, ends.length[end] - last, first)
        before = np.where(tight, np.minimum(before, under - _PROBES[-1] - _SLIVER), before)
        beyond = np.where(tight, np.maximum(beyond, over), beyond)
        bent |= tight
    return bent, before, beyond


def _tight_part(plan: PlanView, k: IntArray, right: FloatArray, left: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return from where to where records k bend too much for lanes at right and left, (n,), m along their curves.

    Where they nowhere do, the part is the whole record.
    """
    first, rate, length = plan.curvature[k], plan.rate[k], plan.length[k]
    begin, end = np.full(len(k), np.inf), np.full(len(k), -np.inf)
    for t in (right, left):
        # -t (first + rate ds) > TIGHT_BEND, a half-line of ds.
        slope, rest = -t * rate, TIGHT_BEND + t * first
        cross = rest / np.where(slope == 0.0, np.inf, slope)
        always = (slope == 0.0) & (rest < 0.0)
        lo = np.where(slope > 0.0, np.clip(cross, 0.0, length), 0.0)
        hi = np.where(slope < 0.0, np.clip(cross, 0.0, length), length)
        some = always | ((slope != 0.0) & (hi > lo))
        begin, end = np.where(some, np.minimum(begin, lo), begin), np.where(some, np.maximum(end, hi), end)
    none = end < begin
    return plan.s[k] + np.where(none, 0.0, begin), plan.s[k] + np.where(none, length, end)


def _outer_excess(curvature: FloatArray, right: FloatArray, left: FloatArray) -> FloatArray:
    """Return by which share the lane on the outside of a bend is longer than the reference line, (n,)."""
    return np.asarray(-np.minimum(curvature * right, curvature * left))


def outermost_lanes(pieces: Sequence[Piece]) -> tuple[float, float]:
    """Return t of about the middles of the outermost lanes of a street, right and left, m."""
    right = min([section.right_edge for _, _, section in pieces]) + HALF_NARROW_LANE
    left = max([section.left_edge for _, _, section in pieces]) - HALF_NARROW_LANE
    return right, max(left, right)


def has_tight_bend(plan: PlanView, curve: IntArray, right: FloatArray, left: FloatArray) -> BoolArray:
    """Say which curves are somewhere too tight for lanes at t = right and left, m, all (n,)."""
    owner = owners(plan.start)
    least, most = np.zeros(len(plan.start) - 1), np.zeros(len(plan.start) - 1)
    for curvature in (plan.curvature, end_curvature(plan)):
        np.minimum.at(least, owner, curvature)
        np.maximum.at(most, owner, curvature)
    excess = np.maximum(_outer_excess(least[curve], right, left), _outer_excess(most[curve], right, left))
    return np.asarray(excess > TIGHT_BEND)


def places_clear_of_bends(
    plan: PlanView,
    curve: IntArray,
    s: FloatArray,
    right: FloatArray,
    left: FloatArray,
    length: FloatArray,
    side: IntArray | None = None,
) -> FloatArray:
    """Return places moved along their curves, by as little as possible, to where no bend is tight, (n,), m.

    A place stays where there is none near enough. `right` and `left` (n,) are t of the middles of the outermost
    lanes, `length` that of each curve, m. Where `side` (n,) is 1 or -1, a place moves forwards or back, unless only
    the other way leads off the bend.
    """
    moved = s.copy()
    # Most curves bend nowhere that much: their places stay unless they are close to an end.
    clear = (s > _PROBES[-1]) & (s < length[curve] - _PROBES[-1]) & ~has_tight_bend(plan, curve, right, left)
    todo = np.flatnonzero(~clear)
    # Towards the middle of the curve first, whichever way that is drawn.
    inwards = np.where(s < length[curve] / 2, 1.0, -1.0)
    probes = np.concatenate([-_PROBES[:0:-1], _PROBES])
    for shift in _SHIFTS:
        at = s[todo] + inwards[todo] * shift
        allowed = (at > _PROBES[-1]) & (at < length[curve[todo]] - _PROBES[-1])
        if side is not None:
            allowed &= side[todo] * inwards[todo] * shift >= 0.0
        inside = np.flatnonzero(allowed)
        row = todo[inside]
        probed = (at[inside, None] + probes).ravel()
        bend = curvature_at(plan, np.repeat(curve[row], len(probes)), probed).reshape(-1, len(probes))
        excess = _outer_excess(bend, right[row, None], left[row, None])
        free = inside[(excess <= TIGHT_BEND).all(axis=1)]
        moved[todo[free]] = at[free]
        todo = np.delete(todo, free)
        if not len(todo):
            break
    if side is not None and len(todo):
        moved[todo] = places_clear_of_bends(plan, curve[todo], s[todo], right[todo], left[todo], length)
    return moved
