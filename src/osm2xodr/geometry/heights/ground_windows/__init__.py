"""Separation of the ground from the noise of coarse elevation models, in windows around the roads.

A global elevation model of 30 m cells has errors of metres that are correlated over a few cells, and takes canopy
and roofs for ground. Sampled along a road they look like grades of many per cent. The terrain beside a road says more
about it than the few cells beneath it, so the ground is estimated in two dimensions first.

A first surface has one roughness for a whole window and sees through what stands out (`estimate`). From it and what
is left follow the spectra of the window's ground and of its noise (`spectra`), and with them the ground, whose
roughness differs from place to place. All work with cosines. Windows are treated in stacks
that stay in the processor's cache, in single precision: its rounding is 1e-4 m. docs/method/heights.md has the
formulas.
"""

from __future__ import annotations

from osm2xodr.geometry.heights.ground_windows.estimate import (
    INNER,
    RIM,
    Estimator,
    WindowEstimates,
    unknown_windows,
)
from osm2xodr.geometry.heights.ground_windows.spectra import CORE, MARGIN, SIZE, Single

__all__ = [
    "CORE",
    "INNER",
    "MARGIN",
    "RIM",
    "SIZE",
    "Estimator",
    "Single",
    "WindowEstimates",
    "unknown_windows",
]
