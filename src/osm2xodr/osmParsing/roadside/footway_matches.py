"""Points along footways, matched with the edges of carriageways; pieces of streets cut where footways begin or end.

So sidewalks can begin and end there too.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import PointTree, cosine, hypot, repeated, sorted_unique, starts
from osm2xodr.model import BoolArray, FloatArray, Footway, IntArray, Street, Structure
from osm2xodr.osmParsing.defaults import BESIDE_SPACING, FOOTWAY_BESIDE
from osm2xodr.osmParsing.roadside.reach import StreetSamples, near_each_other, sample_lines, with_pieces
from osm2xodr.osmParsing.tags import layer_of, structure_of
from osm2xodr.system import record

# A street is cut where a footway beside it is present for at least this length and absent for at least as long, m,
# at the nearest node if one is this near, m. Choices.
_SHORTEST_RUN: Final = 30.0
_NODE_NEAR: Final = 15.0

LEFT, RIGHT = 0, 1
# A footway matches an edge whose heading differs by at most this, degrees, and which it overlaps by at most this, m
# (carriageways are drawn with assumed widths). Choices.
_ANGLE_MAX_DEG: Final = 20.0
_OVERLAP_MAX: Final = 1.5
# In the search tree, perpendicular headings lie twice the first apart, levels that differ by one the second, m: both
# farther than any match.
_HEADING_SCALE: Final = 10.0
_LEVEL_SCALE: Final = 100.0
# Radius of the search, m: the lateral distance, plus room for slightly different headings and for points that do not
# lie abreast.
_SEARCH_RADIUS: Final = FOOTWAY_BESIDE + 7.0
# Number of nearest points among which the nearest edge is chosen.
_CANDIDATES: Final = 4
# Distances from edges that are equal to so many decimals of a metre are the same.
_SAME_DECIMALS: Final = 3


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


@record(eq=False)
class FootwayMatches:
    """Points of footways, and where along which edge they lie."""

    footway: IntArray  # (n,) Index of the footway
    sample: IntArray  # (n,) Index of the point along the street
    side: IntArray  # (n,) Side of the street: `LEFT` or `RIGHT`
    distance: FloatArray  # (n,) From the edge of the carriageway outwards, m
    length: FloatArray  # (n,) Length of footway that the point represents, m
    along: BoolArray  # (n,) Whether the footway runs along the street, not against it
    total: float  # Length of all footways, m


def match_footways(streets: Sequence[Street], samples: StreetSamples, footways: Sequence[Footway]) -> FootwayMatches:
    """Match points along footways (at least one) with the nearest parallel edge at the same level."""
    counts = np.array([len(footway.points) for footway in footways], np.int64)
    lines = sample_lines(np.concatenate([footway.points for footway in footways]), counts, BESIDE_SPACING)
    owner = repeated(counts)[lines.node]
    # Preselected roughly by the streets' lines, then by their edges.
    half = np.maximum(np.abs(samples.left), np.abs(samples.right)).max()
    around = np.flatnonzero(near_each_other(lines.points, samples.lines.points, _SEARCH_RADIUS + float(half))[1])
    along, piece = samples.lines.along[around], samples.piece[around]
    left_of = np.column_stack([-along[:, 1], along[:, 0]])
    # The left edges of all points, then the right ones.
    offsets = (samples.left[piece], samples.right[piece])
    edges = np.concatenate([samples.lines.points[around] + offset[:, None] * left_of for offset in offsets])
    near_foot, near_edge = near_each_other(lines.points, edges, _SEARCH_RADIUS)
    foot, edge = np.flatnonzero(near_foot), np.flatnonzero(near_edge)
    if not len(edge):
        empty = np.zeros(0, np.int64)
        return FootwayMatches(empty, empty, empty, np.zeros(0), np.zeros(0), np.zeros(0, np.bool_), 0.0)
    own, side = edge % len(around), np.where(edge < len(around), LEFT, RIGHT)
    street = around[own]
    levels = np.array([_level(a.structure, a.layer) for item in streets for _, a in item.pieces])
    own_levels = np.array([_level_of(footway.tags) for footway in footways])
    edges, edge_along = edges[edge], along[own]
    outwards = np.where((side == LEFT)[:, None], left_of[own], -left_of[own])
    searched = _search_points(edges, edge_along, levels[samples.piece[street]])
    tree = PointTree(searched)
    query = _search_points(lines.points[foot], lines.along[foot], own_levels[owner[foot]])
    _, number = tree.neighbours(query, _CANDIDATES, _SEARCH_RADIUS)
    # The nearest point is not always on the nearest edge, as points do not lie abreast of each other.
    away = lines.points[foot][:, None] - edges[number]
    beside = (away * outwards[number]).sum(axis=2)
    ahead = (away * edge_along[number]).sum(axis=2)
    same_way = (lines.along[foot][:, None] * edge_along[number]).sum(axis=2)
    fits = (number >= 0) & (np.abs(same_way) >= cosine(math.radians(_ANGLE_MAX_DEG)))
    fits &= (beside >= -_OVERLAP_MAX) & (beside <= FOOTWAY_BESIDE) & (np.abs(ahead) <= BESIDE_SPACING)
    # Points of one straight edge are equally near: rounding must not choose among them, but who is abreast.
    best = np.argmin(np.where(fits, np.round(np.abs(beside), _SAME_DECIMALS), np.inf), axis=1)
    row = np.flatnonzero(fits.any(axis=1))
    best = best[row]
    foot, nearest, beside, same_way = foot[row], number[row, best], beside[row, best], same_way[row, best]
    length, total = lines.length[foot], float(lines.length.sum())
    return FootwayMatches(owner[foot], street[nearest], side[nearest], beside, length, same_way > 0.0, total)


def _search_points(points: FloatArray, along: FloatArray, level: FloatArray) -> FloatArray:
    """Return points (n, 5) that are far apart where headings (modulo a half turn) or levels differ."""
    double = np.column_stack([along[:, 0] ** 2 - along[:, 1] ** 2, 2.0 * along[:, 0] * along[:, 1]])
    return np.column_stack([points, _HEADING_SCALE * double, _LEVEL_SCALE * level])


def _level(structure: Structure, layer: int) -> float:
    return float(3 * layer + structure.value)


def _level_of(tags: Mapping[str, str]) -> float:
    structure = structure_of(tags)
    return _level(structure, layer_of(tags, structure, []))


def covered(samples: StreetSamples, sample: IntArray) -> FloatArray:
    """Return 1 for points of streets with a match at them or at a neighbour on the same piece, else 0, (n,)."""
    hit = np.zeros(len(samples.piece), np.bool_)
    hit[sample] = True
    same = samples.piece[1:] == samples.piece[:-1]
    out = hit.copy()
    out[1:] |= hit[:-1] & same
    out[:-1] |= hit[1:] & same
    return out.astype(np.float64)
