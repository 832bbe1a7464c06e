"""The conversion: what the stages do, in order.

Streets and what lies beside them are read (`osmParsing`), and the ground (`surface`). `build_roads` fits reference
lines, connects roads at junctions, lays out lanes and what is beside them, and lifts all to the ground (`geometry`).
Roads are furnished with signals and objects (`furniture`) and cut where areas meet; `Conversion.write` writes them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from osm2xodr.curves import inside_outline, lengths, owners, pose, repeated
from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.furniture import FurnitureOptions, Placed, find_furniture, with_furniture, with_islands
from osm2xodr.geometry import (
    COMMON_ORIGIN,
    ElevationOptions,
    Ground,
    Neighbourhood,
    RoadOptions,
    build_roads,
    cut_at_names,
    ground_around,
    keep_own_area,
    mark_unmeasured,
    with_boundaries,
)
from osm2xodr.model import FloatArray, IntArray, Outline, Partition, RoadMap, StreetNetwork, Surface
from osm2xodr.osmParsing import ParseOptions
from osm2xodr.projection import offline, to_geographic
from osm2xodr.reporting import Conversion, summarize
from osm2xodr.surface import FlatSurface, SurfaceOptions
from osm2xodr.system import Task, one_thread, record

if TYPE_CHECKING:
    from osm2xodr.surface import DemSummary


@record
class PipelineOptions:
    """What is converted, and what each stage is told."""

    area: Path  # OSM file
    dems: tuple[Path, ...] = ()  # Elevation models; none for a flat world at height 0
    # How they are read
    parse: ParseOptions = field(default_factory=ParseOptions)
    surface: SurfaceOptions = field(default_factory=SurfaceOptions)
    # How roads are made of them
    elevation: ElevationOptions = field(default_factory=ElevationOptions)
    roads: RoadOptions = field(default_factory=RoadOptions)
    furniture: FurnitureOptions = field(default_factory=FurnitureOptions)  # What stands on and beside them
    jobs: int = 1  # How many processes work at once, at least 1; the result is the same for any number
    copies_from: int = 0  # Fewer streets than these are converted by one process, whatever `jobs` says
    # The areas side by side that this is one of; roads are cut at its border. Where it has a block, `area` is the map
    # of that. None for an area by itself.
    partition: Partition | None = None
    boundaries: bool = False  # Whether junctions get a boundary


@record(eq=False)
class Layout:
    """The roads of an area or block with all that is on them, and its surroundings, if any."""

    road_map: RoadMap
    surface: Surface  # The ground
    models: tuple[DemSummary, ...]  # What the elevation models are
    diagnostics: Diagnostics  # What was found
    places: ElementPlaces | None = None  # Of what was found; None for an area by itself


class _Terrain(NamedTuple):
    """The ground, as the stages that follow need it."""

    surface: Surface
    ground: Task[Ground] | None = None  # The ground that heights are solved on, on its way; None where it is flat
    models: tuple[DemSummary, ...] = ()  # What the elevation models are


@one_thread()
@offline()
def convert(
    options: PipelineOptions,
    diagnostics: Diagnostics,
    on_stage: Callable[[str], None] = lambda stage: None,
    layouts: Layouts | None = None,
) -> Conversion:
    """Turn an OSM file and elevation models into an OpenDRIVE road network.

    `diagnostics` receives what was guessed, dropped and repaired, and the conversion holds it as well; `on_stage` is
    called with the name of each stage as it begins. `layouts` keeps the roads of a block for its other areas; the
    result is the same without. `Osm2xodrError` says why it cannot be done and what to do.
    """
    partition = options.partition
    lay_out = partial(_lay_out, options, on_stage)
    if partition is None or layouts is None or not partition.block:
        layout = lay_out()
    else:
        files = (options.area, *options.dems)
        layout = layouts.get(replace(options, partition=None), partition, files, lay_out)
    diagnostics.extend(layout.diagnostics)
    road_map = layout.road_map
    if partition is not None and layout.places is not None:
        on_stage("cutting roads at the border")
        # Their own areas report them.
        diagnostics.forget(layout.places.outside(partition.outlines[partition.own]))
        road_map = keep_own_area(road_map, diagnostics, partition.own)
    else:
        road_map = cut_at_names(road_map, diagnostics)
    if options.boundaries:
        road_map = with_boundaries(road_map, diagnostics)
    if options.parse.corrections.shared:
        diagnostics.forget_code("correction-unused")
    if options.dems:
        road_map = mark_unmeasured(road_map, layout.surface)
    statistics = summarize(road_map)
    _judge_coverage(options, road_map, statistics.dem_coverage, diagnostics)
    return Conversion(road_map, statistics, diagnostics, layout.models)


def _lay_out(options: PipelineOptions, on_stage: Callable[[str], None]) -> Layout:
    """Lay out the roads of an area, or of its block, with all that is on them."""
    # It loads the reader of OSM files.
    from osm2xodr.osmParsing import parse_osm

    partition, diagnostics = options.partition, Diagnostics()
    on_stage(f"reading {options.area}")
    parse = replace(options.parse, frame=partition.frame) if partition else options.parse
    network = parse_osm(options.area, parse, diagnostics)
    if len(network.streets) < options.copies_from:
        options = replace(options, jobs=1)
    if options.dems:
        on_stage("reading the elevation model")
    terrain = _read_terrain(options, network, diagnostics)
    on_stage("building roads")
    with _Furnishing(options, network, diagnostics) as furnishing:
        road_map = _build_roads(options, network, terrain, diagnostics, furnishing.begin)
        _report_ways_inside(network, road_map, diagnostics)
        on_stage("placing signals and objects")
        placed, found = furnishing.result()
    diagnostics.extend(found)
    road_map = with_furniture(road_map, placed)
    if placed is not None:
        road_map = with_islands(road_map, diagnostics)
    places = None if partition is None else _places(options.area, partition, diagnostics)
    return Layout(road_map, terrain.surface, terrain.models, diagnostics, places)


def _read_terrain(options: PipelineOptions, network: StreetNetwork, diagnostics: Diagnostics) -> _Terrain:
    """Read the elevation models, and begin to work out the ground that heights are solved on."""
    if not options.dems:
        diagnostics.note("flat", "", "no elevation model was given: all ground is at height 0; give one with --dem")
        return _Terrain(FlatSurface())
    # They load the reader of rasters.
    from osm2xodr.surface import points_along, read_surface, suspect_feet

    x, y = points_along(network.streets)
    surface = read_surface(options.dems, network.frame, x, y, options.surface, diagnostics)
    if network.node_heights:
        suspect_feet(options.dems, surface, *_known_heights(network), diagnostics)
    origin = COMMON_ORIGIN if options.partition else None
    # Beside the plan view, which takes as long and needs no heights.
    ground = Task(partial(ground_around, surface, x, y, options.elevation, origin), apart=options.jobs > 1)
    return _Terrain(surface, ground, surface.dems)


def _known_heights(network: StreetNetwork) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y and the height of the nodes of streets whose height OSM knows, (n,), m."""
    known = network.node_heights
    places = {
        node: (*street.points[row], known[node])
        for street in network.streets
        for row, node in enumerate(street.node_ids.tolist())
        if node in known
    }
    x, y, z = np.array(list(places.values())).reshape(-1, 3).T
    return x, y, z


class _Furnishing:
    """Places furniture while junctions get their floor; within the block."""

    def __init__(self, options: PipelineOptions, network: StreetNetwork, diagnostics: Diagnostics) -> None:
        self._options, self._network, self._diagnostics = options, network, diagnostics
        self._task: Task[tuple[Placed | None, Diagnostics]] | None = None

    def __enter__(self) -> _Furnishing:
        return self

    def __exit__(self, *_: object) -> None:
        if self._task is not None:
            self._task.cancel()

    def begin(self, road_map: RoadMap) -> None:
        """Begin to place it on the roads of a map."""
        options = self._options
        work = partial(_furnish, self._network, road_map, options.furniture, self._diagnostics.copy())
        self._task = Task(work, apart=options.jobs > 1 and options.furniture.enabled)

    def result(self) -> tuple[Placed | None, Diagnostics]:
        """Return what was placed, and what was found meanwhile."""
        return (None, Diagnostics()) if self._task is None else self._task.result()


def _furnish(
    network: StreetNetwork, road_map: RoadMap, options: FurnitureOptions, diagnostics: Diagnostics
) -> tuple[Placed | None, Diagnostics]:
    known = len(diagnostics)
    placed = find_furniture(network, road_map, options, diagnostics)
    return placed, diagnostics.later_than(known)


def _build_roads(
    options: PipelineOptions,
    network: StreetNetwork,
    terrain: _Terrain,
    diagnostics: Diagnostics,
    on_lanes: Callable[[RoadMap], None],
) -> RoadMap:
    """Lay out roads and junctions, and solve their heights."""
    ground = terrain.ground
    result = None if ground is None else ground.result
    around = _neighbourhood(options, network)
    try:
        return build_roads(
            *(network, terrain.surface, diagnostics, options.elevation, options.roads),
            ground=result,
            neighbourhood=around,
            on_lanes=on_lanes,
            jobs=options.jobs,
        )
    finally:
        if ground is not None:
            ground.cancel()


def _neighbourhood(options: PipelineOptions, network: StreetNetwork) -> Neighbourhood | None:
    """Return the areas side by side, with what makes the surface along their borders."""
    if options.partition is None:
        return None

    def surface_around(x: FloatArray, y: FloatArray) -> Surface:
        if not options.dems:
            return FlatSurface()
        from osm2xodr.surface import read_surface

        return read_surface(options.dems, network.frame, x, y, options.surface, Diagnostics())

    return Neighbourhood(options.partition, surface_around)


def _judge_coverage(
    options: PipelineOptions, road_map: RoadMap, coverage: float | None, diagnostics: Diagnostics
) -> None:
    """Report how much of the roads has no measured height, and where; fail if it is too much."""
    found = road_map.unmeasured
    if found is None or coverage is None or not len(found.begin):
        return
    from osm2xodr.surface import judge_coverage

    road = owners(found.start)
    ends = [pose(road_map.plan_view, road, s)[:2] for s in (found.begin, found.end)]
    places = to_geographic(road_map.frame, *(np.concatenate(column) for column in zip(*ends, strict=True)))
    length = found.total(lengths(road_map.plan_view))
    judge_coverage(options.dems, options.surface, coverage, length, places, diagnostics)


def _report_ways_inside(network: StreetNetwork, road_map: RoadMap, diagnostics: Diagnostics) -> None:
    """Report the ways that became no road because they lie wholly inside junctions."""
    carried = {way for road in road_map.roads for way in road.osm_way_ids}
    ways = {attributes.osm_way_id for street in network.streets for _, attributes in street.pieces} - carried
    dropped = {item.osm_id for item in diagnostics if item.kind is Kind.DROPPED} if ways else set()
    for way in sorted(ways):
        if f"way/{way}" not in dropped:
            message = "it lies wholly inside a junction, whose connecting roads replace it"
            diagnostics.note("inside-junction", f"way/{way}", message)


def _places(path: Path, partition: Partition, diagnostics: Diagnostics) -> ElementPlaces:
    """Return where the elements are that something was found about."""
    # It loads the reader of OSM files, which only starts where there is one to read.
    from osm2xodr.osmParsing import element_places

    return ElementPlaces.of(element_places(path, partition.frame, diagnostics.osm_ids()))


class Layouts:
    """Keeps the last block that was laid out, for the other areas of it."""

    def __init__(self) -> None:
        self._key: tuple[Any, ...] = ()
        self._layout: Layout | None = None

    @property
    def full(self) -> bool:
        """Whether a block is kept."""
        return self._layout is not None

    def clear(self) -> None:
        """Keep none."""
        self._key, self._layout = (), None

    def get(
        self, options: object, partition: Partition, files: Sequence[Path], lay_out: Callable[[], Layout]
    ) -> Layout:
        """Return the layout of the block of an area: the kept one, or a new one, which is then kept.

        It is the same block if its areas, the `options` of the conversion and `files` have not changed.
        """
        areas = [partition.outlines[k] for k in partition.together()]
        rings = tuple(ring.tobytes() for outline in areas for ring in outline.rings)
        key = (options, partition.frame, partition.names, partition.together(), rings, _times(files))
        if self._layout is None or key != self._key:
            # Two of them need not have room.
            self.clear()
            self._layout, self._key = lay_out(), key
        return self._layout


def _times(files: Sequence[Path]) -> tuple[tuple[Path, int, int], ...]:
    """Return size, bytes, and time of change, ns, of files."""
    found = ((path, path.stat()) for path in files if path.exists())
    return tuple((path, item.st_size, item.st_mtime_ns) for path, item in found)


@record(eq=False)
class ElementPlaces:
    """Where the elements are that something was found about."""

    osm_ids: tuple[str, ...]  # Elements of which the map has a node
    element: IntArray  # (places,) Index of the element that has a place
    xy: FloatArray  # (places, 2) Local x, y, m

    @classmethod
    def of(cls, places: dict[str, FloatArray]) -> ElementPlaces:
        """Return the places (n, 2) of elements."""
        element = repeated([len(xy) for xy in places.values()])
        return cls(tuple(places), element, np.concatenate([np.zeros((0, 2)), *places.values()]))

    def outside(self, outline: Outline) -> set[str]:
        """Return the elements without a place in an area."""
        inside = np.zeros(len(self.osm_ids), np.bool_)
        inside[self.element[inside_outline(outline, *self.xy.T)]] = True
        return {self.osm_ids[k] for k in np.flatnonzero(~inside).tolist()}
