"""Traffic signs beside the road."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from osm2xodr.furniture.signs.mapped_signs import add_mapped_signs
from osm2xodr.furniture.signs.posts import joined_posts, make_signals
from osm2xodr.furniture.signs.speed_signs import road_signs
from osm2xodr.furniture.signs.stop_and_give_way import YieldSigns
from osm2xodr.furniture.world import Approach, Crossing, Stop, World
from osm2xodr.model import Signal


@dataclass(frozen=True, slots=True)
class PlacedSigns:
    """Signs, and where those among them make traffic stop."""

    signals: tuple[Signal, ...] = ()
    stops: tuple[Stop, ...] = ()


def place_signs(
    world: World,
    approaches: Sequence[Approach],
    signalled: frozenset[tuple[int, bool]],
    crossings: Sequence[Crossing] = (),
) -> PlacedSigns:
    """Place all signs.

    Parameters
    ----------
    world, approaches
        What is there.
    signalled
        (road, whether at its end) of the approaches with lights: their signs stop nobody.
    crossings
        Where people cross: signs beside a road may be for them.
    """
    places = world.nodes
    yielding = YieldSigns(world, approaches, crossings)
    yielding.add_nodes(places)
    mapped = add_mapped_signs(world, places, yielding)
    posts = [*yielding.posts(), *mapped]
    posts += road_signs(world, approaches, posts)
    return PlacedSigns(make_signals(world, joined_posts(posts, world.diagnostics)), tuple(yielding.stops(signalled)))
