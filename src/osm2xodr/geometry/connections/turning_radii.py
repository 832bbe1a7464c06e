"""The radii of turns at the corners between two streets: what they should have, and what would cut the corner."""

from __future__ import annotations

import numpy as np

from osm2xodr.geometry.connections import defaults
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import FloatArray, IntArray


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

    The lane beside the kerb has half its width between its middle and the kerb. No larger arc leaves the
    carriageway, as it goes on straight, by more than `CORNER_CUT`: at an acute corner that leaves less than the kerb.
    """
    kerb = np.minimum(ends.kerb[entry], ends.kerb[exit_])
    right = np.maximum(ends.left[entry] - t_in, t_out - ends.right[exit_])
    left = np.maximum(t_in - ends.right[entry], ends.left[exit_] - t_out)
    beside = np.maximum(np.where(turn < 0, right, left), 0.0) + defaults.CORNER_CUT
    largest = beside / np.maximum(1 - np.cos(turn / 2), 1e-6)
    largest = np.maximum(largest, defaults.TURNING_RADIUS_ACUTE)
    wanted = np.maximum(kerb + width / 2, defaults.TURNING_RADIUS)
    return np.minimum(wanted, largest), largest
