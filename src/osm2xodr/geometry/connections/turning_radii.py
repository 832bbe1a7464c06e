"""The radii of turns at the corners between two streets: what they should have, and what would cut the corner."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import cosine
from osm2xodr.geometry.connections import defaults
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import FloatArray, IntArray

# What an arc cuts off a square corner, measured from either side, in radii.
_SQUARE_CUT: Final = 0.2929


def turning_radii(
    ends: StreetEnds,
    entry: IntArray,
    exit_: IntArray,
    t_in: FloatArray,
    t_out: FloatArray,
    width: FloatArray,
    turn: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the radii that turns should have, and the largest that do not cut their corner, (n,), m.

    The turns lead from lanes t_in left of street ends `entry` to lanes t_out left of street ends `exit_`, seen from
    the junction, m, which are `width` wide, m; `turn` is their change of heading, left positive, rad.

    Lanes beside each other turn about one centre: to the radius of their inner edge comes what lies between it and
    the lane. A kerb of that radius would cut off as much of an acute corner as one of `KERB_RADIUS` does of a square
    one, or up to `LARGEST_KERB` times as much. No arc leaves the carriageways by more than `OFF_CARRIAGEWAY`.
    """
    kerb = np.minimum(ends.kerb[entry], ends.kerb[exit_])
    right = np.maximum(ends.left[entry] - t_in, t_out - ends.right[exit_])
    left = np.maximum(t_in - ends.right[entry], ends.left[exit_] - t_out)
    beside = np.maximum(np.where(turn < 0, right, left), width / 2)
    edge = kerb * _SQUARE_CUT / np.maximum(1 - cosine(turn / 2), 1e-6)
    stretched = defaults.LARGEST_KERB * edge
    wanted = (
        np.maximum(np.minimum(kerb, edge), np.minimum(defaults.TURNING_RADIUS - width / 2, stretched)) + width / 2
    )
    # The lane nearer to its street's line leaves the carriageways first.
    aside = np.minimum(np.where(turn < 0, t_in, -t_in), np.where(turn < 0, -t_out, t_out))
    half = np.maximum(half_carriageways(ends, entry), half_carriageways(ends, exit_))
    inside = (half + defaults.OFF_CARRIAGEWAY - aside) / np.maximum(1 - cosine(turn / 2), 1e-6)
    least = defaults.TURNING_RADIUS_ACUTE
    return np.maximum(np.minimum(wanted, inside), least), np.maximum(np.minimum(stretched + beside, inside), least)


def half_carriageways(ends: StreetEnds, end: IntArray) -> FloatArray:
    """Return half of the widths of the carriageways at street ends, at least those of narrow ones, (n,), m."""
    return np.maximum((ends.left[end] - ends.right[end]) / 2, defaults.HALF_NARROW_CARRIAGEWAY)
