"""Which area each piece of road belongs to, and so where roads are cut.

Two neighbouring areas lay out a road between them alike, since each sees everything that shapes it; so both cut it at
the same place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import area_at, area_bounds, lengths, owners, places_along, pose, snap_cuts, starts
from osm2xodr.geometry.tile_edges import defaults
from osm2xodr.model import Borders, FloatArray, IntArray, Partition, PlanView

# Roads are sampled for their areas this densely, m; between two samples a border is found to this accuracy, m, by
# dividing the interval into this many parts again and again.
_SAMPLES_EVERY: Final = 5.0
_ACCURACY: Final = 1e-6
_PARTS: Final = 200
# Stand for the area of a road end without a junction, where the road's own course decides.
_NO_JUNCTION: Final = -2


def find_borders(
    partition: Partition, plan_view: PlanView, end_junction: IntArray, junction_xy: FloatArray
) -> Borders:
    """Divide roads among areas.

    A junction belongs to the area that its origin lies in, and with it the first metres of its arms
    (`defaults.BORDER_STUB`). A piece of road shorter than `defaults.BORDER_PIECE` belongs to its neighbour's area.
    `end_junction` (R, 2) is the junction at each road's start and end, -1 for none; `junction_xy` (J, 2) is each
    junction's origin, local x, y, m, and their areas come in the same order.
    """
    length = lengths(plan_view)
    road, s = places_along(plan_view, _SAMPLES_EVERY)
    count = np.bincount(road, minlength=len(length))
    x, y, _ = pose(plan_view, road, s)
    box = area_bounds(partition)
    area = area_at(partition, x, y, box)
    junction_area = area_at(partition, junction_xy[:, 0], junction_xy[:, 1], box)
    at_end = np.where(end_junction >= 0, np.append(junction_area, -1)[end_junction], _NO_JUNCTION)
    first = starts(count)[:-1]
    known = np.where(at_end == _NO_JUNCTION, area[first, None], at_end)
    lowest = np.minimum(np.minimum.reduceat(area, first), known.min(axis=1))
    highest = np.maximum(np.maximum.reduceat(area, first), known.max(axis=1))
    found = [np.array([0.0])] * len(length)
    areas = [area[k : k + 1] for k in first.tolist()]
    for k in np.flatnonzero(lowest != highest).tolist():
        part = slice(int(first[k]), int(first[k] + count[k]))
        line = _Line(partition, box, plan_view, k, float(length[k]), at_end[k].tolist())
        found[k], areas[k] = line.pieces(s[part])
    start = starts([len(item) for item in found])
    of_road = owners(start)
    begin = snap_cuts(plan_view, of_road, np.concatenate(found))
    return Borders(partition, start, begin, np.concatenate(areas), junction_area)


@dataclass(frozen=True, slots=True, eq=False)
class _Line:
    """A road that belongs to several areas."""

    partition: Partition
    box: FloatArray  # Bounds of its areas
    plan_view: PlanView
    road: int
    length: float  # m
    ends: Sequence[int]  # Areas of the junctions at its start and its end

    def stubs(self) -> tuple[float, float]:
        """Return up to where, and from where on, s, m, the road belongs to the junctions at its ends."""
        stub = min(defaults.BORDER_STUB, self.length / 2)
        start, end = (0.0 if area == _NO_JUNCTION else stub for area in self.ends)
        return start, self.length - end

    def pieces(self, s: FloatArray) -> tuple[FloatArray, IntArray]:
        """Return where pieces begin, m, and their areas, from samples s (n,) along the road that miss no piece."""
        s = np.union1d(s, self.stubs())
        at = self._areas(s).tolist()
        runs: list[tuple[int, float]] = [(at[0], 0.0)]
        for (before, low), (after, high) in pairwise(zip(at, s.tolist(), strict=True)):
            if before != after:
                runs.append((after, self._between(before, low, high)))
        runs = self._without_short(runs)
        return np.array([begin for _, begin in runs]), np.array([number for number, _ in runs], np.int64)

    def _areas(self, s: FloatArray) -> IntArray:
        """Return the areas of places, (n,), near junctions those of the junctions."""
        x, y, _ = pose(self.plan_view, np.full(len(s), self.road), s)
        out = area_at(self.partition, x, y, self.box)
        start, end = self.stubs()
        out[s < start], out[s > end] = self.ends
        return out

    def _between(self, area: int, low: float, high: float) -> float:
        """Return where an area ends between two places, s, m."""
        while high - low > _ACCURACY:
            places = np.linspace(low, high, _PARTS)
            beyond = int(np.argmax(self._areas(places)[1:] != area)) + 1
            low, high = float(places[beyond - 1]), float(places[beyond])
        return high

    def _without_short(self, runs: list[tuple[int, float]]) -> list[tuple[int, float]]:
        """Give short pieces, the shortest first, to the longer of their neighbours."""
        runs = _joined(runs)
        while len(runs) > 1:
            ends = [begin for _, begin in runs[1:]] + [self.length]
            size = [end - begin for (_, begin), end in zip(runs, ends, strict=True)]
            at_junction = {k for k, area in zip((0, len(runs) - 1), self.ends, strict=True) if area != _NO_JUNCTION}
            short = [k for k in range(len(runs)) if k not in at_junction and size[k] < defaults.BORDER_PIECE]
            if not short:
                break
            k = min(short, key=lambda item: (size[item], item))
            near = [item for item in (k - 1, k + 1) if 0 <= item < len(runs)]
            taker = max(near, key=lambda item: (size[item], -item))
            runs[k] = (runs[taker][0], runs[k][1])
            runs = _joined(runs)
        return runs


def _joined(runs: list[tuple[int, float]]) -> list[tuple[int, float]]:
    """Join neighbouring runs of one area."""
    return [run for k, run in enumerate(runs) if not k or run[0] != runs[k - 1][0]]
