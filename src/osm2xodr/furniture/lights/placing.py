"""Traffic lights at junctions and crossings, and the controllers that switch them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from osm2xodr.furniture.lights.heads import Head, approach_heads, lanes_at_stop, people_heads, road_heads
from osm2xodr.furniture.lights.installations import installations
from osm2xodr.furniture.lights.nodes import Sites, find_sites
from osm2xodr.furniture.lights.phases import Phases, controllers_of
from osm2xodr.furniture.lights.programmes import junction_programmes
from osm2xodr.furniture.lights.road_lights import RoadLight
from osm2xodr.furniture.lights.standing import off_lanes, switching
from osm2xodr.furniture.world import Approach, Crossing, Stop, World
from osm2xodr.model import Controller, Sign, Signal, SignalProgramme, SignalReference

_KIND: Final = Sign.SIGNALS.value


@dataclass(slots=True)
class Lights:
    """The lights of a map; the lists grow while lights are placed."""

    # (id of a road, s) where a new lane section has to begin, see `osm2xodr.furniture.lights.section_breaks`
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
    lit = frozenset((approaches[k].road, approaches[k].at_end) for k in sites.approaches)
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
    phases = Phases(world, approaches, heads)
    alone = {junction: phases.groups(rows) for junction, rows in members.items()}
    counts = {junction: len(groups) for junction, groups in alone.items()}
    for group in installations(world, approaches, sites.approaches, counts):
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
