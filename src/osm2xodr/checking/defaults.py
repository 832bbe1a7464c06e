"""Numbers that several checks share: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from typing import Final

# Distance between places that should be one, m: ASAM's checker allows lanes 0.01 where they touch. From the second on
# it is an error: a step that shakes a wheel, a choice.
GAP: Final = 0.01
GAP_ERROR: Final = 0.1
# Stations along s that differ by no more than this are one, m.
SAME_S: Final = 1e-6
# A lane that is narrower than this where it ends has tapered out, m: half of a shoe.
TAPERED_WIDTH: Final = 0.15
# Surfaces whose heights differ by this or more are different levels, m.
LEVEL_HEIGHT: Final = 2.0
