"""The floor of junctions: strips beside connecting roads that close the gaps between their lanes.

`cross_sections` where the lanes' edges are · `gaps` places that lanes enclose and none covers, and how far these
reach from a lane's edge · `filling` which edges the strips begin at, and how wide they are · `islands` gaps and areas
that are raised · `faces` ends of carriageways that no lane goes on from · `loops` the middle of turning circles
"""

from __future__ import annotations

from osm2xodr.geometry.junction_floor.faces import Faces
from osm2xodr.geometry.junction_floor.filling import Floor, lay_floor
from osm2xodr.geometry.junction_floor.islands import Hole, is_island, raised_islands

__all__ = ["Faces", "Floor", "Hole", "is_island", "lay_floor", "raised_islands"]
