"""The ground around roads: from the elevation model, met by every edge of a road without a gap.

`building` has the steps in order: `cells` are the squares that it consists of, and `heights` says how high their
corners are; `band` is what lies between roads, shores of `water` and whole squares. Before, `covers` finds the
tunnels that no ground covers, and the junctions in tunnels.
"""

from __future__ import annotations

from osm2xodr.exporting.scene.ground.building import Ground, build_ground
from osm2xodr.exporting.scene.ground.covers import Height, settled
from osm2xodr.exporting.scene.ground.water import WaterShapes, water_shapes

__all__ = ["Ground", "Height", "WaterShapes", "build_ground", "settled", "water_shapes"]
