"""Default numbers of lanes along roads: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from typing import Final

# Values of ``highway`` for streets that have no lines unless a tag says so, and for roads whose edges have none.
# Choices after RMS 1993: no lines where limits are low, edge lines on main roads.
UNMARKED_HIGHWAYS: Final = ("residential", "living_street", "service", "track", "pedestrian")
EDGELESS_HIGHWAYS: Final = ("unclassified", "road", "busway")
# A two-way carriageway narrower than this has no centre line, m (RMS 1993: 5.5 m).
CENTRE_LINE_FROM: Final = 5.5
# Shortest stretch of the same lanes with a speed limit of its own, m: what a car takes in a queue (HBS 2015).
SHORTEST_LIMIT: Final = 6.0
