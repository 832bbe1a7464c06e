"""Lines across lanes at which traffic stops or yields, and arrows that show where lanes lead."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from math import pi
from typing import Final

import numpy as np

from osm2xodr.curves import project
from osm2xodr.diagnostics import Kind
from osm2xodr.furniture import defaults
from osm2xodr.furniture.world import Approach, Crossing, LaneAt, Stop, World, lane_ranges, pieces_on_road
from osm2xodr.model import Direction, LaneSpec, RoadObject, Rule, StreetAttributes

# Lines on the same lanes that are nearer to each other are one, m; a choice.
_APART: Final = 2.0
# Subtype and name of lines by the kind of stop, the strictest first.
_LINES: Final = {
    "traffic_signals": ("stopLine", "stop line"),
    "stop": ("stopLine", "stop line"),
    "give_way": ("giveWayLine", "give-way line"),
}
_RANK: Final = {kind: rank for rank, kind in enumerate(_LINES)}
# Lanes whose edges are nearer lie side by side, and narrower lanes get no line, m: rounding.
_TOUCH: Final = 0.01


def stop_lines(world: World, stops: Sequence[Stop], crossings: Sequence[Crossing] = ()) -> list[RoadObject]:
    """Make the lines of stops, one across each group of lanes side by side; the strictest of stops at one place.

    Where a road is so short that its line would lie on a crossing it has none: cars would wait among people.
    """
    walked: dict[int, list[tuple[float, float]]] = defaultdict(list)
    for crossing in crossings:
        half = 0.5 * crossing.width
        walked[crossing.road].append((crossing.s - half, crossing.s + half))
    out: list[RoadObject] = []
    for stop in _distinct(stops):
        length = world.lanes.length(stop.road)
        extent = min(defaults.STOP_LINE_EXTENT, length)
        # The line lies on the side from which traffic comes.
        begin = stop.s - extent if stop.orientation == "+" else stop.s
        begin = min(max(begin, 0.0), length - extent)
        if any(low < begin + extent - _TOUCH and begin + _TOUCH < high for low, high in walked[stop.road]):
            words = f"its {_LINES[stop.kind][1]} is left out: the road is too short for it before the crossing"
            world.diagnostics.dropped("stop-line-left-out", stop.osm_id, words)
            continue
        middle = begin + 0.5 * extent
        lanes = [lane for lane in world.lanes.at(stop.road, middle) if lane.id in stop.lanes]
        out += [_line(world, stop, middle, extent, group) for group in _side_by_side(lanes)]
    return out


def _distinct(stops: Sequence[Stop]) -> list[Stop]:
    kept: dict[tuple[int, str], list[Stop]] = defaultdict(list)
    for stop in sorted(stops, key=lambda item: (item.road, item.orientation, _RANK[item.kind], item.s)):
        others = kept[stop.road, stop.orientation]
        if not any(abs(other.s - stop.s) < _APART and set(other.lanes) & set(stop.lanes) for other in others):
            others.append(stop)
    return [stop for group in kept.values() for stop in group]


def _side_by_side(lanes: Sequence[LaneAt]) -> list[list[LaneAt]]:
    """Return lanes, from left to right, in groups without a gap."""
    groups: list[list[LaneAt]] = []
    for lane in lanes:
        if lane.left - lane.right >= _TOUCH:
            if not groups or groups[-1][-1].right - lane.left >= _TOUCH:
                groups.append([])
            groups[-1].append(lane)
    return groups


def _line(world: World, stop: Stop, s: float, extent: float, lanes: Sequence[LaneAt]) -> RoadObject:
    left, right = lanes[0].left, lanes[-1].right
    line = world.object_at(stop.road, ("roadMark", *_LINES[stop.kind]), s, 0.5 * (left + right), stop.osm_id)
    validity = lane_ranges(lane.id for lane in lanes)
    return replace(line, length=extent, width=left - right, orientation=stop.orientation, validity=validity)


# Diameter of the disc in the middle of a mini roundabout where OSM gives none, m: TSRGD 2016, diagram 1003.4, from 1
# to 4.
_DISC: Final = 4.0


def mini_roundabouts(world: World) -> list[RoadObject]:
    """Make the discs that mini roundabouts go round, on the nearest way through their junction."""
    network, road_map = world.network, world.road_map
    inside: dict[int, list[int]] = defaultdict(list)
    for k, road in enumerate(road_map.roads):
        if road.junction is not None:
            inside[road.junction].append(k)
    junctions = {node: item.id for item in road_map.junctions for node in item.osm_node_ids}
    out: list[RoadObject] = []
    for node, places in sorted(world.nodes.on_streets(network.node_facts.mini_roundabouts).items()):
        osm_id = f"node/{node}"
        if node not in junctions:
            words = "highway=mini_roundabout is not carried: no streets meet there"
            world.diagnostics.dropped("street-node", osm_id, words)
            continue
        curves = np.array(inside[junctions[node]], np.int64)
        s, t, _ = project(road_map.plan_view, curves, *(np.full(len(curves), v) for v in (places[0].x, places[0].y)))
        k = int(np.abs(t).argmin())
        kind = ("roadMark", "miniRoundabout", "mini roundabout")
        disc = world.object_at(road_map.roads[int(curves[k])].id, kind, float(s[k]), float(t[k]), osm_id)
        out.append(replace(disc, radius=0.5 * (network.turning_circles.get(node) or _DISC)))
        message = "its arms give way to those who go round it, but turns are drawn straight across its middle"
        world.diagnostics.note("mini-roundabout", osm_id, message)
    return out


# Length in towns, m (RMS-1, Zeichen 297); width, distance from the stop line to the tip of the first one, and from
# tip to tip, m; choices.
_LENGTH: Final = 5.0
_WIDTH: Final = 1.0
_FROM_LINE: Final = 5.0
_SPACING: Final = 20.0
# Number of arrows per lane, and width of the narrowest lane that gets any, m; choices.
_COUNT: Final = 2
_NARROWEST_LANE: Final = 2.0
# OpenDRIVE's words for OSM's.
_WORDS: Final = {
    "left": "Left",
    "slight_left": "SlightLeft",
    "sharp_left": "SharpLeft",
    "merge_to_left": "MergeLeft",
    "right": "Right",
    "slight_right": "SlightRight",
    "sharp_right": "SharpRight",
    "merge_to_right": "MergeRight",
    "through": "Straight",
    "reverse": "UTurn",
}


def arrows(world: World, approaches: Sequence[Approach], stops: Sequence[Stop]) -> list[RoadObject]:
    """Make the arrows of lanes with ``turn:lanes`` on approaches, before the first stop line there."""
    lines: dict[tuple[int, str], list[float]] = {}
    for stop in stops:
        lines.setdefault((stop.road, stop.orientation), []).append(stop.s)
    out: list[RoadObject] = []
    unmatched: list[str] = []
    for approach in approaches:
        street = world.network.streets[approach.street_end // 2]
        if not any(lane.turns for _, piece in street.pieces for lane in piece.lanes_ltr):
            continue
        attributes = pieces_on_road(world, street, approach.road)[-1 if approach.at_end else 0][2]
        turns = lane_turns(attributes, world.network.rule, approach.at_end)
        if not turns:
            continue
        if not _matches(world, approach, attributes):
            unmatched.append(f"way/{attributes.osm_way_id}")
            continue
        known = lines.get((approach.road, approach.orientation), ())
        near = [s for s in known if abs(s - approach.stop_s) <= defaults.STOP_NODE_REACH]
        # The first line that traffic meets.
        line = (min if approach.at_end else max)([approach.stop_s, *near])
        for lane, words in sorted(turns.items()):
            out += _on_lane(world, approach, lane, words, line, f"way/{attributes.osm_way_id}")
    finding = "without arrows: the lanes there are not those of the way"
    world.diagnostics.count(Kind.DROPPED, "turn-arrows", unmatched, "road end", finding)
    return out


def arrow_name(turns: frozenset[str]) -> str:
    """Return the subtype of an arrow: ``arrow`` and its directions in alphabetical order; empty for none."""
    words = sorted(_WORDS[turn] for turn in turns if turn in _WORDS)
    return "arrow" + "".join(words) if words else ""


def lane_ids(attributes: StreetAttributes, rule: Rule) -> dict[int, LaneSpec]:
    """Return the lanes of a street by OpenDRIVE's lane id.

    Lanes along the street, or for both directions, lie right of the centre with right-hand traffic, else left.
    """
    lanes = attributes.lanes_ltr
    backward = sum(lane.direction is Direction.BACKWARD for lane in lanes)
    on_left = backward if rule is Rule.RIGHT_HAND else len(lanes) - backward
    return {on_left - k if k < on_left else on_left - k - 1: lane for k, lane in enumerate(lanes)}


def lane_turns(attributes: StreetAttributes, rule: Rule, along: bool) -> dict[int, frozenset[str]]:
    """Return ``turn:lanes`` by lane id for traffic along the street (or against it)."""
    wanted = Direction.FORWARD if along else Direction.BACKWARD
    lanes = ((lane, spec) for lane, spec in lane_ids(attributes, rule).items() if spec.direction is wanted)
    return {lane: spec.turns for lane, spec in lanes if arrow_name(spec.turns)}


def _matches(world: World, approach: Approach, attributes: StreetAttributes) -> bool:
    """Return whether the road has the street's lanes for the approach's traffic."""
    there = {(lane.id, lane.type) for lane in world.lanes.at(approach.road, approach.stop_s)}
    wanted = Direction.FORWARD if approach.at_end else Direction.BACKWARD
    specs = lane_ids(attributes, world.network.rule).items()
    return all((lane, spec.type) in there for lane, spec in specs if spec.direction is wanted)


def _on_lane(
    world: World, approach: Approach, lane: int, turns: frozenset[str], line: float, osm_id: str
) -> list[RoadObject]:
    """Make the arrows of one lane, from the stop line back as far as there is room."""
    out = []
    road, back = approach.road, -1.0 if approach.at_end else 1.0
    section = world.lanes.section_start(road, approach.stop_s)
    words, hdg = ("roadMark", arrow_name(turns), "arrow"), 0.0 if approach.at_end else pi
    for number in range(_COUNT):
        tip = line + back * (_FROM_LINE + number * _SPACING)
        tail = tip + back * _LENGTH
        if not 0.0 <= tail <= world.lanes.length(road) or world.lanes.section_start(road, tail) != section:
            # Lanes of another section may have other ids.
            break
        if not all(_has_room(world, road, s, lane) for s in (tip, tail)):
            break
        middle = 0.5 * (tip + tail)
        (t,) = (item.middle for item in world.lanes.at(road, middle) if item.id == lane)
        arrow = world.object_at(road, words, middle, t, osm_id)
        for_lane = replace(arrow, orientation=approach.orientation, validity=((lane, lane),))
        out.append(replace(for_lane, hdg=hdg, length=_LENGTH, width=_WIDTH))
    return out


def _has_room(world: World, road: int, s: float, lane: int) -> bool:
    return any(item.id == lane and item.left - item.right >= _NARROWEST_LANE for item in world.lanes.at(road, s))
