"""What the surroundings of ways tell of them: the carriageway, by kerbs and ways before and behind; built-up areas.

Where nobody parks for some metres on a street with cars parked along it, its kerb and its lanes run straight on.
Before junctions, at crossings and bus stops mappers cut a street where parking pauses. The carriageway is as wide
there as before and behind, so the lanes must not take the room of the parked cars.

How densely streets lie around a way, and people cross it, marks a built-up area where no tag says so.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import Final

import numpy as np

from osm2xodr.curves import unique_inverse, unique_rows
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.osmParsing.defaults import PARKING_PAUSE_MAX
from osm2xodr.osmParsing.file import RawWay
from osm2xodr.osmParsing.roadside.kerbs import SAME_CARRIAGEWAY, WayPieces, street_chains
from osm2xodr.osmParsing.roadside.reach import sample_lines
from osm2xodr.osmParsing.tags import (
    BESIDE_TAGS,
    COUNT_TAGS,
    LIST_TAGS,
    PARKING_TAGS,
    TURN_TAGS,
    Kerbs,
    StreetFacts,
    Tags,
    read_parking,
    street_of,
    tagged_width,
)
from osm2xodr.system import record

_PARKING: Final = frozenset(PARKING_TAGS)
_LISTS: Final = frozenset((*LIST_TAGS, *TURN_TAGS))
# Endings of keys that tell what a lane beside others is like, not that there is one.
_DETAILS: Final = ("width", ":lane", ":oneway")
_NO_LANE: Final = frozenset({"no", "none", "separate", "track"})
_SIDES: Final = frozenset({"left", "right", "forward", "backward"})

# Streets with houses, by OSM's highway value (OSM wiki, Key:highway).
_RESIDENTIAL: Final = frozenset({"residential", "living_street"})
# And what makes the grid of a town with them; primary roads and faster ones have several carriageways in the country.
_STREETS: Final = _RESIDENTIAL | {"unclassified", "tertiary", "secondary"}
# Distance of the points at which it is measured, m: a quarter of a cell.
_DENSITY_SPACING: Final = 25.0
# Side of the cells, m; a place is judged by three by three of them, 9 ha: about a block on each side. A choice.
_CELL: Final = 100.0
_WINDOW_HA: Final = (3.0 * _CELL) ** 2 / 1e4
# Rows of cells between numbers of columns: more than any area has.
_ROW: Final = 2**31


def street_facts(ways: Sequence[RawWay], pieces: WayPieces, kerbs: Mapping[int, Kerbs]) -> dict[int, StreetFacts]:
    """Return what is known of ways, by index of the way; those of which nothing is known are left out.

    `pieces` are those of the `ways`, `kerbs` those along ways, by index.
    """
    pauses = parking_pauses(ways, pieces, kerbs)
    return {
        index: StreetFacts(kerbs.get(index), no_parking=pauses.get(index, (0.0, 0.0)))
        for index in sorted(kerbs.keys() | pauses.keys())
    }


@record
class _Stretch:
    """A way as seen along its street."""

    way: int  # Its index
    along: bool  # Whether it runs along the street
    length: float  # m
    parking: tuple[float, float]  # What parked cars use of the carriageway on the left and right, m
    lanes: tuple[tuple[str, str], ...]  # What its tags say of lanes, whatever its direction
    width: float | None  # Of its carriageway, m; None where it is not known


def parking_pauses(
    ways: Sequence[RawWay], pieces: WayPieces, kerbs: Mapping[int, Kerbs]
) -> dict[int, tuple[float, float]]:
    """Return the room of parked cars before or behind beside ways on which none park, left and right, m, by index.

    `pieces` are those of the ways, `kerbs` those along ways, by index.
    """
    streets = [street_of(way.tags) for way in ways]
    parked = {street for street, way in zip(streets, ways, strict=True) if not _PARKING.isdisjoint(way.tags)} - {None}
    if not parked:
        return {}
    chosen = [index for index, street in enumerate(streets) if street in parked]
    lengths = pieces.way_lengths(len(ways)).tolist()
    out: dict[int, tuple[float, float]] = {}
    for chain in street_chains(ways, streets, chosen):
        street = [_stretch(ways[way].tags, way, along, lengths[way], kerbs.get(way)) for way, along in chain]
        for side in (0, 1):
            for item, room in _rooms(street, side):
                left, right = out.get(item.way, (0.0, 0.0))
                out[item.way] = (room, right) if item.along == (side == 0) else (left, room)
    return out


def _stretch(tags: Tags, way: int, along: bool, length: float, kerbs: Kerbs | None) -> _Stretch:
    left, right = (
        parking.on_carriageway if (parking := read_parking(tags, side, [])) else 0.0 for side in ("left", "right")
    )
    lanes = sorted(
        (_without_side(key), str(tags[key].count("|")) if key in _LISTS else tags[key])
        for key in (*COUNT_TAGS, *BESIDE_TAGS, *_LISTS)
        if tags.get(key, "no") not in _NO_LANE and not key.endswith(_DETAILS)
    )
    width = (kerbs.apart if kerbs else None) or tagged_width(tags)
    return _Stretch(way, along, length, (left, right) if along else (right, left), tuple(lanes), width)


def _without_side(key: str) -> str:
    return ":".join(word for word in key.split(":") if word not in _SIDES)


def _rooms(street: Sequence[_Stretch], side: int) -> Iterator[tuple[_Stretch, float]]:
    """Yield the ways of short pauses on one side (0 left, 1 right), each with the room of the cars around it, m."""
    runs = [list(run) for _, run in groupby(street, lambda item: item.parking[side] > 0.0)]
    for k, run in enumerate(runs):
        if run[0].parking[side] or sum(item.length for item in run) > PARKING_PAUSE_MAX:
            continue
        around = [*(runs[k - 1][-1:] if k else ()), *(runs[k + 1][:1] if k + 1 < len(runs) else ())]
        if all(_goes_on(item, other) for item in run for other in around):
            room = min((other.parking[side] for other in around), default=0.0)
            yield from ((item, room) for item in run if room)


def _goes_on(item: _Stretch, other: _Stretch) -> bool:
    """Whether the carriageway of a way is that of another one, as far as its tags and kerbs tell."""
    apart = abs(item.width - other.width) if item.width is not None and other.width is not None else 0.0
    return item.lanes == other.lanes and apart <= SAME_CARRIAGEWAY


def street_densities(points: FloatArray, counts: IntArray, ways: IntArray, highways: Sequence[str]) -> FloatArray:
    """Return the mean density of residential streets, and of all streets, around each way (2, ways), m per hectare.

    `points` (n, 2) are the nodes of all pieces of ways, piece after piece, m; `counts` (m,) the number of nodes and
    `ways` (m,) the way of each piece, `highways` the class of each way.
    """
    lines = sample_lines(points, counts, _DENSITY_SPACING)
    way = np.repeat(ways, counts)[lines.node]
    column, row = np.floor(lines.points / _CELL).astype(np.int64).T
    cell = column * _ROW + row
    cells, index = unique_inverse(cell)
    counted = np.array([[highway in kinds for highway in highways] for kinds in (_RESIDENTIAL, _STREETS)], np.bool_)
    metres = np.array([np.bincount(index, lines.length * some[way], len(cells)) for some in counted])
    around = np.zeros((2, len(cells)))
    for right in (-1, 0, 1):
        for up in (-1, 0, 1):
            beside = cells + right * _ROW + up
            at = np.minimum(np.searchsorted(cells, beside), len(cells) - 1)
            around += np.where(cells[at] == beside, metres[:, at], 0.0)
    total = np.array([np.bincount(way, lines.length * near[index], len(highways)) for near in around])
    length = np.bincount(way, lines.length, len(highways))
    density: FloatArray = total / np.maximum(length, 1e-9) / _WINDOW_HA
    return density


def crossing_densities(
    pieces: WayPieces, ways: int, node_ids: IntArray, tags: Mapping[int, Mapping[str, str]]
) -> FloatArray:
    """Return how many places each of so many ways has at which people cross, (ways,), per m.

    `node_ids` are those of the numbers of `pieces`; `tags` are those of nodes by id.
    """
    crossed = [
        node for node, item in tags.items() if item.get("highway") == "crossing" and item.get("crossing") != "no"
    ]
    on_way = np.isin(node_ids[pieces.node], np.array(crossed, np.int64))
    way = np.repeat(pieces.way, pieces.count)[on_way]
    # Once, where two pieces of a way share the node.
    pairs = unique_rows(np.column_stack([way, pieces.node[on_way]])).values
    density: FloatArray = np.bincount(pairs[:, 0], minlength=ways) / np.maximum(pieces.way_lengths(ways), 1e-9)
    return density
