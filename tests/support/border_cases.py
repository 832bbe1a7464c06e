"""Road maps divided between two areas."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from osm2xodr.curves.plan_views import lengths, snap_cuts
from osm2xodr.curves.records import pose
from osm2xodr.model import Borders, FloatArray, IntArray, Outline, Partition, RoadMap

WEST, EAST = 0, 1
# First ids of both.
FIRST = (1000, 50_000)
# The first metres of a junction's arms are the junction's, m.
_STUB = 25.0
_STEP = 1.0
_FAR = 1e6
_ANYWHERE = Outline((np.array([[-_FAR, -_FAR], [_FAR, -_FAR], [_FAR, _FAR], [-_FAR, _FAR]]),))


def halves_of(road_map: RoadMap, x: float, own: int, first_ids: tuple[int, int] = FIRST) -> RoadMap:
    """Return a road map of two areas, west and east of a line; parameters as of `divided`, x is where the line is."""
    return divided(road_map, lambda place: (place >= x).astype(np.int64), own, first_ids)


def stripes_of(road_map: RoadMap, width: float, own: int) -> RoadMap:
    """Return a road map of two areas that alternate from west to east, in stripes of a width, m."""
    return divided(road_map, lambda place: np.floor(place / width).astype(np.int64) % 2, own, FIRST)


def divided(
    road_map: RoadMap, area_at: Callable[[FloatArray], IntArray], own: int, first_ids: tuple[int, int]
) -> RoadMap:
    """Return a road map with borders between two areas.

    Parameters
    ----------
    road_map
        Of an area by itself.
    area_at
        Tells the area, `WEST` or `EAST`, at places (n,), x, local, m.
    own, first_ids
        The area that is converted, and the first ids of both.
    """
    junction_area = area_at(_junction_places(road_map))
    by_id = {junction.id: int(area) for junction, area in zip(road_map.junctions, junction_area, strict=True)}
    length = lengths(road_map.plan_view)
    starts, places, areas = [0], [], []
    for k, road in enumerate(road_map.roads):
        if road.junction is not None:
            break
        s = np.linspace(0.0, length[k], int(length[k] / _STEP) + 2)
        area = area_at(pose(road_map.plan_view, np.full(len(s), k), s)[0])
        stub = min(_STUB, 0.5 * float(length[k]))
        for link, near in ((road.predecessor, s <= stub), (road.successor, s > length[k] - stub)):
            if link is not None and link.to_junction:
                area[near] = by_id[link.id]
        cuts = np.flatnonzero(np.diff(area)) + 1
        # Anywhere between two places, but not on them, where the stations of other things may be.
        between = s[cuts] - 0.37 * (s[1] - s[0])
        places += [np.array([0.0]), snap_cuts(road_map.plan_view, np.full(len(cuts), k), between)]
        areas += [area[:1], area[cuts]]
        starts.append(starts[-1] + 1 + len(cuts))
    # Nobody asks for the outlines once the pieces are known.
    partition = Partition(road_map.frame, ("west", "east"), (_ANYWHERE, _ANYWHERE), first_ids, own)
    borders = Borders(
        partition, np.array(starts, np.int64), np.concatenate(places), np.concatenate(areas), junction_area
    )
    return replace(road_map, borders=borders)


def alone(road_map: RoadMap, first_id: int = 1) -> RoadMap:
    """Return a road map all of which is one area."""
    roads = sum(road.junction is None for road in road_map.roads)
    partition = Partition(road_map.frame, ("all",), (_ANYWHERE,), (first_id,), 0)
    nowhere = np.zeros(len(road_map.junctions), np.int64)
    borders = Borders(partition, np.arange(roads + 1), np.zeros(roads), np.zeros(roads, np.int64), nowhere)
    return replace(road_map, borders=borders)


def _junction_places(road_map: RoadMap) -> FloatArray:
    """Return x of each junction: that of the start of its first connecting road."""
    start = road_map.plan_view.x[road_map.plan_view.start[:-1]].tolist()
    first: dict[int, float] = {}
    for road, there in zip(road_map.roads, start, strict=True):
        if road.junction is not None:
            first.setdefault(road.junction, there)
    return np.array([first[junction.id] for junction in road_map.junctions])
