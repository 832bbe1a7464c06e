"""Default numbers of the floor of junctions: meaning, unit, source. SI units unless a name says otherwise."""

from __future__ import annotations

from typing import Final

# Size of the cells in which gaps between lanes are looked for, m. A choice of speed; their edges are found exactly.
GAP_CELL: Final = 0.4
# Lanes are drawn so much wider on both sides, m: a slit of twice that is none. A choice.
GAP_CLOSED: Final = 0.02
# How far edges of lanes may be off the straight lines that they are drawn with, m. A choice: less than
# that.
GAP_CHORD: Final = 0.01
# Gaps stay open that have less area clear of the edges, m²: half a cell. A choice: narrow slits show in few cells.
GAP_LEAST_AREA: Final = 0.08
# Gaps of more area are blocks between roads, not parts of a junction, m². A choice.
GAP_LARGEST_AREA: Final = 65.0
# Least width of a carriageway's end that no lane goes on from, m: as wide as the smallest lanes. A choice.
FACE_LEAST_OPEN: Final = 1.0
# How far a strip of pavement reaches from a lane's edge at most, m. A choice.
FLOOR_REACH: Final = 9.0
# Strips of less area are left out, m²: below what a wheel notices. A choice.
FLOOR_LEAST_AREA: Final = 0.15
# How far a strip goes under the lanes beyond it, m: so that rounding leaves no slit. A choice.
FLOOR_OVERLAP: Final = 0.05
# How far the edge of a strip may be off what is left open, m. A choice: few records.
FLOOR_TOLERANCE: Final = 0.04
# Islands: least area of a gap between carriageways, and of its cells that touch none, m²: from there on a place
# without traffic gets kerbs; choices.
ISLAND_LEAST_AREA: Final = 6.0
ISLAND_LEAST_CLEAR: Final = 4.0
# Largest gap that may be an island, m²: the middle of a roundabout of 40 m. A choice.
ISLAND_LARGEST_AREA: Final = 1300.0
# Least share of what the lines of streets enclose that an island fills: the rest are their carriageways. A choice:
# what is left of a crossing's middle, or a corner of a block, is no island.
ISLAND_SHARE: Final = 0.15
# How far kerbs stay within a gap, m, and how far they may be off, m. Choices.
ISLAND_CLEARANCE: Final = 0.2
ISLAND_TOLERANCE: Final = 0.15
# Least area of an island that OSM maps, m², and its least share that lanes must leave: where they take more, it lies
# elsewhere. Choices.
ISLAND_MAPPED_LEAST: Final = 1.5
ISLAND_MAPPED_SHARE: Final = 0.25
# Half of the width that trams need, m: BOStrab section 34, 2.65 m, and a little.
TRAM_HALF_WIDTH: Final = 1.45
