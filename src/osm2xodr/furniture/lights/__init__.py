"""Traffic lights: where they stand, which lanes they govern, and which are green together.

Junctions have one installation where no queue fits on the short roads between them. Poles are kept off lanes, of the
own road and of others.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from osm2xodr.curves import connected_groups
from osm2xodr.furniture import defaults
from osm2xodr.furniture.defaults import ONE_INSTALLATION
from osm2xodr.furniture.lights.heads import (
    FOR_PEOPLE,
    Head,
    RoadLight,
    approach_heads,
    lanes_at_stop,
    people_heads,
    road_heads,
)
from osm2xodr.furniture.lights.nodes import Sites, find_sites
from osm2xodr.furniture.lights.phases import Phases, controllers_of, junction_programmes
from osm2xodr.furniture.world import Approach, Crossing, Stop, World, free_of_other_roads, junction_behind
from osm2xodr.model import Controller, Sign, Signal, SignalProgramme, SignalReference

_KIND: Final = Sign.SIGNALS.value
# How far outwards a head may be moved to where no lane is, m, in the order of trials; choices.
_STEPS: Final = (-0.3, 0.5, 1.0)


@dataclass(slots=True)
class Lights:
    """The lights of a map; the lists grow while lights are placed."""

    # (id of a road, s) where a new lane section has to begin, see `osm2xodr.furniture.lane_sections`
    section_breaks: tuple[tuple[int, float], ...] = ()
    # (id of the road, whether traffic comes to its end) of the approaches with lights
    signalled: frozenset[tuple[int, bool]] = frozenset()
    signals: list[Signal] = field(default_factory=list)
    references: list[SignalReference] = field(default_factory=list)
    controllers: list[Controller] = field(default_factory=list)
    programmes: list[SignalProgramme] = field(default_factory=list)
    stops: list[Stop] = field(default_factory=list)


def place_lights(world: World, approaches: Sequence[Approach], crossings: Sequence[Crossing]) -> Lights:
    """Place all traffic lights: at junctions, on roads apart from them, and for people at crossings with lights."""
    sites = find_sites(world, approaches, crossings)
    lit = frozenset((approaches[k].road, approaches[k].at_end) for k in (*sites.approaches, *sites.passed))
    placed = Lights(tuple((light.road, light.section_break()) for light in sites.on_roads), lit)
    _at_junctions(world, approaches, sites, placed)
    for light in sites.on_roads:
        _on_road(world, light, placed)
    placed.signals = off_lanes(world, placed.signals)
    placed.controllers = switching(placed.controllers, placed.signals)
    _report_joined(world, placed)
    return placed


def _report_joined(world: World, placed: Lights) -> None:
    """Report the nodes whose lights are joined with those of another node before the same junction."""
    named = {signal.osm_id for signal in placed.signals} | {item.osm_id for item in world.diagnostics}
    for node, control in world.network.node_facts.controls.items():
        if control.tagged is Sign.SIGNALS and f"node/{node}" not in named:
            words = "the lights here are joined with those of another node at the same junction"
            world.diagnostics.note("signal-joined", f"node/{node}", words)


def _at_junctions(world: World, approaches: Sequence[Approach], sites: Sites, placed: Lights) -> None:
    heads: list[Head] = []
    members: dict[int, list[int]] = defaultdict(list)
    for k, osm_id in sorted(sites.approaches.items()):
        approach = approaches[k]
        found, references = approach_heads(world, k, approach, osm_id)
        members[approach.junction] += range(len(heads), len(heads) + len(found))
        heads += found
        placed.references += references
        lanes = tuple(lanes_at_stop(world, approach).values())
        placed.stops.append(Stop(approach.road, approach.stop_s, lanes, approach.orientation, _KIND, osm_id))
    people: dict[int, list[Signal]] = defaultdict(list)
    for junction, crossing in sites.crossings if world.options.target.lights_for_people else ():
        people[junction] += people_heads(world, crossing, _towards(world, crossing, junction))
    phases = Phases(world, approaches, heads, sites.passed)
    alone = {junction: phases.groups(rows) for junction, rows in members.items()}
    counts = {junction: len(groups) for junction, groups in alone.items()}
    for group in installations(world, approaches, sites, counts):
        rows = [k for junction in group for k in members[junction]]
        ids = [signal.id for junction in group for signal in people[junction]]
        together = alone[group[0]] if len(group) == 1 else phases.groups(rows)
        placed.controllers += controllers_of(world, group, heads, together, ids)
    for junction, rows in sorted(members.items()):
        placed.signals += [heads[k].signal for k in rows] + people[junction]
    if world.options.target.programmes:
        placed.programmes = junction_programmes(world, approaches, heads, members, phases)


def _towards(world: World, crossing: Crossing, junction: int) -> bool:
    """Return whether traffic along s comes over a crossing to a junction; at both ends the nearer one counts."""
    course, s = crossing.on_course
    road = world.lanes.road(course)
    ahead, behind = (
        link is not None and link.to_junction and link.id == junction for link in (road.successor, road.predecessor)
    )
    if ahead and behind:
        return s > 0.5 * world.lanes.length(course)
    return ahead


def _on_road(world: World, light: RoadLight, placed: Lights) -> None:
    cars = road_heads(world, light)
    for signal, lanes in cars:
        placed.stops.append(Stop(signal.road, signal.s, lanes, signal.orientation, _KIND, signal.osm_id))
    crossings = light.crossings if world.options.target.lights_for_people else ()
    people = [signal for crossing in crossings for signal in people_heads(world, crossing, light.stops[0][0])]
    groups = (("traffic", "cars", [head for head, _ in cars]), ("pedestrian", "people", people))
    for sequence, (kind, who, members) in enumerate(groups):
        placed.signals += members
        if members and world.options.target.controllers_apart:
            signals = tuple(sorted(item.id for item in members))
            name = f"{light.osm_ids[0]}, {who}"
            placed.controllers.append(Controller(world.ids.controller(), name, signals, None, sequence, kind))


def installations(
    world: World, approaches: Sequence[Approach], sites: Sites, phases: Mapping[int, int]
) -> list[list[int]]:
    """Return groups of junctions with lights, by ascending ids.

    Junctions share a group if the lights of one let traffic go through the other, or if an approach with lights to
    one of them is a road of up to `ONE_INSTALLATION` that comes from the other. `phases` says how many each junction
    takes alone: where one is enough, nobody waits for anybody, and other junctions need not be waited for.
    """
    ids = sorted(phases)
    place = {junction: k for k, junction in enumerate(ids)}
    near = [k for k in sites.approaches if world.lanes.length(approaches[k].road) <= ONE_INSTALLATION]
    found = [
        (k, approaches[k].junction, junction_behind(world, approaches[k])) for k in (*near, *sorted(sites.passed))
    ]
    pairs = [
        (place[one], place[other])
        for k, one, other in found
        if one in place and other in place and (k in sites.passed or min(phases[one], phases[other]) > 1)
    ]
    ends = np.array(pairs, np.int64).reshape(-1, 2)
    groups: dict[int, list[int]] = {}
    for junction, group in zip(ids, connected_groups(len(ids), *ends.T).tolist(), strict=True):
        groups.setdefault(group, []).append(junction)
    return list(groups.values())


def off_lanes(world: World, signals: Sequence[Signal]) -> list[Signal]:
    """Return heads so that none stands on lanes.

    Those beside the carriageway go a little nearer to it or farther off; where there is no room, those for cars hang
    above their lanes, and those for people are left out: nobody waits between lanes.
    """
    standing = [k for k, item in enumerate(signals) if item.z_offset < defaults.LIGHT_Z_ABOVE]
    out: list[Signal | None] = list(signals)
    for step in (0.0, *_STEPS):
        places = [(signals[k].road, signals[k].s, _outwards(world, signals[k], step)) for k in standing]
        own = [_on_carriageway(world, *place) for place in places]
        free = [is_free and not on for is_free, on in zip(free_of_other_roads(world, places), own, strict=True)]
        for k, (_, _, t), is_free in zip(standing, places, free, strict=True):
            out[k] = replace(signals[k], t=t) if is_free and step else out[k]
        standing = [k for k, is_free in zip(standing, free, strict=True) if not is_free]
    for k in standing:
        out[k] = _without_room(world, signals[k])
    return [item for item in out if item is not None]


def _on_carriageway(world: World, road: int, s: float, t: float) -> bool:
    """Return whether a place is on the carriageway of its own road."""
    left, right = world.lanes.carriageway(road, s)
    return right < t < left


def _outwards(world: World, signal: Signal, step: float) -> float:
    """Return t of a head that is moved away from the carriageway, m."""
    left, right = world.lanes.carriageway(signal.road, signal.s)
    return signal.t + (step if signal.t > 0.5 * (left + right) else -step)


def _without_room(world: World, signal: Signal) -> Signal | None:
    """Return a head for which there is no room beside its road: above its lanes; None for people."""
    if signal.type == FOR_PEOPLE:
        words = "a light for people is left out: it would stand on lanes"
        world.diagnostics.note("light-no-room", signal.osm_id, words)
        return None
    lanes = [
        lane
        for lane in world.lanes.at(signal.road, signal.s)
        if any(first <= lane.id <= last for first, last in signal.validity)
    ]
    if not lanes:
        return signal
    middle = 0.5 * (max(lane.left for lane in lanes) + min(lane.right for lane in lanes))
    return replace(signal, t=middle, z_offset=defaults.LIGHT_Z_ABOVE)


def switching(controllers: Sequence[Controller], signals: Sequence[Signal]) -> list[Controller]:
    """Return controllers without the heads that have been left out, and none without a head."""
    there = {item.id for item in signals}
    kept = [replace(item, signals=tuple(k for k in item.signals if k in there)) for item in controllers]
    return [item for item in kept if item.signals]
