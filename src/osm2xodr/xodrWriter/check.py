"""What must hold of every road map before it is written."""

from __future__ import annotations

import numpy as np

from osm2xodr.curves import lengths
from osm2xodr.errors import OutputError
from osm2xodr.model import FloatArray, IntArray, RoadMap
from osm2xodr.xodrWriter.furniture_check import furniture_defect
from osm2xodr.xodrWriter.tables import all_finite

_DEFECT = "this is a defect of osm2xodr, please report it with the area"


def check_road_map(road_map: RoadMap) -> FloatArray:
    """Check what a file depends on as a whole, and return the lengths of the roads, m.

    Raises
    ------
    OutputError
        If tables and roads do not fit, numbers are not finite, roads have no length or no height, ids repeat, or
        furniture stands where there is no road or refers to what is not there.
    """
    count = len(road_map.roads)
    if count == 0:
        msg = f"there is no road to write; {_DEFECT}"
        raise OutputError(msg)
    ids = [road.id for road in road_map.roads] + [junction.id for junction in road_map.junctions]
    if len(set(ids)) != len(ids) or min(ids) <= 0:
        msg = f"roads and junctions need ids of their own above 0; {_DEFECT}"
        raise OutputError(msg)
    profiles = (road_map.elevation, road_map.superelevation, road_map.lane_offset)
    for start in (road_map.plan_view.start, *(profile.start for profile in profiles)):
        _check_index(start, count)
    if not all_finite(road_map.plan_view, *profiles):
        msg = f"{_first_not_finite(road_map)}; {_DEFECT}"
        raise OutputError(msg)
    _check_not_empty(road_map.plan_view.start, "no geometry", road_map)
    _check_not_empty(road_map.elevation.start, "no height", road_map)
    length = lengths(road_map.plan_view)
    if not (length > 0.0).all() or not (road_map.plan_view.length > 0.0).all():
        msg = f"a road or a piece of one has no length; {_DEFECT}"
        raise OutputError(msg)
    defect = furniture_defect(road_map, length)
    if defect:
        raise OutputError(f"{defect}; {_DEFECT}")
    return length


def _check_index(start: IntArray, count: int) -> None:
    """One curve of every table for every road."""
    if len(start) != count + 1 or start[0] != 0 or (np.diff(start) < 0).any():
        msg = f"the tables of a road map do not fit its roads; {_DEFECT}"
        raise OutputError(msg)


def _check_not_empty(start: IntArray, what: str, road_map: RoadMap) -> None:
    """Every road has a record."""
    empty = np.flatnonzero(np.diff(start) == 0)
    if len(empty):
        msg = f"{_describe(road_map, int(empty[0]))} has {what}; {_DEFECT}"
        raise OutputError(msg)


def _first_not_finite(road_map: RoadMap) -> str:
    """Name the first road with a number that is not finite."""
    for name in ("plan_view", "elevation", "superelevation", "lane_offset"):
        table = getattr(road_map, name)
        good = np.ones(int(table.start[-1]), dtype=np.bool_)
        for column in type(table).__dataclass_fields__:
            if column != "start":
                good &= np.isfinite(getattr(table, column))
        bad = np.flatnonzero(~good)
        if len(bad):
            index = int(np.searchsorted(table.start, bad[0], side="right")) - 1
            return f"{_describe(road_map, index)} has a number that is not finite in its {name.replace('_', ' ')}"
    return "a number is not finite"


def _describe(road_map: RoadMap, index: int) -> str:
    """Name a road so that its origin can be found."""
    road = road_map.roads[index]
    ways = ", ".join(f"way/{way}" for way in road.osm_way_ids[:3])
    return f"road {road.id} ({ways})" if ways else f"road {road.id}"
