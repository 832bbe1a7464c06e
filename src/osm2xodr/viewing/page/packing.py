"""Numbers of the page: arrays of whole numbers that compress well, and rounded ones for its document.

Neighbours in an array of places differ little, so the upper bytes of their differences are nearly all alike; written
as planes of first, second … bytes they compress several times better than as text.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final, TypeAlias

import numpy as np
import numpy.typing as npt

from osm2xodr.model import FloatArray

Packed: TypeAlias = npt.NDArray[np.int32]

# Stands for "unknown" among whole numbers of 32 bits.
UNKNOWN: Final = -(2**31)
_LARGEST: Final = 2**31 - 1


def rounded(value: float | None, digits: int = 2) -> float | None:
    """Return a number rounded to some digits after the point; None where it is unknown."""
    return None if value is None or not math.isfinite(value) else round(float(value), digits)


def quantised(values: FloatArray, step: float) -> npt.NDArray[np.int32]:
    """Return values as whole numbers of steps: `UNKNOWN` where they are not finite, the largest where too large."""
    scaled = np.asarray(values, np.float64) / step
    known = np.isfinite(scaled)
    whole = np.rint(np.clip(np.where(known, scaled, 0.0), -_LARGEST, _LARGEST))
    return np.where(known, whole, float(UNKNOWN)).astype(np.int64).astype(np.int32)


def pack_arrays(arrays: Mapping[str, npt.NDArray[np.int32]]) -> tuple[list[list[Any]], bytes]:
    """Return a table of contents, rows of name and length, and all arrays as one string of bytes.

    Each array is written as differences modulo 2**32, and these as four planes of bytes, the lowest first.
    """
    contents: list[list[Any]] = []
    parts: list[bytes] = []
    for name, values in arrays.items():
        whole = np.ascontiguousarray(values, np.int32).view(np.uint32)
        steps = np.diff(whole, prepend=np.uint32(0)).astype("<u4")
        parts.append(np.ascontiguousarray(steps.view(np.uint8).reshape(-1, 4).T).tobytes())
        contents.append([name, len(whole)])
    return contents, b"".join(parts)
