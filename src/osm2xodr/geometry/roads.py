"""The stage as a whole: streets and a surface become the roads and junctions of an OpenDRIVE network."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from osm2xodr.conventions import find_country
from osm2xodr.curves import profile_of, stack_plan_views, stack_profiles
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.borders import Neighbourhood, find_borders, with_border_heights
from osm2xodr.geometry.connections import ConnectingRoads, InnerLane, Priorities, find_priorities
from osm2xodr.geometry.heights import ElevationOptions, Ground, connector_profiles, solve_profiles
from osm2xodr.geometry.junctions import JunctionLayout, RoadOptions, RoadParts, street_places
from osm2xodr.geometry.lanes import NO_MARK, Connectivity, LaneLayout, lay_out_all, smooth_step
from osm2xodr.geometry.margins import add_margins, inner_width
from osm2xodr.geometry.road_heights import build_connector_problem, build_profile_problem, too_steep_corners
from osm2xodr.geometry.road_plan import plan_roads, report_corners
from osm2xodr.model import (
    Borders,
    Connection,
    Cubic,
    CubicProfile,
    IntArray,
    Junction,
    Lane,
    LaneSection,
    LaneType,
    Road,
    RoadLink,
    RoadMap,
    RoadType,
    Rule,
    StreetNetwork,
    Surface,
)
from osm2xodr.system import release_memory


def build_roads(
    network: StreetNetwork,
    surface: Surface,
    diagnostics: Diagnostics,
    elevation_options: ElevationOptions | None = None,
    road_options: RoadOptions | None = None,
    ground: Callable[[], Ground] | None = None,
    neighbourhood: Neighbourhood | None = None,
) -> RoadMap:
    """Turn streets into roads, intersections into junctions, and give all of them heights.

    Parameters
    ----------
    network
        What is to be driven on.
    surface
        Height of the ground.
    diagnostics
        Where repairs and compromises are told.
    elevation_options
        What the user chose about heights.
    road_options
        What the user chose about roads.
    ground
        Called for what `ground_around` found, once the plan view is there.
    neighbourhood
        The areas side by side that this is one of. The road map tells which of them its roads belong to, and heights
        where they are cut are common to both.
    """
    plan = plan_roads(network, road_options or RoadOptions(), diagnostics)
    parts, connecting, layout = plan.parts, plan.connecting, plan.layout
    release_memory()
    problem = build_profile_problem(network, plan.fitted, layout, parts, diagnostics)
    borders: Borders | None = None
    if neighbourhood is not None:
        partition = neighbourhood.partition
        borders = find_borders(partition, problem.plan_view, problem.end_junction, problem.junction_xy)
        problem = with_border_heights(problem, borders, neighbourhood.surface_around, elevation_options, diagnostics)
    solution = solve_profiles(problem, surface, diagnostics, elevation_options, ground() if ground else None)
    steep = too_steep_corners(plan.corners, solution)
    report_corners(network, layout, plan.corners.junction[steep], diagnostics)
    # Sidewalks' roads come after those of cars, which are what they would be without them.
    through = connecting.joined(plan.corners.chosen(~steep))
    elevation, superelevation = connector_profiles(problem, build_connector_problem(through), solution)
    priorities = find_priorities(network, plan.ends, layout, parts, connecting, diagnostics)
    numbers = _Numbers(len(parts.length), len(through.length))
    known = Connectivity.of(network.connectivities)
    lanes = lay_out_all(parts.stretches, network.rule, known, find_country(network.country))
    lanes = add_margins(lanes, plan.margins, parts.length.tolist())
    if borders is not None:
        borders = replace(borders, junction_area=borders.junction_area[_first_seen(through.junction)])
    offsets = profile_of([layout.offset for layout in lanes])
    none = profile_of([() for _ in lanes])
    return RoadMap(
        frame=network.frame,
        rule=network.rule,
        roads=(
            *_roads(parts, lanes, connecting, numbers, diagnostics.guessed_about("way/")),
            *_connecting(through, parts, lanes, numbers, network.rule),
        ),
        junctions=_junctions(network, layout, through, priorities, numbers),
        plan_view=stack_plan_views(parts.plan_view, through.plan_view),
        elevation=stack_profiles(solution.elevation, elevation),
        superelevation=stack_profiles(solution.superelevation or none, superelevation),
        lane_offset=stack_profiles(offsets, _connecting_offsets(through, network.rule)),
        statistics={
            "road_km": float(parts.length.sum()) / 1000,
            "connecting_road_km": float(connecting.length.sum()) / 1000,
            **solution.statistics,
            **priorities.statistics,
        },
        elevation_report=solution.report,
        country=network.country,
        places=street_places(network, layout, parts, numbers.road, _junction_ids(layout, connecting, numbers)),
        borders=borders,
    )


def _first_seen(number: IntArray) -> IntArray:
    """Return the numbers that occur, in the order in which they do first."""
    found, first = np.unique(number, return_index=True)
    out: IntArray = found[np.argsort(first)]
    return out


def _junction_ids(layout: JunctionLayout, connecting: ConnectingRoads, numbers: _Numbers) -> IntArray:
    """Return the ids of junctions, -1 for those that nobody drives through, and -1 at the end, (junctions + 1,)."""
    out = np.full(len(layout.nodes) + 1, -1, np.int64)
    used = np.unique(connecting.junction)
    out[used] = [numbers.junction(junction) for junction in used.tolist()]
    return out


class _Numbers:
    """Ids in OpenDRIVE: roads, then connecting roads, then junctions, from 1 in one range."""

    def __init__(self, roads: int, connecting: int) -> None:
        self._roads = roads
        self._connecting = connecting

    def road(self, index: int) -> int:
        return index + 1

    def index(self, road: int) -> int:
        """Return the index of a road that is none within a junction."""
        return road - 1

    def connecting(self, index: int) -> int:
        return self._roads + index + 1

    def junction(self, index: int) -> int:
        return self._roads + self._connecting + index + 1


def _connecting_offsets(connecting: ConnectingRoads, rule: Rule) -> CubicProfile:
    """Return the lane offsets that put a connecting road's lane around its reference line, or beside it."""
    n = len(connecting.length)
    side = -0.5 * np.sign(_own_lanes(connecting, rule))
    inner = inner_width(connecting)
    start = side * (connecting.entry_width + 2 * inner[0]) + connecting.entry_aside
    end = side * (connecting.exit_width + 2 * inner[1]) + connecting.exit_aside
    bent = np.flatnonzero(start != end)
    columns = (column[bent].tolist() for column in (connecting.length, start, end))
    steps = [smooth_step(0.0, *values) for values in zip(*columns, strict=True)]
    c, d = np.zeros(n), np.zeros(n)
    c[bent], d[bent] = [step.c for step in steps], [step.d for step in steps]
    return CubicProfile(np.arange(n + 1), np.zeros(n), start, np.zeros(n), c, d)


def _own_lanes(connecting: ConnectingRoads, rule: Rule) -> IntArray:
    """Return the id of each connecting road's lane, (n,); others lie between a sidewalk and the carriageway."""
    usual = -1 if rule is Rule.RIGHT_HAND else 1
    side: IntArray = np.where(connecting.against, -usual, usual)
    out: IntArray = side * np.array([len(lanes) + 1 for lanes in connecting.inner], np.int64)
    return out


def _blend(length: float, start: float, end: float) -> Cubic:
    return Cubic(0.0, start) if start == end else smooth_step(0.0, length, start, end)


def _roads(
    parts: RoadParts,
    lanes: Sequence[LaneLayout],
    connecting: ConnectingRoads,
    numbers: _Numbers,
    guessed: Mapping[int, frozenset[str]],
) -> list[Road]:
    out: list[Road] = []
    connected = set(connecting.entry.tolist()) | set(connecting.exit.tolist())
    beyond = zip(parts.end_junction.ravel().tolist(), parts.end_link.ravel().tolist(), strict=True)
    ends = [_beyond(*there, end in connected, numbers) for end, there in enumerate(beyond)]
    for k, layout in enumerate(lanes):
        stretches = parts.stretches[k]
        longest = max(stretches, key=lambda item: item.end - item.start) if len(stretches) > 1 else stretches[0]
        links = ends[2 * k : 2 * k + 2]
        ways = dict.fromkeys(way for item in stretches for way in item.ways)
        out.append(
            Road(
                id=numbers.road(k),
                name=longest.attributes.name or longest.attributes.ref,
                junction=None,
                predecessor=links[0],
                successor=links[1],
                types=layout.types,
                lane_sections=_linked(layout.sections, *(_section_beyond(link, lanes, numbers) for link in links)),
                osm_way_ids=tuple(ways),
                guesses=tuple(sorted(frozenset[str]().union(*(guessed.get(way, ()) for way in ways)))),
            )
        )
    return out


def _beyond(junction: int, linked_end: int, connected: bool, numbers: _Numbers) -> RoadLink | None:
    """Return what lies beyond a road's end; a junction only if one can drive into it or out of it there."""
    if junction >= 0 and connected:
        return RoadLink(True, numbers.junction(junction))
    if linked_end >= 0:
        return RoadLink(False, numbers.road(linked_end // 2), linked_end % 2 == 0)
    return None


def _section_beyond(link: RoadLink | None, lanes: Sequence[LaneLayout], numbers: _Numbers) -> LaneSection | None:
    """Return the lane section that a road goes on with as another road (halves of a ring or loop)."""
    if link is None or link.to_junction:
        return None
    return lanes[numbers.index(link.id)].sections[0 if link.at_start else -1]


def _linked(
    sections: tuple[LaneSection, ...], before: LaneSection | None, after: LaneSection | None
) -> tuple[LaneSection, ...]:
    """Link lanes to those of the same id and type beyond the road's ends."""
    out = list(sections)
    if before is not None:
        kinds = {lane.id: lane.type for lane in before.lanes if lane.id}
        lanes = (replace(a, predecessor=a.id if kinds.get(a.id) is a.type else None) for a in out[0].lanes)
        out[0] = LaneSection(out[0].s, tuple(lanes))
    if after is not None:
        kinds = {lane.id: lane.type for lane in after.lanes if lane.id}
        lanes = (replace(a, successor=a.id if kinds.get(a.id) is a.type else None) for a in out[-1].lanes)
        out[-1] = LaneSection(out[-1].s, tuple(lanes))
    return tuple(out)


def _connecting(
    connecting: ConnectingRoads, parts: RoadParts, lanes: Sequence[LaneLayout], numbers: _Numbers, rule: Rule
) -> list[Road]:
    out: list[Road] = []
    kinds: dict[_LaneKind, tuple[LaneSection, ...]] = {}
    types: dict[tuple[str, float | None], tuple[RoadType, ...]] = {}
    arms = np.unique(np.concatenate([connecting.entry, connecting.exit])).tolist()
    links = {end: RoadLink(False, numbers.road(end // 2), end % 2 == 0) for end in arms}
    type_at: dict[int, tuple[RoadType, ...]] = {}
    for end in np.unique(connecting.entry).tolist():
        attributes = parts.at_end(end).attributes
        speed = attributes.speed_forward if end % 2 else attributes.speed_backward
        road_type = lanes[end // 2].types[-1 if end % 2 else 0].type, speed
        type_at[end] = types.setdefault(road_type, (RoadType(0.0, *road_type),))
    columns = (
        connecting.junction,
        connecting.entry,
        connecting.exit,
        connecting.entry_lane,
        connecting.exit_lane,
        connecting.entry_width,
        connecting.exit_width,
        connecting.length,
        _own_lanes(connecting, rule),
        connecting.height,
    )
    for k, (junction, entry, exit_, lane_in, lane_out, w0, w1, length, own, height) in enumerate(
        zip(*(column.tolist() for column in columns), strict=True)
    ):
        walk = InnerLane(connecting.set_apart[k], w0, w1, height, lane_in, lane_out)
        across = (*reversed(connecting.inner[k]), walk)
        blends = any(item.entry_width != item.exit_width for item in across)
        kind = own, across, length if blends else 0.0
        sections = kinds.get(kind)
        if sections is None:
            sections = kinds[kind] = _lanes_through(*kind)
        out.append(
            Road(
                id=numbers.connecting(k),
                name="",
                junction=numbers.junction(junction),
                predecessor=links[entry],
                successor=links[exit_],
                types=type_at[entry],
                lane_sections=sections,
                osm_way_ids=(),
            )
        )
    return out


_CENTRE = Lane(0, LaneType.NONE, (), road_mark=NO_MARK)
_LaneKind = tuple[int, tuple[InnerLane, ...], float]


def _lanes_through(own: int, across: tuple[InnerLane, ...], length: float) -> tuple[LaneSection, ...]:
    """Return the lane section of a connecting road, with lanes from its reference line to the one that it is for."""
    side = 1 if own > 0 else -1
    lanes = [
        Lane(
            side * number,
            item.type,
            (_blend(length, item.entry_width, item.exit_width),),
            item.entry_lane,
            item.exit_lane,
            NO_MARK,
            height=item.height,
        )
        for number, item in enumerate(across, start=1)
    ]
    return (LaneSection(0.0, (_CENTRE, *lanes) if own < 0 else (*reversed(lanes), _CENTRE)),)


def _lane_links(entry_lane: int, own: int, inner: tuple[InnerLane, ...]) -> tuple[tuple[int, int], ...]:
    side = 1 if own > 0 else -1
    rest = [(item.entry_lane, own - side * k) for k, item in enumerate(inner, start=1) if item.entry_lane is not None]
    return ((entry_lane, own), *rest)


def _junctions(
    network: StreetNetwork,
    layout: JunctionLayout,
    connecting: ConnectingRoads,
    priorities: Priorities,
    numbers: _Numbers,
) -> tuple[Junction, ...]:
    own = _own_lanes(connecting, network.rule).tolist()
    of = connecting.junction.tolist()
    pairs: dict[int, list[tuple[int, int]]] = {}
    for high, low in zip(priorities.high.tolist(), priorities.low.tolist(), strict=True):
        pair = numbers.connecting(high), numbers.connecting(low)
        pairs.setdefault(of[high], []).append(pair)
    entry, entry_lane = connecting.entry.tolist(), connecting.entry_lane.tolist()
    groups: dict[int, list[int]] = {}
    for k, junction in enumerate(of):
        groups.setdefault(junction, []).append(k)
    out: list[Junction] = []
    for junction, group in groups.items():
        connections = tuple(
            Connection(
                id=number,
                incoming_road=numbers.road(entry[k] // 2),
                connecting_road=numbers.connecting(k),
                lane_links=_lane_links(entry_lane[k], own[k], connecting.inner[k]),
            )
            for number, k in enumerate(group)
        )
        nodes = tuple(network.intersections[node].osm_node_id for node in layout.nodes[junction])
        yielding = tuple(sorted(pairs.get(junction, ())))
        out.append(Junction(numbers.junction(junction), "", connections, nodes, yielding))
    return tuple(out)
