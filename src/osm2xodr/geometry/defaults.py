"""Numbers that several parts of geometry share: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

# ---------------------------------------------------------------- heights

# Elastic grade limit: this times the class's grade. No road outside junctions is steeper than the firm limit, no
# junction's plane than the firm tilt: Baldwin Street in Dunedin, the steepest there is, has 0.35, and the connecting
# roads of a junction need room for what the plane's tilt adds to their grade.
GRADE_SLACK: Final = 1.25
GRADE_MAX: Final = 0.31
# ``ele`` of a node is read off a map or a receiver, in whatever datum: standard error, m (a choice; receivers and
# contour lines are good for 5 to 10 m); values beyond these are mistakes, m (shore of the Dead Sea, highest roads).
ELE_SIGMA: Final = 5.0
ELE_PLAUSIBLE: Final = (-450.0, 6000.0)
# Grade of a connecting road above which it leaves the junction's surface if that makes it less steep.
CONNECTOR_STEEP: Final = 0.30

# ---------------------------------------------------------------- plan view

# Smallest radius that a corner of a street gets where the corner cut allows, by OSM's highway value: turning
# radii of cars (RASt 06: 6 m) and of the lowest design speeds of the class.
CORNER_RADIUS: Final = MappingProxyType(
    {
        "motorway": 100.0,
        "motorway_link": 30.0,
        "trunk": 60.0,
        "trunk_link": 25.0,
        "primary": 15.0,
        "secondary": 12.0,
        "tertiary": 10.0,
        "service": 4.0,
        "track": 4.0,
    }
)
CORNER_RADIUS_OTHER: Final = 6.0
# Radius that the inner edge of a carriageway keeps in a bend, m, and how far the line may move for it. Choices: an
# edge without a radius folds over itself, and nodes in bends are a metre or two off; hairpins of few nodes more.
INNER_EDGE_RADIUS: Final = 0.5
BEND_ASIDE: Final = 2.5
# Values of ``highway`` that are built for speed: long gores and tapers, wide marks.
FAST_HIGHWAYS: Final = ("motorway", "motorway_link", "trunk", "trunk_link")

# ---------------------------------------------------------------- junctions

# How far along its arms a junction may reach, m; farther where ramps join at acute angles (RAA 2008: gores of 100 m).
ARM_REACH: Final = 40.0
ARM_REACH_MOTORWAY: Final = 100.0
# A street that keeps less than this between two junctions becomes part of one junction, m: no car has room to wait
# there. A choice.
SHORTEST_STREET_BETWEEN_JUNCTIONS: Final = 3.0
# Shortest road where two junctions cannot be one, m (half of its street, where the street is shorter than 2 m). A
# choice.
SHORTEST_ROAD: Final = 1.0

# ---------------------------------------------------------------- lanes along a road

# Length over which a lane opens or ends: 30 m at urban speeds, 100 m on motorways (RASt 06 section 6.3, RAA 2008).
TAPER_LENGTH: Final = 30.0
TAPER_LENGTH_MOTORWAY: Final = 100.0
# A taper takes at most this share of its lane section at either end.
TAPER_SHARE: Final = 0.45
# Lane sections shorter than this are taken over by their longer neighbour, m: their tapers would be steps.
SHORTEST_LANE_SECTION: Final = 12.0

# ---------------------------------------------------------------- connecting roads

# Arms of a junction whose turns are too sharp, or whose bends are too tight, are set back by this much at a time, m.
ARM_SETBACK_STEP: Final = 0.75
# A bend is tight where the outermost lane is longer than the reference line by more than this share; a junction takes
# tight bends that end within this distance of its arm's end, m. Half a lane, m.
TIGHT_BEND: Final = 0.08
BEND_IN_JUNCTION: Final = 10.0
HALF_LANE: Final = 1.4

# ---------------------------------------------------------------- streets side by side

# Streets are compared with those that run beside them, nearer than the reach, within the sine of their headings, at
# places this far apart; a gap is left between their carriageways; lanes keep at least this share of their width (a
# lane of 3.5 m becomes one of 2.45 m, about the narrowest that a car drives): m, ratio.
PARALLEL_REACH: Final = 25.0
PARALLEL_SINE: Final = 0.2
PARALLEL_SPACING: Final = 8.0
PARALLEL_GAP: Final = 0.2
NARROWEST: Final = 0.7
