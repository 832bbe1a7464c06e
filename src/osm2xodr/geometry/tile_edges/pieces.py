"""Which area each piece of road belongs to, and the pieces that an area keeps, with their ids."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from osm2xodr.curves import area_at, area_bounds, lengths, owners, places_along, pose, snap_cuts, starts
from osm2xodr.errors import EmptyAreaError, InputError
from osm2xodr.geometry.defaults import SHORTEST_NAME
from osm2xodr.geometry.tile_edges import defaults
from osm2xodr.model import Borders, FloatArray, IntArray, Partition, PlanView, RoadLink, RoadMap, RoadName
from osm2xodr.system import record

# Roads are sampled for their areas this densely, m; between two samples a border is found to this accuracy, m, by
# dividing the interval into this many parts again and again.
_SAMPLES_EVERY: Final = 5.0
_ACCURACY: Final = 1e-6
_PARTS: Final = 200
# Stand for the area of a road end without a junction, where the road's own course decides.
_NO_JUNCTION: Final = -2

# Ids of the last area end here: CARLA reads them as signed numbers of 32 bits.
_IDS_END: Final = 2**31


def find_borders(
    partition: Partition, plan_view: PlanView, end_junction: IntArray, junction_xy: FloatArray
) -> Borders:
    """Divide roads among areas.

    A junction belongs to the area that its origin lies in, and with it the first metres of its arms
    (`defaults.BORDER_STUB`). A piece of road shorter than `defaults.BORDER_PIECE` belongs to its neighbour's area.
    `end_junction` (R, 2) is the junction at each road's start and end, -1 for none; `junction_xy` (J, 2) is each
    junction's origin, local x, y, m, and their areas come in the same order.
    """
    length = lengths(plan_view)
    road, s = places_along(plan_view, _SAMPLES_EVERY)
    count = np.bincount(road, minlength=len(length))
    x, y, _ = pose(plan_view, road, s)
    box = area_bounds(partition)
    area = area_at(partition, x, y, box)
    junction_area = area_at(partition, junction_xy[:, 0], junction_xy[:, 1], box)
    at_end = np.where(end_junction >= 0, np.append(junction_area, -1)[end_junction], _NO_JUNCTION)
    first = starts(count)[:-1]
    known = np.where(at_end == _NO_JUNCTION, area[first, None], at_end)
    lowest = np.minimum(np.minimum.reduceat(area, first), known.min(axis=1))
    highest = np.maximum(np.maximum.reduceat(area, first), known.max(axis=1))
    found = [np.array([0.0])] * len(length)
    areas = [area[k : k + 1] for k in first.tolist()]
    for k in np.flatnonzero(lowest != highest).tolist():
        part = slice(int(first[k]), int(first[k] + count[k]))
        line = _Line(partition, box, plan_view, k, float(length[k]), at_end[k].tolist())
        found[k], areas[k] = line.pieces(s[part])
    start = starts([len(item) for item in found])
    of_road = owners(start)
    begin = snap_cuts(plan_view, of_road, np.concatenate(found))
    return Borders(partition, start, begin, np.concatenate(areas), junction_area)


@record(eq=False)
class _Line:
    """A road that belongs to several areas."""

    partition: Partition
    box: FloatArray  # Bounds of its areas
    plan_view: PlanView
    road: int
    length: float  # m
    ends: Sequence[int]  # Areas of the junctions at its start and its end

    def stubs(self) -> tuple[float, float]:
        """Return up to where, and from where on, s, m, the road belongs to the junctions at its ends."""
        stub = min(defaults.BORDER_STUB, self.length / 2)
        start, end = (0.0 if area == _NO_JUNCTION else stub for area in self.ends)
        return start, self.length - end

    def pieces(self, s: FloatArray) -> tuple[FloatArray, IntArray]:
        """Return where pieces begin, m, and their areas, from samples s (n,) along the road that miss no piece."""
        s = np.union1d(s, self.stubs())
        at = self._areas(s).tolist()
        runs: list[tuple[int, float]] = [(at[0], 0.0)]
        for (before, low), (after, high) in pairwise(zip(at, s.tolist(), strict=True)):
            if before != after:
                runs.append((after, self._between(before, low, high)))
        runs = self._without_short(runs)
        return np.array([begin for _, begin in runs]), np.array([number for number, _ in runs], np.int64)

    def _areas(self, s: FloatArray) -> IntArray:
        """Return the areas of places, (n,), near junctions those of the junctions."""
        x, y, _ = pose(self.plan_view, np.full(len(s), self.road), s)
        out = area_at(self.partition, x, y, self.box)
        start, end = self.stubs()
        out[s < start], out[s > end] = self.ends
        return out

    def _between(self, area: int, low: float, high: float) -> float:
        """Return where an area ends between two places, s, m."""
        while high - low > _ACCURACY:
            places = np.linspace(low, high, _PARTS)
            beyond = int(np.argmax(self._areas(places)[1:] != area)) + 1
            low, high = float(places[beyond - 1]), float(places[beyond])
        return high

    def _without_short(self, runs: list[tuple[int, float]]) -> list[tuple[int, float]]:
        """Give short pieces, the shortest first, to the longer of their neighbours."""
        runs = _joined(runs)
        while len(runs) > 1:
            ends = [begin for _, begin in runs[1:]] + [self.length]
            size = [end - begin for (_, begin), end in zip(runs, ends, strict=True)]
            at_junction = {k for k, area in zip((0, len(runs) - 1), self.ends, strict=True) if area != _NO_JUNCTION}
            short = [k for k in range(len(runs)) if k not in at_junction and size[k] < defaults.BORDER_PIECE]
            if not short:
                break
            k = min(short, key=lambda item: (size[item], item))
            near = [item for item in (k - 1, k + 1) if 0 <= item < len(runs)]
            taker = max(near, key=lambda item: (size[item], -item))
            runs[k] = (runs[taker][0], runs[k][1])
            runs = _joined(runs)
        return runs


def _joined(runs: list[tuple[int, float]]) -> list[tuple[int, float]]:
    """Join neighbouring runs of one area."""
    return [run for k, run in enumerate(runs) if not k or run[0] != runs[k - 1][0]]


class Piece(NamedTuple):
    """A piece of a road, from one border between areas or names to the next, or a road as a whole."""

    curve: int  # Index of the road
    # s on the road, m
    begin: float
    end: float
    # Whether it begins with the road, and whether it ends with it
    at_start: bool
    at_end: bool
    area: int  # Index of its area
    id: int  # Its id as a road of the own area; 0 if it belongs to another one


class Pieces:
    """The pieces of all roads of an area and its surroundings, and those of them that the own area keeps.

    Raises an InputError if the area has no road, or more than it has ids for.
    """

    def __init__(self, road_map: RoadMap, borders: Borders) -> None:
        self.partition = borders.partition
        own = self.partition.own
        areas = borders.junction_area.tolist()
        junction_area = {item.id: area for item, area in zip(road_map.junctions, areas, strict=True)}
        # Those of roads outside junctions are known; a connecting road is one, in the area of its junction.
        columns = borders.piece_start, borders.piece_s, borders.piece_area, lengths(road_map.plan_view)
        start, piece_s, piece_area, length = (column.tolist() for column in columns)
        self._next = self._first = self.partition.first_ids[own]
        self._pieces: list[list[Piece]] = []
        for k, road in enumerate(road_map.roads):
            if road.junction is None:
                rows = slice(start[k], start[k + 1])
                where = _with_names(list(zip(piece_s[rows], piece_area[rows], strict=True)), road.names)
            else:
                where = [(0.0, junction_area[road.junction])]
            pieces: list[Piece] = []
            for i, (begin, area) in enumerate(where, 1):
                at_end = i == len(where)
                end, number = length[k] if at_end else where[i][0], self._id() if area == own else 0
                pieces.append(Piece(k, begin, end, i == 1, at_end, area, number))
            self._pieces.append(pieces)
        self._links: dict[int, RoadLink | None] = {}
        self._of = {road.id: pieces for road, pieces in zip(road_map.roads, self._pieces, strict=True)}
        self.kept = [piece for pieces in self._pieces for piece in pieces if piece.id]
        self._junction = {junction: self._id() for junction, area in junction_area.items() if area == own}
        if not self.kept:
            raise EmptyAreaError(f"area {self.name!r} has no road of its own; leave it out")
        check_ids(self.partition, self._next - self._first, "roads and junctions")

    def _id(self) -> int:
        self._next += 1
        return self._next - 1

    @property
    def name(self) -> str:
        """Name of the own area."""
        return self.partition.names[self.partition.own]

    def of(self, road: int) -> list[Piece]:
        """Return the pieces of the road with an id, in order."""
        return self._of[road]

    def at(self, road: int, s: float) -> Piece:
        """Return the piece of the road with an id that s lies on; the nearest one beyond the road's ends."""
        pieces = self.of(road)
        if len(pieces) == 1:
            return pieces[0]
        return pieces[max(bisect_right([piece.begin for piece in pieces], s) - 1, 0)]

    def beside(self, piece: Piece, *, at_start: bool) -> Piece | None:
        """Return the piece before (or after) another one of the same road, None at the road's end."""
        pieces = self._pieces[piece.curve]
        k = pieces.index(piece) + (-1 if at_start else 1)
        return pieces[k] if 0 <= k < len(pieces) else None

    def touched(self, link: RoadLink) -> Piece:
        """Return the piece of a road that a link leads to."""
        return self.of(link.id)[0 if link.at_start else -1]

    def link(self, link: RoadLink) -> RoadLink | None:
        """Return a link with new ids; None where it leads out of the area. Roads share links."""
        if id(link) not in self._links:
            number = self._junction.get(link.id) if link.to_junction else self.touched(link).id
            self._links[id(link)] = RoadLink(link.to_junction, number, link.at_start) if number else None
        return self._links[id(link)]

    def first(self, road: int) -> int:
        """Return the new id of the first piece of a road that is kept, 0 for none."""
        pieces = self._of[road]
        return pieces[0].id or next((piece.id for piece in pieces if piece.id), 0)

    def junction(self, junction: int) -> int | None:
        """Return the new id of the junction with an id; None if it belongs to another area."""
        return self._junction.get(junction)


def _with_names(where: list[tuple[float, int]], names: Sequence[RoadName]) -> list[tuple[float, int]]:
    """Return (begin, area) of the pieces of a road, cut at its names as well where these leave no sliver."""
    out = list(where)
    for name in names[1:]:
        if all(abs(name.s - begin) >= SHORTEST_NAME for begin, _ in where):
            area = max(item for item in where if item[0] < name.s)[1]
            out.append((name.s, area))
    return sorted(out)


def check_ids(partition: Partition, count: int, what: str) -> None:
    """Raise an InputError if the own area has more things of a kind than ids for them."""
    first = partition.first_ids[partition.own]
    end = min((other for other in partition.first_ids if other > first), default=_IDS_END)
    if count > min(end, _IDS_END) - first:
        name = partition.names[partition.own]
        raise InputError(f"area {name!r} has {count} {what}, more than it has ids for; use smaller tiles")
