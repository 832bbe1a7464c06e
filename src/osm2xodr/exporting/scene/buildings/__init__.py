"""Buildings of OpenStreetMap as blocks with simple roofs, on the ground and off the roads.

`building` has the steps in order: `outlines` says what is left of each area, `heights` how high it is, `roofs` how
its roof bends, and `meshes` makes walls and roofs of that.
"""

from __future__ import annotations

from osm2xodr.exporting.scene.buildings.building import Buildings, building_parts

__all__ = ["Buildings", "building_parts"]
