"""What a conversion comes to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from osm2xodr.model import RoadMap
from osm2xodr.reporting.statistics import Statistics

if TYPE_CHECKING:
    from osm2xodr.surface import DemSummary


@dataclass(frozen=True, slots=True)
class Conversion:
    """A road network, and what is worth saying about it."""

    road_map: RoadMap  # What is to be written
    statistics: Statistics  # Its figures
    # What the elevation models are and what was used of them, in the order given
    elevation_models: tuple[DemSummary, ...]
