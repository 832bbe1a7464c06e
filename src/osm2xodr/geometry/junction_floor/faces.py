"""Where carriageways end at junctions and no lane goes on: their end faces bound the floor."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import cosine, hypot, ranks, rays_to_segments, repeated, sine, starts
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junction_floor import defaults
from osm2xodr.geometry.junction_floor.cross_sections import LaneEdges
from osm2xodr.geometry.junctions import RoadParts, end_poses
from osm2xodr.model import BoolArray, FloatArray, IntArray, Rule
from osm2xodr.system import record

# Distance of places on end faces, as a share of a cell's size: none is missed.
_PLACES_PER_CELL: Final = 0.5
# End faces are drawn so far behind the end of the road, and so far beyond both edges of its carriageway, m.
_BEHIND: Final = 0.15
_BEYOND: Final = 0.4
# So many metres along the road pavement in the open takes to become a metre narrower. A choice: cars that stop at a
# line go past its end on no path.
_TAPER: Final = 3.0
# What a ray meets lies this near to the cells that say so, m: three of them.
_NEAR: Final = 1.2


@record(eq=False)
class Faces:
    """Places on end faces and on the outer edges of the pavement before them, (n,)."""

    junction: IntArray
    # Where, m
    x: FloatArray
    y: FloatArray
    lines: FloatArray  # (m, 4) From x, y to x, y, of all junctions, m
    # (k,) The ends of roads that they are at, of all junctions, and t of both edges of the carriageway there, m
    end: IntArray
    left: FloatArray
    right: FloatArray

    def within(self, junctions: IntArray) -> Faces:
        """Return those in some junctions (m,), ascending, numbered by their place among these."""
        rows = np.flatnonzero(np.isin(self.junction, junctions))
        number = np.searchsorted(junctions, self.junction[rows])
        return replace(self, junction=number, x=self.x[rows], y=self.y[rows])

    @classmethod
    def none(cls) -> Faces:
        """Return no places."""
        none, nowhere = np.zeros(0, np.int64), np.zeros(0)
        return cls(none, nowhere, nowhere, np.zeros((0, 4)), none, nowhere, nowhere)

    @classmethod
    def of(cls, parts: RoadParts, roads: ConnectingRoads, rule: Rule) -> Faces:
        """Return the end faces of carriageways with a stretch that no connecting road for cars goes on from.

        Before a stretch at a side without sidewalk the pavement becomes narrower along the connecting road. What ends
        between a carriageway and a sidewalk that goes on has an end face, too.
        """
        cars = roads.for_vehicles()
        junction = dict(zip(_both(roads.entry, roads.exit), _both(roads.junction, roads.junction), strict=True))
        walks = set(zip(_both(roads.entry, roads.exit, ~cars), _signs(roads, ~cars), strict=True))
        found: list[tuple[int, float, float, float, float]] = []
        open_: list[tuple[int, float, float]] = []
        for at, covered in _covered(roads, cars):
            section = parts.at_end(at).section
            left, right = section.left_edge, section.right_edge
            if left - right - sum(high - low for low, high in covered) < defaults.FACE_LEAST_OPEN:
                continue
            open_.append((at, left, right))
            found.append((at, -_BEHIND, -_BEHIND, left + _BEYOND, right - _BEYOND))
            for side, room in ((1, left - max(high for _, high in covered)), (-1, min(covered)[0] - right)):
                if room >= defaults.FACE_LEAST_OPEN and (at, side) not in walks:
                    edge = left if side > 0 else right
                    found.append((at, -_BEHIND, _TAPER * room, edge, edge - side * room))
        found += _beside(parts, roads, LaneEdges.of(roads, rule), np.flatnonzero(~cars))
        if not found:
            return cls.none()
        ends, *columns = zip(*found, strict=True)
        end = np.array(ends, np.int64)
        u0, u1, t0, t1 = (np.array(column) for column in columns)
        count = np.ceil(hypot(u1 - u0, t1 - t0) / (_PLACES_PER_CELL * defaults.GAP_CELL)).astype(np.int64) + 1
        row = repeated(count)
        share = ranks(count) / (count - 1)[row]
        at_end = end % 2 == 1
        x, y, hdg = end_poses(parts, end)
        u = (u0[row] + share * (u1 - u0)[row]) * np.where(at_end, 1.0, -1.0)[row]
        t = t0[row] + share * (t1 - t0)[row]
        cos, sin = cosine(hdg)[row], sine(hdg)[row]
        numbers = np.array([junction[item] for item in ends], np.int64)
        px, py = x[row] + u * cos - t * sin, y[row] + u * sin + t * cos
        begin = starts(count)
        first, last = begin[:-1], begin[1:] - 1
        lines = np.column_stack([px[first], py[first], px[last], py[last]])
        ended, highest, lowest = np.array(open_, np.float64).reshape(-1, 3).T
        return cls(numbers[row], px, py, lines, ended.astype(np.int64), highest, lowest)

    def meet(self, x: FloatArray, y: FloatArray, dx: FloatArray, dy: FloatArray, reach: FloatArray) -> FloatArray:
        """Return how far from x, y in a direction they lie, near `reach`, which stays where none is near, (n,), m."""
        begin, end = self.lines[:, :2], self.lines[:, 2:]
        far = rays_to_segments(np.column_stack([x, y]), np.column_stack([dx, dy]), begin, end)
        off = np.abs(far - reach[:, None])
        best = off.argmin(axis=1)[:, None]
        found = np.take_along_axis(off, best, axis=1)[:, 0] < _NEAR
        return np.asarray(np.where(found, np.take_along_axis(far, best, axis=1)[:, 0], reach))


def _beside(
    parts: RoadParts, roads: ConnectingRoads, edges: LaneEdges, walks: IntArray
) -> list[tuple[int, float, float, float, float]]:
    """Return the end faces between carriageways and the lanes of some connecting roads, by their rows, beside them.

    Each is a road end and u and t, m, where it begins and ends.
    """
    nearest: dict[tuple[int, int], float] = {}
    end, _, low, high = edges.on_arms(roads, walks)
    for at, first, last in zip(end.tolist(), low.tolist(), high.tolist(), strict=True):
        section = parts.at_end(at).section
        if first > section.left_edge:
            nearest[at, 1] = min(nearest.get((at, 1), np.inf), first - section.left_edge)
        elif last < section.right_edge:
            nearest[at, -1] = min(nearest.get((at, -1), np.inf), section.right_edge - last)
    out = []
    for (at, side), gap in nearest.items():
        if gap >= defaults.GAP_CELL:
            section = parts.at_end(at).section
            edge = section.left_edge if side > 0 else section.right_edge
            out.append((at, -_BEHIND, -_BEHIND, edge - side * _BEYOND, edge + side * (gap + _BEYOND)))
    return out


def _both(one: IntArray, other: IntArray, rows: BoolArray | None = None) -> list[int]:
    """Return the values of both columns, of some rows."""
    some = np.ones(len(one), bool) if rows is None else rows
    out: list[int] = np.concatenate([one[some], other[some]]).tolist()
    return out


def _signs(roads: ConnectingRoads, rows: BoolArray) -> list[int]:
    """Return on which side of both roads the lanes of connecting roads lie: left 1, right -1."""
    return [1 if lane > 0 else -1 for lane in _both(roads.entry_lane, roads.exit_lane, rows)]


def _covered(roads: ConnectingRoads, cars: BoolArray) -> Iterator[tuple[int, list[tuple[float, float]]]]:
    """Yield road ends with the stretches (t, m) of the lanes that connecting roads for cars go on from."""
    end, lane = (
        np.array(_both(*item, cars), np.int64)
        for item in ((roads.entry, roads.exit), (roads.entry_lane, roads.exit_lane))
    )
    if not len(end):
        return
    t = np.concatenate([roads.entry_t[cars], roads.exit_t[cars]])
    half = np.concatenate([roads.entry_width[cars], roads.exit_width[cars]]) / 2
    order = np.lexsort((lane, end))
    order = order[np.append(True, (np.diff(end[order]) != 0) | (np.diff(lane[order]) != 0))[: len(order)]]
    low, high = (t - half)[order].tolist(), (t + half)[order].tolist()
    begins = np.flatnonzero(np.diff(end[order], prepend=-1)).tolist()
    for a, b in zip(begins, [*begins[1:], len(order)], strict=True):
        yield int(end[order[a]]), list(zip(low[a:b], high[a:b], strict=True))
