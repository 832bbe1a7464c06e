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
# More lanes than any carriageway has (toll plazas reach 25); a larger ``lanes`` is a mistake.
LANES_PLAUSIBLE_MAX: Final = 25

# ``maxspeed=walk``, km/h: OSM wiki, Key:maxspeed, from German case law (4 to 7 km/h).
WALKING_SPEED_KMH: Final = 7.0
# Faster than any limit that is signed; a larger ``maxspeed`` is a mistake, km/h.
SPEED_PLAUSIBLE_MAX_KMH: Final = 250.0
# Limits that a country's law sets for a kind of road, km/h, and the countries, for values as ``maxspeed=DE:urban``:
# OSM wiki, pages Default speed limits and Speed limits; left out where the law differs within the country.
IMPLICIT_SPEED_KMH: Final = MappingProxyType(
    {
        "urban": {
            30.0: "BE-BRU",
            50.0: "AD AT AU BE BE-VLG BE-WAL BG CH CZ DE DK EE ES FI FR GR HR HU IE IT LI LT LU LV NL NO NZ PL PT RO "
            "RS SE SI SK TR UA",
            60.0: "BY KZ RU ZA",
        },
        "rural": {
            70.0: "BE-BRU BE-VLG SE",
            80.0: "CH DK FI FR LI NL NO RS",
            90.0: "BE-WAL BG BY CZ EE ES GR HR HU IT LT LU LV PL PT RO RU SI SK TR UA",
            100.0: "AT AU DE NZ ZA",
        },
        "trunk": {
            100.0: "AT CH NL PT RO RS",
            110.0: "CZ FR GR HR HU IT SI TR UA",
            120.0: "BE BE-BRU BE-VLG BE-WAL PL",
        },
        "motorway": {
            100.0: "NL",
            110.0: "BY RU SE",
            120.0: "BE BE-BRU BE-VLG BE-WAL CH ES FI IE PT ZA",
            130.0: "AT CZ DK FR GR HR HU IT LT LU RO RS SI SK UA",
            140.0: "BG PL",
            float("inf"): "DE",
        },
        "living_street": {
            WALKING_SPEED_KMH: "AT DE",
            10.0: "RS SI",
            15.0: "NL",
            20.0: "BE BE-BRU BE-VLG BE-WAL BG BY CH CZ ES FI FR HU KZ LT LU LV PL PT RO RU SK UA",
        },
    }
)
# The United Kingdom names its limits otherwise, mph.
IMPLICIT_SPEED_GB_MPH: Final = MappingProxyType(
    {"nsl_restricted": 30, "nsl_single": 60, "nsl_dual": 70, "urban": 30, "motorway": 70}
)

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
JUNCTION_TILT_MAX: Final = 0.20
# Mean grade of the shortest way between the lanes of two road ends at a junction: the cubic that joins them may be
# one and a half times as steep in its middle.
JUNCTION_STEP_MAX: Final = 0.15

# Variance of a road's vertical curvature times the length over which it is correlated, 1/m: (1.4e-3 1/m)² over 50 m,
# a vertical radius of 700 m. Height and grade errors against known terrain are flat from 2e-5 to 2e-4. Factors by
# class: motorways have crests of 13000 m and more (RAA 2008), streets of a few hundred.
ROAD_FLEXIBILITY: Final = 1e-4
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
# Least standard error of heights, m: keeps the solve well conditioned on exact surfaces.
HEIGHT_SIGMA_MIN: Final = 0.05
# Length over which an elevation model's errors are correlated: cells, but at least so many m.
NOISE_LENGTH_CELLS: Final = 1.7
NOISE_LENGTH_MIN: Final = 2.0
# How far a road lies beside its line in OSM, m (imagery offsets and hand), and what the cells add, in cells.
POSITION_ERROR: Final = 2.0
POSITION_ERROR_CELLS: Final = 0.1
# Roads are smoother than the ground they are built on: factor on the roughness penalty that the ground calls for.
# Against known terrain 2 to 8 do equally well.
ROAD_SMOOTHNESS: Final = 4.0

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
# Carriageways of one street that run opposite ways within this distance are level, with this standard error, m.
TWIN_DISTANCE: Final = 25.0
TWIN_SIGMA: Final = 0.5

# Height from road to road where layers cross, m: 4.50 m clear (RAL, RAA; 4.70 with room for resurfacing) and a deck
# of 0.70 m. What a crossing falls short by is told from the tolerance on.
CLEARANCE: Final = 5.2
CLEARANCE_TOLERANCE: Final = 0.1
# How far the ground's own heights give way to clearance: in standard errors of the elevation model, and from 0.5 m
# (its error beneath bridges) to 10 m. A precise model shows the road in its cutting; there the bridge has to rise.
CLEARANCE_PUSH_SIGMAS: Final = 5.0
CLEARANCE_PUSH_MIN: Final = 0.5
CLEARANCE_PUSH_MAX: Final = 10.0

# Connecting roads: distance of knots, m, and at which distance from its arms a junction's plane counts like an arm.
CONNECTOR_KNOT_SPACING: Final = 2.0
JUNCTION_PLANE_DISTANCE: Final = 6.0
# Grade of a connecting road above which it leaves the junction's surface if that makes it less steep.
CONNECTOR_STEEP: Final = 0.30

# One elevation record stands for several where it fits all knots this well: m, rise per metre; superelevation: rad.
PROFILE_TOLERANCE: Final = 0.005
PROFILE_SLOPE_TOLERANCE: Final = 1e-4
SUPERELEVATION_TOLERANCE: Final = 0.002
# Connecting roads need not show every change of the grade: 0.5 % over some metres.
CONNECTOR_SLOPE_TOLERANCE: Final = 5e-3

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

# Values of ``highway`` that are built for speed: long gores and tapers, wide marks.
FAST_HIGHWAYS: Final = ("motorway", "motorway_link", "trunk", "trunk_link")

# ---------------------------------------------------------------- junctions

# Radius of the kerb at a corner between two streets, by the lesser street's highway value: RASt 06 section 6.3.5
# recommends 5 to 8 m for minor roads; private access is tighter.
KERB_RADIUS: Final = MappingProxyType(
    {"residential": 4.0, "living_street": 3.0, "unclassified": 4.0, "service": 2.0, "track": 2.0}
)
KERB_RADIUS_OTHER: Final = 5.0
# A kerb's tangent is not let grow beyond this at acute corners, where nobody turns at speed.
KERB_TANGENT_MAX: Final = 8.0
# Free space between a junction's arms where their roads end.
ARM_CLEARANCE: Final = 0.5
# How far along its arms a junction may reach where a street turns on the spot, m; there they lie on each other.
ARM_REACH_TURN: Final = 12.0
# How far along its arms a junction may reach; more where ramps join at acute angles (RAA 2008: gores of 100 m).
ARM_REACH: Final = 40.0
ARM_REACH_MOTORWAY: Final = 100.0
# Streets that keep less than this between two junctions become part of one junction.
SHORTEST_STREET_BETWEEN_JUNCTIONS: Final = 3.0
# Roads are not cut shorter than this where their junctions cannot be one (or, at the very least, than a quarter).
SHORTEST_ROAD: Final = 1.0
# Streets shorter than this that a turn restriction runs over (via way) become part of a junction.
RESTRICTED_STREET: Final = 30.0
# Largest extent of the nodes of one junction.
JUNCTION_EXTENT: Final = 60.0


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
# A two-way carriageway narrower than this has no centre line, m (RMS 1993: 5.5 m).
CENTRE_LINE_FROM: Final = 5.5

# ---------------------------------------------------------------- surface

# How heights between the cells of an elevation model are found, and the total degree of the polynomial trend.
# Bilinear: along the roads of ten places with a known terrain and a noisy 30 m model its error is 1.70 m in height
# and 4.3 % in grade over 20 m; bicubic, which amplifies noise, has 1.84 m and 5.1 %, nearest, which steps, 1.84 m
# and 6.3 %. Degree 4 after the thesis that this converter descends from; as the trend only fills, little depends on
# it.
SURFACE_METHOD: Final = "bilinear"
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
# A street runs smoothly on through a junction where no corner on its way is sharper than this, rad (30 degrees);
# a connecting road that strays farther from it than STRAY, m, follows it instead.
SMOOTH_CORNER: Final = 0.52
STRAY: Final = 0.25
# A change of heading above this is a turn back, rad (165 degrees).
TURN_BACK: Final = 2.88
# Arms of a junction with a sharper turn are cut back by this much at a time, at most so many times, m.
TURNING_ROOM: Final = 1.5
TURNING_ROOM_STEPS: Final = 4
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
# A connecting road that is longer than this many times the distance it bridges, and this much more, m, is none: its
# arms lie on each other. They are cut back, and what stays so is left out.
DETOUR: Final = 4.0
DETOUR_MORE: Final = 60.0
