"""Cross sections of connecting roads: where the outer edges of their lanes are."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import Table, advance, cosine_sine, end_curvature, find_record, places_along, smooth_step
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.roadside import inner_width
from osm2xodr.model import BoolArray, FloatArray, IntArray, Rule
from osm2xodr.system import record

# Cross sections are closer where the outer edges of lanes are more than so many times as far apart as they are on the
# reference line, as sidewalks round a bend are: cells between them would be missed. A choice of speed.
_MOST_APART: Final = 1.7


@record(eq=False)
class LaneEdges:
    """The edges of all lanes of connecting roads together at their starts and ends: t, (roads,), m."""

    length: FloatArray
    change_start: FloatArray  # s from which on they change, m
    left_start: FloatArray
    left_end: FloatArray
    right_start: FloatArray
    right_end: FloatArray
    longest: FloatArray  # (roads,) How many times as long as the reference line they are in the sharpest bend, or 1
    bend: FloatArray  # (roads,) The largest rate at which one of them turns along the reference line, 1/m

    def on_arms(self, roads: ConnectingRoads, rows: IntArray) -> tuple[IntArray, BoolArray, FloatArray, FloatArray]:
        """Return the road ends that some roads (k,) touch, first with their starts, then with their ends, all (2 k,).

        With each, whether left of the connecting road is left of that road, too, and t of both edges there, the right
        one first, m.
        """
        end = np.concatenate([roads.entry[rows], roads.exit[rows]])
        same = np.concatenate([roads.entry[rows] % 2 == 1, roads.exit[rows] % 2 == 0])
        t = np.concatenate([roads.entry_t[rows], roads.exit_t[rows]])
        left = np.concatenate([self.left_start[rows], self.left_end[rows]])
        right = np.concatenate([self.right_start[rows], self.right_end[rows]])
        return end, same, np.where(same, t + right, t - left), np.where(same, t + left, t - right)

    @classmethod
    def of(cls, roads: ConnectingRoads, rule: Rule) -> LaneEdges:
        """Return the edges of connecting roads: lanes lie at one side of the centre lane."""
        inner = inner_width(roads)
        # The side of the carriageway where the lanes' traffic drives, seen from the centre lane.
        side = np.where(roads.against, 1.0, -1.0) * (1.0 if rule is Rule.RIGHT_HAND else -1.0)
        out: list[FloatArray] = []
        for width, within, aside in (
            (roads.entry_width, inner[0], roads.entry_aside),
            (roads.exit_width, inner[1], roads.exit_aside),
        ):
            centre = aside - side * (width / 2 + within)
            outermost = aside + side * width / 2
            out += [np.maximum(centre, outermost), np.minimum(centre, outermost)]
        plan = roads.plan_view
        bends, begin = np.stack([plan.curvature, end_curvature(plan)]), plan.start[:-1]
        to_right, to_left = (
            np.minimum.reduceat(bends.min(axis=0), begin),
            np.maximum.reduceat(bends.max(axis=0), begin),
        )
        outside = -to_right * np.maximum(out[0], out[2]), -to_left * np.minimum(out[1], out[3])
        longest = 1.0 + np.maximum(np.maximum(*outside), 0.0)
        length, change_start = np.maximum(roads.length, 1e-6), roads.change_start()
        change = np.maximum(np.abs(out[2] - out[0]), np.abs(out[3] - out[1]))
        # A smooth step bends most at both ends.
        bend = np.maximum(-to_right, to_left) * longest + 6.0 * change / (length - change_start) ** 2
        return cls(length, change_start, out[0], out[2], out[1], out[3], longest, bend)

    def at(self, road: IntArray, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return t of the left and the right edge at s of roads, all (n,), m."""
        start = self.change_start[road]
        blend = smooth_step(np.maximum(s - start, 0.0) / (self.length[road] - start))
        left = self.left_start[road] + blend * (self.left_end - self.left_start)[road]
        right = self.right_start[road] + blend * (self.right_end - self.right_start)[road]
        return left, right


@record(eq=False)
class CrossSections(Table):
    """Cross sections at equal intervals along connecting roads, road after road."""

    road: IntArray  # (n,) Index of the connecting road
    spacing: FloatArray  # (n,) How far they are apart along it, m
    # (n,) Where on it, m, and its reference line there
    s: FloatArray
    x: FloatArray
    y: FloatArray
    # (n,) The direction of t
    nx: FloatArray
    ny: FloatArray
    curvature: FloatArray  # (n,) Of the reference line, 1/m
    # (n,) t of the edges of the lanes, m
    left: FloatArray
    right: FloatArray
    # (n,) The width of strips beyond them, m
    more_left: FloatArray
    more_right: FloatArray
    # (n,) Whether these are part of the carriageway
    paved_left: BoolArray
    paved_right: BoolArray

    def widened(self, more: FloatArray, paved: BoolArray) -> CrossSections:
        """Return them with other strips, left and right: their widths, m, and which are paved, both (2, n)."""
        return replace(self, more_left=more[0], more_right=more[1], paved_left=paved[0], paved_right=paved[1])

    def edge(self, side: IntArray, k: IntArray) -> FloatArray:
        """Return t of the outer edges, strips included, at the left (1) or right (-1) of the k-th ones, m."""
        if not side.ndim:
            return self.left[k] + self.more_left[k] if side > 0 else self.right[k] - self.more_right[k]
        return np.where(side > 0, self.left[k] + self.more_left[k], self.right[k] - self.more_right[k])

    @classmethod
    def of(cls, roads: ConnectingRoads, edges: LaneEdges, spacing: float, rows: IntArray) -> CrossSections:
        """Return cross sections of some roads, at most `spacing` apart, m, the first and the last at their ends.

        Where their edges are farther apart than `_MOST_APART` times that in a bend, these are closer.
        """
        return cls._at(roads, edges, spacing / np.maximum(edges.longest[rows] / _MOST_APART, 1.0), rows)

    @classmethod
    def few(cls, roads: ConnectingRoads, edges: LaneEdges, off: float, rows: IntArray) -> CrossSections:
        """Return cross sections of some roads, between which the edges are at most so far off straight lines, m."""
        return cls._at(roads, edges, np.sqrt(8.0 * off / np.maximum(edges.bend[rows], 1e-9)), rows)

    @classmethod
    def _at(cls, roads: ConnectingRoads, edges: LaneEdges, spacing: FloatArray, rows: IntArray) -> CrossSections:
        """Return cross sections of some roads, (k,), at most `spacing` (k,) apart, m."""
        road, s = places_along(roads.plan_view, spacing, rows)
        plan = roads.plan_view
        record = find_record(plan.start, plan.s, road, s)
        ds, rate = s - plan.s[record], plan.rate[record]
        x, y, hdg = advance(plan.x[record], plan.y[record], plan.hdg[record], plan.curvature[record], ds, rate)
        curvature = plan.curvature[record] + rate * ds
        ny, sin = cosine_sine(hdg)
        count = np.bincount(road, minlength=len(edges.length))
        apart = (edges.length / (count - 1))[road]
        left, right = edges.at(road, s)
        none, no = np.zeros(len(s)), np.zeros(len(s), bool)
        return cls(road, apart, s, x, y, -sin, ny, curvature, left, right, none, none, no, no)
