"""Traffic signs: what they say, where they stand, and which traffic they are for."""

from __future__ import annotations

from collections.abc import Sequence

from osm2xodr.furniture import defaults
from osm2xodr.furniture.signs.mapped_signs import mapped_posts
from osm2xodr.furniture.signs.posts import Post, make_derived_signals, make_signals, merge_posts
from osm2xodr.furniture.signs.speed_signs import posts_of_ways
from osm2xodr.furniture.signs.stop_and_give_way import YieldSigns, priority_posts
from osm2xodr.furniture.world import Approach, Crossing, RailStop, Stop, World
from osm2xodr.model import Signal, SignFace
from osm2xodr.system import record


@record
class PlacedSigns:
    """Signs, and where they make traffic stop."""

    signals: tuple[Signal, ...] = ()
    stops: tuple[Stop, ...] = ()


def place_signs(
    world: World,
    approaches: Sequence[Approach],
    signalled: frozenset[tuple[int, bool]],
    crossings: Sequence[Crossing] = (),
    rail_stops: Sequence[RailStop] = (),
) -> PlacedSigns:
    """Place all signs; stop and give-way signs beside a road may be for those who cross it.

    Those of level crossings stand where traffic meets railways, `rail_stops`, unless they are mapped near there.

    On the approaches with lights, `signalled` as (road, whether at its end), signs stop nobody.
    """
    yield_signs = YieldSigns(world, approaches, crossings)
    yield_signs.add_nodes()
    mapped = mapped_posts(world, yield_signs)
    yield_signs.add_at_roundabouts(signalled)
    posts = [*yield_signs.posts(), *mapped]
    posts += _rail_posts(rail_stops, mapped)
    posts += posts_of_ways(world, approaches, posts)
    signals = make_signals(world, merge_posts(posts, world.diagnostics))
    if world.options.target.priority_signs:
        derived = make_derived_signals(world, priority_posts(world, approaches, signals))
        signals = (*signals, *derived)
    return PlacedSigns(signals, tuple(yield_signs.stops(signalled)))


def _rail_posts(stops: Sequence[RailStop], mapped: Sequence[Post]) -> list[Post]:
    """Return the posts of the signs at level crossings that are not mapped."""
    meaning = "level_crossing"
    there = [post for post in mapped if any(face.meaning == meaning for face in post.faces)]
    return [
        Post(stop.road, stop.s, stop.along, (SignFace(meaning),), stop.osm_id)
        for stop in stops
        if stop.crossing.sign
        and not any(
            (post.road, post.along) == (stop.road, stop.along) and abs(post.s - stop.s) < defaults.ONE_INSTALLATION
            for post in there
        )
    ]
