"""Dead ends that lie on or just behind the carriageway of another street, without a node in common."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import PointTree, cosine, find_record, lengths, pose, ranks, repeated, sine, starts, unique_rows
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.defaults import SHORTEST_STREET
from osm2xodr.geometry.junctions.clusters import JunctionLayout
from osm2xodr.geometry.plan_view import FittedStreets, StreetEnds, outward_pose
from osm2xodr.model import BoolArray, FloatArray, IntArray, StreetNetwork

# Places along streets at which it is asked whether a dead end lies on them, and along dead ends, m.
_SPACING: Final = 4.0
_STEP: Final = 0.5
# Dead ends are cut back by this at most, m: across a wide carriageway at a slant, or by the entrance of a car park
# behind a street. What lies on another street for longer runs along it. And they keep this share of their length.
# Choices.
_MOST: Final = 15.0
_LEAST_SHARE: Final = 0.5
# Carriageways count as apart from this distance on, m. A choice.
_GAP: Final = 0.3


def ends_on_streets(fitted: FittedStreets, ends: StreetEnds) -> list[tuple[int, BoolArray]]:
    """Return the dead ends on or just behind a street of their layer that they do not meet; some come several times.

    With each comes whether it lies there if it is cut back, (n,), by 0 m, then by steps of `_STEP`.
    """
    node = ends.node
    dead = np.flatnonzero(node >= 0)
    dead = dead[np.bincount(node[dead])[node[dead]] == 1]
    streets = _Streets(fitted)
    found = []
    for end, street in streets.under(ends, dead):
        if np.isin(node[[2 * street, 2 * street + 1]], node[[end, end ^ 1]]).any():
            continue
        u = _back(ends, end)
        on = np.zeros(len(u), bool)
        x, y, hdg = outward_pose(ends, np.full(len(u), end), u)
        for edge in (float(ends.left[end]), float(ends.right[end])):
            on |= streets.covers(street, x - edge * sine(hdg), y + edge * cosine(hdg), _GAP)
        found.append((end, on))
    return found


def cut_back_ends_on_streets(
    network: StreetNetwork,
    ends: StreetEnds,
    layout: JunctionLayout,
    found: Iterable[tuple[int, BoolArray]],
    diagnostics: Diagnostics,
) -> JunctionLayout:
    """Cut back the dead ends that `ends_on_streets` has found and that are roads' ends, and report them.

    Most were meant to join that street, but nothing says so: roads would lie on each other that know nothing of it.
    """
    free = (layout.junction < 0) & ~np.repeat(layout.inner, 2) & (layout.trim == 0)
    trim, most = layout.trim.copy(), layout.most.copy()
    for end, on in found:
        if not free[end]:
            continue
        spare = float(ends.length[end]) - SHORTEST_STREET
        u = _back(ends, end)
        u = u[: max(1, int(np.count_nonzero(u <= spare - trim[end ^ 1])))]
        on = on[: len(u)]
        if not on[-1]:
            trim[end] = max(trim[end], u[np.flatnonzero(on)[-1] + 1] if on.any() else 0.0)
            most[end] = max(most[end], trim[end])
            most[end ^ 1] = max(trim[end ^ 1], min(most[end ^ 1], spare - trim[end]))
            way = network.streets[end // 2].attributes_at_end(end).osm_way_id
            text = "it ends on or behind another road without a common node, and is cut back to where it is apart"
            diagnostics.repaired("lies-on-another", f"way/{way}", text)
    return replace(layout, trim=trim, most=most)


def _back(ends: StreetEnds, end: int) -> FloatArray:
    """Return how far from a dead end it may be cut back, (n,), m, from 0 on."""
    return np.arange(0.0, max(min(_MOST, _LEAST_SHARE * float(ends.length[end])), _STEP), _STEP)


class _Streets:
    """Carriageways of all streets at places along them."""

    def __init__(self, fitted: FittedStreets) -> None:
        length = lengths(fitted.plan_view)
        count = np.maximum(np.ceil(length / _SPACING).astype(np.int64), 1) + 1
        self._first = starts(count.tolist())
        self.street = repeated(count)
        s = ranks(count) * (length / (count - 1))[self.street]
        x, y, hdg = pose(fitted.plan_view, self.street, s)
        self._xy, self._along = np.column_stack([x, y]), np.column_stack([cosine(hdg), sine(hdg)])
        every = [piece for pieces in fitted.pieces for piece in pieces]
        begin = np.array([first for first, _, _ in every])
        piece = find_record(starts([len(pieces) for pieces in fitted.pieces]), begin, self.street, s)
        self._left = np.array([section.left_edge for _, _, section in every])[piece]
        self._right = np.array([section.right_edge for _, _, section in every])[piece]
        # By layer, and bridges, tunnels and what lies on the ground apart.
        level = [3 * attributes.layer + attributes.structure for _, attributes, _ in every]
        self._level = np.array(level)[piece]

    def under(self, ends: StreetEnds, found: IntArray) -> list[tuple[int, int]]:
        """Return the ends, of those asked about, that lie on a street of their level, and that street.

        Their middle does, there or some way before them, or one of their corners.
        """
        if not len(found):
            return []
        back = [_back(ends, end) for end in found.tolist()]
        end = np.concatenate([np.repeat(found, [len(u) for u in back]), found, found])
        x, y, hdg = outward_pose(ends, end, np.concatenate([*back, np.zeros(2 * len(found))]))
        middles = np.zeros(len(end) - 2 * len(found))
        aside = np.concatenate([middles, ends.left[found], ends.right[found]])
        x, y = x - aside * sine(hdg), y + aside * cosine(hdg)
        reach = float(np.maximum(self._left, -self._right).max()) + _SPACING
        row, place = PointTree(self._xy).within(np.column_stack([x, y]), reach)
        own = np.where(end % 2 == 1, self._first[end // 2 + 1] - 1, self._first[end // 2])
        other = (self.street[place] != end[row] // 2) & (self._level[place] == self._level[own[row]])
        row, place = row[other], place[other]
        on = self._on(place, x[row], y[row], 0.0)
        pairs = unique_rows(np.column_stack([end[row[on]], self.street[place[on]]])).values
        return [(end, street) for end, street in pairs.tolist()]

    def covers(self, street: int, x: FloatArray, y: FloatArray, gap: float) -> BoolArray:
        """Return which points, (n,), m, lie on a street or nearer to it than a gap, m."""
        places = np.arange(self._first[street], self._first[street + 1])
        nearest = places[PointTree(self._xy[places]).nearest(np.column_stack([x, y]))[1]]
        return self._on(nearest, x, y, gap)

    def _on(self, place: IntArray, x: FloatArray, y: FloatArray, gap: float) -> BoolArray:
        """Return whether points, (n,), m, lie beside places, (n,), within the carriageway widened by a gap, m."""
        dx, dy = (np.column_stack([x, y]) - self._xy[place]).T
        cos, sin = self._along[place].T
        ds, dt = dx * cos + dy * sin, dy * cos - dx * sin
        beside = np.abs(ds) <= 0.5 * _SPACING + gap
        out: BoolArray = beside & (dt < self._left[place] + gap) & (dt > self._right[place] - gap)
        return out
