"""All lane links through junctions: which lane of which road end leads to which lane of which other one.

Bicycle lanes also lead round corners where their like does not continue straight on.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby
from operator import attrgetter
from typing import Final

import numpy as np

from osm2xodr.curves import cosine, pose, sine, wrapped
from osm2xodr.defaults import LEAST_TURN_BACK
from osm2xodr.geometry.connections.defaults import SMOOTH_CORNER
from osm2xodr.geometry.connections.lane_assignment import (
    ArmLanes,
    LaneLink,
    LaneMovement,
    assign_lanes,
    have_one_lane,
    lead_on_against_cars,
    u_turn_lanes,
)
from osm2xodr.geometry.defaults import STRAIGHT_ON
from osm2xodr.geometry.junctions import Movement, RoadParts
from osm2xodr.geometry.lanes import CrossSection, EndLane, centre_lanes, end_lanes
from osm2xodr.model import Access, BoolArray, Direction, FloatArray, IntArray, LaneSpec, LaneType, Rule
from osm2xodr.system import record

# A change of heading above this is a turn back, rad (165 degrees). A choice.
_TURN_BACK: Final = 2.88
# Poses of road ends that differ by less are the same, m and rad.
_SAME_POSE: Final = 1e-9


@record
class LaneRow:
    """One lane link: index of its movement, road ends, lanes; `against` as in `ConnectingRoads`."""

    junction: int
    movement: int
    entry: int
    exit: int
    lane_in: EndLane
    lane_out: EndLane
    against: bool = False
    at_left: bool = False  # Whether a bicycle lane that joins cars keeps to their left

    def lane_type(self) -> LaneType:
        """Return the type of lane that connects the two."""
        one, other = self.lane_in.spec, self.lane_out.spec
        if one.direction is Direction.BOTH:
            return LaneType.BIDIRECTIONAL
        if LaneType.BIKING in (one.type, other.type):
            return LaneType.BIKING
        return one.type if one.type is other.type else LaneType.DRIVING

    def joins_cars(self) -> bool:
        """Return whether bicycles leave their lane for one of cars."""
        return self.lane_in.spec.type is LaneType.BIKING and self.lane_out.spec.type is not LaneType.BIKING

    def access(self) -> Access:
        """Return which cars may drive on the lane that connects the two: all who may on one of them."""
        one, other = self.lane_in.spec.access, self.lane_out.spec.access
        return one if one is other else Access.ALL


@record(eq=False)
class LaneLinks:
    """The lane links of all junctions."""

    rows: tuple[LaneRow, ...]  # In the order of movements' junctions
    # (road ends,) Pose of every road end, its heading along the road's s
    x: FloatArray
    y: FloatArray
    hdg: FloatArray
    road_end: IntArray  # (street ends,) As in `RoadParts`
    # Of every road end: they change where a road has become so short that a stretch at its end joins another
    sections: tuple[CrossSection, ...]


def find_lane_links(
    parts: RoadParts, movements: list[Movement], rule: Rule, before: LaneLinks | None = None
) -> LaneLinks:
    """Assign lanes to all movements, which are grouped by junction.

    `before` is what was found for the same movements before roads were cut again; junctions whose arms have not moved
    since keep it.
    """
    roads = len(parts.length)
    s = np.column_stack([np.zeros(roads), parts.length]).ravel()
    x, y, hdg = pose(parts.plan_view, np.repeat(np.arange(roads), 2), s)
    entry = parts.road_end[np.array([item.entry for item in movements], np.int64)]
    exit_ = parts.road_end[np.array([item.exit for item in movements], np.int64)]
    sections = tuple(stretches[k].section for stretches in parts.stretches for k in (0, -1))
    known: dict[int, list[LaneRow]] = {}
    if before is not None and np.array_equal(before.road_end, parts.road_end):
        change = np.abs(np.stack([before.x - x, before.y - y, before.hdg - hdg])).max(axis=0)
        still = change < _SAME_POSE
        still &= [one is other for one, other in zip(before.sections, sections, strict=True)]
        known = _kept(before, movements, still[entry] & still[exit_])
    # As drivers see it: headings into and out of the junction, and where entries lie as seen from exits.
    hdg_in, hdg_out = hdg[entry] + np.where(entry % 2, 0.0, np.pi), hdg[exit_] + np.where(exit_ % 2, np.pi, 0.0)
    dx, dy = x[entry] - x[exit_], y[entry] - y[exit_]
    view = _DriversView(
        entry.tolist(),
        exit_.tolist(),
        _turns(hdg_in, hdg_out, dx, dy).tolist(),
        (dy * cosine(hdg_out) - dx * sine(hdg_out)).tolist(),
        cosine(hdg[entry] - hdg_out).tolist(),
        rule is Rule.LEFT_HAND,
    )
    arms = _Arms(parts, rule)
    rows: list[LaneRow] = []
    for junction, group in groupby(range(len(movements)), key=lambda k: movements[k].junction):
        if junction in known:
            rows += known[junction]
        else:
            rows += _junction_rows(junction, list(group), movements, view, arms, rule)
    return LaneLinks(tuple(rows), x, y, hdg, parts.road_end, sections)


def _kept(before: LaneLinks, movements: list[Movement], still: BoolArray) -> dict[int, list[LaneRow]]:
    """Return the links of the junctions none of whose arms have moved."""
    of = np.array([item.junction for item in movements], np.int64)
    moved = set(of[~still].tolist())
    out: dict[int, list[LaneRow]] = {junction: [] for junction in of.tolist() if junction not in moved}
    for junction, group in groupby(before.rows, key=attrgetter("junction")):
        if junction in out:
            out[junction] += group
    return out


def _turns(hdg_in: FloatArray, hdg_out: FloatArray, dx: FloatArray, dy: FloatArray) -> FloatArray:
    """Return the changes of heading, left positive; that of a turn back has the sign of the side of its exit."""
    turn = wrapped(hdg_out - hdg_in)
    back = np.abs(turn) >= _TURN_BACK
    side = dx * sine(hdg_in) - dy * cosine(hdg_in)
    return np.where(back, np.copysign(turn, side), turn)


@record
class _DriversView:
    """Each movement's road ends, turn, and offset + scale t, where an entry lane at t lies as seen from the exit."""

    entry: list[int]
    exit: list[int]
    turn: list[float]
    offset: list[float]
    scale: list[float]
    near_side_left: bool  # Whether traffic keeps to the left


class _Arms:
    """Lanes at road ends by direction of travel, found once for each cross-section: streets share them.

    The parts keep their cross-sections, so that these can be known by their identity.
    """

    def __init__(self, parts: RoadParts, rule: Rule) -> None:
        self._parts = parts
        self._rule = rule
        self._known: dict[tuple[int, bool, float], tuple[tuple[EndLane, ...], ArmLanes]] = {}
        self._centre: dict[tuple[int, bool], tuple[EndLane, ...]] = {}

    def lanes(self, end: int, along: bool, sign: float) -> tuple[tuple[EndLane, ...], ArmLanes]:
        """Return the lanes whose traffic runs along the road, or against it; their t times `sign` for the arm."""
        section = self._parts.at_end(end).section
        key = id(section), along, sign
        found = self._known.get(key)
        if found is None:
            lanes = end_lanes(section, self._rule, along)
            found = lanes, ArmLanes(tuple(lane.spec for lane in lanes), tuple(sign * lane.t for lane in lanes))
            self._known[key] = found
        return found

    def centre(self, end: int, along: bool) -> tuple[EndLane, ...]:
        """Return the lanes for both directions, as drivers along the road or against it see them."""
        section = self._parts.at_end(end).section
        key = id(section), along
        if key not in self._centre:
            self._centre[key] = centre_lanes(section, along)
        return self._centre[key]


def _junction_rows(
    junction: int, group: list[int], movements: list[Movement], view: _DriversView, arms: _Arms, rule: Rule
) -> list[LaneRow]:
    """Return every lane link of one junction."""
    lanes: dict[int, tuple[tuple[EndLane, ...], tuple[EndLane, ...]]] = {}
    entries: dict[int, ArmLanes] = {}
    exits: dict[int, ArmLanes] = {}
    against_cars: list[LaneRow] = []
    ins = {end: arms.lanes(end, end % 2 == 1, 1.0) for end in {view.entry[number] for number in group}}
    outs = {
        end: arms.lanes(end, end % 2 == 0, -1.0 if end % 2 else 1.0)
        for end in {view.exit[number] for number in group}
    }
    for number in group:
        entry, exit_ = view.entry[number], view.exit[number]
        (into, entry_lanes), (out, exit_lanes) = ins[entry], outs[exit_]
        if kind := movements[number].apart:
            pairs = lead_on_against_cars(entry_lanes.specs, exit_lanes.specs, kind, rule is Rule.LEFT_HAND)
            against_cars += [
                LaneRow(
                    *(junction, number, entry, exit_, into[k], out[other]),
                    at_left=lies_at_left(k, len(into), view.near_side_left),
                )
                for k, other in pairs
            ]
        elif into and out:
            entries[entry], exits[exit_] = entry_lanes, exit_lanes
            lanes[number] = into, out
    numbers = list(lanes)
    links = [(k, 0, 0) for k in range(len(numbers))]
    if not have_one_lane(entries, exits):
        seen = [_as_lanes_see_it(number, lanes[number][0], movements, view, entries, exits) for number in numbers]
        links = assign_lanes(seen, entries, exits, rule is Rule.LEFT_HAND)
        links += lead_bicycles_on(seen, entries, exits, links, rule is Rule.LEFT_HAND)
    rows = [*_centre_rows(junction, numbers, view, arms), *against_cars]
    for k, lane_in, lane_out in links:
        number = numbers[k]
        into, out = lanes[number]
        at_left = lies_at_left(lane_in, len(into), view.near_side_left)
        ends = view.entry[number], view.exit[number], into[lane_in], out[lane_out]
        rows.append(LaneRow(junction, number, *ends, at_left=at_left))
    return rows


def _as_lanes_see_it(
    number: int,
    into: tuple[EndLane, ...],
    movements: list[Movement],
    view: _DriversView,
    entries: dict[int, ArmLanes],
    exits: dict[int, ArmLanes],
) -> LaneMovement:
    entry, exit_ = view.entry[number], view.exit[number]
    lateral = tuple([view.offset[number] + view.scale[number] * lane.t for lane in into])
    stated = movements[number].stated
    pairs = None if stated is None else stated.between(entries[entry].specs, exits[exit_].specs)
    if pairs is None and movements[number].u_turn:
        pairs = (u_turn_lanes(lateral, entries[entry], exits[exit_], view.near_side_left),)
    return LaneMovement(entry, exit_, view.turn[number], lateral, pairs)


def _centre_rows(junction: int, numbers: list[int], view: _DriversView, arms: _Arms) -> list[LaneRow]:
    """Return the links between lanes for both directions that face each other.

    Readers take such a lane for one along its road (left of its centre: against it), so only those are linked whose
    ids agree on a direction; the way back then runs against the id of its lane.
    """
    rows: list[LaneRow] = []
    for number in numbers:
        entry, exit_ = view.entry[number], view.exit[number]
        if abs(view.turn[number]) >= SMOOTH_CORNER or entry % 2 == exit_ % 2:
            continue
        along = entry % 2 == 1
        here, there = arms.centre(entry, along), arms.centre(exit_, along)
        if here and there:
            pairs = zip(here, there, strict=False)
            rows += [LaneRow(junction, number, entry, exit_, *pair, against=not along) for pair in pairs]
    return rows


def lead_bicycles_on(
    movements: Sequence[LaneMovement],
    entries: dict[int, ArmLanes],
    exits: dict[int, ArmLanes],
    links: Sequence[LaneLink],
    near_side_left: bool,
) -> list[LaneLink]:
    """Return the links that bicycle lanes of one junction lack, besides the known `links` of all lanes.

    Those along the near side's kerbs lead round the corner to each other. Where no movement leads straight on,
    bicycle lanes lead round all corners to bicycle lanes; one that no other leads straight to is reached round one
    corner. What still leads nowhere joins the lane for cars at its side: straight on, else round the corner of the
    near side.
    """
    lacking = {(item.entry, lane) for item in movements for lane in _bicycles(entries[item.entry].specs)}
    unreached = {(item.exit, lane) for item in movements for lane in _bicycles(exits[item.exit].specs)}
    if not lacking and not unreached:
        return []
    lacking -= {(movements[k].entry, lane) for k, lane, _ in links}
    unreached -= {(movements[k].exit, lane) for k, _, lane in links}
    ways = [k for k, item in enumerate(movements) if item.entry != item.exit and abs(item.turn) < LEAST_TURN_BACK]
    # Straight on first, then round the corner of the near side.
    ways.sort(key=lambda k: _rank(movements[k].turn, near_side_left))
    straight = [movements[k] for k in ways if abs(movements[k].turn) < STRAIGHT_ON]

    def at_near_side(lane: int, specs: Sequence[LaneSpec]) -> bool:
        return lane == (0 if near_side_left else len(specs) - 1)

    from_straight = {item.entry for item in straight}
    found: list[LaneLink] = []
    for k in ways:
        item = movements[k]
        own, other = entries[item.entry].specs, exits[item.exit].specs
        turns_near = abs(item.turn) >= STRAIGHT_ON and (item.turn > 0) == near_side_left
        for lane_in, lane_out in _alike(own, other, near_side_left):
            leads_on = (item.entry, lane_in) in lacking and item.entry not in from_straight
            at_kerb = turns_near and at_near_side(lane_in, own) and at_near_side(lane_out, other)
            if leads_on or at_kerb or (item.exit, lane_out) in unreached:
                found.append((k, lane_in, lane_out))
                unreached.discard((item.exit, lane_out))
    # Who leads on round a corner only may want to go straight on as well.
    lacking -= {(movements[k].entry, lane) for k, lane, _ in found if movements[k].entry not in from_straight}
    for arm, lane in sorted(lacking):
        first = next((k for k in ways if movements[k].entry == arm and _cars(exits[movements[k].exit].specs)), None)
        if first is not None:
            beside = _at_its_side(lane, entries[arm].specs, exits[movements[first].exit].specs, near_side_left)
            found.append((first, lane, beside))
    return found


def _rank(turn: float, near_side_left: bool) -> tuple[bool, bool, float]:
    """Return a key by which ways straight on come first, then turns to the near side, the straightest first."""
    return abs(turn) >= STRAIGHT_ON, (turn > 0) != near_side_left, abs(turn)


def _bicycles(specs: Sequence[LaneSpec]) -> list[int]:
    return [k for k, spec in enumerate(specs) if spec.type is LaneType.BIKING]


def _cars(specs: Sequence[LaneSpec]) -> list[int]:
    return [k for k, spec in enumerate(specs) if spec.type is LaneType.DRIVING]


def _alike(entry: Sequence[LaneSpec], exit_: Sequence[LaneSpec], near_side_left: bool) -> Iterable[tuple[int, int]]:
    """Pair the bicycle lanes of two arms, from the near side on."""
    ins, outs = _bicycles(entry), _bicycles(exit_)
    return zip(ins, outs, strict=False) if near_side_left else zip(ins[::-1], outs[::-1], strict=False)


def lies_at_left(lane: int, lanes: int, near_side_left: bool) -> bool:
    """Say whether one of some lanes lies at the left of all of them; the middle one lies at the near side."""
    middle = (lanes - 1) / 2
    return lane < middle or (lane == middle and near_side_left)


def _at_its_side(lane: int, own: Sequence[LaneSpec], other: Sequence[LaneSpec], near_side_left: bool) -> int:
    """Return the lane for cars of another arm at the side of its road at which a bicycle lane lies on its own."""
    return _cars(other)[0 if lies_at_left(lane, len(own), near_side_left) else -1]
