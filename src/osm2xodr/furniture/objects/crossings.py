"""Crossings for people on foot: which there are, and where on which roads; lights and barriers of level crossings.

Level crossings are open, as no train comes, and their barriers stand beside the road.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from math import cos, hypot, pi, sin
from typing import Final

import numpy as np

from osm2xodr.curves import pose
from osm2xodr.diagnostics import Kind
from osm2xodr.furniture import defaults
from osm2xodr.furniture.objects.junction_crossings import Course, JunctionPaths, Span, across_of
from osm2xodr.furniture.world import Crossing, NodePlace, RailStop, World, car_lanes, with_room_for_line
from osm2xodr.model import MappedCrossing, RoadObject, Rule
from osm2xodr.system import record

# Crossings end at least this far before a road that leads nowhere, m; a choice.
_FROM_END: Final = 0.05
# A crossing in a junction may go to arms within 30 degrees, by their sine, of the street that it crosses; a choice.
_ARM_SINE: Final = 0.5
# Nothing crosses narrower carriageways, m; a choice.
_NARROWEST_CARRIAGEWAY: Final = 0.5
# How far a crossing may be moved so that it leads from kerb to kerb, m, and in which steps, m. Choices: people still
# see the place that OSM has as part of it.
_MOST_TO_KERBS: Final = 2.0
_KERB_STEP: Final = 1.0
# Crossings one behind the other that share more of the shorter are one; a choice.
_SHARED: Final = 0.5

# OpenDRIVE's type and subtype, and a name; height and radius, m. Heads hang at 2.1 m and more (RiLSA), booms turn on
# machines of about 1.1 m; radii are choices.
_LIGHT: Final = (("pole", "", "level crossing light"), 3.0, 0.15)
_RAIL_BARRIER: Final = (("barrier", "", "level crossing barrier"), 1.1, 0.2)
# Lights stand this far behind the sign, as traffic meets them, barriers twice as far, m; a choice.
_BEHIND_SIGN: Final = 0.8


@record
class _Way:
    """A road on whose course a crossing lies."""

    road: int  # Id
    s: float  # m; beyond the road's ends in a junction
    place: NodePlace

    def beyond(self, world: World) -> float:
        """How far beyond the road's ends it lies, m."""
        return max(-self.s, self.s - world.lanes.length(self.road), 0.0)


@record
class _Placed:
    """A crossing on its road."""

    crossing: Crossing
    moved: float  # How far it was moved along the road, m
    width_tagged: bool  # Whether OSM gives a width


def find_crossings(world: World) -> tuple[Crossing, ...]:
    """Place the crossings of streets on roads, in the order of roads and s.

    Crossings in a junction go to the straightest connecting road there; to the arm that they cross if there is none.
    """
    crossings = world.network.node_facts.crossings
    on_streets = world.nodes.on_streets(mapped.node for mapped in crossings)
    ways = {item.node: _nearest(world, item, here) for item in crossings if (here := on_streets.get(item.node))}
    inside = {
        junction
        for way in ways.values()
        if way is not None and (junction := _junction_beyond(world, way)) is not None
    }
    nodes = np.array([(here[0].x, here[0].y) for here in on_streets.values()]).reshape(-1, 2)
    paths = JunctionPaths(world, inside, nodes)
    found: list[_Placed] = []
    for mapped in crossings:
        if mapped.node not in ways:
            continue
        placed = _placed(world, paths, mapped, ways[mapped.node])
        if isinstance(placed, str):
            words = f"the crossing is left out: {placed}"
            world.diagnostics.dropped("crossing-left-out", f"node/{mapped.node}", words)
        else:
            found.append(placed)
    out = _joined(world, found)
    _report(world, out)
    return tuple(sorted((item.crossing for item in out), key=lambda item: (item.road, item.s)))


def _placed(world: World, paths: JunctionPaths, mapped: MappedCrossing, way: _Way | None) -> _Placed | str:
    """Put a crossing on a road, or return why it is on none."""
    # As tagged, else usual
    usual = defaults.CROSSING_WIDTH_SIGNALS if mapped.lights else defaults.CROSSING_WIDTH
    width = usual if mapped.width is None else max(mapped.width, defaults.CROSSING_WIDTH_MIN)
    back = 0.0
    if way is not None:
        at, own_width = with_room_for_line(world, way.road, way.s, width)
        if at != way.s:
            placed = _on_arm(world, mapped, replace(way, s=at), own_width, back)
            return replace(placed, moved=abs(at - way.s)) if isinstance(placed, _Placed) else placed
    if way is not None and (junction := _junction_beyond(world, way)) is not None:
        course, back = _course(world, paths, junction, mapped, way, width)
        back, span = _on_pavement(paths, junction, course, back, way.beyond(world))
        if span is not None and span.left - span.right >= _NARROWEST_CARRIAGEWAY:
            return _in_junction(mapped, way, (span, back, width), junction)
    if way is None or way.beyond(world) > defaults.CROSSING_REACH:
        return f"it lies in a junction, more than {defaults.CROSSING_REACH:g} m from every road that it could cross"
    return _on_arm(world, mapped, way, width, back)


def _on_arm(world: World, mapped: MappedCrossing, way: _Way, width: float, back: float) -> _Placed | str:
    """Put a crossing on a road outside junctions, or return why it cannot be."""
    road, s, length = world.lanes.road(way.road), way.s, world.lanes.length(way.road)
    room = 0.5 * width + _FROM_END
    # Before a junction it may lie partly in it.
    first, last = (
        0.0 if link is not None and link.to_junction else min(room, 0.5 * length)
        for link in (road.predecessor, road.successor)
    )
    if back < way.beyond(world):
        # Nothing crosses the junction where it lies.
        first = last = min(room, 0.5 * length)
    else:
        s += back if s < 0.0 else -back
    at = min(max(s, first), length - last)
    left, right = world.lanes.carriageway(way.road, at)
    if left - right < _NARROWEST_CARRIAGEWAY:
        return "the road there has no carriageway"
    osm_id, marking = f"node/{mapped.node}", mapped.marking
    crossing = Crossing(
        way.road, at, width, left, right, osm_id, mapped.lights, marking=marking, island=mapped.island
    )
    return _Placed(_at_junction(world, crossing), abs(at - way.s), mapped.width_tagged)


def _in_junction(mapped: MappedCrossing, way: _Way, found: tuple[Span, float, float], junction: int) -> _Placed:
    """Put a crossing on a connecting road: on its span, so far back towards its arm, of a width, m."""
    span, back, width = found
    at_end = way.s > 0.0
    crossing = Crossing(
        *(span.road, span.s, width, span.left, span.right, f"node/{mapped.node}", mapped.lights),
        at_start=not at_end,
        at_end=at_end,
        marking=mapped.marking,
        island=mapped.island,
        skew=span.skew,
        junction=junction,
        arm=(way.road, way.s - back if at_end else way.s + back),
    )
    return _Placed(crossing, back, mapped.width_tagged)


def _course(
    world: World, paths: JunctionPaths, junction: int, mapped: MappedCrossing, way: _Way, width: float
) -> tuple[Course, float]:
    """Return where a crossing leads over a junction, and how far it was moved back towards its arm for that, m."""
    place = way.place
    arms = world.nodes.arms.get(junction, ())
    arm = next((item for item in arms if item.road == way.road and item.at_end == (way.s > 0.0)), None)
    hdg = place.hdg
    if arm is not None:
        away = arm.hdg if arm.at_end else arm.hdg + pi
        hdg = hdg if cos(hdg - away) > 0.0 else hdg + pi
    course = Course(place.x, place.y, hdg, across_of(hdg, mapped.heading))
    length = world.lanes.length(way.road)
    left, right = world.lanes.carriageway(way.road, min(max(way.s, 0.0), length))
    beyond = way.beyond(world)
    back = paths.clear_of_through_traffic(junction, course, (0.5 * width, 0.5 * (left - right)), beyond)
    if back is None:
        back = beyond + 0.5 * width
    return replace(course, x=place.x - back * cos(hdg), y=place.y - back * sin(hdg)), back


def _on_pavement(
    paths: JunctionPaths, junction: int, course: Course, back: float, beyond: float
) -> tuple[float, Span | None]:
    """Return how far back towards its arm a crossing lies, m, and its span there; none where that is on the arm.

    Where it would end in another arm's mouth, it goes on towards its own arm until it leads from kerb to kerb, if
    that is near.
    """
    first: Span | None = None
    for k in range(int(_MOST_TO_KERBS / _KERB_STEP) + 1):
        more = k * _KERB_STEP
        if back + more >= beyond:
            return back + more, None
        x, y = course.x - more * cos(course.hdg), course.y - more * sin(course.hdg)
        span = paths.span(junction, replace(course, x=x, y=y))
        if span is not None and span.to_kerbs:
            return back + more, span
        if k == 0:
            first = span
    return back, first


def _junction_beyond(world: World, way: _Way) -> int | None:
    """Return the id of the junction in which a place beyond a road's end lies; None for places on the road."""
    road = world.lanes.road(way.road)
    link = road.predecessor if way.s < 0.0 else road.successor if way.s > world.lanes.length(way.road) else None
    return link.id if link is not None and link.to_junction else None


def _nearest(world: World, mapped: MappedCrossing, here: Sequence[NodePlace]) -> _Way | None:
    """Return the road on whose course a crossing lies; None where there is none."""
    keys: list[tuple[float, float, int, float, NodePlace]] = []
    for place in here:
        # Where streets meet, the direction of the way that crosses shows which one it crosses.
        along = 0.0 if mapped.heading is None or len(here) == 1 else abs(cos(mapped.heading - place.hdg))
        for road, s in _candidates(world, place):
            keys.append((along, max(-s, s - world.lanes.length(road), 0.0), road, s, place))
    best = min(keys, key=lambda key: key[:4], default=None)
    return None if best is None else _Way(best[2], best[3], best[4])


def _candidates(world: World, place: NodePlace) -> list[tuple[int, float]]:
    """Return the roads to which a place may go, and s there, which may lie beyond the road's ends."""
    if place.road >= 0:
        return [(place.road, place.s)]
    arms = [item for item in world.nodes.arms.get(place.junction, ()) if abs(sin(item.hdg - place.hdg)) <= _ARM_SINE]
    off = [hypot(place.x - arm.x, place.y - arm.y) for arm in arms]
    length = world.lanes.length
    return [(arm.road, length(arm.road) + far if arm.at_end else -far) for arm, far in zip(arms, off, strict=True)]


def _at_junction(world: World, crossing: Crossing) -> Crossing:
    """Mark the junction at which a crossing lies if no car fits between, rather one to which traffic comes."""
    most = defaults.AT_JUNCTION_WITH_LIGHTS if crossing.signals else defaults.ROOM_FOR_CAR
    road, to_end = world.lanes.road(crossing.road), world.lanes.length(crossing.road) - crossing.s
    ends = []
    for at_end, link, distance in ((False, road.predecessor, crossing.s), (True, road.successor, to_end)):
        if link is not None and link.to_junction and distance - 0.5 * crossing.width <= most:
            comes = bool(car_lanes(world, crossing.road, crossing.s, along=at_end))
            ends.append((distance + (0.0 if comes else defaults.ROOM_FOR_CAR), at_end))
    nearest = min(ends)[1] if ends else None
    return replace(crossing, at_start=nearest is False, at_end=nearest is True)


def _one(world: World, one: _Placed, other: _Placed) -> _Placed:
    """Merge two crossings: the one with lights is kept, else the one that was moved less."""
    kept, gone = sorted((one, other), key=lambda item: (not item.crossing.signals, item.moved))
    words = f"the crossing overlaps that of {kept.crossing.osm_id}: both become one"
    world.diagnostics.note("crossing-merged", gone.crossing.osm_id, words)
    return replace(kept, crossing=replace(kept.crossing, island=one.crossing.island or other.crossing.island))


def _joined(world: World, found: Sequence[_Placed]) -> list[_Placed]:
    """Merge crossings of one road, or in or at one junction, that lie upon each other."""
    out: list[_Placed] = []
    here: dict[tuple[bool, int], list[int]] = defaultdict(list)
    for item in sorted(
        found, key=lambda item: (item.crossing.junction >= 0, item.crossing.on_course, item.crossing.osm_id)
    ):
        crossing, junction = item.crossing, item.crossing.junction
        road = world.lanes.road(crossing.on_course[0])
        link = road.successor if crossing.at_end else road.predecessor if crossing.at_start else None
        if junction < 0 and link is not None and link.to_junction:
            junction = link.id
        keys = [(True, junction)] * (junction >= 0) + [(False, crossing.on_course[0])] * (crossing.junction < 0)
        same = next((k for k in here[keys[-1]] if _overlap(world, out[k].crossing, crossing)), None)
        if same is None:
            for key in keys:
                here[key].append(len(out))
            out.append(item)
        else:
            out[same] = _one(world, out[same], item)
    return out


def _overlap(world: World, one: Crossing, other: Crossing) -> bool:
    """Return whether two crossings lie upon each other."""
    ends = _ends(world, one), _ends(world, other)
    axis, others_axis = ((left - right) / max(abs(left - right), 1e-9) for left, right in ends)
    if abs((axis * others_axis.conjugate()).imag) > _ARM_SINE:
        return False
    seen = [[(end - ends[0][0]) * axis.conjugate() for end in pair] for pair in ends]
    off = abs(sum(z.imag for z in seen[0]) - sum(z.imag for z in seen[1])) * 0.5
    (a, b), (c, d) = (sorted(z.real for z in pair) for pair in seen)
    return off < 0.5 * (one.width + other.width) and min(b, d) - max(a, c) > _SHARED * min(b - a, d - c)


def _ends(world: World, crossing: Crossing) -> tuple[complex, complex]:
    """Return the ends of a crossing's middle line, x + iy, m."""
    curve = np.array([world.lanes.index(crossing.road)])
    (x,), (y,), (hdg,) = pose(world.road_map.plan_view, curve, np.array([crossing.s]))
    along, middle = complex(cos(hdg), sin(hdg)), 0.5 * (crossing.left + crossing.right)
    left, right = (complex(crossing.skew * (t - middle), t) for t in (crossing.left, crossing.right))
    return complex(x, y) + along * left, complex(x, y) + along * right


def _report(world: World, placed: Sequence[_Placed]) -> None:
    """Report what was moved and what was guessed."""
    for item in placed:
        if item.moved > defaults.CROSSING_WIDTH:
            words = f"the crossing lies in a junction and was moved towards the road, by {item.moved:.1f} m"
            world.diagnostics.repaired("crossing-moved", item.crossing.osm_id, words)
    usual, with_lights = defaults.CROSSING_WIDTH, defaults.CROSSING_WIDTH_SIGNALS
    finding = f"without a width: {with_lights:g} m assumed with lights, {usual:g} m otherwise"
    guessed = [item.crossing.osm_id for item in placed if not item.width_tagged]
    world.diagnostics.count(Kind.GUESSED, "crossing-width", guessed, "crossing", finding)


def rail_crossing_objects(world: World, stops: Sequence[RailStop]) -> list[RoadObject]:
    """Make the lights and barriers before railways that tags name, on the side of the traffic that they are for.

    Barriers that close the whole road have a second one on its other side.
    """
    out: list[RoadObject] = []
    for stop in stops:
        near = -1.0 if stop.along == (world.road_map.rule is Rule.RIGHT_HAND) else 1.0
        if stop.crossing.lights:
            out.append(_beside(world, stop, near, 1, _LIGHT))
        if stop.crossing.barriers:
            out.append(_beside(world, stop, near, 2, _RAIL_BARRIER))
        if stop.crossing.barriers == "full":
            out.append(_beside(world, stop, -near, 2, _RAIL_BARRIER))
    return out


def _beside(
    world: World, stop: RailStop, side: float, steps: int, what: tuple[tuple[str, str, str], float, float]
) -> RoadObject:
    words, height, radius = what
    s = stop.s + steps * (_BEHIND_SIGN if stop.along else -_BEHIND_SIGN)
    s = min(max(s, 0.0), world.lanes.length(stop.road))
    left, right = world.lanes.carriageway(stop.road, s)
    t = (left if side > 0.0 else right) + side * (defaults.SIGN_CLEARANCE + radius)
    made = world.object_at(stop.road, words, s, t, stop.osm_id)
    return replace(made, height=height, radius=radius, orientation="+" if stop.along else "-")
