"""Crosswalks as lanelets for walkers."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from osm2xodr.exporting.lanelet2.lanelets import Placed
from osm2xodr.exporting.lanelet2.primitives import Primitives
from osm2xodr.exporting.lanelet2.words import lanelet_tags
from osm2xodr.exporting.outlines import outline_points
from osm2xodr.model import FloatArray
from osm2xodr.opendrive import Furniture, pose

# The bounds by subtype: those that nothing marks are virtual.
_BOUNDS: Final = {"zebra": "zebra_marking", "virtual": "virtual"}


def add_crosswalk(placed: Placed, primitives: Primitives, item: Furniture) -> bool:
    """Add a crosswalk as a lanelet across its road; False where its outline has no two sides along the way across."""
    file = placed.cut.file
    ring = _ring(placed, item)
    if ring is None:
        return False
    heading = float(pose(file, np.array([item.road]), np.array([item.s]))[2][0])
    sides = _sides(ring, np.array([-math.sin(heading), math.cos(heading)]))
    if sides is None:
        return False
    type_ = _BOUNDS.get(item.attributes.get("subtype", ""), "pedestrian_marking")
    left, right = (
        primitives.add_line(primitives.add_points(side), {"type": type_, "lane_change": "no"}) for side in sides
    )
    strip = placed.nearest(item.road, item.s, along=True)
    location = "" if strip is None else placed.cut.strips[strip].words.location
    tags = lanelet_tags("crosswalk", ("pedestrian",), location=location, both_ways=True, speed=math.nan)
    place = {"xodr:road": file.roads.id[item.road], "xodr:object": item.attributes.get("id", "")}
    primitives.add_lanelet(left, right, {**tags, **place})
    return True


def _ring(placed: Placed, item: Furniture) -> FloatArray | None:
    """Return the corners of an object's outline, or of the rectangle of its size, (n, 3), m; None without."""
    file = placed.cut.file
    if item.outlines:
        corners, local = np.array(item.outlines[0]), item.local_outlines[0]
    elif item.length > 0 and item.width > 0:
        u, v = item.length / 2, item.width / 2
        corners, local = np.array([(-u, -v, 0, 0), (u, -v, 0, 0), (u, v, 0, 0), (-u, v, 0, 0)]), True
    else:
        return None
    ring = np.column_stack(outline_points(file, item, corners, local))
    if len(ring) > 1 and np.allclose(ring[0], ring[-1]):
        ring = ring[:-1]
    return ring if len(ring) >= 4 and bool(np.isfinite(ring).all()) else None


def _sides(ring: FloatArray, across: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Return the left and right side of a ring (n, 3) for who walks in the direction `across`.

    Of its edges the two that are squarest to the way across, one at either end, are where walkers come and go.
    """
    middles = 0.5 * (ring + np.roll(ring, -1, axis=0))[:, :2]
    edges = (np.roll(ring, -1, axis=0) - ring)[:, :2]
    far = (middles - ring[:, :2].mean(0)) @ across
    size = np.hypot(*edges.T)
    # The part of an edge that leads neither to nor fro.
    square = np.sqrt(np.maximum(size**2 - (edges @ across) ** 2, 0.0))
    first, last = (int(np.argmax(np.where(sign * far > 0, square, -1.0))) for sign in (-1, 1))
    if min(square[first], square[last]) <= 0.0 or far[first] >= 0 or far[last] <= 0:
        return None
    n = len(ring)
    one = ring[[(first + 1 + k) % n for k in range((last - first - 1) % n + 1)]]
    other = ring[[(last + 1 + k) % n for k in range((first - last - 1) % n + 1)]][::-1]
    if len(one) < 2 or len(other) < 2:
        return None
    # Counter-clockwise rings have the right side first.
    left_first = float(np.cross(across, one[:, :2].mean(0) - other[:, :2].mean(0))) > 0
    return (one, other) if left_first else (other, one)
