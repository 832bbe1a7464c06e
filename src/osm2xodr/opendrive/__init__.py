"""Files of OpenDRIVE of any writer: as tables, and as places in the world."""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.opendrive.locating import (
        LOCATION_FIELDS as LOCATION_FIELDS,
        FieldValue as FieldValue,
        Locator as Locator,
        caveats as caveats,
    )
    from osm2xodr.opendrive.reader import (
        first_index as first_index,
        read_xodr as read_xodr,
        tables_of as tables_of,
    )
    from osm2xodr.opendrive.space import (
        Frame as Frame,
        Places as Places,
        Ribbons as Ribbons,
        RoadFinder as RoadFinder,
        Stations as Stations,
        curvature as curvature,
        elevation as elevation,
        frame_of as frame_of,
        grade as grade,
        lane_borders as lane_borders,
        lane_middles as lane_middles,
        lane_offset as lane_offset,
        lane_ribbons as lane_ribbons,
        points_beside as points_beside,
        pose as pose,
        record_lengths as record_lengths,
        refuse_crowds as refuse_crowds,
        sample_roads as sample_roads,
        section_at as section_at,
        speed_limits as speed_limits,
        superelevation as superelevation,
        surface_points as surface_points,
    )
    from osm2xodr.opendrive.tables import (
        ABSENT as ABSENT,
        End as End,
        Furniture as Furniture,
        HasTables as HasTables,
        Header as Header,
        LinkKind as LinkKind,
        OpenDrive as OpenDrive,
        Shape as Shape,
    )

__getattr__ = lazy_exports(
    __name__,
    {
        "locating": ("LOCATION_FIELDS", "FieldValue", "Locator", "caveats"),
        "reader": ("first_index", "read_xodr", "tables_of"),
        "space": (
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
            "points_beside",
            "pose",
            "record_lengths",
            "refuse_crowds",
            "sample_roads",
            "section_at",
            "speed_limits",
            "superelevation",
            "surface_points",
        ),
        "tables": ("ABSENT", "End", "Furniture", "HasTables", "Header", "LinkKind", "OpenDrive", "Shape"),
    },
)
