"""Heights of a road network: one sparse least-squares problem, arrays in, cubics out."""

from __future__ import annotations

from osm2xodr.geometry.heights.junction_surface import end_state
from osm2xodr.geometry.heights.options import parse_grade_limits
from osm2xodr.geometry.heights.problem import ConnectorProblem, Pins, ProfileProblem, ProfileSolution
from osm2xodr.geometry.heights.solve import (
    ElevationOptions,
    Ground,
    connector_profiles,
    ground_around,
    solve_profiles,
)

__all__ = [
    "ConnectorProblem",
    "ElevationOptions",
    "Ground",
    "Pins",
    "ProfileProblem",
    "ProfileSolution",
    "connector_profiles",
    "end_state",
    "ground_around",
    "parse_grade_limits",
    "solve_profiles",
]
