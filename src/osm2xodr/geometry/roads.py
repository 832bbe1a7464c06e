"""The stage as a whole: streets and a surface become the roads and junctions of an OpenDRIVE network."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import groupby

import numpy as np

from osm2xodr import defaults
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.clusters import JunctionLayout, lay_out_junctions
from osm2xodr.geometry.connecting_roads import ConnectingRoads, build_connecting_roads
from osm2xodr.geometry.curves import joined_plan_views, joined_profiles, profile_of, smallest_radius
from osm2xodr.geometry.elevation import (
    ConnectorProblem,
    ElevationOptions,
    ProfileProblem,
    connector_profiles,
    solve_profiles,
)
from osm2xodr.geometry.lane_sections import LaneLayout, lay_out_lanes, smooth_step
from osm2xodr.geometry.movements import find_movements
from osm2xodr.geometry.narrowing import fit_side_by_side
from osm2xodr.geometry.road_parts import RoadParts, cut_roads, without_idle_junctions
from osm2xodr.geometry.straight_ends import beyond_bends
from osm2xodr.geometry.street_ends import street_ends
from osm2xodr.geometry.streets import FittedStreets, fit_streets, outer_lanes
from osm2xodr.geometry.turning_room import detours, widened_trims
from osm2xodr.model import (
    Connection,
    Cubic,
    Junction,
    Lane,
    LaneSection,
    LaneType,
    Road,
    RoadLink,
    RoadMap,
    RoadMark,
    RoadType,
    Rule,
    StreetAttributes,
    StreetNetwork,
    Surface,
)


def build_roads(
    network: StreetNetwork,
    surface: Surface,
    diagnostics: Diagnostics,
    elevation_options: ElevationOptions | None = None,
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
    """
    fitted = fit_side_by_side(network, fit_streets(network, diagnostics), diagnostics)
    ends = street_ends(network, fitted.plan_view, tuple((p[0][2], p[-1][2]) for p in fitted.pieces))
    layout = lay_out_junctions(network, ends)
    movements = find_movements(network, ends, layout, diagnostics)
    layout = without_idle_junctions(layout, movements)
    parts = cut_roads(network, fitted, layout)
    inner_lanes = partial(outer_lanes, fitted, network.rule)
    connecting = build_connecting_roads(parts, movements, ends, layout.trim, inner_lanes, network.rule)
    trim = beyond_bends(ends, layout.junction, widened_trims(ends, layout, parts, connecting))
    if (trim != layout.trim).any():
        layout = replace(layout, trim=trim)
        parts = cut_roads(network, fitted, layout)
        connecting = build_connecting_roads(parts, movements, ends, trim, inner_lanes, network.rule)
    connecting = _without_detours(network, layout, connecting, diagnostics)
    _report(network, layout, connecting, diagnostics)
    problem = _profile_problem(network, fitted, layout, parts)
    solution = solve_profiles(problem, surface, diagnostics, elevation_options)
    elevation, superelevation = connector_profiles(problem, _connector_problem(connecting), solution)
    numbers = _Numbers(len(parts.length), len(connecting.length))
    lanes = [lay_out_lanes(item, network.rule) for item in parts.stretches]
    offsets = [layout.offset for layout in lanes] + _connecting_offsets(connecting, network.rule)
    none = profile_of([() for _ in lanes])
    return RoadMap(
        frame=network.frame,
        rule=network.rule,
        roads=(
            *_roads(parts, lanes, connecting, numbers),
            *_connecting(connecting, parts, lanes, numbers, network.rule),
        ),
        junctions=_junctions(network, layout, connecting, numbers),
        plan_view=joined_plan_views(parts.plan_view, connecting.plan_view),
        elevation=joined_profiles(solution.elevation, elevation),
        superelevation=joined_profiles(none, superelevation),
        lane_offset=profile_of(offsets),
        statistics={
            "road_km": float(parts.length.sum()) / 1000,
            "connecting_road_km": float(connecting.length.sum()) / 1000,
            **solution.statistics,
        },
    )


class _Numbers:
    """Ids in OpenDRIVE: roads, then connecting roads, then junctions, from 1 in one range."""

    def __init__(self, roads: int, connecting: int) -> None:
        self._roads = roads
        self._connecting = connecting

    def road(self, index: int) -> int:
        return index + 1

    def connecting(self, index: int) -> int:
        return self._roads + index + 1

    def junction(self, index: int) -> int:
        return self._roads + self._connecting + index + 1


def _without_detours(
    network: StreetNetwork, layout: JunctionLayout, connecting: ConnectingRoads, diagnostics: Diagnostics
) -> ConnectingRoads:
    """Leave out connecting roads that no car would drive because the arms that they join lie on each other."""
    astray = detours(connecting.plan_view)
    for junction in np.unique(connecting.junction[astray]).tolist():
        node = network.intersections[layout.nodes[junction][0]].osm_node_id
        diagnostics.dropped(
            "no-room-to-turn", f"node/{node}", "the arms lie on each other, a turn between is left out"
        )
    return connecting.chosen(~astray) if astray.any() else connecting


def _report(
    network: StreetNetwork, layout: JunctionLayout, connecting: ConnectingRoads, diagnostics: Diagnostics
) -> None:
    for street in np.flatnonzero(layout.squeezed).tolist():
        way = network.streets[street].pieces[0][1].osm_way_id
        diagnostics.repaired(
            "street-too-short", f"way/{way}", "too short for the junctions at its ends, which were cut back"
        )
    sharp = smallest_radius(connecting.plan_view) < defaults.CONNECTING_RADIUS
    tight = np.unique(connecting.junction[sharp])
    for junction in tight.tolist():
        node = network.intersections[layout.nodes[junction][0]].osm_node_id
        diagnostics.repaired("tight-turn", f"node/{node}", "a turn through the junction is sharper than a car drives")


def _profile_problem(
    network: StreetNetwork, fitted: FittedStreets, layout: JunctionLayout, parts: RoadParts
) -> ProfileProblem:
    """Ask for the heights of all roads: their spans carry structure, class and grade tags."""
    spans: list[tuple[float, StreetAttributes]] = []
    count: list[int] = []
    for k, street in enumerate(parts.street.tolist()):
        begin, end = float(parts.begin[k]), float(parts.begin[k] + parts.length[k])
        own = [
            (max(s - begin, 0.0), attributes)
            for i, (s, attributes, _) in enumerate(fitted.pieces[street])
            if s < end and (i + 1 == len(fitted.pieces[street]) or fitted.pieces[street][i + 1][0] > begin)
        ]
        own = own or [(0.0, fitted.pieces[street][-1][1])]
        own[0] = (0.0, own[0][1])
        spans += own
        count.append(len(own))
    xy = np.array(
        [
            np.mean([(network.intersections[n].x, network.intersections[n].y) for n in nodes], axis=0)
            for nodes in layout.nodes
        ]
    ).reshape(-1, 2)
    names: dict[str, int] = {}
    return ProfileProblem(
        plan_view=parts.plan_view,
        end_junction=parts.end_junction,
        end_link=parts.end_link,
        junction_xy=xy,
        span_start=np.concatenate([[0], np.cumsum(count)]).astype(np.int64),
        span_s=np.array([s for s, _ in spans]),
        span_structure=np.array([a.structure.value for _, a in spans], np.int64),
        span_layer=np.array([a.layer for _, a in spans], np.int64),
        span_highway=tuple(a.highway for _, a in spans),
        span_grade=np.array([np.nan if a.grade is None else a.grade for _, a in spans]),
        span_way=np.array([a.osm_way_id for _, a in spans], np.int64),
        span_name=np.array(
            [names.setdefault(a.ref or a.name, len(names)) if a.ref or a.name else -1 for _, a in spans]
        ),
        span_oneway=np.array([_oneway(a) for _, a in spans], np.int64),
        span_width=np.array([sum(lane.width for lane in a.lanes_ltr) for _, a in spans]),
    )


def _oneway(attributes: StreetAttributes) -> int:
    """Return 1 where all traffic runs along the street, -1 where all runs against it, 0 else."""
    directions = {lane.direction.value for lane in attributes.lanes_ltr}
    return directions.pop() if len(directions) == 1 else 0


def _connector_problem(connecting: ConnectingRoads) -> ConnectorProblem:
    return ConnectorProblem(
        plan_view=connecting.plan_view,
        junction=connecting.junction,
        start_end=connecting.entry,
        end_end=connecting.exit,
        start_t=connecting.entry_t,
        end_t=connecting.exit_t,
        half_width=np.minimum(connecting.entry_width, connecting.exit_width) / 2,
    )


def _connecting_offsets(connecting: ConnectingRoads, rule: Rule) -> list[tuple[Cubic, ...]]:
    """Return the lane offsets that put a connecting road's one lane around its reference line."""
    side = 0.5 if rule is Rule.RIGHT_HAND else -0.5
    return [
        (_blend(length, side * w0, side * w1),)
        for length, w0, w1 in zip(
            connecting.length.tolist(), connecting.entry_width.tolist(), connecting.exit_width.tolist(), strict=True
        )
    ]


def _blend(length: float, start: float, end: float) -> Cubic:
    return Cubic(0.0, start) if start == end else smooth_step(0.0, length, start, end)


def _roads(
    parts: RoadParts, lanes: Sequence[LaneLayout], connecting: ConnectingRoads, numbers: _Numbers
) -> list[Road]:
    out: list[Road] = []
    connected = set(connecting.entry.tolist()) | set(connecting.exit.tolist())
    for k, layout in enumerate(lanes):
        stretches = parts.stretches[k]
        longest = max(stretches, key=lambda item: item.end - item.start)
        links = [
            _beyond(int(parts.end_junction[k, end]), int(parts.end_link[k, end]), 2 * k + end in connected, numbers)
            for end in (0, 1)
        ]
        ways = dict.fromkeys(item.attributes.osm_way_id for item in stretches)
        out.append(
            Road(
                id=numbers.road(k),
                name=longest.attributes.name or longest.attributes.ref,
                junction=None,
                predecessor=links[0],
                successor=links[1],
                types=layout.types,
                lane_sections=_linked(layout.sections, links[0], links[1]),
                osm_way_ids=tuple(ways),
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


def _linked(
    sections: tuple[LaneSection, ...], before: RoadLink | None, after: RoadLink | None
) -> tuple[LaneSection, ...]:
    """Link lanes to those of the same id where the road goes on as another (halves of a ring or loop)."""
    out = list(sections)
    if before is not None and not before.to_junction:
        out[0] = LaneSection(out[0].s, tuple(replace(lane, predecessor=lane.id or None) for lane in out[0].lanes))
    if after is not None and not after.to_junction:
        out[-1] = LaneSection(out[-1].s, tuple(replace(lane, successor=lane.id or None) for lane in out[-1].lanes))
    return tuple(out)


def _connecting(
    connecting: ConnectingRoads, parts: RoadParts, lanes: Sequence[LaneLayout], numbers: _Numbers, rule: Rule
) -> list[Road]:
    out: list[Road] = []
    none = RoadMark("none", width=0.0)
    own = -1 if rule is Rule.RIGHT_HAND else 1
    centre = Lane(0, LaneType.NONE, (), road_mark=none)
    columns = (
        connecting.junction,
        connecting.entry,
        connecting.exit,
        connecting.entry_lane,
        connecting.exit_lane,
        connecting.entry_width,
        connecting.exit_width,
        connecting.length,
    )
    for k, (junction, entry, exit_, lane_in, lane_out, w0, w1, length) in enumerate(
        zip(*(column.tolist() for column in columns), strict=True)
    ):
        lane = Lane(own, connecting.set_apart[k], (_blend(length, w0, w1),), lane_in, lane_out, none)
        stretch = parts.stretches[entry // 2][-1 if entry % 2 else 0]
        speed = stretch.attributes.speed_forward if entry % 2 else stretch.attributes.speed_backward
        types = lanes[entry // 2].types
        out.append(
            Road(
                id=numbers.connecting(k),
                name="",
                junction=numbers.junction(junction),
                predecessor=RoadLink(False, numbers.road(entry // 2), entry % 2 == 0),
                successor=RoadLink(False, numbers.road(exit_ // 2), exit_ % 2 == 0),
                types=(RoadType(0.0, types[-1 if entry % 2 else 0].type, speed),),
                lane_sections=(LaneSection(0.0, (centre, lane) if own < 0 else (lane, centre)),),
                osm_way_ids=(),
            )
        )
    return out


def _junctions(
    network: StreetNetwork, layout: JunctionLayout, connecting: ConnectingRoads, numbers: _Numbers
) -> tuple[Junction, ...]:
    own = -1 if network.rule is Rule.RIGHT_HAND else 1
    out: list[Junction] = []
    for junction, group in groupby(range(len(connecting.length)), key=lambda k: int(connecting.junction[k])):
        connections = tuple(
            Connection(
                id=number,
                incoming_road=numbers.road(int(connecting.entry[k]) // 2),
                connecting_road=numbers.connecting(k),
                lane_links=((int(connecting.entry_lane[k]), own),),
            )
            for number, k in enumerate(group)
        )
        nodes = tuple(network.intersections[node].osm_node_id for node in layout.nodes[junction])
        out.append(Junction(numbers.junction(junction), "", connections, nodes))
    return tuple(out)
