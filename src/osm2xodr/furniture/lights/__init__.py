"""Traffic lights: where they stand, which lanes they govern, and which are green together."""

from __future__ import annotations

from osm2xodr.furniture.lights.nodes import cut_sections as cut_sections
from osm2xodr.furniture.lights.placing import place_lights as place_lights
