"""The road map as furniture sees it: where nodes and ways of OSM lie on its roads."""

from __future__ import annotations

from osm2xodr.furniture.world.approaches import (
    RailStop as RailStop,
    before_crossings as before_crossings,
    car_lanes as car_lanes,
    crossings_on_course as crossings_on_course,
    find_approaches as find_approaches,
    find_rail_stops as find_rail_stops,
    junction_behind as junction_behind,
    lane_at_other_end as lane_at_other_end,
    with_room_for_line as with_room_for_line,
)
from osm2xodr.furniture.world.lane_table import (
    Arm as Arm,
    LaneAt as LaneAt,
    LaneTable as LaneTable,
    NodePlace as NodePlace,
    NodePlaces as NodePlaces,
    lane_ranges as lane_ranges,
)
from osm2xodr.furniture.world.roadside_places import (
    RoadsideFinder as RoadsideFinder,
    RoadsidePlaces as RoadsidePlaces,
    free_of_other_roads as free_of_other_roads,
)
from osm2xodr.furniture.world.world import (
    Approach as Approach,
    Crossing as Crossing,
    Movement as Movement,
    Stop as Stop,
    World as World,
    nearest_segment as nearest_segment,
    outline as outline,
    pieces_on_road as pieces_on_road,
    points_beside as points_beside,
    way_at as way_at,
)
