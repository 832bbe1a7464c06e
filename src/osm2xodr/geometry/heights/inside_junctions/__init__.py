"""Heights inside junctions: a smooth surface for each, and the connecting roads that are cut from it."""

from __future__ import annotations

from osm2xodr.geometry.heights.inside_junctions.profiles import connector_profiles, end_state

__all__ = ["connector_profiles", "end_state"]
