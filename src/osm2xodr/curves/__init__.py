"""Curves of a network as flat arrays: lines, arcs, spirals and cubics, evaluated, cut and compared all at once.

`plan_views` tables of curves · `records` places on them · `spirals` their shapes · `cubics` piecewise cubics ·
`dubins` shortest curves between poses · `point_tree` points near places · `nearest` curves near them · `crossings`
curves that cross · `overlaps` roads over each other · `clearances` room between them · `polygons` points in areas ·
`polylines` along them · `table` equally long columns · `ragged` groups in flat arrays, distinct integers. The same on
every machine: `trigonometry` · `exponentials` · `elimination` systems of equations · `transverse_mercator`
"""

from __future__ import annotations

from osm2xodr.curves.clearances import CLEARANCE_STEP, ClosePlaces, RoadGraph, Stations, close_places
from osm2xodr.curves.crossings import curves_cross, rays_to_segments, segments_cross
from osm2xodr.curves.cubics import (
    cubic_slope,
    cubic_value,
    part_of_cubics,
    part_of_profile,
    profile_of,
    smooth_cubic,
    smooth_step,
    stack_profiles,
    value_of_cubics,
)
from osm2xodr.curves.dubins import dubins_curves, dubins_without_slivers
from osm2xodr.curves.elimination import Factors, dot, elimination_order, solve_dense, solve_sparse
from osm2xodr.curves.exponentials import cube_root, exp, log, power
from osm2xodr.curves.nearest import SAMPLE_SPACING, CurveFinder, sample_curves
from osm2xodr.curves.overlaps import overlap_depths, overlapping_boxes, overlapping_pairs
from osm2xodr.curves.plan_views import (
    chain_curves,
    chosen_curves,
    curvature_at,
    curve_ends,
    curves_of,
    cut_curves,
    cut_records,
    end_curvature,
    heading_at,
    heading_change,
    lengths,
    lines_that_go_on,
    places_along,
    record_ends,
    record_turns,
    replace_curves,
    reverse_curves,
    sharpest_curvature,
    smallest_radius,
    snap_cuts,
    stack_plan_views,
    wrapped,
)
from osm2xodr.curves.point_tree import PointTree
from osm2xodr.curves.polygons import area_at, area_bounds, distance_to_outline, inside_outline, outline_bounds
from osm2xodr.curves.polylines import running_lengths
from osm2xodr.curves.ragged import (
    blocks,
    connected_groups,
    owners,
    ranks,
    repeated,
    runs,
    sorted_unique,
    starts,
    sum_before,
    unique_all,
    unique_counts,
    unique_first,
    unique_inverse,
    unique_rows,
)
from osm2xodr.curves.records import find_record, pose, project
from osm2xodr.curves.spirals import advance, arc_step, spirals_between
from osm2xodr.curves.table import RaggedTable, Table, join_tables
from osm2xodr.curves.transverse_mercator import from_mercator, to_mercator
from osm2xodr.curves.trigonometry import arccosine, arcsine, arctan2, cosine, hypot, sine, sine_cosine, slope_of

__all__ = [
    "CLEARANCE_STEP",
    "SAMPLE_SPACING",
    "ClosePlaces",
    "CurveFinder",
    "Factors",
    "PointTree",
    "RaggedTable",
    "RoadGraph",
    "Stations",
    "Table",
    "advance",
    "arc_step",
    "arccosine",
    "arcsine",
    "arctan2",
    "area_at",
    "area_bounds",
    "blocks",
    "chain_curves",
    "chosen_curves",
    "close_places",
    "connected_groups",
    "cosine",
    "cube_root",
    "cubic_slope",
    "cubic_value",
    "curvature_at",
    "curve_ends",
    "curves_cross",
    "curves_of",
    "cut_curves",
    "cut_records",
    "distance_to_outline",
    "dot",
    "dubins_curves",
    "dubins_without_slivers",
    "elimination_order",
    "end_curvature",
    "exp",
    "find_record",
    "from_mercator",
    "heading_at",
    "heading_change",
    "hypot",
    "inside_outline",
    "join_tables",
    "lengths",
    "lines_that_go_on",
    "log",
    "outline_bounds",
    "overlap_depths",
    "overlapping_boxes",
    "overlapping_pairs",
    "owners",
    "part_of_cubics",
    "part_of_profile",
    "places_along",
    "pose",
    "power",
    "profile_of",
    "project",
    "ranks",
    "rays_to_segments",
    "record_ends",
    "record_turns",
    "repeated",
    "replace_curves",
    "reverse_curves",
    "running_lengths",
    "runs",
    "sample_curves",
    "segments_cross",
    "sharpest_curvature",
    "sine",
    "sine_cosine",
    "slope_of",
    "smallest_radius",
    "smooth_cubic",
    "smooth_step",
    "snap_cuts",
    "solve_dense",
    "solve_sparse",
    "sorted_unique",
    "spirals_between",
    "stack_plan_views",
    "stack_profiles",
    "starts",
    "sum_before",
    "to_mercator",
    "unique_all",
    "unique_counts",
    "unique_first",
    "unique_inverse",
    "unique_rows",
    "value_of_cubics",
    "wrapped",
]
