"""Cars that park along streets in towns whose tags say nothing of their width, nor of parking.

Between house fronts streets are wider than their lanes, and the rest is where cars stand. What tags say of the same
street elsewhere decides, else those of the streets of its class around, else the fronts on both sides.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set as AbstractSet
from math import inf
from typing import Final

import numpy as np

from osm2xodr.curves import PointTree, connected_groups, owners, repeated, starts, unique_inverse
from osm2xodr.model import BoolArray, FloatArray, IntArray, Structure
from osm2xodr.osmParsing.defaults import PARKED_ALONG, PARKING_WIDTH, SIDEWALK_WIDTH
from osm2xodr.osmParsing.file import RawNodes, RawWay
from osm2xodr.osmParsing.roadside.kerbs import WayPieces, find_crossings, nearest_edges, segments_of, stations_near
from osm2xodr.osmParsing.roadside.reach import sample_lines
from osm2xodr.osmParsing.roadside.things import is_building, is_crossing, is_footway
from osm2xodr.osmParsing.tags import (
    BESIDE_TAGS,
    LEFT_RIGHT,
    PARKING_TAGS,
    TURN_TAGS,
    WIDTH_TAGS,
    StreetFacts,
    Tags,
    is_roundabout,
    is_town_street,
    oneway,
    parse_count,
    read_parking,
    street_of,
    structure_of,
    tells_of_shoulders,
)

# Tags after which nothing is guessed: of the width, and of lanes that lie where cars would park.
_STATED: Final = frozenset((*PARKING_TAGS, *WIDTH_TAGS, *BESIDE_TAGS, *TURN_TAGS))
# Values of these that say that there is no such lane.
_NO_LANE: Final = frozenset({"no", "none", "separate", "track", "sidepath", "shared_lane", "opposite"})
# Cars park on both sides where tagged ways have so much parking across, m, in the mean: rather two rows than one.
_BOTH_SIDES: Final = 1.25 * PARKING_WIDTH["parallel"]
# How much of the same street, and of streets around, must be tagged, and how far away, m: other towns have streets of
# the same name. Choices.
_SAME_MIN: Final = 50.0
_SAME: Final = 1000.0
_AROUND_MIN: Final = 200.0
_AROUND: Final = 300.0
# What rounding may make of these, m; a choice.
_MARGIN: Final = 1e-6
# Least share of the places along a way that must have fronts, or footways, on each side. A choice.
_SHARE_MIN: Final = 0.4
# Houses wall to wall are a row from so many on: pairs with their garages are fewer. A choice: in a part of Berlin
# that is built so, they tell of a third of the streets; in a spa town and in suburbs of none.
_ROW_MIN: Final = 4
# Spacing of points along streets that are compared with those around, m. A choice.
_SPACING: Final = 50.0
# Fronts farther than this from the line, m, stand in gardens or on squares. A choice.
_NEAR: Final = 16.0


def with_guessed_parking(
    facts: Mapping[int, StreetFacts],
    ways: Sequence[RawWay],
    pieces: WayPieces,
    beside: Sequence[RawWay],
    nodes: RawNodes,
    points: FloatArray,
    dense: AbstractSet[int],
) -> dict[int, StreetFacts]:
    """Return what is known of ways, by index, with those along which cars are taken to park.

    `pieces` are those of the `ways`, `beside` other ways, among them buildings and footways; `points` (k, 2) are the
    local x, y of the `nodes`, m; `dense` the ids of ways among many streets.
    """
    open_ones = np.array(
        [index not in facts and _may_have_untagged(way.tags, way.id in dense) for index, way in enumerate(ways)]
    )
    if not open_ones.any():
        return dict(facts)
    tagged = _of_tagged_ways(ways, pieces, open_ones)
    open_ones[[index for index, (parked, _) in tagged.items() if not parked]] = False
    houses = _in_rows([way for way in beside if is_building(way.tags)])
    fronts = _apart(ways, pieces, open_ones, houses, nodes, points)
    chosen = {
        index: tagged[index][1] if index in tagged else "as the fronts on both sides leave room for it"
        for index in sorted(tagged.keys() | {index for index in fronts if _is_narrow(ways[index].tags)})
        if open_ones[index]
    }
    open_ones[:] = False
    open_ones[list(chosen)] = True
    open_ones[_beside_streets(ways, pieces, open_ones)] = False
    footways = [way for way in beside if is_footway(way.tags) and not is_crossing(way.tags)]
    walks = _apart(ways, pieces, open_ones, footways, nodes, points)
    out = dict(facts)
    for index in np.flatnonzero(open_ones).tolist():
        room = min(fronts.get(index, inf) - 2.0 * SIDEWALK_WIDTH, walks.get(index, inf) - SIDEWALK_WIDTH)
        out[index] = StreetFacts(parked=chosen[index], room=room)
    return out


def _may_have_untagged(tags: Tags, dense: bool) -> bool:
    """Whether a way lies in a town, is of a class along which cars park there, and says nothing of its width."""
    if tags["highway"] not in PARKED_ALONG or is_roundabout(tags) or not is_town_street(tags, dense):
        return False
    if tells_of_shoulders(tags) or structure_of(tags) is not Structure.GROUND:
        return False
    return all(key not in _STATED or key == "oneway:bicycle" or tags[key] in _NO_LANE for key in tags)


def _is_narrow(tags: Tags) -> bool:
    """Whether a way has one lane for each direction, and sidewalks beside them."""
    lanes = 1 if oneway(tags)[0] else 2
    return tags["highway"] != "living_street" and (parse_count(tags.get("lanes", "1"))[0] or 1) <= lanes


def _apart(
    ways: Sequence[RawWay],
    pieces: WayPieces,
    chosen: BoolArray,
    lines: Sequence[RawWay],
    nodes: RawNodes,
    points: FloatArray,
) -> dict[int, float]:
    """Return how far lines on both sides of ways lie apart, m, by index of those chosen that have them."""
    segments = segments_of(lines, nodes, points)
    along = stations_near(ways, pieces, chosen, np.concatenate([segments.start, segments.end]))
    if along is None:
        return {}
    edges = nearest_edges(find_crossings(along.stations, segments), len(along.way))
    along.forget_beyond(*edges)
    every = np.bincount(along.way, minlength=len(ways))
    found: list[dict[int, float]] = []
    for edge in edges:
        known = np.flatnonzero(np.abs(edge) <= _NEAR)
        known = known[np.argsort(along.way[known], kind="stable")]
        count = np.bincount(along.way[known], minlength=len(ways))
        first = starts(count)
        enough = np.flatnonzero((count > 0) & (count >= _SHARE_MIN * every))
        found.append(
            {way: float(np.median(np.abs(edge[known[first[way] : first[way + 1]]]))) for way in enough.tolist()}
        )
    return {way: round(left + found[1][way], 1) for way, left in found[0].items() if way in found[1]}


def _beside_streets(ways: Sequence[RawWay], pieces: WayPieces, chosen: BoolArray) -> IntArray:
    """Return the indices of those chosen beside which other streets run: between carriageways nobody parks."""
    along = stations_near(ways, pieces, chosen, pieces.points)
    if along is None:
        return np.zeros(0, np.int64)
    beside = np.zeros(len(along.way), np.bool_)
    beside[along.streets.station[along.streets.along]] = True
    every, count = (np.bincount(way, minlength=len(ways)) for way in (along.way, along.way[beside]))
    return np.flatnonzero((count > 0) & (count >= _SHARE_MIN * every))


def _in_rows(buildings: Sequence[RawWay]) -> list[RawWay]:
    """Return the buildings that stand in rows, wall to wall: they share nodes."""
    count = np.array([len(way.refs) for way in buildings], np.int64)
    if not count.sum():
        return []
    corner = unique_inverse(np.concatenate([np.asarray(way.refs, np.int64) for way in buildings]))[1]
    corner += len(count)
    row = connected_groups(int(corner.max()) + 1, repeated(count), corner)[: len(count)]
    size = np.bincount(row)
    return [way for way, number in zip(buildings, row.tolist(), strict=True) if size[number] >= _ROW_MIN]


def _of_tagged_ways(ways: Sequence[RawWay], pieces: WayPieces, open_ones: BoolArray) -> dict[int, tuple[bool, str]]:
    """Say by the tags of other ways whether cars park along those of which nothing is known, and why, by index."""
    tagged = np.array(
        [way.tags["highway"] in PARKED_ALONG and not way.tags.keys().isdisjoint(PARKING_TAGS) for way in ways],
        np.bool_,
    )
    if not tagged.any():
        return {}
    across = np.array([_parking_across(way.tags) if tags else 0.0 for way, tags in zip(ways, tagged, strict=True)])
    streets = [street_of(way.tags) for way in ways]
    samples = sample_lines(pieces.points, pieces.count, _SPACING)
    way = pieces.way[owners(starts(pieces.count))[samples.node]]

    def near(kinds: Sequence[tuple[str, ...] | None], reach: float, least: float) -> dict[int, float]:
        """Return the mean width of parking along tagged ways of their kind within reach of open ones, m, by index."""
        names = {kind: number for number, kind in enumerate(sorted({kind for kind in kinds if kind is not None}))}
        kind = np.array([-1 if item is None else names[item] for item in kinds], np.int64)
        # Kinds lie apart in the tree.
        apart = np.column_stack([samples.points, 2.0 * reach * kind[way]])
        known = np.flatnonzero((tagged & (kind >= 0))[way])
        count = np.bincount(way, minlength=len(ways))
        asked = np.flatnonzero(open_ones & (kind >= 0) & (count > 0))
        if not len(known) or not len(asked):
            return {}
        middle = np.column_stack([np.bincount(way, values, len(ways))[asked] / count[asked] for values in apart.T])
        at, row = PointTree(apart[known]).within(middle, reach)
        # The tree has no order of its own, and sums depend on it.
        order = np.lexsort((row, at))
        at, row = at[order], known[row[order]]
        long = np.bincount(at, samples.length[row], len(asked))
        area = np.bincount(at, samples.length[row] * across[way[row]], len(asked))
        enough = np.flatnonzero(long >= least - _MARGIN)
        return dict(zip(asked[enough].tolist(), (area[enough] / long[enough]).tolist(), strict=True))

    around = near([(item.tags["highway"],) for item in ways], _AROUND, _AROUND_MIN)
    same = near(streets, _SAME, _SAME_MIN)
    found = {index: (mean, "as along the streets around") for index, mean in around.items()}
    found |= {index: (mean, "as along the same street") for index, mean in same.items()}
    return {index: (mean >= _BOTH_SIDES - _MARGIN, why) for index, (mean, why) in found.items()}


def _parking_across(tags: Tags) -> float:
    """Return how much of a carriageway parked cars use on both sides, m."""
    sides = (read_parking(tags, side, []) for side in LEFT_RIGHT)
    return sum(parking.on_carriageway for parking in sides if parking)
