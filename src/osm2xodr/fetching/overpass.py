"""Maps from the Overpass API: queries for all that conversions and scenes read of a map.

They are asked for their size first, and in parts where they are large. Each part is kept as soon as it is there, so
that a fetch that ended goes on.
"""

from __future__ import annotations

import re
import time
import urllib.parse
import zlib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Final
from xml.etree import ElementTree

import osmium
import osmium.filter

from osm2xodr.defaults import OUTLINE_REACH
from osm2xodr.errors import InputError
from osm2xodr.fetching.connection import Connection, Response, again, host, shown
from osm2xodr.fetching.downloads import key_of
from osm2xodr.fetching.options import FetchOptions, ServerError
from osm2xodr.fetching.place import Box, widened
from osm2xodr.osmParsing import (
    AREA_TYPE,
    RELATION_TYPES,
    SURROUNDINGS_KEYS,
    SURROUNDINGS_TAGS,
    handle,
    node_keys,
    open_osm_file,
    readable,
    way_values,
)
from osm2xodr.system import complete, is_page, make_folder, plain_text, stream_to

# Ways and nodes of a part, about 100 MB of text; larger ones are split. And of the whole area: beyond it an extract
# is less work for everybody. Choices.
_PART_MAX: Final = 60_000
_AREA_MAX: Final = 1_500_000
# Larger boxes are not even counted, square degrees: a country.
_BOX_MAX: Final = 16.0
# Boxes are split at most so often; in the last ones half a second of arc would hold a whole city.
_SPLITS_MAX: Final = 12
# More parts than this no area of that size takes, where they are split evenly or not: some 25 are full. A choice.
_PARTS_MAX: Final = 1000
# Bytes at the beginning and the end of an answer that say what it is; the largest map, and the largest count.
_ENDS: Final = 1 << 14
_ANSWER_MAX: Final = 2_000_000_000
_COUNT_MAX: Final = 1_000_000
_NUMBER: Final = re.compile(r"[0-9]{1,12}")

_REMARK: Final = re.compile(rb"<remark>(.*?)</remark>", re.DOTALL)
# What the server says of queries that are too large for it.
_TOO_LARGE: Final = re.compile(r"timed? ?out|out of memory|memory", re.IGNORECASE)

# How long the server may work on a query, s, and the memory that it may take, bytes: the server's own defaults.
QUERY_TIME: Final = 180
_QUERY_MEMORY: Final = 536_870_912
_SETTINGS: Final = f"[out:xml][timeout:{QUERY_TIME}][maxsize:{_QUERY_MEMORY}];"
# What conversions read on request; it is fetched as well.
_EXTRA: Final = frozenset({"lamps", "trees"})
# Keys of nodes of which only some values are of use, since there are many with others.
_VALUES: Final = {"natural": "tree"}


class _TooLargeError(Exception):
    """A part is too large for the server."""


class _Overpass:
    """Asks servers of the Overpass API, the next one where one fails."""

    def __init__(self, connection: Connection, options: FetchOptions, folder: Path) -> None:
        self._connection = connection
        self._servers = list(options.overpass)
        self._age = options.age
        self._surroundings = options.surroundings
        self._folder = folder
        self.message = ""  # What a server has last said of a part that is too large for it

    def count(self, box: Box) -> tuple[int, Path]:
        """Return the number of elements in a box, and the file that says so; `_TooLargeError` if there is none."""
        path = self._answer(count_query(box, surroundings=self._surroundings), _count, _COUNT_MAX)
        return _count(path), path

    def area(self, box: Box) -> Path:
        """Return the file with what is in a box; `_TooLargeError` if the server cannot give it."""
        most = min(_ANSWER_MAX, self._connection.network.download_max)
        return self._answer(area_query(box, surroundings=self._surroundings), read_through, most)

    def _answer(self, query: str, check: Callable[[Path], object], most: int) -> Path:
        """Return the file with the answer to a query, of which `check` makes an error if it is none."""
        failed: list[ServerError] = []
        for server in tuple(self._servers):
            path = self._folder / f"{key_of(server, query)}.osm"
            try:
                if not (path.is_file() and time.time() - path.stat().st_mtime < self._age and _passes(check, path)):
                    self._ask(server, query, path, check, most)
            except ServerError as error:
                failed.append(error)
                continue
            # What one of them refuses or lacks another one may give; it is not asked for anything more.
            for before, fault in zip(self._servers, failed, strict=False):
                why = f"cannot be reached ({fault.unreached})" if fault.unreached else f"is of no use ({fault})"
                self._connection.network.note(f"{host(before)} {why}; {host(server)} is asked instead")
            del self._servers[: len(failed)]
            return path
        if len(failed) > 1 and all(error.unreached for error in failed):
            names = ", ".join(map(host, self._servers))
            raise ServerError(
                f"none of the servers of the Overpass API can be reached ({names}: {failed[0].unreached}): this "
                "machine may be offline; connect it, give another server with --overpass, or a map that you have "
                "with --extract",
                unreached=failed[0].unreached,
            )
        raise failed[-1]

    def _ask(self, server: str, query: str, path: Path, check: Callable[[Path], object], most: int) -> None:
        sign = "&" if urllib.parse.urlsplit(server).query else "?"
        url = f"{server}{sign}{urllib.parse.urlencode({'data': query})}"
        part = path.with_suffix(".part")

        def read(response: Response) -> None:
            head = tail = b""
            size = 0
            with stream_to(part) as stream:
                for chunk in self._unpacked(response):
                    size += len(chunk)
                    head += chunk[: _ENDS - len(head)]
                    tail = (tail + chunk)[-_ENDS:]
                    if size > most:
                        raise ServerError(f"{shown(server)} sends over {most / 1e6:,.1f} MB; give a smaller area")
                    stream.write(chunk)
                _check(server, head, tail)

        try:
            self._connection.ask(url, "--overpass", read, lambda: {"Accept-Encoding": "gzip"}, QUERY_TIME)
            try:
                check(part)
            except InputError as error:
                why = str(error).replace(str(part), "its answer").partition(";")[0]
                other = "try again later, or give another one with --overpass"
                raise ServerError(f"{shown(server)} is of no use: {why}; {other}") from None
            with stream_to(_origin(path)) as stream:
                stream.write(shown(server).encode())
            complete(part, path)
        finally:
            part.unlink(missing_ok=True)

    def _unpacked(self, response: Response) -> Iterator[bytes]:
        """Yield the content of an answer as text."""
        if response.headers.get("Content-Encoding", "identity").lower() != "gzip":
            yield from self._connection.chunks(response)
            return
        inflate = zlib.decompressobj(wbits=31)
        try:
            for chunk in self._connection.chunks(response):
                yield inflate.decompress(chunk)
        except zlib.error as error:
            raise again(f"sends a damaged answer ({error})") from error
        if not inflate.eof:
            raise again("cut its answer short")


def _check(server: str, head: bytes, tail: bytes) -> None:
    """Refuse an answer that is none, or not whole, by its beginning and its end."""
    other = "check the address, or give another one with --overpass"
    if is_page(head) or b"<osm" not in head:
        message = plain_text(head)
        what = "a web page" if is_page(head) else "something else"
        if is_page(head) and _TOO_LARGE.search(message):
            raise _TooLargeError(message)
        raise ServerError(f"{shown(server)} gives {what} ({message or 'empty'}) instead of OSM data in XML; {other}")
    remark = _REMARK.search(tail)
    if remark is not None:
        message = plain_text(remark[1])
        if _TOO_LARGE.search(message):
            raise _TooLargeError(message)
        raise ServerError(f"{shown(server)} could not answer ({message}); try again later, or {other}")
    if not tail.rstrip().endswith(b"</osm>"):
        raise again("cut its answer short")


def _passes(check: Callable[[Path], object], path: Path) -> bool:
    """Whether an answer that is kept still is one."""
    try:
        check(path)
    except InputError:
        return False
    return True


def read_through(path: Path) -> None:
    """Read a map to its end; `InputError` if it is none, or damaged."""
    file = open_osm_file(path)
    with readable(file):
        # Most nodes have no tags, and are left to the library.
        for _ in osmium.FileProcessor(handle(file)).with_filter(osmium.filter.EmptyTagFilter()):
            pass


def forget(parts: Iterable[Path]) -> None:
    """Remove answers that are of no use, so that they are asked for anew."""
    for part in parts:
        part.unlink(missing_ok=True)


def fetch_parts(connection: Connection, box: Box, options: FetchOptions) -> list[Path]:
    """Return files that together hold what conversions read in a box; what several of them hold is the same.

    Raises
    ------
    InputError
        The area is too large to be asked of a public server.
    ServerError
        No server gives all of it.
    OutputError
        There is no room for it.
    """
    west, south, east, north = box
    if (east - west) * (north - south) > _BOX_MAX:
        raise InputError(
            f"the area has {(east - west) * (north - south):,.0f} square degrees, too much for the Overpass API; "
            "give a map of the country with --extract, such as one of download.geofabrik.de"
        )
    folder = options.cache_dir / "overpass"
    make_folder(folder)
    overpass = _Overpass(connection, options, folder)
    parts: list[Path] = []
    todo = [(box, 0)]
    progress = connection.network.progress
    while todo:
        part, depth = todo.pop()
        all_ = len(parts) + len(todo) + 1
        if all_ > _PARTS_MAX:
            raise ServerError(f"the servers of --overpass split the area over {_PARTS_MAX:,} times; give others")
        progress("asking for the map", f"{len(parts)} of {all_} parts are there", len(parts) / all_)
        found = _part(overpass, part, depth == 0, options.surroundings)
        if found is not None:
            parts.append(found)
        elif depth < _SPLITS_MAX:
            todo += [(quarter, depth + 1) for quarter in reversed(_quarters(part))]
        else:
            raise ServerError(
                f"the servers given with --overpass cannot give even a small part of it ({overpass.message}); "
                "give others"
            )
    return parts


def _part(overpass: _Overpass, box: Box, whole: bool, surroundings: bool) -> Path | None:
    """Return the file with what is in a box; None if it is too large and has to be split."""
    try:
        count, path = overpass.count(box)
        if whole and count > _AREA_MAX:
            forget([path])
            less = "leave out buildings and water with --no-surroundings, or " if surroundings else ""
            raise InputError(
                f"the area has {count:,} ways and objects, too many for the Overpass API; {less}give a map with "
                "--extract, such as one of download.geofabrik.de"
            )
        return None if count > _PART_MAX else overpass.area(box)
    except _TooLargeError as error:
        overpass.message = str(error)
        return None


def _count(path: Path) -> int:
    """Return the number of elements that an answer states; `InputError` if it states none."""
    # What is refused in maps, such as entities, is refused here as well.
    open_osm_file(path)
    try:
        tags = ElementTree.parse(path).iterfind("count/tag")
        total = next((tag.get("v", "") for tag in tags if tag.get("k") == "total"), "")
    except (ElementTree.ParseError, ValueError, LookupError):
        total = ""
    if not _NUMBER.fullmatch(total):
        raise InputError(f"{path} does not say how much there is in the area")
    return int(total)


def _quarters(box: Box) -> list[Box]:
    west, south, east, north = box
    x, y = 0.5 * (west + east), 0.5 * (south + north)
    return [(west, south, x, y), (x, south, east, y), (west, y, x, north), (x, y, east, north)]


def _origin(path: Path) -> Path:
    """Return the file that says which server an answer is from."""
    return path.with_suffix(".from")


def servers_of(parts: Iterable[Path]) -> list[str]:
    """Return the addresses of the servers that answers are from."""
    return sorted({_origin(part).read_text(encoding="utf-8") for part in parts if _origin(part).is_file()})


def data_date(path: Path) -> str:
    """Return the time that the data of an answer is of (``osm_base``); empty if it does not say."""
    with path.open("rb") as stream:
        found = re.search(rb'<meta[^>]*\bosm_base="([^"]+)"', stream.read(_ENDS))
    return "" if found is None else found[1].decode("ascii", "replace")


def count_query(box: Box, *, surroundings: bool) -> str:
    """Return the query for the number of elements in a box that `area_query` gives, without the nodes of ways."""
    if not surroundings:
        return f"{_SETTINGS}({_ways(box)}{_nodes(box)});out count;"
    return (
        f"{_SETTINGS}({_surroundings('rel', box)})->.areas;"
        f"({_ways(box)}{_nodes(box)}{_surroundings('way', box)}.areas;{_outlines(box)});out count;"
    )


def area_query(box: Box, *, surroundings: bool) -> str:
    """Return the query for all that conversions read in a box (west, south, east, north, degrees).

    Ways come whole, with all of their nodes; relations with all ways that they name. With `surroundings` that is also
    what scenes have beside roads; multipolygons of these come with the ways up to `OUTLINE_REACH` beyond the box.
    Ways and nodes that are only needed for outlines come without tags, so that conversions find nothing more.
    """
    kinds = "|".join(sorted(RELATION_TYPES))
    roads = (
        f"{_SETTINGS}({_ways(box)})->.ways;node(w.ways)->.corners;({_nodes(box)})->.things;"
        f'(rel(bw.ways)["type"~"^({kinds})$"];rel(bn.corners)["type"~"^({kinds})$"];)->.rules;'
        "way(r.rules)->.named;node(w.named)->.ends;"
        "(.ways;.corners;.things;.rules;.named;.ends;"
    )
    if not surroundings:
        return f"{roads});out meta;"
    return (
        f"{roads})->.roads;({_surroundings('rel', box)})->.areas;({_surroundings('way', box)})->.shown;"
        f"(.roads;.areas;.shown;)->.whole;({_outlines(box)}-.whole;)->.outlines;"
        "(.shown;.outlines;)->.lines;(node(w.lines);-.whole;)->.places;"
        ".whole out meta;(.outlines;.places;);out skel;"
    )


def _bounds(box: Box) -> str:
    """Return a box as filters have it. Each has one, since one for all would hold for the nodes of ways as well."""
    west, south, east, north = (f"{value:.7f}".rstrip("0").rstrip(".") for value in box)
    return f"({south},{west},{north},{east});"


def _ways(box: Box) -> str:
    values = way_values(frozenset(), _EXTRA)
    del values["highway"]
    others = (f'way["{key}"~"^({"|".join(sorted(names))})$"]' for key, names in sorted(values.items()))
    return "".join(f"{item}{_bounds(box)}" for item in ('way["highway"]', *others))


def _nodes(box: Box) -> str:
    keys, _ = node_keys(True, _EXTRA)
    wanted = (f'="{_VALUES[key]}"' if key in _VALUES else "" for key in sorted(keys))
    return "".join(f'node["{key}"{value}]{_bounds(box)}' for key, value in zip(sorted(keys), wanted, strict=True))


def _surroundings(kind: str, box: Box) -> str:
    """Return what asks for buildings and water: ``way`` for those that are ways, ``rel`` for multipolygons."""
    start = f'rel["type"="{AREA_TYPE}"]' if kind == "rel" else kind
    values = {key: sorted(value for of, value in SURROUNDINGS_TAGS if of == key) for key, _ in SURROUNDINGS_TAGS}
    filters = [f'["{key}"]' for key in sorted(SURROUNDINGS_KEYS)]
    filters += [f'["{key}"~"^({"|".join(names)})$"]' for key, names in sorted(values.items())]
    return "".join(f"{start}{item}{_bounds(box)}" for item in filters)


def _outlines(box: Box) -> str:
    """Return what asks for the ways of the multipolygons in the set ``areas`` that come with them."""
    return f"way(r.areas){_bounds(widened(box, OUTLINE_REACH))}"
