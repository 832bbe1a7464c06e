"""The ground around roads: from the elevation model, met by every edge of a road without a gap.

`building` has the steps in order: `cells` says where there is ground, `slopes` how high it is, `leaves` covers what
is away from roads with squares, `band` what is beside them, and lets it stand at two heights at portals.
`water` is level and cut out of it. Before, `covers` finds the tunnels that no ground covers, and the junctions in
tunnels.
"""

from __future__ import annotations

from osm2xodr.exporting.scene.ground.building import Ground, build_ground
from osm2xodr.exporting.scene.ground.covers import Height, settled
from osm2xodr.exporting.scene.ground.water import WaterShapes, water_shapes

__all__ = ["Ground", "Height", "WaterShapes", "build_ground", "settled", "water_shapes"]
