"""Assembly of streets and intersections from pieces of ways and the attributes of ways.

Pieces of ways are joined into chains from intersection to intersection. Two pieces that meet at a node where no other
ends belong to one chain, unless no traffic could pass (two one-ways head on), may not pass (turn restrictions), or
would have to turn on the spot. A chain has the direction of its one-way pieces; where these run against each other it
is split.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import replace
from itertools import combinations, pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import dot, hypot, ranks, sorted_unique, starts
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import (
    BoolArray,
    Direction,
    FloatArray,
    IntArray,
    Intersection,
    Street,
    StreetAttributes,
    TurnRestriction,
)
from osm2xodr.osmParsing.file import RawNodes
from osm2xodr.osmParsing.network.pieces import Pieces, turns_back
from osm2xodr.osmParsing.network.relations import forbids
from osm2xodr.osmParsing.roadside import street_node_tags
from osm2xodr.osmParsing.tags import turned_round
from osm2xodr.system import record

# Two ways at a node go on beyond each other where they bend by less than the angle of this cosine (60 degrees): side
# streets of one-way streets, whose main street lies outside of the area, bend by more. A choice.
_GOES_ON: Final = 0.5
# A piece of a chain, and whether the chain runs along it (else against it).
Link = tuple[int, bool]


def make_streets(
    pieces: Pieces,
    nodes: RawNodes,
    points: FloatArray,
    attributes: Sequence[StreetAttributes],
    directions: Sequence[int],
    transitions: Set[int] = frozenset(),
    restrictions: Sequence[TurnRestriction] = (),
) -> tuple[tuple[Street, ...], tuple[Intersection, ...]]:
    """Join pieces of ways into streets between intersections.

    `points` (n, 2) are the local x, y of the nodes, m; `attributes` and `directions` (1, -1 or 0 for both) of traffic
    are those of each way, seen along it; `transitions` the OSM ids of ways whose line changes its position among the
    lanes (``placement=transition``). Streets end where `restrictions` forbid to go on. They are in ascending lowest
    way id and place along that way, intersections in ascending node id.
    """
    start, end = pieces.node[pieces.first], pieces.node[pieces.last]
    second, last_but_one = pieces.node[pieces.first + 1], pieces.node[pieces.last - 1]
    neighbour = points[np.column_stack([second, last_but_one]).ravel()]
    flow = np.asarray(directions, np.int64)[pieces.way]
    osm_way = [attributes[way].osm_way_id for way in pieces.way.tolist()] if restrictions else []
    forbidden = _forbidden_passages(np.column_stack([start, end]).ravel(), osm_way, nodes.ids, restrictions)
    chains = make_chains(start, end, flow, points, neighbour, forbidden)
    row, place = _rows(chains, pieces)
    ends = np.array([[row[a], row[b - 1]] for a, b in pairwise(place)], np.int64)
    ring = np.array([chain.ring for chain in chains], np.bool_)
    crossing = sorted_unique(ends[~ring])
    at = np.where(ring[:, None], -1, np.searchsorted(crossing, ends))
    street_points = np.ascontiguousarray(points[row])
    street_nodes = nodes.ids[row]
    streets = tuple(
        Street(
            id=number,
            start=int(at[number, 0]),
            end=int(at[number, 1]),
            points=street_points[place[number] : place[number + 1]],
            node_ids=street_nodes[place[number] : place[number + 1]],
            pieces=_through_transitions(stretches, transitions) if transitions else stretches,
        )
        for number, stretches in enumerate(_stretches(chains, pieces, attributes))
    )
    return streets, _intersections(crossing, nodes, points, at)


def report_head_on(
    streets: Sequence[Street], intersections: Sequence[Intersection], diagnostics: Diagnostics
) -> None:
    """Report nodes at which a street goes on as one that is one-way the other way round, and nothing else leads on.

    There is nothing to report where another street leads on, or where ways part or merge at the edge of an area.
    """
    for node in intersections:
        flows = [_flow_into(streets[number], at_start) for number, at_start in node.arms]
        if len(flows) < 2 or flows[0] == 0 or flows != flows[:1] * len(flows):
            continue
        for one, other in combinations(node.arms, 2):
            (a, along), (b, onwards) = (_arm(streets[number], at_start) for number, at_start in (one, other))
            same = a.road == b.road or a.highway == b.highway
            if same and dot(along, onwards) < -_GOES_ON:
                ways = f"the one-ways way/{a.osm_way_id} and way/{b.osm_way_id}"
                what = "meet head-on here and no way leads on" if flows[0] > 0 else "part here and no way leads here"
                diagnostics.note("oneway-head-on", f"node/{node.osm_node_id}", f"{ways} {what}")


def _flow_into(street: Street, at_start: bool) -> int:
    """Return 1 where cars only come out of a street at its start or end, -1 where they only go in there, else 0."""
    directions = street.pieces[0 if at_start else -1][1].car_directions()
    if len(directions) != 1 or Direction.BOTH in directions:
        return 0
    return 1 if (Direction.BACKWARD in directions) == at_start else -1


def _arm(street: Street, at_start: bool) -> tuple[StreetAttributes, FloatArray]:
    """Return the attributes of a street at its start or end, and the direction in which it leads away from there."""
    points = street.points if at_start else street.points[::-1]
    away = points[1] - points[0]
    return street.pieces[0 if at_start else -1][1], away / hypot(*away)


def _forbidden_passages(
    node: IntArray, osm_way: Sequence[int], node_ids: IntArray, restrictions: Sequence[TurnRestriction]
) -> set[tuple[int, int]]:
    """Return pairs of ends of pieces that meet alone and where restrictions forbid to go on from one to the other.

    `node` (2 x pieces,) are the nodes at the ends of pieces, `osm_way` the OSM ids of their ways.
    """
    by_node: dict[int, list[TurnRestriction]] = {}
    for item in restrictions:
        if item.via_node is not None:
            by_node.setdefault(item.via_node, []).append(item)
    if not by_node:
        return set()
    ends = np.flatnonzero(np.isin(node_ids[node], list(by_node)))
    meeting: dict[int, list[int]] = {}
    for end in ends.tolist():
        meeting.setdefault(int(node_ids[node[end]]), []).append(end)
    found: set[tuple[int, int]] = set()
    for via, both in meeting.items():
        if len(both) == 2:
            for one, other in (both, both[::-1]):
                ways = osm_way[one // 2], osm_way[other // 2]
                # Where a way runs on through the node, a relation means turns off it, or back on it.
                if ways[0] != ways[1] and forbids(by_node[via], *ways):
                    found.add((one, other))
    return found


def tags_on_streets(row: IntArray, nodes: RawNodes, same_node: Mapping[int, int]) -> dict[int, dict[str, str]]:
    """Return the tags of nodes by id, joined with those of nodes at the same place; `row` (n,) are ids on streets."""
    carried = set(row.tolist())
    found: dict[int, dict[str, str]] = {}
    for number, tags in nodes.tags.items():
        place = same_node.get(number, number)
        if place in carried:
            found[place] = {**street_node_tags(tags), **found.get(place, {})}
    return dict(sorted(found.items()))


def _rows(chains: Sequence[Chain], pieces: Pieces) -> tuple[IntArray, list[int]]:
    """Return the nodes of all chains one after the other, and where each chain begins (and the last one ends)."""
    piece = np.array([piece for chain in chains for piece, _ in chain.links], np.int64)
    along = np.array([along for chain in chains for _, along in chain.links], np.bool_)
    links = np.array([len(chain.links) for chain in chains], np.int64)
    is_last = np.zeros(len(piece), np.int64)
    is_last[np.cumsum(links) - 1] = 1
    # The last node of a piece is the first one of the next.
    length = pieces.last[piece] - pieces.first[piece] + is_last
    step = ranks(length)
    begin = np.where(along, pieces.first[piece], pieces.last[piece])
    row = pieces.node[np.repeat(begin, length) + np.repeat(np.where(along, 1, -1), length) * step]
    place = starts(length)[starts(links)]
    return row, place.tolist()


def _stretches(
    chains: Sequence[Chain], pieces: Pieces, attributes: Sequence[StreetAttributes]
) -> list[tuple[tuple[int, StreetAttributes], ...]]:
    """Return for each chain its attributes, each with the index of the node from which on they hold."""
    ways: list[int] = pieces.way.tolist()
    lengths: list[int] = (pieces.last - pieces.first).tolist()
    turned: dict[int, StreetAttributes] = {}
    out: list[tuple[tuple[int, StreetAttributes], ...]] = []
    for chain in chains:
        stretches: list[tuple[int, StreetAttributes]] = []
        at = 0
        for piece, along in chain.links:
            way = ways[piece]
            if not along and way not in turned:
                turned[way] = turned_round(attributes[way])
            seen = attributes[way] if along else turned[way]
            if not stretches or stretches[-1][1] is not seen:
                stretches.append((at, seen))
            at += lengths[piece]
        out.append(tuple(stretches))
    return out


def _through_transitions(
    stretches: tuple[tuple[int, StreetAttributes], ...], transitions: Set[int]
) -> tuple[tuple[int, StreetAttributes], ...]:
    """Interpolate the offset of the carriageway's middle over transitions, in equal steps.

    At the end of a street there is nothing to interpolate to; there the line stays the middle.
    """
    out = list(stretches)
    known = [k for k, (_, attributes) in enumerate(out) if attributes.osm_way_id not in transitions]
    for before, after in pairwise(known):
        first, last = out[before][1].middle_offset, out[after][1].middle_offset
        for k in range(before + 1, after):
            share = (k - before) / (after - before)
            out[k] = out[k][0], replace(out[k][1], middle_offset=first + share * (last - first))
    return tuple(out)


def _intersections(crossing: IntArray, nodes: RawNodes, points: FloatArray, at: IntArray) -> tuple[Intersection, ...]:
    arms: list[list[tuple[int, bool]]] = [[] for _ in range(len(crossing))]
    for street, (start, end) in enumerate(at.tolist()):
        if start >= 0:
            arms[start].append((street, True))
            arms[end].append((street, False))
    ids = nodes.ids[crossing].tolist()
    places = points[crossing].tolist()
    return tuple(
        Intersection(number, ids[number], places[number][0], places[number][1], tuple(meeting))
        for number, meeting in enumerate(arms)
    )


@record
class Chain:
    """A sequence of pieces."""

    links: tuple[Link, ...]
    ring: bool  # Whether it is closed without any intersection


def make_chains(
    start: IntArray,
    end: IntArray,
    flow: IntArray,
    points: FloatArray,
    neighbour: FloatArray,
    forbidden: Set[tuple[int, int]] = frozenset(),
) -> list[Chain]:
    """Join pieces into chains, in ascending order of the lowest piece of each.

    `start` and `end` (m,) are the nodes at the ends of each piece, `points` (n, 2) all nodes, m. `flow` (m,) is 1 or
    -1 where traffic runs only along or against the piece, else 0; `neighbour` (2 m, 2) is the position of the node
    next to each end of each piece (2 x piece, plus 1 for its end). Pieces are in ascending OSM id of their ways.
    `forbidden` has pairs of ends at one node: coming from the first, nobody may go on at the second.
    """
    siblings: list[int] = _siblings(start, end, flow, points, neighbour, forbidden).tolist()
    flows: list[int] = flow.tolist()
    visited = [False] * len(flows)
    chains: list[Chain] = []
    for piece in range(len(flows)):
        if visited[piece]:
            continue
        links, closed = _walk(piece, siblings)
        for other, _ in links:
            visited[other] = True
        chains += _directed(links, closed, flows)
    chains.sort(key=lambda chain: min(chain.links)[0])
    return chains


def _siblings(
    start: IntArray,
    end: IntArray,
    flow: IntArray,
    points: FloatArray,
    neighbour: FloatArray,
    forbidden: Set[tuple[int, int]],
) -> IntArray:
    """Return for each end of a piece (2 x piece, plus 1 for its end) the end that continues the chain, or -1."""
    siblings = np.full(2 * len(start), -1, np.int64)
    node = np.column_stack([start, end]).ravel()
    order = np.argsort(node, kind="stable")
    ordered = node[order]
    first = np.flatnonzero(np.diff(ordered, prepend=-1))
    pairs = first[np.diff(np.append(first, len(ordered))) == 2]
    a, b = order[pairs], order[pairs + 1]
    # Where traffic can reach the other end of a piece (`^ 1`), it can enter the piece at this one.
    onwards, back = _reaches(a, flow) & _reaches(b ^ 1, flow), _reaches(b, flow) & _reaches(a ^ 1, flow)
    through = onwards | back
    if forbidden:
        ends = list(zip(a.tolist(), b.tolist(), strict=True))
        through &= ~(onwards & [pair in forbidden for pair in ends])
        through &= ~(back & [pair[::-1] in forbidden for pair in ends])
    through &= ~turns_back(neighbour[a], points[node[a]], neighbour[b])
    siblings[a[through]] = b[through]
    siblings[b[through]] = a[through]
    return siblings


def _reaches(ends: IntArray, flow: IntArray) -> BoolArray:
    """Return which ends of pieces traffic can reach along the piece."""
    return np.where(ends % 2 == 1, flow[ends // 2] >= 0, flow[ends // 2] <= 0)


def _walk(piece: int, siblings: Sequence[int]) -> tuple[list[Link], bool]:
    """Collect the whole chain of a piece, and whether it closes on itself."""
    ahead = [(piece, True)]
    at = siblings[2 * piece + 1]
    while at >= 0:
        if at // 2 == piece:
            return ahead, True
        ahead.append((at // 2, at % 2 == 0))
        at = siblings[at ^ 1]
    behind: list[Link] = []
    at = siblings[2 * piece]
    while at >= 0:
        behind.append((at // 2, at % 2 == 1))
        at = siblings[at ^ 1]
    return behind[::-1] + ahead, False


def _directed(links: list[Link], closed: bool, flows: Sequence[int]) -> list[Chain]:
    """Give a chain the direction of its one-way pieces; split it where these run against each other.

    The chain initially runs along its lowest piece, so that the result does not depend on where the walk began.
    """
    signs = [flows[piece] if along else -flows[piece] for piece, along in links]
    if min(signs) >= 0 or max(signs) <= 0:
        return [_chain(links, min(signs), closed)]
    if closed:
        first = next(place for place, sign in enumerate(signs) if sign)
        links, signs = links[first:] + links[:first], signs[first:] + signs[:first]
    chains: list[Chain] = []
    part: list[Link] = []
    running = 0
    # Number of links of the part up to its last one-way piece.
    directed = 0
    for link, sign in zip(links, signs, strict=True):
        if sign * running < 0:
            # Two-way pieces between them stay with the lower piece, whatever the direction of the walk.
            rest = part[directed:] if link[0] < part[directed - 1][0] else []
            chains.append(_chain(part[: len(part) - len(rest)], running, ring=False))
            part, running = rest, 0
        part.append(link)
        if sign:
            running, directed = sign, len(part)
    chains.append(_chain(part, running, ring=False))
    return chains


def _chain(links: list[Link], running: int, ring: bool) -> Chain:
    """Return a chain in the direction of its one-way pieces, which run along (1) or against (-1) the links."""
    return Chain(tuple((piece, not along) for piece, along in reversed(links)) if running < 0 else tuple(links), ring)
