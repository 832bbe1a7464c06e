"""Default numbers of conventions: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

# Width of one of several lanes by OSM's highway value, m: RAL 2012 (rural roads 3.50 and 3.25) and RASt 06 (6.50 m of
# carriageway for main streets with buses, 4.75 m where a car passes a lorry slowly); within 0.2 m of the 12, 11 and
# 10 feet of AASHTO's Green Book for the same uses. 14 km of motorways were surveyed with 3.6 to 3.7 between lines,
# where RAA 2008 has 3.75; residential and unclassified streets of two lanes with 3.2 and 3.7; ``width`` of 56
# residential ones says 3.0.
LANE_WIDTH: Final = MappingProxyType(
    {
        "motorway": 3.65,
        **dict.fromkeys(("motorway_link", "trunk", "trunk_link", "primary", "primary_link"), 3.5),
        **dict.fromkeys(("secondary", "secondary_link", "tertiary", "tertiary_link", "busway"), 3.25),
        **dict.fromkeys(("unclassified", "road"), 3.25),
        "residential": 3.0,
        **dict.fromkeys(("living_street", "service", "pedestrian"), 2.5),
        "track": 2.0,
        "raceway": 5.0,
    }
)
LANE_WIDTH_OTHER: Final = 3.0
# The same in built-up areas where lanes of one direction lie beside each other, m: RASt 06, 3.00 to 3.25; streets of
# two to four lanes one way were surveyed with 2.8 to 3.4.
LANE_WIDTH_BESIDE_IN_TOWN: Final = 3.0
# Width of a carriageway of one lane for one direction, m, parked cars not counted: it has room to pass a vehicle that
# stands. Beside the parked cars of 40 residential streets in Berlin kerbs leave 4.0 to 4.4. Ramps surveyed with 5.0;
# medians of ``width``: secondary 4.7 (33 ways), tertiary 5.0 (17), residential 4.0 (79), where surveys say 4.1;
# RASt 06 has 4.75 on main streets and 3.00 to 3.50 where only cars pass.
ONE_LANE_WIDTH: Final = MappingProxyType(
    {
        **dict.fromkeys(("motorway_link", "trunk_link"), 5.0),
        **dict.fromkeys(("primary", "secondary", "tertiary"), 4.75),
        **dict.fromkeys(("trunk", "primary_link", "secondary_link", "tertiary_link"), 4.5),
        **dict.fromkeys(("unclassified", "residential", "road"), 4.0),
        "living_street": 3.5,
        "service": 3.0,
    }
)

# Usual limits where those of the country are not known, km/h: the medians over all countries of legal_speeds.json
# (urban 50, rural 90, motorways 120, living streets 20).
DEFAULT_SPEED_KMH: Final = MappingProxyType({"urban": 50, "rural": 90, "motorway": 120, "living_street": 20})

# Rank of a road by OSM's highway value where nothing is signed: traffic from a road of lower rank yields. Ramps yield
# to all roads that run on; traffic from properties, tracks and streets with walking speed yields to all others
# (StVO, sections 8, 10 and 18; Vienna Convention on Road Traffic, article 18). Residential and unclassified roads
# have equal rank.
PRIORITY_RANK: Final = MappingProxyType(
    {
        "motorway": 10,
        "trunk": 9,
        "primary": 8,
        "secondary": 7,
        "tertiary": 6,
        **dict.fromkeys(("unclassified", "residential", "road", "busway"), 4),
        **dict.fromkeys(("living_street", "pedestrian"), 2),
        "service": 1,
        "track": 0,
    }
)
PRIORITY_RANK_LINK: Final = 3
# Rank of ramps at junctions through which no street of `PRIORITY_RANK_OTHER` runs: they lead from and to main roads;
# a choice.
PRIORITY_RANK_LINK_ABOVE: Final = 5
PRIORITY_RANK_OTHER: Final = 4

# Width of narrow marks and of wide ones (motorway edges), m: German RMS 1993.
MARK_WIDTH: Final = 0.12
MARK_WIDTH_WIDE: Final = 0.15
# Width of edge lines, in general and of roads built for speed, and of lines beside lanes for buses, taxis and
# bicycles, m: narrow and wide marks of RMS 1993. Widths by country are in conventions/countries.json.
EDGE_MARK_WIDTH: Final = 0.12
EDGE_MARK_WIDTH_FAST: Final = 0.15
SPECIAL_MARK_WIDTH: Final = 0.25
SPECIAL_MARK_WIDTH_FAST: Final = 0.30
