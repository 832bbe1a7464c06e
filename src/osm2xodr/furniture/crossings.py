"""Crossings for people on foot."""

from __future__ import annotations

from collections.abc import Sequence

from osm2xodr.furniture.world import Crossing, World
from osm2xodr.model import RoadObject


def find_crossings(world: World) -> tuple[Crossing, ...]:
    """Find where people cross roads."""
    return ()


def crossing_objects(world: World, crossings: Sequence[Crossing]) -> tuple[RoadObject, ...]:
    """Make the objects of crossings: crosswalks, and islands in them."""
    return ()
