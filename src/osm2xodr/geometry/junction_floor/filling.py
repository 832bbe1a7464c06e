"""Which edges of lanes the strips begin at that close the gaps of junctions, and their widths in few records."""

from __future__ import annotations

from collections.abc import Callable, Set as AbstractSet
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import Table, join_tables, ranks, sorted_unique, unique_all, unique_first, unique_inverse
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junction_floor import defaults
from osm2xodr.geometry.junction_floor.cells import FACE
from osm2xodr.geometry.junction_floor.cross_sections import CrossSections, LaneEdges
from osm2xodr.geometry.junction_floor.faces import Faces
from osm2xodr.geometry.junction_floor.gaps import (
    RAY_STEP,
    Grids,
    Rays,
    cast_rays,
    find_gaps,
    gaps_left,
    meet,
    room_inside,
)
from osm2xodr.geometry.junction_floor.islands import Hole, find_holes
from osm2xodr.geometry.junction_floor.loops import Loops, fill_loops
from osm2xodr.model import BoolArray, Cubic, FloatArray, IntArray, Rule
from osm2xodr.system import record

# Decimals of the places and widths of records, m.
_DECIMALS: Final = 3
# Between strips, m: keeps their places apart on one axis.
_APART: Final = 1.0

# Distance of the cross sections that strips begin at, m: below a cell's size, none is missed (below 1 / √2).
_SPACING: Final = 0.7 * defaults.GAP_CELL
# So often gaps are looked for, and each gets at most so many strips.
_PASSES: Final = 2
_MOST_STRIPS: Final = 4
# So many cross sections at once a strip goes on where its gap becomes narrower than this, m: cells do not show the
# gap's tip, nor a narrow slit.
_GOES_ON: Final = 11
_NARROW: Final = 1.5
# Where a strip becomes narrower by more than this at once, m, it does so this much later, m, two cross sections on a
# line: cells do not show how far a lane beside it is.
_STEP: Final = 0.3
_LATER: Final = 2.0 * _SPACING
# About so many cross sections are looked at together, those of whole junctions: few enough for a processor's cache.
_AT_ONCE: Final = 100_000
# Strips may reach so far beyond the outermost lanes of an arm where these end, m, and farther by as much as they are
# away from there. A choice: boundaries of junctions close over no more than 0.3 m.
_OPEN_AT_END: Final = 0.2


def width_records(
    strip: IntArray, s: FloatArray, width: FloatArray, count: int, tolerance: float
) -> list[tuple[Cubic, ...]]:
    """Return the widths of strips as linear records that miss no given width by more than a tolerance, m.

    `strip` (n,), ascending, is the strip, 0 … count - 1, that a width, m, at s belongs to; s ascends from 0. Widths
    that are less than those before and behind them become the lesser of these.
    """
    width = _without_dips(strip, width)
    # Of places without width, only those next to some and both ends of strips say anything.
    some = np.pad(width > 0.0, 1)
    some = some[1:-1] | some[:-2] | some[2:] | _is_end(strip)
    strip, s, width = strip[some], s[some], width[some]
    last = np.append(np.diff(strip) > 0, True)
    # At the end of a road up, so that no width falls below 0 before it.
    s = np.where(last, np.ceil(s * 10**_DECIMALS) / 10**_DECIMALS, np.round(s, _DECIMALS))
    width = np.round(width, _DECIMALS)
    keep = _needed(strip, s, width, tolerance)
    strip, s, width = strip[keep], s[keep], width[keep]
    begins = np.flatnonzero(np.diff(strip) == 0)
    slope = (width[begins + 1] - width[begins]) / (s[begins + 1] - s[begins])
    out: list[list[Cubic]] = [[] for _ in range(count)]
    rows = zip(strip[begins].tolist(), s[begins].tolist(), width[begins].tolist(), slope.tolist(), strict=True)
    for k, at, value, rise in rows:
        before = out[k][-1] if out[k] else None
        if before is None or not (value == rise == before.a == before.b == 0.0):
            out[k].append(Cubic(at, value, rise))
    return [tuple(item) for item in out]


def _without_dips(strip: IntArray, width: FloatArray) -> FloatArray:
    """Raise widths between two larger ones: cells show single rays too short, and esmini 3.6 may never load teeth.

    Its search for points of lanes (``CheckAndAddOSIPoint`` in ``RoadManager.cpp``) does not end at some of them.
    """
    out = width.copy()
    within = np.flatnonzero((strip[1:-1] == strip[:-2]) & (strip[1:-1] == strip[2:])) + 1
    out[within] = np.maximum(width[within], np.minimum(width[within - 1], width[within + 1]))
    return out


def _needed(strip: IntArray, s: FloatArray, width: FloatArray, tolerance: float) -> BoolArray:
    """Say which widths are needed, so that straight lines between them are near all others, (n,).

    In each round every other one of each strip is tried, odd and even ones in turn: no strip changes another one.
    """
    ends = _is_end(strip)
    # All strips one behind the other on one axis.
    begin = np.flatnonzero(np.diff(strip, prepend=-1))
    size = s[np.append(begin[1:], len(s)) - 1] + _APART
    axis = s + np.repeat(np.cumsum(size) - size, np.diff(np.append(begin, len(s))))
    keep = np.ones(len(s), bool)
    failed, phase = 0, 1
    while failed < 2:
        kept = np.flatnonzero(keep)
        candidate = (ranks(np.bincount(strip[kept])) % 2 == phase) & ~ends[kept]
        trial = kept[~candidate]
        off = np.abs(np.interp(axis, axis[trial], width[trial]) - width) > tolerance
        # The interval between trial places that each place lies in: one is tried within each.
        interval = np.searchsorted(trial, np.arange(len(s)), side="right") - 1
        bad = np.bincount(interval[off], minlength=len(trial)) > 0
        good = ~bad[interval[kept[candidate]]]
        keep[kept[candidate][good]] = False
        failed = 0 if good.any() else failed + 1
        phase = 1 - phase
    return keep


def _is_end(strip: IntArray) -> BoolArray:
    """Say which rows are the first or the last ones of their strips, which ascend, (n,)."""
    begins = np.diff(strip, prepend=-1, append=np.iinfo(np.int64).max) > 0
    return begins[:-1] | begins[1:]


@record(eq=False)
class Floor:
    """Strips of pavement beside the lanes of connecting roads, by index of the road: their widths along it."""

    left: dict[int, tuple[Cubic, ...]]
    right: dict[int, tuple[Cubic, ...]]
    # Roads whose strips are part of the carriageway, more of them than of islands
    paved_left: frozenset[int] = frozenset()
    paved_right: frozenset[int] = frozenset()
    islands: tuple[Hole, ...] = ()  # What lanes for cars go round and is no pavement


def lay_floor(
    roads: ConnectingRoads,
    rule: Rule,
    faces: Faces | None = None,
    unpaved: AbstractSet[int] = frozenset(),
    is_island: Callable[[Hole], bool] = lambda hole: False,
) -> Floor:
    """Return the strips beside connecting roads that close the gaps which these, and the ends of roads, enclose.

    `unpaved` are the junctions whose loops go round something else than pavement; `is_island` says which places of
    some size that lanes for cars alone go round are not paved.
    """
    if not len(roads.length):
        return Floor({}, {})
    edges = LaneEdges.of(roads, rule)
    known, junction = unique_inverse(roads.junction)
    faces = (faces or Faces.none()).within(known)
    cars = roads.for_vehicles()
    loops = Loops.of(roads, cars, unpaved)
    parts = [
        _laid(rows, junction[rows], roads, cars, edges, faces, loops, is_island) for rows in _batches(roads, junction)
    ]
    found = [sections for sections, *_ in parts]
    road, s, spacing = (np.concatenate([getattr(item, k) for item in found]) for k in ("road", "s", "spacing"))
    order = np.argsort(road, kind="stable")
    road, s, spacing = road[order], s[order], spacing[order]
    widths = np.hstack([width for _, width, *_ in parts])[:, order]
    paved = np.hstack([item for *_, item, _ in parts])[:, order]
    left, right = (_records(road, s, spacing, each) for each in widths)
    paved_left, paved_right = (_mostly_paved(road, spacing, widths[k], paved[k]) for k in (0, 1))
    return Floor(left, right, paved_left, paved_right, tuple(hole for *_, islands in parts for hole in islands))


def _batches(roads: ConnectingRoads, junction: IntArray) -> list[IntArray]:
    """Return the indices of roads in ascending order, some whole junctions in each batch."""
    size = np.bincount(junction, roads.length / _SPACING + 2)
    batch = ((np.cumsum(size) - size) // _AT_ONCE).astype(np.int64)[junction]
    order = np.argsort(batch, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(batch[order])) + 1)


def _laid(
    rows: IntArray,
    junction_of: IntArray,
    roads: ConnectingRoads,
    cars: BoolArray,
    edges: LaneEdges,
    faces: Faces,
    loops: Loops,
    is_island: Callable[[Hole], bool],
) -> tuple[CrossSections, FloatArray, BoolArray, list[Hole]]:
    """Return the cross sections of roads with strips, how wide these are and which are paved, (2, n), m, and islands.

    `rows` are the roads of some whole junctions, and `junction_of` is theirs; `cars` (roads,) are for motor vehicles.
    """
    outline = CrossSections.few(roads, edges, defaults.GAP_CHORD, rows)
    outline = outline.widened(*fill_loops(outline, loops))
    known, number = unique_inverse(junction_of)
    faces = faces.within(known)
    junction = number[np.searchsorted(rows, outline.road)]
    grids = find_gaps(outline, junction, faces)
    islands = [(hole, gap) for hole, gap in find_holes(grids, cars) if is_island(hole)]
    grids = grids.without_pavement(np.array([gap for _, gap in islands], np.int64))
    in_loops = loops.road[np.isin(loops.road, rows)]
    near = sorted_unique(np.concatenate([in_loops, grids.beside_gaps(outline, junction)]))
    sections = CrossSections.of(roads, edges, _SPACING, near)
    junction = number[np.searchsorted(rows, sections.road)]
    # These are whole, whatever cells show where their cross sections are far from each other.
    width, paved = fill_loops(sections, loops)
    fixed = width > 0.0
    for again in range(_PASSES):
        if again:
            # What strips do not cover in spite of the cells, because they end, begin or bend, is found the next time.
            sections = sections.widened(width, paved)
            grids.draw_strips(sections, junction)
            grids = gaps_left(grids)
        more, of_these = _strips(grids, sections, junction, roads, edges)
        more[fixed] = 0.0
        paved = np.where(more > width, of_these, paved)
        width = width + more
    used = _of_roads_with_strips(width, sections)
    sections, width = sections.chosen(used), width[:, used]
    # What is open to the side where the lanes of an arm end stays so.
    room = room_before_ends(sections, rows, roads, edges, faces)
    width = np.where(fixed[:, used], width, np.minimum(width, room))
    return sections, width, paved[:, used], [hole for hole, _ in islands]


def _of_roads_with_strips(width: FloatArray, sections: CrossSections) -> IntArray:
    """Return the indices of the cross sections of all roads beside which there is any strip, (m,)."""
    with_strip = np.zeros(int(sections.road.max(initial=-1)) + 1, bool)
    with_strip[sections.road[width.any(axis=0)]] = True
    return np.flatnonzero(with_strip[sections.road])


def _strips(
    grids: Grids, sections: CrossSections, junction: IntArray, roads: ConnectingRoads, edges: LaneEdges
) -> tuple[FloatArray, BoolArray]:
    """Return the widths of strips, left and right (2, n), m, and which are paved."""
    width, paved = np.zeros((2, len(sections.s))), np.ones((2, len(sections.s)), bool)
    rays = cast_rays(grids, sections, junction)
    for _ in range(_MOST_STRIPS):
        if not len(rays.gap):
            break
        end, met = rays.ends(grids)
        best = _largest(rays, end, sections)
        if not best.any():
            break
        strip = _Strips.along(rays.chosen(best), end[best], met[best], grids, sections, roads, edges)
        for part in (strip, _continued(strip, sections, roads, edges)):
            np.maximum.at(width, (part.row, part.section), part.reach + defaults.FLOOR_OVERLAP)
            paved[part.row[~part.paved], part.section[~part.paved]] = False
        rays.chosen(best).close(end[best], grids)
        rays = rays.chosen(~best & (end > rays.first))
    rows = _of_roads_with_strips(width, sections)
    width[:, rows] = _with_late_steps(width[:, rows], sections.chosen(rows))
    return width, paved


def _with_late_steps(width: FloatArray, sections: CrossSections) -> FloatArray:
    """Return widths (2, n), m, of strips that go on at full width where they would step down, but fold in no bend."""
    out, road, s = width.copy(), sections.road, sections.s
    for far in range(1, int(_LATER / float(sections.spacing.min(initial=_LATER))) + 1):
        for here, there in ((slice(far, None), slice(None, -far)), (slice(None, -far), slice(far, None))):
            steps = (road[here] == road[there]) & (np.abs(s[there] - s[here]) <= _LATER)
            steps = steps & (width[:, there] > width[:, here] + _STEP)
            out[:, here] = np.where(steps, np.maximum(out[:, here], width[:, there]), out[:, here])
    room = np.array([room_inside(sections, side, np.arange(len(road))) for side in (1, -1)])
    return np.asarray(np.minimum(out, np.maximum(room, 0.0)))


def _largest(rays: Rays, end: IntArray, sections: CrossSections) -> BoolArray:
    """Say which rays belong to the edge from which their gap is seen best, (n,); none where too little is seen.

    Of edges that see as much, the longest one is best: rays from there end at the gap's tips, not before them.
    """
    k = rays.section
    middle = sections.edge(rays.side, k) + rays.side * (rays.first + end - 1) * (RAY_STEP / 2)
    size = (end - rays.first) * RAY_STEP * sections.spacing[k] * (1.0 - sections.curvature[k] * middle)
    key = (rays.gap * (int(sections.road[-1]) + 1) + sections.road[k]) * 2 + (rays.side < 0)
    kinds, first, kind, _ = unique_all(key)
    total = np.bincount(kind, size, len(kinds))
    length = np.bincount(kind, sections.spacing[k], len(kinds))
    order = np.lexsort((kinds, -(total**2) * length, rays.gap[first]))
    largest = order[unique_first(rays.gap[first][order])[1]]
    good = np.zeros(len(kinds), bool)
    good[largest] = total[largest] >= defaults.GAP_LEAST_AREA
    return np.asarray(good[kind])


@record(eq=False)
class _Strips(Table):
    """Widths of strips at cross sections."""

    section: IntArray  # (n,) Index of the cross section
    side: IntArray  # (n,) Left 1, right -1
    other: IntArray  # (n,) The connecting road at whose lanes the strip ends there; -1 for none
    paved: BoolArray  # (n,) Whether it is part of the carriageway
    reach: FloatArray  # (n,) Its width, m

    @classmethod
    def along(
        cls,
        rays: Rays,
        end: IntArray,
        other: IntArray,
        grids: Grids,
        sections: CrossSections,
        roads: ConnectingRoads,
        edges: LaneEdges,
    ) -> _Strips:
        """Return strips along rays as far as the lanes behind the gap, or another one where these end."""
        reach, _ = meet(rays.section, rays.side, end * RAY_STEP, other, sections, roads, edges)
        at = np.flatnonzero(other == FACE)
        if len(at):
            k, sign = rays.section[at], rays.side[at]
            edge, dx, dy = sections.edge(sign, k), sections.nx[k], sections.ny[k]
            begin = sections.x[k] + edge * dx, sections.y[k] + edge * dy
            reach[at] = grids.faces.meet(*begin, sign * dx, sign * dy, reach[at])
        order = np.lexsort((rays.section, rays.side))
        return cls(rays.section[order], rays.side[order], other[order], grids.paved[rays.gap][order], reach[order])

    @property
    def row(self) -> IntArray:
        """0 for left, 1 for right, (n,)."""
        return (self.side < 0).astype(np.int64)

    def ahead(
        self, sense: int, most: FloatArray, sections: CrossSections, roads: ConnectingRoads, edges: LaneEdges
    ) -> tuple[_Strips, BoolArray]:
        """Return strips at the next cross sections, in a sense along roads, as long as they are narrow or become so.

        The first ones are narrow or at most so wide, (n,), m. The second array says which are the last of those that
        were looked at, and may go on.
        """
        steps = np.arange(1, _GOES_ON + 1)
        ahead = np.clip(self.section[:, None] + sense * steps, 0, len(sections.road) - 1)
        same = sections.road[ahead] == sections.road[self.section, None]
        same &= ahead == self.section[:, None] + sense * steps
        each = self.chosen(np.repeat(np.arange(len(same)), len(steps)))
        # Nothing is met beyond the end of a road.
        other = np.where(same.ravel(), each.other, -1)
        far, found = meet(ahead.ravel(), each.side, each.reach, other, sections, roads, edges)
        reach, met = far.reshape(ahead.shape), found.reshape(ahead.shape)
        good = met & (reach > 0.0) & (reach < _NARROW)
        good &= reach <= np.maximum(np.column_stack([most, reach[:, :-1]]), _NARROW / 4)
        keep = np.logical_and.accumulate(good, axis=1).ravel()
        whole = np.broadcast_to(steps == _GOES_ON, ahead.shape).ravel()
        return replace(each, section=ahead.ravel(), reach=far).chosen(keep), whole[keep]


def _continued(strips: _Strips, sections: CrossSections, roads: ConnectingRoads, edges: LaneEdges) -> _Strips:
    """Return how strips go on beyond both of their ends, where cells of lanes hide how narrow gaps end."""
    section, side = strips.section, strips.side
    apart = (np.diff(section) != 1) | (np.diff(side) != 0) | (np.diff(sections.road[section]) != 0)
    found = [strips.chosen(np.zeros(len(section), bool))]
    for sense, ends in ((-1, np.append(True, apart)), (1, np.append(apart, True))):
        here = strips.chosen(ends & (strips.other >= 0))
        most = np.full(len(here.section), _NARROW)
        while len(here.section):
            ahead, whole = here.ahead(sense, most, sections, roads, edges)
            found.append(ahead)
            # Narrow slits are as long as the lanes beside them.
            here = ahead.chosen(whole)
            most = here.reach
    return join_tables(found)


def _records(road: IntArray, s: FloatArray, spacing: FloatArray, width: FloatArray) -> dict[int, tuple[Cubic, ...]]:
    """Return the widths of the roads that have a strip, by index of the road; all at cross sections, (n,), m."""
    beyond = np.maximum(width - defaults.FLOOR_OVERLAP, 0.0)
    area = np.bincount(road, beyond * spacing)
    with_strip = np.flatnonzero(area >= defaults.FLOOR_LEAST_AREA)
    if not len(with_strip):
        return {}
    rows = np.flatnonzero(np.isin(road, with_strip))
    strip = np.searchsorted(with_strip, road[rows])
    records = width_records(strip, s[rows], width[rows], len(with_strip), defaults.FLOOR_TOLERANCE)
    return dict(zip(with_strip.tolist(), records, strict=True))


def _mostly_paved(road: IntArray, spacing: FloatArray, width: FloatArray, paved: BoolArray) -> frozenset[int]:
    """Return the roads whose strips are paved on more than half of their area."""
    whole, part = (np.bincount(road, item * spacing) for item in (width, width * paved))
    return frozenset(np.flatnonzero(part > whole / 2).tolist())


def room_before_ends(
    sections: CrossSections, rows: IntArray, roads: ConnectingRoads, edges: LaneEdges, faces: Faces
) -> FloatArray:
    """Return how wide strips may be at the left and the right of cross sections of some roads, (2, n), m.

    `rows` (k,), ascending, are all roads at their arms. Where lanes of an arm lead nowhere, all of it counts.
    """
    end, same, low, high = edges.on_arms(roads, rows)
    arms, arm = unique_inverse(end)
    here = np.isin(faces.end, arms)
    face = np.searchsorted(arms, faces.end[here])
    lowest, highest = np.full(len(arms), np.inf), np.full(len(arms), -np.inf)
    lowest[face], highest[face] = faces.right[here], faces.left[here]
    np.minimum.at(lowest, arm, low)
    np.maximum.at(highest, arm, high)
    below, above = low - lowest[arm], highest[arm] - high
    road = np.searchsorted(rows, sections.road)
    to_end = edges.length[sections.road] - sections.s
    out = []
    for room in (np.where(same, above, below), np.where(same, below, above)):
        at_start, at_end = room.reshape(2, -1)[:, road]
        out.append(_OPEN_AT_END + np.minimum(at_start + sections.s, at_end + to_end))
    return np.array(out)
