"""What lies between the sidewalk of a corner and the carriageway: strips that go on round it, and what fills it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from osm2xodr.geometry.connections import ConnectingRoads, InnerLane
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.margins import defaults
from osm2xodr.geometry.margins.corner_overlaps import onto_lanes, onto_roads, probes
from osm2xodr.model import BoolArray, FloatArray, LaneType, MarginSpec, Rule

# Gaps between a corner's sidewalk and the carriageway that are narrower stay, m. A choice.
_CORNER_FILLED: Final = 0.05

# Strips that go on beside the sidewalk where both arms have them.
_GO_ON = frozenset({LaneType.BIKING, LaneType.BORDER})
# Heights that differ by less are one, m.
_LEVEL = 0.005


@dataclass(frozen=True, slots=True)
class Sidewalk:
    """A sidewalk at a road end."""

    lane: int  # Its id
    t: float  # Of its middle, m
    # m
    width: float
    height: float
    # Lane ids and strips between it and the carriageway, from the sidewalk inwards
    inner: tuple[tuple[int, MarginSpec], ...] = ()


def between(one: Sidewalk, other: Sidewalk) -> tuple[InnerLane, ...]:
    """Return the lanes between a corner's sidewalk and the carriageway, from the sidewalk inwards.

    What both arms have next to the sidewalk goes on round the corner; the rest is a border as high as the sidewalk.
    """
    out: list[InnerLane] = []
    for (lane, strip), (lane_beyond, beyond) in zip(one.inner, other.inner, strict=False):
        alike = strip.type is beyond.type and abs(strip.height - beyond.height) < _LEVEL
        if not alike or strip.type not in _GO_ON:
            break
        out.append(InnerLane(strip.type, strip.width, beyond.width, strip.height, lane, lane_beyond))
    rest = [sum(strip.width for _, strip in walk.inner[len(out) :]) for walk in (one, other)]
    if max(rest) >= _CORNER_FILLED:
        out.append(InnerLane(LaneType.BORDER, rest[0], rest[1], one.height))
    return tuple(out)


def with_inner_lanes(
    rows: ConnectingRoads, own: BoolArray, cars: ConnectingRoads, parts: RoadParts, rule: Rule
) -> ConnectingRoads:
    """Leave out of corners the innermost lanes beside the sidewalk as far as they lie on lanes for cars.

    Parameters
    ----------
    rows
        Corners, with all that lies between their sidewalks and the carriageway.
    own
        Which of them go their own way, (rows,); the others run beside cars.
    cars, parts, rule
        The lanes for cars, the roads, and the side that one drives on.
    """
    inner = list(rows.inner)
    asked = np.array([bool(lanes) for lanes in inner], bool)
    while asked.any():
        here = replace(rows, inner=tuple(inner)).chosen(asked)
        bad = _lies_badly(here, own[asked], cars, parts, rule)
        asked[asked] = bad
        for k in np.flatnonzero(asked).tolist():
            inner[k] = inner[k][:-1]
            asked[k] = bool(inner[k])
    return replace(rows, inner=tuple(inner))


def _lies_badly(
    rows: ConnectingRoads, own: BoolArray, cars: ConnectingRoads, parts: RoadParts, rule: Rule
) -> BoolArray:
    """Say for which corners the innermost lane lies on lanes for cars, or folds, (rows,)."""
    # Towards the carriageway: left of a lane that traffic keeping right goes along.
    inwards = 1.0 if rule is Rule.RIGHT_HAND else -1.0
    start, end = inner_width(rows)
    start, end = start + rows.entry_width / 2, end + rows.exit_width / 2
    plan = rows.plan_view
    owner = np.repeat(np.arange(len(own)), np.diff(plan.start))
    reach = np.maximum(start, end) + defaults.CORNER_EDGE_RADIUS
    bad = np.zeros(len(own), bool)
    bad[owner[plan.curvature * inwards * reach[owner] > 1.0]] = True
    bad &= own
    far = np.flatnonzero(own | (rows.length > defaults.CORNER_FAR))
    last = [lanes[-1] for lanes in rows.inner]
    width = np.array([lane.entry_width for lane in last]), np.array([lane.exit_width for lane in last])
    nothing = np.zeros(len(own))
    for share in (0.0, 0.5):
        # Beside a turn a lane that swings wider may cover its edge, but no more.
        back = [np.maximum(share * whole, np.minimum(defaults.CORNER_ONTO_LANE, whole / 2)) for whole in width]
        t0, t1 = rows.entry_aside + inwards * (start - back[0]), rows.exit_aside + inwards * (end - back[1])
        x, y = probes(rows, t0, t1)
        bad |= onto_lanes(rows, cars, x, y, nothing)
        bad[far] |= onto_roads(rows.junction[far], parts, x[far], y[far])
    return bad


def inner_width(rows: ConnectingRoads) -> tuple[FloatArray, FloatArray]:
    """Return how wide all lanes between sidewalk and carriageway are together at both ends, (rows,), m."""
    start, end = np.zeros(len(rows.inner)), np.zeros(len(rows.inner))
    for k, lanes in enumerate(rows.inner):
        if lanes:
            start[k] = sum(lane.entry_width for lane in lanes)
            end[k] = sum(lane.exit_width for lane in lanes)
    return start, end
