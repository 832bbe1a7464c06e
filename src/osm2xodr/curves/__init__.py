"""Curves of a network as flat arrays: lines, arcs and cubics, evaluated, cut and compared all at once.

`plan_views` lines and arcs · `cubics` piecewise cubics · `dubins` shortest curves between poses · `nearest` places
nearest to points · `crossings` curves that cross · `overlaps` pieces of roads over each other · `clearances` room
between them · `polygons` points in areas · `ragged` groups in flat arrays
"""

from __future__ import annotations

from osm2xodr.curves.clearances import CLEARANCE_STEP, ClosePlaces, RoadGraph, Stations, close_places
from osm2xodr.curves.crossings import curves_cross, segments_cross
from osm2xodr.curves.cubics import (
    cubic_slope,
    cubic_value,
    part_of_cubics,
    part_of_profile,
    profile_of,
    stack_profiles,
)
from osm2xodr.curves.dubins import dubins_curves, dubins_without_slivers
from osm2xodr.curves.nearest import SAMPLE_SPACING, CurveFinder, project, sample_curves
from osm2xodr.curves.overlaps import overlap_depths, overlapping_pairs
from osm2xodr.curves.plan_views import (
    advance,
    arc_step,
    chain_curves,
    curvature_at,
    curves_of,
    cut_curves,
    find_record,
    heading_change,
    lengths,
    places_along,
    pose,
    replace_curves,
    reverse_curves,
    smallest_radius,
    snap_cuts,
    stack_plan_views,
    wrapped,
)
from osm2xodr.curves.polygons import area_at, area_bounds, distance_to_outline, inside_outline, outline_bounds
from osm2xodr.curves.ragged import owners, ranks, runs, starts

__all__ = [
    "CLEARANCE_STEP",
    "SAMPLE_SPACING",
    "ClosePlaces",
    "CurveFinder",
    "RoadGraph",
    "Stations",
    "advance",
    "arc_step",
    "area_at",
    "area_bounds",
    "chain_curves",
    "close_places",
    "cubic_slope",
    "cubic_value",
    "curvature_at",
    "curves_cross",
    "curves_of",
    "cut_curves",
    "distance_to_outline",
    "dubins_curves",
    "dubins_without_slivers",
    "find_record",
    "heading_change",
    "inside_outline",
    "lengths",
    "outline_bounds",
    "overlap_depths",
    "overlapping_pairs",
    "owners",
    "part_of_cubics",
    "part_of_profile",
    "places_along",
    "pose",
    "profile_of",
    "project",
    "ranks",
    "replace_curves",
    "reverse_curves",
    "runs",
    "sample_curves",
    "segments_cross",
    "smallest_radius",
    "snap_cuts",
    "stack_plan_views",
    "stack_profiles",
    "starts",
    "wrapped",
]
