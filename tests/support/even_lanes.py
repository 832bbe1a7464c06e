"""Lanes whose widths depend on the class of the road alone, so that tests of shapes need not follow the tables."""

from __future__ import annotations

from collections.abc import Iterator
from types import MappingProxyType

import pytest
from street_cases import forget_cases

from osm2xodr.conventions import countries

EVEN_LANES = MappingProxyType(
    {
        "motorway": 3.75,
        **dict.fromkeys(("motorway_link", "trunk", "trunk_link", "primary", "primary_link"), 3.5),
        **dict.fromkeys(("secondary", "secondary_link"), 3.25),
        **dict.fromkeys(("tertiary", "tertiary_link"), 3.0),
        **dict.fromkeys(("living_street", "service", "pedestrian"), 2.5),
        "track": 2.0,
    }
)


@pytest.fixture(scope="module", autouse=True)
def even_lanes() -> Iterator[None]:
    """Make lanes as wide alone as beside others, 2.75 m where `EVEN_LANES` has nothing."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(countries, "LANE_WIDTH", EVEN_LANES)
        patch.setattr(countries, "LANE_WIDTH_OTHER", 2.75)
        patch.setattr(countries, "ONE_LANE_WIDTH", {})
        patch.setattr(countries, "LANE_WIDTH_BESIDE_IN_TOWN", 9.0)
        forget_cases()
        yield
    forget_cases()
