"""Lanes between the sidewalk of a corner and the carriageway: strips that continue round it, a border as filling."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import record_ends
from osm2xodr.geometry.connections import ConnectingRoads, InnerLane
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.roadside import defaults
from osm2xodr.geometry.roadside.corner_overlaps import onto_lanes, onto_roads, probes
from osm2xodr.model import BoolArray, FloatArray, LaneType, MarginSpec, Rule
from osm2xodr.system import record

# Strips that continue beside the sidewalk where both arms have them.
_CONTINUING: Final = frozenset({LaneType.BIKING, LaneType.BORDER})
# Parts of the carriageway beside its lanes, which end where a corner begins.
_PAVED: Final = frozenset({LaneType.PARKING, LaneType.RESTRICTED, LaneType.SHOULDER})
# Shares of the innermost lane, from its inner edge, at which it must not lie on lanes for cars.
_EDGE_AND_MIDDLE: Final = (0.0, 0.5)


@record
class Sidewalk:
    """A sidewalk, or a cycle track or shoulder without one beside it, at a road end."""

    lane: int  # Its lane id
    t: float  # Of its middle, m
    # m
    width: float
    height: float
    # Lane ids and strips between it and the carriageway, from the sidewalk inwards
    inner: tuple[tuple[int, MarginSpec], ...] = ()
    type: LaneType = LaneType.SIDEWALK


def between(one: Sidewalk, other: Sidewalk) -> tuple[InnerLane, ...]:
    """Return the lanes between a corner's sidewalk and the carriageway, from the sidewalk inwards.

    Strips that both arms have next to the sidewalk continue round the corner. The rest is paved where all of it is
    part of the carriageway on both arms, else a border as high as the sidewalk.
    """
    out: list[InnerLane] = []
    for (lane, strip), (lane_beyond, beyond) in zip(one.inner, other.inner, strict=False):
        alike = strip.type is beyond.type and abs(strip.height - beyond.height) < defaults.SAME_HEIGHT
        if not alike or strip.type not in _CONTINUING:
            break
        out.append(InnerLane(strip.type, strip.width, beyond.width, strip.height, lane, lane_beyond))
    rest = [[strip for _, strip in walk.inner[len(out) :]] for walk in (one, other)]
    begins, ends = (sum(strip.width for strip in strips) for strips in rest)
    if max(begins, ends) >= defaults.NARROWEST_FILLING:
        paved = all(item.type in _PAVED and item.height < defaults.SAME_HEIGHT for strips in rest for item in strips)
        kind, height = (LaneType.SHOULDER, 0.0) if paved else (LaneType.BORDER, one.height)
        out.append(InnerLane(kind, begins, ends, height))
    return tuple(out)


def with_inner_lanes(
    rows: ConnectingRoads, own: BoolArray, cars: ConnectingRoads, parts: RoadParts, rule: Rule
) -> ConnectingRoads:
    """Leave out innermost lanes of corners (`rows`) until none lies on lanes for cars.

    `own` (rows,) says which corners have a curve of their own; the others run beside a turn of cars.
    """
    inner = list(rows.inner)
    unchecked = np.array([bool(lanes) for lanes in inner], bool)
    while unchecked.any():
        here = replace(rows, inner=tuple(inner)).chosen(unchecked)
        unchecked[unchecked] = _lies_badly(here, own[unchecked], cars, parts, rule)
        for k in np.flatnonzero(unchecked).tolist():
            inner[k] = inner[k][:-1]
            unchecked[k] = bool(inner[k])
    return replace(rows, inner=tuple(inner))


def _lies_badly(
    rows: ConnectingRoads, own: BoolArray, cars: ConnectingRoads, parts: RoadParts, rule: Rule
) -> BoolArray:
    """Say for which corners the innermost lane lies on lanes for cars, or folds, (rows,)."""
    # Towards the carriageway: with right-hand traffic it lies left of the sidewalk's direction.
    inwards = 1.0 if rule is Rule.RIGHT_HAND else -1.0
    start, end = inner_width(rows)
    start, end = start + rows.entry_width / 2, end + rows.exit_width / 2
    owner, _, curvature = record_ends(rows.plan_view)
    reach = np.maximum(start, end) + defaults.CORNER_EDGE_RADIUS
    bad = np.zeros(len(own), bool)
    bad[owner[curvature * inwards * reach[owner] > 1.0]] = True
    bad &= own
    far = np.flatnonzero(own | (rows.length > defaults.CORNER_FAR))
    last = [lanes[-1] for lanes in rows.inner]
    width = np.array([lane.entry_width for lane in last]), np.array([lane.exit_width for lane in last])
    for share in _EDGE_AND_MIDDLE:
        # Beside a turn a lane that swings wider may cover its edge, but no more.
        back = [np.maximum(share * whole, np.minimum(defaults.CORNER_ONTO_LANE, whole / 2)) for whole in width]
        t0, t1 = rows.entry_aside + inwards * (start - back[0]), rows.exit_aside + inwards * (end - back[1])
        x, y = probes(rows, t0, t1)
        bad |= onto_lanes(rows, cars, x, y, np.zeros_like(x))
        bad[far] |= onto_roads(rows.junction[far], parts, x[far], y[far])
    return bad


def inner_width(rows: ConnectingRoads) -> tuple[FloatArray, FloatArray]:
    """Return the width of all lanes between sidewalk and carriageway together, at both ends, (rows,), m."""
    start, end = np.zeros(len(rows.inner)), np.zeros(len(rows.inner))
    for k, lanes in enumerate(rows.inner):
        if lanes:
            start[k] = sum(lane.entry_width for lane in lanes)
            end[k] = sum(lane.exit_width for lane in lanes)
    return start, end
