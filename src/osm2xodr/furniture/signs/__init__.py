"""Traffic signs: what they say, where they stand, and which traffic they are for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from osm2xodr.furniture.signs.mapped_signs import mapped_posts
from osm2xodr.furniture.signs.posts import make_derived_signals, make_signals, merge_posts
from osm2xodr.furniture.signs.priority_signs import priority_posts
from osm2xodr.furniture.signs.speed_signs import posts_of_ways
from osm2xodr.furniture.signs.stop_and_give_way import YieldSigns
from osm2xodr.furniture.world import Approach, Crossing, Stop, World
from osm2xodr.model import Signal

__all__ = ["PlacedSigns", "place_signs"]


@dataclass(frozen=True, slots=True)
class PlacedSigns:
    """Signs, and where they make traffic stop."""

    signals: tuple[Signal, ...] = ()
    stops: tuple[Stop, ...] = ()


def place_signs(
    world: World,
    approaches: Sequence[Approach],
    signalled: frozenset[tuple[int, bool]],
    crossings: Sequence[Crossing] = (),
) -> PlacedSigns:
    """Place all signs; stop and give-way signs beside a road may be for those who cross it.

    On the approaches with lights, `signalled` as (road, whether at its end), signs stop nobody.
    """
    yield_signs = YieldSigns(world, approaches, crossings)
    yield_signs.add_nodes()
    mapped = mapped_posts(world, yield_signs)
    posts = [*yield_signs.posts(), *mapped]
    posts += posts_of_ways(world, approaches, posts)
    signals = make_signals(world, merge_posts(posts, world.diagnostics))
    if world.options.target.priority_signs:
        derived = make_derived_signals(world, priority_posts(world, approaches, signals))
        signals = (*signals, *derived)
    return PlacedSigns(signals, tuple(yield_signs.stops(signalled)))
