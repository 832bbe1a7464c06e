"""What lies on the carriageway and stands beside it."""

from __future__ import annotations

from osm2xodr.furniture.objects.crossings import crossing_objects, find_crossings
from osm2xodr.furniture.objects.placing import place_objects
from osm2xodr.furniture.objects.structures import place_structures

__all__ = ["crossing_objects", "find_crossings", "place_objects", "place_structures"]
