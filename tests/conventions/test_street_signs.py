"""Ranks of roads at a junction."""

from __future__ import annotations

import pytest

from osm2xodr.conventions import ranks_at_junction


@pytest.mark.parametrize(
    ("highways", "expected"),
    [
        (["trunk_link", "trunk_link", "residential"], [5, 5, 4]),
        # A street that crosses ramps, and a ramp that ends.
        (["trunk_link", "trunk_link", "residential", "unclassified"], [3, 3, 4, 4]),
        (["trunk_link", "residential", "residential"], [3, 4, 4]),
        (["motorway_link", "motorway_link", "motorway"], [5, 5, 10]),
        (["primary_link", "primary", "primary", "residential"], [5, 8, 8, 4]),
        (["tertiary", "residential", "service"], [6, 4, 1]),
    ],
)
def test_ramps_rank_above_streets_that_end(highways: list[str], expected: list[int]) -> None:
    assert ranks_at_junction(highways) == expected
