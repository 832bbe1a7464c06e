"""Default numbers of the boundaries of junctions: meaning, unit, source. SI units unless a name says otherwise."""

from __future__ import annotations

from typing import Final

# Edges that lie this near to the outermost one of their arm are outermost, too, m. A choice: widths are written to
# millimetres, and lanes taper.
SAME_EDGE: Final = 0.15
# Segments whose ends lie this near to each other meet, m: wheels do not notice it. A choice.
CLOSED_WITHIN: Final = 0.3
# Distance of places on edges that may cross, m: arcs of 5 m lie within 7 mm of their chords.
EDGE_SPACING: Final = 0.5
# Distance of places on the boundary of a junction, m, that roads are compared with, and that of places on these,
# which are so many at least. A choice of speed: strips that end narrow by up to a metre on one.
RING_SPACING: Final = 0.75
BULGE_SPACING: Final = 4.0
BULGE_PLACES: Final = 2
# Roads that leave the boundary by less are not gone round, m. A choice.
BULGE_LEAST: Final = 0.25
