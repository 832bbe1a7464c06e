"""Points looked up by place: those near it, and the nearest ones."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from osm2xodr.curves.ragged import repeated
from osm2xodr.model import FloatArray, IntArray

# Points of a leaf at most; fewer make more nodes to visit, more make more distances to work out.
_LEAF: Final = 8
# More levels than any tree has.
_DEEPEST: Final = 64
_INFINITE: Final = math.inf


class PointTree:
    """A k-d tree of points, (n, d): halves of halves along the widest side, each with its box (Bentley 1975).

    Node k has the halves 2 k and 2 k + 1; the root is 1. What is found depends on points and places alone, the order
    included. Raises ValueError for points that are not finite.
    """

    def __init__(self, points: FloatArray) -> None:
        if not np.isfinite(points).all():
            raise ValueError("points must be finite")
        leaves = 1 << max(math.ceil(len(points) / _LEAF) - 1, 0).bit_length()
        self._row, box = np.arange(len(points)), np.empty((2 * leaves, 2, points.shape[1]))
        halve(np.ascontiguousarray(points, np.float64), self._row, box)
        self._tree = np.ascontiguousarray(points[self._row], np.float64), self._row, box

    def within(self, places: FloatArray, reach: float | FloatArray) -> tuple[IntArray, IntArray]:
        """Return all pairs of places, (m, d), and points at most `reach`, (m,) or one, apart: indices of both.

        Places are ascending, the points of a place in no order of their own.
        """
        start, queue = np.zeros(len(places) + 1, np.int64), np.empty(_DEEPEST, np.int64)
        limit = np.broadcast_to(np.square(reach), len(places)).astype(np.float64)
        asked = np.ascontiguousarray(places, np.float64)
        points_within(*self._tree, asked, limit, start, np.empty(0, np.int64), queue)
        np.cumsum(start, out=start)
        found = np.empty(start[len(places)], np.int64)
        if len(found):
            points_within(*self._tree, asked, limit, start, found, queue)
        return repeated(np.diff(start)), found

    def neighbours(self, places: FloatArray, count: int, reach: float = np.inf) -> tuple[FloatArray, IntArray]:
        """Return distance and index of the `count` nearest points that are less than `reach` away, (m, count).

        The nearest comes first, of equally near ones that of the lower index; infinite and -1 where there are fewer.
        """
        away = np.full((len(places), count), np.square(reach, dtype=np.float64))
        found = np.full((len(places), count), -1)
        queue = np.empty(_DEEPEST, np.int64), np.empty(_DEEPEST)
        nearest_points(*self._tree, np.ascontiguousarray(places, np.float64), away, found, *queue)
        away[found < 0] = np.inf
        return np.sqrt(away), found

    def nearest(self, places: FloatArray, reach: float = np.inf) -> tuple[FloatArray, IntArray]:
        """Return distance and index of the nearest point that is less than `reach` away, (m,); see `neighbours`."""
        away, found = self.neighbours(places, 1, reach)
        return away[:, 0], found[:, 0]


def part_of_node(node: int, points: int) -> tuple[int, int]:
    """Return the range of the points, in the order of the tree, that a node has."""
    begin, end, bit = 0, points, 1
    while bit <= node >> 1:
        bit <<= 1
    bit >>= 1
    while bit > 0:
        if node & bit:
            begin = (begin + end) // 2
        else:
            end = (begin + end) // 2
        bit >>= 1
    return begin, end


def halve(points: FloatArray, row: IntArray, box: FloatArray) -> None:
    """Arrange the rows of points, and write the boxes, (nodes, 2, d), of all nodes."""
    for node in range(1, len(box)):
        begin, end = part_of_node(node, len(row))
        widest, size = 0, -1.0
        for side in range(points.shape[1]):
            low, high = _INFINITE, -_INFINITE
            for at in range(begin, end):
                value = points[row[at], side]
                low = min(low, value)
                high = max(high, value)
            box[node, 0, side] = low
            box[node, 1, side] = high
            if high - low > size:
                widest, size = side, high - low
        if 2 * node < len(box):
            part(points, row, widest, begin, end - 1, (begin + end) // 2)


def part(points: FloatArray, row: IntArray, side: int, first: int, last: int, middle: int) -> None:
    """Bring the rows before `middle` whose points are not farther along a side than those behind (Hoare's find)."""
    while first < last:
        value = points[row[(first + last) // 2], side]
        i, j = first, last
        while i <= j:
            while points[row[i], side] < value:
                i += 1
            while points[row[j], side] > value:
                j -= 1
            if i <= j:
                other = row[i]
                row[i] = row[j]
                row[j] = other
                i += 1
                j -= 1
        if middle <= j:
            last = j
        elif middle >= i:
            first = i
        else:
            break


def from_box(box: FloatArray, node: int, places: FloatArray, k: int) -> float:
    """Return the squared distance of a place from the box of a node."""
    out = 0.0
    for side in range(places.shape[1]):
        off = max(box[node, 0, side] - places[k, side], places[k, side] - box[node, 1, side])
        if off > 0.0:
            out += off * off
    return out


def from_point(points: FloatArray, at: int, places: FloatArray, k: int) -> float:
    """Return the squared distance of a place from a point."""
    out = 0.0
    for side in range(places.shape[1]):
        off = points[at, side] - places[k, side]
        out += off * off
    return out


def points_within(
    points: FloatArray,
    row: IntArray,
    box: FloatArray,
    places: FloatArray,
    limit: FloatArray,
    start: IntArray,
    found: IntArray,
    queue: IntArray,
) -> None:
    """Write the points within `limit`, squared, of each place from its `start` on; without room, count them."""
    for k in range(len(places)):
        count, waiting = 0, 1
        queue[0] = 1
        while waiting > 0:
            waiting -= 1
            node = queue[waiting]
            if from_box(box, node, places, k) > limit[k]:
                continue
            if 2 * node < len(box):
                queue[waiting] = 2 * node + 1
                queue[waiting + 1] = 2 * node
                waiting += 2
                continue
            begin, end = part_of_node(node, len(row))
            for at in range(begin, end):
                if from_point(points, at, places, k) <= limit[k]:
                    if len(found) > 0:
                        found[start[k] + count] = row[at]
                    count += 1
        if len(found) == 0:
            start[k + 1] = count


def nearest_points(
    points: FloatArray,
    row: IntArray,
    box: FloatArray,
    places: FloatArray,
    away: FloatArray,
    found: IntArray,
    queue: IntArray,
    least: FloatArray,
) -> None:
    """Write squared distances and rows of the points nearest to each place, (m, count); both hold what to beat."""
    last = away.shape[1] - 1
    for k in range(len(places)):
        waiting = 1
        queue[0] = 1
        least[0] = 0.0
        while waiting > 0:
            waiting -= 1
            if least[waiting] > away[k, last]:
                continue
            node = queue[waiting]
            if 2 * node < len(box):
                # The nearer half is visited first.
                one, other = from_box(box, 2 * node, places, k), from_box(box, 2 * node + 1, places, k)
                nearer = 1 if other < one else 0
                queue[waiting] = 2 * node + 1 - nearer
                least[waiting] = max(one, other)
                queue[waiting + 1] = 2 * node + nearer
                least[waiting + 1] = min(one, other)
                waiting += 2
                continue
            begin, end = part_of_node(node, len(row))
            for at in range(begin, end):
                distance, index = from_point(points, at, places, k), row[at]
                if distance > away[k, last] or (distance == away[k, last] and index >= found[k, last]):
                    continue
                place = last
                while place > 0 and (
                    distance < away[k, place - 1] or (distance == away[k, place - 1] and index < found[k, place - 1])
                ):
                    away[k, place] = away[k, place - 1]
                    found[k, place] = found[k, place - 1]
                    place -= 1
                away[k, place] = distance
                found[k, place] = index
