"""Boundaries of junctions as records of a road map.

They go round roads that bulge out of them, too, as loops of turns back do.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import hypot, owners, ranks, repeated, runs, starts, unique_first, unique_inverse, unique_rows
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.junction_boundaries import defaults
from osm2xodr.geometry.junction_boundaries.corners import Arms, Pieces, find_pieces, first_edges, lanes_across
from osm2xodr.geometry.junction_boundaries.edges import (
    Edges,
    Lines,
    crossings,
    edge_lines,
    lines_along,
    near_segments,
)
from osm2xodr.model import BoolArray, BoundaryEdge, BoundaryJoint, FloatArray, IntArray, RoadMap
from osm2xodr.system import record

# Decimals of the places where edges meet, m.
_DECIMALS: Final = 3
# Most edges that follow each other between two arms.
_MOST_PIECES: Final = 12
# Pieces of edges begin this far beyond where they are joined, m: a crossing does not count twice.
_BEYOND: Final = 0.02
# So many places ahead edges that begin at one place are compared: about 20 m.
_AHEAD: Final = 40
# So many places behind their crossing one edge leads out of the other: about 2 m.
_BEHIND: Final = 4
# Rings of junctions are compared with places on edges some at a time.
_PAIRS_AT_ONCE: Final = 100_000


def find_boundaries(road_map: RoadMap, diagnostics: Diagnostics) -> RoadMap:
    """Return a road map whose junctions know their boundary, as `with_boundaries` says."""
    edges = Edges.of(road_map)
    if not len(edges.road):
        return road_map
    arms = Arms.of(road_map, edges)
    pieces = around_bulges(arms, edges, find_pieces(arms, edges))
    lanes, right, left = lanes_across(road_map, arms)
    closed = _closed(arms, edges, pieces, right, left)
    roads, segments = road_map.roads, _edge_segments(road_map, edges, pieces)
    found: dict[int, list[BoundaryEdge | BoundaryJoint]] = {}
    order = np.lexsort((arms.rank, arms.junction))
    for k in order[closed[order]].tolist():
        across = lanes[k] or (None, None)
        joint = BoundaryJoint(roads[arms.road[k]].id, bool(arms.at_start[k]), *across)
        found.setdefault(int(arms.junction[k]), []).extend([joint, *segments[k]])
    junctions = tuple(replace(item, boundary=tuple(found.get(item.id, ()))) for item in road_map.junctions)
    if len(found) < len(junctions):
        open_ = len(junctions) - len(found)
        said = f"{open_} of {len(junctions)} junctions have no boundary: their roads leave gaps between arms"
        diagnostics.note("junction-boundary", "", said)
    return replace(road_map, junctions=junctions)


def _closed(arms: Arms, edges: Edges, pieces: Pieces, right: FloatArray, left: FloatArray) -> BoolArray:
    """Say for which arms the boundary of their junction is closed, (arms,); u of their joints' ends, (arms,), m."""
    good = pieces.gap <= defaults.CLOSED_WITHIN
    arm, begin = unique_first(pieces.arm)
    last = np.append(begin[1:], len(pieces.arm)) - 1
    for face, u, row, s in (
        (arm, left, begin, pieces.begin),
        (arms.following[arm], right, last, pieces.end),
    ):
        off = hypot(*(edges.at(pieces.edge[row], s[row]) - arms.at(face, u[face])).T)
        good &= off <= defaults.CLOSED_WITHIN
    group = unique_inverse(arms.junction)[1]
    bad = np.bincount(group[~good], minlength=int(group.max()) + 1) > 0
    return ~bad[group]


def _edge_segments(road_map: RoadMap, edges: Edges, pieces: Pieces) -> dict[int, list[BoundaryEdge]]:
    """Return the segments along connecting roads behind each arm."""
    out: dict[int, list[BoundaryEdge]] = {}
    length = edges.length[pieces.edge // 2]
    s = [np.where(v >= length, np.inf, v.round(_DECIMALS)) for v in (pieces.begin, pieces.end)]
    columns = pieces.arm, edges.road[pieces.edge // 2], edges.lane[pieces.edge], *s
    for arm, road, *rest in zip(*(column.tolist() for column in columns), strict=True):
        out.setdefault(arm, []).append(BoundaryEdge(road_map.roads[road].id, *rest))
    return out


def around_bulges(arms: Arms, edges: Edges, pieces: Pieces) -> Pieces:
    """Return pieces that also go round what bulges out of them; with an endless gap where that cannot be."""
    group = unique_inverse(arms.junction)[1]
    of_edge = np.repeat(group[arms.arm[::2]], 2)
    outside = _outside(arms, group, of_edge, edges, pieces)
    if not outside.any():
        return pieces
    first, second, _ = first_edges(arms)
    again = np.flatnonzero(np.isin(group, of_edge[outside]))
    bulging = np.flatnonzero(outside)
    bulging = bulging[np.argsort(of_edge[bulging], kind="stable")]
    begin, end = (np.searchsorted(of_edge[bulging], group[again], side) for side in ("left", "right"))
    # Behind each arm: what bulges, and the edges between this arm and the next.
    every = np.arange(len(again))
    corner = np.concatenate([np.repeat(every, end - begin), every, every])
    edge = np.concatenate([bulging[runs(begin, end - begin)], first[again], second[again]])
    corner, edge = unique_rows(np.column_stack([corner, edge])).values.T
    walked, good = _walked(_Ways(first[again], second[again], corner, edge), edges)
    gap = np.zeros(len(arms.road))
    gap[again[~good]] = np.inf
    pieces = pieces.replaced(again, replace(walked, arm=again[walked.arm], gap=gap))
    still = _outside(arms, group, of_edge, edges, pieces)
    pieces.gap[np.isin(group, of_edge[still])] = np.inf
    return pieces


def _outside(arms: Arms, group: IntArray, of_edge: IntArray, edges: Edges, pieces: Pieces) -> BoolArray:
    """Say which edges have places outside of their junction's boundary, (edges,)."""
    order = np.lexsort((np.arange(len(pieces.arm)), arms.rank[pieces.arm], group[pieces.arm]))
    edge, begin, end = pieces.edge[order], pieces.begin[order], pieces.end[order]
    ring = lines_along(edges, edge, begin, end, defaults.RING_SPACING)
    of_ring = group[pieces.arm[order]][owners(ring.start)]
    first = starts(np.bincount(of_ring, minlength=int(group.max()) + 1))
    length = edges.length[np.arange(len(of_edge)) // 2]
    number = np.maximum(np.ceil(length / defaults.BULGE_SPACING).astype(np.int64), defaults.BULGE_PLACES)
    edge = repeated(number)
    place = edges.at(edge, (ranks(number) + 0.5) / number[edge] * length[edge], defaults.BULGE_LEAST)
    junction, out = of_edge[edge], np.zeros(len(of_edge), bool)
    count = np.diff(first)[junction]
    for rows in np.split(np.arange(len(edge)), np.flatnonzero(np.diff(np.cumsum(count) // _PAIRS_AT_ONCE)) + 1):
        point, k = np.repeat(rows, count[rows]), runs(first[junction[rows]], count[rows])
        following = np.where(k + 1 == first[junction[point] + 1], first[junction[point]], k + 1)
        times = _times_around(place[point], ring.xy[k], ring.xy[following], point - rows[0], len(rows))
        out[edge[rows[times % 2 == 0]]] = True
    return out


def _times_around(place: FloatArray, a: FloatArray, b: FloatArray, owner: IntArray, count: int) -> IntArray:
    """Return how many segments a-b lie east of each place, (count,)."""
    below, over = a[:, 1] <= place[:, 1], b[:, 1] <= place[:, 1]
    side: FloatArray = (b[:, 0] - a[:, 0]) * (place[:, 1] - a[:, 1]) - (place[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
    hit = (below != over) & ((side > 0.0) == below)
    return np.bincount(owner[hit], minlength=count)


@record(eq=False)
class _Ways:
    """Ways round corners that are looked for, and the edges that they may follow."""

    first: IntArray  # (n,) Edges that they begin on, if none that bulges out begins there
    last: IntArray  # (n,) Edges where which ends they end
    # (m,) Way and edge that it may follow
    corner: IntArray
    edge: IntArray


def _walked(ways: _Ways, edges: Edges) -> tuple[Pieces, BoolArray]:
    """Return the pieces of ways that take each edge which leads farther out, and which ways reach their ends."""
    used, index = unique_inverse(np.concatenate([ways.edge, ways.first, ways.last]))
    lines = edge_lines(edges, used)
    line = index[: len(ways.edge)].astype(np.int64)
    now = _begins(ways, lines, line, index[len(ways.edge) :][: len(ways.first)])
    s = lines.s[lines.start[now]]
    goal = lines.xy[lines.start[index[len(ways.edge) + len(ways.first) :] + 1] - 1]
    active, found = np.arange(len(ways.first)), []
    good = np.zeros(len(ways.first), bool)
    for _ in range(_MOST_PIECES):
        edge = used[now[active]]
        last = lines.s[lines.start[now[active] + 1] - 1]
        onwards = np.where(edge % 2 == 1, -1.0, 1.0)
        rest = lines_along(edges, edge, s[active] + onwards * _BEYOND, last, defaults.EDGE_SPACING)
        rows = np.flatnonzero(np.isin(ways.corner, active))
        row = np.searchsorted(active, ways.corner[rows])
        rows, row = rows[line[rows] != now[active[row]]], row[line[rows] != now[active[row]]]
        a, b, pair = near_segments(rest, lines, row, line[rows])
        u, v, turned = crossings(rest, lines, a, b)
        out = np.flatnonzero((turned < 0.0) & ~np.isnan(u))
        out = out[_leads_out(rest, lines, a[out], b[out])]
        out = out[np.lexsort((a[out] + u[out], row[pair[out]]))]
        turning, best = unique_first(row[pair[out]])
        best = out[best]
        end = last.copy()
        end[turning] = rest.between(a[best], u[best])
        found.append(np.stack([active, edge, s[active], end]))
        stays = np.ones(len(active), bool)
        stays[turning] = False
        here = lines.xy[lines.start[now[active[stays]] + 1] - 1]
        good[active[stays]] = hypot(*(here - goal[active[stays]]).T) <= defaults.SAME_EDGE
        now[active[turning]] = line[rows[pair[best]]]
        s[active[turning]] = lines.between(b[best], v[best])
        active = active[turning]
        if not len(active):
            break
    corner, edge, begin, end = np.concatenate(found, axis=1)
    order = np.argsort(corner, kind="stable")
    pieces = Pieces(
        corner[order].astype(np.int64), edge[order].astype(np.int64), begin[order], end[order], np.zeros(0)
    )
    return pieces, good


def _leads_out(one: Lines, other: Lines, a: IntArray, b: IntArray) -> BoolArray:
    """Say whether the other line leads to the right of one behind segments b and a: they may lie on each other."""
    there, here = (
        lines.xy[np.minimum(k + _BEHIND, lines.start[np.searchsorted(lines.start, k, side="right")] - 1)]
        for lines, k in ((other, b), (one, a))
    )
    along, aside = one.xy[a + 1] - one.xy[a], there - here
    left = along[:, 0] * aside[:, 1] - along[:, 1] * aside[:, 0]
    return np.asarray(left < -_BEYOND * hypot(*along.T))


def _begins(ways: _Ways, lines: Lines, line: IntArray, first: IntArray) -> IntArray:
    """Return the outermost line of those that begin where a way's first line does, (n,): parts right first."""
    start = lines.xy[lines.start[first]][ways.corner]
    near = hypot(*(lines.xy[lines.start[line]] - start).T) <= defaults.SAME_EDGE
    row, line = ways.corner[near], line[near]
    ahead, usual = (_places_ahead(lines, each) for each in (line, first[row]))
    along = np.diff(usual, axis=1)
    aside = ahead[:, 1:] - usual[:, 1:]
    left = along[..., 0] * aside[..., 1] - along[..., 1] * aside[..., 0]
    left /= np.maximum(hypot(along[..., 0], along[..., 1]), 1e-9)
    parts = np.abs(left) > defaults.SAME_EDGE
    at = parts.argmax(axis=1)
    side = np.where(parts.any(axis=1), np.sign(left[np.arange(len(at)), at]) / (1 + at), 0.0)
    order = np.lexsort((side, row))
    return np.asarray(line[order][unique_first(row[order])[1]])


def _places_ahead(lines: Lines, line: IntArray) -> FloatArray:
    """Return the first places of lines, (n, places, 2), m; the last one again where there are no more."""
    k = lines.start[line][:, None] + np.arange(_AHEAD)
    return np.asarray(lines.xy[np.minimum(k, lines.start[line + 1][:, None] - 1)])
