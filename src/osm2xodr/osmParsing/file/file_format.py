"""The format of an OSM file, found from its content before any parser sees it.

XML with a document type declaration is refused: OSM's own files have none, and only there can entities and external
references be declared, which can blow up or fetch other files.
"""

from __future__ import annotations

import bz2
import codecs
import gzip
import re
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Final, cast
from xml.parsers import expat

from osm2xodr.errors import InputError

# Bytes that are read at the start of a file, and in one go of its prolog.
_HEAD: Final = 4096
# OSM's files have no longer prolog than this, bytes.
_PROLOG_MAX: Final = 1 << 16
# Nor as many bytes without any markup, or in one element: OSM allows 32,000 members in a relation. The time of
# parsers grows with the square of such lengths, and a small file can decompress to a long one.
_CHUNK: Final = 1 << 20
_ELEMENT_MAX: Final = 16 * _CHUNK
# OSM's text is compressed some fifteenfold; beyond this many bytes of text, a ratio above this is refused.
_RATIO_MAX: Final = 200
_RATIO_CHECKED_FROM: Final = 64 * _CHUNK
_ELEMENTS: Final = (b"<node", b"<way", b"<relation")

_MISC: Final = re.compile(r"\s+|<\?.*?\?>|<!--.*?-->", re.DOTALL)
_ROOT: Final = re.compile(r"<([A-Za-z_][^\s/>]*)[^>]*>")
_DELETED: Final = re.compile(rb"action\s*=\s*[\"']delete")
# Formats that users give by mistake, by their first bytes.
_OTHER_FORMATS: Final = (
    ((b"II*\0", b"MM\0*", b"II+\0"), "a TIFF raster"),
    ((b"PK\3\4",), "a zip archive"),
    ((b"{", b"["), "JSON"),
    ((b"\x89PNG", b"\xff\xd8\xff"), "a picture"),
    ((b"\xfd7zXZ", b"\x28\xb5\x2f\xfd", b"7z\xbc\xaf"), "compressed in a way that is not supported"),
    ((b"\xff\xe0\4o5m",), "in the format o5m"),
)
_EXPECTED: Final = "give OSM data as .osm, .osm.gz, .osm.bz2 or .osm.pbf"
_OVERPASS: Final = f"ask Overpass for XML, [out:xml] in place of [out:json], or {_EXPECTED}"
# Paths lose one of the two slashes.
_ADDRESS: Final = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+:/")
_DAMAGED: Final = (OSError, EOFError, zlib.error)


@dataclass(frozen=True, slots=True)
class OsmFile:
    """A file that looks like OSM data."""

    path: Path
    format: str  # ``pbf``, ``osm``, ``osm.gz`` or ``osm.bz2``, as libosmium names them
    # (``node``, ``way`` or ``relation``, id) of elements that an editor has marked as deleted
    deleted: frozenset[tuple[str, int]] = frozenset()


def open_osm_file(path: Path) -> OsmFile:
    """Find the format of an OSM file.

    Raises InputError if it is missing, cannot be read, is not OSM data, or has a document type declaration.
    """
    head = _read_head(path)
    if b"OSMHeader" in head[:64]:
        return OsmFile(path, "pbf")
    kind = "osm.gz" if head.startswith(b"\x1f\x8b") else "osm.bz2" if head.startswith(b"BZh") else "osm"
    if kind == "osm" and not _text(head).lstrip("\ufeff \t\r\n").startswith("<"):
        what = next((what for starts, what in _OTHER_FORMATS if head.startswith(starts)), None)
        remedy = _OVERPASS if what == "JSON" else _EXPECTED
        raise InputError(f"{path} is {what or 'no OSM data'}; {remedy}")
    try:
        with _decompressed(path, kind) as stream:
            _check_prolog(path, stream)
        deleted = _deleted(path, kind) if _mentions_deleted(path, kind) else frozenset[tuple[str, int]]()
    except _DAMAGED as error:
        raise InputError(f"{path} is damaged or incomplete ({error}); download or export it again") from error
    return OsmFile(path, kind, deleted)


def _read_head(path: Path) -> bytes:
    if not path.exists():
        if _ADDRESS.match(str(path)):
            raise InputError(f"{path.name} is read from a file alone, not from an address; download it first")
        raise InputError(f"{path} does not exist; check the path of the OSM file")
    if not path.is_file():
        what = "a directory" if path.is_dir() else "no regular file"
        raise InputError(f"{path} is {what}; {_EXPECTED}")
    try:
        with path.open("rb") as stream:
            head = stream.read(_HEAD)
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror}); check its permissions") from error
    if not head:
        raise InputError(f"{path} is empty; download or export it again")
    return head


def _text(raw: bytes) -> str:
    """Decode the start of an XML file as far as its markup goes (XML 1.0, appendix F)."""
    if raw.startswith(codecs.BOM_UTF8):
        raw = raw[len(codecs.BOM_UTF8) :]
    elif raw.startswith((codecs.BOM_UTF16_LE, b"<\0")):
        return raw.decode("utf-16-le", "replace")
    elif raw.startswith((codecs.BOM_UTF16_BE, b"\0<")):
        return raw.decode("utf-16-be", "replace")
    return raw.decode("latin-1")


def _decompressed(path: Path, kind: str) -> BinaryIO:
    opener: Any = {"osm.gz": gzip.open, "osm.bz2": bz2.open}.get(kind, open)
    return cast("BinaryIO", opener(path, "rb"))


def _check_prolog(path: Path, stream: BinaryIO) -> None:
    """Refuse files other than OSM's XML by what comes before their content."""
    raw = b""
    while len(raw) < _PROLOG_MAX:
        more = stream.read(_HEAD)
        raw += more
        text = _text(raw).lstrip("\ufeff")
        at = 0
        while found := _MISC.match(text, at):
            at = found.end()
        if text.startswith("<!DOCTYPE", at):
            raise InputError(
                f"{path} is XML with a document type declaration, which can hold entities and external references "
                "and is refused; export the area again without it"
            )
        root = _ROOT.match(text, at)
        if root:
            if root[1] != "osm":
                raise InputError(f"{path} is XML of another kind (<{root[1]}>, not <osm>); {_EXPECTED}")
            return
        if not more:
            break
    raise InputError(f"{path} is no OSM data or incomplete; {_EXPECTED}")


def _mentions_deleted(path: Path, kind: str) -> bool:
    """Return whether anything is marked as deleted; refuse files that would keep parsers busy for nothing."""
    last = b""
    found = False
    since = total = 0
    most = max(_RATIO_CHECKED_FROM, _RATIO_MAX * path.stat().st_size)
    with _decompressed(path, kind) as stream:
        while chunk := stream.read(_CHUNK):
            if len(chunk) == _CHUNK and b"<" not in chunk:
                raise InputError(
                    f"{path} has {_CHUNK >> 20} MB of text without any markup, which is not OSM's; {_EXPECTED}"
                )
            total += len(chunk)
            if total > most:
                raise InputError(
                    f"{path} holds over {_RATIO_MAX} times its own size, which map data does not; {_EXPECTED}"
                )
            since = 0 if _has_element(chunk) else since + len(chunk)
            if since > _ELEMENT_MAX:
                raise InputError(
                    f"{path} has an element of over {_ELEMENT_MAX >> 20} MB, which OSM does not allow; {_EXPECTED}"
                )
            # `in` is many times faster than the pattern, which is tried only where it can match.
            if not found and (b"delete" in chunk or b"delete" in last + chunk[:64]):
                found = _DELETED.search(last + chunk) is not None
            last = chunk[-64:]
    return found


def _has_element(chunk: bytes) -> bool:
    """Whether an element begins in some text, whatever the width of its characters."""
    return any(name in chunk for name in _ELEMENTS) or (
        b"\0" in chunk and any(name in chunk.replace(b"\0", b"") for name in _ELEMENTS)
    )


def _deleted(path: Path, kind: str) -> frozenset[tuple[str, int]]:
    """Collect elements marked ``action="delete"``, as JOSM does; broken XML is left to the real parser to report."""
    found: set[tuple[str, int]] = set()

    def start(name: str, attributes: dict[str, str]) -> None:
        if attributes.get("action") == "delete":
            number = attributes.get("id", "")
            if number.lstrip("-").isdigit():
                found.add((name, int(number)))

    parser = expat.ParserCreate()
    parser.StartElementHandler = start
    with _decompressed(path, kind) as stream:
        try:
            parser.ParseFile(stream)
        except expat.ExpatError:
            return frozenset()
    return frozenset(found)
