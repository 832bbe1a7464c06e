"""The steps of fetching an area in order: map, elevation models, list of sources.

Maps are written when their parts are joined, or cut out of an extract.
"""

from __future__ import annotations

import contextlib
import shutil
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import osmium

from osm2xodr import __version__
from osm2xodr.batching import bounds_of, cut_areas
from osm2xodr.errors import InputError, OptionError, OutputError
from osm2xodr.fetching.connection import Connection, check_address, is_address
from osm2xodr.fetching.downloads import Wanted, download
from osm2xodr.fetching.elevation import FetchedModel, dem_path, fetch_models, with_margin
from osm2xodr.fetching.models import ElevationModel, choose_models, read_models
from osm2xodr.fetching.options import FetchOptions
from osm2xodr.fetching.overpass import data_date, fetch_parts, forget, read_through, servers_of
from osm2xodr.fetching.place import Box, Place, find_place
from osm2xodr.osmParsing import close_writer, handle, open_osm_file, readable
from osm2xodr.system import lock, make_folder, record, stream_to

_OSM_LICENCE = "Open Database License (ODbL) 1.0, <https://www.openstreetmap.org/copyright>"
_OSM_ATTRIBUTION = "© OpenStreetMap contributors"

# Versions are kept, names of mappers and dates of their changes are not.
_METADATA: Final = "add_metadata=version"
_TIMESTAMP: Final = "osmosis_replication_timestamp"


def sources_text(place: Place, osm: FetchedMap | None, models: Sequence[FetchedModel]) -> str:
    """Return the list of sources, in Markdown."""
    return "\n".join(_lines(place, osm, models)) + "\n"


def _lines(place: Place, osm: FetchedMap | None, models: Sequence[FetchedModel]) -> Iterator[str]:
    west, south, east, north = place.box
    today = time.strftime("%Y-%m-%d", time.gmtime())
    yield "# Sources"
    yield ""
    yield f"Fetched on {today} by osm2xodr {__version__} for {place.text}: {south:.5f} to {north:.5f} N,"
    yield f"{west:.5f} to {east:.5f} E. Ways are kept whole, so some reach beyond."
    yield ""
    yield "| file | what it is | licence | attribution |"
    yield "|---|---|---|---|"
    if osm is not None:
        date = f", data of {osm.date}" if osm.date else ", date of the data not stated"
        yield _row(osm.path.name, f"OpenStreetMap, from {osm.source}{date}", _OSM_LICENCE, _OSM_ATTRIBUTION)
    for item in models:
        model = item.model
        kind = "digital surface model, with canopy and roofs" if model.covered else "digital terrain model"
        datum = f", heights above {model.datum}" if model.datum else ""
        page = f", <{model.page}>" if model.page else ""
        for path in item.paths:
            text = f"{model.title}, {kind}, cells of about {model.cell:g} m as published{datum}{page}"
            yield _row(path.name, text, model.licence, model.attribution)
    for item in models:
        yield ""
        yield f"Files of {item.model.title} that this was cut out of:"
        yield ""
        yield from (f"- <{url}>" for url in item.urls)
    if osm is not None:
        yield ""
        yield f"A road network made from `{osm.path.name}` is a derivative database: whoever passes it on names"
        yield "OpenStreetMap and keeps the ODbL. The converter writes this attribution, and those of elevation"
        yield "models, into the file's header."


def _row(*cells: str) -> str:
    name, *others = (cell.replace("|", "\\|").replace("\n", " ") for cell in cells)
    return f"| `{name}` | {' | '.join(others)} |"


# ---------------------------------------------------------------- the area

_SOURCES = "SOURCES.md"


@record
class FetchedArea:
    """What was written."""

    osm: FetchedMap | None
    models: tuple[FetchedModel, ...]
    sources: Path  # The list of sources

    @property
    def dems(self) -> tuple[Path, ...]:
        """The elevation models, the preferred one first."""
        return tuple(path for item in self.models for path in item.paths)


def fetch_area(place: Place | str, options: FetchOptions) -> FetchedArea:
    """Write a map and elevation models of an area, and the list of their sources.

    A text is the name of a place, for which the geocoder is asked.

    Each file is there as a whole or not at all. What was received is kept in the cache, so that a fetch that ended
    before it was done goes on when it is started again.

    Raises
    ------
    OptionError
        An address or the name of a model is wrong.
    InputError
        There is no such place, the area has no roads or is too large, a file of the user's is wrong, or a map cannot
        be read.
    CoverageError
        There are no heights in the area.
    ServerError
        A server cannot be reached, or does not give what it was asked for.
    OutputError
        A file cannot be written, or exists.
    """
    if options.extract is not None and is_address(options.extract):
        check_address("extract", options.extract)
    if isinstance(place, str):
        check_address("geocoder", options.geocoder)
    for url in options.overpass if options.osm and options.extract is None else ():
        check_address("overpass", url)
    models = choose_models(options.models, read_models(options.model_files), options.model_url) if options.dem else []
    osm_path = options.out_dir / ("area.osm.pbf" if options.pbf else "area.osm")
    _check_outputs(options, osm_path)
    for folder in (options.out_dir, options.cache_dir):
        make_folder(folder)
    with _alone(options):
        return _fetch(place, options, models, osm_path)


@contextlib.contextmanager
def _alone(options: FetchOptions) -> Iterator[None]:
    """Wait for another fetch with the same cache: servers are asked by one at a time, and files grow by one."""
    try:
        with (options.cache_dir / "lock").open("ab") as held:
            if not lock(held.fileno(), wait=False):
                options.network.note("another fetch uses the cache; this one goes on when that has ended")
                lock(held.fileno(), wait=True)
            yield
    except PermissionError as error:
        raise OutputError(f"{options.cache_dir} cannot be written; choose another folder with --cache") from error


def _fetch(named: Place | str, options: FetchOptions, models: list[ElevationModel], osm_path: Path) -> FetchedArea:
    connection = Connection(options.network)
    place = find_place(connection, named, options) if isinstance(named, str) else named
    osm = None
    box = place.box
    if options.osm:
        with tempfile.TemporaryDirectory(prefix="work-", dir=options.cache_dir) as work:
            osm = fetch_map(connection, place, options, osm_path, Path(work))
        # Ways are whole, so that roads reach beyond the area.
        box = (
            min(box[0], osm.roads[0]),
            min(box[1], osm.roads[1]),
            max(box[2], osm.roads[2]),
            max(box[3], osm.roads[3]),
        )
    dems = fetch_models(connection, with_margin(box), models, options, options.out_dir) if models else []
    sources = options.out_dir / _SOURCES
    with stream_to(sources) as stream:
        stream.write(sources_text(place, osm, dems).encode("utf-8", "replace"))
    return FetchedArea(osm, tuple(dems), sources)


def _check_outputs(options: FetchOptions, osm_path: Path) -> None:
    """Refuse to replace files, or what is to be read, before any work is done."""
    targets = [options.out_dir / _SOURCES]
    if options.osm:
        targets.append(osm_path)
    if options.dem:
        targets.append(dem_path(options.out_dir, 1))
    for target in targets:
        if options.extract is not None and target.is_file() and not is_address(options.extract):
            extract = Path(options.extract)
            if extract.is_file() and target.samefile(extract):
                raise OptionError(f"extract {extract} would be replaced; choose another folder for output", "extract")
        if target.exists() and not options.overwrite:
            raise OutputError(f"{target} exists; give another folder with -o, or --overwrite to replace it")


@record
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
        return extract, _date_of(found), [_cut(found, place, work, extract, options)]
    except InputError:
        # It must not be taken for a good one the next time. Where there is only nothing in the area, it is one.
        if not _is_sound(found):
            found.unlink(missing_ok=True)
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
