"""Signs that OSM maps as ``traffic_sign=*``, on nodes of streets and beside them: where they stand, and for whom."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.furniture.signs.directions import (
    Candidate,
    LimitsAround,
    Spot,
    TownSide,
    candidates_beside,
    cars_at_end,
    choose_spot,
    choose_yield,
)
from osm2xodr.furniture.signs.posts import Post, with_plates
from osm2xodr.furniture.signs.stop_and_give_way import KINDS, YieldSigns
from osm2xodr.furniture.world import NodePlace, World, car_lanes
from osm2xodr.model import FacingSigns, RoadsideThing, SignFace, SignPost

# Meanings of signs for people on foot or bicycles.
_PATHS: Final = frozenset({"footway", "cycleway", "foot_and_cycleway", "footway_beside_cycleway", "bridleway"})
# What the back of the sign of a town says.
_BACK: Final = {"city_limit": "city_limit_end", "city_limit_end": "city_limit"}


def mapped_posts(world: World, yield_signs: YieldSigns) -> list[Post]:
    """Return the posts of all mapped signs, and add those that say stop or give way to the others of that kind."""
    reader = _Reader(world, yield_signs)
    sign_posts = world.network.node_facts.sign_posts
    meeting = {item.osm_node_id for item in world.network.intersections if len(item.arms) > 1}
    for node, found in sorted(world.nodes.on_streets(sign_posts).items()):
        reader.on_street(node, sign_posts[node], found, meets=node in meeting)
    things = [(item, item.facts.sign_post) for item in world.network.roadside if item.facts.sign_post is not None]
    for (thing, post), candidates in zip(things, candidates_beside(world, things), strict=True):
        reader.beside(thing, post, candidates)
    _report_ways(world)
    return reader.posts


class _Reader:
    """Turns nodes with signs into posts."""

    def __init__(self, world: World, yield_signs: YieldSigns) -> None:
        self._world = world
        self._yield_signs = yield_signs
        self._town = TownSide(world.network.streets)
        self.posts: list[Post] = []

    def on_street(self, node: int, post: SignPost, found: Sequence[NodePlace], *, meets: bool) -> None:
        """Read the signs of a node of streets."""
        osm_id = f"node/{node}"
        yields = post.control is not None
        values = [(signs.facing, _faces_for_cars(signs, but_yielding=yields)) for signs in post.signs]
        if not any(faces for _, faces in values):
            if not yields:
                self._leave_out(osm_id, "what it means is not known, or it is not for cars")
            return
        street = self._world.network.streets[found[0].street]
        for facing, faces in values:
            limits = LimitsAround.at(street, street.place_of(node))
            if meets or found[0].road < 0:
                spot = self._in_junction(node, found[0])
            else:
                s = min(max(found[0].s, 0.0), self._world.lanes.length(found[0].road))
                spot = Spot(found[0].road, s, None, limits.along(facing), limits)
            if spot is None:
                self._leave_out(osm_id, "it stands on a junction and does not say for which of its roads")
                return
            if not facing.both and self._for_both(faces, spot):
                words = "the sign holds for both directions of its street: no tag says for which"
                self._world.diagnostics.guessed("sign-direction", osm_id, words)
            self._place(osm_id, post, faces, spot)

    def _in_junction(self, node: int, place: NodePlace) -> Spot | None:
        """Return the end of the only road from which cars come to a node in a junction; None for several."""
        network = self._world.network
        street = network.streets[place.street]
        if place.road >= 0 or node in street.node_ids[[0, -1]]:
            meeting = street.start if int(street.node_ids[0]) == node else street.end
        else:
            runs = LimitsAround.at(street, street.place_of(node)).directions()
            if len(runs) != 1:
                return None
            meeting = street.start if runs[0] else street.end
        if meeting < 0:
            return None
        arms = [2 * arm + (not start) for arm, start in network.intersections[meeting].arms]
        coming = [end for end in arms if cars_at_end(network.streets[end // 2], end)[0]]
        road = int(self._world.places.end_road[coming[0]]) if len(coming) == 1 else -1
        if road < 0:
            return None
        at_end = bool(coming[0] % 2)
        street = network.streets[coming[0] // 2]
        limits = LimitsAround.at(street, len(street.points) - 1 if at_end else 0)
        return Spot(road, self._world.lanes.length(road) if at_end else 0.0, None, at_end, limits)

    def beside(self, thing: RoadsideThing, post: SignPost, candidates: Sequence[Candidate]) -> None:
        """Read the signs of a node beside streets."""
        yielding = post.control is not None
        faces = [face for signs in post.signs for face in _faces_for_cars(signs, but_yielding=yielding)]
        if post.control is not None:
            faces.insert(0, SignFace(post.control.value))
        if not faces:
            self._leave_out(thing.osm_id, "what it means is not known, or it is not for cars")
            return
        yields = [face.meaning for face in faces if face.meaning in KINDS]
        if yields:
            spot = choose_yield(candidates, yields[0], self._yield_signs.ahead)
            if not self._world.footway_nodes.isdisjoint(thing.node_ids.tolist()):
                spot = "it stands on a way for people on foot or bicycles"
            if not isinstance(spot, str):
                self._place(thing.osm_id, post, faces, spot)
                return
            self._leave_out(thing.osm_id, spot)
            faces = with_plates(faces, lambda face: face.meaning not in KINDS, first_plates=False)
            if not faces:
                return
        spot = choose_spot(candidates, any_way=any(face.meaning == "no_entry" for face in faces))
        if isinstance(spot, str):
            self._leave_out(thing.osm_id, spot)
        else:
            self._place(thing.osm_id, post, faces, spot)

    def _place(self, osm_id: str, post: SignPost, faces: Sequence[SignFace], spot: Spot) -> None:
        """Make the posts of signs at a place, one for each direction that they are for."""
        by_direction: dict[bool, list[SignFace]] = {True: [], False: []}
        main_along: tuple[bool, ...] = ()
        lost = ""
        for face in faces:
            if face.supplementary:
                for along in main_along:
                    by_direction[along].append(face)
                continue
            meant = self._meant(osm_id, face, post.city_limit, spot)
            main_along = tuple(along for along, _ in meant)
            lost = lost if meant else "neither its tags nor the roads around say which direction it is for"
            for along, one in meant:
                by_direction[along].append(one)
        for along, found in by_direction.items():
            if found:
                lost = self._post(osm_id, spot, along, found) or lost
        if lost:
            self._leave_out(osm_id, lost)

    def _post(self, osm_id: str, spot: Spot, along: bool, faces: Sequence[SignFace]) -> str:
        """Make one post, or return why not."""
        any_way = any(face.meaning == "no_entry" for face in faces)
        if not car_lanes(self._world, spot.road, spot.s, along) and not any_way:
            return "no lane for cars leads that way"
        yields = [face for face in faces if face.meaning in KINDS]
        others = tuple(face for face in faces if face.meaning not in KINDS)
        for face in yields:
            self._yield_signs.add(self._yield_signs.nearest(spot.road, spot.s, along, face.meaning, osm_id))
        if others and any(not face.supplementary for face in others):
            self.posts.append(Post(spot.road, spot.s, along, others, osm_id, spot.t))
        return ""

    def _meant(self, osm_id: str, face: SignFace, city_limit: str, spot: Spot) -> list[tuple[bool, SignFace]]:
        """Return the directions that a sign is for, and what it says to each."""
        country = self._world.network.country
        if face.meaning in _BACK:
            return self._city_limits(osm_id, face, city_limit, spot)
        if face.meaning == "maxspeed":
            meant = spot.limits.limit_directions(face, country) if spot.along is None else [spot.along]
            stated = [(along, spot.limits.with_value(face, along, country)) for along in meant]
            return [(along, one) for along, one in stated if one.value is not None]
        if spot.along is not None:
            return [(spot.along, face)]
        if face.meaning in KINDS:
            return [(spot.limits.nearer_end(), face)]
        return [(along, face) for along in spot.limits.directions()]

    def _for_both(self, faces: Sequence[SignFace], spot: Spot) -> bool:
        """Return whether any of the signs holds for both directions because nothing says for which."""
        if spot.along is not None or len(spot.limits.directions()) < 2:
            return False
        main = [face for face in faces if not face.supplementary and face.meaning not in (*KINDS, *_BACK)]
        country = self._world.network.country
        return any(face.meaning != "maxspeed" or not spot.limits.decide_direction(face, country) for face in main)

    def _city_limits(self, osm_id: str, face: SignFace, word: str, spot: Spot) -> list[tuple[bool, SignFace]]:
        """Return what the sign of a town says to traffic that enters it and to traffic that leaves it.

        Where tags do not say where the town lies, it lies where limits are lower, or else where more streets are.
        """
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
            if into is None:
                return []
            words = "the town is assumed to lie on the side of its sign with more streets"
            self._world.diagnostics.guessed("town-side", osm_id, words)
        out = [] if ends else [(into, begin)]
        if ends or (word != "begin" and not face.code):
            out.append((not into, end))
        return [(along, one) for along, one in out if along in runs]

    def _leave_out(self, osm_id: str, why: str) -> None:
        self._world.diagnostics.dropped("sign-left-out", osm_id, f"the sign is left out: {why}")


def _faces_for_cars(signs: FacingSigns, *, but_yielding: bool) -> list[SignFace]:
    """Return the signs that are for cars, with their plates."""
    unwanted = {*_PATHS, *KINDS} if but_yielding else _PATHS
    return with_plates(signs.faces, lambda face: bool(face.meaning or face.code) and face.meaning not in unwanted)


def _report_ways(world: World) -> None:
    """Report how many ways name signs: these have no place along the way, and other tags say what they mean."""
    ways = {item.osm_way_id for street in world.network.streets for _, item in street.pieces if item.traffic_sign}
    finding = "with traffic_sign=*: signs without a place along the way are not drawn"
    world.diagnostics.count(Kind.NOTE, "signs-of-ways", [f"way/{way}" for way in sorted(ways)], "way", finding)
