"""What tags of nodes say about room to turn round."""

from __future__ import annotations

import pytest

from osm2xodr.model import TurningPlace
from osm2xodr.osmParsing.tags.turning_circles import turning_places


@pytest.mark.parametrize("value", ["turning_circle", "turning_loop", "mini_roundabout"])
def test_these_nodes_are_circles(value: str) -> None:
    assert turning_places({7: {"highway": value}}) == {7: TurningPlace(True, None)}


@pytest.mark.parametrize(
    ("text", "diameter"),
    [("18", 18.0), (" 18.5 m ", 18.5), ("60 ft", 18.288), ("60'", 18.288), ("wide", None), ("-3", None), ("", None)],
)
def test_diameters_are_metres_or_feet(text: str, diameter: float | None) -> None:
    (place,) = turning_places({7: {"highway": "turning_circle", "diameter": text}}).values()
    assert place.diameter == pytest.approx(diameter)


def test_other_nodes_say_nothing_or_only_a_diameter() -> None:
    found = turning_places({1: {"highway": "stop"}, 2: {"highway": "crossing", "diameter": "9"}, 3: {}})
    assert found == {2: TurningPlace(False, 9.0)}
