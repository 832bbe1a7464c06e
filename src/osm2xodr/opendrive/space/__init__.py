"""From the road coordinates of a network that was read to inertial ones, and back.

Everything is evaluated over arrays: `road` is an index into `OpenDrive.roads`, `s` and `t` are road coordinates, all
of one shape (n,). What is unknown because the file is damaged comes out as NaN.

Positions beyond a road's ends extrapolate its first or last record. `before` asks for the limit from the left where
records change, as at the end of a lane section after which the lane offset jumps.
"""

from __future__ import annotations

from osm2xodr.opendrive.space.finder import (
    Places as Places,
    RoadFinder as RoadFinder,
    places_on as places_on,
    refuse_crowds as refuse_crowds,
)
from osm2xodr.opendrive.space.georeference import Frame as Frame, frame_of as frame_of
from osm2xodr.opendrive.space.positions import (
    curvature as curvature,
    elevation as elevation,
    grade as grade,
    lane_borders as lane_borders,
    lane_middles as lane_middles,
    lane_offset as lane_offset,
    points_beside as points_beside,
    pose as pose,
    record_lengths as record_lengths,
    section_at as section_at,
    speed_limits as speed_limits,
    superelevation as superelevation,
    surface_points as surface_points,
)
from osm2xodr.opendrive.space.sampling import (
    Ribbons as Ribbons,
    Stations as Stations,
    lane_ribbons as lane_ribbons,
    sample_roads as sample_roads,
)
