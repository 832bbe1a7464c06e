"""Lanes of streets that run side by side become narrow enough for both carriageways to fit."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from scipy.spatial import cKDTree

from osm2xodr.curves import find_record, lengths, pose, ranks
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import defaults
from osm2xodr.geometry.lanes import Piece, cross_section
from osm2xodr.geometry.plan_view.streets import FittedStreets
from osm2xodr.model import BoolArray, FloatArray, IntArray, StreetAttributes, StreetNetwork

# Streets that leave each other less than this share of their widths are no carriageways side by side; a choice.
_LEAST_ROOM: Final = 0.5


def fit_side_by_side(network: StreetNetwork, fitted: FittedStreets, diagnostics: Diagnostics) -> FittedStreets:
    """Narrow the lanes of pieces of streets whose carriageways would overlap those of a parallel street.

    OSM gives the middle of carriageways, seldom their width. Where two middles are closer than the assumed widths
    allow, the widths are wrong, not the lines.
    """
    factor = _factors(network, fitted)
    narrowed: dict[tuple[int, float], StreetAttributes] = {}
    pieces: list[tuple[Piece, ...]] = []
    k = 0
    for street in fitted.pieces:
        own: list[Piece] = []
        for s, attributes, section in street:
            share = float(factor[k])
            k += 1
            if share >= 1.0:
                own.append((s, attributes, section))
                continue
            key = (id(attributes), share)
            if key not in narrowed:
                narrowed[key] = _narrowed(attributes, share)
                diagnostics.repaired(
                    "lanes-narrowed",
                    f"way/{attributes.osm_way_id}",
                    f"its lanes are drawn at {100 * share:.0f} % of their width, a parallel road leaves no more room",
                )
            own.append((s, narrowed[key], cross_section(narrowed[key], network.rule)))
        pieces.append(tuple(own))
    return FittedStreets(fitted.plan_view, tuple(pieces), fitted.aside)


def _narrowed(attributes: StreetAttributes, share: float) -> StreetAttributes:
    lanes = tuple(replace(lane, width=round(lane.width * share, 2)) for lane in attributes.lanes_ltr)
    return replace(attributes, lanes_ltr=lanes)


def _factors(network: StreetNetwork, fitted: FittedStreets) -> FloatArray:
    """Return the share of its width that each piece of each street may keep, (pieces,)."""
    plan = fitted.plan_view
    count = np.array([len(pieces) for pieces in fitted.pieces])
    first = np.concatenate([[0], np.cumsum(count)]).astype(np.int64)
    out = np.ones(first[-1])
    piece_s = np.array([s for pieces in fitted.pieces for s, _, _ in pieces])
    left = np.array([c.left_edge for pieces in fitted.pieces for _, _, c in pieces])
    right = np.array([c.right_edge for pieces in fitted.pieces for _, _, c in pieces])
    layer = np.array([a.layer for pieces in fitted.pieces for _, a, _ in pieces])
    street, s = _samples(lengths(plan))
    if len(street) < 2:
        return out
    piece = find_record(first, piece_s, street, s)
    x, y, hdg = pose(plan, street, s)
    pairs = cKDTree(np.column_stack([x, y])).query_pairs(defaults.PARALLEL_REACH, output_type="ndarray")
    one, other = np.ascontiguousarray(pairs.T)
    apart = street[one] != street[other]
    one, other = one[apart], other[apart]
    alike = layer[piece[one]] == layer[piece[other]]
    alike &= np.abs(np.sin(hdg[one] - hdg[other])) < defaults.PARALLEL_SINE
    one, other = one[alike], other[alike]
    a, b = np.concatenate([one, other]), np.concatenate([other, one])
    dx, dy = x[b] - x[a], y[b] - y[a]
    ds = dx * np.cos(hdg[a]) + dy * np.sin(hdg[a])
    dt = dy * np.cos(hdg[a]) - dx * np.sin(hdg[a])
    abreast = np.abs(ds) <= 0.5 * defaults.PARALLEL_SPACING + 0.1
    abreast &= ~_near_shared_node(network, street[a], street[b], x[a], y[a])
    a, b, dt = a[abreast], b[abreast], dt[abreast]
    same_way = np.cos(hdg[a] - hdg[b]) > 0
    own = np.where(dt > 0, left[piece[a]], -right[piece[a]])
    other = np.where((dt > 0) == same_way, -right[piece[b]], left[piece[b]])
    both = np.maximum(own + other, 0.1)
    room = np.abs(dt) - defaults.PARALLEL_GAP
    tight = (room < both) & (room > _LEAST_ROOM * both) & (own > 0) & (other > 0)
    share = np.maximum(room[tight] / both[tight], defaults.NARROWEST)
    np.minimum.at(out, piece[a[tight]], np.floor(100 * share) / 100)
    return out


def _samples(length: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return street and s of places every few metres along all streets."""
    count = np.maximum((length / defaults.PARALLEL_SPACING).astype(np.int64), 1)
    street = np.repeat(np.arange(len(length)), count)
    number = ranks(count)
    return street, (number + 0.5) * (length / count)[street]


def _near_shared_node(
    network: StreetNetwork, one: IntArray, other: IntArray, x: FloatArray, y: FloatArray
) -> BoolArray:
    """Say which places are close to a node at which both streets end: there they are one junction's arms."""
    xy = np.array([(node.x, node.y) for node in network.intersections] or [(0.0, 0.0)])
    ends = np.array([(street.start, street.end) for street in network.streets])
    fast_ones = defaults.FAST_HIGHWAYS
    fast = np.array([any(item.highway in fast_ones for _, item in street.pieces) for street in network.streets])
    reach = np.where(fast[one] | fast[other], defaults.ARM_REACH_MOTORWAY, defaults.ARM_REACH)
    near = np.zeros(len(one), bool)
    for p in (0, 1):
        node = ends[one, p]
        shared = (node >= 0) & ((node == ends[other, 0]) | (node == ends[other, 1]))
        near |= shared & (np.hypot(x - xy[node, 0], y - xy[node, 1]) < reach)
    return near
