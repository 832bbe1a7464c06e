"""Default numbers of pages and pictures: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from typing import Final

# How far chords of the page's and of pictures' roads lie from their curves at most, m, and the longest chord, m: less
# than a pixel up to 30 pixels per metre; and between stations of a profile a grade is as good as straight. Choices.
VIEW_TOLERANCE: Final = 0.03
VIEW_STEP: Final = 10.0
# OSM's ways beside a file's roads: distance of their points, m; how far beside a lane a point still counts as on it,
# m (a way drawn on the kerb); how far their directions may differ, rad (30 degrees); least length on a road of a way
# that is listed with it, m, or half of the road; and least length without a road of a way listed as missing, m.
COVER_SPACING: Final = 10.0
COVER_SLACK: Final = 1.0
COVER_ANGLE: Final = 0.5236
COVER_WAY_LENGTH: Final = 15.0
COVER_MISSING: Final = 15.0
