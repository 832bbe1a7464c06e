"""Numbers of the ground: meaning, unit, source."""

from __future__ import annotations

from typing import Final

# Length of the smallest squares of ground, m: half a carriageway, so that slopes beside roads have a shape.
GROUND_CELL: Final = 5.0
# Most squares in the rectangle around a scene: 1,000 km², some 2 GB. A choice.
MOST_CELLS: Final = 40_000_000
# Levels of detail; each one's squares away from roads are twice as long as the finer one's. A choice.
DETAILS: Final = 3
# How far corners of squares keep from roads at least, m, so that no triangle is a sliver. A choice.
KEEP_OFF: Final = 1.5
# How far the ground reaches beyond the roads, m, and the largest gap in it that is closed, m². Choices.
REACH: Final = 100.0
LARGEST_GAP: Final = 1e6
# How far water reaches beyond the roads if it begins on that ground, m: a harbour and the sea before it.
WATER_REACH: Final = 500.0
# How far the ground reaches beside roads where no elevation model knows it, m, level across: a choice.
APRON: Final = 10.0
# Rise of cuts and fills per metre against the ground that was there: 1:2, for most soils stable; RAS-Q has 1:1.5.
SLOPE: Final = 0.5
# How far from an edge of a road the ground there counts although it is neither cut nor filled, as roads at other
# heights may be close, m. A choice.
CLASH_REACH: Final = 60.0
# Ground steeper than this, rise per metre, and higher than that, m, is a wall. Choices.
GROUND_WALL_SLOPE: Final = 2.0
GROUND_WALL_HEIGHT: Final = 0.5
# Height of the opening of tunnels, and from their road to the ground above, m: RABT's clearance of 4.5 m, and
# 0.5 m each for signs and the ceiling.
TUNNEL_OPENING: Final = 5.0
TUNNEL_COVER: Final = 5.5
# Tunnels whose road lies less than this below the ground, m, are passages or galleries: half of their opening, as
# elevation models may be off by some metres.
COVERED: Final = 2.5
# Roads that lie more than this above another one are on a bridge, m: less comes of chords and cross slopes.
# A choice.
STACKED: Final = 0.5
# Roads that begin at a portal and lie deeper than this all over are in the tunnel, m: cuttings are not. A choice.
DEEPEST_CUT: Final = 15.0
# From the road of a bridge down to the ground below at least, m: its deck of 1 m, and a little.
BRIDGE_DEPTH: Final = 1.2
# Largest distance between points that stand for edges and faces of roads, m. A fifth of a square.
SAMPLE: Final = 1.0
# Triangles with less area are none, m²: a millimetre times two. A choice.
LEAST_AREA: Final = 1e-6
# Water whose heights differ by more between the lowest and the highest tenth falls, as rivers do, m; and how close
# the places are whose heights are looked at, m. Choices: coarse models err by 1 to 2 m on water.
WATER_LEVEL_SPREAD: Final = 4.0
WATER_SAMPLE: Final = 20.0
# How far beside shores it is looked which area is there, m.
BESIDE_SHORE: Final = 0.05
# Shores that are not whole are closed if at most this share of the roads on the ground comes to lie in water: maps
# have bridges without tags, and quays drawn to the metre. A choice.
MOST_FLOODED: Final = 0.02
# Level water lies at least this far below roads at its shore, m, and what distance that is, m. Roads that are lower
# than lakes by more than the third, m, lead down to a tunnel or lie behind a dam. Choices: coarse models err so.
WATER_BELOW_ROADS: Final = 0.2
AT_SHORE: Final = 2.0
MOST_LOWERED: Final = 5.0
