"""Reference lines: streets as lines and arcs."""

from __future__ import annotations

from osm2xodr.geometry.plan_view.cuts_outside_bends import bends_tightly, beyond_bends, out_of_bends, outermost_lanes
from osm2xodr.geometry.plan_view.ends import StreetEnds, outward_pose, street_ends
from osm2xodr.geometry.plan_view.parallel_carriageways import fit_side_by_side
from osm2xodr.geometry.plan_view.polyline_fit import fit_polylines
from osm2xodr.geometry.plan_view.streets import FittedStreets, fit_streets, outer_lanes

__all__ = [
    "FittedStreets",
    "StreetEnds",
    "bends_tightly",
    "beyond_bends",
    "fit_polylines",
    "fit_side_by_side",
    "fit_streets",
    "out_of_bends",
    "outer_lanes",
    "outermost_lanes",
    "outward_pose",
    "street_ends",
]
