"""The command ``locate``: finds places in all coordinates of a road network."""

from __future__ import annotations

import csv
import io
import json
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from osm2xodr.cli.options import PATH, file_argument, limit_options
from osm2xodr.errors import InputError
from osm2xodr.system import STANDARD_OUTPUT, record, stream_to

if TYPE_CHECKING:
    from osm2xodr.opendrive import FieldValue, Locator

# A place that lies farther from all roads is not one of the network, m: a choice, less than a slip of 0.1 degrees.
_REACH = 10_000.0
# Degrees that there are. Longitudes may be counted on, once around.
_MOST_DEGREES = {"lat": 90.0, "lon": 360.0}
# Ways to name a place: the columns that are needed, and those that are optional.
_WAYS: dict[tuple[str, ...], tuple[str, ...]] = {
    ("lat", "lon"): (),
    ("x", "y"): (),
    ("road", "s"): ("t", "lane", "offset"),
}


@record
class _Point:
    """A place that was asked for: its numbers, the id of its road, and all columns of its row."""

    way: tuple[str, ...]
    numbers: dict[str, float]
    road: str
    columns: dict[str, str]


@click.command(
    short_help="Find places in a road network.",
    epilog="""\b
Examples:
  osm2xodr locate area.xodr --lat 49.9456 --lon 11.5713
  osm2xodr locate area.xodr --x 120 --y -35.5 --all
  osm2xodr locate area.xodr --road 17 --lane -1 --s 42 --json
  osm2xodr locate area.xodr --points places.csv > heights.csv

A CSV file has a line of column names: lat,lon or x,y or road,s and maybe t or lane and offset. Its other columns are
kept. Places over 10 km away from all roads are not found. Degrees are those of WGS 84, headings are in rad, all
else is in m.

Exit status: 0 found, 1 cannot be found, 2 wrong usage, 130 interrupted.""",
)
@file_argument
@click.option("--lat", type=float, metavar="DEG", help="Latitude.")
@click.option("--lon", type=float, metavar="DEG", help="Longitude.")
@click.option("--x", type=float, metavar="M", help="Inertial x, as in the file.")
@click.option("--y", type=float, metavar="M", help="Inertial y, as in the file.")
@click.option("--road", metavar="ID", help="Id of a road.")
@click.option("--s", type=float, metavar="M", help="Distance from the road's start.")
@click.option("--t", type=float, metavar="M", help="Distance from the reference line to the left.  [default: 0]")
@click.option("--lane", type=int, metavar="ID", help="Id of a lane, whose middle is meant.")
@click.option("--offset", type=float, metavar="M", help="Distance from the lane's middle to the left.  [default: 0]")
@click.option("--points", type=PATH, metavar="CSV", help="Many places; - for standard input.")
@click.option(
    "--lane-type", metavar="LIST", help="Only places on lanes of these types, such as driving, separated by commas."
)
@click.option("--all", "every", is_flag=True, help="All roads at each place, such as bridges, not the best alone.")
@click.option("--json", "as_json", is_flag=True, help="JSON in place of text or CSV.")
@limit_options
def locate(
    file: Path,
    points: Path | None,
    lane_type: str | None,
    every: bool,
    as_json: bool,
    **given: float | str | int | None,
) -> None:
    """Find places of the OpenDRIVE FILE on Earth, in the file's coordinates, and on its roads."""
    named = {name: value for name, value in given.items() if value is not None}
    if points is None:
        asked = [_single(named)]
    elif named:
        raise click.UsageError("--points stands for all places; give no other coordinates with it")
    else:
        asked = list(_table(points))
    from osm2xodr.opendrive import Locator, caveats, read_xodr

    locator = Locator(read_xodr(file))
    for line in caveats(locator.file):
        click.echo(f"osm2xodr: {line}", err=True)
    found = _found(locator, asked)
    if lane_type is not None:
        found = _on_types(found, lane_type, locator, refuse=points is None)
    if points is None:
        _refuse_far(found[0], locator)
    else:
        found = [[place for place in places if not _is_far(place)] for places in found]
    if as_json:
        chosen = [places if every else places[:1] for places in found]
        document: object = [{"point": item.columns, "places": at} for item, at in zip(asked, chosen, strict=True)]
        if points is None:
            document = {"places": chosen[0], "others": len(found[0]) - len(chosen[0])}
        text = json.dumps(document, ensure_ascii=False, indent=1) + "\n"
    elif points is None:
        text = _text(found[0], every, locator)
    else:
        text = _csv(asked, found, every)
    with stream_to(STANDARD_OUTPUT) as stream:
        stream.write(text.encode())


def _single(named: dict[str, float | str | int]) -> _Point:
    """Return the place that options name."""
    for way, more in _WAYS.items():
        if set(way) <= set(named):
            wrong = sorted(set(named) - {*way, *more})
            if wrong:
                raise click.UsageError(f"--{wrong[0]} does not go with --{way[0]} and --{way[1]}; leave it out")
            return _point(way, {name: str(value) for name, value in named.items()}, "")
    raise click.UsageError("give --lat and --lon, --x and --y, --road and --s, or --points")


def _table(path: Path) -> Iterator[_Point]:
    """Yield the places of a CSV file."""
    try:
        text = sys.stdin.read() if path == STANDARD_OUTPUT else path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = (getattr(error, "strerror", None) or "it is not UTF-8").lower()
        raise InputError(f"cannot read {path}: {reason}") from error
    reader = csv.DictReader(io.StringIO(text, newline=""), skipinitialspace=True, restval="")
    columns = [name.strip() for name in reader.fieldnames or ()]
    reader.fieldnames = columns
    way = next((item for item in _WAYS if set(item) <= set(columns)), None)
    if way is None:
        raise InputError(f"{path} has no columns lat and lon, x and y, or road and s; name them in its first line")
    for row in reader:
        cells = {name: (cell or "").strip() for name, cell in row.items() if name is not None}
        yield _point(way, cells, f"{path}, line {reader.line_num}: ")


def _point(way: tuple[str, ...], cells: dict[str, str], place: str) -> _Point:
    """Return a place; `place` says where it stands, for messages."""
    numbers = {}
    for name in (*way, *_WAYS[way]):
        text = cells.get(name, "")
        if name == "road" or (not text and name not in way):
            continue
        try:
            numbers[name] = float(text)
        except ValueError:
            numbers[name] = math.nan
        if not math.isfinite(numbers[name]) or (name == "lane" and numbers[name] % 1):
            raise InputError(f"{place}{name} {text!r} is not a {'lane id' if name == 'lane' else 'number'}")
    for name, most in _MOST_DEGREES.items():
        if abs(numbers.get(name, 0.0)) > most:
            raise InputError(f"{place}{name} {numbers[name]:g} is not within {-most:g} to {most:g} degrees")
    if "lane" in numbers and "t" in numbers:
        raise InputError(f"{place}t and lane are two ways to say the same; give one of them, or lane and offset")
    if "offset" in numbers and "lane" not in numbers:
        raise InputError(f"{place}offset counts from the middle of a lane; give lane, too")
    return _Point(way, numbers, cells.get("road", ""), cells)


def _found(locator: Locator, asked: list[_Point]) -> list[list[dict[str, FieldValue]]]:
    """Return all places at each point, the best first."""
    import numpy as np

    if not asked:
        return []
    way = asked[0].way
    one, other = (np.array([item.numbers.get(name, 0.0) for item in asked]) for name in way)
    if way == ("lat", "lon"):
        places = locator.at_geographic(one, other)
    elif way == ("x", "y"):
        places = locator.at_inertial(one, other)
    else:
        t, offset = (np.array([item.numbers.get(name, 0.0) for item in asked]) for name in ("t", "offset"))
        lanes = [int(item.numbers["lane"]) if "lane" in item.numbers else None for item in asked]
        places = locator.on_roads([item.road for item in asked], other, t, lanes, offset)
    rows = locator.describe(places)
    start = places.start.tolist()
    return [rows[start[k] : start[k + 1]] for k in range(len(asked))]


def _on_types(
    found: list[list[dict[str, FieldValue]]], text: str, locator: Locator, *, refuse: bool
) -> list[list[dict[str, FieldValue]]]:
    """Return the places on lanes of some types; `refuse` a point without any."""
    types = {name.strip() for name in text.split(",")}
    known = set(locator.file.lanes.type)
    if unknown := sorted(types - known):
        raise click.UsageError(
            f"--lane-type: {locator.file.path} has no lanes of type {unknown[0]!r}; it has {', '.join(sorted(known))}"
        )
    out = [[place for place in places if place["lane_type"] in types] for places in found]
    if refuse and found[0] and not out[0]:
        there = ", ".join(sorted({str(place["lane_type"]) for place in found[0]}))
        raise InputError(f"no lane of type {text} of {locator.file.path} lies there, but: {there}")
    return out


def _is_far(place: dict[str, FieldValue]) -> bool:
    """Whether a place is too far from its road to be one of the network."""
    distance = place["distance"]
    return isinstance(distance, float) and distance > _REACH


def _refuse_far(places: list[dict[str, FieldValue]], locator: Locator) -> None:
    """Refuse a place that is not one of the network."""
    if places and _is_far(places[0]):
        distance = places[0]["distance"]
        assert isinstance(distance, float)
        raise InputError(
            f"the nearest road of {locator.file.path} lies {distance / 1e3:,.0f} km away; check the coordinates and"
            " their order"
        )


def _csv(asked: list[_Point], found: list[list[dict[str, FieldValue]]], every: bool) -> str:
    """Return a table: the columns of each point, then its place, empty if there is none."""
    from osm2xodr.opendrive import LOCATION_FIELDS

    text = io.StringIO(newline="")
    own = list(asked[0].columns) if asked else []
    # Columns of the input keep their names, except those of results.
    kept = {name: f"input_{name}" if name in LOCATION_FIELDS else name for name in own}
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*kept.values(), *LOCATION_FIELDS])
    for item, places in zip(asked, found, strict=True):
        for place in (places if every else places[:1]) or [dict.fromkeys(LOCATION_FIELDS)]:
            cells = [item.columns[name] for name in own]
            writer.writerow([*cells, *("" if place[name] is None else place[name] for name in LOCATION_FIELDS)])
    return text.getvalue()


def _text(places: list[dict[str, FieldValue]], every: bool, locator: Locator) -> str:
    """Return places as text."""
    if not places:
        raise InputError(f"{locator.file.path} has no road that could be found; osm2xodr check says what is wrong")
    shown = places if every else places[:1]
    blocks = ["".join(f"{name:<9}{text}\n" for name, text in _lines(place, locator)) for place in shown]
    if rest := len(places) - len(shown):
        blocks.append(f"{rest} more {'road lies' if rest == 1 else 'roads lie'} here; --all shows all\n")
    return "\n".join(blocks)


def _lines(place: dict[str, FieldValue], locator: Locator) -> Iterator[tuple[str, str]]:
    """Yield names and texts of the lines about a place."""
    name = f" ({place['road_name']})" if place["road_name"] else ""
    junction = "" if place["junction"] is None else f", in junction {place['junction']}"
    yield "road", f"{place['road']}{name}{junction}"
    lane = "none" if place["lane"] is None else f"{place['lane']} ({place['lane_type']})"
    offset, lateral = place["offset"], "no lane near"
    if isinstance(offset, float):
        lateral = f"{_m(abs(offset))} {'right' if offset < 0 else 'left'} of its middle"
    yield "lane", f"{lane}, section from s={_m(place['section_s'])}, {lateral}"
    yield "s, t", f"{_m(place['s'])}, {_m(place['t'])}"
    if place["distance"]:
        yield "distance", f"{_m(place['distance'])} from the nearest lane of this road"
    yield "x, y, z", f"{_m(place['x'])}, {_m(place['y'])}, {_m(place['z'])}"
    if place["lat"] is None:
        yield "lat, lon", f"unknown: {locator.reason or 'outside of the projection'}"
    else:
        yield "lat, lon", f"{place['lat']:.9f}, {place['lon']:.9f}"
    yield "height", _m(place["height"])
    heading, slope, roll = place["hdg"], place["grade"], place["superelevation"]
    if isinstance(heading, float):
        yield "heading", f"{heading:.6f} rad ({math.degrees(heading):.3f} degrees from east to the left)"
    if isinstance(slope, float):
        yield "grade", f"{100 * slope:.2f} %"
    if isinstance(roll, float) and roll:
        yield "roll", f"{roll:.6f} rad ({100 * math.tan(roll):.2f} % across)"


def _m(value: FieldValue) -> str:
    """Return a length to 0.1 mm."""
    return f"{value:.4f} m" if isinstance(value, float) else "unknown"
