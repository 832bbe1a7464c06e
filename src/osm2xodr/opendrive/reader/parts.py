"""Parts of a large document that can be read side by side, each as a document of its own."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from osm2xodr.system import xml_stream

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


@dataclass(frozen=True, slots=True)
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
