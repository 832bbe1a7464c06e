"""Numbers of reading OSM that have a source or serve several modules: meaning, unit, source.

SI units unless the name says otherwise.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

# Narrowest and widest lane that is made from a carriageway's width, m. RASt 06: two cars pass each other slowly on
# 4.10 m, and lanes that two cars use side by side begin at 5.50 m; any width beyond that is room for parking. Widths
# that ``width:lanes`` gives for a lane itself are believed within wider limits, the narrow ones not for cars.
LANE_WIDTH_MIN: Final = 2.0
LANE_WIDTH_MAX: Final = 5.5
# From so many lanes on, each is narrower: 14 feet are the widest outside lane that bicycles share (AASHTO, Guide for
# the Development of Bicycle Facilities, 2012). Of 20 such carriageways with kerbs all along in Berlin and Nuremberg
# 17 have 2.8 to 4.4 m for each lane, parked cars included, the others 5 to 6 m on the ring of a square.
LANES_SIDE_BY_SIDE: Final = 3
LANE_WIDTH_SIDE_BY_SIDE_MAX: Final = 4.25
# Widest lanes for cars that are built, m, of several, and alone one way; what is left between kerbs is for parking,
# or a shoulder. RAL 2012 and RASt 06 have 3.50 (the usual width of the country's class may be more); beside the
# parked cars of residential one-way streets in Berlin 4.0 to 4.4 m are left.
LANE_WIDEST: Final = 3.5
LANE_ALONE_WIDEST: Final = 4.25
TAGGED_LANE_WIDTH_MIN: Final = 0.5
TAGGED_LANE_WIDTH_MAX: Final = 10.0
# Where OSM gives more widths than lanes for cars, lanes narrower than this are for bicycles, m (RASt 06: lanes for
# cars and lorries from 2.75, bicycle lanes up to 2.50 with their marks and safety strips).
NARROW_LANE: Final = 2.5
# Widths of a carriageway that are believed, m: from a car's to ten wide lanes with their margins.
CARRIAGEWAY_WIDTHS: Final = (1.5, 60.0)
# How far to either side of a way kerbs are looked for, m: half of the widest carriageway, of ten lanes.
KERB_REACH: Final = 20.0
# Kerbs along a way tell where the edges of its carriageway are if the quartiles of their distance differ by no more
# than this, m. A choice.
KERBS_SCATTER: Final = 1.5
# Where three streets meet, kerbs round their corners this far along each of them, m: half of a main street of 11 m,
# and radii of corners of 6 to 8 m (RASt 06). A choice.
KERB_RETURN_LENGTH: Final = 12.0
# How far lanes lie aside of OSM's line where cars park along one side of them alone: 0 if all mappers drew it in the
# middle of the lanes, 1 if in that of the carriageway with the parked cars. Both is common, so half: of 372 such ways
# in Berlin lanes lie beside surveyed kerbs by 0.76 m (rms) with it, by 0.97 with 0 as with 1.
LANES_BESIDE_PARKING: Final = 0.5
# Where nobody parks along at most so much of a street with cars parked before or behind, its kerbs run straight on,
# m. A choice: the law keeps 15 m before and behind the sign of a bus stop free (StVO, section 12).
PARKING_PAUSE_MAX: Final = 40.0
# Bus and bicycle lanes, m: RASt 06, bus lanes 3.25 to 3.50, bicycle lanes 1.50 (advisory) to 1.85.
LANE_WIDTH_BUS: Final = 3.25
LANE_WIDTH_BICYCLE: Final = 1.5
# Lanes of one-way roads without ``lanes`` (OSM wiki, Key:lanes, assumptions); all other roads have one each way.
ONEWAY_LANES: Final = MappingProxyType({"motorway": 2, "trunk": 2})
# More lanes than any carriageway has (toll plazas reach 25); a larger ``lanes`` is a mistake.
LANES_PLAUSIBLE_MAX: Final = 25

# Widths of strips beside the carriageway that are believed, m: from the narrowest strip that people walk on to a
# promenade. A choice.
MARGIN_WIDTH_MIN: Final = 0.3
MARGIN_WIDTH_MAX: Final = 15.0
# Sidewalks without a tagged width, m: Inclusive Mobility (DfT 2021), 2.00 under normal circumstances; between the 1.5
# of AASHTO's guide for pedestrian facilities and the 2.50 of RASt 06 for new streets.
SIDEWALK_WIDTH: Final = 2.0
# Classes of streets that have sidewalks in towns where no tag says anything of any. In a surveyed old town, 88 % of
# the length of residential streets without tags had them, 99 % of tertiary and unclassified ones; of tagged primary
# and secondary ways in and around Heidelberg, three of four.
SIDEWALK_CLASSES: Final = frozenset({"primary", "secondary", "tertiary", "unclassified", "residential"})
# Bicycle tracks for one direction and for both, m (ERA 2010: 2.00 and 2.50), and the strip between the carriageway
# and them, with and without parked cars beside it, m (ERA 2010: 0.75 and 0.50).
CYCLE_TRACK_WIDTH: Final = 2.0
CYCLE_TRACK_WIDTH_BOTH: Final = 2.5
CYCLE_TRACK_GAP: Final = 0.5
CYCLE_TRACK_GAP_PARKING: Final = 0.75
# Strips for parking by orientation, m: RASt 06 and EAR 05, 2.00 lengthwise, 5.00 deep at right angles and 4.85 at 50
# gon (45 degrees), including the overhang over the kerb.
PARKING_WIDTH: Final = MappingProxyType({"parallel": 2.0, "diagonal": 4.85, "perpendicular": 5.0})
# Shoulders, m: RAA 2008, 2.50 beside motorways; RAL 2012, 1.50 beside rural roads. Verges: as those.
SHOULDER_WIDTH: Final = MappingProxyType({"motorway": 2.5, "trunk": 2.5})
SHOULDER_WIDTH_OTHER: Final = 1.5
VERGE_WIDTH: Final = 1.5

# How far from a carriageway's edge a thing still belongs to the street, m: RPS 2009 wants guard rails where trees
# stand within 7.5 m of a rural road (12 m above 100 km/h); a footway behind a verge and a hedge lies as far away. A
# choice.
ROADSIDE_REACH: Final = 15.0
# Spacing of the points along streets and footways at which they are compared, m: well below the length of the gap
# that a crossing leaves in a sidewalk.
BESIDE_SPACING: Final = 5.0
# A footway mapped apart runs along a street where its middle is at most this far from the edge of the carriageway, m.
# A choice: of the ways tagged as sidewalks this near in five towns, nine tenths lie within 5.0 to 6.8 m.
FOOTWAY_BESIDE: Final = 8.0

# Least density of residential streets around a street in a built-up area, m per hectare. Of 39 km of streets around
# Heidelberg whose tags say where they lie, 87 % are told right with it, more than with 5 or 15.
BUILT_UP_DENSITY: Final = 10.0
# Or of residential, unclassified, tertiary and secondary streets together: the grid of a town whose streets are not
# residential, as in downtowns. Of 5,600 streets with a limit in 47 extracts, 80 % of those up to 60 km/h are found
# instead of 73 %, and 29 % of the faster ones instead of 27 %; with 60 m per hectare, 84 and 36 %.
BUILT_UP_STREET_DENSITY: Final = 80.0
# Or people cross a street at places that are no farther apart in the mean, m. Of 8,066 streets with a limit in 130
# extracts, 1,512 are not found otherwise, half of them up to 50 km/h; of the 172 with crossings this near 141 are up
# to 50 km/h, and 10 from 70 km/h.
BUILT_UP_CROSSING_SPACING: Final = 400.0
# Streets with a higher limit have lanes as outside of towns, km/h: RASt 06 holds up to 50, signs in towns add 10; the
# Green Book's streets of low speed end at 45 mph. A choice between.
TOWN_SPEED_MAX_KMH: Final = 60.0
# Usual speed on service roads and tracks where a country has no limit of its own for them, km/h: what routers assume
# lies between 15 (OSRM, profile car) and 20 (SUMO, osmNetconvert.typ.xml). A limit by law says little there.
SERVICE_SPEED_KMH: Final = 20.0
# Highest limit that is guessed for ramps, km/h: RAA 2008, design speeds of ramps 30 to 80.
LINK_SPEED_KMH: Final = 80.0
# Classes of streets along which cars are taken to park in towns where no tag tells, and what they need at least, m:
# RASt 06, 1.80 to 2.00 along the kerb.
PARKED_ALONG: Final = frozenset(
    {"primary", "secondary", "tertiary", "unclassified", "residential", "living_street", "road"}
)
PARKING_WIDTH_LEAST: Final = 1.8
