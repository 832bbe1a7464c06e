"""Lanes of streets that run side by side become narrow enough for both carriageways to fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
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
# Where a street in a bend passes another one, places this far apart are compared, m; within half of
# `PARALLEL_SPACING` the bend turns by less than the angle of this sine (50 degrees). Choices.
_BEND_SPACING: Final = 1.0
_BENT_SINE: Final = 0.77


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


@dataclass(frozen=True, slots=True, eq=False)
class _Places:
    """Places along streets."""

    street: IntArray  # (n,)
    # (n,) Chainage, position, m, and heading, rad
    s: FloatArray
    x: FloatArray
    y: FloatArray
    hdg: FloatArray
    piece: IntArray  # (n,) Piece of its street, over all streets

    def chosen(self, rows: IntArray) -> _Places:
        """Return some of them."""
        return _Places(*(getattr(self, item.name)[rows] for item in fields(_Places)))


def _shares(network: StreetNetwork, fitted: FittedStreets) -> FloatArray:
    """Return the share of its width that each piece of each street may keep, (pieces,)."""
    plan = fitted.plan_view
    first = starts([len(pieces) for pieces in fitted.pieces])
    every = [piece for pieces in fitted.pieces for piece in pieces]
    begin = np.array([s for s, _, _ in every])
    left = np.array([section.left_edge for _, _, section in every])
    right = np.array([section.right_edge for _, _, section in every])
    layer = np.array([attributes.layer for _, attributes, _ in every])
    out = np.ones(len(every))
    length = lengths(plan)

    def places(street: IntArray, s: FloatArray) -> _Places:
        x, y, hdg = pose(plan, street, s)
        return _Places(street, s, x, y, hdg, find_record(first, begin, street, s))

    # Places `PARALLEL_SPACING` or a little more apart along all streets.
    count = np.maximum((length / PARALLEL_SPACING).astype(np.int64), 1)
    street = np.repeat(np.arange(len(length)), count)
    if len(street) < 2:
        return out
    spaced = places(street, (ranks(count) + 0.5) * (length / count)[street])
    pairs = cKDTree(np.column_stack([spaced.x, spaced.y])).query_pairs(defaults.PARALLEL_REACH, output_type="ndarray")
    one, other = np.ascontiguousarray(pairs.T)
    apart = (spaced.street[one] != spaced.street[other]) & (layer[spaced.piece[one]] == layer[spaced.piece[other]])
    one, other = one[apart], other[apart]
    sine = np.abs(np.sin(spaced.hdg[one] - spaced.hdg[other]))
    parallel, half = sine < PARALLEL_SINE, np.maximum(left, -right)[spaced.piece]
    distance = np.hypot(spaced.x[one] - spaced.x[other], spaced.y[one] - spaced.y[other])
    bent = np.flatnonzero(
        ~parallel & (sine < _BENT_SINE) & (distance < half[one] + half[other] + 0.5 * PARALLEL_SPACING)
    )
    a, b = one[bent], other[bent]
    bent = bent[~_near_shared_node(network, spaced.street[a], spaced.street[b], spaced.x[a], spaced.y[a])]
    nearest = _nearest_places(places, length, spaced.chosen(one[bent]), spaced.chosen(other[bent]))
    for a, b, slack in (
        (spaced.chosen(one[parallel]), spaced.chosen(other[parallel]), 0.5 * PARALLEL_SPACING),
        (*nearest, _BEND_SPACING),
    ):
        for p, q in ((a, b), (b, a)):
            _narrow(out, network, p, q, slack, left, right)
    return out


def _nearest_places(
    places: Callable[[IntArray, FloatArray], _Places], length: FloatArray, a: _Places, b: _Places
) -> tuple[_Places, _Places]:
    """Return where two streets come nearest to each other around places of theirs, if they run side by side there.

    A street in a bend may touch another one between two places that are not abreast.
    """
    steps = np.arange(-0.5 * PARALLEL_SPACING, 0.5 * PARALLEL_SPACING + _BEND_SPACING, _BEND_SPACING)
    around = []
    for item in (a, b):
        s = np.clip(item.s[:, None] + steps, 0.0, length[item.street][:, None])
        around.append(places(np.repeat(item.street, len(steps)), s.ravel()))
    p, q = around
    shape = (len(a.s), len(steps))
    dx = p.x.reshape(shape)[:, :, None] - q.x.reshape(shape)[:, None, :]
    dy = p.y.reshape(shape)[:, :, None] - q.y.reshape(shape)[:, None, :]
    nearest = np.argmin((dx * dx + dy * dy).reshape(len(a.s), len(steps) ** 2), axis=1)
    row = len(steps) * np.arange(len(a.s))
    p, q = p.chosen(row + nearest // len(steps)), q.chosen(row + nearest % len(steps))
    parallel = np.flatnonzero(np.abs(np.sin(p.hdg - q.hdg)) < PARALLEL_SINE)
    return p.chosen(parallel), q.chosen(parallel)


def _narrow(
    share: FloatArray,
    network: StreetNetwork,
    a: _Places,
    b: _Places,
    slack: float,
    left: FloatArray,
    right: FloatArray,
) -> None:
    """Lower the shares of pieces, (pieces,), that lie at places a beside places b of other streets, both (n,).

    Places are abreast if one is at most `slack` ahead of the other, m.
    """
    dx, dy = b.x - a.x, b.y - a.y
    ds = dx * np.cos(a.hdg) + dy * np.sin(a.hdg)
    dt = dy * np.cos(a.hdg) - dx * np.sin(a.hdg)
    abreast = np.abs(ds) <= slack + _ABREAST_SLACK
    abreast &= ~_near_shared_node(network, a.street, b.street, a.x, a.y)
    a, b, dt = a.chosen(np.flatnonzero(abreast)), b.chosen(np.flatnonzero(abreast)), dt[abreast]
    same_way = np.cos(a.hdg - b.hdg) > 0
    own = np.where(dt > 0, left[a.piece], -right[a.piece])
    other = np.where((dt > 0) == same_way, -right[b.piece], left[b.piece])
    both = np.maximum(own + other, _LEAST_WIDTH)
    room = np.abs(dt) - PARALLEL_GAP
    tight = (room < both) & (room > _LEAST_ROOM * both) & (own > 0) & (other > 0)
    kept = np.maximum(room[tight] / both[tight], defaults.NARROWEST_SHARE)
    np.minimum.at(share, a.piece[tight], np.floor(100 * kept) / 100)


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
