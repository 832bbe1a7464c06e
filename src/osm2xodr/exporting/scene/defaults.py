"""Numbers of the ground: meaning, unit, source."""

from __future__ import annotations

from typing import Final

# Length of the smallest squares of ground, m: half a carriageway, so that slopes beside roads have a shape.
GROUND_CELL: Final = 5.0
# How far the ground reaches beyond the roads, m, and the largest gap in it that is closed, m². Choices.
REACH: Final = 100.0
LARGEST_GAP: Final = 1e6
# How far water reaches beyond the roads if it begins on that ground, m: a harbour and the sea before it.
WATER_REACH: Final = 500.0
# How far the ground reaches beside roads where no elevation model knows it, m, level across: a choice.
APRON: Final = 10.0
# Height of the opening of tunnels, and from their road to the ground above, m: RABT's clearance of 4.5 m, and
# 0.5 m each for signs and the ceiling.
TUNNEL_OPENING: Final = 5.0
TUNNEL_COVER: Final = 5.5
