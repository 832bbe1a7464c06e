"""The pieces of roads that an area keeps, and their ids."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from typing import Final, NamedTuple

from osm2xodr.curves import lengths
from osm2xodr.errors import EmptyAreaError, InputError
from osm2xodr.geometry.defaults import SHORTEST_NAME
from osm2xodr.model import Borders, Partition, RoadLink, RoadMap, RoadName

# Ids of the last area end here: CARLA reads them as signed numbers of 32 bits.
_IDS_END: Final = 2**31


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
