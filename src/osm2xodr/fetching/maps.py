"""Maps as they are written: several parts joined, or an area cut out of an extract."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import osmium

from osm2xodr.batching import bounds_of, cut_areas
from osm2xodr.errors import InputError, OutputError
from osm2xodr.fetching.addresses import is_address
from osm2xodr.fetching.connection import Connection
from osm2xodr.fetching.downloads import Wanted, download
from osm2xodr.fetching.options import FetchOptions
from osm2xodr.fetching.overpass import data_date, fetch_parts, forget, read_through, servers_of
from osm2xodr.fetching.place import Box, Place
from osm2xodr.osmParsing import close_writer, handle, open_osm_file, readable
from osm2xodr.system import stream_to

# Versions are kept, names of mappers and dates of their changes are not.
_METADATA: Final = "add_metadata=version"
_TIMESTAMP: Final = "osmosis_replication_timestamp"


@dataclass(frozen=True, slots=True)
class FetchedMap:
    """A map that was written."""

    path: Path
    source: str  # Where it is from: an address or a file
    date: str  # The time that its data is of; empty if unknown
    roads: Box  # Bounds of its ways for cars: west, south, east, north, degrees


def fetch_map(connection: Connection, place: Place, options: FetchOptions, target: Path, work: Path) -> FetchedMap:
    """Write the map of an area; `work` is a folder for what is needed meanwhile.

    Raises `InputError`, `OutputError` and `ServerError`.
    """
    if options.extract is not None:
        source, date, parts = _from_extract(connection, place, options, work)
        return _written(source, date, parts, place, target, work)
    answers = fetch_parts(connection, place.box, options)
    try:
        source, date, parts = _from_overpass(answers, place, options, work)
        return _written(source, date, parts, place, target, work)
    except InputError:
        # The next time the servers may know better.
        forget(answers)
        raise


def _written(source: str, date: str, parts: Sequence[Path], place: Place, target: Path, work: Path) -> FetchedMap:
    """Write a map from its parts."""
    written = work / f"written{''.join(target.suffixes)}"
    _write(parts, written, place.box)
    try:
        roads = bounds_of(written)
    except InputError:
        raise InputError(f"{source} has no way that cars can drive on in {place.text}; choose another area") from None
    with written.open("rb") as read, stream_to(target) as stream:
        shutil.copyfileobj(read, stream)
    return FetchedMap(target, source, date, roads)


def _from_overpass(parts: list[Path], place: Place, options: FetchOptions, work: Path) -> tuple[str, str, list[Path]]:
    dates = [date for part in parts if (date := data_date(part))]
    source = ", ".join(["Overpass API", *servers_of(parts)])
    if place.rings:
        joined = work / "joined.osm.pbf"
        _write(parts, joined, place.box)
        parts = [_cut(joined, place, work, source, options)]
    return source, min(dates, default=""), parts


def _from_extract(
    connection: Connection, place: Place, options: FetchOptions, work: Path
) -> tuple[str, str, list[Path]]:
    extract = options.extract or ""
    if not is_address(extract):
        path = Path(extract)
        return extract, _date_of(path), [_cut(path, place, work, extract, options)]
    wanted = Wanted(extract, "--extract", "OSM data", _is_map)
    found = download(connection, wanted, options.cache_dir / "extracts", options.age)
    connection.network.progress("cutting the area out")
    try:
        return extract, _date_of(found.path), [_cut(found.path, place, work, extract, options)]
    except InputError:
        # It must not be taken for a good one the next time. Where there is only nothing in the area, it is one.
        if not _is_sound(found.path):
            found.path.unlink(missing_ok=True)
        raise


def _cut(path: Path, place: Place, work: Path, source: str, options: FetchOptions) -> Path:
    """Cut the area out of a map."""
    target = work / "cut.osm.pbf"
    request = replace(
        place.cut_request(target), surroundings=options.surroundings, allow_partial=options.allow_partial
    )
    if not cut_areas(path, [request])[request.name]:
        raise InputError(f"{source} has no way that cars can drive on in {place.text}; choose another area")
    return target


def _is_map(head: bytes) -> bool:
    """Whether a file begins like a map."""
    if b"OSMHeader" in head[:64] or head.startswith((b"\x1f\x8b", b"BZh")):
        return True
    return b"<osm" in head


def _is_sound(path: Path) -> bool:
    """Whether a map can be read to its end."""
    try:
        bounds_of(path)
    except InputError:
        try:
            read_through(path)
        except InputError:
            return False
    return True


def _date_of(path: Path) -> str:
    """Return the time that the data of a map is of; empty if it does not say."""
    file = open_osm_file(path)
    with readable(file):
        reader: Any = osmium.io.Reader(handle(file), osmium.osm.NOTHING)
        try:
            return str(reader.header().get(_TIMESTAMP, ""))
        finally:
            reader.close()


def _write(parts: Sequence[Path], target: Path, box: Box) -> None:
    """Join maps: of elements in several of them the newest version is taken."""
    merged: Any = osmium.MergeInputReader()
    for part in parts:
        with readable(open_osm_file(part)):
            merged.add_file(str(part.absolute()))
    header = osmium.io.Header()
    header.set("generator", "osm2xodr")
    west, south, east, north = box
    header.add_box(osmium.osm.Box(west, south, east, north))
    kind = "pbf" if target.suffix == ".pbf" else "osm"
    file = osmium.io.File(str(target.absolute()), f"{kind},{_METADATA}")
    try:
        writer = osmium.SimpleWriter(file, header=header, overwrite=True)
        try:
            merged.apply(writer, simplify=True)
        finally:
            close_writer(writer)
    except (RuntimeError, OSError) as error:
        raise OutputError(
            f"{target} cannot be written ({error}); free some space, or choose another folder with --cache"
        ) from error
