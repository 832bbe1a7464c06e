"""Lanes along roads: sections, widths, marks."""

from __future__ import annotations

from osm2xodr.geometry.lanes.carriageway_lanes import without_repeats
from osm2xodr.geometry.lanes.cross_sections import (
    CrossSection,
    EndLane,
    Piece,
    car_directions,
    centre_lanes,
    cross_section,
    end_lanes,
)
from osm2xodr.geometry.lanes.lane_changes import room_for_tapers
from osm2xodr.geometry.lanes.lane_connectivity import Connectivity, StatedLanes
from osm2xodr.geometry.lanes.lane_matching import left_turns, right_turns
from osm2xodr.geometry.lanes.lane_sections import LaneLayout, lay_out_all
from osm2xodr.geometry.lanes.road_marks import NO_MARK
from osm2xodr.geometry.lanes.road_stretches import (
    Stretch,
    change_between,
    shifted_stretch,
    stretches,
    with_narrow_ends,
    with_shifted_ends,
)
from osm2xodr.geometry.lanes.tapers import TaperZone, taper_zones

__all__ = [
    "NO_MARK",
    "Connectivity",
    "CrossSection",
    "EndLane",
    "LaneLayout",
    "Piece",
    "StatedLanes",
    "Stretch",
    "TaperZone",
    "car_directions",
    "centre_lanes",
    "change_between",
    "cross_section",
    "end_lanes",
    "lay_out_all",
    "left_turns",
    "right_turns",
    "room_for_tapers",
    "shifted_stretch",
    "stretches",
    "taper_zones",
    "with_narrow_ends",
    "with_shifted_ends",
    "without_repeats",
]
