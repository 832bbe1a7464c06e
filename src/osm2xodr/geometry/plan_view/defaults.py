"""Default numbers of reference lines: meaning, unit, source. SI units unless the name says otherwise.

docs/method/plan_view.md says where each is used.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

# ---------------------------------------------------------------- lines and arcs

# How far a vertex of an OSM way may be left out of its curve. OSM's own error is 1 to 2 m (Haklay 2010,
# doi:10.1068/b35097); 0.2 m changes no heading that a driver notices.
SIMPLIFY_TOLERANCE: Final = 0.2
# How far a curve cuts a corner of the polyline at least (where there is room), at most for turns up to 90 degrees,
# and at most for hairpins of one node, m. With 0.5 m and half of it given back outwards, curves through polylines of
# true alignments come closest to them.
CORNER_CUT: Final = 0.5
CORNER_CUT_MAX: Final = 2.0
CORNER_CUT_HAIRPIN: Final = 6.0
# How far the line may move so that the inner edge of a carriageway keeps its radius in a bend, m. A choice: as far as
# hairpins of few nodes are cut. Else lanes fold over themselves, and nobody can drive on them.
BEND_SHIFT_MAX: Final = CORNER_CUT_HAIRPIN

# ---------------------------------------------------------------- continuous curvature

# How far a curve of lines and arcs may move to become smooth, m, in the mean over the length that it is smoothed by,
# and anywhere. Nodes are 0.3 to 1.5 m off (Haklay 2010); with these, 95 % of roads are within 0.6 m of OSM's line.
SMOOTH_SHIFT: Final = 0.6
SMOOTH_SHIFT_MOST: Final = 0.75
# In corners it may move by less: by the share of this, m, that they are not cut by already, but not by less than the
# second share. Choices.
SMOOTH_CUT: Final = 0.6
SMOOTH_SHARE_LEAST: Final = 0.2
# Spacing of the points that move, m: two to an arc of the least radius of a connecting road. A choice.
SMOOTH_STEP: Final = 3.0
# How far a curve may move for one spiral to do where there were several, m. A choice: a third of the shift.
SMOOTH_KNOT: Final = 0.2

# ---------------------------------------------------------------- roundabouts

# How far, m, a roundabout's ring may pass its nodes: at most, and as the root of the mean square if it is a circle,
# and if it is another smooth curve. Nodes set by hand on an image are a few decimetres off their neighbours (the 1 to
# 2 m of Haklay 2010 are mostly common to all); a round shape is likelier than any other. Of 37 rings of 8 places 32
# are circles within 0.5 m, and within 0.12 m by the mean square.
RING_TOLERANCE: Final = 0.6
RING_CIRCLE_RMS: Final = 0.3
RING_CURVE_RMS: Final = 0.2
# Length of the arcs of rings that are no circles, m, and of the lines that their straight sides are cut into.
RING_ARC: Final = 4.0
RING_SIDE: Final = 5.0

# ---------------------------------------------------------------- streets side by side

# Streets are compared with those that run beside them nearer than this, m: a choice, wider than two carriageways.
PARALLEL_REACH: Final = 25.0
# Lanes keep at least this share of their width: one of 3.5 m becomes one of 2.45 m, about the narrowest that a car
# drives.
NARROWEST_SHARE: Final = 0.7
# Lanes for cars keep at least this width, m: SUMO closes those below 1.8 m to cars (netconvert,
# ``opendrive.min-width``). Those of service roads, 2.5 m, still take no more room than `PARALLEL_GAP` leaves.
NARROWEST_LANE: Final = 1.85
# Streets move aside and have narrow lanes this far, m, beyond the places that lack room, so that half of a taper fits
# before these; what lies between such parts and beside them stays as it is if it is so long. Choices.
SEPARATED_BEYOND: Final = 30.0
SHORTEST_BETWEEN: Final = 60.0
# Lanes become as narrow as this before OSM's lines move, m: RASt 06 has 2.75 where room is short, and streets of
# several lanes were surveyed from 2.8. Those of motorways do not: 14 km of them all have 3.6 to 3.7.
NARROW_LANE_BUILT: Final = 2.75
# How far lines move before lanes get narrower than that, m: surveyed lines are off by 0.56 in the median.
LINE_ASIDE: Final = 0.5
# Standard errors, m: of the width of each of several lanes (surveyed lanes of one class differ by so much), and of a
# carriageway of one lane (quartiles of residential one-way streets are 3.1 and 5.7 m).
LANE_ERROR: Final = 0.3
ONE_LANE_ERROR: Final = 1.9

# ---------------------------------------------------------------- junctions

# A junction takes tight bends that end within this distance of its arm's end, m; a choice.
BEND_IN_JUNCTION: Final = 10.0
# Radius of the kerb at a corner between two streets, m, by the lesser street's highway value: RASt 06 section 6.3.5
# recommends 5 to 8 m for minor roads; private access is tighter. With these, cars turn right at 5 to 8 m.
KERB_RADIUS: Final = MappingProxyType(
    {"residential": 5.0, "living_street": 4.0, "unclassified": 5.0, "road": 5.0, "service": 4.0, "track": 4.0}
)
KERB_RADIUS_OTHER: Final = 6.0
