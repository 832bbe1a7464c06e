"""Areas cut out of one map, so that neighbours fit."""

from __future__ import annotations

from osm2xodr.batch.cutting.cuts import bounds_of, cut_areas

__all__ = ["bounds_of", "cut_areas"]
