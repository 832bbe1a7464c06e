"""The graph of lanes, for the page's routes."""

from __future__ import annotations

import numpy as np

from osm2xodr.opendrive import OpenDrive
from osm2xodr.viewing.page.packing import Packed
from osm2xodr.viewing.scene import Scene


def lane_arrays(file: OpenDrive, scene: Scene) -> dict[str, Packed]:
    """Return where cars drive on each lane of a scene (1 along s, 2 against it, 3 both), and the steps between them.

    Steps are pairs of nodes: twice a lane of the scene, plus 1 against s.
    """
    # Loads slowly, as the checks do.
    from osm2xodr.checking import driving_of

    graph = driving_of(file)
    drawn = np.full(len(file.lanes.id), -1, np.int64)
    drawn[scene.lane] = np.arange(len(scene.lane))
    start, end = (2 * drawn[nodes // 2] + nodes % 2 for nodes in (graph.start, graph.end))
    kept = (start >= 0) & (end >= 0)
    traffic = graph.along.astype(np.int32) + 2 * graph.against.astype(np.int32)
    return {
        "lane_traffic": traffic[scene.lane].astype(np.int32),
        "step_start": start[kept].astype(np.int32),
        "step_end": end[kept].astype(np.int32),
    }
