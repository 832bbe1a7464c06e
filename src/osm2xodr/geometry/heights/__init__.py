"""Heights of a road network: one sparse least-squares problem, arrays in, cubics out."""

from __future__ import annotations

from osm2xodr.geometry.heights.connectors import connector_profiles, end_state
from osm2xodr.geometry.heights.crossings import curve_spans, levels_at
from osm2xodr.geometry.heights.ground import Ground
from osm2xodr.geometry.heights.problem import (
    ConnectorProblem,
    ElevationOptions,
    KnownHeights,
    Pins,
    ProfileProblem,
    ProfileSolution,
    parse_grade_limits,
)
from osm2xodr.geometry.heights.profiles import ground_around, solve_profiles
from osm2xodr.geometry.heights.report import tolerated_grade

__all__ = [
    "ConnectorProblem",
    "ElevationOptions",
    "Ground",
    "KnownHeights",
    "Pins",
    "ProfileProblem",
    "ProfileSolution",
    "connector_profiles",
    "curve_spans",
    "end_state",
    "ground_around",
    "levels_at",
    "parse_grade_limits",
    "solve_profiles",
    "tolerated_grade",
]
