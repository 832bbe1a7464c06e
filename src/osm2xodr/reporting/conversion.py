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
    """A road network, and what is worth saying about it.

    Parameters
    ----------
    road_map
        What is to be written.
    statistics
        Its figures.
    elevation_models
        What the elevation models are and what was used of them, in the order given.
    """

    road_map: RoadMap
    statistics: Statistics
    elevation_models: tuple[DemSummary, ...]
