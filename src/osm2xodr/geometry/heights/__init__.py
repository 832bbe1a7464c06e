"""Heights of a road network: one sparse least-squares problem, arrays in, cubics out."""

from __future__ import annotations

from osm2xodr.geometry.heights.elements import end_poses
from osm2xodr.geometry.heights.ground import Ground
from osm2xodr.geometry.heights.inside_junctions import connector_profiles, end_state
from osm2xodr.geometry.heights.problem import (
    ConnectorProblem,
    KnownHeights,
    LevelsInside,
    Pins,
    ProfileProblem,
    ProfileSolution,
    chosen_roads,
    curve_spans,
    fast_spans,
    levels_at,
    one_way_fast_ends,
    wanted_clearances,
)
from osm2xodr.geometry.heights.profiles import ground_around, solve_profiles
from osm2xodr.geometry.heights.records import either_profile, hermite_cubics, only_curves, spread_curves
from osm2xodr.geometry.heights.report import tolerated_clearance, tolerated_grade
from osm2xodr.geometry.heights.superelevation import sloping_junctions

__all__ = [
    "ConnectorProblem",
    "Ground",
    "KnownHeights",
    "LevelsInside",
    "Pins",
    "ProfileProblem",
    "ProfileSolution",
    "chosen_roads",
    "connector_profiles",
    "curve_spans",
    "either_profile",
    "end_poses",
    "end_state",
    "fast_spans",
    "ground_around",
    "hermite_cubics",
    "levels_at",
    "one_way_fast_ends",
    "only_curves",
    "sloping_junctions",
    "solve_profiles",
    "spread_curves",
    "tolerated_clearance",
    "tolerated_grade",
    "wanted_clearances",
]
