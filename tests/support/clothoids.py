"""Spirals by Simpson's rule: slower than the code under test, and independent of it."""

from __future__ import annotations

from typing import Final

import numpy as np
import numpy.typing as npt

_PARTS: Final = 64
_SHARES: Final = np.linspace(0.0, 1.0, _PARTS + 1)
_WEIGHTS: Final = np.array([1.0, *[4.0, 2.0] * (_PARTS // 2 - 1), 4.0, 1.0]) / (3 * _PARTS)


def clothoid(
    curvature: float, rate: float, ds: float | npt.NDArray[np.float64]
) -> tuple[npt.NDArray[np.complex128], npt.NDArray[np.float64]]:
    """Return places, u + iv in the frame of the start, and turns after ds, where curvature grows by rate per m."""
    ds = np.asarray(ds, np.float64)
    at = ds[..., None] * _SHARES
    place = ds * (np.exp(1j * at * (curvature + rate * at / 2)) @ _WEIGHTS)
    return place, ds * (curvature + rate * ds / 2)
