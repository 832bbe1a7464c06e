"""Numbers and texts made small for a page: whole numbers, differences, planes of bytes, gzip, base64.

Neighbours in an array of places differ little, so their differences are small numbers whose upper bytes are all
alike; sorted into planes of first, second … bytes they compress several times better than as text.
"""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from osm2xodr.model import FloatArray

# Stands for "unknown" among whole numbers of 32 bits.
UNKNOWN = -(2**31)
_LARGEST = 2**31 - 1


def quantised(values: FloatArray, step: float) -> npt.NDArray[np.int32]:
    """Return values as whole numbers of steps: `UNKNOWN` where they are not finite, the largest where too large."""
    scaled = np.asarray(values, np.float64) / step
    known = np.isfinite(scaled)
    whole = np.rint(np.clip(np.where(known, scaled, 0.0), -_LARGEST, _LARGEST))
    return np.where(known, whole, float(UNKNOWN)).astype(np.int64).astype(np.int32)


def pack_arrays(arrays: Mapping[str, npt.NDArray[np.int32]]) -> tuple[list[list[Any]], bytes]:
    """Return a table of contents, rows of name and length, and all arrays as one string of bytes.

    Each is written as differences (modulo 2 to the 32), and these as four planes of bytes, the lowest first.
    """
    contents: list[list[Any]] = []
    parts: list[bytes] = []
    for name, values in arrays.items():
        whole = np.ascontiguousarray(values, np.int32).view(np.uint32)
        steps = np.diff(whole, prepend=np.uint32(0)).astype("<u4")
        parts.append(np.ascontiguousarray(steps.view(np.uint8).reshape(-1, 4).T).tobytes())
        contents.append([name, len(whole)])
    return contents, b"".join(parts)


def compressed(data: bytes) -> str:
    """Return bytes as base64 of gzip; the same bytes give the same text."""
    return base64.b64encode(gzip.compress(data, 6, mtime=0)).decode("ascii")


def as_json(value: Any) -> bytes:
    """Return a value as JSON, UTF-8, with finite numbers only; halves of characters become question marks."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode("utf-8", "replace")
