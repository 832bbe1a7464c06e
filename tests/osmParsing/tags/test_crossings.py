"""What tags say about crossings."""

from __future__ import annotations

import math

import numpy as np
import pytest

from osm2xodr.model import Footway, MappedCrossing
from osm2xodr.osmParsing.tags.node_facts import is_crossing, read_crossings


def read(tags: dict[str, str]) -> MappedCrossing:
    (found,) = read_crossings({1: {"highway": "crossing", **tags}}, ())
    return found


@pytest.mark.parametrize(
    ("tags", "crosses"),
    [
        ("highway=crossing", True),
        ("highway=crossing crossing=unmarked", True),
        ("highway=crossing crossing=no", False),
        ("highway=traffic_signals crossing=traffic_signals", True),
        ("railway=level_crossing crossing=uncontrolled", False),
        ("highway=traffic_signals", False),
    ],
)
def test_which_nodes_are_crossings(tags: str, crosses: bool) -> None:
    found = dict(pair.split("=") for pair in tags.split())
    assert is_crossing(found) is crosses
    assert len(read_crossings({1: found}, ())) == crosses


@pytest.mark.parametrize(
    ("tags", "lights", "marking", "width"),
    [
        ({"crossing": "traffic_signals"}, True, "yes", None),
        ({"crossing": "traffic_signals", "crossing:signals": "no"}, False, "yes", None),
        ({"crossing": "uncontrolled", "crossing_ref": "zebra"}, False, "zebra", None),
        ({"crossing": "marked", "crossing:markings": "zebra:paired"}, False, "zebra:paired", None),
        ({"crossing": "zebra", "crossing:markings": "yes", "crossing:width": "2.5 m"}, False, "zebra", 2.5),
        ({"crossing_ref": "pelican", "crossing:markings": "no"}, True, "unmarked", None),
        ({"width": "0.5"}, False, "unmarked", 0.5),
        ({"width": "wide"}, False, "unmarked", None),
        ({"crossing:width": "30", "width": "3"}, False, "unmarked", 3.0),
    ],
)
def test_lights_marks_and_widths(tags: dict[str, str], lights: bool, marking: str, width: float | None) -> None:
    found = read(tags)
    assert (found.lights, found.marking, found.width) == (lights, marking, width)
    assert found.width_tagged is any("width" in key for key in tags)


@pytest.mark.parametrize(
    ("tags", "island"),
    [
        ({"crossing:island": "yes"}, True),
        ({"crossing": "island"}, True),
        ({"traffic_calming": "island", "crossing": "marked"}, True),
        ({"crossing": "marked", "crossing:island": "no"}, False),
        ({"crossing": "marked"}, False),
    ],
)
def test_islands(tags: dict[str, str], island: bool) -> None:
    assert read(tags).island is island


def test_a_way_that_crosses_makes_crossings_of_its_nodes() -> None:
    points = np.array([[0.0, -5.0], [0.0, 0.0], [0.0, 5.0]])
    tags = {"highway": "footway", "crossing": "marked", "width": "5"}
    way = Footway(9, True, points, np.array([7, 2, 1], np.int64), tags)
    nodes = {1: {"crossing": "no"}, 2: {"crossing": "traffic_signals"}, 3: {"crossing": "marked"}}
    found = read_crossings(nodes, (way,))
    assert [item.node for item in found] == [2, 3, 7]
    on_way, alone, end = found
    assert (on_way.heading, end.heading) == pytest.approx((math.pi / 2, math.pi / 2))
    assert (on_way.lights, on_way.width) == (True, 5.0)
    assert (alone.heading, alone.width_tagged) == (None, False)
    assert (end.lights, end.marking) == (False, "yes")
