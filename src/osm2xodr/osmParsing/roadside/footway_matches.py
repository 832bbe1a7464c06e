"""Points of footways, and which edge of which carriageway they lie along."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.spatial import cKDTree

from osm2xodr.model import BoolArray, FloatArray, Footway, IntArray, Street, Structure
from osm2xodr.osmParsing.defaults import BESIDE_SPACING, FOOTWAY_ANGLE_DEG, FOOTWAY_BESIDE, FOOTWAY_INSIDE
from osm2xodr.osmParsing.roadside.reach import StreetSamples, near_each_other, sample_lines
from osm2xodr.osmParsing.tags import layer_of, structure_of

LEFT, RIGHT = 0, 1
# How far apart headings are put that differ by a right angle (half of it), and levels that differ by one, m. Both are
# more than the distances that are looked at.
_HEADING: Final = 10.0
_LEVEL: Final = 100.0
# Beside the edge, and what is added by headings that differ a little and by points that do not lie abreast.
_REACH: Final = FOOTWAY_BESIDE + 7.0
# Of how many points of edges the nearest edge is chosen.
_CANDIDATES: Final = 4


@dataclass(frozen=True, slots=True, eq=False)
class FootwayMatches:
    """Points of footways, and where along which edge they lie."""

    # (n,) Index of the footway, of the point of the street, and the side of it
    footway: IntArray
    sample: IntArray
    side: IntArray
    # (n,) From the edge of the carriageway, outwards; length of footway that it stands for; m
    distance: FloatArray
    length: FloatArray
    along: BoolArray  # (n,) Whether the footway runs along the street, not against it
    total: float  # Length of all footways, m


def match_footways(streets: Sequence[Street], samples: StreetSamples, footways: Sequence[Footway]) -> FootwayMatches:
    """Match points along footways (at least one) with the nearest edge that runs the same way at the same level."""
    counts = np.array([len(footway.points) for footway in footways], np.int64)
    lines = sample_lines(np.concatenate([footway.points for footway in footways]), counts, BESIDE_SPACING)
    owner = np.repeat(np.arange(len(footways)), counts)[lines.node]
    # First roughly by the streets' lines, then by their edges.
    half = np.maximum(np.abs(samples.left), np.abs(samples.right)).max()
    around = np.flatnonzero(near_each_other(lines.points, samples.lines.points, _REACH + float(half))[1])
    along, piece = samples.lines.along[around], samples.piece[around]
    left_of = np.column_stack([-along[:, 1], along[:, 0]])
    # The left edges of all points, then the right ones.
    edges = np.concatenate(
        [
            samples.lines.points[around] + samples.left[piece][:, None] * left_of,
            samples.lines.points[around] + samples.right[piece][:, None] * left_of,
        ]
    )
    near_foot, near_edge = near_each_other(lines.points, edges, _REACH)
    foot, edge = np.flatnonzero(near_foot), np.flatnonzero(near_edge)
    if not len(edge):
        nothing = np.zeros(0, np.int64)
        return FootwayMatches(nothing, nothing, nothing, np.zeros(0), np.zeros(0), np.zeros(0, np.bool_), 0.0)
    own, side = edge % len(around), np.where(edge < len(around), LEFT, RIGHT)
    street = around[own]
    levels = np.array([_level(a.structure, a.layer) for item in streets for _, a in item.pieces])
    own_levels = np.array([_level_of(footway.tags) for footway in footways])
    edges, twice = edges[edge], along[own]
    outwards = np.where((side == LEFT)[:, None], left_of[own], -left_of[own])
    tree = cKDTree(_places(edges, twice, levels[samples.piece[street]]), balanced_tree=False, compact_nodes=False)
    query = _places(lines.points[foot], lines.along[foot], own_levels[owner[foot]])
    number = np.asarray(tree.query(query, k=_CANDIDATES, distance_upper_bound=_REACH)[1], np.int64)
    number[number == len(edges)] = -1
    # Of the nearest points of edges the one on the nearest edge: points do not lie abreast of each other.
    away = lines.points[foot][:, None] - edges[number]
    beside = (away * outwards[number]).sum(axis=2)
    ahead = (away * twice[number]).sum(axis=2)
    same_way = (lines.along[foot][:, None] * twice[number]).sum(axis=2)
    fits = (number >= 0) & (np.abs(same_way) >= math.cos(math.radians(FOOTWAY_ANGLE_DEG)))
    fits &= (beside >= -FOOTWAY_INSIDE) & (beside <= FOOTWAY_BESIDE) & (np.abs(ahead) <= BESIDE_SPACING)
    best = np.argmin(np.where(fits, np.abs(beside), np.inf), axis=1)
    row = np.flatnonzero(fits.any(axis=1))
    best = best[row]
    foot, nearest, beside, same_way = foot[row], number[row, best], beside[row, best], same_way[row, best]
    return FootwayMatches(
        owner[foot],
        street[nearest],
        side[nearest],
        beside,
        lines.length[foot],
        same_way > 0.0,
        float(lines.length.sum()),
    )


def _places(points: FloatArray, along: FloatArray, level: FloatArray) -> FloatArray:
    """Return points that are far from each other where headings (either way along) or levels differ, (n, 5)."""
    double = np.column_stack([along[:, 0] ** 2 - along[:, 1] ** 2, 2.0 * along[:, 0] * along[:, 1]])
    return np.column_stack([points, _HEADING * double, _LEVEL * level])


def _level(structure: Structure, layer: int) -> float:
    return float(3 * layer + structure.value)


def _level_of(tags: Mapping[str, str]) -> float:
    structure = structure_of(tags)
    return _level(structure, layer_of(tags, structure, []))


def covered(samples: StreetSamples, sample: IntArray) -> FloatArray:
    """Return 1 for the points of streets that have a footway beside them, or beside a neighbour on their piece."""
    hit = np.zeros(len(samples.piece), np.bool_)
    hit[sample] = True
    same = samples.piece[1:] == samples.piece[:-1]
    out = hit.copy()
    out[1:] |= hit[:-1] & same
    out[:-1] |= hit[1:] & same
    return out.astype(np.float64)
