"""Places by their names, from a geocoder with the API of Nominatim: one request for a name, kept like maps.

The API: https://nominatim.org/release-docs/latest/api/Search. The public server wants a User-Agent that names the
program, at most one request per second and answers kept (https://operations.osmfoundation.org/policies/nominatim).
"""

from __future__ import annotations

import time
import urllib.parse
from pathlib import Path
from typing import Any, Final

from osm2xodr.errors import InputError
from osm2xodr.fetching.addresses import host, shown
from osm2xodr.fetching.connection import Connection, Response
from osm2xodr.fetching.downloads import Wanted, key_of, not_wanted
from osm2xodr.fetching.options import FetchOptions, ServerError
from osm2xodr.fetching.place import Box, Place, is_box
from osm2xodr.system import make_folder, parse_json, plain_text, stream_to

# Most places that are asked for, and named; and the largest answer, bytes: ten places are some 5 kB.
_PLACES_MAX: Final = 10
_ANSWER_MAX: Final = 1_000_000


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
