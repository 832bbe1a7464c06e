"""Design values of signs, lights and objects, and what several parts share: meaning, unit, source. SI units."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

# Distance of stop lines from a junction's edge and before crossings, m: RMS (Richtlinien für die Markierung von
# Straßen) part 2 wants at least 1 m before crossings; MUTCD 3B.16 at least 4 ft.
STOP_LINE_SETBACK: Final = 1.0
STOP_LINE_BEFORE_CROSSING: Final = 1.0
# How far from a junction's edge a node with a signal, stop or give-way sign still shows where traffic stops, m; a
# choice.
STOP_NODE_REACH: Final = 20.0

# Room that a car needs between a crossing and the line at which it stops, m: a design car of 4.74 m (RASt 06), and a
# gap behind and before it.
ROOM_FOR_CAR: Final = 8.0
# Lights within this distance along the road are one installation, m; a choice.
ONE_INSTALLATION: Final = 25.0
# A crossing with lights belongs to a junction if less is left between the two, m: they are mostly those of the
# junction, whose signs reach as far; a choice.
AT_JUNCTION_WITH_LIGHTS: Final = 20.0
# Extent of stop and give-way lines along the road, m: RMS-1, Zeichen 294 (0.50 m) and 341; MUTCD 2009, 3B.16: 12 to
# 24 in. Least distance of a line from a crossing where the road is too short for more, m; a choice.
STOP_LINE_EXTENT: Final = 0.5
STOP_LINE_SQUEEZED: Final = 0.2

# Extent of crossings along the road, m: R-FGÜ 2001 wants zebra crossings of 4 m as a rule, of 3 m at least, RiLSA 4 m
# with lights; not below 6 ft (MUTCD 2009, 3B.18).
CROSSING_WIDTH: Final = 3.0
CROSSING_WIDTH_SIGNALS: Final = 4.0
CROSSING_WIDTH_MIN: Final = 1.83
# Nobody parks within this distance before crossings, m (StVO, annex 2, sign 293; UVC 11-1003: 20 ft), nor where less
# than a space to park along the kerb is left, m (EAR 05).
NO_PARKING_BEFORE_CROSSING: Final = 5.0
ROOM_TO_PARK: Final = 5.7
# How far a crossing or bus stop in a junction may be moved to a road, m; a choice.
CROSSING_REACH: Final = 15.0
# How far a crossing on a short road may be moved so that a stop line fits before it, m; a choice.
CROSSING_REACH_FOR_LINE: Final = 3.5

# How far from the edge of the carriageway a thing beside a road still belongs to the road, m; a choice.
OBJECT_REACH: Final = 10.0
# Things on the carriageway by at most this are drawn inaccurately and go beside it, m; a choice.
OBJECT_INSIDE: Final = 1.0
# Least distance of things from the carriageway, m; a choice.
OBJECT_GAP: Final = 0.1

# Lower edge of a head beside and above the carriageway, its clearance from the kerb, its height and width, m: RiLSA
# (Richtlinien für Lichtsignalanlagen), clearances of heads; three lenses of 200 mm for cars, two for people.
LIGHT_Z_BESIDE: Final = 2.10
LIGHT_Z_ABOVE: Final = 4.50
LIGHT_BESIDE: Final = 0.5
LIGHT_HEIGHT: Final = 0.9
LIGHT_HEIGHT_PEOPLE: Final = 0.6
LIGHT_WIDTH: Final = 0.3

# Signal programmes, s. RiLSA 2015: cycles of 30 to 90, green of 5 at least, yellow of 3 up to 50 km/h. With red for
# all between two stages intergreen times are 4, those of small junctions. Green ends where no traffic comes, and is
# 50 at most, as in SUMO's guesses (``tls.max-dur``). Where only people make cars wait, these have red for as long as
# people need for 7 m at 1.2 m/s, and 5 more.
CYCLE_TIME: Final = 90.0
GREEN_TIMES: Final = (5.0, 50.0)
YELLOW_TIME: Final = 3.0
RED_TIME: Final = 1.0
PEOPLE_TIME: Final = 11.0
# How far before the stop line vehicles are detected, m: what a car drives in about 4 s in town, as loops for the
# extension of green lie 30 to 60 before it. With 100, SUMO's own, full streets keep green that others need. With
# SUMO's single loops cars lose 29 % more time (median of eleven places with lights), with 30 up to 6 % more (five).
DETECTOR_RANGE: Final = 50.0

# Distance of signs from the edge of the carriageway, m: VwV-StVO, on §§ 39 to 43, wants 0.50 in towns, 0.30 at least,
# and 1.50 outside of them; MUTCD 2A.19 wants 2 ft from the kerb. The least distance holds where there is little room.
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
