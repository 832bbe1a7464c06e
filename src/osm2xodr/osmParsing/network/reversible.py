"""Ways whose one direction changes with time: which way their traffic runs where they meet head-on."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.osmParsing.file import RawWay
from osm2xodr.osmParsing.tags import changes_direction, oneway

# Tags of the direction along the nodes: the mapper had that one in mind.
_ALONG: Final = ":forward"


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
