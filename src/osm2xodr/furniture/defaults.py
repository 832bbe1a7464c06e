"""Default numbers of signs, lights and objects: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

# ---------------------------------------------------------------- furniture: where traffic stops

# Distance of stop lines from a junction's edge and before crossings, m: RMS (Richtlinien für die Markierung von
# Straßen) part 2 wants at least 1 m before crossings; MUTCD 3B.16 at least 4 ft.
STOP_LINE_SETBACK: Final = 1.0
STOP_LINE_BEFORE_CROSSING: Final = 1.0
# How far from a junction's edge a node with a signal, stop or give-way sign still shows where traffic stops, m.
STOP_NODE_REACH: Final = 20.0

# ---- furniture: crossings, islands, stop lines, arrows and what stands beside the road

# Extent of crossings along the road, m: R-FGÜ 2001 wants zebra crossings of 4 m as a rule, of 3 m at least, RiLSA 4 m
# with lights. Not below 6 ft (MUTCD 2009, 3B.18).
CROSSING_WIDTH: Final = 3.0
CROSSING_WIDTH_SIGNALS: Final = 4.0
CROSSING_WIDTH_MIN: Final = 1.83
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

# ---------------------------------------------------------------- furniture: lights

# Lower edge of a head beside and above the carriageway, its free space from the kerb, its height and width, m: RiLSA
# (Richtlinien für Lichtsignalanlagen), clearances of heads; three lenses of 200 mm for cars, two for people.
LIGHT_Z_BESIDE: Final = 2.10
LIGHT_Z_ABOVE: Final = 4.50
LIGHT_BESIDE: Final = 0.5
LIGHT_HEIGHT: Final = 0.9
LIGHT_HEIGHT_PEOPLE: Final = 0.6
LIGHT_WIDTH: Final = 0.3

# ---- furniture: bridges and tunnels

# Tunnels are taken as lit from this length on, m, where OSM says nothing: RABT 2006 counts what is covered over 80 m
# as a tunnel, with lights.
TUNNEL_LIT_LENGTH: Final = 80.0

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
