"""Default numbers of conventions: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

# Width of one lane by OSM's highway value, m: RAA 2008 (motorways 3.75), RAL 2012 (rural roads 3.50 and 3.25) and
# RASt 06 (6.50 m of carriageway for main streets with buses, 5.50 m for residential ones, 4.75 m where a car passes a
# lorry slowly); within 0.2 m of the 12, 11 and 9 feet of AASHTO's Green Book for the same uses.
LANE_WIDTH: Final = MappingProxyType(
    {
        "motorway": 3.75,
        **dict.fromkeys(("motorway_link", "trunk", "trunk_link", "primary", "primary_link"), 3.5),
        **dict.fromkeys(("secondary", "secondary_link", "busway"), 3.25),
        **dict.fromkeys(("tertiary", "tertiary_link"), 3.0),
        **dict.fromkeys(("unclassified", "residential", "road"), 2.75),
        **dict.fromkeys(("living_street", "service", "pedestrian"), 2.5),
        "track": 2.0,
        "raceway": 5.0,
    }
)
LANE_WIDTH_OTHER: Final = 2.75

# Usual limits where those of the country are not known, km/h: the medians over all countries of legal_speeds.json
# (urban 50, rural 90, motorways 120, living streets 20).
DEFAULT_SPEED_KMH: Final = MappingProxyType({"urban": 50, "rural": 90, "motorway": 120, "living_street": 20})

# Rank of a road by OSM's highway value where nothing is signed: traffic from a road of lower rank yields. Ramps yield
# to all roads; traffic from properties, tracks and streets with walking speed yields to all others (StVO, sections 8,
# 10 and 18; Vienna Convention on Road Traffic, article 18). Residential and unclassified roads have equal rank.
PRIORITY_RANK: Final = MappingProxyType(
    {
        "motorway": 9,
        "trunk": 8,
        "primary": 7,
        "secondary": 6,
        "tertiary": 5,
        **dict.fromkeys(("unclassified", "residential", "road", "busway"), 4),
        **dict.fromkeys(("living_street", "pedestrian"), 2),
        "service": 1,
        "track": 0,
    }
)
PRIORITY_RANK_LINK: Final = 3
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
