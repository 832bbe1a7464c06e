"""Heights from tags."""

from __future__ import annotations

import numpy as np
import pytest
from elevation_helpers import plan_view, straight

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.geometry.road_heights import _parse_ele, _tagged_heights
from osm2xodr.model import LocalFrame, Rule, Street, StreetNetwork


@pytest.mark.parametrize(
    ("text", "z"),
    [
        ("123", 123.0),
        (" 123.5 m", 123.5),
        ("-12", -12.0),
        ("100ft", 30.48),
        ("1000 feet", 304.8),
        ("123;125", None),
        ("ca. 120", None),
        ("12,5", None),
        ("9999", None),
        ("", None),
    ],
)
def test_values_of_ele(text: str, z: float | None) -> None:
    assert _parse_ele(text) == (None if z is None else pytest.approx(z))


def network(tags: dict[int, dict[str, str]]) -> StreetNetwork:
    street = Street(0, -1, -1, np.array([[0.0, 0.0], [100.0, 0.0], [200.0, 0.0]]), np.array([1, 2, 3], np.int64), ())
    frame = LocalFrame("+proj=tmerc", 0.0, 0.0)
    return StreetNetwork(frame, Rule.RIGHT_HAND, "DE", (street,), (), (), tags, (0.0, 0.0, 1.0, 1.0))


def test_heights_lie_where_their_nodes_are() -> None:
    # The street became two roads with a junction from 140 to 160 between them; the last one is cut at 190.
    curves = plan_view([straight((0.0, 0.0), (140.0, 0.0)), straight((160.0, 0.0), (190.0, 0.0))])
    tags = {3: {"ele": "31"}, 2: {"ele": "20 m"}, 1: {"highway": "stop"}, 77: {"ele": "5"}}
    diagnostics = Diagnostics()
    road, s, z = _tagged_heights(network(tags), curves, np.array([0, 0]), diagnostics)
    assert (road.tolist(), z.tolist()) == ([0, 1], [20.0, 31.0])
    assert s == pytest.approx([100.0, 30.0], abs=1.0)
    assert list(diagnostics) == []


def test_other_values_are_reported() -> None:
    diagnostics = Diagnostics()
    curves = plan_view([straight((0.0, 0.0), (200.0, 0.0))])
    road, s, z = _tagged_heights(network({2: {"ele": "high"}}), curves, np.array([0]), diagnostics)
    assert (len(road), len(s), len(z)) == (0, 0, 0)
    assert [(item.kind, item.code, item.osm_id) for item in diagnostics] == [(Kind.DROPPED, "ele", "node/2")]
