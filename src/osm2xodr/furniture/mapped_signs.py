"""Where the signs stand that OSM maps as ``traffic_sign=*``, on nodes of streets and beside them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from osm2xodr import defaults
from osm2xodr.curve_finder import CurveFinder
from osm2xodr.curves import pose
from osm2xodr.furniture.approaches import car_lanes
from osm2xodr.furniture.node_places import NodePlace, NodePlaces
from osm2xodr.furniture.sign_directions import LimitsAround, TownSide, comes_to, compass_heading, faced_along
from osm2xodr.furniture.sign_nodes import KINDS, YieldSigns
from osm2xodr.furniture.sign_posts import Post
from osm2xodr.furniture.sign_room import curves_near
from osm2xodr.furniture.traffic_sign_tags import SignFace, directed_values, read_faces
from osm2xodr.furniture.world import World
from osm2xodr.model import RoadsideKind, RoadsideThing, Rule

# Signs of ways for people on foot or bicycles.
_PATHS: Final = frozenset({"footway", "cycleway", "foot_and_cycleway", "footway_beside_cycleway", "bridleway"})
_BACK: Final = {"city_limit": "city_limit_end", "city_limit_end": "city_limit"}


@dataclass(frozen=True, slots=True)
class _Spot:
    """A place on a road: t where OSM says so, and the direction of traffic that a sign there is for, if known."""

    road: int
    s: float
    t: float | None
    along: bool | None
    limits: LimitsAround


def add_mapped_signs(world: World, places: NodePlaces, yielding: YieldSigns) -> list[Post]:
    """Return the poles of all mapped signs but stop and give-way signs, which go to the others of that kind.

    Parameters
    ----------
    world, places
        What is there.
    yielding
        The stop and give-way signs.
    """
    reader = _Reader(world, yielding)
    tags = world.network.node_tags
    signed = [node for node, item in tags.items() if any(True for _ in directed_values(item))]
    meeting = {item.osm_node_id for item in world.network.intersections if len(item.arms) > 1}
    for node, found in sorted(places.on_streets(signed).items()):
        reader.on_street(node, tags[node], found, meets=node in meeting)
    things = [item for item in world.network.roadside if item.kind is RoadsideKind.TRAFFIC_SIGN]
    for thing, spots in _beside(world, things):
        reader.beside(thing, spots)
    _count_ways(world)
    return reader.posts


class _Reader:
    """Turns tags of nodes into poles."""

    def __init__(self, world: World, yielding: YieldSigns) -> None:
        self._world = world
        self._yielding = yielding
        self._town = TownSide(world.network.streets)
        self.posts: list[Post] = []

    def on_street(self, node: int, tags: Mapping[str, str], found: Sequence[NodePlace], *, meets: bool) -> None:
        """Read the signs of a node of streets."""
        osm_id = f"node/{node}"
        yields = tags.get("highway") in KINDS
        values = [(word, self._faces(text, tags, word, but_yielding=yields)) for word, text in directed_values(tags)]
        if not any(faces for _, faces in values):
            if not yields:
                self._leave_out(osm_id, "what it means is not known, or it is not for cars")
            return
        street = self._world.network.streets[found[0].street]
        for word, faces in values:
            limits = LimitsAround.at(street, node)
            spot = self._in_junction(node, found[0]) if meets or found[0].road < 0 else None
            if spot is None and (meets or found[0].road < 0):
                self._leave_out(osm_id, "it stands on a junction and does not say for which of its roads")
                return
            if spot is None:
                length = self._world.lanes.length(found[0].road)
                s = min(max(found[0].s, 0.0), length)
                spot = _Spot(found[0].road, s, None, limits.along(word), limits)
            self._place(osm_id, tags, faces, spot)

    def _in_junction(self, node: int, place: NodePlace) -> _Spot | None:
        """Return the end of the only road from which cars come to a node in a junction; None for several."""
        network = self._world.network
        if place.road < 0 and node not in (network.streets[place.street].node_ids[[0, -1]]).tolist():
            runs = LimitsAround.at(network.streets[place.street], node).directions()
            street = network.streets[place.street]
            meeting = (street.start if runs[0] else street.end) if len(runs) == 1 else -1
        else:
            street = network.streets[place.street]
            meeting = street.start if int(street.node_ids[0]) == node else street.end
        if meeting < 0:
            return None
        arms = [2 * street + (not start) for street, start in network.intersections[meeting].arms]
        coming = [end for end in arms if comes_to(network.streets[end // 2], end)]
        road = int(self._world.places.end_road[coming[0]]) if len(coming) == 1 else -1
        if road < 0:
            return None
        at_end = bool(coming[0] % 2)
        limits = LimitsAround.of_end(network.streets[coming[0] // 2], at_end=at_end)
        return _Spot(road, self._world.lanes.length(road) if at_end else 0.0, None, at_end, limits)

    def beside(self, thing: RoadsideThing, spots: Sequence[_Spot]) -> None:
        """Read the signs of a node beside streets."""
        faces: list[SignFace] = []
        kind = thing.tags.get("highway")
        for word, text in directed_values(thing.tags):
            faces += self._faces(text, thing.tags, word, but_yielding=kind in KINDS)
        if kind in KINDS:
            faces.insert(0, SignFace(kind or ""))
        if not faces:
            self._leave_out(thing.osm_id, "what it means is not known, or it is not for cars")
        elif not spots:
            self._leave_out(thing.osm_id, "no road for cars that it faces is near")
        else:
            self._place(thing.osm_id, thing.tags, faces, spots[0])

    def _faces(self, text: str, tags: Mapping[str, str], word: str, *, but_yielding: bool) -> list[SignFace]:
        out: list[SignFace] = []
        wanted = True
        for face in read_faces(text, tags, self._world.network.country, word):
            if not face.supplementary:
                wanted = face.meaning not in _PATHS and not (but_yielding and face.meaning in KINDS)
                wanted = wanted and bool(face.meaning or face.code)
            if wanted:
                out.append(face)
        return out

    def _place(self, osm_id: str, tags: Mapping[str, str], faces: Sequence[SignFace], spot: _Spot) -> None:
        """Make the poles of signs at a place, for each direction that they are for."""
        by_direction: dict[bool, list[SignFace]] = {True: [], False: []}
        main_along: tuple[bool, ...] = ()
        lost = ""
        for face in faces:
            if face.supplementary:
                for along in main_along:
                    by_direction[along].append(face)
                continue
            meant = self._meant(osm_id, face, tags, spot)
            main_along = tuple(along for along, _ in meant)
            lost = lost if meant else "neither its tags nor what is around tell which direction it is for"
            for along, one in meant:
                by_direction[along].append(one)
        for along, found in by_direction.items():
            if found:
                lost = self._post(osm_id, spot, along, found) or lost
        if lost:
            self._leave_out(osm_id, lost)

    def _post(self, osm_id: str, spot: _Spot, along: bool, faces: Sequence[SignFace]) -> str:
        """Make one pole, or say why not."""
        any_way = any(face.meaning == "no_entry" for face in faces)
        if not car_lanes(self._world, spot.road, spot.s, along) and not any_way:
            return "no lane for cars leads that way"
        yields = [face for face in faces if face.meaning in KINDS]
        others = tuple(face for face in faces if face.meaning not in KINDS)
        for face in yields:
            self._yielding.add([self._yielding.nearest(spot.road, spot.s, along, face.meaning, osm_id)])
        if others and any(not face.supplementary for face in others):
            self.posts.append(Post(spot.road, spot.s, along, others, osm_id, spot.t))
        return ""

    def _meant(
        self, osm_id: str, face: SignFace, tags: Mapping[str, str], spot: _Spot
    ) -> list[tuple[bool, SignFace]]:
        """Return which directions a sign is for, and what it says to each."""
        country = self._world.network.country
        if face.meaning in _BACK:
            return self._city_limits(osm_id, face, tags, spot)
        if face.meaning == "maxspeed":
            meant = spot.limits.limited(face, country) if spot.along is None else [spot.along]
            said = [(along, spot.limits.with_value(face, along, country)) for along in meant]
            return [(along, one) for along, one in said if one.value is not None]
        if spot.along is not None:
            return [(spot.along, face)]
        if face.meaning in KINDS:
            return [(spot.limits.nearer_end(), face)]
        return [(along, face) for along in spot.limits.directions()]

    def _city_limits(
        self, osm_id: str, face: SignFace, tags: Mapping[str, str], spot: _Spot
    ) -> list[tuple[bool, SignFace]]:
        """Return what the sign of a town says to those who enter and to those who leave it.

        Where tags do not say where the town lies, it lies where limits are lower, or else where more streets are.
        """
        word = tags.get("city_limit", "")
        ends = face.meaning == "city_limit_end" or word == "end"
        begin = replace(face, meaning="city_limit", code="", country="")
        end = replace(begin, meaning="city_limit_end")
        runs = spot.limits.directions()
        into: bool | None = None
        if spot.along is not None and (word or face.code or len(runs) > 1):
            into = spot.along != ends
        if into is None:
            into = spot.limits.into_town()
        if into is None:
            into = self._town.ahead(spot.limits)
            if into is not None:
                words = "the town is taken to lie on the side of its sign where more streets are"
                self._world.diagnostics.guessed("town-side", osm_id, words)
        if into is None:
            return []
        out = [] if ends else [(into, begin)]
        if ends or (word != "begin" and not face.code):
            out.append((not into, end))
        return [(along, one) for along, one in out if along in runs]

    def _leave_out(self, osm_id: str, why: str) -> None:
        self._world.diagnostics.dropped("sign-left-out", osm_id, f"the sign is left out: {why}")


def _beside(world: World, things: Sequence[RoadsideThing]) -> Iterator[tuple[RoadsideThing, list[_Spot]]]:
    """Yield signs beside streets with the roads that they may be for, the nearest first."""
    if not things:
        return
    plan = world.road_map.plan_view
    x, y = np.array([item.points[0] for item in things]).T
    near = curves_near(plan, x, y)
    finder = CurveFinder(plan, near[near < len(world.places.road_street)])
    point, curve, s, t, distance = finder.near(x, y, defaults.SIGN_ASIDE)
    hdg = pose(plan, curve, s)[2]
    rows = np.lexsort((curve, distance, point)).tolist()
    spots: list[list[_Spot]] = [[] for _ in things]
    for k in rows:
        thing = things[int(point[k])]
        spot = _spot(world, thing, int(curve[k]), (float(s[k]), float(t[k]), float(hdg[k])))
        if spot is not None:
            spots[int(point[k])].append(spot)
    yield from zip(things, spots, strict=True)


def _spot(world: World, thing: RoadsideThing, curve: int, place: tuple[float, float, float]) -> _Spot | None:
    """Return where a sign stands on a road; None where it cannot be for its traffic."""
    s, t, hdg = place
    road = world.road_map.roads[curve].id
    street = world.network.streets[int(world.places.road_street[curve])]
    limits = LimitsAround.near(street, float(thing.points[0, 0]), float(thing.points[0, 1]))
    runs = limits.directions()
    heading = compass_heading(thing.tags)
    along = None if heading is None else faced_along(heading, hdg)
    if heading is not None and along is None:
        return None
    if along is None:
        on_right = t < 0.0
        along = on_right == (world.road_map.rule is Rule.RIGHT_HAND) if len(runs) > 1 else runs[0]
    return _Spot(road, s, t, along, limits)


def _count_ways(world: World) -> None:
    """Say how many ways name signs: they have no place, and other tags say what they mean."""
    ways = {item.osm_way_id for street in world.network.streets for _, item in street.pieces if item.traffic_sign}
    if ways:
        words = f"{len(ways)} ways name signs in traffic_sign: they have no place along the way and are not drawn"
        world.diagnostics.note("signs-of-ways", "", words)
