"""The ground around roads: from the elevation model, met by every edge of a road without a gap.

`building` has the steps in order: `cells` says where there is ground, `slopes` how high it is, `leaves` covers what
is away from roads with squares, `band` what is beside them, and `fans` lets it stand at two heights at portals.
"""

from __future__ import annotations

from osm2xodr.exporting.scene.ground.building import Ground, build_ground

__all__ = ["Ground", "build_ground"]
