"""Default numbers of checks: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from typing import Final

# What is a finding, and from where on it is an error where it would else be a warning.
# Distance between places that should be one, m: ASAM's checker allows lanes 0.01 at touching points. An error is what
# shakes a wheel: a choice.
CHECK_GAP: Final = 0.01
CHECK_GAP_GRAVE: Final = 0.1
# Stated length less that of the curve, m: ASAM's checker for paramPoly3; sums of records, m: rounding of many.
CHECK_RECORD_LENGTH: Final = 0.001
CHECK_ROAD_LENGTH: Final = 0.01
# Two stations along s are one, m; records and sections shorter than this are of no use, m: RoadRunner rounds lengths
# to 1 cm.
CHECK_SAME_S: Final = 1e-6
CHECK_SHORT: Final = 0.01
# Widths below this are negative, m: the tolerance of ASAM's checker for widths of 0. A lane narrower than that much
# where it ends is one that has tapered out, m: half of a shoe.
CHECK_ZERO_WIDTH: Final = 1e-6
CHECK_TAPERED: Final = 0.15
# Coordinates that single precision (24 bits) still tells apart to 1 cm, m: 2**17 at 2**-6 m; a round number below.
CHECK_COORDINATE: Final = 1e5
# Largest id that readers keep in 32 bits with a sign. Junction ids of 3e9 fail in CARLA, its limit was not sought.
CHECK_ID_MAX: Final = 2**31 - 1
# Places of two connecting roads that are one place, m; distances between samples along and the shares of the
# carriageway at which they lie; heights that differ by more are not one surface, m (half of a low kerb), or an error;
# by still more: another level.
CHECK_SURFACE_PLACE: Final = 0.12
CHECK_SURFACE_STEP: Final = 1.0
CHECK_SURFACE_SHARES: Final = (0.05, 0.35, 0.65, 0.95)
CHECK_SURFACE: Final = 0.12
CHECK_SURFACE_GRAVE: Final = 0.3
CHECK_LEVELS: Final = 2.0
# Overlaps of carriageways are counted in cells of this size, m, that far from edges and from ends; an area above this
# is a finding, m2: a car's.
CHECK_OVERLAP_CELL: Final = 0.7
CHECK_OVERLAP_EDGE: Final = 0.4
CHECK_OVERLAP_END: Final = 1.5
CHECK_OVERLAP: Final = 8.0
# Larger files are not held against the schema of 1.8, bytes: xmlschema takes ten seconds and more for each MB.
CHECK_SCHEMA_18_BYTES: Final = 2_000_000
