"""Numbers of junctions: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from typing import Final

# ---------------------------------------------------------------- junctions

# Longest tangent of a kerb's corner, m: at acute corners nobody turns at speed. A choice.
KERB_TANGENT_MAX: Final = 8.0
# Free space between the arms of a junction where their roads end, m. A choice.
ARM_CLEARANCE: Final = 0.5
# Largest extent of the nodes of one junction in x and in y, m, so that chains of short streets do not grow into one
# junction. A choice.
JUNCTION_EXTENT: Final = 60.0
# The same where the street between has some room, if less than a car, m: two crossings side by side, no chain of
# them. A choice.
JUNCTION_EXTENT_SHORT: Final = 25.0

# Where the lanes that a U-turn joins are closer than this, m, it is left out: they have no median between them, and a
# car with a radius of 4 m would swing out by most of a lane on either side. A choice.
U_TURN_ACROSS_MIN: Final = 3.5

# ---------------------------------------------------------------- turnarounds

# Diameter of a turning circle whose tags give none, m: a lorry of two axles collecting waste needs 16 m (RASt 06,
# section 6.1.2.2). The loops that close other dead ends: 12 m, a car's. Tagged diameters are kept within the bounds.
TURNING_CIRCLE_DIAMETER: Final = 16.0
TURNAROUND_DIAMETER: Final = 12.0
TURNAROUND_DIAMETER_MIN: Final = 8.0
TURNAROUND_DIAMETER_MAX: Final = 40.0
