"""Junctions: which nodes make one, where its arms end, who may go where, and which roads are left between them."""

from __future__ import annotations

from osm2xodr.geometry.junctions.clusters import JunctionLayout, lay_out_junctions
from osm2xodr.geometry.junctions.dead_ends import (
    add_turnarounds,
    cut_back_ends_on_streets,
    draw_loops,
    ends_on_streets,
)
from osm2xodr.geometry.junctions.movements import Movement, find_movements, with_movements_against_cars
from osm2xodr.geometry.junctions.reference_line_shift import shift_lines_out_of_bends
from osm2xodr.geometry.junctions.road_parts import (
    RoadParts,
    cut_roads,
    end_poses,
    head_on_ends,
    street_places,
    without_idle_junctions,
)
from osm2xodr.geometry.junctions.u_turns import choose_u_turns

__all__ = [
    "JunctionLayout",
    "Movement",
    "RoadParts",
    "add_turnarounds",
    "choose_u_turns",
    "cut_back_ends_on_streets",
    "cut_roads",
    "draw_loops",
    "end_poses",
    "ends_on_streets",
    "find_movements",
    "head_on_ends",
    "lay_out_junctions",
    "shift_lines_out_of_bends",
    "street_places",
    "with_movements_against_cars",
    "without_idle_junctions",
]
