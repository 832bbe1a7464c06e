"""XML as elements in columns, some children of the root at a time, and parts of a large document side by side.

The parser is expat: it counts lines beyond 65535, never opens a second file, and is part of Python. Declarations of
document types are refused: entities can make a small file grow without bounds.
"""

from __future__ import annotations

import contextlib
import re
import sys
import zlib
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import BinaryIO, Final
from xml.parsers import expat

from osm2xodr.errors import InputError
from osm2xodr.opendrive.reader.elements import TAGS, TEXT, Columns, Elements, Node, Role
from osm2xodr.system import advance, record, xml_stream

_CHUNK: Final = 1 << 18
_STANDARD_INPUT: Final = Path("-")
# The element whose text is read.
_WITH_TEXT: Final = "geoReference"
# Elements that are open within a child of the root, at least.
_INSIDE: Final = 2
# Most elements within each other, a choice: ten times what OpenDRIVE itself has, as foreign ones may be within them.
_DEEPEST: Final = 100

# Parts are at least this large, bytes: below, copies of the process cost as much as they save. A choice.
_LEAST_PART: Final = 8_000_000
# Roads lie one after another below the root: a part begins with one.
_ROAD: Final = re.compile(rb"<road[\s>]")
_ROOT: Final = b"OpenDRIVE"
# What is read at once to find a road, bytes: more than one road takes.
_WINDOW: Final = 1 << 22
_ENCODING: Final = re.compile(rb"""<\?xml[^>]*encoding=["']([^"']*)""")
# Encodings in which every byte below 128 is the letter of ASCII, so that parts can be told, and that expat assumes.
_PLAIN: Final = frozenset({b"utf-8", b"us-ascii", b"ascii"})


class _DoctypeError(Exception):
    """The document declares its type."""


class _DepthError(Exception):
    """Elements are nested too deeply."""


class ElementReader:
    """Reads a document, or a part of one as if it were one; its outermost element is `root`, once that has begun."""

    def __init__(self, path: Path, part: Part | None = None) -> None:
        self.root: Node | None = None
        self._path = path
        self._part = part
        self._lines_before = part.lines_before if part else 0
        self._roads = 0
        # Of the root and of its children that were not handed over: see `Columns`.
        self._columns: Columns = ([], [], [], [])
        self._ends: list[str] = []
        self._names = list(TAGS)
        self._numbers = {name: k for k, name in enumerate(TAGS)}
        self._parser = parser = expat.ParserCreate()
        parser.buffer_text = True
        parser.StartElementHandler = self._starter()
        parser.EndElementHandler = self._ends.append
        parser.StartDoctypeDeclHandler = self._refuse

    def elements(self) -> Iterator[Elements]:
        """Yield the children of the root, some at a time; `InputError` if the file cannot be read or is not XML."""
        try:
            for chunk, share in _chunks(self._path, self._part):
                advance(share)
                self._parser.Parse(chunk, not chunk)
                if found := self._ended():
                    yield found
        except expat.ExpatError as error:
            reason = expat.errors.messages.get(error.code, "it cannot be parsed")
            raise InputError(
                f"{self._path} is not XML that can be read: {reason} in line {error.lineno}; give a file of OpenDRIVE"
            ) from error
        except _DoctypeError as error:
            reason = "declares a document type, which OpenDRIVE does not have; remove <!DOCTYPE>"
            raise InputError(f"{self._path} {reason}") from error
        except _DepthError as error:
            where = f"in line {self._parser.CurrentLineNumber + self._lines_before}"
            raise InputError(
                f"{self._path} has over {_DEEPEST} elements within each other {where}; give a file of OpenDRIVE"
            ) from error
        except (LookupError, ValueError) as error:
            # Raised by expat when Python has no codec for the declared encoding.
            reason = f"has an encoding that cannot be read ({error}); write it in UTF-8"
            raise InputError(f"{self._path} {reason}") from error
        except (OSError, EOFError, zlib.error) as error:
            reason = (getattr(error, "strerror", None) or str(error)).lower()
            raise InputError(f"cannot read {self._path}: {reason}; give a file of OpenDRIVE") from error

    def _starter(self) -> Callable[[str, dict[str, str]], None]:
        """Return what begins an element; most of the time of reading is spent in here."""
        codes, attributes, lines, depths = self._columns
        numbers, ends, parser = self._numbers, self._ends, self._parser

        def start(tag: str, found: dict[str, str]) -> None:
            number = numbers.get(tag)
            depth = len(depths) - len(ends)
            if depth > _DEEPEST:
                raise _DepthError
            codes.append(self._other(tag, found) if number is None else number)
            attributes.append(found)
            lines.append(parser.CurrentLineNumber)
            depths.append(depth)

        return start

    def _other(self, tag: str, attributes: dict[str, str]) -> int:
        """Return the number of a name that has none, and listen to the text of ``<geoReference>``."""
        name = tag.rpartition(":")[2]
        number = self._numbers.get(name, len(self._names))
        if number == len(self._names):
            self._names.append(name)
        if name != _WITH_TEXT:
            self._numbers[tag] = number
            return number
        texts: list[str] = []
        self._parser.CharacterDataHandler = texts.append
        self._parser.EndElementHandler = partial(self._end_text, attributes, texts)
        return number

    def _end_text(self, attributes: dict[str, str], texts: list[str], tag: str) -> None:
        """End an element while the text of ``<geoReference>``, whose attributes these are, is read."""
        self._ends.append(tag)
        if tag.rpartition(":")[2] == _WITH_TEXT:
            attributes[TEXT] = "".join(texts)
            self._parser.CharacterDataHandler = None
            self._parser.EndElementHandler = self._ends.append

    def _ended(self) -> Elements | None:
        """Hand over the children of the root that have ended, if there are any."""
        codes, attributes, lines, depths = self._columns
        if self.root is None and codes:
            self.root = Node(self._names[codes[0]], attributes[0], self._lines_before + lines[0])
        still_open = len(codes) - len(self._ends)
        last = len(codes) if still_open < _INSIDE else len(depths) - 1 - depths[::-1].index(1)
        if last < _INSIDE:
            return None
        some = (codes[:last], attributes[:last], lines[:last], depths[:last])
        out = Elements(self._names, some, self._lines_before, self._roads)
        self._roads += len(out.of(Role.ROAD))
        # The root stays. All others have ended.
        for column in self._columns:
            del column[1:last]
        del self._ends[: last - 1]
        return out

    def _refuse(self, *_: object) -> None:
        """Stop at a declaration of a document type."""
        raise _DoctypeError


def _chunks(path: Path, part: Part | None) -> Iterator[tuple[bytes, float]]:
    """Yield the bytes of a document one after another, an empty piece at last, each with the share read so far."""
    if part is None:
        with _opened(path) as (stream, share):
            more = True
            while more:
                chunk = stream.read(_CHUNK)
                more = bool(chunk)
                yield chunk, share()
        return
    if part.head:
        yield part.head, 0.0
    with path.open("rb") as file:
        file.seek(part.first)
        left = part.last - part.first
        while left > 0 and (chunk := file.read(min(_CHUNK, left))):
            left -= len(chunk)
            yield chunk, 1.0 - left / (part.last - part.first)
    if part.tail:
        yield part.tail, 1.0
    yield b"", 1.0


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[tuple[BinaryIO, Callable[[], float]]]:
    """Open a file that may be compressed; the function tells what share of it was read."""
    if path == _STANDARD_INPUT:
        yield xml_stream(sys.stdin.buffer), lambda: 0.0
        return
    with path.open("rb") as stream:
        size = max(path.stat().st_size, 1)

        def share() -> float:
            return stream.tell() / size if stream.seekable() else 0.0

        yield xml_stream(stream), share


@record
class Part:
    """Bytes of a file, and what makes them a document."""

    first: int
    last: int  # Exclusive
    lines_before: int
    head: bytes  # Stands for what is before
    tail: bytes  # Stands for what is after


def find_parts(path: Path, jobs: int) -> tuple[Part, ...]:
    """Return at most `jobs` parts of about the same size that make up a file; one or none if it is not to be divided.

    A part begins where ``<road`` stands. Whether that is below the root is not known: a part where it is not is no
    document.
    """
    if not path.is_file():
        return ()
    size = path.stat().st_size
    count = min(jobs, size // _LEAST_PART)
    if count < 2:
        return ()
    with path.open("rb") as file:
        if xml_stream(file) is not file:
            return ()
        head = file.read(_WINDOW)
        found = _ENCODING.match(head)
        if found and found.group(1).lower() not in _PLAIN:
            return ()
        cuts = [0]
        for k in range(1, count):
            file.seek(k * size // count)
            if road := _ROAD.search(file.read(_WINDOW)):
                cuts.append(k * size // count + road.start())
        cuts = sorted({*cuts, size})
        lines = _lines(path, cuts[:-1])
    if lines is None:
        return ()
    return tuple(
        Part(first, last, before, b"<%s>" % _ROOT if first else b"", b"</%s>" % _ROOT if last < size else b"")
        for first, last, before in zip(cuts[:-1], cuts[1:], lines, strict=True)
    )


def _lines(path: Path, places: list[int]) -> list[int] | None:
    """Return how many lines end before each of some places in ascending order; None where lines end by CR alone."""
    out, lines, at = [0], 0, places[0]
    with path.open("rb") as file:
        for place in places[1:]:
            text = file.read(place - at)
            if text.count(b"\r") != text.count(b"\r\n"):
                return None
            lines, at = lines + text.count(b"\n"), place
            out.append(lines)
    return out
