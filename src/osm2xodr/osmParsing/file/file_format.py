"""The format of an OSM file, found from its content before any parser sees it.

XML with a document type declaration is refused: OSM's own files have none, and only there can entities and external
references be declared, which can blow up or fetch other files.
"""

from __future__ import annotations

import codecs
import lzma
import re
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, BinaryIO, Final
from xml.parsers import expat

from osm2xodr.errors import InputError
from osm2xodr.osmParsing.file.preparation import (
    CHUNK,
    DAMAGED,
    RATIO_MAX,
    Copy,
    check_claims,
    decompressed,
    in_zip,
    plain_copy,
    too_large,
    unpack,
)
from osm2xodr.system import plain_text, record, xml_stream

# Bytes that are read at the start of a file, and in one go of its prolog.
_HEAD: Final = 4096
# OSM's files have no longer prolog than this, bytes.
_PROLOG_MAX: Final = 1 << 16
# Nor as many bytes without any markup, or in one element: OSM allows 32,000 members in a relation. The time of
# parsers grows with the square of such lengths, and a small file can decompress to a long one.
_ELEMENT_MAX: Final = 16 * CHUNK
_NODE: Final = b"<node"
_ELEMENTS: Final = (_NODE, b"<way", b"<relation")
# Messages of servers are shorter, bytes.
_MESSAGE_MAX: Final = 1 << 14

_MISC: Final = re.compile(r"\s+|<\?.*?\?>|<!--.*?-->", re.DOTALL)
_ROOT: Final = re.compile(r"<(!DOCTYPE\s+)?([A-Za-z_][^\s/>]*)[^>]*>", re.IGNORECASE)
_DELETED: Final = re.compile(rb"action\s*=\s*[\"']delete")
# What servers add to maps that they could not send in full: Overpass, and the API of OSM. And its longest beginning.
_REMARK: Final = re.compile(rb"<(remark|error)\b[^>]*>(.*?)</\1\s*>", re.DOTALL)
_REMARK_MAX: Final = 1 << 12
# With Overpass' ``out geom``; ``out center`` is about the middle of ways, and needs no copy.
_POSITION_ON_WAY: Final = re.compile(rb"<nd\s+(?:ref\s*=\s*[\"'][^\"'>]*[\"']\s+)?lat\s*=")
# Formats that users give by mistake, by their first bytes.
_OTHER_FORMATS: Final = (
    ((b"II*\0", b"MM\0*", b"II+\0"), "a TIFF raster"),
    ((b"{", b"["), "JSON"),
    ((b"\x89PNG", b"\xff\xd8\xff"), "a picture"),
    ((b"7z\xbc\xaf",), "compressed in a way that is not supported"),
    ((b"\xff\xe0\4o5m",), "in the format o5m"),
)
_EXPECTED: Final = "give OSM data as .osm or .osm.pbf"
_OVERPASS: Final = f"ask Overpass for XML, [out:xml] in place of [out:json], or {_EXPECTED}"
_LATER: Final = "ask its server again later, or for a smaller area"
# Elements that web pages begin with.
_OF_PAGES: Final = frozenset({"html", "head", "body", "title", "center", "h1", "p", "pre", "meta"})
# Paths lose one of the two slashes.
_ADDRESS: Final = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+:/")


@dataclass(slots=True)
class Content:
    """What libosmium reads of a file: itself, or a copy of it."""

    path: Path
    format: str  # ``pbf``, ``osm``, ``osm.gz`` or ``osm.bz2``, as libosmium names them
    copy: Copy | None = None  # Where it is one
    odd: str = ""  # What libosmium does not read in the file itself; empty if there is nothing
    nodes: int | None = None  # How many nodes there are; None where they were not counted
    # Of elements that were read and stand in the file more than once: what differs, by ``way/1`` or ``node/2``; and
    # those of which there are several versions
    repeated: dict[str, str] = field(default_factory=dict)
    several_versions: set[str] = field(default_factory=set)


@record
class OsmFile:
    """A file that looks like OSM data."""

    path: Path  # As users know it
    content: Content
    # (``node``, ``way`` or ``relation``, id) of elements that an editor has marked as deleted
    deleted: frozenset[tuple[str, int]] = frozenset()
    remark: str = ""  # What the server says if it could not send all of the map

    @property
    def format(self) -> str:
        """Its format, as libosmium names it."""
        return self.content.format

    def require_whole(self, allow_partial: bool) -> None:
        """Raise InputError if the server could not send all of the map, unless that is allowed."""
        if self.remark and not allow_partial:
            raise InputError(
                f"{self.path} is not whole, as its server says ({self.remark}); {_LATER}, or take what there is with "
                "--allow-partial"
            )

    def make_plain(self, odd: str) -> bool:
        """Replace what is read by a copy without what libosmium refuses; return whether that was done."""
        content = self.content
        if content.odd or content.format == "pbf":
            return False
        copy = plain_copy(content.path, content.format)
        if copy is None:
            return False
        content.path, content.format, content.copy, content.odd = copy.path, "osm", copy, odd
        content.nodes = _look_through(self.path, content).nodes
        return True


@dataclass(slots=True)
class _Findings:
    """What is in the text of a file."""

    deleted: bool = False  # Whether elements are marked as deleted
    positions_on_ways: bool = False
    nodes: int = 0
    remark: str = ""


def open_osm_file(path: Path) -> OsmFile:
    """Find the format of an OSM file.

    Raises InputError if it is missing, cannot be read, is not OSM data, or has a document type declaration.
    """
    head = _read_head(path)
    content = Content(path, "osm")
    opener = next((opener for start, opener in _packings() if head.startswith(start)), None)
    if opener is not None:
        content.copy = unpack(path, opener)
        content.path = content.copy.path
        with content.path.open("rb") as stream:
            head = stream.read(_HEAD)
    if b"OSMHeader" in head[:64]:
        content.format = "pbf"
        check_claims(content.path)
        return OsmFile(path, content)
    content.format = "osm.gz" if head.startswith(b"\x1f\x8b") else "osm.bz2" if head.startswith(b"BZh") else "osm"
    try:
        with decompressed(content.path, content.format) as stream:
            _check_prolog(path, stream)
        found = _look_through(path, content)
        content.nodes = found.nodes
        deleted = _deleted(content) if found.deleted else frozenset[tuple[str, int]]()
    except DAMAGED as error:
        raise InputError(f"{path} is damaged or incomplete ({error}); download or export it again") from error
    file = OsmFile(path, content, deleted, found.remark)
    if found.positions_on_ways:
        file.make_plain("positions of nodes stand on ways, as with Overpass' out geom")
    return file


def _packings() -> tuple[tuple[bytes, Callable[[Path], AbstractContextManager[IO[bytes]]]], ...]:
    """Return the first bytes of packed files that libosmium does not read, and what opens them."""
    return (b"\xfd7zXZ", lzma.open), (b"PK\3\4", in_zip), (b"\x28\xb5\x2f\xfd", _open_zstd)


def _open_zstd(path: Path) -> AbstractContextManager[IO[bytes]]:
    try:
        from compression import zstd  # type: ignore[import-not-found,unused-ignore]
    except ImportError:
        what = "is compressed by zstd, which Python reads from version 3.14 on"
        raise InputError(f"{path} {what}; unpack it with unzstd, and give the map") from None
    opened: AbstractContextManager[IO[bytes]] = zstd.open(path)
    return opened


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


def _check_prolog(path: Path, stream: BinaryIO) -> None:
    """Refuse what is none of OSM's XML by its beginning."""
    raw = b""
    while len(raw) < _PROLOG_MAX:
        more = stream.read(_HEAD)
        raw += more
        text = _text(raw).lstrip("\ufeff")
        at = 0
        while found := _MISC.match(text, at):
            at = found.end()
        if at < len(text) and text[at] != "<":
            raise _no_xml(path, raw + stream.read(_PROLOG_MAX))
        if root := _ROOT.match(text, at):
            if root[1] or root[2] != "osm":
                raise _other_xml(path, root[1] is not None, root[2], raw + stream.read(_PROLOG_MAX))
            return
        if not more:
            break
    raise InputError(f"{path} is no OSM data or incomplete; {_EXPECTED}")


def _no_xml(path: Path, raw: bytes) -> InputError:
    """Return why a file of another kind is refused."""
    what = next((what for starts, what in _OTHER_FORMATS if raw.startswith(starts)), None)
    if (what is None or what == "JSON") and (quote := _message(raw)):
        return InputError(f'{path} is no OSM data but a text ("{quote}"); if its server says so, {_LATER}')
    return InputError(f"{path} is {what or 'no OSM data'}; {_OVERPASS if what == 'JSON' else _EXPECTED}")


def _message(raw: bytes) -> str:
    """Return the text of a message of a server; empty if it is none."""
    words = _quote(raw)
    # What has no space is no sentence; maps in JSON have these.
    is_one = " " in words and b"\0" not in raw and b'"elements"' not in raw and b'"features"' not in raw
    return words if is_one and len(raw) < _MESSAGE_MAX else ""


def _quote(raw: bytes) -> str:
    return plain_text(_text(raw) if b"\0" in raw else raw)


def _other_xml(path: Path, declared: bool, name: str, raw: bytes) -> InputError:
    """Return why XML of another kind is refused, or whatever has a document type declaration."""
    if name.lower() in _OF_PAGES:
        return InputError(
            f'{path} is a web page, not a map ("{_quote(raw)}"); if its server could not help, {_LATER}'
        )
    if declared:
        return InputError(
            f"{path} is XML with a document type declaration, which can hold entities and external references "
            "and is refused; export the area again without it"
        )
    if re.search("error|exception|fault", name, re.IGNORECASE):
        return InputError(f'{path} is a message of its server, not a map ("{_quote(raw)}"); {_LATER}')
    return InputError(f"{path} is XML of another kind (<{name}>, not <osm>); {_EXPECTED}")


def _look_through(path: Path, content: Content) -> _Findings:
    """Find what the text of a file has; refuse files that would keep parsers busy for nothing."""
    found = _Findings()
    last = b""
    since = total = 0
    size = path.stat().st_size
    with decompressed(content.path, content.format) as stream:
        while chunk := stream.read(CHUNK):
            if len(chunk) == CHUNK and b"<" not in chunk:
                raise InputError(
                    f"{path} has {CHUNK >> 20} MB of text without any markup, which is not OSM's; {_EXPECTED}"
                )
            total += len(chunk)
            if too_large(total, size):
                raise InputError(
                    f"{path} holds over {RATIO_MAX} times its own size, which map data does not; {_EXPECTED}"
                )
            since = 0 if _has_element(chunk) else since + len(chunk)
            if since > _ELEMENT_MAX:
                raise InputError(
                    f"{path} has an element of over {_ELEMENT_MAX >> 20} MB, which OSM does not allow; {_EXPECTED}"
                )
            found.nodes += (last[-len(_NODE) + 1 :] + chunk).count(_NODE)
            _look_at(last + chunk, found)
            last = chunk[-_REMARK_MAX:]
    return found


def _look_at(text: bytes, found: _Findings) -> None:
    # `in` is many times faster than patterns, which are tried only where they can match.
    if not found.deleted and b"delete" in text:
        found.deleted = _DELETED.search(text) is not None
    if not found.positions_on_ways and b"<nd" in text:
        found.positions_on_ways = _POSITION_ON_WAY.search(text) is not None
    if (b"<remark" in text or b"<error" in text) and (remark := _REMARK.search(text)):
        quote = plain_text(remark[2])
        # Some remarks are about the query alone.
        if remark[1] == b"error" or "error" in quote.lower():
            found.remark = quote


def _has_element(chunk: bytes) -> bool:
    """Whether an element begins in some text, whatever the width of its characters."""
    return any(name in chunk for name in _ELEMENTS) or (
        b"\0" in chunk and any(name in chunk.replace(b"\0", b"") for name in _ELEMENTS)
    )


def _deleted(content: Content) -> frozenset[tuple[str, int]]:
    """Collect elements marked ``action="delete"``, as JOSM does; broken XML is left to the real parser to report."""
    found: set[tuple[str, int]] = set()

    def start(name: str, attributes: dict[str, str]) -> None:
        if attributes.get("action") == "delete":
            number = attributes.get("id", "")
            if number.lstrip("-").isdigit():
                found.add((name, int(number)))

    parser = expat.ParserCreate()
    parser.StartElementHandler = start
    with decompressed(content.path, content.format) as stream:
        try:
            parser.ParseFile(xml_stream(stream))
        except (expat.ExpatError, LookupError, ValueError):
            return frozenset()
    return frozenset(found)
