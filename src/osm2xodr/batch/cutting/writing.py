"""Writes cuts as OSM files, many in one pass over the map."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any, Final

import numpy as np
import osmium

from osm2xodr.batch.cutting.choice import Choice
from osm2xodr.batch.cutting.source import Source, nodes_of, ways_and_relations_of, without_roads
from osm2xodr.curves import repeated, unique_first
from osm2xodr.errors import InputError, OutputError
from osm2xodr.model import IntArray
from osm2xodr.osmParsing import close_writer, readable

# Without the names of mappers and the dates of their changes, which nobody needs.
_FORMAT: Final = "pbf,add_metadata=false"
# Size of the buffer of a file, bytes: a few thousand nodes.
_BUFFER: Final = 1 << 18


@dataclass(frozen=True, slots=True)
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
