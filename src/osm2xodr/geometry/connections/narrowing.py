"""Lanes narrow towards a junction that leads to narrower ones, where the roads through it are too short for that."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import unique_all
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads
from osm2xodr.geometry.connections.defaults import STEEPEST_JOIN
from osm2xodr.geometry.defaults import STEEPEST_WIDTH
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.lanes import room_for_tapers, with_narrow_ends
from osm2xodr.model import FloatArray, IntArray, Rule

# More lanes than any road has at a side: a road end's lanes get numbers of their own.
_MOST_LANES: Final = 64
# Widths are rounded to this many decimals of a metre, downwards.
_WIDTH_DECIMALS: Final = 2
_SAME_WIDTH: Final = 1e-6
# Connecting roads are at least this many times as long as their lane's width changes: 7.5 is 1 in 5 where a smooth
# step is steepest, and a little more, as their length changes with the lanes that they join. A choice.
_STEEPEST_NARROWING: Final = 7.75
# Where lanes narrow, the ways between them are drawn again, and have this share of their length at least. A choice:
# of six in three towns the shortest had 0.92, and 0.03 are in what is above.
_SHORTER: Final = 0.94


def even_widths(parts: RoadParts, connecting: ConnectingRoads, rule: Rule, diagnostics: Diagnostics) -> RoadParts:
    """Return roads whose lanes narrow towards junctions where connecting roads would taper too fast.

    Widths only shrink: each lane gets the largest width from which tapers lead to all others that it is linked to,
    `_STEEPEST_NARROWING` times as long as widths change; roads without changes of their own taper from end to end.
    """
    ends = np.concatenate([connecting.entry, connecting.exit])
    lanes = np.concatenate([connecting.entry_lane, connecting.exit_lane])
    keys, first, number, _ = unique_all(ends * 2 * _MOST_LANES + lanes + _MOST_LANES)
    before = np.concatenate([connecting.entry_width, connecting.exit_width])[first]
    one, other = number.reshape(2, -1)
    along = _along_roads(parts, keys)
    one, other = np.concatenate([one, along[0]]), np.concatenate([other, along[1]])
    # Bicycle lanes that join lanes for cars fan out at their end.
    steeper = np.where(connecting.joins_cars, STEEPEST_JOIN / STEEPEST_WIDTH, 1.0)
    length = np.concatenate(
        [connecting.length * steeper, [room_for_tapers(item) for item in parts.length[along[2]].tolist()]]
    )
    step, width = 10.0**_WIDTH_DECIMALS, before
    for share in (1.0, _SHORTER):
        again = (np.minimum(width[one] - before[one], width[other] - before[other]) < 0.0)[: len(connecting.length)]
        length[: len(again)] *= np.where(again, share, 1.0)
        # Rounding may take one end down by all of a step, and the other by nothing.
        width = _reachable(before, one, other, np.maximum(length / _STEEPEST_NARROWING - 1 / step, 0.0))
    narrowed = np.flatnonzero(width < before - _SAME_WIDTH)
    if not len(narrowed):
        return parts
    found: dict[int, dict[int, float]] = {}
    for key, new in zip(keys[narrowed].tolist(), (np.floor(width[narrowed] * step) / step).tolist(), strict=True):
        end, lane = divmod(key, 2 * _MOST_LANES)
        found.setdefault(end, {})[lane - _MOST_LANES] = new
    stretches = list(parts.stretches)
    for road in sorted({end // 2 for end in found}):
        # Where roads touch without a junction between them, their widths stay what they are.
        low, high = (found.get(2 * road + k, {} if parts.end_link[road, k] >= 0 else None) for k in (0, 1))
        stretches[road] = with_narrow_ends(stretches[road], low, high, rule)
    text = "its lanes narrow towards a junction that leads to narrower ones within a few metres"
    for end in sorted(found):
        diagnostics.repaired("lanes-narrowed", f"way/{parts.at_end(end).attributes.osm_way_id}", text)
    return replace(parts, stretches=tuple(stretches))


def _along_roads(parts: RoadParts, keys: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return which lanes at either end of a road are the same, as indices of keys, and the road, (n,)."""
    end, lane = np.divmod(keys, 2 * _MOST_LANES)
    alike = np.array([len(item) == 1 for item in parts.stretches], bool)
    start = np.flatnonzero((end % 2 == 0) & alike[end // 2])
    beyond = (end[start] + 1) * 2 * _MOST_LANES + lane[start]
    place = np.minimum(np.searchsorted(keys, beyond), len(keys) - 1)
    both = keys[place] == beyond
    return start[both], place[both], end[start[both]] // 2


def _reachable(width: FloatArray, one: IntArray, other: IntArray, most: FloatArray) -> FloatArray:
    """Return the largest widths up to given ones of which no linked two differ by more than they may, m."""
    out = width.copy()
    while True:
        last = out.copy()
        np.minimum.at(out, one, out[other] + most)
        np.minimum.at(out, other, out[one] + most)
        if (out > last - _SAME_WIDTH).all():
            return out
