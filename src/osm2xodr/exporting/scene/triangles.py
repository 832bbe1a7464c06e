"""Triangles that share their corners: welding, splitting where their edges meet, and steps between them.

Corners are told apart in plan first: places closer than `ONE_PLACE` are one. Each place may have several heights.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt
import shapely
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from osm2xodr.exporting.scene.overlaps import GRID
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.shapes import LEVEL_APART


def area_of(outline: FloatArray, holes: Sequence[FloatArray]) -> tuple[Any, bool]:
    """Return the area within an outline without its holes, (n, 2), m, each, and whether the outline was repaired."""
    shape = shapely.Polygon(outline)
    repaired = not shape.is_valid
    if repaired:
        shape = shapely.make_valid(shape)
    for hole in holes:
        shape = shapely.difference(shape, shapely.make_valid(shapely.Polygon(hole)))
    return shape, repaired


def polygons_of(shape: Any) -> list[Any]:
    """Return the polygons of a shape, without its lines and points."""
    parts = shapely.get_parts(shapely.get_parts(shape))
    return [part for part in parts if part.geom_type == "Polygon" and not part.is_empty]


# ---------------------------------------------------------------- triangles

# Places closer together are one, m: more than rounding to `GRID` moves two corners apart, and no multiple of it.
ONE_PLACE: Final = 2.5 * GRID
# Heights at one place that differ by less are one, m: half of the lowest kerb (`KERB_HEIGHT`).
ONE_HEIGHT: Final = 0.015
GeometryArray: TypeAlias = npt.NDArray[np.object_]
_Value = TypeVar("_Value", np.int64, np.float64)
# Rounds in which edges are split; each splits an edge at one corner.
_ROUNDS: Final = 8
# Corners of others on an edge this near to one of its ends, m, become one with it: split there, either would leave
# the other one beside a sliver, time and again. A choice: four times what slivers are high.
_NEAR_END: Final = 4.0 * ONE_PLACE
# Rounds in which half edges are matched.
_MATCHES: Final = 6


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


def _joined(one: IntArray, other: IntArray, count: int) -> IntArray:
    """Return the number of the group that each of `count` items is in where pairs of them are joined, (count,)."""
    graph = coo_matrix((np.ones(len(one)), (one, other)), shape=(count, count))
    label: IntArray = connected_components(graph, directed=False)[1].astype(np.int64)
    return label


def merged_places(xy: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the place of each point, and the places: points closer than `ONE_PLACE`, at the first of them."""
    unique, inverse = np.unique(xy, axis=0, return_inverse=True)
    first = np.full(len(unique), len(xy))
    np.minimum.at(first, inverse, np.arange(len(xy)))
    pairs = cKDTree(unique).query_pairs(ONE_PLACE, output_type="ndarray")
    label = _joined(pairs[:, 0], pairs[:, 1], len(unique))
    lead = np.full(label.max(initial=-1) + 1, len(xy))
    np.minimum.at(lead, label, first)
    return label[inverse], xy[lead]


def without_slivers(soup: Soup) -> Soup:
    """Return the triangles that are higher than `ONE_PLACE` in plan, and so counter-clockwise."""
    a, b, c = np.moveaxis(soup.xy[soup.place], 1, 0)
    twice = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    longest = np.sqrt(np.max([((p - q) ** 2).sum(1) for p, q in ((a, b), (b, c), (c, a))], axis=0))
    return soup.rows(np.flatnonzero(twice > ONE_PLACE * longest))


def split_where_they_meet(soup: Soup) -> Soup:
    """Return the triangles, split where edges without a neighbour meet the corner of another one, or cross an edge.

    Triangles as thin as a sliver go first: those beside them have the corner that lay between. Areas that lie on each
    other by a sliver have a corner in common where their outlines cross.
    """
    for _ in range(_ROUNDS):
        soup = without_slivers(soup)
        outline = _outline_of(soup)
        corners, (crossings, xy) = _corners_on(outline, soup), _crossings_of(outline, len(soup.xy))
        if not len(corners[0]) + len(crossings[0]):
            break
        soup, corners = _with_near_ends_merged(soup, outline, *corners)
        edge, place, at = (np.concatenate([one, other]) for one, other in zip(corners, crossings, strict=True))
        # One split of each triangle at a time, at what is nearest to the middle of its edge.
        row = outline.row[edge]
        order = np.lexsort((place, np.abs(at - 0.5), row))
        order = order[np.diff(row[order], prepend=-1) != 0]
        edge, place, at = edge[order], place[order], at[order]
        soup = replace(soup, xy=np.concatenate([soup.xy, xy]))
        soup = _split(
            soup, outline.row[edge], outline.side[edge], place, at, outline.z[edge] + at * outline.rise[edge]
        )
    return without_slivers(soup)


@dataclass(frozen=True, eq=False)
class _Outline:
    """Edges of triangles that no other triangle has."""

    row: IntArray
    side: IntArray
    start: IntArray  # Places
    end: IntArray
    xy: FloatArray  # (n, 2) Of the start, m
    along: FloatArray  # (n, 2) From the start to the end, m
    length: FloatArray  # In plan, m
    z: FloatArray  # At the start, m
    rise: FloatArray  # From the start to the end, m
    lines: GeometryArray


def _outline_of(soup: Soup) -> _Outline:
    row, side = np.nonzero(~_has_neighbour(soup))
    start, end = soup.place[row, side], soup.place[row, (side + 1) % 3]
    a, b, z = soup.xy[start], soup.xy[end], soup.z[row, side]
    rise = soup.z[row, (side + 1) % 3] - z
    lines = shapely.linestrings(np.stack([a, b], axis=1))
    return _Outline(row, side, start, end, a, b - a, np.hypot(*(b - a).T), z, rise, lines)


def _corners_on(outline: _Outline, soup: Soup) -> tuple[IntArray, IntArray, FloatArray]:
    """Return pairs of edges and the corners of others that lie on them, at their level, and at which share."""
    places = np.unique(np.concatenate([outline.start, outline.end]))
    low, high = _heights(soup, places)
    tree = shapely.STRtree(shapely.points(soup.xy[places]))
    edge, near = tree.query(outline.lines, predicate="dwithin", distance=ONE_PLACE)
    place = places[near]
    kept = (place != outline.start[edge]) & (place != outline.end[edge])
    edge, near, place = edge[kept], near[kept], place[kept]
    along, length = outline.along[edge], outline.length[edge]
    off = soup.xy[place] - outline.xy[edge]
    at, lateral = (off * along).sum(1) / length**2, np.abs(_cross(off, along)) / length
    z = outline.z[edge] + at * outline.rise[edge]
    kept = (
        (lateral < ONE_PLACE) & (at > 0) & (at < 1) & (z > low[near] - LEVEL_APART) & (z < high[near] + LEVEL_APART)
    )
    return edge[kept], place[kept], at[kept]


def _with_near_ends_merged(
    soup: Soup, outline: _Outline, edge: IntArray, place: IntArray, at: FloatArray
) -> tuple[Soup, tuple[IntArray, IntArray, FloatArray]]:
    """Return the triangles with corners on edges at a share merged with the ends that they are near, and the others.

    Ends of edges stay where corners lie farther from them: these would lie beside their edge.
    """
    near = np.minimum(at, 1.0 - at) * outline.length[edge] < _NEAR_END
    far = edge[~near]
    fixed = np.concatenate([outline.start[far], outline.end[far]])
    end = np.where(at < 0.5, outline.start[edge], outline.end[edge])
    near &= ~np.isin(end, fixed) & ~np.isin(place, fixed)
    becomes = _merged(place[near], end[near], len(soup.xy))
    return replace(soup, place=becomes[soup.place]), (edge[~near], becomes[place[~near]], at[~near])


def _merged(one: IntArray, other: IntArray, count: int) -> IntArray:
    """Return the place that each of `count` places becomes where pairs of them become one, (count,): the first."""
    label = _joined(one, other, count)
    out: IntArray = np.unique(label, return_index=True)[1][label]
    return out


def _crossings_of(outline: _Outline, places: int) -> tuple[tuple[IntArray, IntArray, FloatArray], FloatArray]:
    """Return edges that cross others at their level, the number of the place from `places` on, the share, and x, y.

    Each crossing is given for one of its edges; it is a corner on the other one then.
    """
    one, other = shapely.STRtree(outline.lines).query(outline.lines, predicate="intersects")
    later = one < other
    one, other = one[later], other[later]
    d, e, off = outline.along[one], outline.along[other], outline.xy[other] - outline.xy[one]
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v = _cross(off, e) / _cross(d, e), _cross(off, d) / _cross(d, e)
    room = np.minimum(np.minimum(u, 1.0 - u) * outline.length[one], np.minimum(v, 1.0 - v) * outline.length[other])
    apart = outline.z[one] + u * outline.rise[one] - outline.z[other] - v * outline.rise[other]
    # Closer to an end, that is a corner on the other edge.
    kept = np.flatnonzero((room > ONE_PLACE) & (np.abs(apart) < LEVEL_APART))
    one, u = one[kept], u[kept]
    return (one, places + np.arange(len(one)), u), outline.xy[one] + u[:, None] * outline.along[one]


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the cross products of vectors in plan, (n, 2)."""
    out: FloatArray = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return out


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
    for k in range(_MATCHES):
        one, other = todo[:-1], todo[1:]
        match = (key[one] == key[other]) & (ahead[one] != ahead[other]) & (z[other] - z[one] < LEVEL_APART)
        if k == 0:
            # Those between the same vertices before others, as of a sliver above the edge of another road.
            same = match & (start[one] == end[other]) & (end[one] == start[other])
            match = same if same.any() else match
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
