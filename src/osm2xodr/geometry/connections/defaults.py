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
# How much larger than its kerb's the radius of a corner may be where its arms end far away. A choice.
LARGEST_KERB: Final = 1.4
# Ways from arm to arm and back are drawn beside a common axis where the middles of their lanes come nearer than this
# share of their widths. A choice: lanes of 2.75 m then stay 2.3 m apart.
OPPOSING_CLEARANCE: Final = 0.85
