"""Spirals by Simpson's rule: slower than the code under test, and independent of it."""

from __future__ import annotations

import cmath

_PARTS = 64


def clothoid(curvature: float, rate: float, ds: float) -> tuple[complex, float]:
    """Return place, u + iv in the frame of the start, and turn after ds, where curvature grows by rate per m."""
    step = ds / _PARTS

    def direction(at: float) -> complex:
        return cmath.exp(1j * at * (curvature + rate * at / 2))

    inner = sum((4 if k % 2 else 2) * direction(k * step) for k in range(1, _PARTS))
    return step / 3 * (1 + inner + direction(ds)), ds * (curvature + rate * ds / 2)
