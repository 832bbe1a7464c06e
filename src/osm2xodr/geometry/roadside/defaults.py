"""Default numbers of strips beside the carriageway: meaning, unit, source. SI units unless a name says otherwise."""

from __future__ import annotations

from typing import Final

# Length over which strips beside the carriageway open and end, m: kerbs of lay-bys do so within a car's length. A
# choice.
MARGIN_TAPER_LENGTH: Final = 6.0
# Width of the mark that shows a kerb, m: that of a kerbstone (EN 1340, common 125 to 150 mm).
KERB_MARK_WIDTH: Final = 0.15
# Heights that differ by less are the same, no kerb, m: well below the lowest kerbs (30 mm). A choice.
SAME_HEIGHT: Final = 0.005
# Places along a road that are closer are the same, m: above errors of rounding, below anything that is built.
SAME_PLACE: Final = 1e-6
# Strips give way to carriageways within this distance of the road's line, m, that run along it (at an angle of at
# most this sine), and end this far before them and begin this far behind them, m. Choices.
MARGIN_REACH: Final = 16.0
MARGIN_ALONG_SINE: Final = 0.35
MARGIN_CLEARANCE: Final = 8.0
# Sidewalks through junctions that are longer may meet another arm, m. A choice.
CORNER_FAR: Final = 20.0
# How far before a junction's edge a sidewalk lies at the kerb where it would not get round the corner otherwise, m:
# nobody may park there (StVO section 12: 5 m).
CORNER_KERBSIDE: Final = 5.0
# Least radius of the inner edge of a strip in a bend, m. A choice: an edge without a radius folds over itself.
CORNER_EDGE_RADIUS: Final = 0.1
# The same round the tip between two streets, m. A choice: what is left between its sidewalks is a slit.
CORNER_TIP_RADIUS: Final = 0.03
# Longest path of a sidewalk round a corner: this multiple of the direct distance, and this much on top, m. Choices.
CORNER_DETOUR: Final = 3.0
CORNER_DETOUR_MORE: Final = 5.0
# How much a sidewalk may turn to one side only to turn back, over a corner, rad. A choice.
CORNER_SWING: Final = 1.5
# The same where it swings out round lanes that lie in its way, rad. A choice.
CORNER_SWING_OUT: Final = 3.5
# How far a sidewalk may reach onto lanes for cars, m. A choice: paths of cars through junctions are guesses, too.
CORNER_ONTO_LANE: Final = 0.3
# Narrower gaps between a corner's sidewalk and the carriageway stay open, m. A choice.
NARROWEST_FILLING: Final = 0.05
# Values of OSM's ``highway`` of arms without sidewalks that sidewalks run past: who leaves these yields, over a
# lowered kerb (StVO section 10).
PASSED_HIGHWAYS: Final = ("service", "track")
