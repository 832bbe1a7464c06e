"""What the stages hand to each other, in the order of the pipeline. Read this first.

Units are SI (m, rad, m/s, 1/m) unless a name says otherwise. Local x points east, y north; headings count
counter-clockwise from east; s runs along a road, t to its left. Everything is frozen, arrays are read-only.
Words of OpenStreetMap (node, way, street, intersection) belong to what is read, words of OpenDRIVE (road, lane
section, junction, s, t, hdg) to what is written.
"""

from __future__ import annotations

from osm2xodr.model.areas import BorderEnd, Borders, Outline, Partition
from osm2xodr.model.elevation_report import ElevationReport, LayerCrossing, RoadPlace, StructureRecord
from osm2xodr.model.furniture import (
    Controller,
    Furniture,
    ObjectRepeat,
    RoadObject,
    RoadStructure,
    Signal,
    SignalReference,
)
from osm2xodr.model.ground import Surface, SurfaceQuality
from osm2xodr.model.roads import (
    Connection,
    Cubic,
    CubicProfile,
    Junction,
    Lane,
    LaneSection,
    PlanView,
    Road,
    RoadLink,
    RoadMap,
    RoadMark,
    RoadType,
    StreetPlaces,
)
from osm2xodr.model.shared import (
    BoolArray,
    Direction,
    FloatArray,
    IntArray,
    LaneType,
    LocalFrame,
    Rule,
    Structure,
    freeze_arrays,
)
from osm2xodr.model.streets import (
    Footway,
    Intersection,
    LaneConnectivity,
    LaneSpec,
    MarginSpec,
    RoadsideKind,
    RoadsideThing,
    Street,
    StreetAttributes,
    StreetNetwork,
    StructureTags,
    TurningPlace,
    TurnRestriction,
)

__all__ = [
    "BoolArray",
    "BorderEnd",
    "Borders",
    "Connection",
    "Controller",
    "Cubic",
    "CubicProfile",
    "Direction",
    "ElevationReport",
    "FloatArray",
    "Footway",
    "Furniture",
    "IntArray",
    "Intersection",
    "Junction",
    "Lane",
    "LaneConnectivity",
    "LaneSection",
    "LaneSpec",
    "LaneType",
    "LayerCrossing",
    "LocalFrame",
    "MarginSpec",
    "ObjectRepeat",
    "Outline",
    "Partition",
    "PlanView",
    "Road",
    "RoadLink",
    "RoadMap",
    "RoadMark",
    "RoadObject",
    "RoadPlace",
    "RoadStructure",
    "RoadType",
    "RoadsideKind",
    "RoadsideThing",
    "Rule",
    "Signal",
    "SignalReference",
    "Street",
    "StreetAttributes",
    "StreetNetwork",
    "StreetPlaces",
    "Structure",
    "StructureRecord",
    "StructureTags",
    "Surface",
    "SurfaceQuality",
    "TurnRestriction",
    "TurningPlace",
    "freeze_arrays",
]
