"""Traffic signs beside the road."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from osm2xodr.furniture.world import Approach, Stop, World
from osm2xodr.model import Signal


@dataclass(frozen=True, slots=True)
class PlacedSigns:
    """Signs, and where those among them make traffic stop."""

    signals: tuple[Signal, ...] = ()
    stops: tuple[Stop, ...] = ()


def place_signs(world: World, approaches: Sequence[Approach], signalled: frozenset[tuple[int, bool]]) -> PlacedSigns:
    """Place all signs."""
    return PlacedSigns()
