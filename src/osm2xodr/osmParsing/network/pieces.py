"""Ways are cut into pieces between the nodes where streets may meet; flat arrays over all ways.

Absent nodes are left out, or cut the way where they leave a long gap; consecutive nodes at one place become one. Ways
are cut at nodes that are shared or visited twice; spikes are shortened, pieces on top of others left out. Of ways
whose one direction changes with time, those that meet head-on decide which way their traffic runs.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import Table, arcsine, arctan2, cosine, hypot, repeated, runs, sine, sorted_unique, unique_rows
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.osmParsing.file import RawNodes, RawWay
from osm2xodr.osmParsing.tags import changes_direction, oneway
from osm2xodr.system import record

# Consecutive nodes nearer to each other than this become one, m: OSM's coordinates have steps of 1 cm.
_SAME_NODE_DISTANCE: Final = 1e-3
# A line that turns by more than this, rad (150 degrees), between segments longer than this, m, turns on the spot: a
# junction can do that, a road cannot. Between shorter segments it is a mapping error. Choices.
_TURN_ON_THE_SPOT: Final = 2.618
_MAPPING_ERROR_MAX: Final = 5.0
# Gaps of absent nodes up to this length are bridged, m; at longer ones, where a way leaves the area and comes back,
# it is cut. A choice: a few times the usual distance of nodes on straight roads.
_GAP_BRIDGED_MAX: Final = 200.0
# Consecutive nodes farther from each other than this are an error of the map, m. A choice: the longest straight roads
# of the Earth have nodes every few kilometres; the longest edge of a street in 24 extracts measures 1.5 km.
_EDGE_MAX: Final = 50e3
# Streets of more than this in a square of this width, m, or of more pieces between junctions, have no room beside
# each other. In 24 extracts, with all kinds of ways, one square has 2.3 km and another one 120 ends of streets at
# junctions; twice and three times that leave room for car parks of several storeys.
_CROWD_MAX: Final = 7e3
_CROWD_PIECES: Final = 250
_CROWD_CELL: Final = 200.0
# How far apart the points are by which streets are counted, m, and how many are looked at together.
_CROWD_STEP: Final = 25.0
_CROWD_BLOCK: Final = 1_000_000
# Streets of more than this in all, m, have a node in the mean at least every so many metres, and meet others at so
# many for each end that meets two and more. Choices: the edges of 24 extracts measure 11 to 76 m in the mean; the
# sparsest maps are those of prairies, with streets every mile that have no nodes but where they cross.
_SPARSE_FROM: Final = 3e6
_SPARSE_EDGE: Final = 200.0
_SPARSE_END: Final = 1000.0
# Mean radius of the Earth (IUGG), m.
_EARTH_RADIUS: Final = 6371.0088e3

# Tags of the direction along the nodes: the mapper had that one in mind.
_ALONG: Final = ":forward"


@record(eq=False)
class Lines(Table):
    """Ways, or parts of them, as sequences of nodes."""

    node: IntArray  # (n,) Indices into the nodes, line after line
    line: IntArray  # (n,) Number of the line, ascending
    way: IntArray  # (n,) Index of the way; ascending
    skipped: BoolArray  # (n,) Whether absent nodes of the way come right before


@record(eq=False)
class Pieces:
    """Parts of ways between nodes where streets may meet, in ascending way and place along it."""

    node: IntArray  # (n,) Indices into the nodes, line after line
    # (m,) Indices into `node` of each piece's ends
    first: IntArray
    last: IntArray
    way: IntArray  # (m,) Index of the way


def make_lines(ways: Sequence[RawWay], nodes: RawNodes, diagnostics: Diagnostics) -> Lines:
    """Look up the nodes of ways; leave out absent and repeated nodes, and ways of less than two nodes."""
    lengths = np.array([len(way.refs) for way in ways], np.int64)
    refs = np.concatenate([way.refs for way in ways])
    way = repeated(lengths)
    node = np.minimum(np.searchsorted(nodes.ids, refs), max(len(nodes.ids) - 1, 0))
    present = nodes.ids[node] == refs if len(nodes.ids) else np.zeros(len(refs), np.bool_)
    absent = np.bincount(way[~present], minlength=len(ways))
    for index in np.flatnonzero(absent).tolist():
        words = f"{absent[index]} of its {lengths[index]} nodes are absent or without a position and are left out"
        diagnostics.dropped("absent-node", f"way/{ways[index].id}", words)
    place = np.flatnonzero(present)
    skipped = np.diff(place, prepend=-1) > 1
    lines = _without_repeats(Lines(node[present], way[present], way[present], skipped))
    single = np.bincount(lines.line, minlength=len(ways)) == 1
    gone = (np.bincount(way, minlength=len(ways)) > 0) & (np.bincount(lines.line, minlength=len(ways)) <= 1)
    for index in np.flatnonzero(gone | (lengths == 0)).tolist():
        diagnostics.dropped("short-way", f"way/{ways[index].id}", "has less than two nodes and is left out")
    return lines.chosen(~single[lines.line])


def leave_out_far_nodes(lines: Lines, nodes: RawNodes, ways: Sequence[RawWay], diagnostics: Diagnostics) -> Lines:
    """Leave out edges that are too long to be true, and nodes that have no others."""
    far = np.zeros(len(lines.node) + 1, np.bool_)
    along = lines.line[1:] == lines.line[:-1]
    lengths = _distances(nodes, lines.node[:-1], lines.node[1:])
    far[1:-1] = along & (lengths > _EDGE_MAX)
    if not far.any():
        return lines
    first, last = np.ones(len(lines.node), np.bool_), np.ones(len(lines.node), np.bool_)
    first[1:] = last[:-1] = ~along
    lonely = (first | far[:-1]) & (last | far[1:])
    # Of two nodes that only have each other none is more likely to be wrong.
    alone = lonely & (np.bincount(lines.line, ~lonely)[lines.line] > 0)
    number, way = nodes.ids[lines.node], lines.way
    for k in np.flatnonzero(alone).tolist():
        apart = max(lengths[k - 1] if far[k] else 0.0, lengths[k] if far[k + 1] else 0.0)
        words = f"lies {apart / 1e3:,.0f} km from its neighbours on way/{ways[way[k]].id} and is left out there"
        diagnostics.dropped("far-node", f"node/{number[k]}", words)
    cut = far[1:-1] & ~alone[1:] & ~alone[:-1]
    for k in np.flatnonzero(cut).tolist():
        words = f"its {lengths[k] / 1e3:,.0f} km from node/{number[k]} to node/{number[k + 1]} are left out"
        diagnostics.dropped("far-node", f"way/{ways[way[k]].id}", words)
    keep = ~lonely
    # Where nodes between them are left out, the rest may be near to each other, as at absent nodes.
    skipped = lines.skipped.copy()
    skipped[1:] |= alone[:-1]
    rest = Lines(lines.node, lines.line, way, skipped).chosen(keep)
    split = np.zeros(len(rest.node), np.bool_)
    split[1:] = _distances(nodes, rest.node[:-1], rest.node[1:]) > _EDGE_MAX
    return _with_new_lines(rest, split)


def _distances(nodes: RawNodes, a: IntArray, b: IntArray) -> FloatArray:
    """Return the distances on a sphere between nodes (indices), (n,), m, by the haversine formula."""
    lat, lon = np.radians(nodes.lat_deg), np.radians(nodes.lon_deg)
    square = sine((lat[b] - lat[a]) / 2.0) ** 2
    square += cosine(lat[a]) * cosine(lat[b]) * sine((lon[b] - lon[a]) / 2.0) ** 2
    out: FloatArray = 2.0 * _EARTH_RADIUS * arcsine(np.sqrt(np.minimum(square, 1.0)))
    return out


def _with_new_lines(lines: Lines, split: BoolArray) -> Lines:
    """Begin a new line at some nodes as well, and leave out lines of single nodes."""
    line = np.cumsum((np.diff(lines.line, prepend=-1) != 0) | split) - 1
    cut = Lines(lines.node, line, lines.way, lines.skipped)
    return cut.chosen(np.bincount(line, minlength=1)[line] > 1)


def _without_repeats(lines: Lines) -> Lines:
    """Leave out nodes that repeat the one before."""
    return lines.chosen((np.diff(lines.node, prepend=-1) != 0) | (np.diff(lines.line, prepend=-1) != 0))


def join_same_places(
    lines: Lines, points: FloatArray, nodes: RawNodes, diagnostics: Diagnostics
) -> tuple[Lines, dict[int, int]]:
    """Join consecutive nodes at one place into the one with the lowest id.

    Returns the lines through the remaining nodes, and the OSM ids of joined nodes, each with the remaining one's.
    """
    a, b = lines.node[:-1], lines.node[1:]
    near = hypot(*(points[b] - points[a]).T) < _SAME_NODE_DISTANCE
    near &= lines.line[1:] == lines.line[:-1]
    if not near.any():
        return lines, {}
    lowest = np.arange(len(nodes.ids))
    pairs = unique_rows(np.sort(np.column_stack([a[near], b[near]]), axis=1)).values
    # Nodes are in ascending id: every node is led to the lowest one of its group.
    changed = True
    while changed:
        low = np.minimum(lowest[pairs[:, 0]], lowest[pairs[:, 1]])
        before = lowest.copy()
        np.minimum.at(lowest, pairs[:, 0], low)
        np.minimum.at(lowest, pairs[:, 1], low)
        lowest = lowest[lowest]
        changed = bool((lowest != before).any())
    same: dict[int, int] = {}
    for index in np.flatnonzero(lowest != np.arange(len(lowest))).tolist():
        number, other = int(nodes.ids[index]), int(nodes.ids[lowest[index]])
        same[number] = other
        diagnostics.repaired("same-place", f"node/{number}", f"lies on node {other} and is joined with it")
    moved = Lines(lowest[lines.node], lines.line, lines.way, lines.skipped)
    return _without_repeats(moved), same


def cut_gaps(lines: Lines, points: FloatArray, ways: Sequence[RawWay], diagnostics: Diagnostics) -> Lines:
    """Cut lines where absent nodes leave a gap too long to bridge; leave out ends of single nodes."""
    gap = np.zeros(len(lines.node), np.bool_)
    apart = hypot(*(points[lines.node[1:]] - points[lines.node[:-1]]).T) > _GAP_BRIDGED_MAX
    gap[1:] = lines.skipped[1:] & (lines.line[1:] == lines.line[:-1]) & apart
    if not gap.any():
        return lines
    for index in sorted_unique(lines.way[gap]).tolist():
        diagnostics.repaired("absent-node", f"way/{ways[index].id}", "leaves the area and comes back, cut there")
    return _with_new_lines(lines, gap)


def cut_at_shared_nodes(lines: Lines, points: FloatArray, ways: Sequence[RawWay], diagnostics: Diagnostics) -> Pieces:
    """Cut lines where streets may meet, and leave out pieces on top of others.

    The cuts are at nodes visited more than once, and where a way turns on the spot, which no road does.
    """
    count = len(lines.node)
    if count == 0:
        empty = np.zeros(0, np.int64)
        return Pieces(empty, empty, empty, empty)
    first_of_line = np.diff(lines.line, prepend=-1) != 0
    last_of_line = np.roll(first_of_line, -1)
    visits = np.bincount(lines.node)
    back = np.zeros(count, np.bool_)
    back[1:-1] = turns_back(points[lines.node[:-2]], points[lines.node[1:-1]], points[lines.node[2:]])
    cuts = np.flatnonzero(first_of_line | last_of_line | back | (visits[lines.node] > 1))
    within = ~last_of_line[cuts[:-1]]
    first, last = cuts[:-1][within], cuts[1:][within]
    # Of a spike, out and back over the same nodes, only the way out stays.
    spike = (last - first == 2) & (lines.node[first] == lines.node[last])
    last = last - spike
    pieces = Pieces(lines.node, first, last, lines.way[first])
    keep = _topmost(pieces)
    for index in sorted_unique(pieces.way[~keep]).tolist():
        words = "runs on top of another way over the same nodes and is left out there"
        diagnostics.dropped("duplicate-way", f"way/{ways[index].id}", words)
    for index in sorted_unique(pieces.way[spike & keep]).tolist():
        diagnostics.repaired("spike", f"way/{ways[index].id}", "comes back over its nodes, the way back is left out")
    return Pieces(lines.node, first[keep], last[keep], pieces.way[keep])


def leave_out_crowds(pieces: Pieces, points: FloatArray, ways: Sequence[RawWay], diagnostics: Diagnostics) -> Pieces:
    """Leave out pieces where more streets lie than have room, or meet: their time grows with the square."""
    edges = runs(pieces.first, pieces.last - pieces.first)
    piece = repeated(pieces.last - pieces.first)
    a, b = points[pieces.node[edges]], points[pieces.node[edges + 1]]
    length = hypot(*(b - a).T)
    steps = np.maximum(1, np.ceil(length / _CROWD_STEP)).astype(np.int64)
    cells, owners, metres = [], [], []
    # In blocks: a country has a point in 25 m as well.
    for rows in np.split(np.arange(len(edges)), np.flatnonzero(np.diff(np.cumsum(steps) // _CROWD_BLOCK)) + 1):
        row = np.repeat(rows, steps[rows])
        place = (runs(np.zeros(len(rows), np.int64), steps[rows]) + 0.5) / steps[row]
        cell = np.floor((a[row] + (b - a)[row] * place[:, None]) / _CROWD_CELL).astype(np.int64)
        pairs, _, index, _ = unique_rows(np.column_stack([cell, piece[row]]))
        cells.append(pairs[:, :2])
        owners.append(pairs[:, 2])
        metres.append(np.bincount(index, (length / steps)[row]))
    cell_of = unique_rows(np.concatenate(cells)).inverse
    full = np.bincount(cell_of, np.concatenate(metres)) > _CROWD_MAX
    full |= np.bincount(cell_of) > _CROWD_PIECES
    if not full.any():
        return pieces
    out = np.zeros(len(pieces.first), np.bool_)
    out[np.concatenate(owners)[full[cell_of]]] = True
    for index in sorted_unique(pieces.way[out]).tolist():
        words = (
            f"lies where there are over {_CROWD_MAX / 1e3:g} km of streets in a square of {_CROWD_CELL:g} m, left out"
        )
        diagnostics.dropped("crowd", f"way/{ways[index].id}", words)
    return Pieces(pieces.node, pieces.first[~out], pieces.last[~out], pieces.way[~out])


def most_met(pieces: Pieces) -> tuple[int, int]:
    """Return at how many ends of pieces the node (index) lies at which most of them meet, and that node."""
    met = np.bincount(pieces.node[np.concatenate([pieces.first, pieces.last])], minlength=1)
    return int(met.max()), int(met.argmax())


def sparse_streets(pieces: Pieces, nodes: RawNodes) -> tuple[float, int] | None:
    """Return the length of all streets, m, and the way (index) with the longest piece, if there are too few nodes.

    Time and memory go with the length, and nobody maps the ground like that.
    """
    count = pieces.last - pieces.first
    edges = runs(pieces.first, count)
    lengths = np.bincount(repeated(count), _distances(nodes, pieces.node[edges], pieces.node[edges + 1]))
    met = np.bincount(pieces.node[np.concatenate([pieces.first, pieces.last])])
    total = float(lengths.sum())
    if total <= max(_SPARSE_FROM, _SPARSE_EDGE * len(edges) + _SPARSE_END * int(met[met > 2].sum())):
        return None
    return total, int(pieces.way[lengths.argmax()])


def turns_back(before: FloatArray, here: FloatArray, after: FloatArray) -> BoolArray:
    """Return where lines through (n, 2), (n, 2), (n, 2) turn on the spot and not by a mapping error, (n,)."""
    arriving, leaving = here - before, after - here
    cross = arriving[:, 0] * leaving[:, 1] - arriving[:, 1] * leaving[:, 0]
    turn = np.abs(arctan2(cross, (arriving * leaving).sum(axis=1)))
    shorter = np.minimum(hypot(*arriving.T), hypot(*leaving.T))
    out: BoolArray = (turn > _TURN_ON_THE_SPOT) & (shorter > _MAPPING_ERROR_MAX)
    return out


def _topmost(pieces: Pieces) -> BoolArray:
    """Return which pieces stay: of several segments between the same two nodes the first. Others cannot coincide."""
    keep = np.ones(len(pieces.first), np.bool_)
    short = np.flatnonzero(pieces.last - pieces.first == 1)
    ends = np.sort(np.column_stack([pieces.node[pieces.first[short]], pieces.node[pieces.last[short]]]), axis=1)
    keep[np.delete(short, unique_rows(ends).first)] = False
    return keep


def with_one_flow(ways: Sequence[RawWay], diagnostics: Diagnostics) -> list[RawWay]:
    """Return ways of which those with ``oneway=reversible`` run on where two of a class meet.

    Each is taken as one-way along its nodes. Where two of them, and no third one of their class, are drawn towards
    each other or away from each other, no car could go on: all of their chain then run as most of its ways that have
    tags of the direction along their nodes, or else as most of its nodes.
    """
    ends: dict[tuple[int, str], list[tuple[int, int]]] = defaultdict(list)
    for index, way in enumerate(ways):
        if len(way.refs) > 1 and changes_direction(way.tags) and oneway(way.tags)[0] == 1:
            for end in (0, -1):
                ends[int(way.refs[end]), way.tags["highway"]].append((index, end))
    beside: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for meeting in ends.values():
        if len(meeting) == 2 and meeting[0][0] != meeting[1][0]:
            (one, end), (other, its) = meeting
            turn = -1 if end == its else 1
            beside[one].append((other, turn))
            beside[other].append((one, turn))
    out = list(ways)
    seen: set[int] = set()
    for index in sorted(beside):
        if index not in seen:
            chain = _directions(index, beside)
            seen |= chain.keys()
            for turned in _against(chain, ways):
                way = ways[turned]
                out[turned] = replace(way, tags={**way.tags, "oneway": "-1"})
                words = f"oneway={way.tags['oneway']} meets another one head-on, taken as one-way against its nodes"
                diagnostics.guessed("oneway", f"way/{way.id}", words)
    return out


def _directions(first: int, beside: dict[int, list[tuple[int, int]]]) -> dict[int, int]:
    """Return the ways of a chain, by index, and whether each is drawn like the first, 1, or the other way, -1."""
    out, ahead = {first: 1}, [first]
    while ahead:
        one = ahead.pop()
        for other, turn in beside[one]:
            if other not in out:
                out[other] = out[one] * turn
                ahead.append(other)
    return out


def _against(chain: dict[int, int], ways: Sequence[RawWay]) -> list[int]:
    """Return the ways of a chain that run against their nodes."""

    def weight(side: int) -> tuple[int, int]:
        own = [ways[index] for index, drawn in chain.items() if drawn == side]
        return sum(any(_ALONG in key for key in way.tags) for way in own), sum(len(way.refs) for way in own)

    along = 1 if weight(1) >= weight(-1) else -1
    return sorted(index for index, drawn in chain.items() if drawn != along)
