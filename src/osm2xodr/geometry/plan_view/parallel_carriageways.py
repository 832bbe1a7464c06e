"""Lanes of streets that run side by side become narrow enough for both carriageways to fit."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from scipy.spatial import cKDTree

from osm2xodr.curves import find_record, lengths, pose, ranks, starts
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.defaults import (
    ARM_REACH,
    ARM_REACH_MOTORWAY,
    FAST_HIGHWAYS,
    PARALLEL_GAP,
    PARALLEL_SINE,
    PARALLEL_SPACING,
)
from osm2xodr.geometry.lanes import Piece, cross_section
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.geometry.plan_view.streets import FittedStreets
from osm2xodr.model import VEHICLE_LANES, BoolArray, FloatArray, IntArray, LaneSpec, StreetAttributes, StreetNetwork

# Streets whose middles leave less room than this share of their widths are not carriageways side by side; a choice.
_LEAST_ROOM: Final = 0.5
# Room for rounding where places of two streets are abreast, and the least width of two half carriageways, m.
_ABREAST_SLACK: Final = 0.1
_LEAST_WIDTH: Final = 0.1


def narrow_parallel_streets(network: StreetNetwork, fitted: FittedStreets, diagnostics: Diagnostics) -> FittedStreets:
    """Narrow the lanes of pieces of streets whose carriageways would overlap those of a parallel street.

    OSM gives the middle of carriageways, seldom their width. Where two middles are closer than the assumed widths
    allow, the widths are wrong, not the lines.
    """
    shares = iter(_shares(network, fitted).tolist())
    narrowed: dict[tuple[int, float], StreetAttributes] = {}
    pieces: list[tuple[Piece, ...]] = []
    for street in fitted.pieces:
        own: list[Piece] = []
        for s, attributes, section in street:
            share = next(shares)
            if share >= 1.0:
                own.append((s, attributes, section))
                continue
            key = (id(attributes), share)
            if key not in narrowed:
                lanes = tuple(replace(lane, width=_width(lane, share)) for lane in attributes.lanes_ltr)
                narrowed[key] = replace(attributes, lanes_ltr=lanes)
                percent = f"{100 * share:.0f} %"
                text = f"its lanes are drawn at {percent} of their width, a parallel road leaves no more room"
                both = zip(lanes, attributes.lanes_ltr, strict=True)
                if any(lane.width > round(old.width * share, 2) for lane, old in both):
                    text += f"; lanes for cars do not get below {defaults.NARROWEST_LANE:g} m and may overlap it"
                diagnostics.repaired("lanes-narrowed", f"way/{attributes.osm_way_id}", text)
            own.append((s, narrowed[key], cross_section(narrowed[key], network.rule)))
        pieces.append(tuple(own))
    return replace(fitted, pieces=tuple(pieces))


def _width(lane: LaneSpec, share: float) -> float:
    """Return the width of a lane that may keep a share of it, m."""
    width = round(lane.width * share, 2)
    return max(width, min(lane.width, defaults.NARROWEST_LANE)) if lane.type in VEHICLE_LANES else width


def _shares(network: StreetNetwork, fitted: FittedStreets) -> FloatArray:
    """Return the share of its width that each piece of each street may keep, (pieces,)."""
    plan = fitted.plan_view
    first = starts([len(pieces) for pieces in fitted.pieces])
    every = [piece for pieces in fitted.pieces for piece in pieces]
    left = np.array([section.left_edge for _, _, section in every])
    right = np.array([section.right_edge for _, _, section in every])
    layer = np.array([attributes.layer for _, attributes, _ in every])
    out = np.ones(len(every))
    length = lengths(plan)
    # Places `PARALLEL_SPACING` or a little more apart along all streets.
    count = np.maximum((length / PARALLEL_SPACING).astype(np.int64), 1)
    street = np.repeat(np.arange(len(length)), count)
    s = (ranks(count) + 0.5) * (length / count)[street]
    if len(street) < 2:
        return out
    piece = find_record(first, np.array([s for s, _, _ in every]), street, s)
    x, y, hdg = pose(plan, street, s)
    pairs = cKDTree(np.column_stack([x, y])).query_pairs(defaults.PARALLEL_REACH, output_type="ndarray")
    one, other = np.ascontiguousarray(pairs.T)
    parallel = (street[one] != street[other]) & (layer[piece[one]] == layer[piece[other]])
    parallel &= np.abs(np.sin(hdg[one] - hdg[other])) < PARALLEL_SINE
    one, other = one[parallel], other[parallel]
    a, b = np.concatenate([one, other]), np.concatenate([other, one])
    dx, dy = x[b] - x[a], y[b] - y[a]
    ds = dx * np.cos(hdg[a]) + dy * np.sin(hdg[a])
    dt = dy * np.cos(hdg[a]) - dx * np.sin(hdg[a])
    abreast = np.abs(ds) <= 0.5 * PARALLEL_SPACING + _ABREAST_SLACK
    abreast &= ~_near_shared_node(network, street[a], street[b], x[a], y[a])
    a, b, dt = a[abreast], b[abreast], dt[abreast]
    same_way = np.cos(hdg[a] - hdg[b]) > 0
    own = np.where(dt > 0, left[piece[a]], -right[piece[a]])
    other = np.where((dt > 0) == same_way, -right[piece[b]], left[piece[b]])
    both = np.maximum(own + other, _LEAST_WIDTH)
    room = np.abs(dt) - PARALLEL_GAP
    tight = (room < both) & (room > _LEAST_ROOM * both) & (own > 0) & (other > 0)
    share = np.maximum(room[tight] / both[tight], defaults.NARROWEST_SHARE)
    np.minimum.at(out, piece[a[tight]], np.floor(100 * share) / 100)
    return out


def _near_shared_node(
    network: StreetNetwork, one: IntArray, other: IntArray, x: FloatArray, y: FloatArray
) -> BoolArray:
    """Say which places x, y are close to a node at which both streets end: there they are arms of one junction."""
    xy = np.array([(node.x, node.y) for node in network.intersections] or [(0.0, 0.0)])
    ends = np.array([(street.start, street.end) for street in network.streets])
    fast = np.array([any(item.highway in FAST_HIGHWAYS for _, item in street.pieces) for street in network.streets])
    reach = np.where(fast[one] | fast[other], ARM_REACH_MOTORWAY, ARM_REACH)
    near = np.zeros(len(one), bool)
    for p in (0, 1):
        node = ends[one, p]
        shared = (node >= 0) & ((node == ends[other, 0]) | (node == ends[other, 1]))
        near |= shared & (np.hypot(x - xy[node, 0], y - xy[node, 1]) < reach)
    return near
