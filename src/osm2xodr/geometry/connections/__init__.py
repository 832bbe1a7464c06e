"""Roads through junctions: which lanes they join, how they run, and who goes first."""

from __future__ import annotations

from osm2xodr.geometry.connections.arm_setbacks import Turns, set_back_arms, set_back_stems
from osm2xodr.geometry.connections.connecting_roads import (
    BESIDE_CARS,
    ConnectingRoads,
    InnerLane,
    build_connecting_roads,
    change_in_parts,
    direct_roads,
    draw_in_parts,
    redraw_connecting_roads,
)
from osm2xodr.geometry.connections.lane_links import LaneLinks, find_lane_links
from osm2xodr.geometry.connections.marks import Marks, connecting_marks
from osm2xodr.geometry.connections.overrun_arms import beyond_streets, clear_arms
from osm2xodr.geometry.connections.pose_to_pose import (
    connect,
    curves_apart,
    detours,
    legs_through,
    tangents,
)
from osm2xodr.geometry.connections.priorities import Priorities, find_priorities
from osm2xodr.geometry.connections.sharp_turns import runs_backwards, swing_out, turns_without_need
from osm2xodr.geometry.connections.street_paths import Poses
from osm2xodr.geometry.connections.through_lanes import even_widths, keep_lanes_in_line
from osm2xodr.geometry.connections.turn_backs import draw_turns_back

__all__ = [
    "BESIDE_CARS",
    "ConnectingRoads",
    "InnerLane",
    "LaneLinks",
    "Marks",
    "Poses",
    "Priorities",
    "Turns",
    "beyond_streets",
    "build_connecting_roads",
    "change_in_parts",
    "clear_arms",
    "connect",
    "connecting_marks",
    "curves_apart",
    "detours",
    "direct_roads",
    "draw_in_parts",
    "draw_turns_back",
    "even_widths",
    "find_lane_links",
    "find_priorities",
    "keep_lanes_in_line",
    "legs_through",
    "redraw_connecting_roads",
    "runs_backwards",
    "set_back_arms",
    "set_back_stems",
    "swing_out",
    "tangents",
    "turns_without_need",
]
