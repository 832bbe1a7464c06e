"""Cuts areas out of a map: complete ways, what stands beside them, and all that shapes roads at the borders.

A map is read once for all areas, in a few passes, and then once for every `_OPEN_MAX` files that are written.

Cuts are written as OSM files, many in one pass over the map.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import lru_cache
from itertools import count
from pathlib import Path
from typing import Any, Final

import numpy as np
import osmium

from osm2xodr import projection
from osm2xodr.batching.cutting.choice import Choice, choose, make_plan
from osm2xodr.batching.cutting.source import (
    Driven,
    Source,
    nodes_of,
    read_source,
    ways_and_relations_of,
    without_roads,
)
from osm2xodr.batching.model import CutRequest
from osm2xodr.curves import repeated, unique_first
from osm2xodr.errors import InputError, OutputError, SwappedAxesError
from osm2xodr.model import IntArray
from osm2xodr.osmParsing import DRIVABLE, close_writer, open_osm_file, readable
from osm2xodr.system import record

# Files that are open at a time; systems allow a process 256 or more.
_OPEN_MAX: Final = 200
# All ways that a car fits on.
_CARS: Final = Driven()
# Without the names of mappers and the dates of their changes, which nobody needs.
_FORMAT: Final = "pbf,add_metadata=false"
# Size of the buffer of a file, bytes: a few thousand nodes.
_BUFFER: Final = 1 << 18


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


@record
class Target:
    """A file to write."""

    path: Path
    choice: Choice  # Its contents

    @property
    def part(self) -> Path:
        """Its name until it is complete."""
        return self.path.with_name(f"{self.path.name}.part")


class _Users:
    """The targets of each element, asked for in the order of the elements' keys.

    `wanted` are the keys of the elements of each target, ascending.
    """

    def __init__(self, wanted: Sequence[IntArray]) -> None:
        key = np.concatenate([np.zeros(0, np.int64), *wanted])
        target = repeated([len(one) for one in wanted])
        order = np.argsort(key, kind="stable")
        self.keys, first = unique_first(key[order])
        # Memory views give Python's own numbers, several times faster than arrays do.
        self._keys: Any = np.ascontiguousarray(self.keys).data
        self._first: Any = np.append(first, len(key)).astype(np.int64).data
        self._targets: Any = np.ascontiguousarray(target[order]).data
        self._at = 0
        self._next: int | None = self._keys[0] if len(self.keys) else None

    @property
    def complete(self) -> bool:
        """Whether all elements of all targets have come."""
        return self._next is None

    def take(self, key: int) -> Sequence[int]:
        """Return the targets of an element."""
        if key != self._next:
            return ()
        at = self._at
        self._at = at + 1
        self._next = self._keys[at + 1] if at + 1 < len(self._keys) else None
        found: Sequence[int] = self._targets[self._first[at] : self._first[at + 1]]
        return found


def write_targets(source: Source, targets: Sequence[Target]) -> None:
    """Write files in one pass over the map; they get their names when they are complete."""
    try:
        _write_parts(source, targets)
        for target in targets:
            with _writable(target):
                if not source.in_order:
                    _sort(target)
                os.replace(target.part, target.path)
    finally:
        for target in targets:
            with suppress(OSError):
                target.part.unlink(missing_ok=True)


def _write_parts(source: Source, targets: Sequence[Target]) -> None:
    by_id = not len(source.node_at)
    place = source.node_ids if by_id else source.node_at
    nodes = _Users([np.sort(place[target.choice.nodes]) for target in targets])
    ways = _Users([target.choice.ways for target in targets])
    # Conversions read nothing of these.
    corners = _Users([np.sort(place[target.choice.more_nodes]) for target in targets])
    outlines = _Users([target.choice.more_ways for target in targets])
    relations = _Users([target.choice.relations for target in targets])
    writers: list[Any] = []
    # All are closed, also where one of them cannot be.
    with ExitStack() as opened:
        for target in targets:
            with _writable(target):
                writer = _open(target)
            opened.callback(_close, target, writer)
            writers.append(writer)
        with readable(source.file):
            # Where ids do not identify nodes, their position in the file does.
            wanted = np.union1d(nodes.keys, corners.keys) if by_id else source.node_ids
            for number, node in enumerate(nodes_of(source.file, wanted)):
                key = node.id if by_id else number
                if users := nodes.take(key):
                    _add(node, users, targets, writers)
                if users := corners.take(key):
                    _add(node.replace(tags={}), users, targets, writers)
            way_places, relation_places = count(), count()
            for item, _ in ways_and_relations_of(source.file, source.outlines):
                key = next(way_places if item.is_way() else relation_places)
                if users := (ways if item.is_way() else relations).take(key):
                    _add(item, users, targets, writers)
                if item.is_way() and (users := outlines.take(key)):
                    _add(item.replace(tags=without_roads(item.tags)), users, targets, writers)
        if not all(users.complete for users in (nodes, ways, relations, corners, outlines)):
            raise InputError(f"{source.file.path} has changed while it was read; start again")


def _close(target: Target, writer: Any) -> None:
    with _writable(target):
        close_writer(writer)


def _add(item: Any, users: Sequence[int], targets: Sequence[Target], writers: Sequence[Any]) -> None:
    for index in users:
        try:
            writers[index].add(item)
        except (RuntimeError, OSError) as error:
            raise _problem(targets[index], error) from error


def _open(target: Target) -> Any:
    header = osmium.io.Header()
    header.set("generator", "osm2xodr")
    header.set("sorting", "Type_then_ID")
    west, south, east, north = target.choice.bounds_deg
    # A box across the 180th meridian could not be told from one round the Earth.
    header.add_box(osmium.osm.Box(max(west, -180.0), south, min(east, 180.0), north))
    file = osmium.io.File(os.path.abspath(target.part), _FORMAT)
    return osmium.SimpleWriter(file, bufsz=_BUFFER, header=header, overwrite=True)


def _sort(target: Target) -> None:
    """Bring a file into the order of ids."""
    merged = osmium.MergeInputReader()
    merged.add_buffer(target.part.read_bytes(), "pbf")
    target.part.unlink()
    writer = _open(target)
    try:
        merged.apply(writer, simplify=False)
    finally:
        close_writer(writer)


@contextmanager
def _writable(target: Target) -> Iterator[None]:
    """Turn the errors of osmium about a file that it writes into one sentence."""
    try:
        yield
    except (RuntimeError, OSError) as error:
        raise _problem(target, error) from error


def _problem(target: Target, error: RuntimeError | OSError) -> OutputError:
    cause = (error.strerror if isinstance(error, OSError) else None) or str(error)
    return OutputError(f"{target.path} cannot be written ({cause}); check the folder and the room on the disk")
