"""The number of lanes of ways without any tag about it, from the ways that continue the street on both sides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from osm2xodr.osmParsing.defaults import LANES_PLAUSIBLE_MAX
from osm2xodr.osmParsing.file import RawWay
from osm2xodr.osmParsing.tags.access import is_roundabout, oneway
from osm2xodr.osmParsing.tags.lane_counts import COUNT_TAGS
from osm2xodr.osmParsing.tags.lane_lists import LIST_TAGS
from osm2xodr.osmParsing.tags.values import Tags, parse_count

_LANE_TAGS: Final = (*COUNT_TAGS, *LIST_TAGS)
# How many ways beyond an untagged one are searched for a number of lanes on either side; a choice.
_WAYS_SEARCHED: Final = 5


def lanes_of_neighbours(ways: Sequence[RawWay]) -> dict[int, int]:
    """Guess the numbers of lanes (both directions together) of untagged ways, by index of the way.

    A street continues where exactly one other way of the same class, name and number of directions ends; untagged
    ways are stepped over. A number is needed on both sides. The smaller one is taken, made even for two-way streets:
    short turn lanes make the difference.
    """
    # A way without nodes continues nowhere.
    streets = [_street(way.tags) if len(way.refs) else None for way in ways]
    untagged = [
        street is not None and way.tags.keys().isdisjoint(_LANE_TAGS)
        for way, street in zip(ways, streets, strict=True)
    ]
    if not any(untagged):
        return {}
    meeting: dict[tuple[int, tuple[str, ...]], list[int]] = {}
    for index, (way, street) in enumerate(zip(ways, streets, strict=True)):
        if street is not None:
            for node in (way.refs[0], way.refs[-1]):
                meeting.setdefault((node, street), []).append(index)
    found: dict[int, int] = {}
    for index, is_untagged in enumerate(untagged):
        if is_untagged:
            counts = [_count_beyond(index, end, ways, streets, untagged, meeting) for end in (0, -1)]
            if all(counts):
                lanes = min(counts)
                two_way = oneway(ways[index].tags)[0] == 0
                found[index] = lanes - 1 if two_way and lanes % 2 and lanes > 1 else lanes
    return found


def _street(tags: Tags) -> tuple[str, ...] | None:
    """Return what all ways of a street have in common; None for roundabouts and ways without a name."""
    name, ref = tags.get("name", ""), tags.get("ref", "")
    if is_roundabout(tags) or not (name or ref):
        return None
    return tags["highway"], name or ref, str(abs(oneway(tags)[0]))


def _count_beyond(
    index: int,
    end: int,
    ways: Sequence[RawWay],
    streets: Sequence[tuple[str, ...] | None],
    untagged: Sequence[bool],
    meeting: Mapping[tuple[int, tuple[str, ...]], Sequence[int]],
) -> int:
    """Return the number of lanes of the first tagged way beyond one end (0 or -1); 0 if there is none."""
    node = ways[index].refs[end]
    street = streets[index]
    for _ in range(_WAYS_SEARCHED):
        others = [other for other in meeting.get((node, street), ()) if other != index] if street else []
        if len(others) != 1:
            return 0
        index = others[0]
        if not untagged[index]:
            count = parse_count(ways[index].tags.get("lanes", ""))[0] or 0
            return count if count <= LANES_PLAUSIBLE_MAX else 0
        refs = ways[index].refs
        node = refs[-1] if refs[0] == node else refs[0]
    return 0
