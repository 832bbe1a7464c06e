"""Lights and barriers of level crossings: open, as no train comes, they stand beside the road."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from osm2xodr.furniture import defaults
from osm2xodr.furniture.world import RailStop, World
from osm2xodr.model import RoadObject, Rule

# OpenDRIVE's type and subtype, and a name; height and radius, m. Heads hang at 2.1 m and more (RiLSA), booms turn on
# machines of about 1.1 m; radii are choices.
_LIGHT: Final = (("pole", "", "level crossing light"), 3.0, 0.15)
_BARRIER: Final = (("barrier", "", "level crossing barrier"), 1.1, 0.2)
# Lights stand this far behind the sign, as traffic meets them, barriers twice as far, m; a choice.
_STEP: Final = 0.8


def rail_crossing_objects(world: World, stops: Sequence[RailStop]) -> list[RoadObject]:
    """Make the lights and barriers before railways that tags name, on the side of the traffic that they are for.

    Barriers that close the whole road have a second one on its other side.
    """
    out: list[RoadObject] = []
    for stop in stops:
        near = -1.0 if stop.along == (world.road_map.rule is Rule.RIGHT_HAND) else 1.0
        if stop.crossing.lights:
            out.append(_beside(world, stop, near, 1, _LIGHT))
        if stop.crossing.barriers:
            out.append(_beside(world, stop, near, 2, _BARRIER))
        if stop.crossing.barriers == "full":
            out.append(_beside(world, stop, -near, 2, _BARRIER))
    return out


def _beside(
    world: World, stop: RailStop, side: float, steps: int, what: tuple[tuple[str, str, str], float, float]
) -> RoadObject:
    words, height, radius = what
    s = stop.s + steps * (_STEP if stop.along else -_STEP)
    s = min(max(s, 0.0), world.lanes.length(stop.road))
    left, right = world.lanes.carriageway(stop.road, s)
    t = (left if side > 0.0 else right) + side * (defaults.SIGN_CLEARANCE + radius)
    made = world.object_at(stop.road, words, s, t, stop.osm_id)
    return replace(made, height=height, radius=radius, orientation="+" if stop.along else "-")
