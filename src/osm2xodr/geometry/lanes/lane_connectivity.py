"""Which lane leads to which where ``connectivity`` relations say so, at junctions and along roads.

They count lanes from 1 at the left, those of the direction of travel only; lanes for bicycles, which OSM tags as
``cycleway``, are not counted.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from osm2xodr.model import Direction, LaneConnectivity, LaneSpec, LaneType
from osm2xodr.system import record

COUNTED_LANES = frozenset({LaneType.DRIVING, LaneType.BUS, LaneType.TAXI})
"""The types of lanes that relations count."""

LanePair = tuple[int, int]
"""(entry lane, exit lane), from 0 at the left as their drivers see them."""


@record
class StatedLanes:
    """What relations say about one way through a junction or along a road."""

    # (lane, lane it leads to, whether the link is optional), from 1 at the left
    pairs: tuple[tuple[int, int, bool], ...]
    relations: tuple[int, ...]  # OSM ids

    def between(self, entry: Sequence[LaneSpec], exit_: Sequence[LaneSpec]) -> tuple[LanePair, ...] | None:
        """Return the links as indices of all lanes of the direction of travel; None if they name a missing lane."""
        ins, outs = _counted(entry), _counted(exit_)
        if any(not (0 < a <= len(ins) and 0 < b <= len(outs)) for a, b, _ in self.pairs):
            return None
        return tuple((ins[a - 1], outs[b - 1]) for a, b, _ in self.pairs)


def _counted(specs: Sequence[LaneSpec]) -> list[int]:
    """Return the indices of the lanes that relations count."""
    return [k for k, spec in enumerate(specs) if spec.type in COUNTED_LANES]


@dataclass(slots=True)
class Connectivity:
    """All connectivity relations, ready to be looked up."""

    _over_node: dict[tuple[int, int, int], LaneConnectivity] = field(default_factory=dict)
    _over_ways: dict[int, list[LaneConnectivity]] = field(default_factory=dict)
    _between: dict[tuple[int, int], LaneConnectivity] = field(default_factory=dict)

    @classmethod
    def of(cls, items: Iterable[LaneConnectivity]) -> Connectivity:
        """Index relations by the ways and nodes that they are looked up by."""
        out = cls()
        for item in items:
            if item.via_node is None:
                out._over_ways.setdefault(item.from_way, []).append(item)
            else:
                out._over_node.setdefault((item.from_way, item.via_node, item.to_way), item)
                out._between.setdefault((item.from_way, item.to_way), item)
        return out

    def __bool__(self) -> bool:
        return bool(self._over_node or self._over_ways)

    def along(self, ways: Sequence[int], nodes: Sequence[int]) -> StatedLanes | None:
        """Return what relations say about a path over ways; None unless they cover it from start to end.

        No two `ways` in a row are the same; `nodes` are the OSM nodes between them.
        """
        found: list[LaneConnectivity] = []
        k = 0
        while k < len(nodes):
            item = self._from(ways, nodes, k)
            if item is None:
                return None
            found.append(item)
            k += 1 + len(item.via_ways)
        if not found:
            return None
        pairs = {(a, b): optional for a, b, optional in found[0].lanes}
        for item in found[1:]:
            pairs = {(a, c): one or other for (a, b), one in pairs.items() for b2, c, other in item.lanes if b2 == b}
        return StatedLanes(
            tuple((a, b, optional) for (a, b), optional in sorted(pairs.items())),
            tuple(item.osm_relation_id for item in found),
        )

    def _from(self, ways: Sequence[int], nodes: Sequence[int], k: int) -> LaneConnectivity | None:
        for item in self._over_ways.get(ways[k], ()):
            last = k + 1 + len(item.via_ways)
            if tuple(ways[k + 1 : last]) == item.via_ways and last < len(ways) and ways[last] == item.to_way:
                return item
        return self._over_node.get((ways[k], nodes[k], ways[k + 1]))

    def at_border(self, before: int, after: int) -> dict[Direction, StatedLanes]:
        """Return what relations say about either direction where one way continues as another within a road."""
        out: dict[Direction, StatedLanes] = {}
        for direction, pair in ((Direction.FORWARD, (before, after)), (Direction.BACKWARD, (after, before))):
            if pair in self._between:
                item = self._between[pair]
                out[direction] = StatedLanes(item.lanes, (item.osm_relation_id,))
        return out
