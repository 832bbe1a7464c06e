"""Traffic lights at junctions and crossings, and the controllers that switch them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from osm2xodr.furniture.world import Approach, Crossing, Stop, World
from osm2xodr.model import Controller, Signal, SignalReference


@dataclass(frozen=True, slots=True)
class Lights:
    """What lights consist of."""

    signals: tuple[Signal, ...] = ()
    references: tuple[SignalReference, ...] = ()
    controllers: tuple[Controller, ...] = ()
    stops: tuple[Stop, ...] = ()


def place_lights(world: World, approaches: Sequence[Approach], crossings: Sequence[Crossing]) -> Lights:
    """Place all traffic lights."""
    return Lights()
