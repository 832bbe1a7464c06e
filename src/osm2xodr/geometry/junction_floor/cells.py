"""Cells of grids that cross sections of lanes cover."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from osm2xodr.model import IntArray

_Floats = NDArray[np.float32]
_Ints = NDArray[np.int32]


def draw_across(
    sections: IntArray,
    shares: _Floats,
    low: _Floats,
    high: _Floats,
    x: _Floats,
    y: _Floats,
    nx: _Floats,
    ny: _Floats,
    first: _Ints,
    across: _Ints,
    value: _Ints,
    out: _Ints,
) -> None:
    """Write values into the cells of some cross sections, at shares of the way from t = low to t = high, m.

    Where several cover a cell, the last one has it. The columns are those of `gaps.Grids`, whose cells are `out`.
    """
    for i in range(len(sections)):
        k = sections[i]
        for j in range(len(shares)):
            t = _between(low[k], high[k], shares[j])
            row, column = _cell(t, ny[k], y[k]), _cell(t, nx[k], x[k])
            out[first[k] + row * across[k] + column] = value[k]


def _between(low: np.float32, high: np.float32, share: np.float32) -> np.float32:
    """Return a place between two, m; no step of it has more digits than these."""
    return (high - low) * share + low


def _cell(t: np.float32, along: np.float32, begin: np.float32) -> int:
    """Return the column or row of a cell at t, m, of a cross section."""
    return int(t * along + begin)
