"""The list of sources: where files are from, of when, under which licence, and what must be named."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence

from osm2xodr import __version__
from osm2xodr.fetching.elevation import FetchedModel
from osm2xodr.fetching.maps import FetchedMap
from osm2xodr.fetching.place import Place

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
