"""Which approaches, crossings and places on roads have lights, from the nodes that OSM tags with them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from osm2xodr import defaults
from osm2xodr.conventions import Signs, read_signs
from osm2xodr.curves import crossing as paths_crossing, pose
from osm2xodr.furniture.lights.road_lights import Candidate, RoadLight, place_on_roads
from osm2xodr.furniture.lights.rows import LightRow, light_rows
from osm2xodr.furniture.world import Approach, Crossing, World
from osm2xodr.model import FloatArray, Light, NodeControl, RoadsideKind, Sign

# How far from a crossing a node with lights on a footway belongs to it, m; a choice.
_LIGHT_CROSSING_REACH: Final = 8.0

_LEFT_OUT = "signal-left-out"


@dataclass(frozen=True, slots=True)
class Sites:
    """Where lights are."""

    approaches: Mapping[int, str]  # OSM element behind the lights of each approach that has any, by its index
    # All crossings of signalled junctions where people have lights: (id of the junction, crossing)
    crossings: tuple[tuple[int, Crossing], ...]
    on_roads: tuple[RoadLight, ...]  # Lights apart from junctions


def find_sites(world: World, approaches: Sequence[Approach], crossings: Sequence[Crossing]) -> Sites:
    """Find all places that have lights, and say which nodes with lights give none."""
    lights = {node: item for node, item in world.network.node_facts.controls.items() if item.light is not None}
    crossings = _with_lights_beside(world, crossings)
    if not lights and not any(crossing.signals for crossing in crossings):
        return Sites({}, (), ())
    signs = read_signs(world.network)
    before = _lights_before(world, signs)
    lit = _lit_approaches(world, approaches, signs, before)
    lit |= dict.fromkeys(_between(world, approaches, signs, lit), "")
    lit |= _crossing_the_lit(world, approaches, signs, before, lit)
    junctions = frozenset(approaches[k].junction for k in lit)
    at_junctions: list[tuple[int, Crossing]] = []
    apart: list[Crossing] = []
    for crossing in crossings:
        if not crossing.signals:
            continue
        junction = _junction_at(world, crossing, junctions)
        if junction is None:
            apart.append(crossing)
        else:
            at_junctions.append((junction, crossing))
    covered = {crossing.osm_id for _, crossing in at_junctions}
    candidates = _not_at_junctions(world, lights, signs, {approaches[k].street_end for k in lit}, junctions, covered)
    named = {item.osm_id for item in candidates}
    candidates += [
        Candidate(item.road, item.s, None, item.osm_id, True) for item in apart if item.osm_id not in named
    ]
    found = place_on_roads(world, candidates, apart)
    have = {osm_id for item in found for osm_id in item.osm_ids}
    for osm_id in sorted({item.osm_id for item in candidates} - have):
        _leave_out(world, osm_id, "no cars drive on the road there")
    return Sites(lit, tuple(at_junctions), found)


def _leave_out(world: World, osm_id: str, why: str) -> None:
    world.diagnostics.dropped(_LEFT_OUT, osm_id, f"the lights here are left out: {why}")


def _lights_before(world: World, signs: Signs) -> dict[int, int]:
    """Return the first node with lights before each street end that has any, those of crossings among them."""
    out: dict[int, int] = {}
    for node, ends in signs.ends_of.items():
        if world.network.node_facts.controls[node].light is not None:
            for end in ends:
                out.setdefault(end, node)
    return out


def _lit_approaches(
    world: World, approaches: Sequence[Approach], signs: Signs, before: Mapping[int, int]
) -> dict[int, str]:
    """Return which approaches have lights, and the OSM node that says so.

    Lights at the nodes of a junction or inside it are for all its approaches but those that have a sign of their
    own; else a junction has lights if enough of its approaches have, as `Signs.signalled` says.
    """
    places = world.places
    inside: dict[int, int] = {}
    for node, ends in signs.ends_of.items():
        for end in ends:
            if places.inner[end // 2] and signs.before_end[end] is Sign.SIGNALS:
                inside.setdefault(int(places.end_junction[end]), node)
    members: dict[int, list[int]] = defaultdict(list)
    for k, approach in enumerate(approaches):
        members[approach.junction].append(k)
    lit: dict[int, str] = {}
    for junction in world.road_map.junctions:
        rows = members.get(junction.id, [])
        middle = next(
            (n for n in junction.osm_node_ids if signs.nodes.get(n) is Sign.SIGNALS), inside.get(junction.id)
        )
        if middle is None and not signs.signalled((), [approaches[k].street_end for k in rows]):
            continue
        for k in rows:
            sign = signs.before_end.get(approaches[k].street_end)
            if sign is Sign.SIGNALS or (sign is None and middle is not None):
                lit[k] = f"node/{before.get(approaches[k].street_end, middle)}"
    return lit


def _between(world: World, approaches: Sequence[Approach], signs: Signs, lit: Mapping[int, str]) -> list[int]:
    """Return the approaches without lights or signs that come from another junction with lights over a short road.

    The carriageways of a wide road are junctions of their own there, but one intersection: OSM has its lights at the
    arms that lead to it.
    """
    junctions = {approaches[k].junction for k in lit}
    out = []
    for k, approach in enumerate(approaches):
        if k in lit or approach.junction not in junctions or approach.street_end in signs.before_end:
            continue
        road = world.lanes.road(approach.road)
        behind = road.predecessor if approach.at_end else road.successor
        if behind is None or not behind.to_junction or behind.id not in junctions:
            continue
        if world.lanes.length(approach.road) <= defaults.SIGN_REACH:
            out.append(k)
            way = f"way/{road.osm_way_ids[-1 if approach.at_end else 0]}"
            words = "a short road between junctions with lights has none in OSM, it gets some where it comes to one"
            world.diagnostics.guessed("signal-between", way, words)
    return out


def _crossing_the_lit(
    world: World, approaches: Sequence[Approach], signs: Signs, before: Mapping[int, int], lit: Mapping[int, str]
) -> dict[int, str]:
    """Return further approaches of junctions with lights whose traffic crosses that of approaches which have some.

    Those with lights of a crossing and a sign before the junction have the sign for when the lights are off. Those
    with neither would drive into traffic that has green: OSM lacks their lights, unless they merge and do not cross.
    """
    members: dict[int, list[int]] = defaultdict(list)
    for k in sorted(lit):
        members[approaches[k].junction].append(k)
    rows: list[tuple[int, int, int]] = []
    for k, approach in enumerate(approaches):
        end = approach.street_end
        if k in lit or approach.junction not in members or (end in signs.before_end and end not in before):
            continue
        others = {
            item.connecting_road for other in members[approach.junction] for item in approaches[other].movements
        }
        own = {item.connecting_road for item in approach.movements}
        rows += [(k, world.lanes.index(one), world.lanes.index(other)) for one in own for other in others]
    if not rows:
        return {}
    owner, one, other = np.array(sorted(rows), np.int64).T
    out: dict[int, str] = {}
    for k in np.unique(owner[paths_crossing(world.road_map.plan_view, one, other)]).tolist():
        end = approaches[k].street_end
        out[k] = f"node/{before[end]}" if end in before else ""
        if not out[k]:
            road = world.lanes.road(approaches[k].road)
            way = f"way/{road.osm_way_ids[-1 if approaches[k].at_end else 0]}"
            words = "it has no lights or signs in OSM and crosses traffic that has lights: it gets some, too"
            world.diagnostics.guessed("signal-added", way, words)
    return out


def _junction_at(world: World, crossing: Crossing, junctions: frozenset[int]) -> int | None:
    """Return the id of the signalled junction whose arm a crossing lies on."""
    road = world.lanes.road(crossing.road)
    length = world.lanes.length(crossing.road)
    found = []
    for link, there, away in (
        (road.predecessor, crossing.at_start, crossing.s),
        (road.successor, crossing.at_end, length - crossing.s),
    ):
        if there and link is not None and link.to_junction and link.id in junctions:
            found.append((away, link.id))
    return min(found)[1] if found else None


def _not_at_junctions(
    world: World,
    lights: Mapping[int, NodeControl],
    signs: Signs,
    lit_ends: set[int],
    junctions: frozenset[int],
    covered: set[str],
) -> list[Candidate]:
    """Return what is to have lights on a road of its own, and report the nodes that give nothing."""
    network = world.network
    of_node = {node: junction.id for junction in world.road_map.junctions for node in junction.osm_node_ids}
    arms = {item.osm_node_id: len(item.arms) for item in network.intersections if item.osm_node_id in lights}
    rows = light_rows(world, lights)
    out: list[Candidate] = []
    for node, control in lights.items():
        osm_id = f"node/{node}"
        if control.light is Light.OTHER:
            _leave_out(world, osm_id, f"traffic_signals={control.light_value} tells no one to go")
            continue
        if of_node.get(node) in junctions or osm_id in covered:
            continue
        ends = signs.ends_of.get(node, ())
        if any(end in lit_ends or _inside(world, end, junctions) for end in ends):
            continue
        places = [row for row in rows.get(node, ()) if row.road >= 0]
        if any(_belongs(world, row, control, junctions) for row in places):
            continue
        if arms.get(node) == 1:
            _leave_out(world, osm_id, "its street ends there, and the map with it")
        elif not places:
            _leave_out(world, osm_id, "it lies in a junction that no traffic which lights could stop enters")
        else:
            row = places[0]
            out.append(Candidate(row.road, row.s, row.along, osm_id, control.light is Light.CROSSING))
    return out


def _inside(world: World, end: int, junctions: frozenset[int]) -> bool:
    return bool(world.places.inner[end // 2]) and int(world.places.end_junction[end]) in junctions


def _belongs(world: World, row: LightRow, control: NodeControl, junctions: frozenset[int]) -> bool:
    """Say whether a place lies in a signalled junction, or is a crossing at one where traffic leaves it."""
    if row.junction in junctions:
        return True
    if control.light is not Light.CROSSING and not control.crossing_lights:
        return False
    reach = defaults.SIGNALLED_CROSSING_REACH
    at_start, at_end = row.s <= reach, world.lanes.length(row.road) - row.s <= reach
    place = Crossing(row.road, row.s, 0.0, 0.0, 0.0, "", True, at_start, at_end)
    return _junction_at(world, place, junctions) is not None


def _with_lights_beside(world: World, crossings: Sequence[Crossing]) -> tuple[Crossing, ...]:
    """Give crossings the lights that OSM has beside the street, and report other lights there."""
    things = [item for item in world.network.roadside if item.kind is RoadsideKind.TRAFFIC_SIGNALS]
    if not things:
        return tuple(crossings)
    out = list(crossings)
    left, right = _crossing_ends(world, crossings)
    for thing in things:
        near = _nearest(thing.points[0], left, right)
        for_people = not world.footway_nodes.isdisjoint(thing.node_ids.tolist()) or thing.facts.at_crossing
        if near is None:
            _leave_out(world, thing.osm_id, "it lies on no street that is carried and at no crossing")
        elif not out[near].signals and not for_people:
            _leave_out(world, thing.osm_id, "it lies on no street that is carried")
        else:
            out[near] = replace(out[near], signals=True)
    return tuple(out)


def _crossing_ends(world: World, crossings: Sequence[Crossing]) -> tuple[FloatArray, FloatArray]:
    """Return the left and right ends of crossings, both (n, 2), m."""
    curve = np.array([world.lanes.index(item.road) for item in crossings], np.int64)
    x, y, hdg = pose(world.road_map.plan_view, curve, np.array([item.s for item in crossings], float))
    ends = []
    for t in (np.array([item.left for item in crossings]), np.array([item.right for item in crossings])):
        ends.append(np.column_stack([x - t * np.sin(hdg), y + t * np.cos(hdg)]))
    return ends[0], ends[1]


def _nearest(point: FloatArray, left: FloatArray, right: FloatArray) -> int | None:
    """Return the index of the crossing nearest to a point, (2,), within reach; their ends are (n, 2), m."""
    if not len(left):
        return None
    step = right - left
    share = np.clip(((point - left) * step).sum(1) / np.maximum((step * step).sum(1), 1e-12), 0.0, 1.0)
    distance = np.hypot(*(point - left - share[:, None] * step).T)
    k = int(np.argmin(distance))
    return k if distance[k] <= _LIGHT_CROSSING_REACH else None
