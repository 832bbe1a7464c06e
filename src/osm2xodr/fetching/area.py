"""The steps of fetching an area in order: map, elevation models, list of sources."""

from __future__ import annotations

import contextlib
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from osm2xodr import __version__
from osm2xodr.errors import OptionError, OutputError
from osm2xodr.fetching.addresses import check_address, is_address
from osm2xodr.fetching.connection import Connection
from osm2xodr.fetching.elevation import FetchedModel, dem_path, fetch_models, with_margin
from osm2xodr.fetching.geocoding import find_place
from osm2xodr.fetching.maps import FetchedMap, fetch_map
from osm2xodr.fetching.models import ElevationModel, choose_models, read_models
from osm2xodr.fetching.options import FetchOptions
from osm2xodr.fetching.place import Place
from osm2xodr.system import lock, make_folder, stream_to

_OSM_LICENCE = "Open Database License (ODbL) 1.0, <https://www.openstreetmap.org/copyright>"
_OSM_ATTRIBUTION = "© OpenStreetMap contributors"


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


@dataclass(frozen=True, slots=True)
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
