"""Cut pieces of streets where footways beside them begin or end, so that sidewalks can begin and end there too."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import (
    hypot,
    sorted_unique,
    starts,
)
from osm2xodr.model import BoolArray, FloatArray, IntArray, Street
from osm2xodr.osmParsing.roadside.footway_matches import LEFT, RIGHT, FootwayMatches, covered
from osm2xodr.osmParsing.roadside.reach import StreetSamples, with_pieces

# A street is cut where a footway beside it is present for at least this length and absent for at least as long, m,
# at the nearest node if one is this near, m. Choices.
_SHORTEST_RUN: Final = 30.0
_NODE_NEAR: Final = 15.0


def cut_where_footways_end(
    streets: tuple[Street, ...], samples: StreetSamples, matches: FootwayMatches, use: IntArray
) -> tuple[tuple[Street, ...], StreetSamples]:
    """Cut pieces at the nodes next to where footways begin or end; `use` (n,) numbers the use of each match."""
    cuts: dict[int, set[int]] = defaultdict(set)
    points = np.concatenate([street.points for street in streets])
    for kind in sorted_unique(use).tolist():
        for side in (LEFT, RIGHT):
            hit = sorted_unique(matches.sample[(use == kind) & (matches.side == side)])
            for piece, node in _ends(samples, points, covered(samples, hit) > 0.0):
                cuts[piece].add(node)
    if not cuts:
        return streets, samples
    counts = np.array([len(street.points) for street in streets], np.int64)
    first = starts(counts)[:-1].tolist()
    ids = np.concatenate([street.node_ids for street in streets])
    out = list(streets)
    for piece, found in sorted(cuts.items()):
        number = int(samples.street[piece])
        street = streets[number]
        begin, attributes = street.pieces[int(samples.index[piece])]
        end = next((at for at, _ in street.pieces if at > begin), len(street.points) - 1)
        taken = [begin, end]
        # By id, an order that does not depend on the way's direction.
        for at in sorted((node - first[number] for node in found), key=lambda at: int(ids[first[number] + at])):
            if begin < at < end and hypot(*(street.points[taken] - street.points[at]).T).min() > _NODE_NEAR:
                taken.append(at)
        more = [(at, attributes) for at in taken[2:]]
        pieces = tuple(sorted((*out[number].pieces, *more), key=lambda item: item[0]))
        out[number] = replace(out[number], pieces=pieces)
    new = tuple(out)
    return new, with_pieces(samples.lines, new)


def join_like_pieces(street: Street) -> Street:
    """Join consecutive pieces of a street with equal attributes."""
    kept = [street.pieces[0]]
    for at, attributes in street.pieces[1:]:
        if attributes != kept[-1][1]:
            kept.append((at, attributes))
    return replace(street, pieces=tuple(kept)) if len(kept) < len(street.pieces) else street


def _ends(samples: StreetSamples, points: FloatArray, beside: BoolArray) -> list[tuple[int, int]]:
    """Return (piece, node counted over all streets) next to where long runs with and without a footway meet."""
    # Only pieces that have any.
    row = np.flatnonzero(np.isin(samples.piece, samples.piece[beside]))
    if not len(row):
        return []
    length, piece, beside = samples.lines.length[row], samples.piece[row], beside[row]
    begins = (np.diff(piece, prepend=-1) != 0) | np.diff(beside, prepend=beside[:1])
    run = np.cumsum(begins) - 1
    start = np.flatnonzero(begins)
    lengths = np.bincount(run, length)
    of_piece = piece[start]
    # Only pieces that have both, for long enough.
    both = np.zeros(len(samples.street), np.int64)
    np.bitwise_or.at(both, of_piece, np.where(lengths >= _SHORTEST_RUN, np.where(beside[start], 1, 2), 0))
    out: list[tuple[int, int]] = []
    long_runs = np.flatnonzero((both[of_piece] == 3) & (lengths >= _SHORTEST_RUN))
    for a, b in zip(long_runs[:-1].tolist(), long_runs[1:].tolist(), strict=True):
        if of_piece[a] != of_piece[b] or beside[start[a]] == beside[start[b]]:
            continue
        # In the middle of any short runs between the two.
        at = int(start[a + 1] + start[b]) // 2
        before, after = int(row[at - 1]), int(row[at])
        place = 0.5 * (samples.lines.points[before] + samples.lines.points[after])
        nodes = np.arange(samples.lines.node[before], samples.lines.node[after] + 2)
        distance = hypot(*(points[nodes] - place).T)
        if distance.min() <= _NODE_NEAR:
            out.append((int(of_piece[a]), int(nodes[np.argmin(distance)])))
    return out
