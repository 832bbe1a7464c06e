"""Default numbers of the floor of junctions: meaning, unit, source. SI units unless a name says otherwise."""

from __future__ import annotations

from typing import Final

# Size of the cells in which gaps between lanes are looked for, m. A choice of speed; their edges are found exactly.
GAP_CELL: Final = 0.4
# How much narrower lanes are drawn than they are, on both sides, m, to show narrow slits. A choice: with less than
# half a cell, lanes that touch stay closed nearly everywhere.
GAP_INSET: Final = 0.18
# Gaps stay open that have less area clear of the edges, m²: a cell or none. A choice.
GAP_LEAST_AREA: Final = 0.15
# Gaps of more area are blocks between roads, not parts of a junction, m². A choice.
GAP_LARGEST_AREA: Final = 65.0
# How far a strip of pavement reaches from a lane's edge at most, m. A choice.
FLOOR_REACH: Final = 9.0
# Strips of less area are left out, m²: below what a wheel notices. A choice.
FLOOR_LEAST_AREA: Final = 0.15
# How far a strip goes under the lanes beyond it, m: so that rounding leaves no slit. A choice.
FLOOR_OVERLAP: Final = 0.05
# How far the edge of a strip may be off what is left open, m. A choice: few records.
FLOOR_TOLERANCE: Final = 0.04
