"""Signs that say who yields: of ``highway=stop`` and ``highway=give_way``, and mapped signs with these meanings.

Where the map has none, such signs are made for readers that know nothing else about the right of way.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cached_property
from typing import Final

import numpy as np

from osm2xodr.conventions import meant_ends
from osm2xodr.defaults import SIGN_REACH
from osm2xodr.diagnostics import Kind, counted
from osm2xodr.furniture import defaults
from osm2xodr.furniture.signs.directions import Spot, cars_at_end
from osm2xodr.furniture.signs.posts import Post
from osm2xodr.furniture.world import (
    Approach,
    Crossing,
    NodePlace,
    Stop,
    World,
    before_crossings,
    car_lanes,
    crossings_on_course,
)
from osm2xodr.model import Intersection, NodeControl, Sign, Signal, SignFace
from osm2xodr.system import record

KINDS: Final = (Sign.STOP.value, Sign.GIVE_WAY.value)

# Signs that such readers know, by whether their traffic goes first.
_GOES_FIRST: Final = {"priority_next": True, "priority_road": True, "give_way": False}


@record
class YieldSign:
    """A stop or give-way sign for one direction of a road."""

    kind: str  # ``stop`` or ``give_way``
    road: int  # Id of the road
    s: float  # Where traffic has to stop or yield, m
    along: bool  # Its direction: whether along s
    osm_id: str  # The node
    approach: Approach | None = None  # The approach that it is for; None apart from junctions
    all_way: bool = False  # Whether all approaches of the junction have to stop


class YieldSigns:
    """Collects stop and give-way signs, one for each approach, and reports the nodes that give none."""

    def __init__(self, world: World, approaches: Sequence[Approach], crossings: Sequence[Crossing] = ()) -> None:
        self._world = world
        self._crossings = crossings
        self._on_course = crossings_on_course(crossings)
        self._by_end = {item.street_end: item for item in approaches}
        self._at = {(item.road, item.at_end): item for item in approaches}
        self._found: dict[tuple[int, bool, float | None], YieldSign] = {}

    @cached_property
    def _meeting(self) -> Mapping[int, Intersection]:
        return {item.osm_node_id: item for item in self._world.network.intersections}

    @cached_property
    def _minor_roads(self) -> Mapping[int, frozenset[int]]:
        """Roads that only yield at a junction and never go first, by junction."""
        out: dict[int, frozenset[int]] = {}
        for junction in self._world.road_map.junctions:
            incoming = {item.connecting_road: item.incoming_road for item in junction.connections}
            high = {incoming[one] for one, _ in junction.priorities}
            low = {incoming[other] for _, other in junction.priorities}
            out[junction.id] = frozenset(low - high)
        return out

    @cached_property
    def _rings(self) -> frozenset[tuple[int, int]]:
        """Junctions, and roads of roundabouts that lead to them."""
        streets = self._world.network.streets
        return frozenset(
            (item.junction, item.road)
            for item in self._by_end.values()
            if streets[item.street_end // 2].attributes_at_end(item.street_end).roundabout
        )

    @cached_property
    def _yielding_to_rings(self) -> frozenset[tuple[int, int]]:
        """Junctions and roads of which some traffic yields to that of a roundabout."""
        ring = {road for _, road in self._rings}
        found: set[tuple[int, int]] = set()
        for junction in self._world.road_map.junctions:
            incoming = {item.connecting_road: item.incoming_road for item in junction.connections}
            pairs = ((incoming[high], incoming[low]) for high, low in junction.priorities)
            found |= {(junction.id, low) for high, low in pairs if high in ring and low not in ring}
        return frozenset(found)

    def add_nodes(self) -> None:
        """Add the signs of the nodes on streets."""
        controls = self._world.network.node_facts.controls
        nodes = [node for node, item in controls.items() if item.tagged in (Sign.STOP, Sign.GIVE_WAY)]
        for node, found in sorted(self._world.nodes.on_streets(nodes).items()):
            signs = self._signs(node, controls[node], found)
            if isinstance(signs, str):
                self._leave_out(f"node/{node}", signs)
            else:
                for sign in signs:
                    self.add(sign)

    def add_at_roundabouts(self, signalled: Collection[tuple[int, bool]]) -> None:
        """Add give-way signs where traffic enters roundabouts and mini roundabouts, unless there is a sign or light.

        Approaches with lights are `signalled`, as (road, whether at its end).
        """
        streets, minis = self._world.network.streets, self._world.network.node_facts.mini_roundabouts
        small = {
            item.id: f"node/{node}"
            for item in self._world.road_map.junctions
            for node in sorted(minis.intersection(item.osm_node_ids))
        }
        places = self._world.places
        # Roundabouts that a junction has taken in: all of its arms enter them.
        inside = {
            int(places.end_junction[2 * street])
            for street in np.flatnonzero(places.inner).tolist()
            if streets[street].attributes_at_end(0).roundabout
        } - {junction for junction, _ in self._rings}
        added: list[str] = []
        for item in self._by_end.values():
            enters = item.junction in inside or (item.junction, item.road) in self._yielding_to_rings
            known = (item.road, item.at_end) in signalled or (item.road, item.at_end, None) in self._found
            if not known and (enters or item.junction in small):
                way = streets[item.street_end // 2].attributes_at_end(item.street_end).osm_way_id
                added.append(f"way/{way}")
                self.add(self._of(item, Sign.GIVE_WAY.value, small.get(item.junction, added[-1])))
        words = "into a roundabout without a sign in OSM: give-way signs are assumed"
        self._world.diagnostics.count(Kind.GUESSED, "yield-sign", added, "road", words)

    def add(self, sign: YieldSign) -> None:
        """Add a sign; of several for one approach the first is kept, but a stop sign rather than a give-way sign."""
        key = (sign.road, sign.along, None if sign.approach else sign.s)
        old = self._found.get(key, sign)
        kept, lost = (sign, old) if (sign.kind, old.kind) == KINDS else (old, sign)
        self._found[key] = kept
        if lost.osm_id != kept.osm_id:
            self._leave_out(lost.osm_id, f"{kept.osm_id} has the sign of that approach")

    def nearest(self, road: int, s: float, along: bool, kind: str, osm_id: str) -> YieldSign:
        """Return the sign for one that stands beside a road at s, m: that of the approach if it is near."""
        approach = self._at.get((road, along))
        length = self._world.lanes.length(road)
        if approach is not None and (length - s if along else s) <= SIGN_REACH:
            return YieldSign(kind, road, approach.stop_s, along, osm_id, approach)
        margin = min(0.5 * length, defaults.STOP_LINE_SETBACK)
        at = min(max(s, margin), length - margin)
        stop = before_crossings(length - at if along else at, length, self._on_course.get(road, ()), at_end=along)
        return YieldSign(kind, road, length - stop if along else stop, along, osm_id)

    def ahead(self, spot: Spot, along: bool) -> float | None:
        """Return the distance from a sign beside a road to the junction, crossing or railway ahead of it, m.

        None where there is none within reach.
        """
        length = self._world.lanes.length(spot.road)
        found = [abs(at - spot.s) for at in self._crossed.get(spot.road, ()) if (at > spot.s) == along]
        if (spot.road, along) in self._at:
            found.append(length - spot.s if along else spot.s)
        near = [distance for distance in found if distance <= SIGN_REACH]
        return min(near) if near else None

    @cached_property
    def _crossed(self) -> Mapping[int, list[float]]:
        """Where people and railways cross roads: s by road, m."""
        out: dict[int, list[float]] = defaultdict(list)
        for crossing in self._crossings:
            road, s = crossing.on_course
            out[road].append(s)
        places, tracks = self._world.places, self._world.network.node_facts.track_crossings
        for node, road, s in zip(places.node.tolist(), places.road.tolist(), places.s.tolist(), strict=True):
            if road >= 0 and node in tracks:
                out[road].append(s)
        return out

    def _leave_out(self, osm_id: str, why: str) -> None:
        self._world.diagnostics.dropped("sign-left-out", osm_id, f"the sign is left out: {why}")

    def _signs(self, node: int, control: NodeControl, found: Sequence[NodePlace]) -> list[YieldSign] | str:
        """Return the signs of a node, or why there are none."""
        meeting = self._meeting.get(node)
        if meeting is not None and len(meeting.arms) > 1:
            return self._at_intersection(meeting, control)
        out: list[YieldSign] = []
        why = ""
        for place in found:
            street = self._world.network.streets[place.street]
            for end in meant_ends(street, street.place_of(node), control.facing):
                signs = self._inside_street(place, end, control)
                if isinstance(signs, str):
                    why = signs
                else:
                    out += signs
        return out or why

    def _inside_street(self, place: NodePlace, end: int, control: NodeControl) -> list[YieldSign] | str:
        """Return the signs of a node inside a street that are for those who come to one of its ends."""
        osm_id = f"node/{place.node}"
        kind = _kind(control)
        if place.road < 0:
            inner = self._world.network.streets[place.street]
            arms = self._leading_into(2 * place.street + end, inner.start if end else inner.end)
            if not arms:
                return "it stands inside a junction, on a way that no single road leads into"
            return [self._of(arm, kind, osm_id) for arm in arms]
        sign = self.nearest(place.road, place.s, bool(end), kind, osm_id)
        lanes = car_lanes(self._world, sign.road, sign.s, sign.along)
        return [sign] if lanes else "no lane for cars leads that way"

    def _leading_into(self, end: int, start_node: int) -> list[Approach]:
        """Return the approaches from which a street inside a junction is the only way on."""
        streets = self._world.network.streets
        arms = [2 * street + (not start) for street, start in self._world.network.intersections[start_node].arms]
        left = [other for other in arms if cars_at_end(streets[other // 2], other)[1]]
        coming = [arm for arm in arms if arm in self._by_end and arm != end ^ 1]
        return [self._by_end[arm] for arm in coming if [other for other in left if other != arm] == [end ^ 1]]

    def _at_intersection(self, meeting: Intersection, control: NodeControl) -> list[YieldSign] | str:
        """Return the signs of a node where streets meet."""
        ends = [2 * street + (not start) for street, start in meeting.arms]
        junctions = {int(self._world.places.end_junction[end]) for end in ends} - {-1}
        here = [self._by_end[end] for end in ends if end in self._by_end]
        here = here or [item for item in self._by_end.values() if item.junction in junctions]
        if not here:
            return "no road with lanes for cars comes to that junction"
        meant = here if control.all_way or len(here) == 1 else self._yielding(here)
        if not meant:
            return "it stands on a junction of equal roads and does not say for which of them"
        kind, osm_id = _kind(control), f"node/{meeting.osm_node_id}"
        return [self._of(item, kind, osm_id, all_way=control.all_way) for item in meant]

    def _yielding(self, here: Sequence[Approach]) -> list[Approach]:
        """Return the approaches that yield by the junction's priorities; none where that are all of them."""
        minor = [item for item in here if item.road in self._minor_roads[item.junction]]
        return minor if len(minor) < len(here) else []

    def _of(self, item: Approach, kind: str, osm_id: str, *, all_way: bool = False) -> YieldSign:
        return YieldSign(kind, item.road, item.stop_s, item.at_end, osm_id, item, all_way)

    def posts(self) -> list[Post]:
        """Return the posts of all signs."""
        out = []
        for sign in self._found.values():
            faces = [SignFace(sign.kind)]
            if sign.all_way and sign.kind == "stop" and self._world.network.country == "US":
                faces.append(SignFace("all_way", "US", "R1-3P", supplementary=True))
            s = min(max(sign.s, 0.0), self._world.lanes.length(sign.road))
            out.append(Post(sign.road, s, sign.along, tuple(faces), sign.osm_id))
        return out

    def stops(self, signalled: frozenset[tuple[int, bool]]) -> list[Stop]:
        """Return where traffic stops or yields, except on the approaches with lights."""
        out: list[Stop] = []
        for sign in self._found.values():
            approach = sign.approach
            if approach is not None and (approach.road, approach.at_end) in signalled:
                continue
            lanes = approach.lanes if approach else car_lanes(self._world, sign.road, sign.s, sign.along)
            out.append(Stop(sign.road, sign.s, lanes, "+" if sign.along else "-", sign.kind, sign.osm_id))
        return sorted(out, key=lambda stop: (stop.road, stop.s, stop.orientation))


def _kind(control: NodeControl) -> str:
    assert control.tagged is not None
    return control.tagged.value


def priority_posts(world: World, approaches: Sequence[Approach], signals: Iterable[Signal]) -> list[Post]:
    """Return posts with the signs that follow from the priorities of junctions and are not there yet.

    An approach that yields to some and goes before others gets none: it ranks between them without a sign. `signals`
    are the signs that the map gives.
    """
    stated = _stated(signals)
    of_connecting = {movement.connecting_road: item for item in approaches for movement in item.movements}
    out: list[Post] = []
    for junction in world.road_map.junctions:
        first, yields = (
            {(item.road, item.at_end): item for road in roads if (item := of_connecting.get(road))}
            for roads in (zip(*junction.priorities, strict=True) if junction.priorities else ((), ()))
        )
        for key in sorted(first.keys() ^ yields.keys()):
            item, goes_first = (first | yields)[key], key in first
            if stated.get(key) is not goes_first:
                face = SignFace("priority_next" if goes_first else "give_way")
                out.append(Post(item.road, item.stop_s, item.at_end, (face,), ""))
    if out:
        words = f"{counted(len(out), 'sign')} added that {world.options.target.name} takes the right of way from"
        world.diagnostics.note("priority-signs", "", words)
    return out


def _stated(signals: Iterable[Signal]) -> dict[tuple[int, bool], bool]:
    """Return what the last sign of each direction of a road says: whether its traffic goes first."""
    out: defaultdict[tuple[int, bool], list[bool]] = defaultdict(list)
    for item in sorted(signals, key=Signal.place_for_traffic):
        if item.name in _GOES_FIRST and not item.dynamic:
            out[item.road, item.orientation == "+"].append(_GOES_FIRST[item.name])
    return {key: found[-1] for key, found in out.items()}
