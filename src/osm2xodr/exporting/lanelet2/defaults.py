"""Numbers of the export to Lanelet2: meaning, unit, source."""

from __future__ import annotations

from typing import Final

# Ways through junctions that turn by more than this turn left or right, rad (30 degrees): a choice, between the turns
# that OSM's wiki calls slight (35 degrees and more) and the bends of ways that lead straight on.
TURN_LEAST: Final = 0.5236
# Lanes that are nowhere wider than this are no lanelets, m: it is less than any road mark.
NARROWEST: Final = 0.01
# Lanelets that are longer, m, or turn by more, rad, or by some of both, are divided: CommonRoad's designer tells the
# sides of lanelets apart in a frame along them, which it cannot make around hairpins. Choices.
LONGEST: Final = 200.0
MOST_TURN: Final = 3.1416
# Points of a bound that are closer together than this are one, m: readers divide by their distance.
CLOSEST: Final = 0.01
# Ends of linked lanes that are farther apart than this are reported, m: the checker's lane gaps are small below it.
GAP_REPORTED: Final = 0.10
# Kerbs lower than this are ``low``, m: rolled ones have 0.05 (`osm2xodr.defaults.KERB_HEIGHT`), usual ones 0.12.
KERB_LOW: Final = 0.06
# Height of a light's or a sign's body where the file has none, m: a usual signal head with three lenses of 0.2 m
# (EN 12368) is 0.9 m high.
LIGHT_HEIGHT: Final = 0.9
SIGN_HEIGHT: Final = 0.6
# Width of the same, m.
BODY_WIDTH: Final = 0.3
