"""Traffic signs: what they say, where they stand, whom they are for."""

from __future__ import annotations

from osm2xodr.furniture.signs.placing import place_signs

__all__ = ["place_signs"]
