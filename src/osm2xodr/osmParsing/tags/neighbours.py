"""What ways of the same street before and behind a way tell of its lanes and of its carriageway's width."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from osm2xodr.osmParsing.defaults import LANES_PLAUSIBLE_MAX
from osm2xodr.osmParsing.file import RawWay
from osm2xodr.osmParsing.tags.access import is_roundabout, oneway
from osm2xodr.osmParsing.tags.cross_sections import NO_FACTS, StreetFacts, tagged_width
from osm2xodr.osmParsing.tags.lane_counts import COUNT_TAGS
from osm2xodr.osmParsing.tags.lane_lists import LIST_TAGS
from osm2xodr.osmParsing.tags.values import Tags, parse_count

_LANE_TAGS: Final = (*COUNT_TAGS, *LIST_TAGS)
# How many ways beyond an untagged one are searched for a number of lanes on either side; a choice.
_WAYS_SEARCHED: Final = 5


def lanes_of_neighbours(ways: Sequence[RawWay]) -> dict[int, int]:
    """Guess the numbers of lanes (both directions together) of untagged ways, by index of the way.

    A number is needed on both sides along the street. The smaller one is taken, made even for two-way streets: short
    turn lanes make the difference.
    """
    streets = [street_of(way.tags) for way in ways]
    untagged = [
        street is not None and way.tags.keys().isdisjoint(_LANE_TAGS)
        for way, street in zip(ways, streets, strict=True)
    ]
    found: dict[int, int] = {}
    for index, both in _beyond(ways, streets, untagged):
        counts = [_plausible_count(ways[other].tags) for other in both]
        if len(counts) == 2 and all(counts):
            lanes = min(counts)
            two_way = oneway(ways[index].tags)[0] == 0
            found[index] = lanes - 1 if two_way and lanes % 2 and lanes > 1 else lanes
    return found


def widths_of_neighbours(ways: Sequence[RawWay], facts: Mapping[int, StreetFacts]) -> dict[int, float]:
    """Guess the widths of the carriageways of ways without any by those of the same street, by index of the way, m.

    `facts` are those of ways, by index: kerbs tell widths, too. One side along the street is enough, of both sides
    the mean is taken; the number of lanes must be the same.
    """
    streets = [street_of(way.tags, "lanes") for way in ways]
    widths = [
        kerbs.apart if (kerbs := facts.get(index, NO_FACTS).kerbs) else tagged_width(way.tags) if street else None
        for index, (way, street) in enumerate(zip(ways, streets, strict=True))
    ]
    unknown = [street is not None and width is None for street, width in zip(streets, widths, strict=True)]
    if all(width is None for width in widths):
        return {}
    found: dict[int, float] = {}
    for index, both in _beyond(ways, streets, unknown):
        beyond = [width for other in both if (width := widths[other]) is not None]
        if beyond:
            found[index] = round(sum(beyond) / len(beyond), 1)
    return found


def street_of(tags: Tags, *same: str) -> tuple[str, ...] | None:
    """Return what all ways of a street have in common; None for roundabouts and ways without a name.

    That is class, name, number of directions, and the values of the tags that must be the `same`.
    """
    name, ref = tags.get("name", ""), tags.get("ref", "")
    if is_roundabout(tags) or not (name or ref):
        return None
    return tags["highway"], name or ref, str(abs(oneway(tags)[0])), *(tags.get(key, "") for key in same)


def ends_of_streets(
    ways: Sequence[RawWay], streets: Sequence[tuple[str, ...] | None]
) -> dict[tuple[int, tuple[str, ...]], list[tuple[int, bool]]]:
    """Return the ways of each street that end at each node, by their indices, and whether they begin there."""
    out: dict[tuple[int, tuple[str, ...]], list[tuple[int, bool]]] = {}
    for index, (way, street) in enumerate(zip(ways, streets, strict=True)):
        # A way without nodes continues nowhere.
        if street is not None and len(way.refs):
            out.setdefault((way.refs[0], street), []).append((index, True))
            out.setdefault((way.refs[-1], street), []).append((index, False))
    return out


def _beyond(
    ways: Sequence[RawWay], streets: Sequence[tuple[str, ...] | None], unknown: Sequence[bool]
) -> Iterator[tuple[int, list[int]]]:
    """Yield each unknown way with the first known ways along its street, one or two, by their indices.

    A street continues where exactly one other way of the same street ends; unknown ways are stepped over.
    """
    # Streets with ways of both kinds; others tell nothing.
    with_unknown, with_known = (
        {street for street, is_unknown in zip(streets, unknown, strict=True) if is_unknown is wanted}
        for wanted in (True, False)
    )
    streets = [street if street in with_unknown and street in with_known else None for street in streets]
    meeting = ends_of_streets(ways, streets)
    for index, is_unknown in enumerate(unknown):
        if is_unknown and streets[index] is not None and len(ways[index].refs):
            both = (_first_beyond(index, end, ways, streets, unknown, meeting) for end in (0, -1))
            yield index, [other for other in both if other is not None]


def _first_beyond(
    index: int,
    end: int,
    ways: Sequence[RawWay],
    streets: Sequence[tuple[str, ...] | None],
    unknown: Sequence[bool],
    meeting: Mapping[tuple[int, tuple[str, ...]], Sequence[tuple[int, bool]]],
) -> int | None:
    """Return the index of the first known way beyond one end (0 or -1) of a way; None if there is none."""
    node = ways[index].refs[end]
    street = streets[index]
    for _ in range(_WAYS_SEARCHED):
        others = [other for other, _ in meeting.get((node, street), ()) if other != index] if street else []
        if len(others) != 1:
            return None
        index = others[0]
        if not unknown[index]:
            return index
        refs = ways[index].refs
        node = refs[-1] if refs[0] == node else refs[0]
    return None


def _plausible_count(tags: Tags) -> int:
    """Return the number of lanes that a way's tags give, 0 for none and for mistakes."""
    count = parse_count(tags.get("lanes", ""))[0] or 0
    return count if count <= LANES_PLAUSIBLE_MAX else 0
