"""How the lines of two ways lie to each other in OSM: whether they share a node, cross without one, or lie apart."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import Table, join_tables, segments_cross
from osm2xodr.model import FloatArray, IntArray, StreetNetwork

# Only what ways do within this distance of a place counts there, m: the widest junctions. A choice.
_AROUND: Final = 100.0
# Lines nearer than this touch, m: OSM's coordinates have steps of 1 cm.
_TOUCH: Final = 0.02


@dataclass(frozen=True, slots=True)
class LinesInOsm:
    """How the lines of two ways lie to each other around a place."""

    crossing: tuple[int, int] | None  # Two of them that cross or touch where they share no node
    node: int | None  # OSM id of the node that they share nearest to the place
    away: float  # How far that is from the place, m
    apart: float  # Distance of the lines, m


@dataclass(frozen=True, slots=True, eq=False)
class _Segments(Table):
    """Straight pieces of ways."""

    way: IntArray  # (n,) OSM ids
    node: IntArray  # (n, 2) OSM ids of the nodes at both ends
    xy: FloatArray  # (n, 2, 2) Where these are, m


class WayLines:
    """The lines of some of a network's ways, by their OSM ids."""

    def __init__(self, network: StreetNetwork, ways: Set[int]) -> None:
        found: dict[int, tuple[list[IntArray], list[FloatArray]]] = {way: ([], []) for way in ways}
        for street in network.streets:
            begins = [*(first for first, _ in street.pieces), len(street.node_ids) - 1]
            for (first, last), (_, attributes) in zip(pairwise(begins), street.pieces, strict=True):
                if attributes.osm_way_id in found:
                    nodes, points = found[attributes.osm_way_id]
                    nodes.append(
                        np.column_stack([street.node_ids[first:last], street.node_ids[first + 1 : last + 1]])
                    )
                    points.append(np.stack([street.points[first:last], street.points[first + 1 : last + 1]], axis=1))
        self._segments = {
            way: _Segments(np.full(sum(map(len, nodes)), way), np.concatenate(nodes), np.concatenate(points))
            for way, (nodes, points) in found.items()
        }

    def between(self, one: Set[int], other: Set[int], place: FloatArray) -> LinesInOsm:
        """Return how the ways of one set lie to those of another around a place, (2,), m."""
        a, b = self._around(one, place), self._around(other, place)
        shared = (a.node[:, None, :, None] == b.node[None, :, None, :]).any(axis=(2, 3))
        (p, q), (r, s) = (np.moveaxis(item.xy, 1, 0) for item in (a, b))
        apart = np.minimum(_distances(a, b), _distances(b, a).T)
        apart[segments_cross(p[:, None], q[:, None], r[None], s[None])] = 0.0
        crossing = np.argwhere((apart < _TOUCH) & ~shared)
        nodes = np.intersect1d(a.node, b.node)
        away = np.hypot(*(a.xy - place).T).T
        away[~np.isin(a.node, nodes)] = np.inf
        nearest = np.unravel_index(int(away.argmin()), away.shape)
        return LinesInOsm(
            (int(a.way[crossing[0, 0]]), int(b.way[crossing[0, 1]])) if len(crossing) else None,
            int(a.node[nearest]) if len(nodes) else None,
            float(away[nearest]),
            float(apart.min()),
        )

    def _around(self, ways: Set[int], place: FloatArray) -> _Segments:
        """Return what ways have near a place; where that is nothing, all of them."""
        every = join_tables(self._segments[way] for way in sorted(ways))
        near = _to_segments(place[None], every.xy)[0] < _AROUND
        return every.chosen(near) if near.any() else every


def _distances(one: _Segments, other: _Segments) -> FloatArray:
    """Return the distances of segments' nearer ends from other segments, (n, m), m."""
    ends = _to_segments(one.xy.reshape(-1, 2), other.xy)
    return np.asarray(ends.reshape(-1, 2, len(other.xy)).min(axis=1), np.float64)


def _to_segments(points: FloatArray, segments: FloatArray) -> FloatArray:
    """Return the distances of points, (n, 2), from segments, (m, 2, 2), as (n, m), m."""
    begin, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    off = points[:, None] - begin
    share = np.clip((off * along).sum(axis=2) / np.maximum((along**2).sum(axis=1), 1e-12), 0.0, 1.0)
    out: FloatArray = np.hypot(*np.moveaxis(off - share[..., None] * along, 2, 0))
    return out
