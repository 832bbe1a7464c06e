"""Where along roads their names change."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Final

import numpy as np

from osm2xodr.geometry.defaults import SHORTEST_NAME
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.model import LaneSection, RoadName

# A name that changes nearer than this to where lanes change does so there, m: half a dash, and no sliver is left.
_AT_SECTION: Final = 1.5


def guesses_about(ways: Iterable[int], guesses: Mapping[int, frozenset[str]]) -> tuple[str, ...]:
    """Return the codes of the guesses about ways, in ascending order."""
    return tuple(sorted(frozenset[str]().union(*(guesses.get(way, ()) for way in ways))))


def road_names(
    parts: RoadParts, road: int, sections: Sequence[LaneSection], guesses: Mapping[int, frozenset[str]]
) -> tuple[RoadName, ...]:
    """Return the names along a road by its index, none where it has one alone; short pieces bear a neighbour's."""
    pieces = parts.fitted.pieces[int(parts.street[road])]
    begin, length = float(parts.begin[road]), float(parts.length[road])
    starts_at = [s - begin for s, _, _ in pieces]
    ends_at = [*starts_at[1:], np.inf]
    # (begin, name and number, ways) of each name
    found: list[tuple[float, tuple[str, str], list[int]]] = []
    for (_, item, _), start, end in zip(pieces, starts_at, ends_at, strict=True):
        lower, upper = max(start, 0.0), min(end, length)
        if upper <= lower:
            continue
        said = (item.name, item.ref)
        if len(found) == 1 and lower < SHORTEST_NAME:
            found[0] = (0.0, said, [*found[0][2], item.osm_way_id])
        elif not found or (found[-1][1] != said and upper - lower >= SHORTEST_NAME):
            found.append((lower if found else 0.0, said, [item.osm_way_id]))
        else:
            found[-1][2].append(item.osm_way_id)
    if len(found) < 2:
        return ()
    borders = np.array([section.s for section in sections])
    out: list[RoadName] = []
    for s, (name, ref), ways in found:
        near = float(borders[np.argmin(np.abs(borders - s))])
        place = near if abs(near - s) < _AT_SECTION else s
        out.append(RoadName(place, name or ref, tuple(dict.fromkeys(ways)), guesses_about(ways, guesses)))
    return tuple(out)
