"""The page about many areas: a map, the failures, a table.

Scripts sort, filter and zoom; where they are forbidden, as in archives of some build servers, the rest still works.
"""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Callable, Iterator, Sequence
from html import escape
from types import MappingProxyType
from typing import Final
from urllib.parse import quote

from osm2xodr import __version__
from osm2xodr.batching.index.area_rows import AreaRow, Figures, one_line
from osm2xodr.batching.index.map import Map, Shape, make_map, number
from osm2xodr.batching.model import Status
from osm2xodr.diagnostics import Kind, counted
from osm2xodr.viewing import facts, filled, package_text, page_html

# Statuses, the most important first, and what each means for areas.
_STATUSES: Final = MappingProxyType(
    {
        Status.FAILED: "could not be converted",
        Status.EMPTY: "contain no road for cars",
        Status.DONE: "converted in this run",
        Status.UNCHANGED: "kept from before: neither input nor version changed",
    }
)
_LINKS: Final = MappingProxyType({".xodr": "xodr", ".json": "report", ".html": "page"})


def _count(kind: Kind) -> Callable[[Figures], float]:
    return lambda figures: figures.counts[kind]


# Columns from the report, after name, status and files: heading, meaning, unit, figure, its factor and decimals.
# index.js knows their number, too.
_FIGURES: Final[tuple[tuple[str, str, str, Callable[[Figures], float | None], float, int], ...]] = (
    ("Roads", "length of reference lines outside of junctions", "km", lambda found: found.road_length, 1e-3, 2),
    ("Roads", "number of roads outside of junctions", "", lambda found: found.roads, 1.0, 0),
    ("Junctions", "number of junctions", "", lambda found: found.junctions, 1.0, 0),
    ("DEM", "share of the roads with a measured height", "%", lambda found: found.dem_coverage, 100.0, 1),
    ("Lowest", "lowest height of a road", "m", lambda found: found.lowest, 1.0, 1),
    ("Highest", "highest height of a road", "m", lambda found: found.highest, 1.0, 1),
    ("Steepest", "largest grade", "%", lambda found: found.grade, 100.0, 1),
    ("Guessed", "number of values that are missing in OpenStreetMap", "", _count(Kind.GUESSED), 1.0, 0),
    ("Dropped", "number of things that were left out", "", _count(Kind.DROPPED), 1.0, 0),
    ("Repaired", "number of contradictions that were resolved", "", _count(Kind.REPAIRED), 1.0, 0),
    ("Notes", "number of further remarks", "", _count(Kind.NOTE), 1.0, 0),
    ("Size", "size of the road network's file", "MB", lambda found: found.size, 1e-6, 2),
)
# Columns about the run: heading, meaning, unit.
_SPENT: Final = (
    ("Time", "time of the conversion in this run", "s"),
    ("Memory", "peak memory of the conversion in this run", "MB"),
)
# Marks the page before the table is read, so that rows far down are laid out only when they come into view.
_EARLY_SCRIPT: Final = 'document.documentElement.className = "scripted";'
# An area smaller than this on the map gets a symbol, units: a hundredth of the map's width is hard to see.
_SYMBOL_BELOW: Final = 9.0
# Durations are given in seconds, and in minutes, up to this many.
_MOST_SECONDS: Final = 120.0
_MOST_MINUTES: Final = 120


def make_index(rows: Sequence[AreaRow]) -> bytes:
    """Return the page, UTF-8; the same rows, in order of names, give the same bytes."""
    order = {status: place for place, status in enumerate(_STATUSES)}
    rows = sorted(rows, key=lambda row: (order[row.result.status], _natural(row.name)))
    chart = make_map([row.result.outline_deg for row in rows])
    count = counted(len(rows), "area")
    parts = {
        "version": escape(__version__),
        "count": count,
        "statuses": "".join(_status(rows, status) for status in _STATUSES),
        "figures": facts(_totals(rows)),
        "failures": _failures(rows),
        "map": _map(rows, chart),
        "nowhere": "" if any(chart.shapes) else ' class="nowhere"',
        "unplaced": _unplaced(chart),
        "headings": "".join(_heading(*column) for column in (*(figure[:3] for figure in _FIGURES), *_SPENT)),
        "rows": "\n".join(_row(place, row) for place, row in enumerate(rows)),
    }
    return page_html(
        f"osm2xodr: {count}",
        filled(_text("index.html"), parts),
        _text("index.css"),
        scripts=[_text("index.js")],
        early_script=_EARLY_SCRIPT,
    )


def _natural(name: str) -> tuple[list[tuple[int, str]], str]:
    """Return the sort key of a name: numbers in it count by their value."""
    words = re.findall(r"[0-9]+|[^0-9]+", name.casefold())
    return [(int(word[:99]), "") if word[0] in "0123456789" else (-1, word) for word in words], name


def _status(rows: Sequence[AreaRow], status: Status) -> str:
    """Return the button of a status, which shows its symbol and the number of its areas."""
    areas = sum(row.result.status is status for row in rows)
    word, meaning = status.value, _STATUSES[status]
    return (
        f'<button type="button" class="{word}" data-status="{word}" aria-pressed="false"'
        f' title="{areas:,} {meaning}">'
        '<svg class="swatch" viewBox="0 0 46 22" aria-hidden="true"><path class="shape" d="M1 1H27V21H1Z"/>'
        f'<use href="#s-{word}" x="38" y="11"/></svg><b>{areas:,}</b> {word}</button>'
    )


def _totals(rows: Sequence[AreaRow]) -> Iterator[tuple[str, str]]:
    """Yield names and values of figures about all areas."""
    known = [row.figures for row in rows if row.figures is not None]
    yield "km of road", f"{sum(figures.road_length or 0.0 for figures in known) / 1000.0:,.1f}"
    yield "roads", f"{sum(figures.roads or 0.0 for figures in known):,.0f}"
    yield "junctions", f"{sum(figures.junctions or 0.0 for figures in known):,.0f}"
    yield "MB of OpenDRIVE", f"{sum(figures.size or 0.0 for figures in known) / 1e6:,.1f}"
    yield "of conversions", _duration(sum(row.result.seconds for row in rows))
    yield "most memory", f"{max((row.result.memory for row in rows), default=0) / 1e6:,.0f} MB"


def _duration(seconds: float) -> str:
    """Return a duration in words."""
    if seconds < _MOST_SECONDS:
        return f"{seconds:.1f} s"
    minutes = round(seconds / 60.0)
    return f"{minutes} min" if minutes < _MOST_MINUTES else f"{minutes // 60:,} h {minutes % 60} min"


def _failures(rows: Sequence[AreaRow]) -> str:
    """Return the list of areas that failed, each with its message."""
    items = [
        f'<li><a href="#a{place}"><bdi>{escape(row.name)}</bdi></a> <span>{escape(row.message)}</span></li>'
        for place, row in enumerate(rows)
        if row.result.status is Status.FAILED
    ]
    if not items:
        return ""
    head = f'<section id="failures" aria-label="Failed"><h2>{len(items):,} failed</h2>'
    return f"{head}<ul>{''.join(items)}</ul></section>"


def _unplaced(chart: Map) -> str:
    """Return a sentence on areas that are not on the map."""
    missing = sum(shape is None for shape in chart.shapes)
    number_is = f"{missing:,} of {len(chart.shapes):,} areas {'is' if missing == 1 else 'are'}"
    return f"{number_is} of unknown place, and not on the map." if missing else ""


def _map(rows: Sequence[AreaRow], chart: Map) -> str:
    """Return the map; areas that failed are drawn last."""
    shapes = enumerate(zip(rows, chart.shapes, strict=True))
    drawn = [_area(place, row, shape) for place, (row, shape) in shapes if shape]
    data = f'data-unit="{chart.unit:.9g}" data-left="{chart.left:.9g}" data-top="{chart.top:.9g}"'
    box = f"0 0 {number(chart.width)} {number(chart.height)}"
    head = f'<svg id="map" viewBox="{box}" {data} role="group" aria-labelledby="map-help"><g id="grid"></g>'
    return f'{head}{"".join(reversed(drawn))}<g id="labels"></g></svg>'


def _area(place: int, row: AreaRow, shape: Shape) -> str:
    """Return an area of the map, a link to its row."""
    word = row.result.status.value
    outline = f'<path class="shape" d="{shape.path}"/>' if shape.path else ""
    small = not shape.path or max(shape.width, shape.height) < _SYMBOL_BELOW
    symbol = ""
    if small or row.result.status is Status.FAILED:
        at = f"translate({number(shape.x)} {number(shape.y)})"
        symbol = f'<g transform="{at}"><use class="sign" href="#s-{word}"/></g>'
    return (
        f'<a id="m{place}" class="{word}" href="#a{place}" tabindex="-1">'
        f"<title>{escape(row.name)}: {word}</title>{outline}{symbol}</a>"
    )


def _heading(name: str, meaning: str, unit: str) -> str:
    label = f"{name} <small>{unit}</small>" if unit else name
    return f'<th scope="col" class="n" title="{name}: {meaning}"><button type="button">{label}</button></th>'


def _row(place: int, row: AreaRow) -> str:
    """Return the row of an area; if it has no figures, a message takes their place."""
    word = row.result.status.value
    links = _links(row)
    if row.figures is None or row.message:
        cells = f'<td colspan="{1 + len(_FIGURES)}">{links} {escape(row.message)}</td>'
    else:
        cells = f"<td>{links}</td>" + "".join(f"<td>{cell}</td>" for cell in _figures(row.figures))
    seconds, memory = row.result.seconds, row.result.memory
    spent = (f"{seconds:,.1f}" if seconds > 0.0 else "", f"{memory / 1e6:,.0f}" if memory > 0 else "")
    return (
        f'<tr id="a{place}" class="{word}"><th scope="row">{_thumbnail(row)}<bdi>{escape(row.name)}</bdi></th>'
        f"<td>{word}</td>{cells}<td>{spent[0]}</td><td>{spent[1]}</td></tr>"
    )


def _thumbnail(row: AreaRow) -> str:
    """Return the picture of an area, which says nothing that the row does not."""
    if not row.thumbnail:
        return ""
    return f'<img class="thumb" alt="" src="data:image/png;base64,{b64encode(row.thumbnail).decode("ascii")}">'


def _links(row: AreaRow) -> str:
    """Return links to the files of an area, which lie beside the page."""
    return " ".join(
        f'<a href="./{quote(row.files[suffix].encode("utf-8", "surrogateescape"), safe="")}"'
        f' aria-label="{word} of {escape(one_line(row.name))}">{word}</a>'
        for suffix, word in _LINKS.items()
        if suffix in row.files
    )


def _figures(figures: Figures) -> Iterator[str]:
    """Yield the cells about the road network."""
    for *_, get, factor, decimals in _FIGURES:
        value = get(figures)
        yield "" if value is None else f"{value * factor:,.{decimals}f}"


def _text(name: str) -> str:
    """Return a file of the template."""
    return package_text("osm2xodr.batching.index", f"template/{name}")
