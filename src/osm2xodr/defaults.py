"""Default numbers that several parts share: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

# ---------------------------------------------------------------- reading OSM

# ``maxspeed=walk``, km/h: OSM wiki, Key:maxspeed, from German case law (4 to 7 km/h).
WALKING_SPEED_KMH: Final = 7.0
# Latitude up to which there are roads (Svalbard: 78.7) and the frame is of use, degrees.
LATITUDE_MAX_DEG: Final = 84.0
# How far beyond an area the ways of multipolygons of buildings and water are fetched and cut out with it, m: a
# choice, as far as most roads reach that begin in it, and farther than buildings do; seas and rivers end there.
OUTLINE_REACH: Final = 1000.0

# ---------------------------------------------------------------- heights

# Height from a road to the one above it that traffic needs at least, m: a lorry is 4.0 m high (Directive 96/53/EC).
CLEARANCE_LEAST: Final = 4.0

# Largest grade of a road by OSM's highway value, rise per metre. The order of magnitude of the design limits for
# rolling to mountainous terrain in the German RAL and RASt 06 and in AASHTO's Green Book, links a little steeper than
# the roads they join. Real streets exceed them; the profile treats them as elastic.
GRADE_LIMIT: Final = MappingProxyType(
    {
        "motorway": 0.06,
        "motorway_link": 0.08,
        "trunk": 0.07,
        "trunk_link": 0.08,
        "primary": 0.09,
        "primary_link": 0.10,
        "secondary": 0.10,
        "secondary_link": 0.11,
        "tertiary": 0.12,
        "tertiary_link": 0.12,
        "unclassified": 0.15,
        "residential": 0.15,
        "living_street": 0.15,
        "service": 0.18,
        "track": 0.25,
    }
)
GRADE_LIMIT_OTHER: Final = 0.15
# Elevation models with larger cells, m, do not show a road's own bed: the ground is estimated from the cells around.
COARSE_CELL: Final = 15.0
# How far around roads such cells are needed, cells: windows of 48 whose inner 24 hold a road reach 36 beyond it.
COARSE_MARGIN_CELLS: Final = 38
# Standard error of a height that is a guess (voids, beyond the elevation model), and the length of road that one such
# guess stands for, m.
GUESS_SIGMA: Final = 30.0
GUESS_LENGTH: Final = 200.0

# ---------------------------------------------------------------- priorities at junctions

# Roads of this rank and below yield wherever they end; others only to a road that runs on through the junction.
PRIORITY_RANK_MINOR: Final = 2
# How far before the end of its street a sign or signal stands that is meant for the junction there, m; a choice,
# twice what stop lines of wide junctions keep from the middle.
SIGN_REACH: Final = 50.0
# The same for lights of a crossing without any that OSM says are the junction's, m: RiLSA counts crossings as far as
# this away as those of the junction's arms; a choice.
SIGNALLED_CROSSING_REACH: Final = 30.0

# ---------------------------------------------------------------- surface

# How heights between the cells of an elevation model are found, and the total degree of the polynomial trend.
# Bicubic: on ten places with a known terrain and a noisy 30 m model, roads made from it are 5 % better in grade and
# 14 % in height than from bilinear heights (docs/elevation.md). Degree 4 after the thesis that this converter
# descends from; as the trend only fills, little depends on it.
SURFACE_METHOD: Final = "bicubic"
POLYNOMIAL_ORDER: Final = 4

# ---------------------------------------------------------------- connecting roads

# Smallest radius of the middle of a turning lane that a car drives: half of a turning circle of 11 m less half of
# the car (DIN 70020), rounded down. Sharper ones are reported.
CONNECTING_RADIUS: Final = 3.0
# Turns sharper than that swing out first where there is room: they turn forth and back by at most this, rad (86
# degrees), and by this if they turn back (218 degrees: lanes 2 m apart), so that no car goes round a circle.
MOST_SWING: Final = 1.5
MOST_SWING_BACK: Final = 3.8
# Turns by at least this lead back, rad (150 degrees). A choice.
LEAST_TURN_BACK: Final = 2.618

# ---------------------------------------------------------------- roads as points and faces

# How far a chord may lie from its curve, m, and the longest chord, m. A twentieth of a metre is less than the width
# of a road mark (RMS: 0.12 m and more), so no lane is drawn over its neighbour's mark.
SAMPLE_TOLERANCE: Final = 0.05
SAMPLE_STEP: Final = 10.0

# ---------------------------------------------------------------- checking files

# Findings that are listed per rule; a choice.
CHECK_FINDINGS: Final = 20

# ---------------------------------------------------------------- reports and pictures

# Findings per rule that the report lists at most; a choice.
REPORT_FINDINGS: Final = 500
# Width of pictures, pixels, and the largest. Choices.
RENDER_WIDTH: Final = 1600
RENDER_WIDTH_MOST: Final = 16_384

# ---------------------------------------------------------------- furniture: what lies beside the carriageway

# Heights of kerbs by OSM's value, m: RASt 06, 0.12 (0.10 to 0.14); DIN 18040-3, 0.03 where lowered; rolled ones 0.05,
# a choice. What lies beyond a kerb without a height is as high as a raised one. Heights above the last are none.
KERB_HEIGHT: Final = MappingProxyType(
    {
        "raised": 0.12,
        "yes": 0.12,
        "regular": 0.12,
        "normal": 0.12,
        "rolled": 0.05,
        "lowered": 0.03,
        "flush": 0.0,
        "no": 0.0,
    }
)
KERB_HEIGHT_MAX: Final = 0.5

# Code and value of the header's ``<userData>`` of files whose lane ids are negated, as SUMO's netconvert wants them
# in left-hand networks: own words, which only this package knows.
NEGATED_LANES: Final = ("lanes", "negated")

# Code of the ``<userData>`` of roads without measured heights. Its value has s of the begin and of the end of each
# stretch, m, with blanks between.
UNMEASURED_HEIGHTS: Final = "unmeasured_heights"
