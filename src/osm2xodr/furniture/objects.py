"""Objects on and beside the road apart from crossings."""

from __future__ import annotations

from collections.abc import Sequence

from osm2xodr.furniture.world import Approach, Stop, World
from osm2xodr.model import RoadObject


def place_objects(world: World, approaches: Sequence[Approach], stops: Sequence[Stop]) -> tuple[RoadObject, ...]:
    """Place stop lines, arrows, and whatever stands beside the road."""
    return ()
