"""Posts beside the road, and the signs on them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Final

from osm2xodr.conventions import NO_SUBTYPE, SignCode, sign_code
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.furniture import defaults
from osm2xodr.furniture.world import World, car_lanes, free_of_other_roads, lane_ranges
from osm2xodr.model import LaneType, Rule, Signal, SignFace
from osm2xodr.system import record

# Signs for one direction that are nearer to each other share a post, m; a choice.
_SHARED_POST: Final = 4.0
# How far back, or on, a sign goes that would stand on the lanes of another road, m, in the order of trials; choices.
_STEPS_BACK: Final = (3.0, 6.0, 10.0, 15.0, -3.0, -6.0, -10.0, -15.0)

# Shapes of the Vienna Convention on Road Signs; all others are round.
_SHAPES: Final = {
    "stop": "octagon",
    **dict.fromkeys(
        (
            *("give_way", "priority_next", "hazard", "crossroads", "curve_left", "curve_right", "curves_left"),
            *("curves_right", "steep_down", "steep_up", "bumps", "slippery", "side_wind", "road_narrows"),
            *("road_works", "queues", "two_way", "signals_ahead", "pedestrians", "children", "bicycles"),
            *("animals", "level_crossing_ahead", "crosswalk_ahead", "stop_ahead", "give_way_ahead"),
        ),
        "triangle",
    ),
    **dict.fromkeys(
        (
            *("priority_road", "priority_road_end", "priority_over_oncoming", "parking", "motorway"),
            *("motorway_end", "motorroad", "motorroad_end", "crosswalk", "dead_end", "tunnel", "one_way"),
            *("advisory_speed", "advisory_speed_end", "maxspeed_zone", "maxspeed_zone_end", "pedestrian_zone"),
            *("pedestrian_zone_end",),
        ),
        "square",
    ),
    **dict.fromkeys(("city_limit", "city_limit_end", "living_street", "living_street_end"), "town"),
}
# Lanes on which posts may stand.
_STANDING: Final = frozenset(
    {LaneType.SIDEWALK, LaneType.BORDER, LaneType.CURB, LaneType.NONE, LaneType.MEDIAN, LaneType.SHOULDER}
)


@record
class Post:
    """Signs at one place for one direction."""

    road: int  # Id of the road
    s: float  # m
    along: bool  # Whether they are for traffic along s, else for that against it
    faces: tuple[SignFace, ...]  # The signs, from the top down; each supplementary plate follows its sign
    osm_id: str  # What they come from; empty where no single element is behind them
    t: float | None = None  # Where it stands, m, if OSM says so; else beside the carriageway


def merge_posts(posts: Iterable[Post], diagnostics: Diagnostics) -> list[Post]:
    """Merge posts for one direction that are near each other, and return all in the order of roads.

    A place that is mapped is kept. Of equal signs one is kept; posts with no other sign are reported as left out.
    """
    out: list[Post] = []
    ordered = sorted(posts, key=lambda post: (post.road, post.along, post.s, post.t is None, post.osm_id))
    for _, group in groupby(ordered, key=lambda post: (post.road, post.along)):
        first = len(out)
        for post in group:
            if len(out) > first and post.s - out[-1].s < _SHARED_POST:
                kept = out[-1]
                out[-1] = _with(kept, post)
                if len(out[-1].faces) == len(kept.faces) and post.osm_id != kept.osm_id and post.osm_id[:4] == "node":
                    words = f"the sign is left out: {kept.osm_id} says the same at the same place"
                    diagnostics.dropped("sign-left-out", post.osm_id, words)
            else:
                out.append(post)
    return sorted(out, key=lambda post: (post.road, post.s, post.along))


def _with(one: Post, other: Post) -> Post:
    """Return a post with the signs of another one that it does not have."""
    stated = {_what(face) for face in one.faces}
    added = with_plates(other.faces, lambda face: _what(face) not in stated)
    named = (face if face.osm_id else replace(face, osm_id=other.osm_id) for face in added)
    return replace(one, faces=(*one.faces, *named), t=other.t if one.t is None else one.t)


def with_plates(
    faces: Iterable[SignFace], wanted: Callable[[SignFace], bool], *, first_plates: bool = True
) -> list[SignFace]:
    """Return the wanted signs with their plates; plates above all signs are kept as well if so said."""
    out: list[SignFace] = []
    keep = first_plates
    for face in faces:
        keep = keep if face.supplementary else wanted(face)
        if keep:
            out.append(face)
    return out


def _what(face: SignFace) -> tuple[object, ...]:
    """Return what a sign says; codes matter only where their meaning is not known."""
    return face.meaning or (face.country, face.code), face.value, face.text


def make_signals(world: World, posts: Sequence[Post]) -> tuple[Signal, ...]:
    """Put merged posts where they do not stand on other roads, and make the signals on them."""
    foreign: set[tuple[str, str]] = set()
    out: list[Signal] = []
    for post, (s, t) in zip(posts, _places(world, posts), strict=True):
        lower = defaults.SIGN_LOWER_EDGE
        faces = post.faces
        if faces and faces[0].supplementary:
            # A plate without a sign above it goes to the bottom.
            faces = tuple(sorted(faces, key=lambda face: face.supplementary))
        for face in reversed(faces):
            if face.code and not face.meaning and (face.country, face.code) not in foreign:
                foreign.add((face.country, face.code))
                words = f"the sign {face.country}:{face.code} has no common number and keeps its own"
                world.diagnostics.note("sign-code", post.osm_id, words)
            signal = _signal(world, post, face, (s, t, lower))
            lower += signal.height
            out.append(signal)
    return tuple(out)


def make_derived_signals(world: World, posts: Sequence[Post]) -> tuple[Signal, ...]:
    """Make signals of signs that follow from something else and stand nowhere: beside the carriageway."""
    out: list[Signal] = []
    for post in posts:
        t = _beyond_edge(world, post.road, post.s, post.along, defaults.SIGN_CLEARANCE)
        place = (post.s, t, defaults.SIGN_LOWER_EDGE)
        out += [replace(_signal(world, post, face, place), derived=True) for face in post.faces]
    return tuple(out)


def _places(world: World, posts: Sequence[Post]) -> list[tuple[float, float]]:
    """Return s and t of posts: as mapped or beside the carriageway, and not on the lanes of another road."""
    first = [(post.s, _beyond_edge(world, post.road, post.s, post.along, defaults.SIGN_CLEARANCE)) for post in posts]
    free = free_of_other_roads(world, [(post.road, *place) for post, place in zip(posts, first, strict=True)])
    out: list[tuple[float, float]] = []
    for post, usual, is_free in zip(posts, first, free, strict=True):
        left, right = world.lanes.carriageway(post.road, post.s)
        if post.t is not None and max(post.t - left, right - post.t) > 0.5 * defaults.SIGN_CLEARANCE_LEAST:
            out.append((post.s, post.t))
        else:
            out.append(usual if is_free else _elsewhere(world, post))
    return out


def _elsewhere(world: World, post: Post) -> tuple[float, float]:
    """Return another place (s, t) for a post whose usual one is not free: nearer to the road, farther back, or on."""
    length = world.lanes.length(post.road)
    back = -1.0 if post.along else 1.0
    tried = [(post.s, defaults.SIGN_CLEARANCE_LEAST)]
    tried += [(post.s + back * step, defaults.SIGN_CLEARANCE) for step in _STEPS_BACK]
    places = [
        (s, _beyond_edge(world, post.road, s, post.along, clearance)) for s, clearance in tried if 0.0 <= s <= length
    ]
    free = free_of_other_roads(world, [(post.road, *place) for place in places])
    for place, is_free in zip(places, free, strict=True):
        if is_free:
            return place
    words = "a sign stands on the lanes of another road: there is no room for it beside its own"
    world.diagnostics.note("sign-on-road", post.osm_id, words)
    return places[0]


def _beyond_edge(world: World, road: int, s: float, along: bool, clearance: float) -> float:
    """Return t of a place beside the carriageway on the side to which traffic of a direction keeps, m."""
    left, right = world.lanes.carriageway(road, s)
    outwards = -1.0 if along == (world.road_map.rule is Rule.RIGHT_HAND) else 1.0
    t = (left if outwards > 0.0 else right) + outwards * clearance
    # Beyond a verge there may be a track for bicycles.
    lanes = world.lanes.at(road, s)
    for lane in lanes if outwards < 0.0 else reversed(lanes):
        if lane.right < t < lane.left and lane.type not in _STANDING:
            t = (lane.left if outwards > 0.0 else lane.right) + outwards * clearance
    return t


def _signal(world: World, post: Post, face: SignFace, place: tuple[float, float, float]) -> Signal:
    """Make the signal of a sign at s, t and z of its lower edge, m."""
    s, t, lower = place
    target, country = world.options.target, face.country or world.network.country
    code = sign_code(
        face.meaning, face.value, country, own_codes=target.own_codes, value_in_subtype=target.value_in_subtype
    ) or SignCode(face.code or "-1", NO_SUBTYPE, face.country)
    name = face.meaning or face.text or f"{face.country}:{face.code}"
    width, height = defaults.SIGN_SIZE[_shape(face)]
    lanes = car_lanes(world, post.road, s, post.along) or car_lanes(world, post.road, s, not post.along)
    return Signal(
        *(world.ids.thing(), post.road, s, t, name, code.type, code.subtype, code.country),
        dynamic=False,
        orientation="+" if post.along else "-",
        z_offset=lower,
        height=height,
        width=width,
        value=face.value,
        unit=face.unit if face.value is not None else "",
        text=face.text,
        validity=lane_ranges(lanes),
        osm_id=face.osm_id or post.osm_id,
    )


def _shape(face: SignFace) -> str:
    return "plate" if face.supplementary else _SHAPES.get(face.meaning, "round")
