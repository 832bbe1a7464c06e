"""The ground around roads: from the elevation model, met by every edge of a road without a gap.

`building` has the steps in order: `cells` says where there is ground, `slopes` how high it is, `leaves` covers what
is away from roads with squares, `band` what is beside them, and `fans` lets it stand at two heights at portals.
`passages` finds the tunnels that no ground covers.
"""

from __future__ import annotations

from osm2xodr.exporting.scene.ground.building import Ground, Height, build_ground
from osm2xodr.exporting.scene.ground.passages import find_passages, on_the_ground

__all__ = ["Ground", "Height", "build_ground", "find_passages", "on_the_ground"]
