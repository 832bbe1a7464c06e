"""The number of lanes of a way without any, from the ways that the same street goes on with on either side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from osm2xodr.osmParsing.defaults import LANES_FROM_NEIGHBOURS_STEPS, LANES_PLAUSIBLE_MAX
from osm2xodr.osmParsing.file import RawWay
from osm2xodr.osmParsing.tags.access import is_roundabout, oneway
from osm2xodr.osmParsing.tags.lane_counts import COUNT_TAGS
from osm2xodr.osmParsing.tags.lane_lists import LIST_TAGS
from osm2xodr.osmParsing.tags.values import parse_count

_TELLING: Final = (*COUNT_TAGS, *LIST_TAGS)


def lanes_of_neighbours(ways: Sequence[RawWay]) -> dict[int, int]:
    """Guess numbers of lanes.

    A street goes on where exactly one other way of the same class, name and number of directions ends; ways that are
    silent as well are stepped over. Both sides have to know the number of lanes. The smaller number is taken, and of
    a two-way street an even one: short turning lanes make the difference.

    Parameters
    ----------
    ways
        Whose tags are known.

    Returns
    -------
    dict of int to int
        Numbers of lanes, both directions in one, by index of the way; only of ways that OSM gives none for.
    """
    # A way without nodes goes on nowhere.
    streets = [_street(way.tags) if len(way.refs) else None for way in ways]
    silent = [
        street is not None and way.tags.keys().isdisjoint(_TELLING) for way, street in zip(ways, streets, strict=True)
    ]
    if not any(silent):
        return {}
    meeting: dict[tuple[int, tuple[str, ...]], list[int]] = {}
    for index, (way, street) in enumerate(zip(ways, streets, strict=True)):
        if street is not None:
            for node in (way.refs[0], way.refs[-1]):
                meeting.setdefault((node, street), []).append(index)
    found: dict[int, int] = {}
    for index, is_silent in enumerate(silent):
        if is_silent:
            counts = [_beyond(index, end, ways, streets, silent, meeting) for end in (0, -1)]
            if all(counts):
                lanes = min(counts)
                two_way = oneway(ways[index].tags)[0] == 0
                found[index] = lanes - 1 if two_way and lanes % 2 and lanes > 1 else lanes
    return found


def _street(tags: Mapping[str, str]) -> tuple[str, ...] | None:
    """Return what all ways of a street have in common, None for ways of no street."""
    name, ref = tags.get("name", ""), tags.get("ref", "")
    if is_roundabout(tags) or not (name or ref):
        return None
    return tags["highway"], name or ref, str(abs(oneway(tags)[0]))


def _beyond(
    index: int,
    end: int,
    ways: Sequence[RawWay],
    streets: Sequence[tuple[str, ...] | None],
    silent: Sequence[bool],
    meeting: Mapping[tuple[int, tuple[str, ...]], Sequence[int]],
) -> int:
    """Return the number of lanes of the first way beyond one end (0 or -1) that has one; 0 where there is none."""
    node = ways[index].refs[end]
    street = streets[index]
    for _ in range(LANES_FROM_NEIGHBOURS_STEPS):
        others = [other for other in meeting.get((node, street), ()) if other != index] if street else []
        if len(others) != 1:
            return 0
        index = others[0]
        if not silent[index]:
            count = parse_count(ways[index].tags.get("lanes", ""))[0] or 0
            return count if count <= LANES_PLAUSIBLE_MAX else 0
        refs = ways[index].refs
        node = refs[-1] if refs[0] == node else refs[0]
    return 0
