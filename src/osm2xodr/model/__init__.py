"""The data that the stages hand on to each other. Read this first.

Units are SI (m, rad, m/s, 1/m) unless a name says otherwise. Local x points east, y north; headings count
counter-clockwise from east; s runs along a road, t to its left. Everything is frozen, arrays are read-only.
Input is named in words of OpenStreetMap (node, way, street, intersection), output in words of OpenDRIVE (road, lane
section, junction, s, t, hdg).
"""

from __future__ import annotations

from osm2xodr.model.corrections import (
    EVERY_LANE as EVERY_LANE,
    Corrections as Corrections,
    NodeCorrection as NodeCorrection,
    WayCorrection as WayCorrection,
    applied as applied,
    unused as unused,
)
from osm2xodr.model.furniture import (
    Controller as Controller,
    Furniture as Furniture,
    ObjectRepeat as ObjectRepeat,
    RoadObject as RoadObject,
    RoadStructure as RoadStructure,
    Signal as Signal,
    SignalLink as SignalLink,
    SignalPhase as SignalPhase,
    SignalProgramme as SignalProgramme,
    SignalReference as SignalReference,
)
from osm2xodr.model.roads import (
    BorderEnd as BorderEnd,
    Borders as Borders,
    BoundaryEdge as BoundaryEdge,
    BoundaryJoint as BoundaryJoint,
    Connection as Connection,
    Cubic as Cubic,
    CubicProfile as CubicProfile,
    ElevationReport as ElevationReport,
    Island as Island,
    Junction as Junction,
    Lane as Lane,
    LaneSection as LaneSection,
    LayerCrossing as LayerCrossing,
    Outline as Outline,
    Partition as Partition,
    PlanView as PlanView,
    Road as Road,
    RoadLink as RoadLink,
    RoadMap as RoadMap,
    RoadMark as RoadMark,
    RoadName as RoadName,
    RoadPlace as RoadPlace,
    RoadType as RoadType,
    StreetPlaces as StreetPlaces,
    Stretches as Stretches,
    StructureRecord as StructureRecord,
)
from osm2xodr.model.shared import (
    CAR_LANES as CAR_LANES,
    VEHICLE_LANES as VEHICLE_LANES,
    Access as Access,
    BoolArray as BoolArray,
    Direction as Direction,
    FloatArray as FloatArray,
    IntArray as IntArray,
    LaneType as LaneType,
    LocalFrame as LocalFrame,
    Rule as Rule,
    Structure as Structure,
    Surface as Surface,
    SurfaceQuality as SurfaceQuality,
    freeze_arrays as freeze_arrays,
)
from osm2xodr.model.streets import (
    BusStop as BusStop,
    Facing as Facing,
    FacingSigns as FacingSigns,
    Footway as Footway,
    Intersection as Intersection,
    LaneConnectivity as LaneConnectivity,
    LaneSpec as LaneSpec,
    Light as Light,
    MappedCrossing as MappedCrossing,
    MarginSpec as MarginSpec,
    NodeControl as NodeControl,
    NodeFacts as NodeFacts,
    RailCrossing as RailCrossing,
    RoadsideKind as RoadsideKind,
    RoadsideThing as RoadsideThing,
    Sign as Sign,
    SignFace as SignFace,
    SignPost as SignPost,
    Street as Street,
    StreetAttributes as StreetAttributes,
    StreetNetwork as StreetNetwork,
    StructureTags as StructureTags,
    ThingFacts as ThingFacts,
    TurnRestriction as TurnRestriction,
)
from osm2xodr.model.surroundings import (
    Building as Building,
    OpenWater as OpenWater,
    Surroundings as Surroundings,
    Water as Water,
    WaterArea as WaterArea,
)
