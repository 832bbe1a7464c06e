"""Every default number of the converter, once, with its source. SI units unless the name says otherwise."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

# ---------------------------------------------------------------- reading OSM

# Narrowest and widest lane that is made from a carriageway's width, m. RASt 06: two cars pass each other slowly on
# 4.10 m, and lanes that two cars use side by side begin at 5.50 m; what is beyond that is room for parking. Widths
# that ``width:lanes`` gives for a lane itself are believed within wider limits, narrower ones for other than cars.
LANE_WIDTH_MIN: Final = 2.0
LANE_WIDTH_MAX: Final = 5.5
TAGGED_LANE_WIDTH_MIN: Final = 0.5
TAGGED_LANE_WIDTH_MAX: Final = 10.0
# Lanes narrower than this are for bicycles if there are more widths than lanes for cars, m (RASt 06: lanes for cars
# and lorries from 2.75, bicycle lanes up to 2.50 with their marks and safety strips).
NARROW_LANE: Final = 2.5
# Width of a carriageway that ``width`` can mean, m: from a car's to ten wide lanes with their margins.
CARRIAGEWAY_WIDTH_MIN: Final = 1.5
CARRIAGEWAY_WIDTH_MAX: Final = 60.0

# Width of one lane by OSM's highway value, m: RAA 2008 (motorways 3.75), RAL 2012 (rural roads 3.50 and 3.25) and
# RASt 06 (6.50 m of carriageway for main streets with buses, 5.50 m for residential ones, 4.75 m where a car passes a
# lorry slowly); within 0.2 m of the 12, 11 and 9 feet of AASHTO's Green Book for the same uses.
LANE_WIDTH: Final = MappingProxyType(
    {
        "motorway": 3.75,
        "motorway_link": 3.5,
        "trunk": 3.5,
        "trunk_link": 3.5,
        "primary": 3.5,
        "primary_link": 3.5,
        "secondary": 3.25,
        "secondary_link": 3.25,
        "tertiary": 3.0,
        "tertiary_link": 3.0,
        "busway": 3.25,
        "unclassified": 2.75,
        "residential": 2.75,
        "road": 2.75,
        "living_street": 2.5,
        "service": 2.5,
        "pedestrian": 2.5,
        "track": 2.0,
        "raceway": 5.0,
    }
)
LANE_WIDTH_OTHER: Final = 2.75
# Lanes beside those for cars, m: RASt 06, bus lanes 3.25 to 3.50, bicycle lanes 1.50 (advisory) to 1.85.
LANE_WIDTH_BUS: Final = 3.25
LANE_WIDTH_BICYCLE: Final = 1.5

# Lanes of a one-way road without ``lanes`` (OSM wiki, Key:lanes, assumptions); all others have one each way.
ONEWAY_LANES: Final = MappingProxyType({"motorway": 2, "trunk": 2})
# Over so many ways without ``lanes`` a street's number of lanes is looked for on either side; a choice.
LANES_FROM_NEIGHBOURS_STEPS: Final = 5
# More lanes than any carriageway has (toll plazas reach 25); a larger ``lanes`` is a mistake.
LANES_PLAUSIBLE_MAX: Final = 25

# ``maxspeed=walk``, km/h: OSM wiki, Key:maxspeed, from German case law (4 to 7 km/h).
WALKING_SPEED_KMH: Final = 7.0
# Faster than any limit that is signed; a larger ``maxspeed`` is a mistake, km/h.
SPEED_PLAUSIBLE_MAX_KMH: Final = 250.0

# Steeper than the steepest streets (0.35 to 0.38) and tracks; a larger ``incline`` is a mistake, rise per metre.
GRADE_PLAUSIBLE_MAX: Final = 0.45
# Layers beyond these are mistakes (OSM wiki, Key:layer: -5 to 5; stacked interchanges keep within 8).
LAYER_PLAUSIBLE_MAX: Final = 10

# Nodes in a row nearer to each other than this are one node, m: OSM's coordinates have steps of 1 cm.
SAME_NODE_DISTANCE: Final = 1e-3
# A line that turns by more than this, rad (150 degrees), between segments longer than this, m, turns on the spot: no
# road does, a junction can. With shorter segments it is a slip of the mapper's hand. Choices.
TURN_ON_THE_SPOT: Final = 2.618
SLIP_OF_THE_HAND: Final = 5.0
# Where nodes of a way are absent from the file, their neighbours are joined up to this distance, m; a way that leaves
# the area and comes back farther away is cut. A choice: a few times the usual distance of nodes on straight roads.
ABSENT_NODES_BRIDGED: Final = 200.0
# How far from the origin the local frame is true to 1 part in 8 000, m: (x / 6371 km)² / 2 of a transverse Mercator.
FRAME_REACH: Final = 100e3
# Latitude up to which there are roads (Svalbard: 78.7) and the frame is of use, degrees.
LATITUDE_MAX_DEG: Final = 84.0
# How far an area may reach in longitude, degrees: PROJ's transverse Mercator ends 80 degrees from its meridian.
LONGITUDE_SPAN_MAX_DEG: Final = 160.0
# How far out at sea the nearest country still tells the side that traffic drives on, m.
COUNTRY_REACH: Final = 200e3

# ---------------------------------------------------------------- heights

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

# Elastic grade limit: this times the class's grade. No road outside junctions is steeper than the firm limit, no
# junction's plane than the firm tilt: Baldwin Street in Dunedin, the steepest there is, has 0.35, and the connecting
# roads of a junction need room for what the plane's tilt adds to their grade.
GRADE_SLACK: Final = 1.25
GRADE_MAX: Final = 0.31
# Least grade limit that a user may set: RAL and RASt want 0.5 to 0.7 % at least for the water to run off.
GRADE_LIMIT_LEAST: Final = 0.005
JUNCTION_TILT_MAX: Final = 0.20
# Mean grade of the shortest way between the lanes of two road ends at a junction: the cubic that joins them may be
# one and a half times as steep in its middle.
JUNCTION_STEP_MAX: Final = 0.15
# Largest difference in height of two road ends at a junction whose edges touch, m; with a gap, what such a path
# climbs over it is added, up to the gap across which connecting roads do not come to the same place at once, m.
# Choices: both that meet there then give way by half of it.
JUNCTION_EDGE_STEP_MAX: Final = 0.06
JUNCTION_EDGES_NEAR: Final = 1.5

# Variance of a road's vertical curvature times the length over which it is correlated, 1/m: (1e-3 1/m)² over 50 m, a
# vertical radius of 1000 m. Height and grade errors against known terrain are flat from 2e-5 to 2e-4; on coarsened
# models of real places 2e-5 to 5e-5 does best. Factors by class: motorways have crests of 13000 m and more (RAA
# 2008), streets of a few hundred.
ROAD_FLEXIBILITY: Final = 5e-5
FLEXIBILITY_FACTOR: Final = MappingProxyType(
    {
        "motorway": 0.2,
        "motorway_link": 0.5,
        "trunk": 0.3,
        "trunk_link": 0.5,
        "primary": 0.5,
        "primary_link": 0.5,
        "secondary": 0.7,
        "secondary_link": 0.7,
    }
)
# Bridges and tunnels are drawn straight between their ends where they are longer than this, m.
STRUCTURE_TENSION_LENGTH: Final = 60.0

# Longest piece of road that one cubic stands for in the solve, m, by the least cell size, m; on cells of 30 m heights
# and grades are the same to 1 cm and 0.02 % for 15 to 120 m. Distance of samples: in cells, and its bounds, m.
KNOT_SPACING: Final = ((20.0, 60.0), (5.0, 25.0), (0.0, 12.0))
SAMPLES_PER_CELL: Final = 1.5
SAMPLE_SPACING_MIN: Final = 3.0
SAMPLE_SPACING_MAX: Final = 20.0

# Elevation models with larger cells, m, do not show a road's own bed: the ground is estimated from the cells around.
COARSE_CELL: Final = 15.0
# How far from OSM's streets the ground is estimated before roads are built, m: beyond what junctions and turning
# circles move roads by. What lies farther is estimated later.
GROUND_REACH: Final = 40.0
# Least standard error of heights, m: keeps the solve well conditioned on exact surfaces.
HEIGHT_SIGMA_MIN: Final = 0.05
# Length over which an elevation model's errors are correlated: cells, but at least so many m.
NOISE_LENGTH_CELLS: Final = 1.7
NOISE_LENGTH_MIN: Final = 2.0
# How far a road lies beside its line in OSM, m (imagery offsets and hand), and what the cells add, in cells: they do
# not show what was cut and filled for the road. On coarsened models of real places 0.17 is better than 0.1.
POSITION_ERROR: Final = 2.0
POSITION_ERROR_CELLS: Final = 0.17
# Roads are smoother than the ground they are built on: factor on the roughness penalty that the ground calls for.
# Against known terrain 2 to 8 do equally well.
ROAD_SMOOTHNESS: Final = 4.0

# Heights of a surface model stand on canopy and roofs: how many standard errors above and below the road they begin
# to lose weight (from below they are the ground). To see through them the roads are stiff at first: lengths over
# which they give way, m, and how far the ground leaves such a road, m (a vertical radius of 1000 m over half of it).
COVERED_ABOVE: Final = 1.5
COVERED_BELOW: Final = 8.0
COVERED_STAGES: Final = ((150.0, 3.0), (80.0, 1.0), (40.0, 0.5))
# What keeps less than this share of its weight stands out; the rest keeps at least that share of it from then on. On
# bare models of 9 and 13 m that are taken for surface models roads stay within 4 m so (15 m without). What stands out
# is canopy or roofs if heights along it change by more than this, m, and more steeply than ground. Choices.
COVERED_OUT: Final = 0.25
COVERED_LEAST: Final = 0.2
WALL_HEIGHT: Final = 2.0
WALL_SLOPE: Final = 0.5

# Standard error of a height that is a guess (voids, beyond the elevation model), and the length of road that one such
# guess stands for, m.
GUESS_SIGMA: Final = 30.0
GUESS_LENGTH: Final = 200.0
# Weight of ground near the ends of bridges and tunnels, and how far that reaches, m.
PORTAL_WEIGHT: Final = 0.01
PORTAL_LENGTH: Final = 8.0
# Length of road whose heights a junction's middle counts as much as, m.
JUNCTION_LENGTH: Final = 10.0
# Standard error of a junction's tilt about level, where no road tells: streets at junctions are within a few percent.
JUNCTION_TILT_SIGMA: Final = 0.3
# ``incline`` is estimated or the steepest part: standard error, the length of road that one value stands for, m, and
# what cannot be (steeper than any street).
INCLINE_SIGMA: Final = 0.02
INCLINE_LENGTH: Final = 100.0
INCLINE_MAX: Final = 0.35
# ``ele`` of a node is read off a map or a receiver, in whatever datum: standard error, m (a choice; receivers and
# contour lines are good for 5 to 10 m); values beyond these are mistakes, m (shore of the Dead Sea, highest roads).
ELE_SIGMA: Final = 5.0
ELE_PLAUSIBLE: Final = (-450.0, 6000.0)
# Carriageways of one street that run opposite ways within this distance are level, with this standard error, m.
TWIN_DISTANCE: Final = 25.0
TWIN_SIGMA: Final = 0.5

# Height from road to road where layers cross, m, by the highway value of the road below: clear height and a deck of
# 0.70 m. 4.50 m (RAL, RAA), on main roads 4.70 m with room for resurfacing, and 3.50 m where only cars and fire
# engines pass (DIN 14090). What a crossing falls short by is told from the tolerance on.
CLEARANCE_OTHER: Final = 5.2
CLEARANCE: Final = MappingProxyType(
    {
        "motorway": 5.4,
        "motorway_link": 5.4,
        "trunk": 5.4,
        "trunk_link": 5.4,
        "primary": 5.4,
        "primary_link": 5.4,
        "living_street": 4.2,
        "service": 4.2,
        "pedestrian": 4.2,
        "track": 4.2,
    }
)
CLEARANCE_TOLERANCE: Final = 0.1
# How far the ground's own heights give way to clearance: in standard errors of the elevation model, and from 0.5 m
# (its error beneath bridges) to 10 m. A precise model shows the road in its cutting; there the bridge has to rise.
CLEARANCE_PUSH_SIGMAS: Final = 5.0
CLEARANCE_PUSH_MIN: Final = 0.5
CLEARANCE_PUSH_MAX: Final = 10.0

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

# Connecting roads: distance of samples, m, at which distance from its arms a junction's plane counts like an arm, and
# how far to the side of an arm's end its level counts. Choices: with these, fewest connecting roads of seven steep
# places disagree.
CONNECTOR_SAMPLE_SPACING: Final = 2.0
JUNCTION_PLANE_DISTANCE: Final = 4.0
ARM_LEVEL_DISTANCE: Final = 3.0
# Within how many metres of its ends a connecting road makes up for what is left between surface and arms there.
CONNECTOR_END_REACH: Final = 8.0
# Grade of a connecting road above which it leaves the junction's surface if that makes it less steep.
CONNECTOR_STEEP: Final = 0.30

# One elevation record stands for several where it fits all knots this well: m, rise per metre.
PROFILE_TOLERANCE: Final = 0.015
PROFILE_SLOPE_TOLERANCE: Final = 1e-3
# Decimals of places, heights (or cross slopes) and grades at knots, m, m (rad) and rise per metre: far below what any
# height is worth.
PROFILE_S_DECIMALS: Final = 3
PROFILE_DECIMALS: Final = 5
PROFILE_SLOPE_DECIMALS: Final = 6
# How far connecting roads may leave their junction's surface for the sake of few records, m: along their middle, and
# by their cross slope at their edges; and how much steeper they may become. A choice; twice that is what two of them
# may disagree by.
CONNECTOR_GRADE_TOLERANCE: Final = 0.01
CONNECTOR_TOLERANCE: Final = 0.012
CONNECTOR_EDGE_TOLERANCE: Final = 0.012

# ---------------------------------------------------------------- plan view

# How far a vertex of an OSM way may be left out of its curve. OSM's own error is 1 to 2 m (Haklay 2010,
# doi:10.1068/b35097); 0.2 m changes no heading that a driver notices.
SIMPLIFY_TOLERANCE: Final = 0.2
# Nodes closer than this carry no direction of their own.
SHORTEST_SEGMENT: Final = 0.5
# How far a curve cuts a corner of the polyline at least (where the place allows) and at most for turns up to 90
# degrees, and at most for hairpins of one node. With 0.5 m and half of it given back outwards, curves through
# polylines of true alignments come closest to them.
CORNER_CUT: Final = 0.5
CORNER_CUT_MAX: Final = 2.0
CORNER_CUT_HAIRPIN: Final = 6.0
# Radius above which a curve is no longer told from a line; also keeps single-precision readers exact.
LARGEST_RADIUS: Final = 2000.0
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

# How far, m, a roundabout's ring may pass its nodes: at most, and as the root of the mean square if it is a circle,
# and if it is another smooth curve. Nodes set by hand on an image are a few decimetres off their neighbours (the 1 to
# 2 m of Haklay 2010 are mostly common to all); a round shape is likelier than any other. Of 37 rings of 8 places 32
# are circles within 0.5 m, and within 0.12 m by the mean square.
RING_TOLERANCE: Final = 0.6
RING_CIRCLE_RMS: Final = 0.3
RING_CURVE_RMS: Final = 0.2
# By how much a circle may leave the line between two nodes of a ring, m (one of 12 m drawn with four nodes leaves it
# by 3.5 m); and from how much on, on a ring that is no circle, that line is a straight side. Choices.
RING_OFF_CIRCLE: Final = 4.0
RING_OFF_LINE: Final = 1.0
# Length of the arcs of rings that are no circles, m, and of the lines that their straight sides are cut into.
RING_ARC: Final = 4.0
RING_SIDE: Final = 5.0
# Least turn of an open row of streets that is taken for part of a ring (extracts cut some), rad (120 degrees).
RING_TURN_MIN: Final = 2.09
# Over this length of a street that joins a ring the line follows its end, which is moved onto the ring, m.
RING_ARM_BLEND: Final = 15.0

# Values of ``highway`` that are built for speed: long gores and tapers, wide marks.
FAST_HIGHWAYS: Final = ("motorway", "motorway_link", "trunk", "trunk_link")

# ---------------------------------------------------------------- junctions

# Radius of the kerb at a corner between two streets, by the lesser street's highway value: RASt 06 section 6.3.5
# recommends 5 to 8 m for minor roads; private access is tighter.
KERB_RADIUS: Final = MappingProxyType(
    {"residential": 4.0, "living_street": 3.0, "unclassified": 4.0, "road": 4.0, "service": 2.0, "track": 2.0}
)
KERB_RADIUS_OTHER: Final = 5.0
# A kerb's tangent is not let grow beyond this at acute corners, where nobody turns at speed.
KERB_TANGENT_MAX: Final = 8.0
# Free space between a junction's arms where their roads end.
ARM_CLEARANCE: Final = 0.5
# How far along its arms a junction may reach where a street turns on the spot, m; there they lie on each other.
ARM_REACH_TURN: Final = 12.0
# Arms of a node at which nobody can turn lie on each other within the angle of this cosine (45 degrees); and nobody
# turns on the spot from one fast road into another within that of the second (20 degrees). Choices.
ACUTE_COSINE: Final = 0.7
NO_TURN_COSINE: Final = 0.94
# How far along its arms a junction may reach; more where ramps join at acute angles (RAA 2008: gores of 100 m).
ARM_REACH: Final = 40.0
ARM_REACH_MOTORWAY: Final = 100.0
# Streets that keep less than this between two junctions become part of one junction.
SHORTEST_STREET_BETWEEN_JUNCTIONS: Final = 3.0
# Roads are not cut shorter than this where their junctions cannot be one (or, at the very least, than a quarter).
SHORTEST_ROAD: Final = 1.0
# A ring without any junction that is shorter than this, m, is a point that somebody drew as a line: the circle whose
# radius a turning lane has at least (CONNECTING_RADIUS), rounded down.
SHORTEST_RING: Final = 18.0
# Streets shorter than this that a turn restriction runs over (via way) become part of a junction.
RESTRICTED_STREET: Final = 30.0
# Largest extent of the nodes of one junction.
JUNCTION_EXTENT: Final = 60.0
# Streets across a median, from one carriageway to the other of the same road, are at most so long, m; within the
# angle of this cosine (37 degrees) the carriageways run opposite ways, and square to the street.
MEDIAN_CROSSING: Final = 40.0
CARRIAGEWAYS_COSINE: Final = 0.8
# Bridges and tunnels shorter than this, m, may lie within a junction: less than two carriageways pass beneath them.
SHORTEST_BRIDGE: Final = 8.0


# ---------------------------------------------------------------- priorities at junctions

# Rank of a road by OSM's highway value where nothing is signed: who comes from a road of less rank yields. Ramps
# yield to all roads, whoever leaves a property, a track or a street with walking speed to all others (StVO, sections
# 8, 10 and 18; Vienna Convention on Road Traffic, article 18). Residential and unclassified roads are alike.
PRIORITY_RANK: Final = MappingProxyType(
    {
        "motorway": 9,
        "trunk": 8,
        "primary": 7,
        "secondary": 6,
        "tertiary": 5,
        "unclassified": 4,
        "residential": 4,
        "road": 4,
        "busway": 4,
        "living_street": 2,
        "pedestrian": 2,
        "service": 1,
        "track": 0,
    }
)
PRIORITY_RANK_LINK: Final = 3
PRIORITY_RANK_OTHER: Final = 4
# Roads of this rank and below yield wherever they end; others only to a road that runs on through the junction.
PRIORITY_RANK_MINOR: Final = 2
# How far before the end of its street a sign or signal stands that is meant for the junction there, m; a choice,
# twice what stop lines of wide junctions keep from the middle.
SIGN_REACH: Final = 50.0
# The same for lights of a crossing without any that OSM says are the junction's, m: RiLSA counts crossings as far as
# this away as those of the junction's arms; a choice.
SIGNALLED_CROSSING_REACH: Final = 30.0
# Share of a junction's entries that must have a signal for the junction to be one with signals; a choice.
SIGNALLED_SHARE: Final = 0.5

# ---------------------------------------------------------------- lanes along a road

# Length over which a lane opens or ends: 30 m at urban speeds, 100 m on motorways (RASt 06 section 6.3, RAA 2008).
TAPER_LENGTH: Final = 30.0
TAPER_LENGTH_MOTORWAY: Final = 100.0
# A taper takes at most this share of its lane section at either end.
TAPER_SHARE: Final = 0.45
# Lane sections shorter than this are taken over by their longer neighbour, m: their tapers would be steps.
SHORTEST_LANE_SECTION: Final = 12.0
# Lanes run on in line where another pairing of them would shift each by this much more, m.
IN_LINE: Final = 0.5
# Speed above which a road without a better sign is taken for a rural one, m/s (60 km/h: beyond urban limits).
RURAL_SPEED: Final = 60.0 / 3.6
# Width of narrow marks and of wide ones (motorway edges), m: German RMS 1993.
MARK_WIDTH: Final = 0.12
MARK_WIDTH_WIDE: Final = 0.15
# Width of edge lines, in general and of roads built for speed, and of lines beside lanes for buses, taxis and
# bicycles, m: narrow and wide marks of RMS 1993. Widths by country are in conventions/countries.json.
EDGE_MARK_WIDTH: Final = 0.12
EDGE_MARK_WIDTH_FAST: Final = 0.15
SPECIAL_MARK_WIDTH: Final = 0.25
SPECIAL_MARK_WIDTH_FAST: Final = 0.30
# Values of ``highway`` for streets that have no lines unless a tag says so, and for roads whose edges have none.
# Choices after RMS 1993: no lines where limits are low, edge lines on main roads.
UNMARKED_HIGHWAYS: Final = ("residential", "living_street", "service", "track", "pedestrian")
EDGELESS_HIGHWAYS: Final = ("unclassified", "road", "busway")
# A two-way carriageway narrower than this has no centre line, m (RMS 1993: 5.5 m).
CENTRE_LINE_FROM: Final = 5.5

# ---------------------------------------------------------------- surface

# How heights between the cells of an elevation model are found, and the total degree of the polynomial trend.
# Bicubic: on ten places with a known terrain and a noisy 30 m model, roads made from it are 5 % better in grade and
# 14 % in height than from bilinear heights (docs/elevation.md). Degree 4 after the thesis that this converter
# descends from; as the trend only fills, little depends on it.
SURFACE_METHOD: Final = "bicubic"
POLYNOMIAL_ORDER: Final = 4

# Least share of the roads that an elevation model must cover unless the user allows less (a choice: what is guessed
# should not outweigh what is known).
DEM_COVERAGE_MIN: Final = 0.5

# What is read around the roads, m and cells: room for lane edges and for the fitted curves, which leave the OSM line
# by a few metres; eight cells dampen the end effect of a bicubic spline to 3e-5 of itself (0.27 per cell).
DEM_MARGIN: Final = 50.0
DEM_MARGIN_CELLS: Final = 8

# Most cells that are kept of all elevation models (128 MB in single precision), and for a bicubic spline, which
# takes 30 bytes more per cell. Where the roads span more, the finest models are averaged over blocks of cells, and
# that is said.
DEM_CELLS_MAX: Final = 2**25
DEM_CELLS_MAX_BICUBIC: Final = 2**23
# More cells than these are not read, even to be averaged: a minute's work, 32 km of cells of 1 m either way. Files of
# a few hundred bytes can claim them.
DEM_CELLS_READ: Final = 2**30
# Largest block of cells that a file may ask to be unpacked as a whole, bytes; usual ones have up to some MB.
DEM_BLOCK_MAX: Final = 2**28

# Over which length the step between two elevation models fades, m and cells of the coarser one, whichever is longer
# (3 m of step over 100 m: 4.5 % of grade at most); and over which length the guess beyond the last measured cell
# falls back to the trend, m. Choices.
SEAM_RAMP: Final = 100.0
SEAM_RAMP_CELLS: Final = 4
EDGE_RAMP: Final = 1000.0

# Magnitude above which a height is no height, m: no road is higher (Everest: 8849 m) or lower. Below the second
# height no road lies either (shore of the Dead Sea: -430 m), so that values there that stand for "nothing" in
# models without a nodata tag give themselves away in whatever unit.
HEIGHT_LIMIT: Final = 9000.0
HEIGHT_LOWEST: Final = -450.0
HEIGHT_SENTINELS: Final = (-32768.0, -32767.0, -9999.0, -99999.0, -999999.0)

# Standard error of an elevation model's heights, m, by the size of its cells, m; between them the logarithms are
# interpolated. Airborne laser 1 m: 0.1-0.15; national models of 5 to 10 m: 0.5-1; Copernicus GLO-30 and AW3D30: 2-3
# (product handbooks and comparisons against geodetic points); SRTM at 3 arc seconds: 5-6.
DEM_SIGMA: Final = ((1.0, 0.12), (2.0, 0.15), (5.0, 0.5), (10.0, 1.0), (30.0, 2.0), (90.0, 5.0))

# Surface models (canopy, roofs) are told from terrain models by their heights where their name does not say it, on
# gentle slopes: rise per metre, over some distance, m. Up to the first cell size, m, by the share of cells at which
# three heights in a row bend by more than 1.5 m and a quarter of a cell, which ground does at walls only: none in ten
# terrains of 5 m, 3 to 62 % with houses and trees over 5 to 60 % of them (cells of 1 and 5 m). Above it by the
# skewness of heights about the median around them: 1.3 to 1.8 with blobs of 3 to 12 m over a tenth of the ground, at
# most 0.8 in five models of 10 to 90 m that see the ground or through most of the canopy. Less scatter than this, m,
# is noise.
COVER_GENTLE: Final = 0.3
COVER_GENTLE_OVER: Final = 50.0
COVER_FINE_CELL: Final = 5.5
COVER_BEND: Final = 1.5
COVER_BEND_PER_CELL: Final = 0.25
COVER_WALLS: Final = 0.02
COVER_SKEWNESS: Final = 1.0
COVER_SCATTER: Final = 0.5
# Cells in a row, along and across, that it takes to tell; if the roads need fewer, more are read around them.
COVER_CELLS: Final = 200

# What stands off all ground around it by more than this is no ground: m, times the cell size (a grade of 250 % on all
# sides: needles of rock have it, roads do not), and in standard errors. Small blobs (3 x 3 cells) must stand off by
# the range of the heights around them as well; larger ones by so many standard deviations from the polynomial trend,
# or have one single value, and on this share of their rim. Choices; no cell of 17 models of 10 to 90 m does.
OUTLIER_STEP: Final = 30.0
OUTLIER_GRADE: Final = 2.5
OUTLIER_SIGMAS: Final = 8.0
OUTLIER_TREND: Final = 6.0
OUTLIER_RIM: Final = 0.9

# Distance of the points at which the difference between two vertical datums is found, m: geoids are smoother.
DATUM_SPACING: Final = 1000.0

# Cells that the comparison of interpolations looks at: half a million take a few seconds. Of larger models so many
# patches in either direction are taken, evenly spread; fewer cells in a row than the last compare nothing.
COMPARISON_CELLS: Final = 2**19
COMPARISON_PATCHES: Final = 3
COMPARISON_CELLS_MIN: Final = 12

# Two elevation models on one common grid are one model unless they differ by more than this share of their standard
# error where they meet.
DEM_SAME_SHARE: Final = 0.5

# Distance between the points at which roads are held against an elevation model, m: below the cells of the coarsest
# ones in use (90 m).
COVERAGE_STEP: Final = 50.0

# ---------------------------------------------------------------- writing

# Written as the limit of a lane that has none on a road that has one: ``lane/speed@max`` knows no "no limit".
# A choice: beyond what road vehicles reach.
NO_LIMIT_KMH: Final = 400

# ---------------------------------------------------------------- connecting roads

# Smallest radius of the middle of a turning lane that a car drives: half of a turning circle of 11 m less half of
# the car (DIN 70020), rounded down. Sharper ones are reported.
CONNECTING_RADIUS: Final = 3.0
# A connecting road shorter than this, m, that turns by more than this, rad, is a point: no car turns on one.
SHORTEST_TURN: Final = 0.1
TURN_OF_A_POINT: Final = 0.5
# A street runs smoothly on through a junction where no corner on its way is sharper than this, rad (30 degrees);
# a connecting road that strays farther from it than STRAY, m, follows it instead.
SMOOTH_CORNER: Final = 0.52
STRAY: Final = 0.25
# A way through a junction that turns to and fro, or by more than this in all, rad (140 degrees), has several corners.
# A connecting road that strays from it by more than this, m, turns at each of them instead, if it then strays by less
# than this share of that; between corners it runs straight from this far beyond one to this far before the next, m.
CORNERS_TURN: Final = 2.44
STRAY_CORNERS: Final = 3.0
STRAY_LESS: Final = 0.8
CORNER_LEAD: Final = 4.0
# Turns sharper than that swing out first where there is room: they turn forth and back by at most this, rad (86
# degrees), and by this if they turn back, by more than this (172 and 149 degrees: lanes 3 m apart), so that no car
# goes round a circle. They must not run onto the first stretch of the junction's roads, m.
MOST_SWING: Final = 1.5
MOST_SWING_BACK: Final = 3.0
SWING_BACK: Final = 2.6
WIDE_TURN_REACH: Final = 25.0
# A change of heading above this is a turn back, rad (165 degrees).
TURN_BACK: Final = 2.88
# Arms of a junction with a sharper turn are cut back by this much at a time, at most so many times, m.
# So are arms of a turn above SWING_OF_TURN, rad (40 degrees), that turns to the other side, too: forth and back by
# more than SWING, rad (20 degrees).
SWING_OF_TURN: Final = 0.7
SWING: Final = 0.35
TURNING_ROOM: Final = 0.75
TURNING_ROOM_STEPS: Final = 8
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
# Streets that leave each other less than this share of their widths are no carriageways side by side; a choice.
LEAST_ROOM: Final = 0.5
# A connecting road that is longer than this many times the distance it bridges, and this much more, m, is none: its
# arms lie on each other. They are cut back, and what stays so is left out.
DETOUR: Final = 4.0
DETOUR_MORE: Final = 60.0

# ---------------------------------------------------------------- turnarounds

# Diameter of a turning circle whose tags give none, m: a lorry of two axles collecting waste needs 16 m (RASt 06,
# section 6.1.2.2); and of the loops that close other dead ends: 12 m, a car's. What is believed of tags.
TURNING_CIRCLE_DIAMETER: Final = 16.0
TURNAROUND_DIAMETER: Final = 12.0
TURNAROUND_DIAMETER_MIN: Final = 8.0
TURNAROUND_DIAMETER_MAX: Final = 40.0
# Free space between a loop and the next carriageway, and the longest piece of a street that is looked at as one, m.
TURNAROUND_CLEARANCE: Final = 0.5
TURNAROUND_PIECE: Final = 40.0
# Lanes that lie this near to their loop's radius apart go round half a circle without more ado, m.
TURNAROUND_ASIDE_MIN: Final = 0.05

# ---------------------------------------------------------------- batches
# Road and junction ids that each area of a shared frame may use; a choice.
BATCH_IDS_PER_AREA: Final = 100_000
# Side of the smallest tiles, m, below which most roads are cut several times, and the greatest number of tiles.
# Choices.
BATCH_TILE_MIN: Final = 200.0
BATCH_TILES_MAX: Final = 100_000
# Origins of the frames of tiles are rounded to this, degrees, so that tiles keep names and ids when the map's bounds
# move a little from one extract to the next; a choice.
BATCH_ORIGIN_STEP_DEG: Final = 0.1
# An area during whose conversion so many workers died is given up.
BATCH_WORKER_DEATHS: Final = 3
# How long a conversion that is to stop has for its temporary files, s, before it is killed.
BATCH_STOP_GRACE: Final = 3.0
# A process that has not been given an area for so long ends, s; a choice.
BATCH_IDLE: Final = 60.0

# ---------------------------------------------------------------- areas side by side
# The first metres of a junction's arms belong to the area of the junction, m: the arms have to be there for its
# connecting roads, and their stop lines and lights stand on them.
BORDER_STUB: Final = 25.0
# What a road runs through an area for less than this stays with its neighbour, m: as long as two stubs.
BORDER_PIECE: Final = 50.0
# Heights where roads are cut follow from the roads that come this near to both areas, m. Evidence farther off than
# the length over which a road bends (some 100 m on coarse elevation models, `ROAD_FLEXIBILITY`) hardly moves them.
BORDER_HEIGHT_REACH: Final = 270.0
# What comes this near to the border is cut out whole for both areas, m: roads lie some metres off OSM's lines.
BORDER_REACH: Final = 300.0
# Around the ends of streets that come this near to a border, what lies within this belongs to the cut as well, m:
# junctions farther off do not shape each other (twice the longest connecting road through a large junction).
CONTEXT_REACH: Final = 200.0
# So far from the middle of these streets, m, is all that lies beside them: sidewalks tell of built-up areas and their
# speed limits over the whole length of a street (half of the widest carriageway, `ROADSIDE_REACH`, and some room).
CONTEXT_BESIDE: Final = 50.0
# Standard errors with which an area keeps to these heights and grades, m and rise per metre: little beside what must
# meet (1 cm), and much beside rounding.
BORDER_HEIGHT_SIGMA: Final = 1e-4
BORDER_GRADE_SIGMA: Final = 1e-4

# ---------------------------------------------------------------- several cores

# More processes than these gain little: what cannot be shared out takes about a third of the time on one core, so
# eight are at most twice as fast as two (Amdahl's law).
MOST_JOBS: Final = 8

# ---------------------------------------------------------------- roads as points and faces

# How far a chord may lie from its curve, m, and the longest chord, m. A twentieth of a metre is less than the width
# of a road mark (RMS: 0.12 m and more), so no lane is drawn over its neighbour's mark.
SAMPLE_TOLERANCE: Final = 0.05
SAMPLE_STEP: Final = 10.0
# Most chords of one record: a damaged file must not fill the memory. At 0.1 m each they make 1 km.
SAMPLE_MOST: Final = 10_000
# Distance between the points by which roads are looked up, m: near enough that the nearest point of a curve lies
# next to the nearest of them.
FIND_STEP: Final = 4.0
# Roads are looked up so far beside their reference lines at most, m; wider ones are a damage of the file.
FIND_REACH: Final = 100.0
# How far from a lane's border a place still lies on the lane, m: rounding of what is typed in.
FIND_SLACK: Final = 1e-6
# Up to here coordinates of meshes stay those of the file, m: single precision (24 bits) knows them to 1 mm at least.
# Beyond, they count from a round place, m. Choices.
EXPORT_EXACT: Final = 16_384.0
EXPORT_ORIGIN_GRID: Final = 1000.0
# Lanes that are nowhere wider than this are left out of maps, m: less than any road mark.
EXPORT_THINNEST: Final = 0.01

# ---------------------------------------------------------------- checking files

# What is a finding, and from where on it is an error where it would else be a warning.
# Distance between places that should be one, m: ASAM's checker allows lanes 0.01 at touching points. An error is what
# shakes a wheel: a choice.
CHECK_GAP: Final = 0.01
CHECK_GAP_GRAVE: Final = 0.1
# Turn of the heading in one place, degrees: a car at 50 km/h is 0.24 m beside its line after a second. An error above
# what the steering of a car takes up over its own length: a choice.
CHECK_KINK: Final = 1.0
CHECK_KINK_GRAVE: Final = 10.0
# Step of the grade in one place, %: a car pitches by 0.3 degrees at 0.5; an error is a break on which low cars
# ground. Choices.
CHECK_GRADE_STEP: Final = 0.5
CHECK_GRADE_STEP_GRAVE: Final = 8.0
# Grade, %: steeper than any street that cars use (Baldwin Street, Dunedin: 34.8), and than all but a few (15).
CHECK_GRADE: Final = 35.0
CHECK_GRADE_STEEP: Final = 15.0
# Stated length less that of the curve, m: ASAM's checker for paramPoly3; sums of records, m: rounding of many.
CHECK_RECORD_LENGTH: Final = 0.001
CHECK_ROAD_LENGTH: Final = 0.01
# Two stations along s are one, m; records and sections shorter than this are of no use, m: RoadRunner rounds lengths
# to 1 cm.
CHECK_SAME_S: Final = 1e-6
CHECK_SHORT: Final = 0.01
# Widths below this are negative, m: the tolerance of ASAM's checker for widths of 0. A lane narrower than that much
# where it ends is one that has tapered out, m: half of a shoe.
CHECK_ZERO_WIDTH: Final = 1e-6
CHECK_TAPERED: Final = 0.15
# A lane's border folds where it is nearer to the centre of the curve than this, m.
CHECK_FOLD: Final = 0.0
# Coordinates that single precision (24 bits) still tells apart to 1 cm, m: 2**17 at 2**-6 m; a round number below.
CHECK_COORDINATE: Final = 1e5
# Largest id that readers keep in 32 bits with a sign. Junction ids of 3e9 fail in CARLA, its limit was not sought.
CHECK_ID_MAX: Final = 2**31 - 1
# Places of two connecting roads that are one place, m; distances between samples along and the shares of the
# carriageway at which they lie; heights that differ by more are not one surface, m (half of a low kerb), or an error;
# by still more: another level.
CHECK_SURFACE_PLACE: Final = 0.12
CHECK_SURFACE_STEP: Final = 1.0
CHECK_SURFACE_SHARES: Final = (0.05, 0.35, 0.65, 0.95)
CHECK_SURFACE: Final = 0.12
CHECK_SURFACE_GRAVE: Final = 0.3
CHECK_LEVELS: Final = 2.0
# Middles of lanes that end so near to each other end on one lane, m: half of a narrow one.
CHECK_SAME_LANE: Final = 1.0
# Overlaps of carriageways are counted in cells of this size, m, that far from edges and from ends; an area above this
# is a finding, m2: a car's.
CHECK_OVERLAP_CELL: Final = 0.7
CHECK_OVERLAP_EDGE: Final = 0.4
CHECK_OVERLAP_END: Final = 1.5
CHECK_OVERLAP: Final = 8.0
# Pieces of a road over which its steepness is looked at, m; findings that are listed per rule.
CHECK_SAMPLE_STEP: Final = 1.0
CHECK_FINDINGS: Final = 20
# Larger files are not held against the schema of 1.8, bytes: xmlschema takes ten seconds and more for each MB.
CHECK_SCHEMA_18_BYTES: Final = 2_000_000

# ---------------------------------------------------------------- reports and pictures

# How far chords of the page's and of pictures' roads lie from their curves at most, m, and the longest chord, m: less
# than a pixel up to 30 pixels per metre; and between stations of a profile a grade is as good as straight. Choices.
VIEW_TOLERANCE: Final = 0.03
VIEW_STEP: Final = 10.0
# Points of the grid that shows the ground, and how far it reaches beyond the roads at least, m. Choices: the page
# gets 40 kB heavier.
REPORT_TERRAIN_CELLS: Final = 40_000
REPORT_TERRAIN_MARGIN: Final = 60.0
# Roads, findings per rule and ways that tables list at most; a choice.
REPORT_WORST: Final = 25
REPORT_FINDINGS: Final = 500
REPORT_MISSING: Final = 2000
# OSM's ways beside a file's roads: distance of their points, m; how far beside a lane a point still counts as on it,
# m (a way drawn on the kerb); how far their directions may differ, rad (30 degrees); least length on a road of a way
# that is listed with it, m, or half of the road; and least length without a road of a way listed as missing, m.
COVER_SPACING: Final = 10.0
COVER_SLACK: Final = 1.0
COVER_ANGLE: Final = 0.5236
COVER_WAY_LENGTH: Final = 15.0
COVER_MISSING: Final = 15.0
# Pictures: width, pixels, and the largest; pixels in all at most; margin as a share of the longer side; samples per
# pixel in either direction, fewer where there would be more samples than the last (450 MB). Choices.
RENDER_WIDTH: Final = 1600
RENDER_WIDTH_MOST: Final = 16_384
RENDER_PIXELS_MOST: Final = 100_000_000
RENDER_MARGIN: Final = 0.03
RENDER_SAMPLES: Final = 3
RENDER_SAMPLES_MOST: Final = 150_000_000

# ---------------------------------------------------------------- furniture: where traffic stops

# Distance of stop lines from a junction's edge and before crossings, m: RMS (Richtlinien für die Markierung von
# Straßen) part 2 wants at least 1 m before crossings; MUTCD 3B.16 at least 4 ft.
STOP_LINE_SETBACK: Final = 1.0
STOP_LINE_BEFORE_CROSSING: Final = 1.0
# How far from a junction's edge a node with a signal, stop or give-way sign still shows where traffic stops, m.
STOP_NODE_REACH: Final = 20.0

# ---- furniture: crossings, islands, stop lines, arrows and what stands beside the road

# Extent of crossings along the road, m: R-FGÜ 2001 wants zebra crossings of 4 m as a rule, of 3 m at least, RiLSA 4 m
# with lights. Not below 6 ft (MUTCD 2009, 3B.18); what is believed of tags at most is a choice.
CROSSING_WIDTH: Final = 3.0
CROSSING_WIDTH_SIGNALS: Final = 4.0
CROSSING_WIDTH_MIN: Final = 1.83
CROSSING_WIDTH_MAX: Final = 20.0
# Crossings end this far before a road does, m. Nodes inside a junction go to an arm up to so far away, m; arms run
# along the street that is crossed within the sine of this (30 degrees). Choices.
CROSSING_END: Final = 0.05
CROSSING_REACH: Final = 15.0
CROSSING_SINE: Final = 0.5
# A crossing belongs to a junction if what is left between the two is shorter, m: with lights, which are mostly those
# of the junction, than STOP_NODE_REACH; without, than a car that would wait between (RASt 06: 5 m). Choices.
CROSSING_AT_JUNCTION_SIGNALS: Final = 20.0
CROSSING_AT_JUNCTION: Final = 5.0
# Lanes keep this width beside an island, m: that of buses and lorries without their mirrors. Narrower islands are
# none, m; how far they reach beyond their crossing, how long they are without one, and how high, m: choices.
ISLAND_LANE: Final = 2.5
ISLAND_WIDTH_MIN: Final = 1.0
ISLAND_BEYOND: Final = 1.0
ISLAND_LENGTH: Final = 6.0
ISLAND_HEIGHT: Final = 0.12
# Extent of stop lines along the road, m: RMS-1 Zeichen 294 (0.50 m); MUTCD 2009, 3B.16: 12 to 24 in. Give-way lines
# are as wide, Zeichen 341. Two lines nearer than this are one, m; a choice.
STOP_LINE_EXTENT: Final = 0.5
STOP_LINE_APART: Final = 2.0
# Arrows, m: length of 5 m in towns (RMS-1, Zeichen 297); width, from the stop line to the tip of the first, from
# there to the next one's, how many there are, and the narrowest lane that gets them: choices.
ARROW_LENGTH: Final = 5.0
ARROW_WIDTH: Final = 1.0
ARROW_FROM_LINE: Final = 5.0
ARROW_SPACING: Final = 20.0
ARROWS: Final = 2
ARROW_LANE: Final = 2.0
# Length along the road and height of what calms traffic, m. Humps and tables: Highways (Road Hump) Regulations 1999
# (at most 0.1 m high) and FHWA Traffic Calming ePrimer (humps of 12 ft, tables of 22 ft); all else, such as the width
# of cushions, m: choices.
CALMING: Final = {
    "bump": (0.6, 0.08),
    "mini_bumps": (0.3, 0.04),
    "hump": (3.7, 0.08),
    "double_hump": (7.4, 0.08),
    "table": (6.7, 0.08),
    "cushion": (3.0, 0.07),
    "rumble_strip": (3.0, 0.01),
    "dip": (2.0, 0.0),
    "double_dip": (4.0, 0.0),
}
CUSHION_WIDTH: Final = 1.8
# How far from the edge of the carriageway what OSM has beside a road still belongs to the road, m; what lies on the
# carriageway by no more than the second is drawn inaccurately and goes to its edge, this far off it, m. Choices.
OBJECT_REACH: Final = 10.0
OBJECT_INSIDE: Final = 1.0
OBJECT_GAP: Final = 0.1
# Bus stops: height of the sign's upper edge and width of its post, m; where the post stands beside the carriageway, m
# (VwV-StVO: 0.5 m). Bays are as deep as a bus with its mirrors, m, with room for an articulated one, and taper off, m
# (lengths and depth are those of short bays). How far from a carriageway stops still are those of its buses, m. All
# but the second are choices.
BUS_STOP_REACH: Final = 15.0
BUS_STOP_HEIGHT: Final = 2.5
BUS_STOP_WIDTH: Final = 0.1
BUS_STOP_ASIDE: Final = 0.5
BUS_BAY_DEPTH: Final = 3.0
BUS_BAY_LENGTH: Final = 20.0
BUS_BAY_TAPER: Final = 12.0
# Distance of the places at which what runs along roads is looked at, m; how far it may be moved when it is drawn with
# fewer places, m; its shortest part, m; parts that turn from the road by more than this, m per m, do not run along.
OBJECT_SPACING: Final = 3.0
OBJECT_TOLERANCE: Final = 0.1
OBJECT_SHORTEST: Final = 1.0
OBJECT_SLOPE: Final = 1.0
# Distance of what stands in a row that is mapped as a line, m: bollards, so that no car comes through, and trees.
BOLLARD_SPACING: Final = 1.5
TREE_SPACING: Final = 10.0
# Width and height of what stands beside roads where tags give none, m: guard rails of steel (0.75 m) and kerbs (0.12
# m) as they mostly are in Germany (RPS 2009, RASt 06), garden walls, fences and hedges, lamps of streets, young
# trees: choices.
OBJECT_SIZE: Final = {
    "guard_rail": (0.3, 0.75),
    "wall": (0.3, 1.5),
    "fence": (0.1, 1.2),
    "hedge": (0.6, 1.2),
    "bollard": (0.2, 0.9),
    "kerb": (0.15, 0.12),
    "street_lamp": (0.2, 6.0),
    "tree": (0.6, 8.0),
}
# What is believed of tags about heights and widths, m; a choice.
OBJECT_HEIGHT_MAX: Final = 60.0
OBJECT_WIDTH_MAX: Final = 5.0
# Tram tracks, m: standard gauge; head of a grooved rail.
TRAM_GAUGE: Final = 1.435
TRAM_RAIL_WIDTH: Final = 0.07

# ---------------------------------------------------------------- furniture: beside the carriageway

# Length over which strips beside the carriageway open and end, m: kerbs of lay-bys do so within a car's length; and
# the width of the mark that shows a kerb, m: that of a kerbstone (EN 1340, common 125 to 150 mm). Choices.
MARGIN_TAPER_LENGTH: Final = 6.0
KERB_MARK_WIDTH: Final = 0.15
# What stands in the way of strips: carriageways that run along within so much of the road's line, m, at an angle of
# this sine at most; the strips are clear of them so much before and after, m. Choices.
MARGIN_REACH: Final = 16.0
MARGIN_ALONG_SINE: Final = 0.35
MARGIN_CLEARANCE: Final = 8.0
# Share of its width that a strip keeps at least; narrower, it is left out. A choice.
MARGIN_NARROWEST: Final = 0.5
# Sidewalks through junctions that are longer may meet another arm, m. A choice.
CORNER_FAR: Final = 20.0
# How far before a junction's edge a sidewalk lies at the kerb where it would not get round the corner otherwise, m:
# nobody may park there (StVO section 12: 5 m).
CORNER_KERBSIDE: Final = 5.0
# Share of its width that a sidewalk keeps there if it gets round so only. A choice.
CORNER_NARROW: Final = 0.5
# Sidewalks across corners: least radius of their inner edge, m; longest path as a multiple of the direct distance and
# how much longer it may be anyway, m; how much it turns to one side only to turn back, rad; how far onto lanes for
# cars they may reach, m. Choices.
CORNER_EDGE_RADIUS: Final = 0.1
CORNER_DETOUR: Final = 3.0
CORNER_DETOUR_MORE: Final = 5.0
CORNER_SWING: Final = 1.5
CORNER_ONTO_LANE: Final = 0.3
# Gaps between a corner's sidewalk and the carriageway that are narrower stay, m. A choice.
CORNER_FILLED: Final = 0.05

# ---------------------------------------------------------------- furniture: what lies beside the carriageway

# Widths of strips beside the carriageway that a tag can mean, m: from the narrowest strip that people walk on to a
# promenade. A choice.
MARGIN_WIDTH_MIN: Final = 0.3
MARGIN_WIDTH_MAX: Final = 15.0
# Sidewalks without a width, m: Inclusive Mobility (DfT 2021), 2.00 under normal circumstances; between the 1.5 of
# AASHTO's guide for pedestrian facilities and the 2.50 of RASt 06 for new streets.
SIDEWALK_WIDTH: Final = 2.0
# Bicycle tracks for one direction and for both, m (ERA 2010: 2.00 and 2.50), and the strip between the carriageway
# and them, with and without parked cars beside it, m (ERA 2010: 0.75 and 0.50).
CYCLE_TRACK_WIDTH: Final = 2.0
CYCLE_TRACK_WIDTH_BOTH: Final = 2.5
CYCLE_TRACK_GAP: Final = 0.5
CYCLE_TRACK_GAP_PARKING: Final = 0.75
# Strips for parking by orientation, m: RASt 06 and EAR 05, 2.00 lengthwise, 5.00 deep at right angles and 4.85 at 50
# gon (45 degrees), what hangs over the kerb among it.
PARKING_WIDTH: Final = MappingProxyType({"parallel": 2.0, "diagonal": 4.85, "perpendicular": 5.0})
# Shoulders, m: RAA 2008, 2.50 beside motorways; RAL 2012, 1.50 beside rural roads. Verges: as those.
SHOULDER_WIDTH: Final = MappingProxyType({"motorway": 2.5, "trunk": 2.5})
SHOULDER_WIDTH_OTHER: Final = 1.5
VERGE_WIDTH: Final = 1.5
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

# ---------------------------------------------------------------- furniture: lights

# Lower edge of a head beside and above the carriageway, its free space from the kerb, its height and width, m: RiLSA
# (Richtlinien für Lichtsignalanlagen), clearances of heads; three lenses of 200 mm for cars, two for people.
LIGHT_Z_BESIDE: Final = 2.10
LIGHT_Z_ABOVE: Final = 4.50
LIGHT_BESIDE: Final = 0.5
LIGHT_HEIGHT: Final = 0.9
LIGHT_HEIGHT_PEOPLE: Final = 0.6
LIGHT_WIDTH: Final = 0.3
# Movements that turn by less go straight on, rad (34 degrees); a choice.
LIGHT_THROUGH: Final = 0.6
# Arms are opposite if the turn from one to the other is at most this, rad (45 degrees); a choice.
LIGHT_OPPOSITE: Final = 0.785
# Paths through a junction whose middles come this near to each other meet, m: a car is 1.76 m wide without its
# mirrors (design vehicle of RASt 06). They are sampled at this distance, m.
LIGHT_PATHS_APART: Final = 2.0
LIGHT_PATH_STEP: Final = 1.0
# Lights apart from junctions whose nodes are so near to each other along the road are one installation, m; half of
# the extent of a crossing whose node alone is known, m; least distance of such lights from the road's ends, m.
# Choices.
LIGHT_GROUP_REACH: Final = 25.0
LIGHT_HALF_CROSSING: Final = 2.0
LIGHT_FROM_END: Final = 1.0
# Half of the distance of the stop lines of both directions at a node that is not said to be for one of them, m: so
# readers that cut roads between them can tell them apart; a choice. Least length of a lane section that is cut off,
# m.
LIGHT_HALF_GAP: Final = 1.0
# How far from the start of their lane section heads stand at least, m; a choice.
LIGHT_IN_SECTION: Final = 0.1
SECTION_BREAK_APART: Final = 0.5
# No lane section is cut within so many m of a bend of less than this radius, m: CARLA steps 2.5 m along the reference
# line, which on a lane 6 m outside of it is no more than 3.3 m.
SECTION_BREAK_STEP: Final = 2.5
SECTION_BREAK_RADIUS: Final = 20.0
# How far from a crossing a node with lights on a footway belongs to it, m; a choice.
LIGHT_CROSSING_REACH: Final = 8.0

# ---- furniture: what lies beside streets

# How far from a carriageway's edge a thing still belongs to the street, m: RPS 2009 wants guard rails where trees
# stand within 7.5 m of a rural road (12 m above 100 km/h); a footway behind a verge and a hedge lies as far. A
# choice.
ROADSIDE_REACH: Final = 15.0
# Distance of the points along streets and along footways at which they are compared, m: well below the length of a
# crossing's gap in a sidewalk.
BESIDE_SPACING: Final = 5.0
# A footway that is mapped apart runs along a street where its middle is at most this far from the carriageway's edge,
# or this far inside (carriageways are drawn by assumed widths), m, within so many degrees of its heading. Choices: of
# the ways tagged as sidewalks that are so near in five towns, nine tenths lie within 5.0 to 6.8 m. Those that no tag
# calls a sidewalk must be nearer, and nearer still beside drives and alleys.
FOOTWAY_BESIDE: Final = 8.0
FOOTWAY_BESIDE_UNTAGGED: Final = 6.0
FOOTWAY_BESIDE_SERVICE: Final = 4.0
FOOTWAY_INSIDE: Final = 1.5
FOOTWAY_ANGLE_DEG: Final = 20.0
# A stretch of street has it as its sidewalk if it runs along so much of it; gaps between two such stretches that are
# shorter than this are closed, m. Where OSM says that there is no sidewalk, it is believed from this distance on, m.
FOOTWAY_COVER: Final = 0.6
FOOTWAY_GAP_CLOSED: Final = 20.0
FOOTWAY_AGAINST_TAGS: Final = 3.0
# Streets are cut where a footway beside them begins or ends if it is there, and is not, for so long, and if a node is
# so near; sidewalks shorter than the last are left out, m. Choices.
FOOTWAY_RUN: Final = 30.0
FOOTWAY_CUT_NEAR: Final = 15.0
FOOTWAY_STRIP_MIN: Final = 10.0
# Distances of a footway that differ by less along a street are one, m; strips of verge narrower than the second are
# none. Choices.
FOOTWAY_STEADY: Final = 0.5
FOOTWAY_VERGE_MIN: Final = 0.3
# Widths of footways and cycleways that are believed, m.
FOOTWAY_WIDTH_MIN: Final = 0.8
FOOTWAY_WIDTH_MAX: Final = 6.0

# ---- furniture: bridges and tunnels

# Of bridges of which OSM says nothing: what most road bridges of the last 70 years are made of.
BRIDGE_MATERIAL: Final = "concrete"
# Tunnels are taken as lit from this length on, m, where OSM says nothing: RABT 2006 counts what is covered over 80 m
# as a tunnel, with lights.
TUNNEL_LIT_LENGTH: Final = 80.0
# How much daylight reaches the road in galleries, which are open at one side, 0 to 1; a choice.
GALLERY_DAYLIGHT: Final = 0.5

# ---- furniture: signs

# Signs stand so far beyond the edge of the carriageway, m: VwV-StVO, on §§ 39 to 43, wants 0.50 in towns, 0.30 at
# least, and 1.50 outside of them; MUTCD 2A.19 wants 2 ft from the kerb. Less where there is no room for it.
SIGN_CLEARANCE: Final = 0.75
SIGN_CLEARANCE_LEAST: Final = 0.3
# Lower edge of the lowest sign above the road, m: VwV-StVO 2.00, 2.20 above footways; MUTCD 2A.18 7 ft.
SIGN_LOWER_EDGE: Final = 2.2
# Width and height of signs, m: VwV-StVO, size 2 (for 20 to 80 km/h).
SIGN_SIZE: Final = MappingProxyType(
    {
        "octagon": (0.9, 0.9),
        "triangle": (0.9, 0.8),
        "round": (0.6, 0.6),
        "square": (0.6, 0.6),
        "town": (1.0, 0.65),
        "plate": (0.6, 0.33),
    }
)
# Signs for one direction that are nearer to each other than this share a pole, m; a choice.
SIGN_SAME_POLE: Final = 4.0
# Where a sign would stand on the lanes of another road it goes back by these steps, m, before it is put there.
SIGN_STEPS_BACK: Final = (3.0, 6.0, 10.0, 15.0)
# Roads whose heights differ by more than this are on other levels, m: half of the headroom below bridges.
SIGN_LEVELS: Final = 2.25
# Where a road begins at a junction its signs stand this far from it, m; a choice, about a car's length.
SIGN_BEYOND_JUNCTION: Final = 5.0
# A sign that says what another one said less than this before it for the same direction is left out, m: VwV-StVO has
# limits repeated at larger distances only.
SIGN_REPEATED: Final = 50.0
# How far beside its road a sign may be mapped, m: MUTCD 2A.19 has overhead ones 12 ft and more beside; a choice.
SIGN_ASIDE: Final = 15.0
# Of the roads near a sign, one counts as so much farther away, m, if the sign is not on the side of its traffic, and
# as so much, m per m, for the way to what a stop or give-way sign is for; a road of another level makes it unclear
# which is meant if it is farther by less than the last, m. Choices.
SIGN_WRONG_SIDE: Final = 5.0
SIGN_AHEAD_SHARE: Final = 0.2
SIGN_AMBIGUOUS: Final = 5.0
# Where neither tags nor limits tell it, a town lies on that side of its sign on which there are so many times as many
# nodes of streets as on the other, within so many metres. Choices.
TOWN_REACH: Final = 300.0
TOWN_RATIO: Final = 1.5
