"""Ways of one street, one behind the other."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from osm2xodr.osmParsing.file import RawWay
from osm2xodr.osmParsing.tags import ends_of_streets


def street_chains(
    ways: Sequence[RawWay], streets: Sequence[tuple[str, ...] | None], chosen: Collection[int]
) -> Iterator[list[tuple[int, bool]]]:
    """Yield chosen ways (by index) of one street, one behind the other, each with whether it runs along the chain.

    `streets` are those of the ways, as `street_of` has them. A street continues at a node where exactly two of its
    ways end.
    """
    among, done = frozenset(chosen), set[int]()
    wanted = {streets[way] for way in among}
    streets = [street if street in wanted else None for street in streets]
    meeting = ends_of_streets(ways, streets)

    def following(way: int, along: bool) -> tuple[int, bool] | None:
        street = streets[way]
        at = meeting.get((ways[way].refs[-1 if along else 0], street), []) if street is not None else []
        others = [other for other in at if other[0] != way]
        return others[0] if len(at) == 2 and len(others) == 1 and others[0][0] in among else None

    for index in sorted(among):
        if index in done:
            continue
        # To the end of the chain, and from there back.
        start, seen = (index, False), {index}
        while (ahead := following(*start)) is not None and ahead[0] not in seen:
            start = ahead
            seen.add(ahead[0])
        chain = [(start[0], not start[1])]
        done.add(start[0])
        while (ahead := following(*chain[-1])) is not None and ahead[0] not in done:
            chain.append(ahead)
            done.add(ahead[0])
        yield chain
