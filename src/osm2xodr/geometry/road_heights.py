"""From roads as they are laid out to the problems of the elevation solve, and sidewalks that turn out too steep."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

import numpy as np

from osm2xodr.curves import (
    hypot,
    lengths,
    pose,
    starts,
)
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import defaults
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.heights import (
    ConnectorProblem,
    KnownHeights,
    LevelsInside,
    ProfileProblem,
    ProfileSolution,
    end_state,
)
from osm2xodr.geometry.junctions import JunctionLayout, RoadParts
from osm2xodr.geometry.plan_view import FittedStreets
from osm2xodr.geometry.roadside import inner_width
from osm2xodr.model import (
    BoolArray,
    FloatArray,
    IntArray,
    PlanView,
    Street,
    StreetAttributes,
    StreetNetwork,
    unused,
)

# Distance of the places along a road among which the nearest to a node is looked for, m.
_STEP: Final = 2.0
# Nodes farther than this from all roads of their streets lie in a junction, m: half of a wide carriageway, as lines
# of roads may be shifted. A choice.
_BESIDE_NODE: Final = 3.0
# Shorter sidewalks count as this long, m: keeps quotients finite.
_SHORTEST: Final = 1e-6


def build_profile_problem(
    network: StreetNetwork, fitted: FittedStreets, layout: JunctionLayout, parts: RoadParts
) -> ProfileProblem:
    """Ask for the heights of all roads: their spans carry structure, class and grade tags.

    Roads get the ids 1, 2, 3 … that they have in OpenDRIVE.
    """
    spans, middle, count = _spans(fitted, parts)
    places = [[(network.intersections[n].x, network.intersections[n].y) for n in nodes] for nodes in layout.nodes]
    xy = np.array([np.mean(group, axis=0) if len(group) > 1 else group[0] for group in places]).reshape(-1, 2)
    names: dict[str, int] = {}
    ele_road, ele_s, ele_z = _tagged_heights(network, parts.plan_view, parts.street)
    return ProfileProblem(
        plan_view=parts.plan_view,
        end_junction=parts.end_junction,
        end_link=parts.end_link,
        junction_xy=xy,
        span_start=starts(count),
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
        span_max_height=np.array([np.nan if a.max_height is None else a.max_height for _, a in spans]),
        span_speed=np.array([_speed(a) for _, a in spans]),
        span_middle=np.array(middle),
        ele_road=ele_road,
        ele_s=ele_s,
        ele_z=ele_z,
        rule=network.rule,
        span_clearance=_known_clearances([a for _, a in spans]),
        known=_known_heights(network, layout, parts, xy),
        road_id=np.arange(1, len(parts.length) + 1, dtype=np.int64),
    )


def report_lost_corrections(network: StreetNetwork, problem: ProfileProblem, diagnostics: Diagnostics) -> None:
    """Report corrections of heights and clearances of elements that no road is made of."""
    corrections = network.corrections
    nodes = set() if problem.known is None else set(problem.known.node.tolist())
    for node, at in sorted(corrections.nodes.items()):
        if at.z is not None and node not in nodes:
            unused(diagnostics, f"node/{node}", "z", "no road passes it")
    ways = set(problem.span_way.tolist()) if corrections.ways else set()
    for way, item in sorted(corrections.ways.items()):
        if item.clearance is not None and way not in ways:
            unused(diagnostics, f"way/{way}", "clearance", "no road is made of it")


def _known_clearances(spans: Sequence[StreetAttributes]) -> FloatArray | None:
    """Return the clearances that the user knows, by span, m, NaN for none; None if there are none at all."""
    if all(item.clearance is None for item in spans):
        return None
    return np.array([np.nan if item.clearance is None else item.clearance for item in spans])


def _spans(
    fitted: FittedStreets, parts: RoadParts
) -> tuple[list[tuple[float, StreetAttributes]], list[float], list[int]]:
    """Return start, m, and attributes of all spans, t of their middles, m, and how many spans each road has."""
    spans: list[tuple[float, StreetAttributes]] = []
    middle: list[float] = []
    count: list[int] = []
    for k, street in enumerate(parts.street.tolist()):
        begin, end = float(parts.begin[k]), float(parts.begin[k] + parts.length[k])
        pieces = fitted.pieces[street]
        here = [
            piece
            for i, piece in enumerate(pieces)
            if piece[0] < end and (i + 1 == len(pieces) or pieces[i + 1][0] > begin)
        ] or [pieces[-1]]
        spans += [(max(s - begin, 0.0) if i else 0.0, attributes) for i, (s, attributes, _) in enumerate(here)]
        middle += [(section.left_edge + section.right_edge) / 2 for _, _, section in here]
        count.append(len(here))
    return spans, middle, count


def _oneway(attributes: StreetAttributes) -> int:
    """Return 1 where all traffic runs along the street, -1 where all runs against it, 0 else."""
    directions = attributes.car_directions()
    return next(iter(directions)).value if len(directions) == 1 else 0


def _speed(attributes: StreetAttributes) -> float:
    """Return the higher one of both directions' speed limits, m/s, NaN where none is known."""
    limits = [attributes.speed_along(direction) for direction in attributes.car_directions()]
    return max((limit for limit in limits if limit is not None), default=np.nan)


def build_connector_problem(connecting: ConnectingRoads) -> ConnectorProblem:
    """Ask for the heights of all connecting roads; those beside cars follow what these drive on."""
    aside = np.maximum(np.abs(connecting.entry_aside), np.abs(connecting.exit_aside))
    # A sidewalk that goes its own way runs along its middle, with all that lies inside of it at one side.
    aside = np.where(aside > 0.0, aside, np.maximum(*inner_width(connecting)))
    return ConnectorProblem(
        plan_view=connecting.plan_view,
        junction=connecting.junction,
        start_end=connecting.entry,
        end_end=connecting.exit,
        start_t=connecting.entry_t,
        end_t=connecting.exit_t,
        half_width=np.minimum(connecting.entry_width, connecting.exit_width) / 2 + aside,
        beside=connecting.beside_cars(),
    )


def levels_inside(connecting: ConnectingRoads, parts: RoadParts) -> LevelsInside | None:
    """Return the levels along connecting roads between arms whose streets change theirs within the junction.

    None where none does. A connecting road has those of the ways on which its arms would go on to their nodes.
    """
    several = np.array([len({_level(item) for _, item, _ in pieces}) > 1 for pieces in parts.fitted.pieces], bool)
    street = parts.street[np.stack([connecting.entry, connecting.exit]) // 2]
    rows: list[tuple[int, float, int, int]] = []
    for k in np.flatnonzero(several[street].any(axis=0)).tolist():
        entry, exit_ = (_way_inside(parts, int(arms[k])) for arms in (connecting.entry, connecting.exit))
        if all(len({level for _, level in way}) == 1 for way in (entry, exit_)):
            continue
        # Both ways, from the arms to their nodes, in the length that there is.
        length = float(connecting.length[k])
        scale = length / max(entry[-1][0] + exit_[-1][0], _SHORTEST)
        begin = [0.0, *(u * scale for u, _ in entry[:-1])]
        rows += [(k, s, *level) for s, (_, level) in zip(begin, entry, strict=True)]
        rows += [(k, length - u * scale, *level) for u, level in exit_[::-1]]
    if not rows:
        return None
    connector, s, structure, layer = np.array(rows).T
    return LevelsInside(connector.astype(np.int64), s, structure.astype(np.int64), layer.astype(np.int64))


def _way_inside(parts: RoadParts, end: int) -> list[tuple[float, tuple[int, int]]]:
    """Return the levels of a street between a road end and the node there: how far from the end each goes, m."""
    road, street = end // 2, int(parts.street[end // 2])
    pieces = parts.fitted.pieces[street]
    to = [*(s for s, _, _ in pieces[1:]), float(lengths(parts.fitted.plan_view, np.array([street]))[0])]
    cut = float(parts.end[road] if end % 2 else parts.begin[road])
    if end % 2:
        way = [(s - cut, _level(item)) for s, (_, item, _) in zip(to, pieces, strict=True) if s > cut]
    else:
        way = [(cut - s, _level(item)) for s, item, _ in pieces[::-1] if s < cut]
    return way or [(0.0, _level(pieces[-1 if end % 2 else 0][1]))]


def _level(attributes: StreetAttributes) -> tuple[int, int]:
    return attributes.structure.value, attributes.layer


def too_steep_corners(corners: ConnectingRoads, solution: ProfileSolution) -> BoolArray:
    """Say which sidewalks around corners are steeper than a connecting road may be and than both roads, (corners,).

    Around a corner on a slope the difference of heights is left for the few metres between both sidewalks. The cubic
    that has both heights and grades is steepest half-way.
    """
    z0, g0 = end_state(solution, corners.entry, corners.entry_t, leaving=True)
    z1, g1 = end_state(solution, corners.exit, corners.exit_t, leaving=False)
    half_way = 1.5 * (z1 - z0) / np.maximum(corners.length, _SHORTEST) - 0.25 * (g0 + g1)
    arms = np.maximum(np.abs(g0), np.abs(g1))
    return np.asarray(np.abs(half_way) > np.maximum(defaults.CONNECTOR_STEEP, arms))


def _tagged_heights(
    network: StreetNetwork, plan_view: PlanView, street: IntArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the heights that ``ele`` of nodes gives: road, place along it, m, and height, m.

    `street` (R,) is the street that each road is a part of. Where roads end short of a node, as at junctions, their
    nearest place stands for it.
    """
    heights = network.node_heights
    nearest = _nearest_places(network, plan_view, street, heights)
    places = [(road, s, heights[node]) for node, (_, road, s) in sorted(nearest.items())]
    table = np.array(places, np.float64).reshape(-1, 3)
    return table[:, 0].astype(np.int64), table[:, 1], table[:, 2]


def _nearest_places(
    network: StreetNetwork, plan_view: PlanView, street: IntArray, nodes: Iterable[int]
) -> dict[int, tuple[float, int, float]]:
    """Return how far from each node the nearest road of its streets is, m, the road, and the place along it, m."""
    roads_of = defaultdict(list)
    for road, owner in enumerate(street.tolist()):
        roads_of[owner].append(road)
    length = lengths(plan_view).tolist()
    nearest: dict[int, tuple[float, int, float]] = {}
    for item, k in _nodes(network, nodes):
        node = int(item.node_ids[k])
        for road in roads_of[item.id]:
            s, distance = _nearest(plan_view, road, length[road], *item.points[k].tolist())
            found = (distance, road, s)
            nearest[node] = min(nearest.get(node, found), found)
    return nearest


def _known_heights(
    network: StreetNetwork, layout: JunctionLayout, parts: RoadParts, origin: FloatArray
) -> KnownHeights | None:
    """Return the heights that the user knows; `origin` (junctions, 2) is where junctions' planes are described, m.

    Nodes whose streets end short of them, at a junction, are on its plane.
    """
    heights = {node: item.z for node, item in sorted(network.corrections.nodes.items()) if item.z is not None}
    if not heights:
        return None
    nearest = _nearest_places(network, parts.plan_view, parts.street, heights)
    of_node = {node: j for j, nodes in enumerate(layout.nodes) for node in nodes}
    rows: dict[int, tuple[int, int, float, int, float, float, float]] = {}
    for item, k in _nodes(network, heights):
        node = int(item.node_ids[k])
        distance, road, s = nearest.get(node, (np.inf, -1, 0.0))
        junction = _junction_at(item, k, of_node, parts, road, s) if distance > _BESIDE_NODE else -1
        if junction >= 0:
            rows[node] = (node, -1, 0.0, junction, *(item.points[k] - origin[junction]).tolist(), heights[node])
        elif road >= 0:
            rows[node] = (node, road, s, -1, 0.0, 0.0, heights[node])
    table = np.array(list(rows.values()), np.float64).reshape(-1, 7)
    whole = table.astype(np.int64)
    return KnownHeights(whole[:, 0], whole[:, 1], table[:, 2], whole[:, 3], table[:, 4:6], table[:, 6])


def _junction_at(
    street: Street, place: int, of_node: Mapping[int, int], parts: RoadParts, road: int, s: float
) -> int:
    """Return the junction that has taken a node, at a place of a street; -1 if none has.

    `of_node` are the junctions of intersections; `road` is the street's road that is nearest to the node, at s, m, -1
    where the whole street lies in a junction.
    """
    ends = {0: street.start, len(street.node_ids) - 1: street.end}
    if place in ends and ends[place] in of_node:
        return of_node[ends[place]]
    if road < 0:
        return of_node.get(street.start, -1)
    return int(parts.end_junction[road, int(s > parts.length[road] / 2)])


def _nodes(network: StreetNetwork, wanted: Iterable[int]) -> list[tuple[Street, int]]:
    """Return the streets that pass wanted nodes, and the places of these among their nodes."""
    count = np.array([len(item.node_ids) for item in network.streets], np.int64)
    first = starts(count)[:-1]
    every = np.concatenate([np.zeros(0, np.int64), *(item.node_ids for item in network.streets)])
    found = np.flatnonzero(np.isin(every, np.array(list(wanted), np.int64)))
    owner = np.searchsorted(first, found, side="right") - 1
    return [
        (network.streets[k], place) for k, place in zip(owner.tolist(), (found - first[owner]).tolist(), strict=True)
    ]


def _nearest(plan_view: PlanView, road: int, length: float, x: float, y: float) -> tuple[float, float]:
    """Return where a road of a length is nearest to a place, and how near, m."""
    s = np.linspace(0.0, length, int(np.ceil(length / _STEP)) + 1)
    px, py, _ = pose(plan_view, np.full(len(s), road), s)
    distance = hypot(px - x, py - y)
    k = int(np.argmin(distance))
    return float(s[k]), float(distance[k])
