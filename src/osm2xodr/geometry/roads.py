"""Stage 3 as a whole: streets and a surface become the roads and junctions of an OpenDRIVE network."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from osm2xodr.conventions import find_country
from osm2xodr.curves import profile_of, stack_plan_views, stack_profiles
from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.geometry.borders import Neighbourhood, default_speed_km, find_borders, with_border_heights
from osm2xodr.geometry.clearance_report import with_clearances
from osm2xodr.geometry.connecting_marks import connecting_marks
from osm2xodr.geometry.connections import ConnectingRoads, Priorities, find_priorities
from osm2xodr.geometry.crossfall_lines import CrossfallLines, find_crossfall_lines, floor_on, on_crossfall_lines
from osm2xodr.geometry.heights import (
    ElevationOptions,
    Ground,
    ProfileProblem,
    ProfileSolution,
    connector_profiles,
    solve_profiles,
)
from osm2xodr.geometry.junctions import JunctionLayout, RoadOptions, street_places
from osm2xodr.geometry.lanes import Connectivity, LaneLayout, lay_out_all, sharp_joints
from osm2xodr.geometry.margins import add_margins, with_lanes_of_sections
from osm2xodr.geometry.pavement import Faces, Hole, is_island, lay_floor, raised_islands
from osm2xodr.geometry.plan_report import report_missing_corners
from osm2xodr.geometry.road_heights import (
    build_connector_problem,
    build_profile_problem,
    levels_inside,
    report_lost_corrections,
    too_steep_corners,
)
from osm2xodr.geometry.road_plan import RoadPlan, lay_out_sides, plan_roads
from osm2xodr.geometry.road_records import (
    RoadIds,
    connecting_lane_offsets,
    connecting_road_records,
    junction_records,
    road_records,
    with_floor,
)
from osm2xodr.model import BoolArray, Borders, FloatArray, Island, RoadMap, StreetNetwork, Surface
from osm2xodr.system import Task, advance, release_memory


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
    found = Diagnostics()
    # Sidewalks need no heights, nor do heights, lanes of carriageways and priorities need sidewalks.
    with Task(partial(lay_out_sides, network, plan), apart=jobs > 1) as beside:
        problem, borders = _pose_heights(network, plan, neighbourhood, elevation_options, found)
        carried, lines = find_crossfall_lines(problem, plan.connecting)
        problem = replace(problem, carried=carried)
        solution = solve_profiles(problem, surface, found, elevation_options, ground() if ground else None)
        advance(0.75)
        known = Connectivity.of(network.connectivities)
        country, joints = find_country(network.country), sharp_joints(plan.parts.plan_view)
        lanes = lay_out_all(plan.parts.stretches, network.rule, known, country, joints)
        priorities = find_priorities(network, plan.ends, plan.layout, plan.parts, plan.connecting, found)
        sides = beside.result()
    diagnostics.extend(sides.diagnostics)
    diagnostics.extend(found)
    through = _with_sidewalk_corners(network, plan, sides.corners, solution, diagnostics)
    lanes = add_margins(lanes, sides.margins, plan.parts.length.tolist())
    through = with_lanes_of_sections(through, plan.parts, sides.margins, lanes)
    if borders is not None:
        order = np.unique(through.junction, return_index=True)[1]
        borders = replace(borders, junction_area=borders.junction_area[through.junction[np.sort(order)]])
    lines = lines.chosen(_keep_crossfall(problem, solution)[through.junction[lines.row]])
    carrying = on_crossfall_lines(through, lines)
    road_map = _road_map(network, plan, problem, solution, carrying, lines, lanes, priorities, borders, diagnostics)
    if on_lanes is not None:
        on_lanes(road_map)
    # The floor lies beside the carriageways whose clearances are looked at.
    road_map = with_clearances(road_map, problem, diagnostics)
    faces = Faces.of(plan.parts, through, network.rule)
    enclosed = partial(_is_enclosed, _streets_at(network), plan.layout, through)
    floor = lay_floor(through, network.rule, faces, _round_islands(network, plan.layout), enclosed)
    road_map = with_floor(road_map, len(plan.parts.length), floor_on(lines, through.length, floor), sides.ends)
    islands, left_out = raised_islands(network.roadside, road_map, tuple(_islands(plan, through, floor.islands)))
    text = "with an island left out: it is tiny or far away, or lies on lanes"
    diagnostics.count(Kind.DROPPED, "roadside-left-out", left_out, "way", text)
    return replace(road_map, islands=islands)


def _keep_crossfall(problem: ProfileProblem, solution: ProfileSolution) -> BoolArray:
    """Return the junctions whose arms have a superelevation where they end, (J,)."""
    out = np.zeros(len(problem.junction_xy), bool)
    if solution.end_superelevation is not None:
        junction = problem.end_junction.ravel()
        out[junction[(junction >= 0) & (solution.end_superelevation.ravel() != 0.0)]] = True
    return out


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


def _islands(plan: RoadPlan, through: ConnectingRoads, islands: tuple[Hole, ...]) -> Iterator[Island]:
    """Return the islands that junctions have."""
    ids = RoadIds(len(plan.parts.length), len(through.length))
    for hole in islands:
        junction = int(through.junction[hole.road])
        yield Island(ids.junction(junction), len(plan.parts.length) + hole.road, hole.corners)


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


def _with_sidewalk_corners(
    network: StreetNetwork,
    plan: RoadPlan,
    corners: ConnectingRoads,
    solution: ProfileSolution,
    diagnostics: Diagnostics,
) -> ConnectingRoads:
    """Return the connecting roads of cars, and behind them those of sidewalks that are not too steep."""
    steep = too_steep_corners(corners, solution)
    report_missing_corners(network, plan.layout, corners.junction[steep], diagnostics)
    return plan.connecting.joined(corners.chosen(~steep))


def _road_map(
    network: StreetNetwork,
    plan: RoadPlan,
    problem: ProfileProblem,
    solution: ProfileSolution,
    through: ConnectingRoads,
    lines: CrossfallLines,
    lanes: list[LaneLayout],
    priorities: Priorities,
    borders: Borders | None,
    diagnostics: Diagnostics,
) -> RoadMap:
    """Put everything together but the floor of junctions; `through` are all roads through these, some on `lines`."""
    parts, layout = plan.parts, plan.layout
    ids = RoadIds(len(parts.length), len(through.length))
    elevation, superelevation = connector_profiles(problem, build_connector_problem(through), solution)
    level = profile_of([() for _ in lanes])
    marks = connecting_marks(parts, plan.connecting, lanes, network.rule)
    roads = road_records(parts, lanes, plan.connecting, ids, diagnostics.guessed_about("way/"))
    return RoadMap(
        frame=network.frame,
        rule=network.rule,
        roads=(
            *roads,
            *connecting_road_records(through, parts, lanes, ids, network.rule, lines, marks),
        ),
        junctions=junction_records(network, layout, through, priorities, ids),
        plan_view=stack_plan_views(parts.plan_view, through.plan_view),
        elevation=stack_profiles(solution.elevation, elevation),
        superelevation=stack_profiles(solution.superelevation or level, superelevation),
        lane_offset=stack_profiles(
            profile_of([item.offset for item in lanes]), connecting_lane_offsets(through, network.rule, lines)
        ),
        statistics={
            "road_km": float(parts.length.sum()) / 1000,
            "connecting_road_km": float(plan.connecting.length.sum()) / 1000,
            "default_speed_km": default_speed_km(roads, parts.length),
            **solution.statistics,
            **priorities.statistics,
        },
        elevation_report=solution.report,
        country=network.country,
        places=street_places(network, layout, parts, ids.road, ids.driven_junctions(layout, plan.connecting)),
        borders=borders,
    )
