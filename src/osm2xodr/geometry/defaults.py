"""Numbers that several parts of geometry share: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

import math
from types import MappingProxyType
from typing import Final

# ---------------------------------------------------------------- heights

# No road outside junctions is steeper, and no junction's plane: Baldwin Street in Dunedin, the steepest there is, has
# 0.35, and the connecting roads of a junction need room for what the plane's tilt adds to their grade.
GRADE_MAX: Final = 0.31
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
# Radius that the inner edge of a carriageway keeps in a bend, m. A choice: an edge without one folds over itself.
INNER_EDGE_RADIUS: Final = 0.5
# Values of ``highway`` that are built for speed: long gores and tapers, wide marks.
FAST_HIGHWAYS: Final = ("motorway", "motorway_link", "trunk", "trunk_link")

# ---------------------------------------------------------------- junctions

# How far along its arms a junction may reach, m; farther where ramps join at acute angles (RAA 2008: gores of 100 m).
ARM_REACH: Final = 40.0
ARM_REACH_MOTORWAY: Final = 100.0
# A street that keeps less than this between two junctions becomes part of one junction where that does no harm, m:
# no car has room to wait there. In queues a car takes 6 m (HBS 2015).
SHORTEST_STREET_BETWEEN_JUNCTIONS: Final = 6.0
# What any street between two junctions keeps, if they cannot be one, and dead ends beside setbacks and loops, m (half
# of the street, where it is shorter than twice that). A choice: markings and lights stand apart on it.
SHORTEST_STREET: Final = 3.0
# Shortest road at a dead end, m (half of its street, where the street is shorter than 2 m). A choice.
SHORTEST_ROAD: Final = 1.0
# What both ends of a road may lose together when they are moved onto borders of its lines and arcs, m.
SNAPPED: Final = 0.02

# ---------------------------------------------------------------- lanes along a road

# Length over which a lane opens or ends, in multiples of its width, where limits are low (up to 45 km/h), at speeds
# of towns (up to 50 km/h) and on fast roads (from 80 km/h), from towns on in proportion; lanes that shift to the side
# take twice that of their shift. The first is a choice: the shortest smooth step that is nowhere steeper than 1 in 5.
# AASHTO, A Policy on Geometric Design of Highways and Streets 2018, 9.7: 8 to 15.
SLOW_TAPER_RATIO: Final = 7.6
TAPER_RATIO: Final = 8.5
TAPER_RATIO_FAST: Final = 15.0
SLOW_SPEED: Final = 45.0 / 3.6
TOWN_SPEED: Final = 50.0 / 3.6
FAST_SPEED: Final = 80.0 / 3.6
# The least such multiple above `SLOW_SPEED`, also where there is little room. AASHTO's 8, and a little for the round
# ends of a taper.
STEEPEST_TAPER: Final = 8.5
# Where limits are low a lane opens behind the place where OSM's lanes change, and ends before it, if that leaves it
# its width on at least this share of its stretch. A choice; tapers are about that place where they are longer.
FULL_WIDTH_SHARE: Final = 0.25
# Lanes that hardly change do so over this length where there is room, m: what goes with their width is a few
# centimetres then, and cars jerk. A choice, the length of a small car: lanes of half a metre open over as much.
SHORTEST_TAPER: Final = 4.0
# Where room lacks for this many times the width, a taper is a line with round ends, of this share of its length each;
# longer ones are smooth steps. Choices: a smooth step of 7.5 is 1 in 5 where it is steepest.
SMOOTH_TAPER: Final = 7.5
ROUND_END: Final = 0.15
# Where a road is too short for that, the ends are as short as it takes for widths to change no faster than this, but
# no shorter than this share. Choices: 1 in 5, as above.
STEEPEST_WIDTH: Final = 0.2
SHORTEST_ROUND_END: Final = 0.05
# How fast the sideways acceleration of a car changes, m/s3, in lanes that shift to the side where there is room:
# AASHTO 2018, 3.3.8 has 0.3 to 0.9 for transition curves.
SHIFT_JERK: Final = 0.5
# At no more than this speed, m/s: 130 km/h, the advisory speed of German motorways.
SHIFT_SPEED: Final = 130.0 / 3.6
# Such a shift is no shorter than this many times its width: it is half as steep as 1 in this at most. A choice.
GENTLEST_SHIFT: Final = 20.0
# Lanes lead straight on through a junction if their way bends by no more, rad (10 degrees); those that are off by
# more than this, m, are others: half of a lane, and a little. Choices.
IN_LINE_BEND: Final = 0.17
IN_LINE_FARTHEST: Final = 2.1
# How much it counts that a carriageway stays against lanes in line, and how far it shifts at most for these, m: with
# turn lanes, beside which OSM's lines often lead straight on, without, and where tags tell its place. Choices: 95 %
# of roads stay within 0.6 m of OSM's line.
IN_LINE_WEIGHT: Final = 0.5
IN_LINE_WEIGHT_TURNS: Final = 0.1
IN_LINE_WEIGHT_KNOWN: Final = 20.0
IN_LINE_MOST: Final = 0.45
IN_LINE_MOST_TURNS: Final = 1.0
# Smaller shifts are left out, m. A choice.
IN_LINE_LEAST: Final = 0.2
# Stretches that are passed in less time, s, shift as a whole. A choice: about twice what `IN_LINE_MOST_TURNS` takes.
IN_LINE_SECONDS: Final = 8.0
# Turns below this lead straight on, rad (50 degrees): about half of a square turn. A choice.
STRAIGHT_ON: Final = math.radians(50.0)
# Lanes of one direction that open at one place do so one after another, at least this far apart, m. A choice.
LANES_OPEN_APART: Final = 6.0
# At either end of a road its lanes are steady for this length, m. A choice: they meet those of the junction.
STEADY_END: Final = 1.0
# Length within which tapers lie that may reach into a bend, m: a lane of 3.5 m opens over it in town.
TAPER_LENGTH: Final = 30.0
# A strip beside the carriageway tapers over at most this share of its stretch at either end.
TAPER_SHARE: Final = 0.45
# Lane sections shorter than this are taken over by their longer neighbour, m: a bay that short is mostly an artefact.
SHORTEST_LANE_SECTION: Final = 12.0

# ---------------------------------------------------------------- connecting roads

# Arms of a junction whose turns are too sharp, or whose bends are too tight, are set back by this much at a time, m.
ARM_SETBACK_STEP: Final = 0.75
# Smallest radius of the middle of the lane of a turn back, m: a car's turning circle of 10 to 12 m between kerbs; and
# the largest that one has whose lanes are far apart. Choices.
U_TURN_RADIUS: Final = 4.0
U_TURN_RADIUS_MAX: Final = 6.0
# A bend is tight where the outermost lane is longer than the reference line by more than this share. Half of a narrow
# lane (2.8 m), m: the middle of the outermost lane lies at least this far inside the carriageway's edge.
TIGHT_BEND: Final = 0.08
HALF_NARROW_LANE: Final = 1.4

# Cars that drive from arm to arm and back meet where the middles of their ways come nearer than a car is wide, m:
# the design vehicle of RASt 06 (1.75 m), rounded up; or than this share of narrower lanes' width, a choice.
CAR_WIDTH: Final = 1.8
MEETING_SHARE: Final = 0.85

# ---------------------------------------------------------------- streets side by side

# Streets run side by side where the sine of the angle between them is below this; they are compared at places this
# far apart, m, and a gap is left between their carriageways, m. Choices.
PARALLEL_SINE: Final = 0.2
PARALLEL_SPACING: Final = 8.0
PARALLEL_GAP: Final = 0.2
# Least distance between the lanes of opposite carriageways of a motorway, m: RAA 2008 has medians of 2.5 m and more.
LEAST_MEDIAN: Final = 2.5

# ---------------------------------------------------------------- splits and merges

# Junctions whose ways turn by less than this, rad (30 degrees), are splits and merges. Where limits are at least so
# high, km/h, their stems, and other arms, are set back by at most so much, m, and by that share of their OSM ways,
# until cars shift aside with no more than this acceleration, m/s2. Choices; surveyed exit lanes of a motorway part
# from it over 130 m.
MERGE_TURN: Final = 0.52
MERGE_SPEED_KMH: Final = 60.0
MERGE_SETBACK_MAX: Final = 80.0
MERGE_BRANCH_MAX: Final = 25.0
MERGE_SHARE_MAX: Final = 0.35
MERGE_ACCELERATION: Final = 2.5
# Roads are cut where their name changes, but for pieces shorter than this, m: about a car, nobody's address.
SHORTEST_NAME: Final = 5.0
