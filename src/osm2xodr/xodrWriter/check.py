"""Checks of a road map before it is written: that its tables fit together and nothing gets lost in the text.

Ids of furniture and what refers to them are left to `osm2xodr.checking`, which sees them in the written file.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, TypeAlias

import numpy as np

from osm2xodr.curves import lengths
from osm2xodr.errors import OutputError
from osm2xodr.model import FloatArray, RoadMap, RoadObject, RoadStructure, Signal, SignalReference

_Thing: TypeAlias = Signal | SignalReference | RoadObject | RoadStructure

_TABLES: Final = ("plan_view", "elevation", "superelevation", "lane_offset")
# Furniture may lie beyond a road's end by this, m: rounding. The writer puts it back onto the road.
_ROUNDING: Final = 1e-3


def check_road_map(road_map: RoadMap) -> FloatArray:
    """Check that a road map can be written, and return the lengths of its roads, m.

    Raises
    ------
    OutputError
        If tables and roads do not fit, numbers are not finite, roads have no length or no height, ids of roads and
        junctions repeat, or furniture does not stand on a road.
    """
    # Later checks rely on earlier ones.
    for defect in _table_defects(road_map):
        raise _error(defect)
    length = lengths(road_map.plan_view)
    for defect in _furniture_defects(road_map, length):
        raise _error(defect)
    return length


def _error(defect: str) -> OutputError:
    return OutputError(f"{defect}; this is a defect of osm2xodr, please report it with the area")


def _table_defects(road_map: RoadMap) -> Iterator[str]:
    """Yield what is wrong with roads and their tables."""
    count = len(road_map.roads)
    if count == 0:
        yield "there is no road to write"
    ids = [road.id for road in road_map.roads] + [junction.id for junction in road_map.junctions]
    if len(set(ids)) != len(ids) or min(ids) <= 0:
        yield "roads and junctions need ids of their own above 0"
    for name in _TABLES:
        start = getattr(road_map, name).start
        if len(start) != count + 1 or start[0] != 0 or (np.diff(start) < 0).any():
            yield "the tables of a road map do not fit its roads"
    for name in _TABLES:
        table = getattr(road_map, name)
        columns = [getattr(table, column) for column in type(table).__dataclass_fields__ if column != "start"]
        bad = np.flatnonzero(~np.logical_and.reduce([np.isfinite(column) for column in columns]))
        if len(bad):
            road = int(np.searchsorted(table.start, bad[0], side="right")) - 1
            yield f"{_road(road_map, road)} has a number that is not finite in its {name.replace('_', ' ')}"
    for table, what in ((road_map.plan_view, "geometry"), (road_map.elevation, "height")):
        empty = np.flatnonzero(np.diff(table.start) == 0)
        if len(empty):
            yield f"{_road(road_map, int(empty[0]))} has no {what}"
    if not (road_map.plan_view.length > 0.0).all() or not (lengths(road_map.plan_view) > 0.0).all():
        yield "a road or a piece of one has no length"


def _furniture_defects(road_map: RoadMap, length: FloatArray) -> Iterator[str]:
    """Yield what does not stand on a road, and controllers that the schema does not allow."""
    placed = road_map.furniture
    things: tuple[_Thing, ...] = (*placed.signals, *placed.references, *placed.objects, *placed.structures)
    length_of = dict(zip((road.id for road in road_map.roads), length.tolist(), strict=True)) if things else {}
    for thing in things:
        end = length_of.get(thing.road)
        if end is None:
            yield f"{_name(thing)} stands on road {thing.road}, which is not there"
            return
        places = [thing.s]
        if isinstance(thing, RoadObject) and thing.repeat is not None:
            places += [thing.repeat.s, thing.repeat.s + thing.repeat.length]
        elif isinstance(thing, RoadStructure):
            places.append(thing.s + thing.length)
        if not all(-_ROUNDING <= s <= end + _ROUNDING for s in places):
            yield f"{_name(thing)} does not stand within the {end:.3f} m of road {thing.road}: s {thing.s:.3f}"
    for controller in placed.controllers:
        if not controller.signals:
            yield f"controller {controller.id} has no signal"


def _road(road_map: RoadMap, index: int) -> str:
    """Name a road so that its origin can be found."""
    road = road_map.roads[index]
    ways = ", ".join(f"way/{way}" for way in road.osm_way_ids[:3])
    return f"road {road.id} ({ways})" if ways else f"road {road.id}"


def _name(thing: _Thing) -> str:
    """Name a thing so that its origin can be found."""
    if isinstance(thing, SignalReference):
        return f"a reference to signal {thing.signal}"
    if isinstance(thing, RoadStructure):
        return f"{thing.kind} {thing.id}"
    what = "signal" if isinstance(thing, Signal) else "object"
    return f"{what} {thing.id} ({thing.osm_id})" if thing.osm_id else f"{what} {thing.id}"
