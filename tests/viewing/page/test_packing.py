"""Packed numbers come back as they were."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, strategies as st

from osm2xodr.viewing.page.packing import UNKNOWN, pack_arrays, quantised


def unpacked(contents: list[list[object]], data: bytes) -> dict[str, list[int]]:
    """Read arrays as the page does."""
    out, at = {}, 0
    for name, count in contents:
        assert isinstance(name, str)
        assert isinstance(count, int)
        planes = np.frombuffer(data, np.uint8, 4 * count, at).reshape(4, count).astype(np.uint32)
        steps = planes[0] | planes[1] << 8 | planes[2] << 16 | planes[3] << 24
        out[name] = np.cumsum(steps, dtype=np.uint32).view(np.int32).tolist()
        at += 4 * count
    return out


@given(st.lists(st.integers(-(2**31), 2**31 - 1), max_size=50), st.lists(st.integers(-5, 5), max_size=9))
def test_arrays_come_back(one: list[int], other: list[int]) -> None:
    arrays = {"one": np.array(one, np.int32), "other": np.array(other, np.int32)}
    assert unpacked(*pack_arrays(arrays)) == {"one": one, "other": other}


def test_values_become_steps() -> None:
    values = np.array([0.004, -1.236, math.nan, math.inf, 1e30])
    assert quantised(values, 0.01).tolist() == [0, -124, UNKNOWN, UNKNOWN, 2**31 - 1]
