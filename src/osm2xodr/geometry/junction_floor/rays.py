"""Rays from the edges of lanes across gaps: how far each gap reaches from there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from osm2xodr.curves import Table, cosine_sine, heading_at, join_tables, project
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junction_floor import defaults
from osm2xodr.geometry.junction_floor.cross_sections import CrossSections, LaneEdges
from osm2xodr.geometry.junction_floor.gaps import Grids
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Distance of places on a ray, m, and how many of them a gap may begin behind: cells that an edge runs through are
# covered.
RAY_STEP: Final = 0.5 * defaults.GAP_CELL
_FIRST: Final = 4
# How near strips come to the centre of a bend, where cross sections meet, as a share of its radius and at most, m.
_LEAST_SHARE: Final = 0.15
_LEAST_RADIUS: Final = 0.1
# A place lies abreast of a road, not beyond its ends, if its distance is |t| up to this, m.
_ABREAST: Final = 0.01
# Least sine of the angle between a ray and the edge that it meets, and how often the meeting is improved.
_LEAST_SINE: Final = 0.3
_ROUNDS: Final = 2


@dataclass(frozen=True, slots=True, eq=False)
class Rays(Table):
    """Rays across gaps, in the order of edges and along each of them."""

    # (n,) Index of the cross section that each begins at, and the side: left 1, right -1
    section: IntArray
    side: IntArray
    gap: IntArray  # (n,) Number of the gap
    cells: NDArray[np.int32]  # (n, steps) Cells on the way
    first: IntArray  # (n,) Index of the first place within the gap
    room: IntArray  # (n,) Index of the first place that is too far away

    def ends(self, grids: Grids) -> IntArray:
        """Return the index of the first place behind each gap (of the first one within, where it is closed), (n,)."""
        steps = np.arange(self.cells.shape[1])
        left = (grids.gap[self.cells] != self.gap[:, None]) & (steps >= self.first[:, None])
        left |= steps >= self.room[:, None]
        left[:, -1] = True
        end: IntArray = left.argmax(axis=1)
        return end

    def roads_at(self, end: IntArray, grids: Grids) -> IntArray:
        """Return the connecting road whose lanes each ray comes to at its `end`; -1 for none, (n,)."""
        out: IntArray = grids.road[self.cells[np.arange(len(end)), end]].astype(np.int64)
        return out


def cast_rays(grids: Grids, sections: CrossSections, junction: IntArray) -> Rays:
    """Return the rays that meet a gap next to the edge where they begin; `junction` is that of each section, (n,)."""
    step = RAY_STEP
    holed = np.maximum.reduceat(grids.gap, grids.start[:-1]) > 0
    near = np.flatnonzero(holed[junction])
    steps = np.arange(1, int(defaults.FLOOR_REACH / step) + 1) * step
    found: list[Rays] = []
    for side in (1, -1):
        edge = sections.edge(np.array(side), near)
        begin = grids.gap[grids.cells(near, (edge + side * steps[:_FIRST, None]).astype(np.float32))]
        meets = np.flatnonzero(begin.any(axis=0))
        k, edge, begin = near[meets], edge[meets], begin[:, meets]
        first = (begin > 0).argmax(axis=0)
        gap = begin[first, np.arange(len(first))].astype(np.int64)
        room = room_inside(sections, side, k) / step - 1.0
        cells = grids.cells_far(k, (edge + side * steps[:, None]).astype(np.float32)).T
        last = np.clip(room, 0, len(steps) - 1).astype(np.int64)
        found.append(Rays(k, np.full(len(k), side), gap, cells, first, last))
    rows = join_tables(found)
    return rows.chosen(rows.room > rows.first)


def room_inside(sections: CrossSections, side: int, k: IntArray) -> FloatArray:
    """Return how wide a strip may be on a side of the k-th cross sections, (n,), m: up to near a bend's centre.

    A bend may begin between two cross sections, and widths are linear there.
    """
    edge = sections.edge(np.array(side), k)
    radius = 1.0 / bend_beside(sections, np.array(side), k)
    return np.asarray(np.maximum((1.0 - _LEAST_SHARE) * radius, radius - _LEAST_RADIUS) - side * edge)


def bend_beside(sections: CrossSections, side: IntArray, k: IntArray) -> FloatArray:
    """Return the largest curvature towards a side at the k-th cross sections and those beside them, (n,), 1/m."""
    bend = np.full(len(k), 1e-9)
    for other in (k, np.maximum(k - 1, 0), np.minimum(k + 1, len(sections.road) - 1)):
        same = sections.road[other] == sections.road[k]
        bend = np.where(same, np.maximum(bend, side * sections.curvature[other]), bend)
    return bend


def meet(
    section: IntArray,
    side: IntArray,
    reach: FloatArray,
    other: IntArray,
    sections: CrossSections,
    roads: ConnectingRoads,
    edges: LaneEdges,
) -> tuple[FloatArray, BoolArray]:
    """Return where rays meet the lanes of the `other` roads (-1: none), beyond their edge, near `reach`, (n,), m.

    The second array says which of them do; the others keep their `reach`.
    """
    out, met = reach.copy(), np.zeros(len(reach), bool)
    rows = np.flatnonzero(other >= 0)
    for _ in range(_ROUNDS):
        k, road, sign = section[rows], other[rows], side[rows]
        t = sections.edge(sign, k) + sign * out[rows]
        x, y = sections.x[k] + t * sections.nx[k], sections.y[k] + t * sections.ny[k]
        s, aside, distance = project(roads.plan_view, road, x, y)
        left, right = edges.at(road, s)
        beyond_left = aside > (left + right) / 2
        outside = np.where(beyond_left, aside - left, right - aside)
        cos, sin = cosine_sine(heading_at(roads.plan_view, road, s))
        # How much nearer to that edge a step along the ray gets.
        nearer = sign * (sections.ny[k] * cos - sections.nx[k] * sin)
        nearer = np.where(beyond_left, -nearer, nearer)
        good = (np.abs(distance - np.abs(aside)) < _ABREAST) & (nearer > _LEAST_SINE)
        met[rows] = good
        # The others stay where they are.
        rows = rows[good]
        out[rows] += outside[good] / nearer[good]
    low, high = reach - 3 * defaults.GAP_CELL, reach + 2 * defaults.GAP_CELL
    return np.asarray(np.clip(out, np.maximum(low, 0.0), high)), met & (out <= high)
