"""Ways of one street whose kerbs hardly differ get the same ones, so that its lanes do not shift at each of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from osm2xodr.model import FloatArray
from osm2xodr.osmParsing.file import RawWay
from osm2xodr.osmParsing.roadside.street_chains import street_chains
from osm2xodr.osmParsing.tags import Kerbs, street_of

# Carriageways whose widths, and whose middles, differ by no more than this, m, are one. A choice: kerbs are drawn no
# better than to a quarter of a metre on both sides.
SAME_CARRIAGEWAY: Final = 0.5
# Distances and middles have so many digits, m: kerbs are drawn no better, and ways of a street become alike.
_DIGITS: Final = 1


def kerbs_about(width: float, middle: float) -> Kerbs:
    """Return kerbs by their distance and the t of their middle, m, rounded as they are drawn."""
    apart, lateral = round(width, _DIGITS), round(middle, _DIGITS)
    return Kerbs(lateral + apart / 2.0, lateral - apart / 2.0)


def even_out(ways: Sequence[RawWay], kerbs: Mapping[int, Kerbs], lengths: FloatArray) -> dict[int, Kerbs]:
    """Return kerbs along ways, by index, each with the means of those before and behind it that hardly differ.

    `lengths` (ways,) are those of the ways, m.
    """
    out = dict(kerbs)
    chosen = [way for way, item in kerbs.items() if item.apart is not None]
    for chain in street_chains(ways, [street_of(way.tags) for way in ways], chosen):
        first = 0
        for last in range(1, len(chain) + 1):
            if last < len(chain) and _alike([_seen(kerbs[way], along) for way, along in chain[first : last + 1]]):
                continue
            run = chain[first:last]
            first = last
            if len(run) > 1:
                seen = [_seen(kerbs[way], along) for way, along in run]
                left, right = np.average(seen, axis=0, weights=[lengths[way] for way, _ in run]).tolist()
                for way, along in run:
                    out[way] = kerbs_about(left - right, (left + right) / 2.0 if along else -(left + right) / 2.0)
    return out


def _seen(kerbs: Kerbs, along: bool) -> tuple[float, float]:
    """Return t of both kerbs as seen along or against the way, m."""
    assert kerbs.left is not None
    assert kerbs.right is not None
    return (kerbs.left, kerbs.right) if along else (-kerbs.right, -kerbs.left)


def _alike(edges: Sequence[tuple[float, float]]) -> bool:
    widths = [left - right for left, right in edges]
    middles = [(left + right) / 2.0 for left, right in edges]
    return max(max(widths) - min(widths), max(middles) - min(middles)) <= SAME_CARRIAGEWAY + 1e-9
