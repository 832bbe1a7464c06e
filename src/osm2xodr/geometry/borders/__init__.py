"""Roads cut where areas side by side meet."""

from __future__ import annotations

from osm2xodr.geometry.borders.borders import find_borders
from osm2xodr.geometry.borders.heights import COMMON_ORIGIN, Neighbourhood, with_border_heights
from osm2xodr.geometry.borders.own_part import keep_own

__all__ = ["COMMON_ORIGIN", "Neighbourhood", "find_borders", "keep_own", "with_border_heights"]
