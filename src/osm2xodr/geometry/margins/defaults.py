"""Numbers of strips beside the carriageway: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from typing import Final

# Length over which strips beside the carriageway open and end, m: kerbs of lay-bys do so within a car's length; and
# the width of the mark that shows a kerb, m: that of a kerbstone (EN 1340, common 125 to 150 mm). Choices.
MARGIN_TAPER_LENGTH: Final = 6.0
KERB_MARK_WIDTH: Final = 0.15
# What stands in the way of strips: carriageways that run along within so much of the road's line, m, at an angle of
# this sine at most; the strips are clear of them so much before and after, m. Choices.
MARGIN_REACH: Final = 16.0
MARGIN_ALONG_SINE: Final = 0.35
MARGIN_CLEARANCE: Final = 8.0
# Sidewalks through junctions that are longer may meet another arm, m. A choice.
CORNER_FAR: Final = 20.0
# How far before a junction's edge a sidewalk lies at the kerb where it would not get round the corner otherwise, m:
# nobody may park there (StVO section 12: 5 m).
CORNER_KERBSIDE: Final = 5.0
# Sidewalks across corners: least radius of their inner edge, m; longest path as a multiple of the direct distance and
# how much longer it may be anyway, m; how much it turns to one side only to turn back, rad; how far onto lanes for
# cars they may reach, m. Choices.
CORNER_EDGE_RADIUS: Final = 0.1
CORNER_DETOUR: Final = 3.0
CORNER_DETOUR_MORE: Final = 5.0
CORNER_SWING: Final = 1.5
CORNER_ONTO_LANE: Final = 0.3
