"""The conversion: what the stages do, in order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from osm2xodr.curves import inside
from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.furniture import FurnitureOptions, place_furniture
from osm2xodr.geometry import (
    COMMON_ORIGIN,
    ElevationOptions,
    Ground,
    Neighbourhood,
    RoadOptions,
    build_roads,
    ground_around,
    keep_own_area,
)
from osm2xodr.model import FloatArray, Partition, RoadMap, StreetNetwork, Surface
from osm2xodr.osmParsing import ParseOptions, parse_osm
from osm2xodr.reporting import Conversion, summarize
from osm2xodr.surface import FlatSurface, SurfaceOptions, points_along, read_surface
from osm2xodr.system import Task

if TYPE_CHECKING:
    from osm2xodr.surface import DemSummary


@dataclass(frozen=True, slots=True)
class ConvertOptions:
    """What is converted, and how."""

    area: Path  # OSM file
    dems: tuple[Path, ...] = ()  # Elevation models; none for a flat world at height 0
    # How they are read
    parse: ParseOptions = field(default_factory=ParseOptions)
    surface: SurfaceOptions = field(default_factory=SurfaceOptions)
    # How roads are made of them
    elevation: ElevationOptions = field(default_factory=ElevationOptions)
    roads: RoadOptions = field(default_factory=RoadOptions)
    furniture: FurnitureOptions = field(default_factory=FurnitureOptions)  # What stands on and beside them
    jobs: int = 1  # How many processes work at once, at least 1. What comes out does not depend on it.
    # The areas side by side that this is one of; roads are cut at its border. None for an area by itself.
    partition: Partition | None = None


def convert(
    options: ConvertOptions, diagnostics: Diagnostics, on_stage: Callable[[str], None] = lambda stage: None
) -> Conversion:
    """Turn an OSM file and elevation models into an OpenDRIVE road network.

    Parameters
    ----------
    options
        What is converted, and how.
    diagnostics
        Receives what was guessed, dropped and repaired.
    on_stage
        Called with the name of each stage as it begins.

    Raises
    ------
    Osm2xodrError
        If it cannot be done, with a sentence that says why and what to do.
    """
    on_stage(f"reading {options.area}")
    parse = replace(options.parse, frame=options.partition.frame) if options.partition else options.parse
    network = parse_osm(options.area, parse, diagnostics)
    surface: Surface = FlatSurface()
    coverage: float | None = None
    elevation_models: tuple[DemSummary, ...] = ()
    ground: Task[Ground] | None = None
    if options.dems:
        on_stage("reading the elevation model")
        x, y = points_along(network.streets)
        measured = read_surface(options.dems, network.frame, x, y, options.surface, diagnostics)
        surface, coverage, elevation_models = measured, measured.coverage, measured.dems
        # Beside the plan view, which takes as long and needs no heights.
        origin = COMMON_ORIGIN if options.partition else None
        ground = Task(partial(ground_around, surface, x, y, options.elevation, origin), apart=options.jobs > 1)
    else:
        diagnostics.note("flat", "", "no elevation model was given: all ground is at height 0; give one with --dem")
    on_stage("building roads")
    try:
        found = ground.result if ground else None
        around = _neighbourhood(options, network)
        road_map = build_roads(network, surface, diagnostics, options.elevation, options.roads, found, around)
    finally:
        if ground is not None:
            ground.cancel()
    _tell_of_ways_inside(network, road_map, diagnostics)
    on_stage("placing signals and objects")
    road_map = place_furniture(network, road_map, options.furniture, diagnostics)
    if options.partition is not None:
        on_stage("cutting roads at the border")
        _forget_others(options.area, options.partition, diagnostics)
        road_map = keep_own_area(road_map, diagnostics)
    return Conversion(road_map, summarize(road_map, coverage), elevation_models)


def _forget_others(path: Path, partition: Partition, diagnostics: Diagnostics) -> None:
    """Take back what was found of elements of which no node lies in the own area: its neighbours tell of them."""
    from osm2xodr.osmParsing import element_places

    outline = partition.outlines[partition.own]
    places = element_places(path, partition.frame, diagnostics.osm_ids())
    diagnostics.forget({osm_id for osm_id, xy in places.items() if not inside(outline, xy[:, 0], xy[:, 1]).any()})


def _neighbourhood(options: ConvertOptions, network: StreetNetwork) -> Neighbourhood | None:
    """Return the areas side by side, with what makes the surface along their borders."""
    if options.partition is None:
        return None
    # Borders may run where elevation models end.
    choices = replace(options.surface, allow_partial=True)

    def surface_around(x: FloatArray, y: FloatArray) -> Surface:
        if not options.dems:
            return FlatSurface()
        return read_surface(options.dems, network.frame, x, y, choices, Diagnostics())

    return Neighbourhood(options.partition, surface_around)


def _tell_of_ways_inside(network: StreetNetwork, road_map: RoadMap, diagnostics: Diagnostics) -> None:
    """Report the ways that no road is made of, since all of them lies inside junctions."""
    carried = {way for road in road_map.roads for way in road.osm_way_ids}
    ways = {attributes.osm_way_id for street in network.streets for _, attributes in street.pieces} - carried
    dropped = {item.osm_id for item in diagnostics if item.kind is Kind.DROPPED} if ways else set()
    for way in sorted(ways):
        if f"way/{way}" not in dropped:
            diagnostics.note(
                "inside-junction", f"way/{way}", "it lies wholly inside a junction, whose connecting roads replace it"
            )
