"""Numbers of connecting roads: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from typing import Final

# A street runs smoothly on through a junction where no corner on its way is sharper than this, rad (30 degrees): its
# drivers do not turn. A choice.
SMOOTH_CORNER: Final = 0.52
# Smallest radius of the middle of a turning lane wherever the arms have room, m: cars turn at 5 to 6 m (RASt 06, as
# `CORNER_RADIUS_OTHER`).
TURNING_RADIUS: Final = 6.0
# Smallest radius at corners so acute that a larger one would leave both streets, m: what most cars just manage
# (turning circles of 11 m and less, DIN 70020, less half of the car).
TURNING_RADIUS_ACUTE: Final = 4.2
# An arm is set back for its turns by at most this, m. A choice.
ARM_SETBACK_MAX: Final = 12.0
# And at acute forks by this, m, until cars turn from one arm into the other round the nose between them. A choice:
# arms 15 degrees apart have room for that 41 m from their node, 17 m beyond where their carriageways part.
FORK_SETBACK_MAX: Final = 30.0
# And gives no more than this share of its street to an acute fork. A choice.
FORK_SHARE_MAX: Final = 0.35
# How much larger than its kerb's the radius of a corner may be where its arms end far away. A choice.
LARGEST_KERB: Final = 1.4
# Ways from arm to arm and back are drawn beside a common axis where the middles of their lanes come nearer than this
# share of their widths. A choice: lanes of 2.75 m then stay 2.3 m apart.
OPPOSING_CLEARANCE: Final = 0.85
# Connecting roads may leave the carriageways of the streets inside their junction by this much, m. A choice: drivers
# cut bends by half a lane at most.
OFF_CARRIAGEWAY: Final = 1.25
# Half of the narrowest carriageway that cars use both ways, m.
HALF_NARROW_CARRIAGEWAY: Final = 2.75
# Curves drawn instead of others, to turn less sharply or to keep to a street, are longer than these by this factor at
# most, unless they turn back. A choice.
LONGEST_REDRAWN: Final = 1.8
# And they have this radius at least, m, or that of the curve they replace; turns at short streets get it, too: cars
# turn at 5 to 6 m.
LEAST_REDRAWN_RADIUS: Final = 5.1
# Lanes through junctions take at least this many times as long as their width changes: 7.5 is 1 in 5 where a smooth
# step is steepest, and a little more, as their length changes with the lanes that they join. A choice.
TAPER_PER_WIDTH: Final = 7.75
# A bicycle lane that joins a lane for cars where there is no room for that widens to it by this many metres per metre
# at most. A choice: paint ends there, and cyclists leave the edge of the lane.
STEEPEST_JOIN: Final = 1.0

# Ways that turn back: pavement is known by squares of this size, m.
PAVEMENT_CELL: Final = 0.5
# They need tarmac of their own if it is more than this, m². A choice: the corner of a lane.
OWN_TARMAC: Final = 10.0
# Those there and back do not meet in this share of their lengths at both ends.
NEAR_ENDS: Final = 0.06
