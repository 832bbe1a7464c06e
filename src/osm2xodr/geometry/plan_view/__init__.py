"""Reference lines: streets as lines, arcs and spirals; docs/method/plan_view.md is their theory.

`streets` tells the story: `roundabouts` (with `arc_splines`), `polyline_fit`, wider bends. Then `street_smoothing`
(with `smooth_curves` and `fine_points`), `parallel_carriageways` and `ends`.
"""

from __future__ import annotations

from osm2xodr.geometry.plan_view.ends import (
    StreetEnds,
    has_tight_bend,
    outermost_lanes,
    outward_pose,
    places_clear_of_bends,
    street_ends,
    trims_clear_of_bends,
)
from osm2xodr.geometry.plan_view.parallel_carriageways import separate_parallel_streets
from osm2xodr.geometry.plan_view.polyline_fit import fit_polylines
from osm2xodr.geometry.plan_view.street_smoothing import smooth_streets
from osm2xodr.geometry.plan_view.streets import FittedStreets, fit_streets, outer_lanes

__all__ = [
    "FittedStreets",
    "StreetEnds",
    "fit_polylines",
    "fit_streets",
    "has_tight_bend",
    "outer_lanes",
    "outermost_lanes",
    "outward_pose",
    "places_clear_of_bends",
    "separate_parallel_streets",
    "smooth_streets",
    "street_ends",
    "trims_clear_of_bends",
]
