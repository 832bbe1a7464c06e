"""Signs that say who yields where the map has none, for readers that know nothing else about the right of way."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import Final

from osm2xodr.diagnostics import counted
from osm2xodr.furniture.signs.posts import Post
from osm2xodr.furniture.world import Approach, World
from osm2xodr.model import Signal, SignFace

# Signs that such readers know, by whether their traffic goes first.
_GOES_FIRST: Final = {"priority_next": True, "priority_road": True, "give_way": False}


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
