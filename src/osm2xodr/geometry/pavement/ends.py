"""How wide strips may be near the ends of connecting roads: they end with the lanes of their arms."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import unique_inverse
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.pavement.cross_sections import CrossSections, LaneEdges
from osm2xodr.geometry.pavement.faces import Faces
from osm2xodr.model import FloatArray, IntArray

# Strips may reach so far beyond the outermost lanes of an arm where these end, m, and farther by as much as they are
# away from there. A choice: boundaries of junctions close over no more than 0.3 m.
_OPEN_AT_END: Final = 0.2


def room_before_ends(
    sections: CrossSections, rows: IntArray, roads: ConnectingRoads, edges: LaneEdges, faces: Faces
) -> FloatArray:
    """Return how wide strips may be at the left and the right of cross sections of some roads, (2, n), m.

    `rows` (k,), ascending, are all roads at their arms. Where lanes of an arm lead nowhere, all of it counts.
    """
    end, same, low, high = edges.on_arms(roads, rows)
    arms, arm = unique_inverse(end)
    here = np.isin(faces.end, arms)
    face = np.searchsorted(arms, faces.end[here])
    lowest, highest = np.full(len(arms), np.inf), np.full(len(arms), -np.inf)
    lowest[face], highest[face] = faces.right[here], faces.left[here]
    np.minimum.at(lowest, arm, low)
    np.maximum.at(highest, arm, high)
    below, above = low - lowest[arm], highest[arm] - high
    road = np.searchsorted(rows, sections.road)
    to_end = edges.length[sections.road] - sections.s
    out = []
    for room in (np.where(same, above, below), np.where(same, below, above)):
        at_start, at_end = room.reshape(2, -1)[:, road]
        out.append(_OPEN_AT_END + np.minimum(at_start + sections.s, at_end + to_end))
    return np.array(out)
