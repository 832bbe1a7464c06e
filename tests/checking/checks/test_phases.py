"""Which signals one controller may switch: told from the ways through the junction alone."""

from __future__ import annotations

from pathlib import Path

import pytest
from lxml import etree
from t_junction import Tree, one, road, sound_tree

from osm2xodr.checking import CheckOptions, check_file

ONLY = CheckOptions(only=("conflicting-phase",))


def with_lights(governed: dict[int, list[int]]) -> Tree:
    """Return the T junction with one controller and a light on roads that some connecting roads refer to."""
    tree = sound_tree()
    controller = one(tree, "controller")
    for number, (number_of_road, connecting) in enumerate(governed.items(), start=900):
        if number > 900:
            end = "-" if number_of_road == 2 else "+"
            light = f'<signal id="{number}" s="1" t="0" dynamic="yes" orientation="{end}" type="1000001"/>'
            road(tree, number_of_road).append(etree.fromstring(f"<signals>{light}</signals>"))
            controller.append(etree.fromstring(f'<control signalId="{number}"/>'))
        for way in connecting:
            text = f'<signals><signalReference id="{number}" s="0" t="0" orientation="+"/></signals>'
            road(tree, way).append(etree.fromstring(text))
    return tree


def found(tree: Tree, folder: Path) -> list[str]:
    path = folder / "lights.xodr"
    path.write_bytes(etree.tostring(tree))
    return [item.text for item in check_file(path, ONLY).findings]


# Connecting roads: 10 from 1 to 2, 11 back, 12 from 1 to 3, 13 from 3 to 2, 14 from 3 to 1, 15 from 2 to 3.
@pytest.mark.parametrize(
    ("governed", "pairs"),
    [
        # Oncoming traffic on its own side.
        ({1: [10], 2: [11]}, ""),
        # Ways of one approach.
        ({1: [10, 12], 2: [11]}, ""),
        # The street from the south turns left across the road.
        ({1: [10], 3: [14]}, "1 pair, connecting roads 10 and 14 first"),
        # It turns right onto the lane that the others go on.
        ({1: [10], 3: [13]}, "1 pair, connecting roads 10 and 13 first"),
        ({1: [12], 3: [13]}, ""),
        ({1: [10, 12], 2: [11, 15]}, "2 pairs, connecting roads 10 and 15 first"),
        # Without references all ways from the light's road are meant: 10 and 12 with 13 and 14.
        ({1: [], 3: []}, "2 pairs, connecting roads 10 and 13 first"),
        # That one is for traffic which comes to the road's start.
        ({1: [], 2: []}, "2 pairs, connecting roads 10 and 15 first"),
    ],
)
def test_ways_that_meet(governed: dict[int, list[int]], pairs: str, tmp_path: Path) -> None:
    texts = found(with_lights(governed), tmp_path)
    assert texts == ([f"controller 800 of junction 100: {pairs}"] if pairs else [])


def test_ways_above_each_other_do_not_meet(tmp_path: Path) -> None:
    tree = with_lights({1: [10], 3: [14]})
    one(road(tree, 14), "elevationProfile/elevation").set("a", "18")
    assert found(tree, tmp_path) == []


def test_validity_names_the_lanes(tmp_path: Path) -> None:
    tree = with_lights({1: [10], 3: [14]})
    reference = one(road(tree, 14), "signals/signalReference")
    reference.append(etree.fromstring('<validity fromLane="1" toLane="2"/>'))
    assert found(tree, tmp_path) == []


def test_lights_for_other_directions_count_not(tmp_path: Path) -> None:
    tree = with_lights({1: [], 3: []})
    one(road(tree, 3), "signals/signal").set("orientation", "-")
    assert found(tree, tmp_path) == []


def test_controllers_that_the_junction_does_not_name(tmp_path: Path) -> None:
    tree = with_lights({1: [10], 3: [14]})
    junction = one(tree, "junction")
    junction.remove(one(junction, "controller"))
    assert found(tree, tmp_path) == []
