"""Ways whose direction changes with time, where they meet head-on."""

from __future__ import annotations

import pytest

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.osmParsing.file import RawWay
from osm2xodr.osmParsing.network import with_one_flow


def way(number: int, nodes: str, tags: str = "") -> RawWay:
    """A reversible carriageway of a motorway from node to node, one letter each."""
    pairs = dict(item.split("=") for item in f"highway=motorway oneway=reversible {tags}".split())
    return RawWay(number, [ord(letter) for letter in nodes], pairs)


@pytest.mark.parametrize(
    ("ways", "turned"),
    [
        # They run on.
        ([way(1, "ab"), way(2, "bc")], []),
        # Head-on, and away from each other: the one with more nodes stays.
        ([way(1, "abc"), way(2, "dc")], [2]),
        ([way(1, "ba"), way(2, "bcd")], [1]),
        # Tags of a direction count more than nodes.
        ([way(1, "abcde"), way(2, "ge"), way(3, "hg", "turn:lanes:forward=through|right")], [1]),
        # A chain turns as a whole.
        ([way(1, "ab"), way(2, "bc"), way(3, "fedc")], [3]),
        # Ramps between them say nothing, and nor do ways with a known direction.
        ([way(1, "abc"), way(2, "dc"), way(3, "ce", "highway=motorway_link")], [2]),
        ([way(1, "abc"), way(2, "dc", "oneway=yes")], []),
        # Three of a class are no chain.
        ([way(1, "ab"), way(2, "cb"), way(3, "bd")], []),
    ],
)
def test_a_chain_has_one_direction(ways: list[RawWay], turned: list[int]) -> None:
    diagnostics = Diagnostics()
    found = with_one_flow(ways, diagnostics)
    assert [item.id for item in found if item.tags["oneway"] == "-1"] == turned
    assert [item.osm_id for item in diagnostics if item.kind is Kind.GUESSED] == [f"way/{k}" for k in turned]
