"""What must hold of furniture before it is written."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import chain
from typing import Final, TypeAlias

from osm2xodr.model import (
    Controller,
    FloatArray,
    Furniture,
    RoadMap,
    RoadObject,
    RoadStructure,
    Signal,
    SignalReference,
)

_Thing: TypeAlias = Signal | SignalReference | RoadObject | RoadStructure

# How far beyond a road's end is a matter of rounding, m; the writer puts it back onto the road.
_ROUNDING: Final = 1e-3

_NUMBERS: Final = {
    Signal: ("s", "t", "z_offset", "height", "width", "h_offset"),
    SignalReference: ("s", "t"),
    RoadObject: ("s", "t", "z_offset", "hdg", "length", "width", "height", "radius"),
    RoadStructure: ("s", "length", "lighting", "daylight"),
}


def furniture_defect(road_map: RoadMap, lengths: FloatArray) -> str:
    """Return what is wrong with the furniture of a road map, empty where it is sound.

    Parameters
    ----------
    road_map
        Its roads have ids of their own.
    lengths : (roads,)
        Of the roads, m.
    """
    furniture = road_map.furniture
    return next(chain(_places(road_map, lengths), _ids(furniture), _references(furniture, road_map)), "")


def _places(road_map: RoadMap, lengths: FloatArray) -> Iterator[str]:
    """Yield what does not stand on a road, or has numbers that are not finite."""
    furniture = road_map.furniture
    things: tuple[_Thing, ...] = (
        *furniture.signals,
        *furniture.references,
        *furniture.objects,
        *furniture.structures,
    )
    if not things:
        return
    length_of = dict(zip((road.id for road in road_map.roads), lengths.tolist(), strict=True))
    for thing in things:
        length = length_of.get(thing.road)
        if length is None:
            yield f"{_name(thing)} stands on road {thing.road}, which is not there"
            continue
        if not _finite(thing):
            yield f"{_name(thing)} has a number that is not finite"
        starts = [thing.s]
        if isinstance(thing, RoadObject) and thing.repeat is not None:
            starts += [thing.repeat.s, thing.repeat.s + thing.repeat.length]
        elif isinstance(thing, RoadStructure):
            starts.append(thing.s + thing.length)
        if not all(-_ROUNDING <= s <= length + _ROUNDING for s in starts):
            yield f"{_name(thing)} does not stand within the {length:.3f} m of road {thing.road}: s {starts[0]:.3f}"


def _finite(thing: _Thing) -> bool:
    """Whether all numbers of a thing are finite."""
    numbers = [getattr(thing, name) for name in _NUMBERS[type(thing)]]
    if isinstance(thing, RoadObject):
        numbers += chain.from_iterable(thing.outline)
        if thing.repeat is not None:
            numbers += [getattr(thing.repeat, name) for name in type(thing.repeat).__dataclass_fields__]
    elif isinstance(thing, Signal) and thing.value is not None:
        numbers.append(thing.value)
    return all(map(math.isfinite, numbers))


def _ids(furniture: Furniture) -> Iterator[str]:
    """Yield ids that repeat, or are not above 0."""
    things = [item.id for item in furniture.signals] + [item.id for item in furniture.objects]
    things += [item.id for item in furniture.structures]
    for ids, what in (
        (things, "signals, objects, bridges and tunnels"),
        ([item.id for item in furniture.controllers], "controllers"),
    ):
        if ids and (min(ids) <= 0 or len(set(ids)) != len(ids)):
            yield f"{what} need ids of their own above 0"


def _references(furniture: Furniture, road_map: RoadMap) -> Iterator[str]:
    """Yield what refers to a signal or junction that is not there."""
    signals = {item.id for item in furniture.signals}
    for reference in furniture.references:
        if reference.signal not in signals:
            yield f"road {reference.road} refers to signal {reference.signal}, which is not there"
    junctions = {item.id for item in road_map.junctions} if furniture.controllers else set()
    for controller in furniture.controllers:
        yield from _controlled(controller, signals, junctions)


def _controlled(controller: Controller, signals: set[int], junctions: set[int]) -> Iterator[str]:
    """Yield what a controller names that is not there."""
    if not controller.signals:
        yield f"controller {controller.id} has no signal"
    for signal in controller.signals:
        if signal not in signals:
            yield f"controller {controller.id} names signal {signal}, which is not there"
    if controller.junction is not None and controller.junction not in junctions:
        yield f"controller {controller.id} names junction {controller.junction}, which is not there"


def _name(thing: _Thing) -> str:
    """Name a thing so that its origin can be found."""
    if isinstance(thing, SignalReference):
        return f"a reference to signal {thing.signal}"
    if isinstance(thing, RoadStructure):
        return f"{thing.kind} {thing.id}"
    what = "signal" if isinstance(thing, Signal) else "object"
    return f"{what} {thing.id} ({thing.osm_id})" if thing.osm_id else f"{what} {thing.id}"
