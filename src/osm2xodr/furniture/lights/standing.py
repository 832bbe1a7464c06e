"""Keeps the poles of lights off lanes: of the own road and of others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from osm2xodr.furniture import defaults
from osm2xodr.furniture.lights.heads import FOR_PEOPLE
from osm2xodr.furniture.world import PostClearance, World
from osm2xodr.model import Controller, Signal

# How far outwards a head may be moved to where no lane is, m, in the order of trials; choices.
_STEPS: Final = (-0.3, 0.5, 1.0)


def off_lanes(world: World, signals: Sequence[Signal]) -> list[Signal]:
    """Return heads so that none stands on lanes.

    Those beside the carriageway go a little nearer to it or farther off; where there is no room, those for cars hang
    above their lanes, and those for people are left out: nobody waits between lanes.
    """
    standing = [k for k, item in enumerate(signals) if item.z_offset < defaults.LIGHT_Z_ABOVE]
    out: list[Signal | None] = list(signals)
    others = PostClearance(world, [(signals[k].road, signals[k].s) for k in standing])
    for step in (0.0, *_STEPS):
        places = [(signals[k].road, signals[k].s, _outwards(world, signals[k], step)) for k in standing]
        own = [_on_carriageway(world, *place) for place in places]
        free = [is_free and not on for is_free, on in zip(others.are_free(places), own, strict=True)]
        for k, (_, _, t), is_free in zip(standing, places, free, strict=True):
            out[k] = replace(signals[k], t=t) if is_free and step else out[k]
        standing = [k for k, is_free in zip(standing, free, strict=True) if not is_free]
    for k in standing:
        out[k] = _without_room(world, signals[k])
    return [item for item in out if item is not None]


def _on_carriageway(world: World, road: int, s: float, t: float) -> bool:
    """Return whether a place is on the carriageway of its own road."""
    left, right = world.lanes.carriageway(road, s)
    return right < t < left


def _outwards(world: World, signal: Signal, step: float) -> float:
    """Return t of a head that is moved away from the carriageway, m."""
    left, right = world.lanes.carriageway(signal.road, signal.s)
    return signal.t + (step if signal.t > 0.5 * (left + right) else -step)


def _without_room(world: World, signal: Signal) -> Signal | None:
    """Return a head for which there is no room beside its road: above its lanes; None for people."""
    if signal.type == FOR_PEOPLE:
        words = "a light for people is left out: it would stand on lanes"
        world.diagnostics.note("light-no-room", signal.osm_id, words)
        return None
    lanes = [
        lane
        for lane in world.lanes.at(signal.road, signal.s)
        if any(first <= lane.id <= last for first, last in signal.validity)
    ]
    if not lanes:
        return signal
    middle = 0.5 * (max(lane.left for lane in lanes) + min(lane.right for lane in lanes))
    return replace(signal, t=middle, z_offset=defaults.LIGHT_Z_ABOVE)


def switching(controllers: Sequence[Controller], signals: Sequence[Signal]) -> list[Controller]:
    """Return controllers without the heads that have been left out, and none without a head."""
    there = {item.id for item in signals}
    kept = [replace(item, signals=tuple(k for k in item.signals if k in there)) for item in controllers]
    return [item for item in kept if item.signals]
