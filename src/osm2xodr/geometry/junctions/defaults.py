"""Default numbers of junctions: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from typing import Final

# ---------------------------------------------------------------- junctions

# A kerb's tangent is not let grow beyond this at acute corners, where nobody turns at speed.
KERB_TANGENT_MAX: Final = 8.0
# Free space between a junction's arms where their roads end.
ARM_CLEARANCE: Final = 0.5
# Arms of a node at which nobody can turn lie on each other within the angle of this cosine (45 degrees); and nobody
# turns on the spot from one fast road into another within that of the second (20 degrees). Choices.
ACUTE_COSINE: Final = 0.7
NO_TURN_COSINE: Final = 0.94
# Largest extent of the nodes of one junction.
JUNCTION_EXTENT: Final = 60.0

# ---------------------------------------------------------------- turnarounds

# Diameter of a turning circle whose tags give none, m: a lorry of two axles collecting waste needs 16 m (RASt 06,
# section 6.1.2.2); and of the loops that close other dead ends: 12 m, a car's. What is believed of tags.
TURNING_CIRCLE_DIAMETER: Final = 16.0
TURNAROUND_DIAMETER: Final = 12.0
TURNAROUND_DIAMETER_MIN: Final = 8.0
TURNAROUND_DIAMETER_MAX: Final = 40.0
