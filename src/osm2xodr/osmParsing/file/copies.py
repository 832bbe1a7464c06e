"""Copies of maps in a form that libosmium reads: unpacked, or without what is of no use to streets.

libosmium refuses a whole file for a date that is written in another way, a missing version or an element that it does
not know, and passes over positions that stand on ways (Overpass' ``out geom``).
"""

from __future__ import annotations

import bz2
import contextlib
import gzip
import lzma
import os
import tempfile
import weakref
import zipfile
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any, BinaryIO, Final, cast
from xml.parsers import expat

from osm2xodr.errors import InputError, OutputError
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
