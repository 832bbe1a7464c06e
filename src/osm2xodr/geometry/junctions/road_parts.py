"""Which part of which street becomes a road, what its lanes are, and where streets and nodes are in the road map."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import (
    cosine,
    curve_ends,
    cut_curves,
    hypot,
    lengths,
    pose,
    project,
    repeated,
    snap_cuts,
    sorted_unique,
    wrapped,
)
from osm2xodr.geometry.junctions.clusters import JunctionLayout
from osm2xodr.geometry.junctions.movements import Movement
from osm2xodr.geometry.lanes import Piece, Stretch, car_directions, stretches, taper_zones
from osm2xodr.geometry.plan_view import FittedStreets, StreetEnds, outermost_lanes, places_clear_of_bends
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView, Rule, StreetNetwork, StreetPlaces
from osm2xodr.system import record

# Dead ends at one node lie on each other but where they go on beyond one another within the angle of this cosine (20
# degrees). A choice.
_STRAIGHT_ON: Final = 0.94
# Rings close to this, m and rad.
_CLOSED: Final = 1e-3


@record(eq=False)
class RoadParts:
    """The roads outside junctions. Road end number 2 k is the start of road k, 2 k + 1 its end."""

    plan_view: PlanView  # One curve per road
    length: FloatArray  # (roads,) m
    street: IntArray  # (roads,) The street each is part of
    # (roads,) s on the street where the road begins and where it ends, m
    begin: FloatArray
    end: FloatArray
    road_end: IntArray  # (street ends,) Road end that each street end became, -1 for none
    end_junction: IntArray  # (roads, 2) Junction at either end, -1 for none
    end_link: IntArray  # (roads, 2) Road end that touches directly, -1 for none
    stretches: tuple[tuple[Stretch, ...], ...]  # Of each road
    fitted: FittedStreets  # The streets that they were cut from
    pieces: tuple[tuple[Piece, ...], ...]  # Of each street, with borders where lanes may change

    def street_end(self) -> IntArray:
        """Return the street end that each road end was, (2 roads,), -1 for none."""
        out = np.full(2 * len(self.length), -1, np.int64)
        used = np.flatnonzero(self.road_end >= 0)
        out[self.road_end[used]] = used
        return out

    def at_end(self, end: int) -> Stretch:
        """Return the stretch at a road end."""
        return self.stretches[end // 2][-1 if end % 2 else 0]


def end_poses(parts: RoadParts, end: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x and y, m, of road ends, (n,), and the heading of their roads there, rad."""
    return pose(parts.plan_view, end // 2, np.where(end % 2 == 1, parts.length[end // 2], 0.0))


def without_idle_junctions(ends: StreetEnds, layout: JunctionLayout, movements: list[Movement]) -> JunctionLayout:
    """Take out junctions that nobody can drive through: their arms are dead ends.

    The widest, the first of equal ones, keeps its length, and so does what goes on beyond it. Others lie on it, as
    where an area ends between a motorway and its ramp, and end where they are apart.
    """
    used = np.zeros(len(layout.arms), bool)
    used[[item.junction for item in movements]] = True
    idle = (layout.junction >= 0) & ~np.append(used, False)[layout.junction]
    trim = layout.trim.copy()
    for junction in sorted_unique(layout.junction[idle]).tolist():
        arms = np.array(layout.arms[junction])
        widest = arms[np.argmax(ends.left[arms] - ends.right[arms])]
        trim[arms[(arms == widest) | (cosine(ends.hdg[arms] - ends.hdg[widest]) < -_STRAIGHT_ON)]] = 0.0
    return replace(layout, junction=np.where(idle, -1, layout.junction), trim=trim)


def head_on_ends(ends: StreetEnds, layout: JunctionLayout, parts: RoadParts) -> dict[int, int]:
    """Return the road ends that touch another one from which nobody may go on, by each other's number.

    They are the two ends at a node that keep their length, as of one-ways that meet head-on.
    """
    at = np.flatnonzero(ends.node >= 0)
    order = at[np.argsort(ends.node[at], kind="stable")]
    first = np.flatnonzero(np.diff(ends.node[order], prepend=-1))
    two = first[np.diff(np.append(first, len(order))) == 2]
    one, other = order[two], order[two + 1]
    free = (layout.junction < 0) & (layout.trim == 0.0) & (parts.road_end >= 0)
    chosen = free[one] & free[other] & (cosine(ends.hdg[one] - ends.hdg[other]) <= -_STRAIGHT_ON)
    a, b = parts.road_end[one[chosen]].tolist(), parts.road_end[other[chosen]].tolist()
    return dict(zip(a + b, b + a, strict=True))


def cut_roads(
    network: StreetNetwork, fitted: FittedStreets, layout: JunctionLayout, earlier: RoadParts | None = None
) -> RoadParts:
    """Cut streets to roads at their junctions; what is unchanged since an earlier cut is taken from there.

    A closed ring, and a street that leaves a junction and comes back to it, become two roads that touch: no road may
    be its own successor, and readers take a road with one junction at both ends for a way through it.
    """
    length = lengths(fitted.plan_view)
    begin, end = layout.trim[0::2], length - layout.trim[1::2]
    first, last = layout.junction[0::2], layout.junction[1::2]
    halved = np.array([street.start < 0 for street in network.streets], bool) | ((first >= 0) & (first == last))
    whole, halves = np.flatnonzero(~layout.inner & ~halved), np.flatnonzero(~layout.inner & halved)
    pieces = earlier.pieces if earlier is not None and earlier.fitted is fitted else _lane_pieces(fitted, length)
    uncut = [
        _stretches_to_halve(pieces[k], begin[k], end[k], network.streets[k].start < 0, network.rule)
        for k in halves.tolist()
    ]
    middle = _middles(fitted, halves, begin[halves], uncut, length, network.rule)
    street = np.concatenate([whole, np.repeat(halves, 2)])
    lo = np.concatenate([begin[whole], np.column_stack([begin[halves], middle]).ravel()])
    hi = np.concatenate([end[whole], np.column_stack([middle, end[halves]]).ravel()])
    lo, hi = snap_cuts(fitted.plan_view, street, lo), snap_cuts(fitted.plan_view, street, hi)
    plan = cut_curves(fitted.plan_view, lo, hi, street)
    n = len(whole)
    cuts = zip(uncut, begin[halves].tolist(), hi[n::2].tolist(), strict=True)
    ring = (first[halves] < 0) & _closes(fitted.plan_view, halves, length)
    road_end, end_junction, end_link = _road_ends(layout.junction, whole, halves, ring)
    return RoadParts(
        plan_view=plan,
        length=lengths(plan),
        street=street,
        begin=lo,
        end=hi,
        road_end=road_end,
        end_junction=end_junction,
        end_link=end_link,
        stretches=(
            *_stretches(pieces, whole, lo[:n], hi[:n], earlier, network.rule),
            *(half for found, start, cut in cuts for half in _cut_in_two(found, cut - start)),
        ),
        fitted=fitted,
        pieces=pieces,
    )


def _road_ends(
    junction: IntArray, whole: IntArray, halves: IntArray, ring: BoolArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Return the road end of each street end, and the junction and the road end at either end of each road; -1: none.

    Roads are the whole streets, then the halves of those cut in two. `junction` is that of each street end, `ring`
    says which of the halved streets are closed.
    """
    roads = len(whole) + 2 * len(halves)
    before = np.arange(len(whole), roads, 2)
    after = before + 1
    front, back = np.append(np.arange(len(whole)), before), np.append(np.arange(len(whole)), after)
    street = np.concatenate([whole, halves])
    road_end = np.full(len(junction), -1, np.int64)
    road_end[2 * street], road_end[2 * street + 1] = 2 * front, 2 * back + 1
    end_junction = np.full((roads, 2), -1, np.int64)
    end_junction[front, 0], end_junction[back, 1] = junction[2 * street], junction[2 * street + 1]
    end_link = np.full((roads, 2), -1, np.int64)
    end_link[before, 1], end_link[after, 0] = 2 * after, 2 * before + 1
    end_link[before[ring], 0], end_link[after[ring], 1] = 2 * after[ring] + 1, 2 * before[ring]
    return road_end, end_junction, end_link


def _middles(
    fitted: FittedStreets,
    street: IntArray,
    begin: FloatArray,
    uncut: list[list[Stretch]],
    length: FloatArray,
    rule: Rule,
) -> FloatArray:
    """Return s on streets where they are cut in two, (n,), m: on their longest stretches, off tight bends."""
    right, left = np.array([outermost_lanes(fitted.pieces[k]) for k in street.tolist()]).reshape(-1, 2).T
    least, most = np.array([_room_to_halve(found, rule) for found in uncut]).reshape(-1, 2).T + begin
    middle = places_clear_of_bends(fitted.plan_view, street, (least + most) / 2, right, left, length)
    return np.clip(middle, least, most)


def _closes(plan: PlanView, curve: IntArray, length: FloatArray) -> BoolArray:
    """Say which curves end where they start, and in the same direction; a line to and fro does not."""
    (x0, y0, hdg0), (x1, y1, hdg1) = curve_ends(plan, curve)
    return (hypot(x1 - x0, y1 - y0) < _CLOSED) & (np.abs(wrapped(hdg1 - hdg0)) < _CLOSED)


def _stretches_to_halve(pieces: Sequence[Piece], begin: float, end: float, ring: bool, rule: Rule) -> list[Stretch]:
    """Return the stretches of a street that becomes two roads: both must agree about the lanes where they touch."""
    found = stretches(pieces, begin, end, rule, (end - begin) / 2)
    if ring and found[0].section != found[-1].section:
        # The ring was opened within a stretch that was too short to be kept: the longest one takes the whole ring.
        longest = max(found, key=lambda item: item.end - item.start)
        found = [replace(longest, start=0.0, end=end - begin, ways=tuple(way for item in found for way in item.ways))]
    return found


def _room_to_halve(found: Sequence[Stretch], rule: Rule) -> tuple[float, float]:
    """Return between which s a road may be halved: where its lanes stay longest the same, within its middle half."""
    length = found[-1].end
    zones = taper_zones(found, rule, room=length / 2)
    begin, end = [0.0, *(zone.end for zone in zones)], [*(zone.start for zone in zones), length]
    spans = [(max(lo, length / 4), min(hi, 3 * length / 4)) for lo, hi in zip(begin, end, strict=True)]
    lower, upper = max(spans, key=lambda span: span[1] - span[0])
    off = 0.25 * (upper - lower)
    return lower + (off if lower > length / 4 else 0.0), upper - (off if upper < 3 * length / 4 else 0.0)


def _cut_in_two(found: Sequence[Stretch], cut: float) -> tuple[tuple[Stretch, ...], tuple[Stretch, ...]]:
    """Return the stretches before and after s = cut."""
    before = tuple(replace(item, end=min(item.end, cut)) for item in found if item.start < cut)
    after = tuple(
        replace(item, start=max(item.start - cut, 0.0), end=item.end - cut) for item in found if item.end > cut
    )
    return before, after


def _stretches(
    pieces: Sequence[tuple[Piece, ...]],
    street: IntArray,
    lo: FloatArray,
    hi: FloatArray,
    earlier: RoadParts | None,
    rule: Rule,
) -> tuple[tuple[Stretch, ...], ...]:
    """Return the stretches of the roads from lo to hi of streets, (roads,); unchanged roads keep theirs."""
    known: dict[tuple[int, float, float], tuple[Stretch, ...]] = {}
    if earlier is not None:
        roads = zip(earlier.street.tolist(), earlier.begin.tolist(), earlier.end.tolist(), strict=True)
        same = [one is other for one, other in zip(earlier.pieces, pieces, strict=True)]
        known = {road: found for road, found in zip(roads, earlier.stretches, strict=True) if same[road[0]]}
    return tuple(
        known.get(road) or tuple(stretches(pieces[road[0]], road[1], road[2], rule))
        for road in zip(street.tolist(), lo.tolist(), hi.tolist(), strict=True)
    )


def _lane_pieces(fitted: FittedStreets, length: FloatArray) -> tuple[tuple[Piece, ...], ...]:
    """Return the pieces of all streets with their borders moved out of tight bends, where lanes may change."""
    inner = [(k, i) for k, pieces in enumerate(fitted.pieces) for i in range(1, len(pieces))]
    if not inner:
        return fitted.pieces
    curve = np.array([k for k, _ in inner], np.int64)
    s = np.array([fitted.pieces[k][i][0] for k, i in inner])
    right, left = np.array([outermost_lanes(fitted.pieces[k][i - 1 : i + 1]) for k, i in inner]).T
    # Lanes against a one-way piece stay out of it: the border moves away from that.
    cars = [[car_directions(fitted.pieces[k][i + j][2]) for j in (-1, 0)] for k, i in inner]
    side = np.array([(before < after) - (after < before) for before, after in cars], np.int64)
    moved = places_clear_of_bends(fitted.plan_view, curve, s, right, left, length, side)
    out = list(fitted.pieces)
    changed = sorted_unique(curve[moved != s])
    first, last = np.searchsorted(curve, changed), np.searchsorted(curve, changed, side="right")
    for k, lo, hi in zip(changed.tolist(), first.tolist(), last.tolist(), strict=True):
        pieces = fitted.pieces[k]
        starts = [pieces[0][0], *moved[lo:hi].tolist()]
        if all(one < other for one, other in pairwise(starts)):
            out[k] = tuple((start, a, c) for start, (_, a, c) in zip(starts, pieces, strict=True))
    return tuple(out)


def street_places(
    network: StreetNetwork,
    layout: JunctionLayout,
    parts: RoadParts,
    road_id: Callable[[int], int],
    junction_ids: IntArray,
) -> StreetPlaces:
    """Find where streets and their tagged nodes are in the road map.

    `road_id` gives the id of the k-th road; `junction_ids` (junctions + 1,) are those of the layout's junctions, -1
    for those that are not written; the last is -1.
    """
    end_road = np.array([road_id(end // 2) if end >= 0 else -1 for end in parts.road_end.tolist()], np.int64)
    of_node = np.full(len(network.intersections) + 1, -1, np.int64)
    for junction, nodes in enumerate(layout.nodes):
        of_node[list(nodes)] = junction_ids[junction]
    ends = np.array([node for street in network.streets for node in (street.start, street.end)], np.int64)
    end_junction = np.where(np.repeat(layout.inner, 2), of_node[ends], junction_ids[layout.junction])
    node, street, x, y = _tagged(network)
    road, s, t = _on_roads(parts, street, x, y)
    within = _junctions(parts, layout, end_junction, street, road, s)
    return StreetPlaces(
        road_street=parts.street,
        end_road=end_road,
        end_junction=end_junction,
        inner=layout.inner,
        node=node,
        street=street,
        road=np.array([road_id(k) if k >= 0 else -1 for k in road.tolist()], np.int64),
        s=s,
        t=t,
        junction=within,
    )


def _tagged(network: StreetNetwork) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """Return node, street, x and y of every place of a tagged node on a street."""
    count = [len(street.node_ids) for street in network.streets]
    nodes = np.concatenate([street.node_ids for street in network.streets])
    points = np.concatenate([street.points for street in network.streets])
    owner = repeated(count)
    rows = np.flatnonzero(np.isin(nodes, np.array(list(network.node_tags), np.int64)))
    return nodes[rows], owner[rows], points[rows, 0], points[rows, 1]


def _on_roads(
    parts: RoadParts, street: IntArray, x: FloatArray, y: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the index of the street's nearest road (-1 for none), s on it (or beyond its ends) and t, all (n,)."""
    on_street, t, _ = project(parts.fitted.plan_view, street, x, y)
    first = np.full(len(parts.fitted.pieces), -1, np.int64)
    second = first.copy()
    for k, owner in enumerate(parts.street.tolist()):
        (second if first[owner] >= 0 else first)[owner] = k
    road, other = first[street], second[street]
    begin, end = np.append(parts.begin, 0.0), np.append(parts.end, 0.0)

    def off(k: IntArray) -> FloatArray:
        return np.maximum(np.maximum(begin[k] - on_street, on_street - end[k]), 0.0)

    road = np.where((other >= 0) & (off(other) < off(road)), other, road)
    s = np.where(road >= 0, on_street - begin[road], np.nan)
    return road, s, np.where(road >= 0, t, np.nan)


def _junctions(
    parts: RoadParts, layout: JunctionLayout, end_junction: IntArray, street: IntArray, road: IntArray, s: FloatArray
) -> IntArray:
    """Return the junction that each place lies in, -1 for none."""
    length = np.append(lengths(parts.plan_view), 0.0)[road]
    out: IntArray = np.full(len(street), -1, np.int64)
    before, beyond = s < 0.0, s > length
    out[before] = end_junction[2 * street[before]]
    out[beyond] = end_junction[2 * street[beyond] + 1]
    inner = layout.inner[street]
    out[inner] = end_junction[2 * street[inner]]
    return out
