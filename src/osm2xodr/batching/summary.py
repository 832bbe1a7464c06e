"""Writes the summary of a batch: a table for programs, and a page with a map, the failures and a table for people.

Scripts sort, filter and zoom; where they are forbidden, as in archives of some build servers, the rest still works.

The map is in the Mercator projection, in units of the drawing. It is conformal, so small areas keep their shape at
any latitude. Formula: J. P. Snyder, Map Projections: A Working Manual, USGS 1987, eq. 7-1 and 7-2, on the sphere.
"""

from __future__ import annotations

import csv
import io
import math
import re
from base64 import b64encode
from collections.abc import Callable, Iterator, Sequence
from html import escape
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import Final
from urllib.parse import quote

from osm2xodr import __version__
from osm2xodr.batching.area_rows import AreaRow, Figures, one_line, read_rows
from osm2xodr.batching.model import Result, Status
from osm2xodr.diagnostics import Kind, counted
from osm2xodr.system import record, stream_to
from osm2xodr.viewing import facts, filled, package_text, page_html

TABLE_NAME: Final = "summary.csv"
PAGE_NAME: Final = "index.html"

# Spreadsheets take cells that begin with these for formulas; the last four are the full-width forms.
_FORMULA = tuple("=+-@\uff1d\uff0b\uff0d\uff20")

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

Ring = tuple[tuple[float, float], ...]
Point = tuple[float, float]

# Radius of the sphere, m: the semi-major axis of WGS 84, as in web maps.
RADIUS: Final = 6378137.0
# Width of the drawing, units: numbers stay short, and fine enough for browsers, which keep seven digits.
WIDTH: Final = 1000.0
# Latitude at which the map ends, degrees: there a map of the whole earth is a square.
_LAST_LATITUDE: Final = 85.05
# Least width and height of what is drawn, m: a single area may be a point.
_LEAST_EXTENT: Final = 300.0
# Margin on each side as a share of the width.
_MARGIN: Final = 0.03
# Least and largest height of the drawing as a share of its width.
_LEAST_ASPECT: Final = 1 / 3
_LARGEST_ASPECT: Final = 3.0


def _of_result(decimals: int, get: Callable[[Result], float]) -> Callable[[AreaRow], str]:
    """Return a function for cells with a figure that is 0 without a conversion."""
    return lambda row: f"{get(row.result):.{decimals}f}" if get(row.result) > 0.0 else ""


def _figure(decimals: int, get: Callable[[Figures], float | None], unit: float = 1.0) -> Callable[[AreaRow], str]:
    """Return a function for cells with a figure of the report, in some unit."""

    def cell(row: AreaRow) -> str:
        value = None if row.figures is None else get(row.figures)
        return "" if value is None else f"{value / unit:.{decimals}f}"

    return cell


def _text_column(get: Callable[[AreaRow], str]) -> Callable[[AreaRow], str]:
    """Return a function for cells with a text, after an apostrophe where spreadsheets would see a formula."""

    def cell(row: AreaRow) -> str:
        value = get(row)
        return f"'{value}" if value.lstrip().startswith(_FORMULA) else value

    return cell


_COLUMNS: Final = MappingProxyType(
    {
        "name": _text_column(lambda row: row.name),
        "status": _text_column(lambda row: row.result.status.value),
        "message": _text_column(lambda row: row.message),
        "seconds": _of_result(2, lambda result: result.seconds),
        "memory_mb": _of_result(1, lambda result: result.memory / 1e6),
        "xodr": _text_column(lambda row: row.files.get(".xodr", "")),
        "report": _text_column(lambda row: row.files.get(".json", "")),
        "page": _text_column(lambda row: row.files.get(".html", "")),
        "xodr_bytes": _figure(0, lambda figures: figures.size),
        "roads": _figure(0, lambda figures: figures.roads),
        "connecting_roads": _figure(0, lambda figures: figures.connecting_roads),
        "junctions": _figure(0, lambda figures: figures.junctions),
        "road_km": _figure(3, lambda figures: figures.road_length, 1000.0),
        "connecting_road_km": _figure(3, lambda figures: figures.connecting_length, 1000.0),
        "dem_coverage": _figure(4, lambda figures: figures.dem_coverage),
        "lowest_m": _figure(2, lambda figures: figures.lowest),
        "highest_m": _figure(2, lambda figures: figures.highest),
        "steepest_grade": _figure(4, lambda figures: figures.grade),
        "guessed": _figure(0, lambda figures: figures.counts[Kind.GUESSED]),
        "dropped": _figure(0, lambda figures: figures.counts[Kind.DROPPED]),
        "repaired": _figure(0, lambda figures: figures.counts[Kind.REPAIRED]),
        "notes": _figure(0, lambda figures: figures.counts[Kind.NOTE]),
        "xodr_version": _text_column(lambda row: "" if row.figures is None else row.figures.xodr_version),
        "osm2xodr": _text_column(lambda row: "" if row.figures is None else row.figures.version),
    }
)
COLUMNS: Final = tuple(_COLUMNS)


def write_summary(out_dir: Path, results: Sequence[Result]) -> None:
    """Write ``summary.csv`` and ``index.html`` into the folder of a batch, each as a whole or not at all.

    The same results and reports give the same bytes, whatever the order of the results. Figures come from the reports
    ``NAME.json`` in the folder; where one is missing or damaged the message says so. Raises `OutputError` if a file
    cannot be written.
    """
    rows = read_rows(out_dir, results)
    for name, text in ((TABLE_NAME, make_table(rows)), (PAGE_NAME, make_index(rows))):
        with stream_to(out_dir / name) as stream:
            stream.write(text)


def make_table(rows: Sequence[AreaRow]) -> bytes:
    """Return a table by RFC 4180, UTF-8, with a header, and empty cells for what is unknown."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\r\n")
    writer.writerow(COLUMNS)
    writer.writerows([make(row) for make in _COLUMNS.values()] for row in rows)
    return text.getvalue().encode("utf-8", "replace")


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
        filled(_template("index.html"), parts),
        _template("index.css"),
        scripts=[_template("index.js")],
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


def _template(name: str) -> str:
    """Return a file of the template."""
    return package_text("osm2xodr.batching", f"template/{name}")


@record
class Shape:
    """An area on the map."""

    path: str  # Its outline, as data of an SVG path; empty for a point
    # Its middle, units to the right and down
    x: float
    y: float
    # Units
    width: float
    height: float


@record
class Map:
    """Areas on the map."""

    shapes: tuple[Shape | None, ...]  # Of each area; None where its place is unknown
    # Of the drawing, units
    width: float
    height: float
    unit: float  # Metres of the sphere's equator per unit
    # Mercator's x and y of the drawing's left upper corner, m
    left: float
    top: float


def make_map(outlines: Sequence[Sequence[Ring]]) -> Map:
    """Return a map of outlines (rings of longitude and latitude, degrees).

    The map is cut on the far side of the areas, so that areas on both sides of the 180th meridian are neighbours.
    """
    joined = [[_joined(ring) for ring in rings if ring] for rings in outlines]
    cut = _cut([_middle([lon for ring in rings for lon, _ in ring]) for rings in joined if rings])
    placed = [[_projected(ring) for ring in _turned(rings, cut)] for rings in joined]
    xs = [x for rings in placed for ring in rings for x, _ in ring]
    ys = [y for rings in placed for ring in rings for _, y in ring]
    if not xs:
        return Map(tuple(None for _ in outlines), WIDTH, WIDTH / 2.0, 1.0, 0.0, 0.0)
    across, down = (max(max(values) - min(values), _LEAST_EXTENT) for values in (xs, ys))
    unit = across * (1.0 + 2.0 * _MARGIN) / WIDTH
    height = min(max(down + 2.0 * _MARGIN * across, _LEAST_ASPECT * across) / unit, _LARGEST_ASPECT * WIDTH)
    unit = max(unit, (down + 2.0 * _MARGIN * across) / height)
    left, top = _middle(xs) - unit * WIDTH / 2.0, _middle(ys) + unit * height / 2.0
    shapes = tuple(_shape(rings, left, top, unit) for rings in placed)
    return Map(shapes, WIDTH, height, unit, left, top)


def _joined(ring: Ring) -> list[Point]:
    """Return a ring that does not jump at the 180th meridian; one all round the earth stays as it is."""
    out = [ring[0]]
    for (before, _), (lon, lat) in pairwise(ring):
        step = lon - before
        out.append((out[-1][0] + (math.remainder(step, 360.0) if abs(step) < 360.0 else step), lat))
    return out


def _middle(values: Sequence[float]) -> float:
    return (min(values) + max(values)) / 2.0


def _cut(longitudes: Sequence[float]) -> float:
    """Return the meridian, degrees from -180, in the middle of the widest gap between longitudes."""
    sorted_deg = sorted(longitude % 360.0 for longitude in longitudes)
    if not sorted_deg:
        return -180.0
    gaps = [(b - a, a) for a, b in pairwise([*sorted_deg, sorted_deg[0] + 360.0])]
    width, begin = max(gaps, key=lambda gap: (gap[0], -gap[1]))
    return (begin + width / 2.0 + 180.0) % 360.0 - 180.0


def _turned(rings: list[list[Point]], cut: float) -> list[list[Point]]:
    """Return rings with longitudes within the 360 degrees from the cut on; rings of one area stay together."""
    if not rings:
        return []
    middle = _middle([lon for ring in rings for lon, _ in ring])
    turn = cut + (middle - cut) % 360.0 - middle
    return [[(lon + turn, lat) for lon, lat in ring] for ring in rings]


def _projected(ring: list[Point]) -> list[Point]:
    """Return x and y of the Mercator projection, m."""
    out = []
    for lon, lat in ring:
        y = math.asinh(math.tan(math.radians(min(max(lat, -_LAST_LATITUDE), _LAST_LATITUDE))))
        out.append((RADIUS * math.radians(lon), RADIUS * y))
    return out


def _shape(rings: list[list[Point]], left: float, top: float, unit: float) -> Shape | None:
    """Return the shape of an area; None without rings."""
    if not rings:
        return None
    drawn = [[((x - left) / unit, (top - y) / unit) for x, y in ring] for ring in rings]
    xs, ys = [x for ring in drawn for x, _ in ring], [y for ring in drawn for _, y in ring]
    path = "".join(
        "M" + "L".join(f"{number(x)} {number(y)}" for x, y in ring) + "Z" for ring in drawn if len(ring) > 2
    )
    return Shape(path, _middle(xs), _middle(ys), max(xs) - min(xs), max(ys) - min(ys))


def number(value: float) -> str:
    """Return a number of units, short."""
    text = f"{value:.3f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
