"""Files that are downloaded once, as a whole, to the cache; a download that was cut goes on where it ended."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import time
import urllib.parse
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

from osm2xodr.errors import OutputError
from osm2xodr.fetching.connection import Connection, Response, again, host, mark_of, range_of, shown
from osm2xodr.fetching.options import ServerError
from osm2xodr.system import appended, complete, is_page, make_folder, parse_json, plain_text, record, stream_to

# Bytes that show what a file is.
_HEAD: Final = 4096
# Longest part of a file's own name that is kept in the cache, characters; a choice.
_NAME_MAX: Final = 80
_MEGABYTE: Final = 1e6
# Status of answers where a file ends before the part that was asked for (RFC 9110).
_NO_SUCH_RANGE: Final = 416


@record
class Wanted:
    """A file to download."""

    url: str  # Its address
    option: str  # The option that has given the address, for messages
    what: str  # What it should be, such as ``a GeoTIFF``
    looks_right: Callable[[bytes], bool]  # Whether its first bytes are those of such a file


def key_of(*parts: object) -> str:
    """Return a short name for what was asked for."""
    return hashlib.sha256("\n".join(map(str, parts)).encode()).hexdigest()[:16]


def download(connection: Connection, wanted: Wanted, folder: Path, age: float) -> Path:
    """Return the file at an address as a whole, from the cache if it was fetched less than `age`, s, ago.

    Raises `ServerError` if it cannot be had, and `OutputError` if there is no room for it.
    """
    make_folder(folder)
    name = urllib.parse.unquote(urllib.parse.urlsplit(wanted.url).path).rpartition("/")[2]
    clean = re.sub(r"[^\w.-]+", "_", name, flags=re.ASCII)[-_NAME_MAX:].lstrip(".-")
    path = folder / f"{key_of(wanted.url)}-{clean or 'file'}"
    if path.is_file() and time.time() - path.stat().st_mtime < age:
        return path
    part = path.with_name(f"{path.name}.part")
    state = _State(part)

    def read(response: Response) -> None:
        _receive(connection, wanted, response, part, state)

    try:
        connection.ask(wanted.url, wanted.option, read, state.headers)
    except ServerError as error:
        if error.status != _NO_SUCH_RANGE:
            raise
        # The part that is there is none of the file that is there now.
        part.unlink(missing_ok=True)
        connection.ask(wanted.url, wanted.option, read, state.headers)
    complete(part, path)
    state.forget()
    return path


class _State:
    """What is known about a file of which a part is there."""

    def __init__(self, part: Path) -> None:
        self._part = part
        self._file = part.with_name(f"{part.name}.json")

    def headers(self) -> Mapping[str, str]:
        """Return what asks for the rest of the file, if it still is the same."""
        mark, there = self._mark(), self.size()
        if not there or not mark:
            return {}
        return {"Range": f"bytes={there}-", "If-Range": mark}

    def size(self) -> int:
        """Return how much is there, bytes."""
        return self._part.stat().st_size if self._part.is_file() else 0

    def begin(self, mark: str) -> None:
        """Begin anew; by its mark the file is known again."""
        self._part.unlink(missing_ok=True)
        with stream_to(self._file) as stream:
            stream.write(json.dumps({"mark": mark}).encode())

    def forget(self) -> None:
        """Remove what is known."""
        self._file.unlink(missing_ok=True)

    def _mark(self) -> str:
        try:
            return str(parse_json(self._file.read_bytes())["mark"])
        except (OSError, ValueError, LookupError, TypeError):
            return ""


def _receive(connection: Connection, wanted: Wanted, response: Response, part: Path, state: _State) -> None:
    """Add an answer to the part of a file that is there."""
    there = state.size()
    begins, total = range_of(response)
    if response.status == 206 and begins != there:
        part.unlink(missing_ok=True)
        raise again("sends another part than it was asked for")
    if response.status != 206:
        state.begin(mark_of(response))
        there = 0
    _check_room(connection, wanted, part, there, total)
    head, checked = b"", there > 0
    try:
        with appended(part) as stream:
            for chunk in connection.chunks(response):
                head += chunk[: _HEAD - len(head)]
                if not checked and len(head) == _HEAD:
                    _check_head(wanted, head, response)
                    checked = True
                stream.write(chunk)
                there += len(chunk)
                _check_size(connection, wanted, there)
                of = f" of {total / _MEGABYTE:,.1f}" if total else ""
                share = there / total if total else None
                connection.network.progress(host(wanted.url), f"{there / _MEGABYTE:,.1f}{of} MB", share)
        if not checked:
            _check_head(wanted, head, response)
    except ServerError:
        part.unlink(missing_ok=True)
        raise


def _check_room(connection: Connection, wanted: Wanted, part: Path, there: int, total: int | None) -> None:
    """Refuse a file that is too large, before it is read."""
    if total is None:
        return
    _check_size(connection, wanted, total)
    free = shutil.disk_usage(part.parent).free
    if total - there > free:
        raise OutputError(
            f"{shown(wanted.url)} needs {(total - there) / _MEGABYTE:,.0f} MB, but {part.parent} has only "
            f"{free / _MEGABYTE:,.0f} MB left; free some space, or choose another folder with --cache"
        )


def _check_size(connection: Connection, wanted: Wanted, size: int) -> None:
    """Refuse a file of too many bytes."""
    most = connection.network.download_max
    if size > most:
        raise ServerError(
            f"{shown(wanted.url)} has {size / _MEGABYTE:,.1f} MB or more, but --max-download allows "
            f"{most / _MEGABYTE:,.1f} MB; allow more, or give a smaller one with {wanted.option}"
        )


def _check_head(wanted: Wanted, head: bytes, response: Response) -> None:
    """Refuse a file that is not what it should be by its first bytes."""
    if wanted.looks_right(head):
        return
    raise ServerError(not_wanted(wanted, head, response), response.status)


def not_wanted(wanted: Wanted, head: bytes, response: Response) -> str:
    """Return the sentence about an answer that is not what was asked for."""
    kind = plain_text(response.headers.get_content_type().encode())
    message = plain_text(head) if is_page(head) else ""
    found = f"a web page{f' ({message})' if message else ''}" if is_page(head) else f"something else ({kind})"
    if not head:
        found = "nothing"
    return (
        f"{shown(wanted.url)} gives {found} instead of {wanted.what}; check the address, or give another one with "
        f"{wanted.option}"
    )
