"""Pieces of ways become chains from intersection to intersection.

Two pieces that alone meet at a node belong to one chain, unless no traffic could run through it (two one-ways head
on) or it would have to turn on the spot. A chain runs along its one-way pieces; where they run against each other it
is broken.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.osmParsing.network.pieces import turns_back

# A chain: pieces in order, each with whether it is run through along its own direction.
Link = tuple[int, bool]


@dataclass(frozen=True, slots=True)
class Chain:
    """A row of pieces."""

    links: tuple[Link, ...]  # Pieces in order, each with whether the chain runs along it (else against it)
    ring: bool  # Whether it is closed without any intersection


def make_chains(
    start: IntArray, end: IntArray, flow: IntArray, points: FloatArray, neighbour: FloatArray
) -> list[Chain]:
    """Join pieces to chains.

    Parameters
    ----------
    start, end : (m,)
        Node that each piece starts and ends at. Pieces are in ascending OSM id of their ways.
    flow : (m,)
        1 or -1 where traffic runs only along or against the piece, else 0.
    points : (n, 2)
        Where the nodes are: local x, y, m.
    neighbour : (2 m, 2)
        Where the node next to each end of each piece is (2 x piece, plus 1 for its end).

    Returns
    -------
    list of Chain
        In ascending order of the lowest piece of each.
    """
    mates: list[int] = _mates(start, end, flow, points, neighbour).tolist()
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


def _mates(start: IntArray, end: IntArray, flow: IntArray, points: FloatArray, neighbour: FloatArray) -> IntArray:
    """Return for each end of a piece (2 x piece, plus 1 for its end) the one that the chain goes on with, or -1."""
    mates = np.full(2 * len(start), -1, np.int64)
    node = np.column_stack([start, end]).ravel()
    order = np.argsort(node, kind="stable")
    ordered = node[order]
    first = np.flatnonzero(np.diff(ordered, prepend=-1))
    pairs = first[np.diff(np.append(first, len(ordered))) == 2]
    a, b = order[pairs], order[pairs + 1]
    through = (_enters(a, flow) & _leaves(b, flow)) | (_enters(b, flow) & _leaves(a, flow))
    through &= ~turns_back(neighbour[a], points[node[a]], neighbour[b])
    mates[a[through]] = b[through]
    mates[b[through]] = a[through]
    return mates


def _enters(ends: IntArray, flow: IntArray) -> BoolArray:
    """Whether traffic on the piece can come to this end of it."""
    return np.where(ends % 2 == 1, flow[ends // 2] >= 0, flow[ends // 2] <= 0)


def _leaves(ends: IntArray, flow: IntArray) -> BoolArray:
    """Whether traffic can go into the piece at this end of it."""
    return np.where(ends % 2 == 0, flow[ends // 2] >= 0, flow[ends // 2] <= 0)


def _walk(piece: int, mates: Sequence[int]) -> tuple[list[Link], bool]:
    """Collect the whole chain that a piece is part of, and whether it closes on itself."""
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
    """Turn a chain along its one-way pieces; break it where they run against each other.

    The walk has the lowest piece run along itself, which makes the outcome independent of where it began.
    """
    signs = [flows[piece] if along else -flows[piece] for piece, along in links]
    if min(signs) == max(signs) == 0 or min(signs) >= 0:
        return [Chain(tuple(links), closed)]
    if max(signs) <= 0:
        return [Chain(_reversed(links), closed)]
    if closed:
        first = next(place for place, sign in enumerate(signs) if sign)
        links, signs = links[first:] + links[:first], signs[first:] + signs[:first]
    chains: list[Chain] = []
    part: list[Link] = []
    running = 0
    # How many links of the part there are up to its last one-way piece.
    ruled = 0
    for link, sign in zip(links, signs, strict=True):
        if sign * running < 0:
            # What is two-way between them goes with the lower piece, whichever way the walk went.
            rest = part[ruled:] if link[0] < part[ruled - 1][0] else []
            chains.append(_part(part[: len(part) - len(rest)], running))
            part, running = rest, 0
        part.append(link)
        if sign:
            running, ruled = sign, len(part)
    chains.append(_part(part, running))
    return chains


def _part(links: list[Link], running: int) -> Chain:
    return Chain(_reversed(links) if running < 0 else tuple(links), False)


def _reversed(links: list[Link]) -> tuple[Link, ...]:
    return tuple((piece, not along) for piece, along in reversed(links))
