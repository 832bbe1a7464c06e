"""Files on servers, of which parts are read as if they were local."""

from __future__ import annotations

import os
from collections import OrderedDict
from typing import Any, Final

from osm2xodr.fetching.addresses import shown
from osm2xodr.fetching.connection import Connection, Response, again, mark_of, range_of
from osm2xodr.fetching.options import ServerError

# Bytes that are asked for at the least, and at the most: where one part after the other is read, twice as many each
# time. And how much is kept of a file, in parts. Choices: 16 kB (the head of usual files), 4 MB and 64 MB.
PART: Final = 1 << 14
_PARTS_AT_ONCE: Final = 256
_PARTS_KEPT: Final = 4096


class RemoteFile:
    """A file on a server, which GDAL reads through rasterio.

    GDAL's callbacks must not fail: the first fault is kept in `fault`, and nothing is read from then on.
    """

    # Rasterio opens a file anew by its file system, which is this object too.
    path = mode = "rb"

    def __init__(self, connection: Connection, url: str, size: int, mark: str, head: bytes) -> None:
        self.fault: BaseException | None = None
        self._connection = connection
        self._url, self._size, self._mark = url, size, mark
        self._place = 0
        self._parts = OrderedDict({0: head}) if len(head) == min(PART, size) else OrderedDict[int, bytes]()
        self._next, self._run = -1, 1
        self._received = 0

    @property
    def fs(self) -> RemoteFile:
        """Return what opens the file."""
        return self

    def open(self, *_: Any) -> RemoteFile:
        """Return the file."""
        return self

    def close(self) -> None:
        """Do nothing: no connection stays open."""

    def tell(self) -> int:
        """Return where it is read next."""
        return self._place

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Set where it is read next, and return that."""
        start = {os.SEEK_SET: 0, os.SEEK_CUR: self._place, os.SEEK_END: self._size}[whence]
        self._place = max(0, start + offset)
        return self._place

    def read(self, count: int = -1) -> bytes:
        """Return what follows; less of it where the file ends, or where a fault is kept."""
        end = self._size if count < 0 else min(self._place + count, self._size)
        found = bytearray()
        try:
            while self.fault is None and self._place < end:
                number, first = divmod(self._place, PART)
                piece = self._part(number, (end - 1) // PART)[first : first + end - self._place]
                found += piece
                self._place += len(piece)
        except BaseException as error:
            self.fault = error
        return bytes(found) if self.fault is None else b""

    def _part(self, number: int, last: int) -> bytes:
        """Return a part; with it those up to another one are fetched, as far as none of them is there."""
        if number not in self._parts:
            self._run = min(2 * self._run, _PARTS_AT_ONCE) if number == self._next else 1
            count = 1
            most = min(max(last - number + 1, self._run), _PARTS_AT_ONCE, -(-self._size // PART) - number)
            while count < most and number + count not in self._parts:
                count += 1
            content = self._fetch(number * PART, min((number + count) * PART, self._size))
            for place in range(count):
                self._parts[number + place] = content[place * PART : (place + 1) * PART]
            self._next = number + count
            while len(self._parts) > _PARTS_KEPT:
                self._parts.popitem(last=False)
        self._parts.move_to_end(number)
        return self._parts[number]

    def _fetch(self, begin: int, end: int) -> bytes:
        """Return the bytes from `begin` up to `end`."""

        def read(response: Response) -> bytes:
            begins, size = range_of(response)
            mark = mark_of(response)
            if response.status != 206 or size != self._size or (mark and self._mark and mark != self._mark):
                raise ServerError(f"{shown(self._url)} has changed while it was read; start the same command again")
            if begins != begin:
                raise again("sends another part than it was asked for")
            content = bytearray()
            for chunk in self._connection.chunks(response):
                content += chunk
                if len(content) > end - begin:
                    break
            if len(content) != end - begin:
                raise again("sends another part than it was asked for")
            return bytes(content)

        self._received += end - begin
        most = self._connection.network.download_max
        if self._received > most:
            raise ServerError(
                f"{shown(self._url)} takes over {most / 1e6:,.1f} MB to be read, but --max-download allows no more; "
                "allow more, or give another address with --dem-url"
            )
        wanted = {"Range": f"bytes={begin}-{end - 1}"}
        return self._connection.ask(self._url, "--dem-url", read, lambda: wanted)
