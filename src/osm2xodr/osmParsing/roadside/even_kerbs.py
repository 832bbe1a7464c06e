"""Ways of one street whose kerbs hardly differ get the same ones, so that its lanes do not shift at each of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import numpy as np

from osm2xodr.model import FloatArray
from osm2xodr.osmParsing.file import RawWay
from osm2xodr.osmParsing.tags import Kerbs, ends_of_streets, street_of

# Carriageways whose widths, and whose middles, differ by no more than this, m, are one. A choice: kerbs are drawn no
# better than to a quarter of a metre on both sides.
_SAME: Final = 0.5
# Distances and middles have so many digits, m: kerbs are drawn no better, and ways of a street become alike.
_DIGITS: Final = 1


def kerbs_about(width: float, middle: float) -> Kerbs:
    """Return kerbs by their distance and the t of their middle, m, rounded as they are drawn."""
    apart, aside = round(width, _DIGITS), round(middle, _DIGITS)
    return Kerbs(aside + apart / 2.0, aside - apart / 2.0)


def even_out(ways: Sequence[RawWay], kerbs: Mapping[int, Kerbs], lengths: FloatArray) -> dict[int, Kerbs]:
    """Return kerbs along ways, by index, each with the means of those before and behind it that hardly differ.

    `lengths` (ways,) are those of the ways, m.
    """
    out = dict(kerbs)
    for chain in _chains(ways, kerbs):
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
    return max(max(widths) - min(widths), max(middles) - min(middles)) <= _SAME + 1e-9


def _chains(ways: Sequence[RawWay], kerbs: Mapping[int, Kerbs]) -> Iterator[list[tuple[int, bool]]]:
    """Yield ways of one street with both kerbs, one behind the other, each with whether it runs along the chain.

    A street continues at a node where exactly two of its ways end.
    """
    chosen = [index for index in sorted(kerbs) if kerbs[index].apart is not None]
    streets = [street_of(way.tags) for way in ways]
    meeting = ends_of_streets(ways, streets)
    among, done = set(chosen), set[int]()

    def following(way: int, along: bool) -> tuple[int, bool] | None:
        street = streets[way]
        at = meeting.get((ways[way].refs[-1 if along else 0], street), []) if street is not None else []
        others = [other for other in at if other[0] != way]
        return others[0] if len(at) == 2 and len(others) == 1 and others[0][0] in among else None

    for index in chosen:
        if index in done:
            continue
        # To the end of the chain, and from there back.
        start, seen = (index, False), {index}
        while (ahead := following(*start)) is not None and ahead[0] not in seen:
            start = ahead
            seen.add(ahead[0])
        chain = [(start[0], not start[1])]
        done.add(start[0])
        while (ahead := following(*chain[-1])) is not None and ahead[0] not in done:
            chain.append(ahead)
            done.add(ahead[0])
        yield chain
