"""Traffic lights: where they stand, which lanes they govern, and which are green together."""

from __future__ import annotations

from osm2xodr.furniture.lights.placing import place_lights
from osm2xodr.furniture.lights.section_breaks import cut_sections

__all__ = ["cut_sections", "place_lights"]
