"""Where buses and bicycles go straight on through junctions against one-way streets: no car may."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import wrapped
from osm2xodr.geometry.defaults import STRAIGHT_ON
from osm2xodr.geometry.junctions.clusters import JunctionLayout
from osm2xodr.geometry.junctions.movements import Movement, inner_streets, unrestricted_path
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import BoolArray, Direction, LaneType, StreetNetwork

# Types of lanes that lead on to each other: buses and taxis as their like, bicycles on their own.
_KINDS: Final = (frozenset({LaneType.BUS, LaneType.TAXI}), frozenset({LaneType.BIKING}))


def with_movements_against_cars(
    network: StreetNetwork, ends: StreetEnds, layout: JunctionLayout, movements: list[Movement]
) -> list[Movement]:
    """Return the movements and those straight on from or to lanes set apart against one-way streets, by junction.

    From such a lane buses, taxis and bicycles go on to their like, else to lanes for cars; to such a lane they come
    from their like alone, so that no car gets there.
    """
    found: list[Movement] = []
    inner_at = inner_streets(network, ends, layout, against_one_way=True)
    for kind in _KINDS:
        into, out = _lanes_of_kind(network, kind)
        against_in, against_out = into & ~ends.enters, out & ~ends.leaves
        some = {int(layout.junction[end]) for end in np.flatnonzero(against_in | against_out).tolist()} - {-1}
        for junction in sorted(some):
            arms = np.array(layout.arms[junction])
            for entry in arms[into[arms]].tolist():
                turn = np.abs(wrapped(ends.hdg[arms] - ends.hdg[entry] - np.pi))
                open_ = (turn < STRAIGHT_ON) & (arms != entry)
                open_ &= (out | ends.leaves)[arms] if against_in[entry] else against_out[arms]
                if open_.any():
                    exit_ = int(arms[np.lexsort((turn, ~out[arms], ~open_))[0]])
                    path = unrestricted_path(network, ends, inner_at, entry, exit_)
                    if path is not None:
                        found.append(Movement(junction, entry, exit_, path, apart=kind))
    return sorted([*movements, *found], key=lambda item: item.junction) if found else movements


def _lanes_of_kind(network: StreetNetwork, kind: frozenset[LaneType]) -> tuple[BoolArray, BoolArray]:
    """Say at which street ends lanes of some types lead into the junction, and out of it, (ends,)."""
    into, out = np.zeros((2, 2 * len(network.streets)), bool)
    for street in network.streets:
        for end in (2 * street.id, 2 * street.id + 1):
            found = {lane.direction for lane in street.attributes_at_end(end).lanes_ltr if lane.type in kind}
            along, back = Direction.FORWARD in found, Direction.BACKWARD in found
            into[end], out[end] = (along, back) if end % 2 else (back, along)
    return into, out
