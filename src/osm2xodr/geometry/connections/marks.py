"""Road marks within junctions: lines run on where lanes do and no other lane crosses them.

Where carriageways part or join, lanes go on side by side for a hundred metres, and so do the lines between and beside
them. A road that goes first keeps its lines between lanes past side streets, broken, since cars turn over them. In
other junctions the line at the carriageway's edge runs on: opposite a side road, along the inside of a roundabout,
and round a corner. Crossings of equals and those with lights are bare.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final, Literal, NamedTuple

import numpy as np

from osm2xodr.conventions import MarkStyle
from osm2xodr.curves import (
    PointTree,
    Table,
    cosine,
    cosine_sine,
    heading_change,
    hypot,
    lengths,
    pose,
    ranks,
    repeated,
    sine,
    sorted_unique,
)
from osm2xodr.defaults import LEAST_TURN_BACK
from osm2xodr.geometry.connections.arm_setbacks import merge_stems
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads
from osm2xodr.geometry.connections.priorities import Priorities
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.lanes import NO_MARK, LaneLayout
from osm2xodr.model import VEHICLE_LANES, BoolArray, FloatArray, IntArray, LaneSection, RoadMark, Rule
from osm2xodr.system import record

# Edges of lanes are looked at every so many metres, but not at their ends.
_SPACING: Final = 1.0
_ENDS: Final = 1.0
# An edge lies in another lane if it is so deep inside, and on its edge if it is so near to that, m. Choices.
_INSIDE: Final = 0.4
# It has the line between two lanes if it is the edge of both for this share of its length. A choice.
_SHARED: Final = 0.6

# Ways that turn by less go straight on, rad. A choice.
_STRAIGHT: Final = 0.4
# Carriageways part or join where no way turns by more, rad (60 degrees). A choice.
_MERGE_TURN: Final = 1.05
# Lines of a road that goes first stop for this long at most, m. A choice: more than crossing a street takes.
_LONGEST_BARE: Final = 25.0

# Every so many places of an edge are looked at first. Only saves time.
_FEW: Final = 4

Marks = tuple[RoadMark, RoadMark]
"""The marks on the inner and the outer edge of a connecting road's lane; the inner one is nearer to lane 0."""


_Edge = Literal["inside", "shared", "free"]
"""What the edge of a lane is: inside another lane, the edge of one on its other side as well, or neither.

Ways that part or join have the same edge for a while, which none of them shares. One too short to tell is inside.
"""


def connecting_marks(
    parts: RoadParts,
    connecting: ConnectingRoads,
    lanes: Sequence[LaneLayout],
    rule: Rule,
    priorities: Priorities,
    style: MarkStyle,
) -> dict[int, Marks]:
    """Return the marks of connecting roads for vehicles, by their indices; those without any are left out.

    An edge that no other lane crosses has a mark: that of the carriageway's edge, in splits and merges where the lane
    has one before or behind the junction, elsewhere where it has one at both. In splits and merges it has that
    between lanes where it is the edge of another lane, too (of both lanes the one that lies nearer to lane 0 has it).
    The line on the inner side of a lane that goes straight on runs on where `_lines_run_on` says so.
    """
    merge = merge_stems(parts, connecting) >= 0
    kinds = _kinds(connecting, lanes, merge)
    wanted = np.array(list(kinds), np.int64)
    inner, outer = _edges(connecting, wanted, (1, -1) if rule is Rule.RIGHT_HAND else (-1, 1))
    out: dict[int, Marks] = {}
    for (row, found), *edges in zip(kinds.items(), inner, outer, strict=True):
        marks = [_mark(edge, both, bool(merge[row])) for edge, both in zip(edges, found, strict=True)]
        # The line between two lanes is painted once.
        out[row] = NO_MARK if marks[0].type.startswith("broken") else marks[0], marks[1]
    ends = connecting.entry, connecting.entry_lane, connecting.exit, connecting.exit_lane
    beside = {key: row for row, key in enumerate(zip(*(column.tolist() for column in ends), strict=True))}
    for row, line in _lines_between(connecting, lanes, _lines_run_on(connecting, priorities, style)).items():
        inwards = _lane_inwards(int(connecting.entry_lane[row])), _lane_inwards(int(connecting.exit_lane[row]))
        other = beside.get((int(connecting.entry[row]), inwards[0], int(connecting.exit[row]), inwards[1]))
        # A line belongs to the lane on its inner side, if that goes on as well.
        if other is None:
            out[row] = line, out.get(row, (NO_MARK, NO_MARK))[1]
        else:
            out[other] = out.get(other, (NO_MARK, NO_MARK))[0], line
    return {row: marks for row, marks in out.items() if marks != (NO_MARK, NO_MARK)}


def _lines_run_on(
    connecting: ConnectingRoads, priorities: Priorities, style: MarkStyle
) -> tuple[BoolArray, BoolArray]:
    """Say where the lines between lanes of one direction run on, and those between opposite directions, (n,).

    Both do along a road that goes first; the first also where all ways part or join at small angles.
    """
    turn = np.abs(heading_change(connecting.plan_view, np.arange(len(connecting.length))))
    straight, cars = turn < _STRAIGHT, connecting.for_vehicles()
    past = 1 if style.past_side_streets else 0
    first = (priorities.passed >= 0) & ((priorities.passed <= past) | (connecting.length > _LONGEST_BARE))
    count = int(connecting.junction.max(initial=-1)) + 1
    sharpest = np.zeros(count)
    np.maximum.at(sharpest, connecting.junction[cars], turn[cars])
    merge = sharpest[connecting.junction] < _MERGE_TURN
    return straight & (first | merge), straight & first


def _lines_between(
    connecting: ConnectingRoads, lanes: Sequence[LaneLayout], run_on: tuple[BoolArray, BoolArray]
) -> dict[int, RoadMark]:
    """Return the lines on the inner sides of lanes that run on, by their rows; those between directions once."""
    out: dict[int, RoadMark] = {}
    painted: set[tuple[int, int]] = set()
    carried = ~connecting.beside_cars()
    for row in np.flatnonzero(carried & (run_on[0] | run_on[1])).tolist():
        entry, exit_ = int(connecting.entry[row]), int(connecting.exit[row])
        before = _line_inside(lanes, entry, int(connecting.entry_lane[row]))
        behind = _line_inside(lanes, exit_, int(connecting.exit_lane[row]))
        if before is None or behind is None or before[1] != behind[1] or not run_on[before[1]][row]:
            continue
        if before[1]:
            if (exit_, entry) in painted:
                continue
            painted.add((entry, exit_))
        out[row] = replace(before[0], type="broken", lane_change="none")
    return out


def _lane_inwards(lane: int) -> int:
    """Return the id of the next lane on the inner side."""
    return lane - int(np.sign(lane)) or -lane


def _line_inside(lanes: Sequence[LaneLayout], end: int, lane: int) -> tuple[RoadMark, bool] | None:
    """Return the line between a lane and the next one on its inner side, and whether that is for the other direction.

    None without a line, or where no lane for cars lies there.
    """
    inwards = _lane_inwards(lane)
    other = next((item for item in _section(lanes, end).lanes if item.id == inwards), None)
    mark = _marks(lanes, end, lane)[0]
    if other is None or other.type not in VEHICLE_LANES or mark.type == NO_MARK.type:
        return None
    return mark, inwards * lane < 0


@record(eq=False)
class _Places(Table):
    """Places along the middles of lanes, row after row."""

    row: IntArray  # (m,) Of the connecting road
    xy: FloatArray  # (m, 2) m
    hdg: FloatArray  # (m,) rad
    half: FloatArray  # (m,) Half of the lane's width, m

    @staticmethod
    def along(connecting: ConnectingRoads, rows: IntArray) -> _Places:
        """Return places on some connecting roads, from end to end."""
        length = lengths(connecting.plan_view, rows)
        count = np.maximum((length / _SPACING).astype(np.int64), 2) + 1
        of = repeated(count)
        share = ranks(count) / (count - 1)[of]
        x, y, hdg = pose(connecting.plan_view, rows[of], share * length[of])
        # Bicycle lanes that join cars widen in their last metres only.
        last = np.where(connecting.joins_cars, connecting.entry_width, connecting.exit_width)
        width = connecting.entry_width[rows][of] * (1 - share) + last[rows][of] * share
        return _Places(rows[of], np.column_stack([x, y]), hdg, 0.5 * width)


def _edges(connecting: ConnectingRoads, wanted: IntArray, sides: tuple[int, int]) -> list[list[_Edge]]:
    """Return what the left (1) and right (-1) edges of some connecting roads' lanes are, side after side."""
    driven = ~connecting.beside_cars()
    there = np.isin(connecting.junction, connecting.junction[wanted])
    places = _Places.along(connecting, np.flatnonzero(driven & there))
    own = places.chosen(np.isin(places.row, wanted))
    tree = PointTree(places.xy)
    return [_edges_beside(connecting.junction, places, tree, own, wanted, side) for side in sides]


def _edges_beside(
    junction: IntArray, places: _Places, tree: PointTree, own: _Places, wanted: IntArray, side: int
) -> list[_Edge]:
    """Return what the edges of the wanted lanes are on one side; `tree` has all places, `own` are those on them."""
    edges = _EdgePlaces.of(own, side)
    many = len(junction)
    places_of = np.bincount(own.row[edges.looked_at], minlength=many)
    inside, beside = places_of == 0, np.zeros(many, np.int64)
    # Most edges lie inside other lanes, which a few of their places show.
    few = np.arange(len(own.row)) % _FEW == 0
    for part in (few, ~few):
        there = np.flatnonzero(edges.looked_at & part & ~inside[own.row])
        at, across, beyond = _lanes_near(junction, places, tree, edges, there)
        inside[own.row[at[across < -_INSIDE]]] = True
        beside += np.bincount(own.row[sorted_unique(at[beyond])], minlength=many)
    shared = beside >= _SHARED * places_of
    return ["inside" if inside[row] else "shared" if shared[row] else "free" for row in wanted.tolist()]


class _EdgePlaces(NamedTuple):
    """Places on the edges of lanes on one side, beside those along their middles."""

    row: IntArray  # (m,) Of the connecting road
    xy: FloatArray  # (m, 2) m
    outwards: FloatArray  # (m, 2) Directions away from the lane
    looked_at: BoolArray  # (m,) Whether they are not at an end

    @staticmethod
    def of(own: _Places, side: int) -> _EdgePlaces:
        """Return the places on the left (1) or right (-1) edges."""
        outwards = float(side) * np.column_stack([-sine(own.hdg), cosine(own.hdg)])
        xy = own.xy + own.half[:, None] * outwards
        first, last = np.searchsorted(own.row, own.row), np.searchsorted(own.row, own.row, "right") - 1
        from_ends = np.minimum(hypot(*(xy - xy[first]).T), hypot(*(xy - xy[last]).T))
        return _EdgePlaces(own.row, xy, outwards, from_ends > _ENDS)


def _lanes_near(
    junction: IntArray, places: _Places, tree: PointTree, edges: _EdgePlaces, there: IntArray
) -> tuple[IntArray, FloatArray, BoolArray]:
    """Return which of the places `there` on edges are on or in another lane of their junction, once for each, (n,).

    And how far outside of that lane they are, m, and whether it lies beyond the edge. `tree` has all places.
    """
    reach = math.hypot(places.half.max(initial=0.0) + _INSIDE, _SPACING)
    at, by = tree.within(edges.xy[there], reach)
    # Most are on the lane itself.
    at = there[at]
    apart = np.flatnonzero(edges.row[at] != places.row[by])
    at, by = at[apart], by[apart]
    together = np.flatnonzero(junction[edges.row[at]] == junction[places.row[by]])
    at, other = at[together], places.chosen(by[together])
    step = edges.xy[at] - other.xy
    cos, sin = cosine_sine(other.hdg)
    along = step[:, 0] * cos + step[:, 1] * sin
    across = np.abs(step[:, 1] * cos - step[:, 0] * sin) - other.half
    on = np.flatnonzero((np.abs(along) <= _SPACING) & (across < _INSIDE))
    return at[on], across[on], (step[on] * edges.outwards[at[on]]).sum(axis=1) < 0.0


def _kinds(
    connecting: ConnectingRoads, lanes: Sequence[LaneLayout], merge: BoolArray
) -> dict[int, tuple[tuple[RoadMark, RoadMark], tuple[RoadMark, RoadMark]]]:
    """Return the marks before and behind at the inner and the outer edges of lanes for vehicles, by their rows.

    They are those of splits and merges, and of other junctions if a line runs on at one of the edges; turns back have
    none, since pavement lies on both sides of them.
    """
    turn = np.abs(heading_change(connecting.plan_view, np.arange(len(connecting.length))))
    cars = connecting.for_vehicles() & (turn < LEAST_TURN_BACK)
    lined = np.zeros(2 * len(lanes), bool)
    for end in sorted_unique(np.concatenate([connecting.entry[cars], connecting.exit[cars]])).tolist():
        lined[end] = any(item.road_mark and item.road_mark.type == "solid" for item in _section(lanes, end).lanes)
    out = {}
    for row in np.flatnonzero(cars & (merge | (lined[connecting.entry] & lined[connecting.exit]))).tolist():
        before = _marks(lanes, int(connecting.entry[row]), int(connecting.entry_lane[row]))
        behind = _marks(lanes, int(connecting.exit[row]), int(connecting.exit_lane[row]))
        edges = (before[0], behind[0]), (before[1], behind[1])
        if merge[row] or any(map(_runs_on, edges)):
            out[row] = edges
    return out


def _section(lanes: Sequence[LaneLayout], end: int) -> LaneSection:
    return lanes[end // 2].sections[-1 if end % 2 else 0]


def _marks(lanes: Sequence[LaneLayout], end: int, lane: int) -> tuple[RoadMark, RoadMark]:
    """Return the marks at the inner and the outer edge of a lane at the end of a road."""
    marks = {item.id: item.road_mark or NO_MARK for item in _section(lanes, end).lanes}
    return marks[lane - int(np.sign(lane))], marks[lane]


def _runs_on(kinds: tuple[RoadMark, RoadMark]) -> bool:
    """Whether the line at a carriageway's edge leads to a junction and on behind it."""
    return all(mark.type == "solid" for mark in kinds)


def _mark(edge: str, kinds: tuple[RoadMark, RoadMark], merge: bool) -> RoadMark:
    """Return the mark on an edge of a lane, of those on this edge of its lane before and behind the junction."""
    if not merge:
        return replace(kinds[0], lane_change="none") if edge == "free" and _runs_on(kinds) else NO_MARK
    wanted = {"shared": "broken", "free": "solid"}.get(edge)
    found = next((mark for mark in kinds if mark.type == wanted), NO_MARK)
    return replace(found, lane_change="none")
