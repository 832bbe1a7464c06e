"""The area to fetch: a box, polygons, or a place by its name.

Names are looked up in a geocoder with the API of Nominatim: one request for a name, kept like maps.
"""

from __future__ import annotations

import math
import time
import urllib.parse
from pathlib import Path
from typing import Any, Final

import numpy as np

from osm2xodr.batching import CutRequest, frame_around, read_polygons
from osm2xodr.errors import InputError, OptionError
from osm2xodr.fetching.connection import Connection, Response, host, shown
from osm2xodr.fetching.downloads import Wanted, key_of, not_wanted
from osm2xodr.fetching.options import FetchOptions, ServerError
from osm2xodr.model import Outline
from osm2xodr.projection import to_local
from osm2xodr.system import make_folder, parse_json, plain_text, record, stream_to

# Length of a degree of latitude, m (WGS 84, mean).
DEGREE: Final = 111_195.0

Box = tuple[float, float, float, float]
_Rings = tuple[tuple[tuple[float, float], ...], ...]

# Most places that are asked for, and named; and the largest answer, bytes: ten places are some 5 kB.
_PLACES_MAX: Final = 10
_ANSWER_MAX: Final = 1_000_000


@record
class Place:
    """An area on Earth."""

    box: Box  # West, south, east, north, degrees, WGS 84
    # Rings of (longitude, latitude), degrees, as in `Outline`; empty where the area is the box
    rings: _Rings = ()
    text: str = ""  # How the user named it, for the list of sources

    def cut_request(self, target: Path) -> CutRequest:
        """Return what cuts the area out of a map, into a file ``.osm.pbf``."""
        west, south, east, north = self.box
        rings = self.rings or (((west, south), (east, south), (east, north), (west, north)),)
        frame = frame_around(rings)
        outline = Outline(tuple(np.column_stack(to_local(frame, *np.array(ring).T)) for ring in rings))
        return CutRequest(self.text, target, frame, outline)


def widened(box: Box, margin: float) -> Box:
    """Return a box (west, south, east, north, degrees) with what lies up to a margin, m, around it."""
    west, south, east, north = box
    up = margin / DEGREE
    across = up / max(0.05, math.cos(math.radians(max(abs(south), abs(north)))))
    return max(-180.0, west - across), max(-90.0, south - up), min(180.0, east + across), min(90.0, north + up)


def is_box(box: Box) -> bool:
    """Whether west, south, east and north, degrees, are a box on Earth, on one side of the 180th meridian."""
    west, south, east, north = box
    return -180.0 <= west < east <= 180.0 and -90.0 < south < north < 90.0


def place_of_box(text: str) -> Place:
    """Return the area ``west,south,east,north``, degrees; `OptionError` says what is wrong with it."""
    form = "write west,south,east,north in degrees"
    try:
        west, south, east, north = (float(word) for word in text.split(","))
    except ValueError:
        raise OptionError(f"bbox {text} is not 4 numbers; {form}", "bbox") from None
    if not (-180.0 <= west <= 180.0 and -180.0 <= east <= 180.0 and -90.0 < south < 90.0 and -90.0 < north < 90.0):
        raise OptionError(f"bbox {text} is not on Earth; {form}", "bbox")
    if not (west < east and south < north):
        raise OptionError(f"bbox {text} is empty; {form}, areas on both sides of longitude 180 one by one", "bbox")
    return Place((west, south, east, north), text=f"bbox {west:.7g},{south:.7g},{east:.7g},{north:.7g}")


def place_of_file(path: Path) -> Place:
    """Return the area of all polygons of a GeoJSON file; `InputError` says what is wrong with it."""
    rings = tuple(ring for _, found in read_polygons(path) for ring in found)
    corners = np.array([corner for ring in rings for corner in ring])
    west, south = corners.min(axis=0).tolist()
    east, north = corners.max(axis=0).tolist()
    return Place((west, south, east, north), rings, f"the polygons of {path.name}")


def find_place(connection: Connection, name: str, options: FetchOptions) -> Place:
    """Return the box of the place that a geocoder finds first; what it is, and others of that name, are noted.

    Raises
    ------
    InputError
        The geocoder knows no such place.
    ServerError
        It cannot be reached, or does not answer with places.
    """
    server = options.geocoder
    folder = options.cache_dir / "places"
    make_folder(folder)
    path = folder / f"{key_of(server, name)}.json"
    if not (path.is_file() and time.time() - path.stat().st_mtime < options.age):
        _ask(connection, server, name, path)
    try:
        places = [_place(item) for item in parse_json(path.read_bytes())]
    except (ValueError, TypeError, LookupError):
        path.unlink(missing_ok=True)
        raise ServerError(
            f"{shown(server)} gives places without bounds; check the address, or give another one with --geocoder"
        ) from None
    if not places:
        raise InputError(
            f"{shown(server)} knows no place {name!r}; write it another way, or give its box with --bbox"
        )
    (what, box), *others = places
    note = connection.network.note
    note(f"{name!r} is {what}: --bbox {_text(box)}")
    for other, bounds in others:
        note(f"another place of that name is {other}: --bbox {_text(bounds)}")
    return Place(box, text=f"{what}, found by {host(server)}")


def _ask(connection: Connection, server: str, name: str, path: Path) -> None:
    query = urllib.parse.urlencode({"q": name, "format": "jsonv2", "limit": _PLACES_MAX})
    url = f"{server}{'&' if urllib.parse.urlsplit(server).query else '?'}{query}"
    wanted = Wanted(server, "--geocoder", "a list of places in JSON", lambda head: head.lstrip().startswith(b"["))

    def read(response: Response) -> bytes:
        content = b""
        for chunk in connection.chunks(response):
            content += chunk
            if len(content) > _ANSWER_MAX:
                raise ServerError(f"{shown(server)} sends over {_ANSWER_MAX / 1e6:,.1f} MB; give another --geocoder")
        if not wanted.looks_right(content):
            raise ServerError(not_wanted(wanted, content, response), response.status)
        return content

    connection.network.progress(f"asking {host(server)} for the place")
    try:
        content = connection.ask(url, "--geocoder", read)
    except ServerError as error:
        if not error.unreached:
            raise
        raise ServerError(
            f"{shown(server)} cannot be reached ({error.unreached}): this machine may be offline; connect it, give "
            "another address with --geocoder, or the box of the place with --bbox",
            unreached=error.unreached,
        ) from error
    with stream_to(path) as stream:
        stream.write(content)


def _place(item: Any) -> tuple[str, Box]:
    """Return what a place is, in words, and its box."""
    south, north, west, east = map(float, item["boundingbox"])
    box = west, south, east, north
    if not is_box(box):
        raise ValueError("no box on Earth")
    kind = plain_text(" ".join(str(item.get(key, "")) for key in ("category", "type", "osm_type", "osm_id")))
    return f"{plain_text(str(item.get('display_name', '')))} ({kind})", box


def _text(box: Box) -> str:
    return ",".join(f"{value:.7g}" for value in box)
