"""Pieces of ways are joined into chains from intersection to intersection.

Two pieces that meet at a node where no other ends belong to one chain, unless no traffic could pass (two one-ways
head on), may not pass (turn restrictions), or would have to turn on the spot. A chain has the direction of its
one-way pieces; where these run against each other it is split.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass

import numpy as np

from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.osmParsing.network.pieces import turns_back

# A piece of a chain, and whether the chain runs along it (else against it).
Link = tuple[int, bool]


@dataclass(frozen=True, slots=True)
class Chain:
    """A sequence of pieces."""

    links: tuple[Link, ...]
    ring: bool  # Whether it is closed without any intersection


def make_chains(
    start: IntArray,
    end: IntArray,
    flow: IntArray,
    points: FloatArray,
    neighbour: FloatArray,
    forbidden: Set[tuple[int, int]] = frozenset(),
) -> list[Chain]:
    """Join pieces into chains, in ascending order of the lowest piece of each.

    `start` and `end` (m,) are the nodes at the ends of each piece, `points` (n, 2) all nodes, m. `flow` (m,) is 1 or
    -1 where traffic runs only along or against the piece, else 0; `neighbour` (2 m, 2) is the position of the node
    next to each end of each piece (2 x piece, plus 1 for its end). Pieces are in ascending OSM id of their ways.
    `forbidden` has pairs of ends at one node: coming from the first, nobody may go on at the second.
    """
    mates: list[int] = _mates(start, end, flow, points, neighbour, forbidden).tolist()
    flows: list[int] = flow.tolist()
    visited = [False] * len(flows)
    chains: list[Chain] = []
    for piece in range(len(flows)):
        if visited[piece]:
            continue
        links, closed = _walk(piece, mates)
        for other, _ in links:
            visited[other] = True
        chains += _directed(links, closed, flows)
    chains.sort(key=lambda chain: min(chain.links)[0])
    return chains


def _mates(
    start: IntArray,
    end: IntArray,
    flow: IntArray,
    points: FloatArray,
    neighbour: FloatArray,
    forbidden: Set[tuple[int, int]],
) -> IntArray:
    """Return for each end of a piece (2 x piece, plus 1 for its end) the end that continues the chain, or -1."""
    mates = np.full(2 * len(start), -1, np.int64)
    node = np.column_stack([start, end]).ravel()
    order = np.argsort(node, kind="stable")
    ordered = node[order]
    first = np.flatnonzero(np.diff(ordered, prepend=-1))
    pairs = first[np.diff(np.append(first, len(ordered))) == 2]
    a, b = order[pairs], order[pairs + 1]
    # Where traffic can reach the other end of a piece (`^ 1`), it can enter the piece at this one.
    onwards, back = _reaches(a, flow) & _reaches(b ^ 1, flow), _reaches(b, flow) & _reaches(a ^ 1, flow)
    through = onwards | back
    if forbidden:
        ends = list(zip(a.tolist(), b.tolist(), strict=True))
        through &= ~(onwards & [pair in forbidden for pair in ends])
        through &= ~(back & [pair[::-1] in forbidden for pair in ends])
    through &= ~turns_back(neighbour[a], points[node[a]], neighbour[b])
    mates[a[through]] = b[through]
    mates[b[through]] = a[through]
    return mates


def _reaches(ends: IntArray, flow: IntArray) -> BoolArray:
    """Return which ends of pieces traffic can reach along the piece."""
    return np.where(ends % 2 == 1, flow[ends // 2] >= 0, flow[ends // 2] <= 0)


def _walk(piece: int, mates: Sequence[int]) -> tuple[list[Link], bool]:
    """Collect the whole chain of a piece, and whether it closes on itself."""
    ahead = [(piece, True)]
    at = mates[2 * piece + 1]
    while at >= 0:
        if at // 2 == piece:
            return ahead, True
        ahead.append((at // 2, at % 2 == 0))
        at = mates[at ^ 1]
    behind: list[Link] = []
    at = mates[2 * piece]
    while at >= 0:
        behind.append((at // 2, at % 2 == 1))
        at = mates[at ^ 1]
    return behind[::-1] + ahead, False


def _directed(links: list[Link], closed: bool, flows: Sequence[int]) -> list[Chain]:
    """Give a chain the direction of its one-way pieces; split it where these run against each other.

    The chain initially runs along its lowest piece, so that the result does not depend on where the walk began.
    """
    signs = [flows[piece] if along else -flows[piece] for piece, along in links]
    if min(signs) >= 0 or max(signs) <= 0:
        return [_chain(links, min(signs), closed)]
    if closed:
        first = next(place for place, sign in enumerate(signs) if sign)
        links, signs = links[first:] + links[:first], signs[first:] + signs[:first]
    chains: list[Chain] = []
    part: list[Link] = []
    running = 0
    # Number of links of the part up to its last one-way piece.
    directed = 0
    for link, sign in zip(links, signs, strict=True):
        if sign * running < 0:
            # Two-way pieces between them stay with the lower piece, whatever the direction of the walk.
            rest = part[directed:] if link[0] < part[directed - 1][0] else []
            chains.append(_chain(part[: len(part) - len(rest)], running, ring=False))
            part, running = rest, 0
        part.append(link)
        if sign:
            running, directed = sign, len(part)
    chains.append(_chain(part, running, ring=False))
    return chains


def _chain(links: list[Link], running: int, ring: bool) -> Chain:
    """Return a chain in the direction of its one-way pieces, which run along (1) or against (-1) the links."""
    return Chain(tuple((piece, not along) for piece, along in reversed(links)) if running < 0 else tuple(links), ring)
