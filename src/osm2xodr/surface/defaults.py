"""Default numbers of elevation models: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from typing import Final

# Most cells that are kept of all elevation models (128 MB in single precision), and for a bicubic spline, which
# takes 30 bytes more per cell. Where the roads span more, the finest models are averaged over blocks of cells, and
# that is said.
DEM_CELLS_MAX: Final = 2**25
DEM_CELLS_MAX_BICUBIC: Final = 2**23
# Standard error of an elevation model's heights, m, by the size of its cells, m; between them the logarithms are
# interpolated. Airborne laser 1 m: 0.1-0.15; national models of 5 to 10 m: 0.5-1; Copernicus GLO-30 and AW3D30: 2-3
# (product handbooks and comparisons against geodetic points); SRTM at 3 arc seconds: 5-6.
DEM_SIGMA: Final = ((1.0, 0.12), (2.0, 0.15), (5.0, 0.5), (10.0, 1.0), (30.0, 2.0), (90.0, 5.0))
# Cells that the comparison of interpolations looks at: half a million take a few seconds. Of larger models so many
# patches in either direction are taken, evenly spread; fewer cells in a row than the last compare nothing.
COMPARISON_CELLS: Final = 2**19
COMPARISON_PATCHES: Final = 3
COMPARISON_CELLS_MIN: Final = 12
