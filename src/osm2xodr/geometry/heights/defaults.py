"""Parameters of the heights' objective: meaning, unit, source. SI units unless the name says otherwise.

docs/method/heights.md gives each its symbol and place in the formulas, and a test finds them all there. Settings of
the numerical methods stand in the modules that use them.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

# ---------------------------------------------------------------- roads as beams

# Variance of a road's vertical curvature times the length over which it is correlated, 1/m: (1e-3 1/m)² over 50 m, a
# vertical radius of 1000 m. Height and grade errors against known terrain are flat from 2e-5 to 2e-4; on coarsened
# models of real places 2e-5 to 5e-5 does best. Factors by class: motorways have crests of 13000 m and more (RAA
# 2008), streets of a few hundred.
ROAD_FLEXIBILITY: Final = 5e-5
FLEXIBILITY_FACTOR: Final = MappingProxyType(
    {"motorway": 0.3, "trunk": 0.4}
    | dict.fromkeys(("motorway_link", "trunk_link", "primary", "primary_link"), 0.5)
    | dict.fromkeys(("secondary", "secondary_link"), 0.7)
)
# Roads of hills bend with them. Along a line through relief of spectrum A / k⁴ curvature has the density A k / 4; at
# the wave number RELIEF_WAVE, rad/m, it is compared with that of the road. Where it is larger, the road's density is
# multiplied by the quotient to the power of RELIEF_SHARE. 1 would be a road that lies on the ground wherever it goes.
# On coarsened models of two real places 0.4 to 0.7 does equally well in height, 0.6 and more in its 99th percentile.
RELIEF_WAVE: Final = 0.025
RELIEF_SHARE: Final = 0.6
# Length over which a road's grade forgets itself, m, where the ground is estimated from coarse cells: what curvature
# adds to the grade dies away over it, so that grades have the standard deviation (q L / 2)^1/2, 4 % on plains and
# 10 % in hills. Little else holds short roads and dead ends. On coarsened models of real places 60 to 85 m do equally
# well.
GRADE_LENGTH: Final = 70.0
# Bridges and tunnels longer than this are drawn straight between their ends, m.
STRUCTURE_TENSION_LENGTH: Final = 60.0
# Factor on the flexibility of bridges for each bridge above them: they are built straight between their portals, and
# what passes over them is built higher.
LOWER_DECK_FLEXIBILITY: Final = 0.05
# Standard error of a junction's tilt about level, where its roads leave it open, rise per metre: streets at junctions
# are within a few percent.
JUNCTION_TILT_SIGMA: Final = 0.3

# ---------------------------------------------------------------- elements and samples

# Longest element, m, by the least cell size from which it holds, m: (cell size, length). On cells of 30 m heights and
# grades are the same to 1 cm and 0.02 % for 15 to 120 m.
KNOT_SPACING: Final = ((20.0, 60.0), (5.0, 25.0), (0.0, 12.0))
# Samples per cell along a road, and the bounds of their distance, m.
SAMPLES_PER_CELL: Final = 1.5
SAMPLE_SPACING_MIN: Final = 3.0
SAMPLE_SPACING_MAX: Final = 20.0

# ---------------------------------------------------------------- the ground

# How far from OSM's streets the ground is estimated before roads are built, m: beyond what junctions and turning
# circles move roads by. What lies farther is estimated later.
GROUND_REACH: Final = 40.0
# Factor on the roughness penalty of the first surface through coarse cells, which shows what stands out. Against
# known terrain 2 to 8 do equally well.
ROAD_SMOOTHNESS: Final = 3.0
# Roads leave the ground that was estimated from coarse cells by its standard error, or by this share of the elevation
# model's if that is less, over this length, m. On coarsened models of real places 0.7 to 0.9 and 45 to 60 m do
# equally well.
GROUND_SIGMA_SHARE: Final = 0.8
GROUND_LENGTH: Final = 60.0
# Least standard error of heights, m: keeps the solve well conditioned on exact surfaces.
HEIGHT_SIGMA_MIN: Final = 0.05
# Farther than this from all that is measured heights are reported as not known, m: there the surface has fallen back
# to the trend of the whole map.
UNKNOWN_FROM: Final = 1000.0
# Length over which an elevation model's errors are correlated: in cells, and at least, m.
NOISE_LENGTH_CELLS: Final = 1.7
NOISE_LENGTH_MIN: Final = 2.0
# How far a road is cut into a slope, in cells, which do not show it. On coarsened models of real places 0.17 is
# better than 0.1.
POSITION_ERROR_CELLS: Final = 0.17
# Most of it, m: cuts and fills are as wide as roads are, whatever the cells.
POSITION_ERROR_MAX: Final = 5.0
# Factor on the weight of ground near the ends of bridges and tunnels, and how far that reaches, m; half a cell where
# that is more.
PORTAL_WEIGHT: Final = 0.01
PORTAL_LENGTH: Final = 8.0
# Standard error of the ground as the height of a bridge that the map's edge cuts, m: about the height of bridges, and
# at least this share of the length that is there: long bridges are high. Choices.
CUT_BRIDGE_SIGMA: Final = 5.0
CUT_BRIDGE_RISE: Final = 0.03
# Length of road that the height of a junction's middle stands for, m.
JUNCTION_LENGTH: Final = 10.0

# ---------------------------------------------------------------- other observations

# ``incline`` is estimated or the steepest part: standard error, rise per metre, the length of road that one value
# stands for, m, and the value above which it is a mistake (steeper than any street).
INCLINE_SIGMA: Final = 0.02
INCLINE_LENGTH: Final = 100.0
INCLINE_MAX: Final = 0.35
# ``ele`` of a node is read off a map, a sign or a receiver: standard error, m, and the residual, in these, at which
# it loses half of its weight, as datums differ and slips are common. Choices: signs of passes are good for 1 m,
# receivers and contour lines for 5 to 10 m.
ELE_SIGMA: Final = 2.5
ELE_SCALE: Final = 6.0
# Carriageways of one street that run opposite ways within this distance are level, with this standard error, m.
DUAL_CARRIAGEWAY_DISTANCE: Final = 25.0
DUAL_CARRIAGEWAY_SIGMA: Final = 0.5
# Standard errors with which an area keeps to the heights and grades at its borders, m and rise per metre: little
# beside what must meet (1 cm), and much beside rounding.
BORDER_HEIGHT_SIGMA: Final = 1e-4
BORDER_GRADE_SIGMA: Final = 1e-4

# ---------------------------------------------------------------- robust loss and canopy

# Residual, in standard errors, at which Cauchy's loss halves a weight. A choice: well beyond noise.
ROBUST_SCALE: Final = 3.0
# The same for ground that is estimated from coarse cells: outliers are set aside in that estimate already, and what a
# road leaves it by is relief. On coarsened models of real places 4.5 to 8 do equally well, 3 drops dead ends' ground.
ROBUST_SCALE_ESTIMATED: Final = 6.0
# The same for heights of a surface model, which stand on canopy and roofs: above the road, and below it (from below
# they are the ground).
CANOPY_SCALE_ABOVE: Final = 1.5
CANOPY_SCALE_BELOW: Final = 8.0
# To see through canopy the roads are stiff at first: lengths over which they give way, m, and how far the ground
# leaves such a road, m (a vertical radius of 1000 m over half of it).
CANOPY_STAGES: Final = ((150.0, 3.0), (80.0, 1.0), (40.0, 0.5))
# Heights that keep less than this share of their weight stand out; the others keep at least the second share from
# then on. On bare models of 9 and 13 m that are taken for surface models roads stay within 4 m so (15 m without).
CANOPY_OUTLIER: Final = 0.25
CANOPY_GROUND_FLOOR: Final = 0.2
# What stands out is canopy or roofs if heights along it change by more than this, m, and more steeply than ground,
# rise per metre. Choices.
WALL_HEIGHT: Final = 2.0
WALL_SLOPE: Final = 0.5

# ---------------------------------------------------------------- limits

# Elastic grade limit: this times the class's grade.
GRADE_SLACK: Final = 1.25
# How far the ground gives way to limits, m: to those that readers and cars need, and to what the user knows, as if to
# none; to the usual grade of a class where the ground itself is no steeper; to how roads twist at junctions by half a
# standard error of the elevation model; to the level ends of arms that cannot be warped; to ways that part as one
# surface; to the deepest cut. Choices; docs/method/heights.md says what they mean.
FIRM_PUSH: Final = 50.0
GRADE_PUSH: Final = 10.0
USUAL_PUSH_SIGMAS: Final = 0.5
LEVEL_ARM_PUSH: Final = 1.0
PARTING_PUSH: Final = 3.0
CUT_AND_FILL_PUSH: Final = 3.0
# Deepest cut and highest fill by class, m.
CUT_AND_FILL_OTHER: Final = 2.0
CUT_AND_FILL: Final = MappingProxyType(
    dict.fromkeys(("motorway", "motorway_link", "trunk", "trunk_link"), 15.0)
    | dict.fromkeys(("primary", "primary_link", "secondary", "secondary_link"), 6.0)
    | dict.fromkeys(("tertiary", "tertiary_link"), 4.0)
)
CUT_AND_FILL_SIGMAS: Final = 1.0
EARTHWORK_REACH: Final = 60.0
# Largest vertical acceleration that heights give a car, m/s², at the speed limit, in bends at the speed with this
# lateral acceleration, m/s². Choices: crests and sags are designed for 0.3 to 0.5 (AASHTO), which roads beside
# contradictory data cannot have; 0.3 of the earth's is what drivers accept in bends.
VERTICAL_ACCELERATION_MAX: Final = 2.5
LATERAL_ACCELERATION: Final = 3.0
# Largest difference in height of two arms of a junction that come together as one carriageway, m. A choice: either
# road gives way by half.
JUNCTION_EDGE_STEP_MAX: Final = 0.06
# Largest tilt of a junction's plane across arms that are level, rise per metre, and what it may lift their edges by,
# m. Connecting roads have to twist by the tilt. 2.5 % is what drainage takes (RAL, AASHTO), 6 % the steepest
# superelevation in towns (RASt 06, AASHTO for low speeds). Arms that are warped take as much as streets are steep.
FAST_CROSS_SLOPE_MAX: Final = 0.025
CROSS_SLOPE_MAX: Final = 0.06
CROSS_STEP_MAX: Final = 0.10
WARP_MAX: Final = 0.30
# Vertical acceleration that the run-off of a warped arm gives its outer lane, m/s²: of comfortable crests (AASHTO).
WARP_ACCELERATION: Final = 0.5
# How far the plane may be from the crossfall of carriageways that keep it at their junction. A choice: 0.5 cm over a
# wide carriageway.
CARRIED_CROSS_SLOPE_MAX: Final = 0.0005
# Arms lie beside each other whose carriageways are at most so far apart, m, whose ends are at most so far apart along
# them, m, and which run the same way out of the junction but for this angle, rad. Choices: as gores are.
BESIDE_GAP: Final = 3.0
BESIDE_LENGTH: Final = 25.0
BESIDE_ANGLE: Final = 0.5
# Height from road to road where layers cross, m, by the highway value of the road below: clear height and a deck of
# 0.70 m. 4.50 m (RAL, RAA), on main roads 4.70 m with room for resurfacing, and 3.50 m where only cars and fire
# engines pass (DIN 14090). A crossing that falls short by more than the tolerance is reported.
CLEARANCE_OTHER: Final = 5.2
CLEARANCE: Final = MappingProxyType(
    dict.fromkeys(("motorway", "motorway_link", "trunk", "trunk_link", "primary", "primary_link"), 5.4)
    | dict.fromkeys(("living_street", "service", "pedestrian", "track"), 4.2)
)
# Where a sign gives the height of vehicles (``maxheight``) that counts instead, with this deck, m.
DECK: Final = 0.7
CLEARANCE_TOLERANCE: Final = 0.3
# How far the ground's own heights give way to clearance at a place: in standard errors of the elevation model, and
# from 1 m (twice its error beneath bridges) to 500 m. A precise model shows the road in its cutting; there the bridge
# has to rise. To clearances and heights that the user knows they give way by the last.
CLEARANCE_PUSH_SIGMAS: Final = 100.0
CLEARANCE_PUSH_MIN: Final = 1.0
CLEARANCE_PUSH_MAX: Final = 500.0
# Largest force with which a tunnel that rises above the ground is pushed below it, and a bridge that lies below it
# above: that of measured heights which are so far off, m. A choice: it wins over tunnels below, which can go deeper,
# and loses to streets and junctions.
STRUCTURE_PUSH: Final = 10.0
# Largest difference in height of carriageways that lie over each other right beside a node that they share, m, and
# how far the ground is moved for it at most, m. Choices: they are one surface there.
MEETING_STEP_MAX: Final = 0.1
MEETING_PUSH: Final = 3.0

# ---------------------------------------------------------------- inside junctions

# Distance of samples along connecting roads, m. A choice.
CONNECTOR_SAMPLE_SPACING: Final = 2.0
# By how much a connecting road's grade may differ from that of the reference line it touches, for the sake of the
# lane that it continues, rise per metre. A choice: half of what is felt.
LANE_GRADE_STEP_MAX: Final = 0.0045
# Length at either end over which a connecting road makes up for the difference between surface and arm, m.
CONNECTOR_END_REACH: Final = 12.0

# Largest change of a connecting road's superelevation, rad/m, and between fast roads: one wheel of a car of 2.7 m by
# 1.6 m leaves the plane of the others by 5 and 3 cm. Records may add a third.
TWIST_MAX: Final = 0.015
FAST_TWIST_MAX: Final = 0.007
# Mean change of superelevation along a connecting road that turns between warped arms, rad/m. A choice: with 1.5
# times that in the middle of a smooth step one wheel of a car leaves the plane of the others by 20 cm.
TURNING_TWIST_MAX: Final = 0.033

# ---------------------------------------------------------------- superelevation

# Superelevation of fast roads: read where cells are at most so large (2 m) and the standard error of heights so
# small, m, over at least this half width of the carriageway, m. It is smoothed over two to three times the length of
# the beam, m; readings that differ by the standard error count a quarter, ones steeper than plausible (verges, walls)
# nothing. At most 8 % (RAA 2008: 7 %, AASHTO: 8 % where there is ice). Records fit this well, rad.
CROSSFALL_CELL_MAX: Final = 2.1
CROSSFALL_SIGMA_MAX: Final = 0.5
CROSSFALL_HALF_WIDTH_MIN: Final = 1.5
CROSSFALL_LENGTH: Final = 25.0
CROSSFALL_SIGMA: Final = 0.02
CROSSFALL_PLAUSIBLE: Final = 0.12
CROSSFALL_MAX: Final = 0.08
CROSSFALL_TOLERANCE: Final = 0.001

# Superelevation that roads are designed with. The least crossfall is that of RAA 2008 and RAL 2012, 2.5 %, which
# surveyed motorways have throughout, the largest that of RAA 2008, 6 %. Side friction that may be asked of tyres by
# speed: AASHTO Green Book 2018, table 3-7. Outward crossfall stays in bends that ask at most the adverse friction,
# which is RAA 2008's least radius of 4000 m at 130 km/h. Design speeds by class, m/s: RAA 2008 (EKA 1, 2; ramps:
# table 24). The curvature is the mean over this window, m: bends of OSM have corners. Roads whose junctions are
# closer than this have no room for run-offs at both ends, m.
CROSSFALL_LEAST: Final = 0.025
CROSSFALL_DESIGN_MAX: Final = 0.06
CROSSFALL_ADVERSE_FRICTION: Final = 0.033
SIDE_FRICTION_SPEEDS: Final = tuple(v / 3.6 for v in (40, 50, 60, 70, 80, 90, 100, 110, 120, 130))
SIDE_FRICTION: Final = (0.23, 0.19, 0.17, 0.15, 0.14, 0.13, 0.12, 0.11, 0.09, 0.08)
DESIGN_SPEED: Final = MappingProxyType(
    {"motorway": 130 / 3.6, "trunk": 100 / 3.6, "motorway_link": 80 / 3.6, "trunk_link": 60 / 3.6}
)
CROSSFALL_WINDOW: Final = 80.0
CROSSFALL_ROOM: Final = 200.0
# Length over which roads of a level world come back to it from a junction whose arms lie on its crossfall, m. A
# choice: what 6 m of offset and 2.5 % make is 0.2 %.
LEVEL_AGAIN: Final = 100.0
# Where one road passes over another on a level world, roads within this distance may be ramps, m: 6 m at 6 % and the
# crest and sag at its ends take 250 m.
RAMP_REACH: Final = 300.0
# How firmly roads keep to a level world there: cell size, m, and standard error, m, of an elevation model to which
# they would keep as firmly. Choices: ramps have about the grade of their class.
LEVEL_CELL: Final = 10.0
LEVEL_SIGMA: Final = 1.0

# ---------------------------------------------------------------- records

# One elevation record stands for several where it fits all knots this well: m, rise per metre.
RECORD_TOLERANCE: Final = 0.015
RECORD_SLOPE_TOLERANCE: Final = 1e-3
# Decimals of places, heights (or cross slopes) and grades at knots, m, m (rad) and rise per metre: far below what any
# height is worth.
RECORD_S_DECIMALS: Final = 3
RECORD_DECIMALS: Final = 5
RECORD_SLOPE_DECIMALS: Final = 6
# How far connecting roads may leave their junction's surface for the sake of few records: along their middle, m, in
# grade, rise per metre, by their cross slope at their edges, m, and in twist, rad/m. A choice; twice that is what two
# of them may disagree by.
CONNECTOR_TOLERANCE: Final = 0.012
CONNECTOR_GRADE_TOLERANCE: Final = 0.002
CONNECTOR_EDGE_TOLERANCE: Final = 0.012
CONNECTOR_TWIST_TOLERANCE: Final = 0.002
