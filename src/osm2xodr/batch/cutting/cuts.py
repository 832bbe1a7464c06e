"""Cuts areas out of a map: complete ways, what stands beside them, and the relations about them.

A map is read once for all areas, in a few passes, and then once for every `_OPEN_MAX` files that are written.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Final

import numpy as np

from osm2xodr import projection
from osm2xodr.batch.cutting.choice import choose, make_plan
from osm2xodr.batch.cutting.source import Driven, Source, read_source
from osm2xodr.batch.cutting.writing import Target, write_targets
from osm2xodr.batch.model import CutRequest
from osm2xodr.errors import InputError, SwappedAxesError
from osm2xodr.osmParsing import DRIVABLE, open_osm_file

# Files that are open at a time; systems allow a process 256 or more.
_OPEN_MAX: Final = 200
# All ways that a car fits on.
_CARS: Final = Driven()


def cut_areas(
    source: Path, requests: Sequence[CutRequest], written: Callable[[Mapping[str, int]], object] | None = None
) -> dict[str, int]:
    """Write parts of a map, and return the number of ways that become streets in each area, by name.

    Areas are the requests, or their parts where they have some.
    `written` is called with the same of each group of areas, as soon as their files are complete.

    A cut has all that a conversion reads, with all tags: ways of any ``highway`` and what stands beside streets, if
    a node or a segment of them lies in the area, with all their nodes; nodes that mean something by themselves; turn
    restrictions and lane connectivities about any of these ways, with all ways that they name. Where no way becomes a
    street no file is written, and an old one is removed.

    With a context it also has what is near the area, whole streets that come near it, and what lies beside them and
    around their ends (`choice` says how near): all that shapes a road across a border is the same on both sides.

    With surroundings it also has the buildings and the water in the rectangle around the area, of multipolygons the
    ways that come within `OUTLINE_REACH` of it. A conversion reads the same with and without them.

    Raises
    ------
    InputError
        The map cannot be read; its server says that it is not whole, and not all requests allow that.
    SwappedAxesError
        A part lies beside the map, and would not with longitude and latitude swapped.
    OutputError
        A cut cannot be written.
    """
    driven = [Driven(request.ways, request.include_private, request.kept) for request in requests]
    surroundings = any(request.surroundings for request in requests)
    allow_partial = all(request.allow_partial for request in requests)
    found = _read(source, driven, surroundings=surroundings, allow_partial=allow_partial)
    _read_once.cache_clear()
    plan = make_plan(found, context=any(request.context for request in requests))
    counts: dict[str, int] = {}
    group: list[Target] = []
    pending: dict[str, int] = {}

    def write() -> None:
        if group:
            write_targets(plan.source, group)
        if written is not None:
            written(pending)
        counts.update(pending)
        group.clear()
        pending.clear()

    for request, streets in zip(requests, driven, strict=True):
        choice = choose(plan, request, streets)
        pending.update(choice.driven)
        if any(choice.driven.values()):
            group.append(Target(request.target, choice))
        else:
            _refuse_swapped(plan.source, request, choice.bounds_deg)
            request.target.unlink(missing_ok=True)
        if len(group) == _OPEN_MAX:
            write()
    write()
    return counts


def _refuse_swapped(source: Source, request: CutRequest, bounds: tuple[float, float, float, float]) -> None:
    """Raise `SwappedAxesError` if an area lies beside the map, but not with longitude and latitude swapped."""
    if not len(source.node_ids):
        return
    lon, lat = source.degrees()
    west, south, east, north = lon.min(), lat.min(), lon.max(), lat.max()

    def meets(one: tuple[float, float, float, float]) -> bool:
        return bool(one[0] <= east and one[2] >= west and one[1] <= north and one[3] >= south)

    x_0, y_0, x_1, y_1 = bounds
    if not meets(bounds) and meets((y_0, x_0, y_1, x_1)):
        box = f"{west:.4g},{south:.4g},{east:.4g},{north:.4g}"
        raise SwappedAxesError(
            f"{request.where or request.name}: it lies beside {source.file.path} ({box}), and in it with longitude"
            " and latitude swapped; give longitudes first: west, south, east, north"
        )


def bounds_of(source: Path) -> tuple[float, float, float, float]:
    """Return west, south, east, north of all ways for cars, degrees; east is above 180 across the antimeridian.

    Raises
    ------
    InputError
        The map cannot be read, or there is nothing to drive on.
    """
    # What is cut out of a map mostly becomes streets by the same tags, so that it need not be read again.
    found = _read(source, [Driven(DRIVABLE)])
    nodes = found.row[np.repeat(found.driven[_CARS], np.diff(found.first))]
    if not len(nodes):
        raise InputError(f"{source} has no way that cars can drive on; check the area that it covers")
    return projection.bounds_deg(*found.degrees(nodes))


def _read(
    source: Path, driven: Sequence[Driven], *, surroundings: bool = False, allow_partial: bool = True
) -> Source:
    """Return what `read_source` does of a map, and which ways cars fit on."""
    # Reading says what is wrong where there is no file.
    known = source.stat() if source.is_file() else None
    stamp = None if known is None else (known.st_size, known.st_mtime_ns)
    found = _read_once(source, stamp, tuple(dict.fromkeys([_CARS, *driven])), surroundings)
    found.file.require_whole(allow_partial)
    return found


@lru_cache(maxsize=1)
def _read_once(source: Path, stamp: tuple[int, int] | None, driven: tuple[Driven, ...], surroundings: bool) -> Source:
    """Read a map; `stamp` says when it is another one."""
    return read_source(open_osm_file(source), driven, surroundings=surroundings)
