"""XML as small trees, one top-level element at a time.

The parser is expat: it counts lines beyond 65535, never opens a second file, and is part of Python. Declarations of
document types are refused: entities can make a small file grow without bounds.
"""

from __future__ import annotations

import contextlib
import sys
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO, Final
from xml.parsers import expat

from osm2xodr.errors import InputError
from osm2xodr.opendrive.reader.parts import Part
from osm2xodr.system import advance, unpacked

_CHUNK: Final = 1 << 18
_STANDARD_INPUT: Final = Path("-")


class Node:
    """An element: its name without prefix, attributes, children, text (of ``<geoReference>`` only) and line."""

    __slots__ = ("attributes", "children", "line", "tag", "text")

    def __init__(self, tag: str, attributes: dict[str, str], line: int) -> None:
        self.tag = tag
        self.attributes = attributes
        self.children: list[Node] = []
        self.line = line
        self.text = ""

    def get(self, name: str) -> str:
        """Return an attribute, empty where there is none; texts that are alike, as most are, are one in memory."""
        return sys.intern(self.attributes.get(name, ""))


class _DoctypeError(Exception):
    """The document declares its type."""


class TreeReader:
    """Reads a document, or a part of one; its outermost element is `root`, once that has begun.

    The children of the root are not kept. A part is read as if it were a document.
    """

    def __init__(self, path: Path, part: Part | None = None) -> None:
        self.root: Node | None = None
        self._path = path
        self._part = part
        self._lines_before = part.lines_before if part else 0
        self._open: list[Node] = []
        self._done: list[Node] = []
        self._texts: list[str] = []
        self._parser = parser = expat.ParserCreate()
        parser.buffer_text = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.StartDoctypeDeclHandler = self._refuse

    def trees(self) -> Iterator[Node]:
        """Yield the children of the root, each as a whole; `InputError` if the file cannot be read or is not XML."""
        try:
            for chunk, share in _chunks(self._path, self._part):
                advance(share)
                self._parser.Parse(chunk, not chunk)
                done, self._done = self._done, []
                yield from done
        except expat.ExpatError as error:
            reason = expat.errors.messages.get(error.code, "it cannot be parsed")
            raise InputError(
                f"{self._path} is not XML that can be read: {reason} in line {error.lineno}; give a file of OpenDRIVE"
            ) from error
        except _DoctypeError as error:
            reason = "declares a document type, which OpenDRIVE does not have; remove <!DOCTYPE>"
            raise InputError(f"{self._path} {reason}") from error
        except (LookupError, ValueError) as error:
            # Raised by expat when Python has no codec for the declared encoding.
            reason = f"has an encoding that cannot be read ({error}); write it in UTF-8"
            raise InputError(f"{self._path} {reason}") from error
        except (OSError, EOFError, zlib.error) as error:
            reason = (getattr(error, "strerror", None) or str(error)).lower()
            raise InputError(f"cannot read {self._path}: {reason}; give a file of OpenDRIVE") from error

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        """Begin an element."""
        if ":" in tag:
            tag = tag.rpartition(":")[2]
        node = Node(tag, attributes, self._lines_before + self._parser.CurrentLineNumber)
        if self._open:
            self._open[-1].children.append(node)
        else:
            self.root = node
        self._open.append(node)
        if tag == "geoReference":
            self._texts = []
            self._parser.CharacterDataHandler = self._texts.append

    def _end(self, tag: str) -> None:
        """End an element; it is complete if it is a child of the root."""
        node = self._open.pop()
        if len(self._open) == 1:
            self._done.append(node)
            self._open[0].children.clear()
        if node.tag == "geoReference":
            node.text = "".join(self._texts)
            self._parser.CharacterDataHandler = None

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
        yield sys.stdin.buffer, lambda: 0.0
        return
    with path.open("rb") as stream:
        size = max(path.stat().st_size, 1)

        def share() -> float:
            return stream.tell() / size if stream.seekable() else 0.0

        yield unpacked(stream), share
