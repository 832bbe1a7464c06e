"""From the road coordinates of a network that was read to inertial ones, and back.

Everything is evaluated over arrays: `road` is an index into `OpenDrive.roads`, `s` and `t` are road coordinates, all
of one shape (n,). What is unknown because the file is damaged comes out as NaN.

Positions beyond a road's ends extrapolate its first or last record. `before` asks for the limit from the left where
records change, as at the end of a lane section after which the lane offset jumps.
"""

from __future__ import annotations

from osm2xodr.opendrive.space.finder import Places, RoadFinder, places_on, refuse_crowds
from osm2xodr.opendrive.space.georeference import Frame, frame_of
from osm2xodr.opendrive.space.positions import (
    curvature,
    elevation,
    grade,
    lane_borders,
    lane_middles,
    lane_offset,
    points_beside,
    pose,
    record_lengths,
    section_at,
    speed_limits,
    superelevation,
    surface_points,
)
from osm2xodr.opendrive.space.sampling import Ribbons, Stations, lane_ribbons, sample_roads

__all__ = [
    "Frame",
    "Places",
    "Ribbons",
    "RoadFinder",
    "Stations",
    "curvature",
    "elevation",
    "frame_of",
    "grade",
    "lane_borders",
    "lane_middles",
    "lane_offset",
    "lane_ribbons",
    "places_on",
    "points_beside",
    "pose",
    "record_lengths",
    "refuse_crowds",
    "sample_roads",
    "section_at",
    "speed_limits",
    "superelevation",
    "surface_points",
]
