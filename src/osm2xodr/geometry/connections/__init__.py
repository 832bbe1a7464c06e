"""Roads through junctions: which lanes they join, and how they run."""

from __future__ import annotations

from osm2xodr.geometry.connections.arm_setback import widened_trims
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads, InnerLane, build_connecting_roads
from osm2xodr.geometry.connections.connectivity_report import report_unheeded
from osm2xodr.geometry.connections.lane_links import find_lane_links
from osm2xodr.geometry.connections.pose_to_pose import connect, detours, turns_on_the_spot
from osm2xodr.geometry.connections.priorities import Priorities, find_priorities
from osm2xodr.geometry.connections.swing_out import with_wide_turns

__all__ = [
    "ConnectingRoads",
    "InnerLane",
    "Priorities",
    "build_connecting_roads",
    "connect",
    "detours",
    "find_lane_links",
    "find_priorities",
    "report_unheeded",
    "turns_on_the_spot",
    "widened_trims",
    "with_wide_turns",
]
