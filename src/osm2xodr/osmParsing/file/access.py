"""Access to OSM files by libosmium, and elements as they are there."""

from __future__ import annotations

import ctypes
import errno
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import wraps
from itertools import islice
from typing import Any, Concatenate, Final, ParamSpec, TypeVar

import osmium

from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.osmParsing.file.file_format import OsmFile
from osm2xodr.system import LimitError, record

# Longest quotation of libosmium's messages, characters.
_CAUSE_MAX: Final = 200

_P = ParamSpec("_P")
_T = TypeVar("_T")


class _RefusedError(InputError):
    """libosmium refuses a file; `cause` says why."""

    def __init__(self, file: OsmFile, cause: str) -> None:
        super().__init__(
            f"{file.path} cannot be read as OSM data ({cause}); it may be damaged or incomplete, "
            "download or export it again"
        )
        self.cause = cause


def forgiving(read: Callable[Concatenate[OsmFile, _P], _T]) -> Callable[Concatenate[OsmFile, _P], _T]:
    """Let a reader begin again, with a plain copy of the file, where libosmium refuses what streets do not need."""

    @wraps(read)
    def read_again(file: OsmFile, /, *args: _P.args, **kwargs: _P.kwargs) -> _T:
        try:
            return read(file, *args, **kwargs)
        except _RefusedError as error:
            if not file.make_plain(error.cause):
                raise
        return read(file, *args, **kwargs)

    return read_again


def handle(file: OsmFile) -> Any:
    """Return libosmium's handle of a file."""
    # Absolute, as libosmium takes names such as "http:x" for addresses to fetch.
    return osmium.io.File(os.path.abspath(file.content.path), file.content.format)


def all_tags(item: Any) -> Iterator[tuple[str, str]]:
    """Return the keys and values of the tags of one of libosmium's elements."""
    tags = item.tags
    # No further than to the last one: the exception that ends libosmium's iterator takes as long as four tags.
    return islice(tags, len(tags))


@contextmanager
def readable(file: OsmFile) -> Iterator[None]:
    """Turn osmium's exceptions about a file's content into one `InputError`."""
    try:
        yield
    except (RuntimeError, ValueError, OSError, osmium.InvalidLocationError) as error:
        if str(error) == os.strerror(errno.EAGAIN):
            words = "the system gives no further threads; allow more of them (ulimit -u), or more memory (ulimit -v)"
            raise LimitError(f"{file.path} cannot be read: {words}") from None
        # The cause may quote the damaged content: one line of it, and only what can be printed.
        quoted = "".join(letter if letter.isprintable() else " " for letter in str(error))
        cause = " ".join(quoted.split())[:_CAUSE_MAX].rstrip(". ") or type(error).__name__
        raise _RefusedError(file, cause) from error


@record
class RawWay:
    """A way as in the file; `refs` are ids of nodes, `tags` those that were asked for."""

    id: int
    refs: Sequence[int]
    tags: Mapping[str, str]


@record
class RawMember:
    """A member of a relation; `type` is ``node``, ``way`` or ``relation``."""

    type: str
    ref: int
    role: str


@record
class RawRelation:
    """A relation as in the file."""

    id: int
    members: tuple[RawMember, ...]
    tags: Mapping[str, str]


@record(eq=False)
class RawNodes:
    """Nodes that are in the file, in ascending id."""

    # (n,) Ids, and positions, degrees, WGS 84
    ids: IntArray
    lon_deg: FloatArray
    lat_deg: FloatArray
    tags: Mapping[int, Mapping[str, str]]  # Tags of nodes that have any, in ascending id


def close_writer(writer: Any) -> None:
    """Close one of osmium's writers; RuntimeError or OSError if the file is not whole.

    A writer that could not be closed is kept for ever: its destructor would try again, and the exception in it would
    abort the process (seen with pyosmium 4.3).
    """
    try:
        writer.close()
    except (RuntimeError, OSError):
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(writer))
        raise
