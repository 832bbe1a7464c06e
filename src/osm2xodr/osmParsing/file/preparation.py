"""What is done with a map before libosmium reads it.

It is copied in a form that libosmium reads: unpacked, or without what is of no use to streets. And a pbf file says
how much it becomes when it is read: few bytes can stand for gigabytes of nodes and tags.
"""

from __future__ import annotations

import bz2
import contextlib
import gzip
import lzma
import os
import struct
import tempfile
import weakref
import zipfile
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any, BinaryIO, Final, cast
from xml.parsers import expat

import numpy as np

from osm2xodr.errors import InputError, OutputError
from osm2xodr.model import IntArray
from osm2xodr.system import xml_stream

CHUNK: Final = 1 << 20
# OSM's text is compressed some fifteenfold; beyond this many bytes of text, a ratio above this is refused.
RATIO_MAX: Final = 200
RATIO_CHECKED_FROM: Final = 64 * CHUNK
DAMAGED: Final = (OSError, EOFError, zlib.error, lzma.LZMAError, zipfile.BadZipFile)
# Names of maps in zip archives, and of files that archives of one system have for the others.
_MAPS: Final = (".osm", ".xml", ".pbf")
_BESIDE: Final = "__MACOSX/"
# What is kept of each element, by its name in OSM's XML; versions and deletions only where they can be read.
_ATTRIBUTES: Final = {
    "node": ("id", "lat", "lon"),
    "way": ("id",),
    "relation": ("id",),
    "bounds": ("minlat", "minlon", "maxlat", "maxlon"),
    "nd": ("ref",),
    "member": ("type", "ref", "role"),
    "tag": ("k", "v"),
}
_OBJECTS: Final = ("node", "way", "relation")
_VERSION_MAX: Final = 1 << 31

# What is needed for a dense node, for another element, of which Python has objects, and for a node of a way or a
# member of a relation, bytes.
_NODE: Final = 64
_ELEMENT: Final = 500
_MEMBER: Final = 16
# Most that a file may become, bytes: a part for files of any size, and one for each of its bytes. In extracts of
# 1 to 3 MB a byte becomes 10 to 20.
_ANY: Final = 256_000_000
_PER_BYTE: Final = 100
# Files up to this size, bytes, and blocks of larger ones that unpack to more than this many times their size are
# looked into. In extracts a block unpacks to 3.3 times its size at most.
_SMALL: Final = 1_000_000
_UNUSUAL: Final = 8
# Longest header of a block, and longest block when it is unpacked, bytes, by the format.
_HEADER_MAX: Final = 64 * 1024
_BLOCK_MAX: Final = 32 * 1024 * 1024
# Numbers of fields: of a block, of dense nodes, and of nodes, ways and relations by themselves.
_STRINGS, _GROUP, _DENSE = 1, 2, 2
_IDS, _DENSE_INFO, _DENSE_TAGS, _USERS = 1, 5, 10, 5
_TAGS: Final = (2, 3)
_MEMBERS: Final = (8, 9)
# Kinds of fields, and the size of those that have one of their own, bytes.
_VARINT, _BYTES = 0, 2
_SIZES: Final = {1: 8, 5: 4}


class Copy:
    """A temporary file, which is there as long as this is."""

    def __init__(self, suffix: str) -> None:
        try:
            descriptor, name = tempfile.mkstemp(suffix, "osm2xodr-")
        except OSError as error:
            raise _unwritten(Path(tempfile.gettempdir()), error) from error
        os.close(descriptor)
        self.path = Path(name)
        weakref.finalize(self, _remove, self.path, os.getpid())


def _remove(path: Path, owner: int) -> None:
    # Not in copies of the process, which end before it.
    if os.getpid() == owner:
        path.unlink(missing_ok=True)


def _unwritten(path: Path, error: OSError) -> OutputError:
    reason = (error.strerror or str(error)).lower()
    return OutputError(f"cannot write {path}: {reason}; free some space, or name another folder with TMPDIR")


def decompressed(path: Path, kind: str) -> BinaryIO:
    """Open a file for reading; `kind` is what libosmium calls its format."""
    opener: Any = {"osm.gz": gzip.open, "osm.bz2": bz2.open}.get(kind, open)
    return cast("BinaryIO", opener(path, "rb"))


def too_large(total: int, size: int) -> bool:
    """Whether a file of `size` bytes becomes far larger than map data do, with `total` bytes so far."""
    return total > max(RATIO_CHECKED_FROM, RATIO_MAX * size)


def unpack(path: Path, opener: Callable[[Path], contextlib.AbstractContextManager[IO[bytes]]]) -> Copy:
    """Unpack a file of a kind that libosmium does not; `InputError` if it is damaged or far too large."""
    copy, total, size = Copy(".osm"), 0, path.stat().st_size
    try:
        with opener(path) as stream:
            while chunk := stream.read(CHUNK):
                total += len(chunk)
                if too_large(total, size):
                    raise InputError(
                        f"{path} holds over {RATIO_MAX} times its own size, which map data does not; give OSM data"
                    )
                _append(copy.path, chunk)
    except DAMAGED as error:
        raise InputError(f"{path} is damaged or incomplete ({error}); download or export it again") from error
    return copy


def _append(path: Path, chunk: bytes) -> None:
    try:
        with path.open("ab") as stream:
            stream.write(chunk)
    except OSError as error:
        raise _unwritten(path, error) from error


@contextlib.contextmanager
def in_zip(path: Path) -> Iterator[IO[bytes]]:
    """Open the one map in a zip archive; `InputError` if there is none, more than one, or it is encrypted."""
    remedy = "unpack it, and give the map"
    with zipfile.ZipFile(path) as archive:
        files = [item for item in archive.infolist() if not item.is_dir() and not item.filename.startswith(_BESIDE)]
        maps = [item for item in files if item.filename.lower().endswith(_MAPS)] or files
        if len(maps) != 1:
            raise InputError(f"{path} is a zip archive of {len(maps)} files, not of one map; {remedy}")
        try:
            with archive.open(maps[0]) as stream:
                yield stream
        except (NotImplementedError, RuntimeError) as error:
            raise InputError(f"{path} is a zip archive that cannot be read ({error}); {remedy}") from error


def plain_copy(path: Path, kind: str) -> Copy | None:
    """Copy what streets need of an XML file; None if it is no XML, so that there is nothing to copy."""
    copy = Copy(".osm")
    try:
        with decompressed(path, kind) as packed, copy.path.open("w", encoding="utf-8") as out:
            _Copying(out).run(xml_stream(packed))
    except (expat.ExpatError, LookupError, ValueError, *DAMAGED):
        return None
    return copy


class _Copying:
    """Writes the elements of a file anew, and the nodes whose positions stand on ways."""

    def __init__(self, out: IO[str]) -> None:
        self._out = out
        self._parser = parser = expat.ParserCreate()
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        self._open: str | None = None  # The node, way or relation that the next elements belong to
        self._depth = 0
        self._nodes: set[str] = set()
        self._positions: dict[str, tuple[str, str]] = {}

    def run(self, stream: BinaryIO) -> None:
        self._out.write('<osm version="0.6">\n')
        while chunk := stream.read(CHUNK):
            self._parser.Parse(chunk, False)
        self._parser.Parse(b"", True)
        for ref, (lat, lon) in self._positions.items():
            if ref not in self._nodes:
                self._write("node", {"id": ref, "lat": lat, "lon": lon}, "/>\n")
        self._out.write("</osm>\n")

    def _start(self, name: str, found: dict[str, str]) -> None:
        self._depth += 1
        if name == "bounds" and self._open is None:
            self._write(name, found, "/>\n")
        elif name in _OBJECTS and self._open is None:
            self._open = name
            if name == "node":
                self._nodes.add(found.get("id", ""))
            self._write(name, found, ">")
        # Members of relations have elements of their own with Overpass' ``out geom``.
        elif name in _ATTRIBUTES and self._open is not None and self._depth == 3:
            self._write(name, found, "/>")
            if name == "nd" and "lat" in found and "lon" in found:
                self._positions[found.get("ref", "")] = found["lat"], found["lon"]

    def _end(self, name: str) -> None:
        self._depth -= 1
        if name == self._open and self._depth == 1:
            self._out.write(f"</{name}>\n")
            self._open = None

    def _write(self, name: str, found: dict[str, str], end: str) -> None:
        # Here, as few files need a copy.
        from xml.sax.saxutils import quoteattr

        kept = {key: found[key] for key in _ATTRIBUTES[name] if found.get(key) or (key in found and name != "node")}
        if name in _OBJECTS:
            version = found.get("version", "")
            if version.isascii() and version.isdigit() and int(version) < _VERSION_MAX:
                kept["version"] = version
            if found.get("visible") == "false":
                kept["visible"] = "false"
        self._out.write(f"<{name} {' '.join(f'{key}={quoteattr(value)}' for key, value in kept.items())}{end}")


def check_claims(path: Path) -> None:
    """Raise InputError if a pbf file becomes far more than its size when it is read."""
    left = _ANY + _PER_BYTE * path.stat().st_size
    try:
        for content in _blobs(path):
            left -= _claimed(content, left)
            if left < 0:
                raise InputError(
                    f"{path} holds far more elements and text than map data of its size ({_ANY / 1e6:g} MB and"
                    f" {_PER_BYTE} times the file); give OSM data as .osm or .osm.pbf"
                )
    except (zlib.error, struct.error, IndexError, KeyError, ValueError, OverflowError):
        return


def _blobs(path: Path) -> Iterator[bytes]:
    """Yield the contents of data blocks that can claim much."""
    small = path.stat().st_size <= _SMALL
    with path.open("rb") as stream:
        while head := stream.read(4):
            length = struct.unpack(">I", head)[0]
            if length > _HEADER_MAX:
                return
            header = dict(_fields(stream.read(length)))
            size = header.get(3)
            if not isinstance(size, int) or size > _BLOCK_MAX:
                return
            blob = dict(_fields(stream.read(size)))
            packed, raw = blob.get(3), blob.get(2)
            if header.get(1) != b"OSMData" or not isinstance(raw, int):
                continue
            if isinstance(packed, bytes) and (small or raw > _UNUSUAL * len(packed)):
                yield zlib.decompressobj().decompress(packed, min(raw, _BLOCK_MAX))


def _claimed(block: bytes, most: int) -> int:
    """Return how many bytes the elements of a block become; any number above `most` if it is more."""
    lengths, total = np.zeros(0, np.int64), 0
    # Few bytes become many elements only where these are alike.
    known: dict[tuple[int, bytes], int] = {}
    for number, field in _fields(block):
        if not isinstance(field, bytes):
            continue
        if number == _STRINGS:
            known.clear()
            lengths = np.array([len(text) for _, text in _fields(field) if isinstance(text, bytes)], np.int64)
        elif number == _GROUP:
            for kind, element in _fields(field):
                if isinstance(element, bytes):
                    one = (kind, element)
                    if one not in known:
                        known[one] = (_dense if kind == _DENSE else _single)(element, lengths)
                    total += known[one]
                if total > most:
                    return total
    return total


def _dense(nodes: bytes, lengths: IntArray) -> int:
    found = dict(_fields(nodes))
    total = _NODE * len(_numbers(found.get(_IDS, b""))) + _text(found.get(_DENSE_TAGS, b""), lengths)
    info = found.get(_DENSE_INFO, b"")
    users = _numbers(dict(_fields(info)).get(_USERS, b"") if isinstance(info, bytes) else b"")
    # Users are told by their difference to the one before, with the sign in the last bit.
    places = np.cumsum((users >> 1) ^ -(users & 1))
    return total + int(lengths[places[(places >= 0) & (places < len(lengths))]].sum())


def _single(element: bytes, lengths: IntArray) -> int:
    total = _ELEMENT
    for number, field in _fields(element):
        if not isinstance(field, bytes):
            continue
        if number in _TAGS:
            total += _text(field, lengths)
        elif number in _MEMBERS:
            total += _MEMBER * len(_numbers(field))
    return total


def _text(places: int | bytes, lengths: IntArray) -> int:
    """Return the length of the texts at some places of the block's table."""
    found = _numbers(places)
    return int(lengths[found[found < len(lengths)]].sum())


def _fields(data: bytes) -> Iterator[tuple[int, int | bytes]]:
    """Yield the fields of a message: their numbers, and whole numbers or bytes."""
    at = 0
    while at < len(data):
        key, at = _number(data, at)
        kind = key & 7
        if kind == _VARINT:
            value, at = _number(data, at)
            yield key >> 3, value
            continue
        size, at = _number(data, at) if kind == _BYTES else (_SIZES[kind], at)
        yield key >> 3, data[at : at + size]
        at += size


def _number(data: bytes, at: int) -> tuple[int, int]:
    value = shift = 0
    while True:
        byte = data[at]
        value |= (byte & 127) << shift
        at, shift = at + 1, shift + 7
        if byte < 128:
            return value, at


def _numbers(data: int | bytes) -> IntArray:
    """Return packed numbers, (n,); those of more than 21 bits are of no use here, and cut."""
    found = np.frombuffer(data if isinstance(data, bytes) else b"", np.uint8).astype(np.int64)
    last = np.flatnonzero(found < 128)
    if len(last) == len(found):
        return found
    first = np.concatenate([[0], last[:-1] + 1]) if len(last) else last
    out: IntArray = found[first] & 127
    for k in (1, 2):
        longer = first + k <= last
        out[longer] |= (found[first[longer] + k] & 127) << 7 * k
    return out
