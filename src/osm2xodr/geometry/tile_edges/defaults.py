"""Default numbers of borders between areas: meaning, unit, source. SI units unless a name says otherwise."""

from __future__ import annotations

from typing import Final

# The first metres of a junction's arms belong to the area of the junction, m: the arms have to be there for its
# connecting roads, and their stop lines and lights stand on them.
BORDER_STUB: Final = 25.0
# Shorter pieces of road belong to the area of a neighbouring piece, m: as long as two stubs.
BORDER_PIECE: Final = 50.0
