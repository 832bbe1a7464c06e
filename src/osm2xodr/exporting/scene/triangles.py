"""Triangles that share their corners: welding, splitting at corners that lie on edges, and steps between them.

Corners are told apart in plan first: places closer than `ONE_PLACE` are one. Each place may have several heights.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, TypeVar

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from osm2xodr.exporting.scene.overlaps import GRID, LEVEL_APART
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Places closer together are one, m: more than rounding to `GRID` moves two corners apart, and no multiple of it.
ONE_PLACE: Final = 2.5 * GRID
# Heights at one place that differ by less are one, m: half of the lowest kerb (`KERB_HEIGHT`).
ONE_HEIGHT: Final = 0.015
_Value = TypeVar("_Value", np.int64, np.float64)
# Rounds in which edges are split; each splits an edge at one corner.
_ROUNDS: Final = 6


@dataclass(frozen=True, eq=False)
class Soup:
    """Triangles of which each has corners of its own, at places that they share."""

    place: IntArray  # (n, 3) Index in `xy`
    xy: FloatArray  # (places, 2) m
    z: FloatArray  # (n, 3) m
    uv: FloatArray  # (n, 3, 2) m
    tag: IntArray  # (n,) Whatever belongs to a triangle: goes with its pieces

    def rows(self, kept: IntArray) -> Soup:
        """Return some of the triangles."""
        return replace(self, place=self.place[kept], z=self.z[kept], uv=self.uv[kept], tag=self.tag[kept])


def merged_places(xy: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the place of each point, and the places: points closer than `ONE_PLACE`, at the first of them."""
    unique, inverse = np.unique(xy, axis=0, return_inverse=True)
    first = np.full(len(unique), len(xy))
    np.minimum.at(first, inverse, np.arange(len(xy)))
    pairs = cKDTree(unique).query_pairs(ONE_PLACE, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(unique), len(unique)))
    count, label = connected_components(graph, directed=False)
    lead = np.full(count, len(xy))
    np.minimum.at(lead, label, first)
    return label.astype(np.int64)[inverse], xy[lead]


def without_slivers(soup: Soup) -> Soup:
    """Return the triangles that are higher than `ONE_PLACE` in plan, and so counter-clockwise."""
    a, b, c = np.moveaxis(soup.xy[soup.place], 1, 0)
    twice = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    longest = np.sqrt(np.max([((p - q) ** 2).sum(1) for p, q in ((a, b), (b, c), (c, a))], axis=0))
    return soup.rows(np.flatnonzero(twice > ONE_PLACE * longest))


def split_at_corners(soup: Soup) -> Soup:
    """Return the triangles, split where the corner of another one lies on an edge without a neighbour.

    Triangles as thin as a sliver go first: those beside them have the corner that lay between.
    """
    for _ in range(_ROUNDS):
        soup = without_slivers(soup)
        row, side = np.nonzero(~_has_neighbour(soup))
        start, end = soup.place[row, side], soup.place[row, (side + 1) % 3]
        places = np.unique(np.concatenate([start, end]))
        heights = _heights(soup, places)
        a, b = soup.xy[start], soup.xy[end]
        tree = cKDTree(soup.xy[places])
        length = np.hypot(*(b - a).T)
        found = tree.query_ball_point(0.5 * (a + b), 0.5 * length + ONE_PLACE)
        count = np.array([len(item) for item in found], np.int64)
        edge = np.repeat(np.arange(len(row)), count)
        near = np.concatenate([np.asarray(item, np.int64) for item in found]) if len(row) else np.zeros(0, np.int64)
        place = places[near]
        kept = (place != start[edge]) & (place != end[edge])
        edge, near, place = edge[kept], near[kept], place[kept]
        along = (b[edge] - a[edge]) / length[edge][:, None]
        off = soup.xy[place] - a[edge]
        at = (off * along).sum(1) / length[edge]
        aside = np.abs(off[:, 0] * along[:, 1] - off[:, 1] * along[:, 0])
        za, zb = soup.z[row, side][edge], soup.z[row, (side + 1) % 3][edge]
        z = za + at * (zb - za)
        low, high = heights
        kept = (
            (aside < ONE_PLACE) & (at > 0) & (at < 1) & (z > low[near] - LEVEL_APART) & (z < high[near] + LEVEL_APART)
        )
        edge, place, at, z = edge[kept], place[kept], at[kept], z[kept]
        # One split of each triangle at a time, at the corner that is nearest to the middle of its edge.
        order = np.lexsort((place, np.abs(at - 0.5), row[edge]))
        edge, place, at, z = edge[order], place[order], at[order], z[order]
        one = np.diff(row[edge], prepend=-1) != 0
        if not one.any():
            break
        soup = _split(soup, row[edge[one]], side[edge[one]], place[one], at[one], z[one])
    return without_slivers(soup)


def _heights(soup: Soup, places: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and the highest z of some places, m."""
    low, high = np.full(len(soup.xy), np.inf), np.full(len(soup.xy), -np.inf)
    np.minimum.at(low, soup.place.ravel(), soup.z.ravel())
    np.maximum.at(high, soup.place.ravel(), soup.z.ravel())
    return low[places], high[places]


def _has_neighbour(soup: Soup) -> BoolArray:
    """Return whether another triangle has the same edge the other way round, (n, 3)."""
    start, end = soup.place, np.roll(soup.place, -1, axis=1)
    n = len(soup.xy)
    return np.isin(start * n + end, end * n + start)


def _split(soup: Soup, row: IntArray, side: IntArray, place: IntArray, at: FloatArray, z: FloatArray) -> Soup:
    """Return the triangles, some of them cut in two from a place on one side to the opposite corner."""
    a, b, c = side, (side + 1) % 3, (side + 2) % 3
    uv = soup.uv[row, a] + at[:, None] * (soup.uv[row, b] - soup.uv[row, a])

    def pieces(old: npt.NDArray[_Value], new: npt.NDArray[_Value]) -> npt.NDArray[_Value]:
        first = np.stack([old[row, a], new, old[row, c]], axis=1)
        second = np.stack([new, old[row, b], old[row, c]], axis=1)
        whole = old.copy()
        whole[row] = first
        return np.concatenate([whole, second])

    tag = np.concatenate([soup.tag, soup.tag[row]])
    return Soup(pieces(soup.place, place), soup.xy, pieces(soup.z, z), pieces(soup.uv, uv), tag)


def welded(soup: Soup) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the vertex of each corner, (n, 3), and x, y, z and uv of vertices; close heights are one."""
    place, z = soup.place.ravel(), soup.z.ravel()
    order = np.lexsort((z, place))
    new = np.ones(len(order), np.bool_)
    new[1:] = (np.diff(place[order]) != 0) | (np.diff(z[order]) > ONE_HEIGHT)
    vertex = np.empty(len(order), np.int64)
    vertex[order] = np.cumsum(new) - 1
    count = np.bincount(vertex)
    first = order[new]
    height = np.bincount(vertex, weights=z) / count
    xyz = np.column_stack([soup.xy[place[first]], height])
    return vertex.reshape(-1, 3), xyz, soup.uv.reshape(-1, 2)[first]


@dataclass(frozen=True, eq=False)
class Edges:
    """Edges of triangles (rows and sides), and what is on their other side."""

    # (pairs, 2) Half edges, 3 * row + side, that run the same way back and forth in plan, at one level
    pairs: IntArray
    alone: IntArray  # (edges,) Half edges without such a one


def edges_of(faces: IntArray, place: IntArray, xyz: FloatArray) -> Edges:
    """Match the edges of triangles in plan; `place` (vertices,) is that of each vertex."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    p, q = place[start], place[end]
    ahead = p < q
    key = np.where(ahead, p, q) * (int(place.max(initial=0)) + 1) + np.where(ahead, q, p)
    z = 0.5 * (xyz[start, 2] + xyz[end, 2])
    # Per edge in plan by height; two that follow each other, run against each other and are close in height match.
    order = np.lexsort((ahead, z, key))
    pairs: list[IntArray] = []
    todo = order
    for _ in range(_ROUNDS):
        one, other = todo[:-1], todo[1:]
        match = (key[one] == key[other]) & (ahead[one] != ahead[other]) & (z[other] - z[one] < LEVEL_APART)
        # Of matches in a row every other one counts.
        first = np.flatnonzero(match)
        run = np.concatenate([[0], np.cumsum(np.diff(first) != 1)]) if len(first) else first
        begin = np.flatnonzero(np.diff(run, prepend=-1)) if len(first) else first
        rank = np.arange(len(first)) - (begin[run] if len(first) else 0)
        first = first[rank % 2 == 0]
        if not len(first):
            break
        pairs.append(np.column_stack([todo[first], todo[first + 1]]))
        left = np.ones(len(todo), np.bool_)
        left[first] = left[first + 1] = False
        todo = todo[left]
    return Edges(np.concatenate(pairs) if pairs else np.zeros((0, 2), np.int64), np.sort(todo))


def steps_between(faces: IntArray, pairs: IntArray) -> tuple[IntArray, IntArray]:
    """Return vertical triangles between edges that run together in plan but not in height, and their pair."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    a0, a1 = start[pairs[:, 0]], end[pairs[:, 0]]
    b1, b0 = start[pairs[:, 1]], end[pairs[:, 1]]
    both = np.stack([np.column_stack([a1, a0, b0]), np.column_stack([a1, b0, b1])], axis=1)
    pair = np.repeat(np.arange(len(pairs)), 2)
    rows = both.reshape(-1, 3)
    kept = (rows[:, 0] != rows[:, 1]) & (rows[:, 1] != rows[:, 2]) & (rows[:, 2] != rows[:, 0])
    return rows[kept], pair[kept]
