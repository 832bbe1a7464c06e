"""Numbers of cropping and merging: meaning, unit, source. Lengths in m."""

from __future__ import annotations

from typing import Final

# Roads are cut between stretches of about this length, each of which is inside or outside as a whole: the cut lies
# within half of it from the border. A choice: what is left is never shorter, and readers take 1 m for a road.
CELL: Final = 2.0
# How far the ends of roads at a junction belong to it: what lies nearer stays with the junction, so that its arms
# have something to stand on. A choice, the length of a car.
STUB: Final = 5.0
# Ends of roads of different files meet if they, and the corners of their lanes, are nearer than this: ten times what
# coordinates in files are rounded to by most writers.
MEET_DISTANCE: Final = 0.01
# And if one road goes on within this angle, rad (half a degree): a kink that `check` does not count as one.
MEET_TURN: Final = 0.0087
