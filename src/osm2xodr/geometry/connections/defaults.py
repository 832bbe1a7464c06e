"""Numbers of connecting roads: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from typing import Final

# A street runs smoothly on through a junction where no corner on its way is sharper than this, rad (30 degrees): its
# drivers do not turn. A choice.
SMOOTH_CORNER: Final = 0.52
