"""The road map as furniture sees it: where nodes and ways of OSM lie on its roads."""

from __future__ import annotations

from osm2xodr.furniture.world.approaches import (
    RailStop,
    before_crossings,
    car_lanes,
    crossings_on_course,
    find_approaches,
    find_rail_stops,
    junction_behind,
    lane_at_other_end,
    with_room_for_line,
)
from osm2xodr.furniture.world.lane_table import Arm, LaneAt, LaneTable, NodePlace, NodePlaces, lane_ranges
from osm2xodr.furniture.world.roadside_places import PostClearance, RoadsideFinder, RoadsidePlaces, curves_near
from osm2xodr.furniture.world.world import (
    Approach,
    Crossing,
    Movement,
    Stop,
    World,
    nearest_segment,
    outline,
    pieces_on_road,
    points_beside,
    way_at,
)

__all__ = [
    "Approach",
    "Arm",
    "Crossing",
    "LaneAt",
    "LaneTable",
    "Movement",
    "NodePlace",
    "NodePlaces",
    "PostClearance",
    "RailStop",
    "RoadsideFinder",
    "RoadsidePlaces",
    "Stop",
    "World",
    "before_crossings",
    "car_lanes",
    "crossings_on_course",
    "curves_near",
    "find_approaches",
    "find_rail_stops",
    "junction_behind",
    "lane_at_other_end",
    "lane_ranges",
    "nearest_segment",
    "outline",
    "pieces_on_road",
    "points_beside",
    "way_at",
    "with_room_for_line",
]
