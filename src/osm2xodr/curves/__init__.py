"""Curves of a network as flat arrays: lines, arcs and cubics, evaluated, cut and compared all at once."""

from __future__ import annotations

from osm2xodr.curves.crossings import crossing
from osm2xodr.curves.cubics import (
    cubic_slope,
    cubic_value,
    joined_profiles,
    part_of_cubics,
    part_of_profile,
    profile_of,
)
from osm2xodr.curves.dubins import shortest_curves, wide_curves
from osm2xodr.curves.nearest import SAMPLE_SPACING, CurveFinder, curvature_at, project, sampled
from osm2xodr.curves.plan_views import (
    arc_step,
    curves_of,
    cut_curves,
    find_record,
    joined_curves,
    joined_plan_views,
    lengths,
    places_along,
    pose,
    replaced,
    smallest_radius,
    snap_cuts,
    turned_round,
    wrapped,
)
from osm2xodr.curves.polygons import area_of, box, boxes, distance, inside
from osm2xodr.curves.ragged import ranks, runs

__all__ = [
    "SAMPLE_SPACING",
    "CurveFinder",
    "arc_step",
    "area_of",
    "box",
    "boxes",
    "crossing",
    "cubic_slope",
    "cubic_value",
    "curvature_at",
    "curves_of",
    "cut_curves",
    "distance",
    "find_record",
    "inside",
    "joined_curves",
    "joined_plan_views",
    "joined_profiles",
    "lengths",
    "part_of_cubics",
    "part_of_profile",
    "places_along",
    "pose",
    "profile_of",
    "project",
    "ranks",
    "replaced",
    "runs",
    "sampled",
    "shortest_curves",
    "smallest_radius",
    "snap_cuts",
    "turned_round",
    "wide_curves",
    "wrapped",
]
