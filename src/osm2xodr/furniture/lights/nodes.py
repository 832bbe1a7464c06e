"""Which approaches, crossings and places on roads have lights, from the nodes that OSM tags with them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.conventions import Signs, read_signs
from osm2xodr.curves import curves_cross, sorted_unique
from osm2xodr.defaults import SIGN_REACH, SIGNALLED_CROSSING_REACH
from osm2xodr.furniture.defaults import ONE_INSTALLATION, ROOM_FOR_CAR
from osm2xodr.furniture.lights.heads import THROUGH, Candidate, RoadLight, place_on_roads, turn_of
from osm2xodr.furniture.world import (
    Approach,
    Crossing,
    Movement,
    World,
    junction_behind,
    nearest_segment,
    points_beside,
)
from osm2xodr.model import Light, NodeControl, RoadsideKind, Sign
from osm2xodr.system import record

# How far from a crossing a node with lights on a footway belongs to it, m; a choice.
_LIGHT_CROSSING_REACH: Final = 8.0


@record
class Sites:
    """Where lights are."""

    approaches: Mapping[int, str]  # OSM element behind the lights of each approach that has any, by its index
    # Approaches without lights of junctions with lights, by index: those of the junction before let their traffic go
    passed: frozenset[int]
    # All crossings of signalled junctions where people have lights: (id of the junction, crossing)
    crossings: tuple[tuple[int, Crossing], ...]
    on_roads: tuple[RoadLight, ...]  # Lights apart from junctions


@record
class _Place:
    """A place of a node with lights."""

    road: int  # -1 for none
    s: float  # m; beyond the road's ends in a junction
    junction: int  # Id of the junction that it lies in, -1 for none
    along: bool | None  # Whether it is for traffic along s, else against it; None where it may be for both


def find_sites(world: World, approaches: Sequence[Approach], crossings: Sequence[Crossing]) -> Sites:
    """Find all places that have lights, and report the nodes with lights that give none."""
    lights = {node: item for node, item in world.network.node_facts.controls.items() if item.light is not None}
    crossings = _with_lights_beside(world, crossings)
    if not lights and not any(crossing.signals for crossing in crossings):
        return Sites({}, frozenset(), (), ())
    signs = read_signs(world.network)
    # The first node with lights before each street end that has any, those of crossings included
    first_light: dict[int, int] = {}
    for node, ends in signs.ends_of.items():
        for end in ends if node in lights else ():
            first_light.setdefault(end, node)
    lit = _lit_approaches(world, approaches, signs, first_light)
    between = _between_lit_junctions(world, approaches, signs, lit)
    passed = _held_before(world, approaches, between, lit)
    lit = {k: osm_id for k, osm_id in lit.items() if k not in passed}
    added = [k for k in between if k not in lit and k not in passed]
    for k in added:
        words = "a short road between junctions with lights has none in OSM: it gets some before its junction"
        world.diagnostics.guessed("signal-between", _way_of(world, approaches[k]), words)
    lit |= dict.fromkeys(added, "")
    lit |= _crossing_lit_traffic(world, approaches, signs, first_light, {**lit, **dict.fromkeys(passed, "")})
    junctions = frozenset(approaches[k].junction for k in lit)
    with_lights = [(_junction_at(world, item, junctions), item) for item in crossings if item.signals]
    at_junctions = [(junction, item) for junction, item in with_lights if junction is not None]
    apart = [item for junction, item in with_lights if junction is None]
    covered = {crossing.osm_id for _, crossing in at_junctions}
    governed = {approaches[k].street_end for k in (*lit, *passed)}
    candidates = _not_at_junctions(world, lights, signs, governed, junctions, covered)
    named = {item.osm_id for item in candidates}
    others = (item for item in apart if item.osm_id not in named)
    candidates += [Candidate(*item.on_course, None, item.osm_id, True) for item in others]
    on_roads = place_on_roads(world, candidates, apart, crossings)
    placed = {osm_id for item in on_roads for osm_id in item.osm_ids}
    for osm_id in sorted({item.osm_id for item in candidates} - placed):
        _leave_out(world, osm_id, "no cars drive on the road there")
    on_roads, joined = _with_room(on_roads, [approaches[k] for k in lit])
    return Sites(lit, passed, (*at_junctions, *joined), on_roads)


def _with_room(
    found: Sequence[RoadLight], approaches: Sequence[Approach]
) -> tuple[tuple[RoadLight, ...], list[tuple[int, Crossing]]]:
    """Return the lights on roads that leave a car room before the next ones, and the crossings of the others.

    No car could wait between these and the lights of a junction (its `approaches` with lights), which are for their
    crossings, too: (id of the junction, crossing).
    """
    ahead = {(item.road, item.at_end): item for item in approaches}
    kept: list[RoadLight] = []
    joined: list[tuple[int, Crossing]] = []
    for light in found:
        stops, near = [], []
        for along, s in light.stops:
            item = ahead.get((light.road, along))
            if item is None or abs(item.stop_s - s) >= ROOM_FOR_CAR:
                stops.append((along, s))
            else:
                near.append(item.junction)
        if stops:
            kept.append(replace(light, stops=tuple(stops)))
        else:
            joined += [(near[0], crossing) for crossing in light.crossings]
    return tuple(kept), joined


def _leave_out(world: World, osm_id: str, why: str) -> None:
    world.diagnostics.dropped("signal-left-out", osm_id, f"the lights here are left out: {why}")


def _lit_approaches(
    world: World, approaches: Sequence[Approach], signs: Signs, first_light: Mapping[int, int]
) -> dict[int, str]:
    """Return which approaches have lights, and the OSM node that says so.

    Lights at the nodes of a junction or inside it are for all its approaches without a sign of their own; otherwise
    a junction has lights if enough of its approaches have, see `Signs.signalled`.
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
                lit[k] = f"node/{first_light.get(approaches[k].street_end, middle)}"
    return lit


def _between_lit_junctions(
    world: World, approaches: Sequence[Approach], signs: Signs, lit: Mapping[int, str]
) -> list[int]:
    """Return the approaches without lights or signs of their own that come from another junction with lights nearby.

    Where the carriageways of a wide road are junctions of their own but one intersection, OSM has the lights at the
    outer arms, or at the nodes where ways cross.
    """
    junctions = {approaches[k].junction for k in lit}
    return [
        k
        for k, approach in enumerate(approaches)
        if approach.junction in junctions
        and approach.street_end not in signs.before_end
        and junction_behind(world, approach) in junctions
        and world.lanes.length(approach.road) <= SIGN_REACH
    ]


def _held_before(
    world: World, approaches: Sequence[Approach], between: Sequence[int], lit: Mapping[int, str]
) -> frozenset[int]:
    """Return which of the approaches `between` junctions need no lights: their traffic is held one junction before.

    No queue fits on so short a road, and most of those who come to it (straight on, if any do) have just been let go
    by lights at an outer arm.
    """
    inner = frozenset(between)
    outer = frozenset(lit) - inner
    coming: dict[tuple[int, bool], list[tuple[int, Movement]]] = defaultdict(list)
    for k, approach in enumerate(approaches):
        for item in approach.movements:
            coming[item.exit_road, item.exit_at_start].append((k, item))
    out = []
    for k in between:
        road, at_end = approaches[k].road, approaches[k].at_end
        if world.lanes.length(road) > ONE_INSTALLATION:
            continue
        ways = [(other, item) for other, item in coming[road, at_end] if approaches[other].road != road]
        straight = [other for other, item in ways if turn_of(item) == THROUGH] or [other for other, _ in ways]
        held = sum(other in outer for other in straight)
        if 2 * held > len(straight) and all(other in outer or other in inner for other, _ in ways):
            out.append(k)
    return frozenset(out)


def _way_of(world: World, approach: Approach) -> str:
    return f"way/{world.lanes.road(approach.road).osm_way_ids[-1 if approach.at_end else 0]}"


def _crossing_lit_traffic(
    world: World, approaches: Sequence[Approach], signs: Signs, first_light: Mapping[int, int], lit: Mapping[int, str]
) -> dict[int, str]:
    """Return further approaches of junctions with lights whose traffic crosses that of approaches which have some.

    Where there are lights of a crossing and a sign before the junction, the sign holds while the lights are off.
    Traffic with neither would drive into traffic that has green: OSM lacks its lights, unless it only merges.
    """
    members: dict[int, list[int]] = defaultdict(list)
    for k in sorted(lit):
        members[approaches[k].junction].append(k)
    rows: list[tuple[int, int, int]] = []
    for k, approach in enumerate(approaches):
        end = approach.street_end
        if k in lit or approach.junction not in members or (end in signs.before_end and end not in first_light):
            continue
        lit_here = (approaches[other] for other in members[approach.junction])
        others = {item.connecting_road for lit_one in lit_here for item in lit_one.movements}
        own = {item.connecting_road for item in approach.movements}
        rows += [(k, world.lanes.index(one), world.lanes.index(other)) for one in own for other in others]
    if not rows:
        return {}
    owner, one, other = np.array(sorted(rows), np.int64).T
    out: dict[int, str] = {}
    for k in sorted_unique(owner[curves_cross(world.road_map.plan_view, one, other)]).tolist():
        node = first_light.get(approaches[k].street_end)
        out[k] = "" if node is None else f"node/{node}"
        if node is None:
            words = "it has no lights or signs in OSM and crosses traffic that has lights: it gets lights, too"
            world.diagnostics.guessed("signal-added", _way_of(world, approaches[k]), words)
    return out


def _junction_at(world: World, crossing: Crossing, junctions: frozenset[int]) -> int | None:
    """Return the id of the signalled junction on whose arm a crossing lies."""
    course, s = crossing.on_course
    road, to_end = world.lanes.road(course), world.lanes.length(course) - s
    ends = ((road.predecessor, crossing.at_start, s), (road.successor, crossing.at_end, to_end))
    found = [
        (away, link.id)
        for link, there, away in ends
        if there and link is not None and link.to_junction and link.id in junctions
    ]
    return min(found)[1] if found else None


def _not_at_junctions(
    world: World,
    lights: Mapping[int, NodeControl],
    signs: Signs,
    lit_ends: set[int],
    junctions: frozenset[int],
    covered: set[str],
) -> list[Candidate]:
    """Return the nodes whose lights stand on a road apart from junctions, and report those that give none."""
    of_node = {node: junction.id for junction in world.road_map.junctions for node in junction.osm_node_ids}
    arms = {item.osm_node_id: len(item.arms) for item in world.network.intersections if item.osm_node_id in lights}
    places_of = _places(world, lights)
    out: list[Candidate] = []
    for node, control in lights.items():
        osm_id = f"node/{node}"
        if control.light is Light.OTHER:
            _leave_out(world, osm_id, f"traffic_signals={control.light_value} never shows green to cars")
            continue
        if of_node.get(node) in junctions or osm_id in covered:
            continue
        ends = signs.ends_of.get(node, ())
        inside = (world.places.inner[end // 2] and int(world.places.end_junction[end]) in junctions for end in ends)
        if not lit_ends.isdisjoint(ends) or any(inside):
            continue
        places = [place for place in places_of.get(node, ()) if place.road >= 0]
        if any(_is_of_junction(world, place, control, junctions) for place in places):
            continue
        if arms.get(node) == 1:
            _leave_out(world, osm_id, "its street ends there, and the map with it")
        elif not places:
            _leave_out(world, osm_id, "it lies in a junction, and no traffic that lights could stop enters that")
        else:
            place = places[0]
            out.append(Candidate(place.road, place.s, place.along, osm_id, control.light is Light.CROSSING))
    return out


def _places(world: World, nodes: Collection[int]) -> Mapping[int, list[_Place]]:
    """Return all places of nodes with lights, those nearest to their roads first."""
    places = world.places
    rows = np.flatnonzero(np.isin(places.node, np.array(sorted(nodes), np.int64)))
    found: dict[int, list[tuple[float, int, _Place]]] = defaultdict(list)
    for row in rows.tolist():
        node, road, s = int(places.node[row]), int(places.road[row]), float(places.s[row])
        off = max(-s, s - world.lanes.length(road), 0.0) if road >= 0 else np.inf
        along = _along(world, node, int(places.street[row]))
        found[node].append((off, row, _Place(road, s, int(places.junction[row]), along)))
    return {node: [item[2] for item in sorted(items, key=lambda item: item[:2])] for node, items in found.items()}


def _along(world: World, node: int, street: int) -> bool | None:
    """Return whether a node's lights are for traffic along their street, and so along its roads."""
    along, found = world.network.node_facts.controls[node].facing.along, world.network.streets[street]
    return None if along is None else along != found.attributes_at(found.place_of(node)).reversed


def _is_of_junction(world: World, place: _Place, control: NodeControl, junctions: frozenset[int]) -> bool:
    """Return whether a place lies in a signalled junction, or is a crossing at one where traffic leaves it."""
    if place.junction in junctions:
        return True
    if control.light is not Light.CROSSING and not control.crossing_lights:
        return False
    at_start = place.s <= SIGNALLED_CROSSING_REACH
    at_end = world.lanes.length(place.road) - place.s <= SIGNALLED_CROSSING_REACH
    crossing = Crossing(place.road, place.s, 0.0, 0.0, 0.0, "", True, at_start, at_end)
    return _junction_at(world, crossing, junctions) is not None


def _with_lights_beside(world: World, crossings: Sequence[Crossing]) -> tuple[Crossing, ...]:
    """Give crossings the lights that OSM has beside the street, and report other lights there."""
    things = [item for item in world.network.roadside if item.kind is RoadsideKind.TRAFFIC_SIGNALS]
    if not things:
        return tuple(crossings)
    out = list(crossings)
    curve = np.array([world.lanes.index(item.road) for item in crossings], np.int64)
    s = np.array([item.s for item in crossings], float)
    left, right = (
        np.column_stack(points_beside(world.road_map.plan_view, curve, s, np.array(t, float))[:2])
        for t in ([item.left for item in crossings], [item.right for item in crossings])
    )
    for thing in things:
        near, distance = nearest_segment(thing.points[0], left, right) if out else (-1, np.inf)
        for_people = not world.footway_nodes.isdisjoint(thing.node_ids.tolist()) or thing.facts.at_crossing
        if distance > _LIGHT_CROSSING_REACH:
            _leave_out(world, thing.osm_id, "it lies on no street of the map and at no crossing")
        elif not out[near].signals and not for_people:
            _leave_out(world, thing.osm_id, "it lies on no street of the map")
        else:
            out[near] = replace(out[near], signals=True)
    return tuple(out)
