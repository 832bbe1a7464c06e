"""How much a pbf file becomes when it is read: few bytes can stand for gigabytes of nodes and tags.

It is unpacked and counted (OSM wiki, PBF Format) where it can claim much. Damage is left to libosmium to report.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from osm2xodr.errors import InputError
from osm2xodr.model import IntArray

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
