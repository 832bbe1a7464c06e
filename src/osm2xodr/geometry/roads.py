"""Stage 3 as a whole: streets and a surface become the roads and junctions of an OpenDRIVE network."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from osm2xodr.conventions import find_country
from osm2xodr.curves import profile_of, stack_plan_views, stack_profiles, unique_first
from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.geometry.clearance_report import with_clearances
from osm2xodr.geometry.connections import ConnectingRoads, Marks, Priorities, connecting_marks, find_priorities
from osm2xodr.geometry.crossfall_lines import CrossfallLines, find_crossfall_lines, floor_on, on_crossfall_lines
from osm2xodr.geometry.heights import (
    Ground,
    ProfileProblem,
    ProfileSolution,
    connector_profiles,
    sloping_junctions,
    solve_profiles,
)
from osm2xodr.geometry.junction_floor import Faces, Floor, Hole, is_island, lay_floor, raised_islands
from osm2xodr.geometry.junctions import JunctionLayout, head_on_ends, street_places
from osm2xodr.geometry.lanes import Connectivity, LaneLayout, lay_out_all
from osm2xodr.geometry.options import ElevationOptions, RoadOptions
from osm2xodr.geometry.plan_report import report_blunt_sidewalks, report_missing_corners
from osm2xodr.geometry.road_heights import (
    build_connector_problem,
    build_profile_problem,
    levels_inside,
    report_lost_corrections,
    too_steep_corners,
)
from osm2xodr.geometry.road_plan import RoadPlan, RoadSides, lay_out_sides, plan_roads
from osm2xodr.geometry.road_records import (
    RoadIds,
    connecting_lane_offsets,
    connecting_road_records,
    junction_records,
    road_records,
    with_bicycles_among_cars,
    with_floor,
)
from osm2xodr.geometry.roadside import add_margins, ends_instead, with_lanes_of_sections
from osm2xodr.geometry.tile_edges import Neighbourhood, default_speed_km, find_borders, with_border_heights
from osm2xodr.model import BoolArray, Borders, FloatArray, Island, RoadMap, StreetNetwork, Surface
from osm2xodr.system import Task, advance, record, release_memory


@record(eq=False)
class _Lanes:
    """What heights do not change."""

    lanes: list[LaneLayout]  # Of each road, strips beside the carriageway included
    marks: Mapping[int, Marks]  # Of some of these
    priorities: Priorities


@record(eq=False)
class _Heights:
    """The heights of roads, and what they follow from."""

    problem: ProfileProblem
    solution: ProfileSolution
    lines: CrossfallLines  # Reference lines of connecting roads through junctions that crossfall may run through
    borders: Borders | None
    diagnostics: Diagnostics  # What was found meanwhile


def build_roads(
    network: StreetNetwork,
    surface: Surface,
    diagnostics: Diagnostics,
    elevation_options: ElevationOptions | None = None,
    road_options: RoadOptions | None = None,
    ground: Callable[[], Ground] | None = None,
    neighbourhood: Neighbourhood | None = None,
    on_lanes: Callable[[RoadMap], None] | None = None,
    jobs: int = 1,
) -> RoadMap:
    """Turn streets into roads, intersections into junctions, and give all of them heights.

    Parameters
    ----------
    network
        The streets.
    surface
        Height of the ground.
    diagnostics
        Where repairs and compromises are recorded.
    elevation_options
        What the user chose about heights.
    road_options
        What the user chose about roads.
    ground
        Called for what `ground_around` found, once the plan view is there.
    neighbourhood
        The areas side by side that this is one of. The road map then says which of them its roads belong to, and
        heights where roads are cut are common to both sides.
    on_lanes
        Called with the road map when roads have their lanes and heights, but junctions no floor yet.
    jobs
        How many processes work at once; the road map and the order of diagnostics do not depend on it.
    """
    plan = plan_roads(network, road_options or RoadOptions(), diagnostics, neighbourhood is not None, jobs)
    release_memory()
    advance(0.45)
    known = ground() if ground else None
    solve = partial(_find_heights, network, plan, surface, elevation_options, known, neighbourhood)
    # Heights need neither lanes nor sidewalks. In hills they take longest; on flat ground sidewalks take longer, and
    # the floor as long as lanes and records. Furniture takes as long as what is left of it and clearances.
    hills, flat = jobs > 1 and known is not None, jobs > 1 and known is None
    sides_of = partial(lay_out_sides, network, plan)
    with Task(solve, apart=hills) as heights, Task(sides_of, apart=flat) as beside:
        carriageways = _lay_out_carriageways(network, plan)
        if flat:
            heights.result()
        sides = beside.result()
        laid_out = Task(partial(_lay_out_lanes, network, plan, carriageways, sides), apart=False)
        if hills:
            laid_out.result()
        solved = heights.result()
    advance(0.75)
    diagnostics.extend(sides.diagnostics)
    diagnostics.extend(solved.diagnostics)
    steep = too_steep_corners(sides.corners, solved.solution)
    report_missing_corners(network, plan.layout, sides.corners.junction[steep], diagnostics)
    through = plan.connecting.joined(sides.corners.chosen(~steep))
    with Task(partial(_lay_out_floor, network, plan, through), apart=jobs > 1) as laid:
        lanes = laid_out.result()
        through = with_lanes_of_sections(through, plan.parts, sides.margins, lanes.lanes)
        lines = solved.lines.chosen(_keep_crossfall(solved)[through.junction[solved.lines.row]])
        carrying = on_crossfall_lines(through, lines)
        road_map = _road_map(network, plan, solved, carrying, lines, lanes, diagnostics, jobs)
        if on_lanes is not None:
            on_lanes(road_map)
        # The floor lies beside the carriageways whose clearances are looked at.
        road_map = with_clearances(network, road_map, solved.problem, diagnostics)
        release_memory()
        floor = laid.result()
    release_memory()
    lost = sides.corners.chosen(steep & sides.corners.beside_cars())
    ends = sides.ends.joined(ends_instead(plan.parts, sides.margins, plan.connecting, lost))
    report_blunt_sidewalks(network, plan.layout, sides.blunt, diagnostics)
    first = len(plan.parts.length)
    road_map = with_floor(road_map, first, floor_on(lines, through.length, floor), ends)
    road_map = with_bicycles_among_cars(road_map, first, through)
    islands, left_out = raised_islands(network.roadside, road_map, tuple(islands_of(plan, through, floor)))
    text = "with an island left out: it is tiny or far away, or lies on lanes"
    diagnostics.count(Kind.DROPPED, "roadside-left-out", left_out, "way", text)
    return replace(road_map, islands=islands)


def _lay_out_carriageways(network: StreetNetwork, plan: RoadPlan) -> list[LaneLayout]:
    """Lay out the lanes of carriageways."""
    known, country = Connectivity.of(network.connectivities), find_country(network.country)
    return lay_out_all(plan.parts.stretches, network.rule, known, country)


def _lay_out_lanes(
    network: StreetNetwork, plan: RoadPlan, carriageways: Sequence[LaneLayout], sides: RoadSides
) -> _Lanes:
    """Lay out the lanes of roads."""
    lanes = add_margins(carriageways, sides.margins, plan.parts.length.tolist())
    priorities = find_priorities(network, plan.ends, plan.layout, plan.parts, plan.connecting)
    style = find_country(network.country).marks
    marks = connecting_marks(plan.parts, plan.connecting, lanes, network.rule, priorities, style)
    return _Lanes(lanes, marks, priorities)


def _find_heights(
    network: StreetNetwork,
    plan: RoadPlan,
    surface: Surface,
    options: ElevationOptions | None,
    ground: Ground | None,
    neighbourhood: Neighbourhood | None,
) -> _Heights:
    """Ask for the heights of all roads, and solve them."""
    found = Diagnostics()
    problem, borders = _pose_heights(network, plan, neighbourhood, options, found)
    carried, warped, lines = find_crossfall_lines(problem, plan.connecting, sloping_junctions(problem, surface))
    problem = replace(problem, carried=carried, warped=warped)
    return _Heights(problem, solve_profiles(problem, surface, found, options, ground), lines, borders, found)


def _keep_crossfall(heights: _Heights) -> BoolArray:
    """Return the junctions whose arms have a superelevation where they end, (J,)."""
    problem, solution = heights.problem, heights.solution
    out = np.zeros(len(problem.junction_xy), bool)
    if solution.end_superelevation is not None:
        junction = problem.end_junction.ravel()
        out[junction[(junction >= 0) & (solution.end_superelevation.ravel() != 0.0)]] = True
    return out


def _pose_heights(
    network: StreetNetwork,
    plan: RoadPlan,
    neighbourhood: Neighbourhood | None,
    options: ElevationOptions | None,
    diagnostics: Diagnostics,
) -> tuple[ProfileProblem, Borders | None]:
    """Ask for the heights of all roads; those at borders are known, which come with them."""
    problem = build_profile_problem(network, plan.fitted, plan.layout, plan.parts)
    inside = levels_inside(plan.connecting, plan.parts)
    problem = replace(problem, connectors=replace(build_connector_problem(plan.connecting), inside=inside))
    report_lost_corrections(network, problem, diagnostics)
    if neighbourhood is None:
        return problem, None
    borders = find_borders(neighbourhood.partition, problem.plan_view, problem.end_junction, problem.junction_xy)
    return with_border_heights(problem, borders, neighbourhood.surface_around, options, diagnostics), borders


def _road_map(
    network: StreetNetwork,
    plan: RoadPlan,
    heights: _Heights,
    through: ConnectingRoads,
    lines: CrossfallLines,
    laid: _Lanes,
    diagnostics: Diagnostics,
    jobs: int,
) -> RoadMap:
    """Put everything together but the floor of junctions; `through` are all roads through these, some on `lines`."""
    parts, layout, lanes, priorities = plan.parts, plan.layout, laid.lanes, laid.priorities
    solution, borders = heights.solution, heights.borders
    ids = RoadIds(len(parts.length), len(through.length))
    if borders is not None:
        order = unique_first(through.junction)[1]
        borders = replace(borders, junction_area=borders.junction_area[through.junction[np.sort(order)]])
    profiles = partial(connector_profiles, heights.problem, build_connector_problem(through), solution)
    with Task(profiles, apart=jobs > 1) as found:
        guesses, head_on = diagnostics.guessed_about("way/"), head_on_ends(plan.ends, layout, parts)
        roads = road_records(parts, lanes, plan.connecting, ids, guesses, head_on)
        connecting = connecting_road_records(through, parts, lanes, ids, network.rule, lines, laid.marks)
        junctions = junction_records(network, layout, through, priorities, ids)
        places = street_places(network, layout, parts, ids.road, ids.driven_junctions(layout, plan.connecting))
        offset = connecting_lane_offsets(through, network.rule, lines)
        elevation, superelevation = found.result()
    level = profile_of([() for _ in lanes])
    return RoadMap(
        frame=network.frame,
        rule=network.rule,
        roads=(*roads, *connecting),
        junctions=junctions,
        plan_view=stack_plan_views(parts.plan_view, through.plan_view),
        elevation=stack_profiles(solution.elevation, elevation),
        superelevation=stack_profiles(solution.superelevation or level, superelevation),
        lane_offset=stack_profiles(profile_of([item.offset for item in lanes]), offset),
        statistics={
            "road_km": float(parts.length.sum()) / 1000,
            "connecting_road_km": float(through.length[: len(plan.connecting.length)].sum()) / 1000,
            "default_speed_km": default_speed_km(roads, parts.length),
            **solution.statistics,
            **priorities.statistics,
        },
        elevation_report=solution.report,
        country=network.country,
        places=places,
        borders=borders,
    )


def _lay_out_floor(network: StreetNetwork, plan: RoadPlan, through: ConnectingRoads) -> Floor:
    """Lay the floor of junctions; `through` are all roads through these, those of sidewalks behind those of cars."""
    enclosed = partial(_is_enclosed, _streets_at(network), plan.layout, through)
    round_islands = _round_islands(network, plan.layout)
    return lay_floor(through, network.rule, Faces.of(plan.parts, through, network.rule), round_islands, enclosed)


def islands_of(plan: RoadPlan, through: ConnectingRoads, floor: Floor) -> Iterator[Island]:
    """Return the islands that junctions have."""
    ids = RoadIds(len(plan.parts.length), len(through.length))
    for hole in floor.islands:
        junction = int(through.junction[hole.road])
        yield Island(ids.junction(junction), len(plan.parts.length) + hole.road, hole.corners)


def _round_islands(network: StreetNetwork, layout: JunctionLayout) -> frozenset[int]:
    """Return the junctions whose loops go round an island (OSM wiki, Tag:highway=turning_loop)."""
    loops = {node for node, tags in network.node_tags.items() if tags.get("highway") == "turning_loop"}
    if not loops:
        return frozenset()
    ids = [item.osm_node_id for item in network.intersections]
    return frozenset(k for k, nodes in enumerate(layout.nodes) if any(ids[node] in loops for node in nodes))


def _streets_at(network: StreetNetwork) -> dict[int, list[FloatArray]]:
    """Return the lines of the streets that begin or end at each intersection, (n, 2), m."""
    out: dict[int, list[FloatArray]] = {}
    for street in network.streets:
        for node in {street.start, street.end}:
            out.setdefault(node, []).append(street.points)
    return out


def _is_enclosed(
    streets: Mapping[int, Sequence[FloatArray]], layout: JunctionLayout, through: ConnectingRoads, hole: Hole
) -> bool:
    """Say whether the streets of its junction go round a hole, those at each intersection given."""
    lines = [line for node in layout.nodes[int(through.junction[hole.road])] for line in streets.get(node, ())]
    return is_island(
        hole, np.concatenate([line[:-1] for line in lines]), np.concatenate([line[1:] for line in lines])
    )
