"""Small files that claim or hold far more than they should."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import rasterio
from rasterio import Affine

MEGABYTE: Final = 1 << 20
HEAD: Final = b'<?xml version="1.0"?>\n<osm version="0.6" generator="x">\n'


def spaces(size: int) -> Iterator[bytes]:
    """Yield nothing but space, MB."""
    yield HEAD
    yield from (b" " * MEGABYTE for _ in range(size))
    yield b"</osm>"


def zeros(size: int) -> Iterator[bytes]:
    """Yield zeros, MB."""
    yield HEAD
    yield from (bytes(MEGABYTE) for _ in range(size))


def one_value(size: int) -> Iterator[bytes]:
    """Yield a tag with a value of some MB."""
    yield HEAD + b'<node id="1" lat="1" lon="1"><tag k="a" v="'
    yield from (b"x" * MEGABYTE for _ in range(size))
    yield b'"/></node></osm>'


def one_way(size: int) -> Iterator[bytes]:
    """Yield a way of some MB of references."""
    line = b'<nd ref="1"/>\n'
    yield HEAD + b'<way id="1">'
    yield from (line * (MEGABYTE // len(line)) for _ in range(size))
    yield b"</way></osm>"


def prolog(size: int) -> Iterator[bytes]:
    """Yield a comment of some MB before the content."""
    yield b'<?xml version="1.0"?>\n<!-- '
    yield from (b" " * MEGABYTE for _ in range(size))
    yield b" --><osm/>"


def _varint(number: int) -> bytes:
    number &= (1 << 64) - 1
    out = b""
    while number > 127:
        out += bytes([number & 127 | 128])
        number >>= 7
    return out + bytes([number])


def _field(key: int, content: bytes) -> bytes:
    return bytes([key]) + _varint(len(content)) + content


def _block(kind: bytes, blob: bytes, claimed: int | None = None) -> bytes:
    header = _field(0x0A, kind) + b"\x18" + _varint(len(blob) if claimed is None else claimed)
    return struct.pack(">I", len(header)) + header + blob


def _packed(claimed: int, content: bytes) -> bytes:
    return _block(b"OSMData", b"\x10" + _varint(claimed) + _field(0x1A, zlib.compress(content, 9)))


def pbf_files() -> dict[str, bytes]:
    """Return pbf files with headers that lie about sizes, by what they do."""
    header = _field(0x0A, _field(0x22, b"OsmSchema-V0.6"))
    sound = _block(b"OSMHeader", header)
    return {
        "header of 4 GB": sound + struct.pack(">I", 0xFFFFFFFF) + b"x" * 50,
        "header of 2 GB": sound + struct.pack(">I", 0x7FFFFFFF) + b"x" * 50,
        "first blob of 4 GB": _block(b"OSMHeader", header, 0xFFFFFFFF),
        "blob of 4 GB": sound + _block(b"OSMData", _field(0x0A, b"abc"), 0xFFFFFFFF),
        "blob of 2 GB": sound + _block(b"OSMData", _field(0x0A, b"abc"), 0x7FFFFFFF),
        "blob of -1 byte": sound + _block(b"OSMData", _field(0x0A, b"abc"), -1),
        "content of 4 GB": sound + _block(b"OSMData", b"\x0a" + _varint(0xFFFFFFFF) + b"abc"),
        "unpacked 4 GB": sound + _packed(0xFFFFFFFF, bytes(10)),
        "unpacked -1 byte": sound + _packed(-1, bytes(10)),
        "unpacked 31 MB": sound + _packed(31 * MEGABYTE, bytes(10)),
        "unpacked more than claimed": sound + _packed(100, bytes(200 * MEGABYTE)),
    }


def pbf_that_claims_much(what: str) -> bytes:
    """Return a pbf file of a few kB of nodes, or of tags of 1 kB each, or of ways, that are all alike."""
    strings = (b"", b"k" * 1000, b"v" * 1000) if what == "tags" else (b"", b"highway", b"primary")
    table = _field(0x0A, b"".join(_field(0x0A, text) for text in strings))
    way = _field(0x1A, b"\x08\x01" + _field(0x12, b"\x01") + _field(0x1A, b"\x02") + _field(0x42, b"\x02\x02"))
    count = {"nodes": 8_000_000, "tags": 300_000, "ways": 1_000_000}[what]
    ones = b"\x02" * count
    dense = _field(0x0A, ones) + _field(0x42, ones) + _field(0x4A, ones)
    tags = _field(0x52, b"\x01\x02\x00" * count) if what == "tags" else b""
    group = way * count if what == "ways" else _field(0x12, dense + tags)
    content = table + _field(0x12, group)
    return _block(b"OSMHeader", _field(0x0A, _field(0x22, b"OsmSchema-V0.6"))) + _packed(len(content), content)


def sparse_raster(path: Path, size: int, transform: Affine, **profile: Any) -> Path:
    """Write a GeoTIFF of size x size cells, none of which is stored."""
    with rasterio.open(
        path, "w", driver="GTiff", width=size, height=size, count=1, dtype="float32", crs="EPSG:4326",
        transform=transform, SPARSE_OK=True, BIGTIFF="YES", **profile,
    ):  # fmt: skip
        pass
    return path
