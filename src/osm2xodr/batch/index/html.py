"""The page about many areas: a map, failures, a table; one file of HTML that needs neither a network nor scripts.

Scripts sort, filter and zoom; where they are forbidden, as in the archives of some build servers, all else works.
"""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Iterator, Sequence
from html import escape
from importlib.resources import files
from types import MappingProxyType
from typing import Final
from urllib.parse import quote

from osm2xodr import __version__
from osm2xodr.batch.index.area_rows import AreaRow, Figures, one_line
from osm2xodr.batch.index.map import Map, Shape, make_map, number
from osm2xodr.batch.model import Status
from osm2xodr.diagnostics import Kind, counted

# Statuses, the most interesting first, and what each means.
_STATUSES: Final = MappingProxyType(
    {
        Status.FAILED: "could not be converted",
        Status.EMPTY: "hold nothing to drive on",
        Status.DONE: "converted in this run",
        Status.UNCHANGED: "left as they were: neither input nor version changed",
    }
)
_LINKS: Final = MappingProxyType({".xodr": "xodr", ".json": "report", ".html": "page"})
# Columns after name, status and files: heading, meaning, unit.
_HEADINGS: Final = (
    ("Roads", "length of reference lines outside of junctions", "km"),
    ("Roads", "number of roads outside of junctions", ""),
    ("Junctions", "number of junctions", ""),
    ("DEM", "share of the streets whose height is measured", "%"),
    ("Lowest", "least height of a road", "m"),
    ("Highest", "greatest height of a road", "m"),
    ("Steepest", "largest grade", "%"),
    ("Guessed", "number of values that OpenStreetMap does not give", ""),
    ("Dropped", "number of things that are left out", ""),
    ("Repaired", "number of contradictions that were resolved", ""),
    ("Notes", "number of further remarks", ""),
    ("Size", "of the road network's file", "MB"),
    ("Time", "of the conversion in this run", "s"),
    ("Memory", "most that the conversion took in this run", "MB"),
)
# Number of columns whose figures come from the report.
_FIGURES: Final = 12
# Runs before the table is read: with scripts, rows far down are laid out only when they are scrolled into view.
_EARLY: Final = 'document.documentElement.className = "scripted";'
# An area smaller than this on the whole map gets a symbol, units: a hundredth of the map's width is hard to see.
_SMALL: Final = 9.0


def make_index(rows: Sequence[AreaRow]) -> bytes:
    """Return the page, UTF-8; the same rows give the same bytes."""
    order = {status: place for place, status in enumerate(_STATUSES)}
    rows = sorted(rows, key=lambda row: (order[row.result.status], _natural(row.name)))
    chart = make_map([row.result.outline_deg for row in rows])
    script, style = _part("index.js"), _part("index.css")
    parts = {
        "policy": f"default-src 'none'; script-src {_hash(_EARLY)} {_hash(script)}; style-src {_hash(style)};"
        " img-src data:; base-uri 'none'; form-action 'none'",
        "style": style,
        "script": script,
        "early": _EARLY,
        "version": escape(__version__),
        "count": counted(len(rows), "area"),
        "statuses": "".join(_status(rows, status) for status in _STATUSES),
        "figures": "".join(f"<div><dt>{name}</dt><dd>{value}</dd></div>" for name, value in _totals(rows)),
        "failures": _failures(rows),
        "map": _map(rows, chart),
        "nowhere": "" if any(chart.shapes) else ' class="nowhere"',
        "unplaced": _unplaced(chart),
        "headings": "".join(_heading(*heading) for heading in _HEADINGS),
        "rows": "\n".join(_row(place, row) for place, row in enumerate(rows)),
    }
    page = re.sub(r"@([a-z]+)@", lambda match: parts[match.group(1)], _part("index.html"))
    return page.encode("utf-8", "replace")


def _natural(name: str) -> tuple[list[tuple[int, str]], str]:
    """Return the key that sorts names with numbers in them by value."""
    words = re.findall(r"[0-9]+|[^0-9]+", name.casefold())
    return [(int(word[:99]), "") if word[0] in "0123456789" else (-1, word) for word in words], name


def _status(rows: Sequence[AreaRow], status: Status) -> str:
    """Return the button of a status, with its pattern and the number of its areas."""
    number_of = sum(row.result.status is status for row in rows)
    word, meaning = status.value, _STATUSES[status]
    return (
        f'<button type="button" class="{word}" data-status="{word}" aria-pressed="false"'
        f' title="{number_of:,} {meaning}">'
        '<svg class="swatch" viewBox="0 0 46 22" aria-hidden="true"><path class="shape" d="M1 1H27V21H1Z"/>'
        f'<use href="#s-{word}" x="38" y="11"/></svg><b>{number_of:,}</b> {word}</button>'
    )


def _totals(rows: Sequence[AreaRow]) -> Iterator[tuple[str, str]]:
    """Yield names and values of the figures about all areas."""
    known = [row.figures for row in rows if row.figures is not None]
    yield "km of road", f"{sum(figures.road_length or 0.0 for figures in known) / 1000.0:,.1f}"
    yield "roads", f"{sum(figures.roads or 0.0 for figures in known):,.0f}"
    yield "junctions", f"{sum(figures.junctions or 0.0 for figures in known):,.0f}"
    yield "MB of OpenDRIVE", f"{sum(figures.size or 0.0 for figures in known) / 1e6:,.1f}"
    yield "of conversions", _duration(sum(row.result.seconds for row in rows))
    yield "most memory", f"{max((row.result.memory for row in rows), default=0) / 1e6:,.0f} MB"


def _duration(seconds: float) -> str:
    """Return a duration as text."""
    if seconds < 120.0:
        return f"{seconds:.1f} s"
    minutes = round(seconds / 60.0)
    return f"{minutes} min" if minutes < 120 else f"{minutes // 60:,} h {minutes % 60} min"


def _failures(rows: Sequence[AreaRow]) -> str:
    """Return the list of areas that failed, each with its sentence."""
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
    """Return a sentence about areas that are not on the map."""
    missing = sum(shape is None for shape in chart.shapes)
    verb = "is" if missing == 1 else "are"
    return (
        f"{missing:,} of {len(chart.shapes):,} areas {verb} of unknown place, and not on the map." if missing else ""
    )


def _map(rows: Sequence[AreaRow], chart: Map) -> str:
    """Return the map, with the areas that failed on top."""
    drawn = [
        _area(place, row, shape) for place, (row, shape) in enumerate(zip(rows, chart.shapes, strict=True)) if shape
    ]
    data = f'data-unit="{chart.unit:.9g}" data-left="{chart.left:.9g}" data-top="{chart.top:.9g}"'
    box = f"0 0 {number(chart.width)} {number(chart.height)}"
    head = f'<svg id="map" viewBox="{box}" {data} role="group" aria-labelledby="map-help"><g id="grid"></g>'
    return f'{head}{"".join(reversed(drawn))}<g id="labels"></g></svg>'


def _area(place: int, row: AreaRow, shape: Shape) -> str:
    """Return an area of the map, linked to its row."""
    word = row.result.status.value
    outline = f'<path class="shape" d="{shape.path}"/>' if shape.path else ""
    small = not shape.path or max(shape.width, shape.height) < _SMALL
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
    """Return an area's row of the table, with a sentence in place of missing figures."""
    word = row.result.status.value
    links = _links(row)
    if row.figures is None or row.message:
        told = f'<td colspan="{1 + _FIGURES}">{links} {escape(row.message)}</td>'
    else:
        told = f"<td>{links}</td>" + "".join(f"<td>{cell}</td>" for cell in _figures(row.figures))
    spent = "".join(f"<td>{cell}</td>" for cell in _spent(row))
    return (
        f'<tr id="a{place}" class="{word}"><th scope="row"><bdi>{escape(row.name)}</bdi></th>'
        f"<td>{word}</td>{told}{spent}</tr>"
    )


def _links(row: AreaRow) -> str:
    """Return links to the files of an area, which lie beside the page."""
    return " ".join(
        f'<a href="./{quote(row.files[suffix].encode("utf-8", "surrogateescape"), safe="")}"'
        f' aria-label="{word} of {escape(one_line(row.name))}">{word}</a>'
        for suffix, word in _LINKS.items()
        if suffix in row.files
    )


def _spent(row: AreaRow) -> Iterator[str]:
    """Yield the cells of the last columns, about the run."""
    yield f"{row.result.seconds:,.1f}" if row.result.seconds > 0.0 else ""
    yield f"{row.result.memory / 1e6:,.0f}" if row.result.memory > 0 else ""


def _figures(figures: Figures) -> Iterator[str]:
    """Yield the cells of the first columns, about the road network."""
    yield _written(figures.road_length, 1e-3, 2)
    yield _written(figures.roads, 1.0, 0)
    yield _written(figures.junctions, 1.0, 0)
    yield _written(figures.dem_coverage, 100.0, 1)
    yield _written(figures.lowest, 1.0, 1)
    yield _written(figures.highest, 1.0, 1)
    yield _written(figures.grade, 100.0, 1)
    for kind in (Kind.GUESSED, Kind.DROPPED, Kind.REPAIRED, Kind.NOTE):
        yield f"{figures.counts[kind]:,}"
    yield _written(figures.size, 1e-6, 2)


def _written(value: float | None, factor: float, decimals: int) -> str:
    return "" if value is None else f"{value * factor:,.{decimals}f}"


def _hash(text: str) -> str:
    """Return the source expression of a text in a Content-Security-Policy."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode('ascii')}'"


def _part(name: str) -> str:
    """Return a file of the template."""
    return files("osm2xodr.batch.index").joinpath("template").joinpath(name).read_text(encoding="utf-8")
